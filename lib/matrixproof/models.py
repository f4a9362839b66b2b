"""Explicit rational matrices that satisfy relations, and claims refuted by them.

A set of relations that no matrices satisfy proves anything, so every set in use is
given a model.  A claim that is false has a model of the relations in which its sides
differ, and such a model says more than a residual does.

The search takes sizes from 1 to 3 and one symbol after the other.  Every relation is
solved, exactly, as soon as it is linear in what is left; what remains free is drawn
at random, always in the same way.  A relation that is never linear is searched.

Source: our own.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache, lru_cache
from itertools import islice, product
from math import comb
from random import Random
from typing import Any

import sympy as sp

from .contents import KEPT, monomials, parts, unknowns
from .dependence import declared
from .exact import (
    System,
    Unsolvable,
    World,
    as_matrix,
    as_table,
    constant,
    minus,
    multiplied,
    rational,
    search,
    transposed,
)
from .families import alike
from .relations import Given, named
from .symbols import Over
from .words import Formula, Symbols, Values, denied, plain

LARGEST = 3  # of the sizes that are tried, unless a power asks for more
MOST = 3**8  # combinations of sizes that are looked at
FIRST = 8  # sizes tried in order of preference; the others follow in mixed order


class Setting:
    """Relations, and perhaps other expressions, with everything that needs a value.

    `equations` are the relations, and X Y = I, Y X = I for every inverse Y of an X;
    `supports` has for each the products of unknowns in it, and `masks` the same as
    bits.  `partial` are the expressions in which a scalar is inverted or has a root.
    `values` is what is known before the search.  Where `definite` is true, symmetric
    letters are positive definite if nothing else is asked.
    """

    def __init__(self, relations, symmetric, also=(), values=None, definite=True):
        self.relations, self.definite = relations, definite
        self.symmetric = set(declared(symmetric, (*relations, *also)))
        self.values = values or {}
        self.equations = [(alike(r.left), alike(r.right)) for r in relations]
        also = [alike(side) for side in also]
        self.partial = [side for side in also if parts(side).partial]
        sides = [s for pair in self.equations for s in pair] + also
        found = [parts(side) for side in sides]
        self._list_sizes(found)
        inverted = dict.fromkeys(X for p in found for X in p.inverted)
        for X in inverted:
            Y, one = sp.Inverse(X), sp.Identity(X.shape[0])
            for factors in ((X, Y), (Y, X)):
                self.equations.append((sp.MatMul(*factors, evaluate=False), one))
        self.symmetric |= {("inverse", X) for X in inverted if X in self.symmetric}
        sizes = frozenset(self.sizes)
        self.supports = [support(a, b, sizes) for a, b in self.equations]
        self._list_unknowns(set().union(*map(unknowns, sides)))
        self.bits = {s: 1 << k for k, s in enumerate(self.unknowns)}
        self.masks = [masks(products, self.bits) for products in self.supports]
        self._list_degrees()
        self.stated_zeros = sum(
            isinstance(a, sp.MatrixSymbol) and getattr(b, "is_ZeroMatrix", False)
            for a, b in self.equations
        )

    def _list_sizes(self, found):
        self.dimensions = frozenset().union(*(p.dimensions for p in found))
        self.full = 0 not in self.dimensions
        symbols = set().union(*(d.free_symbols for d in self.dimensions))
        self.sizes = sorted(symbols, key=str)
        self.caps = dict.fromkeys(self.sizes, LARGEST)
        for size, power in {pair for p in found for pair in p.powers}:
            for symbol in size.free_symbols:
                self.caps[symbol] = max(self.caps[symbol], power + 1)

    def _list_unknowns(self, found):
        self.unknowns = {}
        for s in sorted(found - set(self.sizes), key=spelled):
            inside = s[1] if isinstance(s, tuple) else s
            self.unknowns[s] = getattr(inside, "shape", None)

    def _list_degrees(self):
        self.degree, self.defined = Counter(), set()
        for (left, _), products in zip(self.equations, self.supports):
            self.defined |= {left} if isinstance(left, sp.MatrixSymbol) else set()
            for m in products:
                for s, d in Counter(m).items():
                    self.degree[s] = max(self.degree[s], d)

    # -- sizes ----------------------------------------------------------------------

    def generic_sizes(self):
        """Sizes that differ from each other first, so that no accident helps."""
        return self._in_turn(_alike)

    def small_sizes(self):
        """The smallest first: a counterexample should be short."""
        return self._in_turn(sum)

    def _in_turn(self, key):
        """Sizes in the order that `key` makes, at which what is known has its shape."""
        shapes = [
            (sp.sympify(d), k)
            for s, value in self.values.items()
            for d, k in zip(getattr(s, "shape", ()), getattr(value, "shape", ()))
        ]
        fixed = dict(shapes)
        ranges = {s: (fixed.get(s, 1), fixed.get(s, k)) for s, k in self.caps.items()}
        sizes = _in_turn(self.dimensions, tuple(ranges.items()), key)
        fits = lambda size: all(d.xreplace(size) == k for d, k in shapes)  # noqa: E731
        return [size for size in sizes if fits(size)] if shapes else sizes


spelled = lru_cache(KEPT)(str)


@lru_cache(KEPT)
def support(left, right, sizes):
    """The products of unknowns in an equation, other than `sizes`."""
    found = monomials(left) | monomials(right)
    return {tuple(s for s in m if s not in sizes) for m in found}


def masks(products, bits):
    """All unknowns of an equation, and (all, repeated) of each product, as bits."""
    found, whole = set(), 0
    for product_ in products:
        once = twice = 0
        for s in product_:
            twice |= once & bits[s]
            once |= bits[s]
        found.add((once, twice))
        whole |= once
    return whole, sorted(found)


def _alike(dimensions):
    """How much dimensions are like each other and like 1, and how large they are."""
    counts = Counter(dimensions)
    return sum(k * k for k in counts.values()) + counts[1], sum(dimensions)


@cache
def _in_turn(dimensions, ends, key):
    """Sizes between ends that leave no matrix empty, by what `key` makes of them."""
    dimensions = sorted((d for d in dimensions if d.free_symbols), key=str)
    names = [symbol for symbol, _ in ends]
    at = sp.lambdify(names, dimensions, "math", dummify=True)
    ranges = [range(low, high + 1) for _, (low, high) in ends]
    found = [(at(*values), values) for values in islice(product(*ranges), MOST)]
    found = [pair for pair in found if all(d >= 1 for d in pair[0])]
    found.sort(key=lambda pair: key(pair[0]))
    sizes = [dict(zip(names, values)) for _, values in found]
    late = sizes[FIRST:]
    Random(1).shuffle(late)
    return sizes[:FIRST] + late


LONGEST = 250  # terms of a polynomial
POSITIVE = (1, 4, 2, 3, Fraction(1, 4))  # two have roots, one is small


def models(setting, sizes, attempts):
    """Every model found in so many attempts, or in some, the sizes taken in turn."""
    turns = [s for s in sizes[:FIRST] for _ in range(3)] + sizes[FIRST:]
    attempts = range(attempts) if isinstance(attempts, int) else attempts
    for k in attempts if turns else ():
        try:
            yield Attempt(setting, turns[k % len(turns)], Random(k)).solve()
        except (Unsolvable, ArithmeticError):
            continue


class Attempt:
    """One search: sizes are given, symbols get their values one after the other."""

    def __init__(self, setting, sizes, random):
        self.setting, self.random, self.system = setting, random, System()
        self.sparse, self.thin = random.random() < 0.3, random.random() < 0.25
        self.world = World(sizes, {}, full=setting.full)
        for k, (s, shape) in enumerate(setting.unknowns.items()):
            self.world.of[s] = self._unknowns_of(k, s, shape)
        self.entries = {s: self._entries(s) for s in setting.unknowns}

    def _unknowns_of(self, k, s, shape):
        """A table of unknown entries; a scalar is one unknown."""
        if s in self.setting.values:
            known = self.setting.values[s]
            return constant(rational(known)) if shape is None else as_table(known)
        if isinstance(s, Over):  # mostly one member, so that little is to be solved
            aside = Random()
            aside.setstate(self.random.getstate())
            return constant(aside.choice((1, 1, 1, 2, 0)))
        if shape is None:
            return {((k, 0, 0),): 1}
        rows, cols = (self.world.size(d) for d in shape)
        even = s in self.setting.symmetric
        entry = lambda i, j: (k, *sorted((i, j))) if even else (k, i, j)  # noqa: E731
        return [[{(entry(i, j),): 1} for j in range(cols)] for i in range(rows)]

    def solve(self):
        """The model.

        Raises
        ------
        Unsolvable
            Not with these sizes, this order and these draws.
        """
        waiting = range(len(self.setting.equations))
        order = self._order()
        while True:
            waiting, order = self._solve_linear(waiting, order)
            if not order:
                return Model(self.setting, self.world)
            s = order.pop(0)
            free, within = self._bits(order), self.setting.masks
            alone = [k for k in waiting if not within[k][0] & free]
            waiting = [k for k in waiting if within[k][0] & free]
            self._refuse_long(s, alone)
            entries = [p for k in alone for p in self._difference(k)]
            self.system = search(self.system, entries, self.random)
            self._draw(s)

    def _refuse_long(self, s, equations):
        """Polynomials of high degree in many unknowns are not worth multiplying out."""
        products = [m for k in equations for m in self.setting.supports[k]]
        degree = max((m.count(s) for m in products), default=0)
        if comb(len(self.entries[s]) + degree, degree) > LONGEST:
            raise Unsolvable

    def _order(self):
        """Symbols in which relations are not linear first, those they define last."""
        degree, defined = self.setting.degree, self.setting.defined
        mixed = self.random.random
        inverses_first, by_degree = mixed() < 0.5, mixed() < 0.8
        early = self.setting.symmetric if mixed() < 0.5 else ()

        def key(s):
            late = isinstance(s, tuple) != inverses_first
            first = -degree[s] * by_degree, s in defined, s not in early
            return *first, late, mixed()

        drawn = (s for s in self.setting.unknowns if not isinstance(s, Over))
        return sorted(drawn, key=key)

    def _solve_linear(self, waiting, order):
        """Solve what is linear; a symbol that this determines leaves the order."""
        while True:
            free, later = self._bits(order), []
            for k in waiting:
                if is_linear(self.setting.masks[k][1], free):
                    for p in self._difference(k):
                        self.system.require(p)
                else:
                    later.append(k)
            known = [s for s in order if self._is_determined(s)]
            for s in known:
                self._draw(s)
            waiting, order = later, [s for s in order if s not in set(known)]
            if not known:
                return waiting, order

    def _bits(self, symbols):
        return sum(self.setting.bits[s] for s in symbols)

    def _is_determined(self, s):
        solved = self.system.solved
        return all(x in solved and solved[x].keys() <= {()} for x in self.entries[s])

    def _entries(self, s):
        """The unknowns that a symbol consists of."""
        table = self.world.of[s]
        rows = [[table]] if isinstance(table, dict) else table
        return {x for row in rows for p in row for m in p for x in m}

    def _difference(self, k):
        left, right = self.setting.equations[k]
        return [
            self.system.reduced(minus(x, y))
            for x, y in paired(self.world.value(left), self.world.value(right))
        ]

    def _draw(self, s):
        """Give a symbol its value: random where the equations leave it free."""
        table = self.world.of[s]
        scalar = isinstance(table, dict)
        positive = scalar and s.is_positive
        rows = [[table]] if scalar else table
        entries = self.entries[s]
        if entries and not entries & set(self.system.solved):
            if s in self.setting.symmetric and self.setting.definite:
                self._draw_definite(rows)
            elif self.thin and self.random.random() < 0.7:
                self._draw_thin(rows)
        for x in sorted(entries):
            for m in self.system.reduced({(x,): 1}):
                for y in m:
                    if y not in self.system.solved:
                        self.system.fix(y, self._number(positive))
        rows = [[self.system.reduced(p) for p in row] for row in rows]
        self.world.of[s] = rows[0][0] if scalar else rows

    def _draw_definite(self, rows):
        n = len(rows)
        G = [[constant(self._number()) for _ in range(n)] for _ in range(n)]
        square = multiplied(G, transposed(G))
        for i in range(n):
            for j in range(i, n):
                value = square[i][j].get((), 0) + (i == j)
                ((x,),) = rows[i][j]
                self.system.fix(x, value)

    def _draw_thin(self, rows):
        """A product of a column and a row, singular unless there is one of each."""
        column = [self._number() for _ in rows]
        for x in range(len(rows[0])):
            scale = self._number()
            for row, number in zip(rows, column):
                ((entry,),) = row[x]
                self.system.fix(entry, number * scale)

    def _number(self, positive=False):
        choices = (0, 0, 1, -1) if self.sparse else (-2, -1, 1, 2, 3)
        return self.random.choice(POSITIVE if positive else choices)


def rational_of(polynomial):
    return sp.Rational(polynomial.get((), 0))


def is_linear(products, free):
    """Whether no product has two of the free unknowns, or one of them twice."""
    for once, twice in products:
        inside = once & free
        if twice & free or inside & (inside - 1):
            return False
    return True


def paired(a, b):
    """The entries of two values side by side; the number 0 fits a table."""
    if isinstance(a, dict):
        return [(a, b)]
    flat = [x for row in a for x in row]
    other = [b] * len(flat) if b == {} else [y for row in b for y in row]
    return zip(flat, other, strict=True)


class Model:
    """Explicit values that satisfy the relations of a problem."""

    def __init__(self, setting, world):
        self.setting, self.world = setting, world
        for s in setting.unknowns:
            if isinstance(s, sp.Symbol) and denied(s, rational_of(world.of[s])):
                raise Unsolvable
        for left, right in setting.equations:
            if not self.agree(left, right):
                raise Unsolvable
        for side in setting.partial:
            world.value(side)  # or there is none, where one divides by zero

    def agree(self, left, right):
        """Whether two expressions have one value here."""
        both = paired(self.world.value(left), self.world.value(right))
        return all(x == y for x, y in both)

    @property
    def zeros(self):
        """How many matrix symbols are zero."""
        tables = [v for v in self.world.of.values() if isinstance(v, list)]
        return sum(any(t) and not any(map(any, t)) for t in tables)

    def matrices(self):
        return {
            s: rational_of(v)
            if isinstance(v, dict)
            else as_matrix(v, self.world.shape(s))
            for s, v in self.world.of.items()
            if not isinstance(s, tuple)
        }


PATIENT, QUICK = 150, 90  # attempts to find a model, and to refute


class NoModel(ValueError):
    """No matrices were found that satisfy the relations, so nothing can be tried."""


def model(
    relations: Given, symmetric: Symbols = (), also: Iterable[Formula] = ()
) -> Values | None:
    """Explicit rational matrices that satisfy relations exactly, or None.

    Parameters
    ----------
    relations : iterable of Relation or (left, right)
        Between matrix expressions, or between scalars.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose; positive definite where nothing else is asked.
    also : iterable of expression
        Their symbols get a value, too, and what they invert is invertible.

    Notes
    -----
    None says that none was found with sizes from 1 to 3, or to k + 1 where a k-th power
    occurs: the relations may contradict each other, and then they prove anything.  Of
    several models the one with the fewest symbols that are zero is taken, and it is the
    same at each run.

    Examples
    --------
    >>> from matrixproof import Identity, letters
    >>> A, B, T = letters("A:p*n B:n*p T:n*n")
    >>> found = model([(A * B, Identity(A.rows))])
    >>> found[A] * found[B] == Identity(found[A].rows).as_explicit()
    True
    >>> model([(T * T, T), (T * T, 2 * T), (T, Identity(T.rows))]) is None
    True
    """
    found = instance(relations, symmetric, also)
    return None if found is None else found.matrices()


def instance(relations, symmetric=(), also=()):
    """The same as a `Model`, which knows its sizes as well."""
    setting = Setting(named(relations), symmetric, also)
    best = None
    for found in models(setting, setting.generic_sizes(), PATIENT):
        if best is None or found.zeros < best.zeros:
            best = found
        if best.zeros <= setting.stated_zeros:
            break
    return best


def possible(relations, symmetric=(), sides=()):
    """Whether matrices were found that satisfy the relations, with every inverse."""
    relations = named(relations)
    sides = [plain(side) for side in sides]
    if not relations and not any(parts(s).inverted or parts(s).partial for s in sides):
        return True
    setting = Setting(relations, symmetric, sides)
    plainest = any(of_ones(setting, sizes) for sizes in setting.small_sizes()[:FIRST])
    return plainest or instance(relations, symmetric, sides) is not None


def of_ones(setting, sizes):
    """Whether identities, ones and their like satisfy everything."""
    world = World(sizes, {}, full=setting.full)
    for s, shape in setting.unknowns.items():
        if shape is None:
            world.of[s] = constant(1)
        elif not isinstance(s, tuple):
            rows, cols = map(world.size, shape)
            world.of[s] = [
                [constant(int(i == j)) for j in range(cols)] for i in range(rows)
            ]
    try:
        Model(setting, world)
    except (Unsolvable, ArithmeticError):
        return False
    return True


def refute(
    left: Formula, right: Formula, given: Given = (), symmetric: Symbols = ()
) -> Values | None:
    """Matrices of small sizes that satisfy what is given, but not `left = right`.

    Parameters
    ----------
    left, right : expression
        Both sides; a right side of 0 fits every left side.
    given : iterable of Relation or (left, right)
    symmetric : iterable of MatrixSymbol

    Returns
    -------
    dict of symbol to ImmutableMatrix, or None
        None if the sides agree on every model that was tried, which is no proof.

    Raises
    ------
    NoModel
        No model of the relations was found: they may contradict each other.

    Examples
    --------
    A right inverse is not a left inverse, unless the matrices are square.

    >>> from matrixproof import Identity, letters
    >>> A, B = letters("A:p*n B:n*p")
    >>> found = refute(B * A, Identity(B.rows), given=[(A * B, Identity(A.rows))])
    >>> found[B] * found[A] == Identity(found[A].cols).as_explicit()
    False
    """
    found = denial(left, right, given, symmetric)
    return None if found is None else found.matrices()


def denial(left, right, given, symmetric=()):
    """The same as a `Model`."""
    setting = Setting(named(given), symmetric, (left, right))
    tried = False
    for found in models(setting, setting.small_sizes(), QUICK):
        tried = True
        if not found.agree(left, right):
            return found
    if not tried:
        raise NoModel(
            "no small rational matrices were found that satisfy the relations "
            f"{', '.join(r.name for r in setting.relations) or '(none)'}: they may "
            "contradict each other, or what is inverted may be singular"
        )
    return None


def evaluate(expr: Formula, values: Mapping[Any, Any]) -> Any:
    """The exact value of an expression at explicit matrices; sizes follow from these.

    Raises
    ------
    ZeroDivisionError
        Something that is inverted is singular.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from matrixproof import Identity, letters
    >>> (A,) = letters("A:n*n")
    >>> evaluate((A + Identity(A.rows)).I, {A: Matrix([[1, 1], [0, 1]])})
    Matrix([
    [1/2, -1/4],
    [  0,  1/2]])
    """
    world = world_of(values)
    value = world.value(expr)
    if isinstance(value, dict):
        logs = {x: sp.log(x[1]) for m in value for x in m}
        return sum(
            (sp.Rational(c) * sp.Mul(*map(logs.get, m)) for m, c in value.items()),
            sp.S.Zero,
        )
    return as_matrix(value, world.shape(expr))


def differ(left, right, values):
    """Whether two expressions differ in value; a right side of 0 fits any left."""
    world = world_of(values)
    return any(x != y for x, y in paired(world.value(left), world.value(right)))


def world_of(values):
    """Explicit matrices as a `World`; the sizes are solved from their shapes."""
    values = {
        s: x if isinstance(s, sp.Symbol) else sp.ImmutableMatrix(x)
        for s, x in values.items()
    }
    of = {
        s: constant(rational(x)) if isinstance(s, sp.Symbol) else as_table(x)
        for s, x in values.items()
    }
    return World(sizes_of(values)[0], of)


def sizes_of(values):
    """The sizes that the shapes of values give, and those that they leave open.

    What is left open is small.

    >>> n, m = sp.symbols("n m", integer=True, positive=True)
    >>> sizes_of({sp.MatrixSymbol("A", n - m, 1): sp.ones(2, 1)})
    ({m: 1, n: 3}, [m, n])
    """
    system, names = System(), set()
    try:
        for symbol in filter(lambda s: hasattr(s, "shape"), values):
            for size, number in zip(symbol.shape, values[symbol].shape):
                if (gap := sp.sympify(size - number)) != 0:
                    system.require(linear(gap))
                    names |= gap.free_symbols
        return fitting(system, sorted(names, key=str))
    except Unsolvable as e:
        why = str(e) or "the shapes of these matrices do not fit"
        raise ValueError(why) from None


def fitting(system, names):
    """{size: its value} of positive sizes that solve a system, and the open ones."""
    free = [s for s in names if s not in system.solved]
    for value in range(1, 10):
        tried = system.copy()
        for s in free:
            tried.fix(s, value)
        sizes = {s: tried.solved[s].get((), 0) for s in names}
        if all(size >= (1 if free else 0) for size in sizes.values()):
            if part := [s for s, size in sizes.items() if size != int(size)]:
                raise Unsolvable(f"{part[0]} = {sizes[part[0]]} is no size")
            return sizes, [s for s in names if set(system.reduced({(s,): 1})) - {()}]
    raise Unsolvable


def linear(expr):
    """A SymPy expression, linear in its symbols, as a polynomial of `systems`."""
    found = sp.expand(expr).as_coefficients_dict()
    return {
        () if symbol == 1 else (symbol,): rational(c) for symbol, c in found.items()
    }
