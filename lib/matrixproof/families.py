"""Families: letters with an index, and sums over all of its values.

`sum_i * A_i * Q * A_i.T` is the sum over i of A_i Q A_i', for a family A_1, ..., A_p
of any number of members.  The sign of the sum is a factor like a number, in front of
what it sums; so a sum is linear, and an equation between sums holds if it holds between
what they sum, for one member that stands for each.

Such a factor is no number that a proof may use freely: where an equation has a sum over
i, nothing with a member A_i may be multiplied to it, and no second sum.  The checker
holds every term of a certificate against that.

In the product of two sums the second has an index of its own; copies of i are i', i''
by name, and are shown as j, k.
"""

import sympy as sp

from .symbols import Member, Over, at, shown
from .words import plain


def over(index):
    """The sign of the sum over an index."""
    return Over(f"sum_{index}")


def sums(expr):
    """The signs of sums in an expression or a coefficient."""
    return expr.atoms(Over) if isinstance(expr, sp.Basic) else set()


def summed(value):
    """The indices over which something in a normal form is summed."""
    terms = getattr(value, "terms", None)
    if terms is None:
        return set().union(*(summed(x) for row in value.entries for x in row))
    return {s.index for c in terms.values() for s in sums(c)}


def left_open(value):
    """The indices of members in a normal form that are in no sum over them."""
    if not hasattr(value, "terms"):
        return set().union(*(left_open(x) for row in value.entries for x in row))
    return {
        index
        for word, c in value.terms.items()
        for x in word
        for index in value.algebra.depends(x.atom) - {s.index for s in sums(c)}
    }


def refuse_captured(value, factor):
    """Refuse two factors, one with a member and the other with a sum over its index."""
    once, twice = summed(value), summed(factor)
    if not (once or twice):
        return
    if caught := (once & left_open(factor)) | (twice & left_open(value)):
        i = shown(min(caught))
        raise ValueError(
            f"a member with the index {i} stands beside a sum over {i}, and not in it: "
            "write the sum in front of all that it sums, or use another index"
        )


def product(v, c, w, d):
    """The product of two words with coefficients, each sum with an index of its own."""
    once = {s.index for s in sums(c)}
    for index in sorted(once & {s.index for s in sums(d)}):
        new = index
        while new in once | {s.index for s in sums(d)}:
            new += "'"
        if any(x.inverted and not isinstance(x.atom, Member) for x in w):
            raise ValueError("what is inverted in a product of sums needs a letter")
        w, d = renamed(w, {index: new}), recast(d, {index: new})
    return v + w, c * d


def renamed(word, new):
    """A word with other indices."""
    return tuple(
        x._replace(atom=at(x.atom, new[x.atom.index]))
        if isinstance(x.atom, Member) and x.atom.index in new
        else x
        for x in word
    )


def recast(c, new):
    """A coefficient with other indices."""
    signs = {s: over(new[s.index]) for s in sums(c) if s.index in new}
    return c.xreplace(signs) if signs else c


def settled(pairs):
    """(word, coefficient) pairs whose indices are named in the order of the word."""
    for word, c in pairs:
        if not any(s.index.endswith("'") for s in sums(c)):
            yield word, c
            continue
        for part in sp.Add.make_args(sp.expand(c)):
            yield in_turn(word, part)


def in_turn(word, c):
    """A word and its coefficient, the first index that occurs named first."""
    signs = {s.index for s in sums(c)}
    met = [x.atom.index for x in word if isinstance(x.atom, Member)]
    taken, new = set(met) - signs, {}
    for index in dict.fromkeys([*(i for i in met if i in signs), *sorted(signs)]):
        name = index.rstrip("'")
        while name in taken:
            name += "'"
        taken.add(name)
        new[index] = name
    return renamed(word, new), recast(c, new)


def degree(c, sign):
    """In which power the sign of a sum is in a coefficient; 2 if in none that is whole.

    >>> degree(3 * over("i"), over("i")), degree(1 / over("i"), over("i"))
    (1, 2)
    """
    if not isinstance(c, sp.Basic) or not c.has(sign):
        return 0
    return sp.degree(c, sign) if c.is_polynomial(sign) else 2


def alike(expr):
    """An expression in which all members of a family are one, for explicit values."""
    copies = {
        x: over(x.index.rstrip("'"))
        if isinstance(x, Over)
        else at(x, x.index.rstrip("'"))
        for x in plain(expr).atoms(Over, Member)
        if x.index.endswith("'")
    }
    return plain(expr).xreplace(copies) if copies else plain(expr)


def scopes(free, *sides):
    """{sign of a sum: the names of letters that depend on its index}."""
    signs = set().union(*(sums(plain(side)) for side in sides))
    found = {s: set() for s in signs}
    for (atom, _), name in free.names.items():
        for index in free.depends(atom):
            found.setdefault(over(index), set()).add(name)
    return {s: frozenset(names) for s, names in found.items()}
