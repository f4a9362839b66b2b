"""Matrix expressions evaluated at explicit rational matrices, without SymPy's rules.

The value of an expression is a table of polynomials in unknown entries; where every
symbol has numbers for entries, the polynomials are constant.  Nothing is simplified
on the way, so a value is a second opinion on what the algebra proves.

Equations between such polynomials are solved, exactly and for good, where they are
linear.  What is left is searched: an equation in one unknown gives its rational roots,
and where no equation decides, a few small numbers are tried.

Source: our own.
"""

from fractions import Fraction
from functools import cache
from math import isqrt

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .families import alike
from .words import exact

# -- polynomials: {monomial: coefficient}, a monomial a sorted tuple of unknowns ----


def constant(value):
    """The polynomial without unknowns; integers stay integers, for speed."""
    value = value.numerator if value.denominator == 1 else value
    return {(): value} if value else {}


def poly_plus(p, q):
    return increased(dict(p), q)


def increased(total, q):
    """`total`, to which q has been added."""
    for m, c in q.items():
        c += total.get(m, 0)
        if c:
            total[m] = c
        else:
            total.pop(m, None)
    return total


def minus(p, q):
    return poly_plus(p, {m: -c for m, c in q.items()})


def poly_times(p, q):
    for one, other in ((p, q), (q, p)):  # most are numbers
        if len(one) == 1 and () in one:
            return {m: one[()] * c for m, c in other.items()}
    total = {}
    for m, c in p.items():
        for k, d in q.items():
            mk = tuple(sorted(m + k)) if m and k else m or k
            total[mk] = total.get(mk, 0) + c * d
    return {m: c for m, c in total.items() if c}


def rational(number):
    """A SymPy number as an integer or a fraction."""
    number = sp.Rational(number if isinstance(number, int) else exact(number))
    return number.p if number.q == 1 else Fraction(number.p, number.q)


# -- tables -------------------------------------------------------------------------


def added(a, b):
    return [[poly_plus(x, y) for x, y in zip(r, s)] for r, s in zip(a, b)]


def multiplied(a, b):
    columns = list(zip(*b))
    return [[dot(row, column) for column in columns] for row in a]


def dot(row, column):
    total = {}
    for x, y in zip(row, column):
        if x and y:
            increased(total, poly_times(x, y))
    return total


