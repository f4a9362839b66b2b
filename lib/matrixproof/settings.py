"""Relations, everything in them that needs a value, and the sizes to try."""

from collections import Counter
from functools import cache, lru_cache
from itertools import islice, product
from random import Random

import sympy as sp

from .contents import KEPT, monomials, parts, unknowns
from .dependence import declared
from .words import plain

LARGEST = 3  # of the sizes that are tried, unless a power asks for more
MOST = 3**8  # combinations of sizes that are looked at
FIRST = 8  # sizes tried in order of preference; the others follow in mixed order


class Setting:
    """Relations, and perhaps other expressions, with everything that needs a value.

    Attributes
    ----------
    equations : list of (left, right)
        The relations, and X Y = I, Y X = I for every inverse Y of an X.
    supports : list of set of tuple
        For every equation the products of unknowns in it.
    masks : list of (int, list of (int, int))
        The same as bits, one for each unknown: what is in an equation, and for each
        product what is in it and what is in it more than once.
    bits : dict of unknown to int
    degree : dict of unknown to int
        How often it occurs in one product, at most.
    defined : set of MatrixSymbol
        What stands alone on the left of an equation.
    unknowns : dict of unknown to shape
        Matrix symbols, inverses, and scalars (of shape None).
    full : bool
        No matrix is empty at the sizes that are tried.
    partial : list of expression
        The other expressions in which a scalar is inverted or has a root.
    values : dict of symbol to matrix or number
        What is known before the search.
    """

    def __init__(self, relations, symmetric, also=(), values=None):
        self.relations = relations
        self.symmetric = set(declared(symmetric, (*relations, *also)))
        self.values = values or {}
        self.equations = [(plain(r.left), plain(r.right)) for r in relations]
        also = [plain(side) for side in also]
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
    """All unknowns of an equation, and (all, repeated) of each product, as bits.

    >>> masks({("x", "y"), ("x", "x")}, {"x": 1, "y": 2})[0]
    3
    """
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
