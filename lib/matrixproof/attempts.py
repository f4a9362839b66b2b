"""The search for one model: an order of the symbols, solving and drawing."""

from fractions import Fraction
from math import comb
from random import Random

import sympy as sp

from .exact import (
    World,
    as_matrix,
    as_table,
    constant,
    minus,
    multiplied,
    rational,
    transposed,
)
from .settings import FIRST
from .systems import System, Unsolvable, search
from .words import denied

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

        return sorted(self.setting.unknowns, key=key)

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
            if s in self.setting.symmetric:
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
