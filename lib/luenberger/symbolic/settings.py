"""Relations, everything in them that needs a value, and the sizes to try."""

from collections import Counter
from functools import cache
from itertools import islice, product
from random import Random

import sympy as sp

from .exact import base_of_inverse, monomials, plain, unknowns

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
    unknowns : dict of unknown to shape
        Matrix symbols, inverses, and scalars (of shape None).
    partial : list of expression
        The other expressions in which a scalar is inverted or has a root.
    """

    def __init__(self, relations, symmetric, also=()):
        self.relations, self.symmetric = relations, set(symmetric)
        self.equations = [(plain(r.left), plain(r.right)) for r in relations]
        also = [plain(side) for side in also]
        self.partial = [
            side for side in also if any(map(is_partial, side.atoms(sp.Pow)))
        ]
        sides = [s for pair in self.equations for s in pair] + also
        nodes = [node for s in sides for node in sp.preorder_traversal(s)]
        self._list_sizes(nodes)
        inverted = dict.fromkeys(filter(None, map(base_of_inverse, nodes)))
        for X in inverted:
            Y, one = sp.Inverse(X), sp.Identity(X.shape[0])
            for factors in ((X, Y), (Y, X)):
                self.equations.append((sp.MatMul(*factors, evaluate=False), one))
        self.symmetric |= {("inverse", X) for X in inverted if X in self.symmetric}
        self.supports = [self._support(a, b) for a, b in self.equations]
        self._list_unknowns(set().union(*map(unknowns, sides)))
        self.stated_zeros = sum(
            isinstance(a, sp.MatrixSymbol) and getattr(b, "is_ZeroMatrix", False)
            for a, b in self.equations
        )

    def _list_sizes(self, nodes):
        shaped = [n for n in nodes if getattr(n, "shape", ())]
        self.dimensions = {sp.sympify(d) for n in shaped for d in n.shape}
        symbols = set().union(*(d.free_symbols for d in self.dimensions))
        self.sizes = sorted(symbols, key=str)
        self.caps = dict.fromkeys(self.sizes, LARGEST)
        for n in nodes:
            if isinstance(n, sp.MatPow) and n.exp.is_Integer:
                for size in sp.sympify(n.shape[0]).free_symbols:
                    self.caps[size] = max(self.caps[size], int(n.exp) + 1)

    def _support(self, *sides):
        found = set().union(*(monomials(side) for side in sides))
        return {tuple(s for s in m if s not in self.caps) for m in found}

    def _list_unknowns(self, found):
        self.unknowns = {}
        for s in sorted(found - set(self.sizes), key=str):
            inside = s[1] if isinstance(s, tuple) else s
            self.unknowns[s] = getattr(inside, "shape", None)

    # -- sizes ----------------------------------------------------------------------

    def _all_sizes(self):
        """Pairs of sizes that leave no matrix empty, and the dimensions they give."""
        dimensions = sorted((d for d in self.dimensions if d.free_symbols), key=str)
        at = _evaluated(tuple(self.sizes), tuple(dimensions))
        ranges = [range(1, self.caps[s] + 1) for s in self.sizes]
        for values in islice(product(*ranges), MOST):
            found = at(*values)
            if all(d >= 1 for d in found):
                yield dict(zip(self.sizes, values)), found

    def generic_sizes(self):
        """Sizes that differ from each other first, so that no accident helps."""

        def alike(pair):
            counts = Counter(pair[1])
            return sum(k * k for k in counts.values()) + counts[1], sum(pair[1])

        return self._in_turn(sorted(self._all_sizes(), key=alike))

    def small_sizes(self):
        """The smallest first: a counterexample should be short."""
        return self._in_turn(sorted(self._all_sizes(), key=lambda pair: sum(pair[1])))

    def _in_turn(self, sizes):
        sizes = [chosen for chosen, _ in sizes]
        late = sizes[FIRST:]
        Random(1).shuffle(late)
        return sizes[:FIRST] + late


@cache
def _evaluated(sizes, dimensions):
    """Dimensions as a function of sizes; pages ask for the same few again and again."""
    return sp.lambdify(sizes, list(dimensions), "math", dummify=True)


def is_partial(power):
    """Whether a power of a scalar is not a number everywhere."""
    return not (power.exp.is_Integer and power.exp.is_nonnegative)
