"""What is in an expression: the sizes, the unknowns and the products of unknowns.

Pages cite the same relations again and again, so what is in them is kept.
"""

from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from .exact import base_of_inverse
from .families import alike
from .words import is_letter

KEPT = 20_000  # expressions of which it is kept what is in them


class Parts(NamedTuple):
    """What an expression has in it that decides which sizes and values it needs."""

    dimensions: frozenset  # of the matrices in it
    inverted: tuple  # what is inverted, in order
    powers: frozenset  # pairs (size, exponent) of the powers of matrices
    partial: bool  # whether a scalar is inverted or has a root


@lru_cache(KEPT)
def parts(expr):
    """The `Parts` of an expression."""
    nodes = list(sp.preorder_traversal(expr))
    shaped = [n for n in nodes if getattr(n, "shape", ())]
    powers = [n for n in nodes if isinstance(n, sp.MatPow) and n.exp.is_Integer]
    return Parts(
        frozenset(sp.sympify(d) for n in shaped for d in n.shape),
        tuple(filter(None, map(base_of_inverse, nodes))),
        frozenset((sp.sympify(n.shape[0]), int(n.exp)) for n in powers),
        any(is_partial(n) for n in nodes if isinstance(n, sp.Pow)),
    )


def is_partial(power):
    """Whether a power of a scalar is not a number everywhere."""
    return not (power.exp.is_Integer and power.exp.is_nonnegative)


@lru_cache(KEPT)
def unknowns(expr):
    """Symbols that need a value, sizes included; an inverse counts as a symbol."""
    found, waiting = set(), [alike(expr)]
    while waiting:
        node = waiting.pop()
        inner = base_of_inverse(node)
        if inner is not None:
            found.add(("inverse", inner))
        if is_letter(node):
            found.add(node)
        elif isinstance(node, sp.MatrixBase):
            waiting += list(node)
        elif not isinstance(node, (sp.Identity, sp.ZeroMatrix)):
            waiting += node.args
    return found


@lru_cache(KEPT)
def monomials(expr):
    """The products of unknowns that an expression is a sum of, orders put aside.

    A set of sorted tuples.  An inverse counts as one unknown, and what is inverted
    does not count.  A scalar with a negative exponent is listed twice, because no
    equation is linear in it.
    """
    expr = alike(expr)
    inner = base_of_inverse(expr)
    if inner is not None:
        return {(("inverse", inner),) * -int(expr.exp)}
    if is_letter(expr):
        return {(expr,)}
    if isinstance(expr, (sp.Identity, sp.ZeroMatrix)):
        return {()}
    if isinstance(expr, (sp.MatPow, sp.Pow)):
        whole = expr.exp.is_Integer and expr.exp.is_nonnegative
        return crossed([monomials(expr.base)] * (int(expr.exp) if whole else 2))
    if isinstance(expr, (sp.Determinant, sp.log)):  # of no low degree
        return crossed([monomials(expr.args[0])] * 2)
    if isinstance(expr, sp.MatrixBase):
        return set().union({()}, *(monomials(x) for x in expr))
    if isinstance(expr, (sp.MatMul, sp.Mul)):
        return crossed([monomials(part) for part in expr.args])
    return set().union({()}, *(monomials(part) for part in expr.args))


def crossed(factors):
    """Every product of one monomial from each factor."""
    total = {()}
    for factor in factors:
        total = {tuple(sorted(m + k, key=str)) for m in total for k in factor}
    return total
