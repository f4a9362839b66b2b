"""Polynomial equations over the rationals: linear ones solved, others searched.

Equations that are linear are solved exactly and for good.  What is left is searched:
an equation in one unknown gives its rational roots, and where no equation decides,
a few small numbers are tried.

Source: our own.
"""

from fractions import Fraction
from math import isqrt

from .exact import constant, increased, poly_plus, poly_times

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
    """A `System` in which all equations hold; those that are not linear, by trial.

    Raises
    ------
    Unsolvable
        None was found within `PATIENCE` branches.
    """
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