def scaled(c, a):
    return [[poly_times(c, x) for x in row] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def zeros(rows, cols):
    return [[{}] * cols for _ in range(rows)]


def diagonal(n, value=1):
    return [[constant(value) if i == j else {} for j in range(n)] for i in range(n)]


def trace(a):
    total = {}
    for i, row in enumerate(a):
        total = poly_plus(total, row[i])
    return total


def as_matrix(table, shape):
    """A table of constants as a SymPy matrix."""
    return sp.ImmutableMatrix(
        *shape, [sp.Rational(x.get((), 0)) for row in table for x in row]
    )


def as_table(matrix):
    """An explicit SymPy matrix of rational numbers as a table."""
    return [[constant(rational(x)) for x in row] for row in matrix.tolist()]


# -- expressions ------------------------------------------------------------------


def base_of_inverse(node):
    """What a node is an inverse of, transposes put aside; None for other nodes."""
    if not (isinstance(node, sp.MatPow) and node.exp.is_negative):
        return None
    return node.base.arg if isinstance(node.base, sp.Transpose) else node.base


class World:
    """What every symbol stands for: `sizes`, and `of`, its table or its polynomial.

    The inverse of an expression X is listed under ("inverse", X).  `full` says that no
    matrix is empty.
    """

    def __init__(self, sizes, of, full=False):
        self.sizes, self.of, self.full = sizes, of, full
        self._known, self._shapes = {}, {}

    def size(self, expr):
        if expr not in self._known:
            names, at = size_function(expr)
            known = all(s in self.sizes for s in names)
            value = at(*(self.sizes[s] for s in names)) if known else None
            if not known or value != int(value):
                raise ValueError(f"no shape of these matrices says what {expr} is")
            self._known[expr] = int(value)
        return self._known[expr]

    def shape(self, expr):
        if isinstance(expr, sp.MatrixBase):
            return expr.shape
        if expr not in self._shapes:
            self._shapes[expr] = tuple(self.size(s) for s in expr.shape)
        return self._shapes[expr]

    def value(self, expr):
        """The table of a matrix expression, the polynomial of a scalar one."""
        expr = alike(expr)
        if isinstance(expr, (MatrixExpr, sp.MatrixBase)):
            return self._table(expr)
        return self._scalar(expr)

    def _table(self, expr):
        if not self.full and 0 in self.shape(expr):
            return [[]] * self.size(expr.shape[0])
        if isinstance(expr, sp.MatrixSymbol):
            return self.of[expr]
        if isinstance(expr, sp.MatAdd):
            return fold(added, [self._table(a) for a in expr.args])
        if isinstance(expr, sp.MatMul):
            return self._product(expr.args)
        if isinstance(expr, sp.Transpose):
            return transposed(self._table(expr.arg))
        if isinstance(expr, sp.MatPow):
            return self._power(expr)
        if isinstance(expr, sp.Identity):
            return diagonal(self.size(expr.shape[0]))
        if isinstance(expr, sp.ZeroMatrix):
            return zeros(*self.shape(expr))
        if isinstance(expr, sp.BlockMatrix):
            return self._blocks(expr.blocks)
        if isinstance(expr, sp.MatrixBase):
            return [[self._scalar(x) for x in row] for row in expr.tolist()]
        raise TypeError(f"no value for {type(expr).__name__}: {expr}")

    def _product(self, args):
        factors = [a for a in args if isinstance(a, (MatrixExpr, sp.MatrixBase))]
        scale = [a for a in args if not isinstance(a, (MatrixExpr, sp.MatrixBase))]
        if not self.full and any(0 in self.shape(a) for a in factors):
            ends = factors[0].shape[0], factors[-1].shape[1]
            return zeros(*map(self.size, ends))
        total = fold(multiplied, [self._table(a) for a in factors])
        return scaled(self._scalar(sp.Mul(*scale)), total) if scale else total

    def _power(self, expr):
        if not expr.exp.is_Integer:
            raise TypeError(f"no value for the power {expr.exp} of a matrix: {expr}")
        inner = base_of_inverse(expr)
        if inner is None:
            factor = self._table(expr.base)
        else:
            factor = self._inverse(inner)
            if isinstance(expr.base, sp.Transpose):
                factor = transposed(factor)
        return fold(multiplied, [factor] * abs(int(expr.exp)), len(factor))

    def _inverse(self, inner):
        if ("inverse", inner) in self.of:
            return self.of["inverse", inner]
        matrix = as_matrix(self._table(inner), self.shape(inner))
        if matrix.det() == 0:
            raise ZeroDivisionError(f"{inner} is singular")
        return as_table(matrix.inv())

    def _blocks(self, blocks):
        rows = []
        for line in blocks.tolist():
            parts = [self._table(block) for block in line]
            rows += [sum(pieces, []) for pieces in zip(*parts)]
        return rows

    def _scalar(self, expr):
        expr = sp.sympify(expr)
        if isinstance(expr, sp.Add):
            return fold(poly_plus, [self._scalar(a) for a in expr.args])
        if isinstance(expr, sp.Mul):
            return fold(poly_times, [self._scalar(a) for a in expr.args])
        if isinstance(expr, sp.Trace):
            return trace(self._table(expr.arg))
        if isinstance(expr, sp.Determinant):
            return self._determinant(expr.arg)
        if isinstance(expr, sp.log):
            return self._logarithm(expr.args[0])
        if isinstance(expr, sp.Symbol):
            size = self.sizes.get(expr)
            return self.of[expr] if size is None else constant(size)
        if isinstance(expr, sp.Pow):
            return self._scalar_power(*expr.args)
        return constant(rational(expr))

    def _determinant(self, matrix):
        table = self._table(matrix)
        if any(set(x) - {()} for row in table for x in row):
            raise ArithmeticError(f"the determinant of {matrix} has unknown entries")
        return constant(rational(as_matrix(table, self.shape(matrix)).det()))

    def _logarithm(self, inner):
        """Of a number, as a sum of those of primes, which are unknowns of their own."""
        value = self._scalar(inner)
        number = sp.Rational(value.get((), 0))
        if set(value) - {()} or number <= 0:
            raise ArithmeticError(f"the logarithm of {inner} is no number")
        return {((-1, p, 0),): k for p, k in sp.factorrat(number).items()}

    def _scalar_power(self, base, exponent):
        value, exponent = self._scalar(base), exponent.subs(self.sizes)
        if exponent.is_Rational and not exponent.is_Integer:
            root = sp.root(sp.Rational(value.get((), 0)), exponent.q)
            if set(value) - {()} or not root.is_Rational:
                raise ArithmeticError(f"{base} has no rational root")
            value, exponent = constant(rational(root)), exponent.p
        exponent = int(exponent)
        if exponent < 0:
            if set(value) != {()}:
                raise ZeroDivisionError(f"{base} is not a number other than zero")
            value = constant(Fraction(1) / value[()])
        return fold(poly_times, [value] * abs(exponent), None)


def fold(operation, values, size=None):
    """All values combined; of none at all, the identity or the number one."""
    if not values:
        return constant(1) if size is None else diagonal(size)
    total = values[0]
    for value in values[1:]:
        total = operation(total, value)
    return total


@cache
def size_function(expr):
    """The symbols in a size, and the size as a function of their numbers."""
    names = sorted(sp.sympify(expr).free_symbols, key=str)
    return names, sp.lambdify(names, expr, "math", dummify=True)


TRIES = (0, 1, -1, 2, -2)  # in any order, and mostly before the others
FRACTIONS = (Fraction(3, 5), Fraction(4, 5), Fraction(1, 2))  # 3-4-5 makes rotations
PATIENCE = 150  # branches of one search


class Unsolvable(Exception):
    """The equations have no solution where we look."""


class System:
    """Unknowns with the linear equations found so far, each solved for one unknown.

    >>> system = System()
    >>> system.require({("x",): 1, ("y",): 1, (): -3})  # x + y = 3
    >>> system.require({("x",): 1, ("y",): -1, (): -1})  # x - y = 1
    >>> system.reduced({("x",): 1}), system.reduced({("y",): 1})
    ({(): 2}, {(): 1})
    """

    def __init__(self):
        self.solved, self.used_in = {}, {}

    def copy(self):
        twin = System()
        twin.solved = dict(self.solved)
        twin.used_in = {x: set(rows) for x, rows in self.used_in.items()}
        return twin

    def reduced(self, p):
        """A polynomial in the unknowns that are still free."""
        if not any(x in self.solved for m in p for x in m):
            return p
        total = {}
        for m, c in p.items():
            term = {(): c}
            for x in m:
                term = poly_times(term, self.solved.get(x, {(x,): 1}))
            increased(total, term)
        return total

    def require(self, p):
        """Add the equation p = 0, which must be linear in what is free."""
        p = self.reduced(p)
        if not p:
            return
        pivot = next((m for m in p if m), None)
        if pivot is None:
            raise Unsolvable
        if any(len(m) > 1 for m in p):
            raise ValueError("this equation is not linear")
        x, c = pivot[0], p[pivot]
        row = {m: ratio(-d, c) for m, d in p.items() if m != pivot}
        self._put(x, row)

    def _put(self, x, row):
        """Solve for x, and put what it is where it is used."""
        for y in self.used_in.pop(x, ()):
            self._store(y, substituted(self.solved[y], x, row))
        self._store(x, row)

    def _store(self, x, row):
        self.solved[x] = row
        for m in row:
            if m:
                self.used_in.setdefault(m[0], set()).add(x)

    def fix(self, x, value):
        """Give an unknown that is not solved its number."""
        self._put(x, constant(value))


def substituted(row, x, replacement):
    """A linear polynomial with x replaced."""
    c = row.get((x,), 0)
    rest = {m: d for m, d in row.items() if m != (x,)}
    return poly_plus(rest, {m: c * d for m, d in replacement.items()}) if c else rest


def ratio(a, b):
    value = Fraction(a) / b
    return value.numerator if value.denominator == 1 else value


def search(system, equations, random):
    """A `System` in which all equations hold; those that are not linear, by trial."""
    budget = [PATIENCE]
    found = _search(system, equations, random, budget)
    if found is None:
        raise Unsolvable
    return found


def _search(system, equations, random, budget):
    budget[0] -= 1
    system = system.copy()
    try:
        equations = settled(system, equations)
    except Unsolvable:
        return None
    if not equations:
        return system
    x, values = branching(equations, random)
    for value in values:
        if budget[0] <= 0:
            break
        tried = system.copy()
        tried.fix(x, value)
        found = _search(tried, equations, random, budget)
        if found is not None:
            return found
    return None


def settled(system, equations):
    """What is left of the equations when all linear ones are solved."""
    while True:
        equations = [p for p in map(system.reduced, equations) if p]
        linear = [p for p in equations if all(len(m) < 2 for m in p)]
        if not linear:
            return equations
        for p in linear:
            system.require(p)


def branching(equations, random):
    """An unknown and the numbers to try for it."""
    for p in equations:
        names = {x for m in p for x in m}
        if len(names) == 1:
            (x,) = names
            return x, roots(p)
    shortest = min(equations, key=lambda p: len({x for m in p for x in m}))
    names = sorted({x for m in shortest for x in m})
    tries, late = list(TRIES), list(FRACTIONS)
    if random.random() < 0.25:
        tries, late = tries + late, []
    random.shuffle(tries)
    return random.choice(names), tries + late


def roots(p):
    """Rational roots of a polynomial in one unknown; above degree 2, small ones."""
    degree = max(len(m) for m in p)
    c = [Fraction(0)] * (degree + 1)
    for m, d in p.items():
        c[len(m)] = Fraction(d)
    if degree > 2:
        tries = (*TRIES, *FRACTIONS)
        return [t for t in tries if sum(d * t**k for k, d in enumerate(c)) == 0]
    root = rational_root(c[1] ** 2 - 4 * c[2] * c[0])
    if root is None:
        return []
    return sorted({ratio(-c[1] + s * root, 2 * c[2]) for s in (1, -1)})


def rational_root(q):
    """The rational square root of a fraction, or None."""
    if q < 0:
        return None
    top, bottom = isqrt(q.numerator), isqrt(q.denominator)
    exact = top * top == q.numerator and bottom * bottom == q.denominator
    return Fraction(top, bottom) if exact else None
