"""A claim: two sides, and the algebra in which their difference must vanish."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .core import Algebra
from .models import possible
from .proofs import Proof, prove
from .relations import named, unfounded
from .statements import sound
from .typeset import latex, text
from .words import Formula, exact


@dataclass(frozen=True, eq=False)
class Claim:
    """`left = right`, for all values of the symbols that satisfy the relations.

    Attributes
    ----------
    left, right : SymPy expression or normal form
        A right side of 0 fits every left side.
    algebra : Algebra, optional
        Without one, the sides are explicit matrices or scalars.
    """

    left: Formula
    right: Formula = 0
    algebra: Algebra | None = None

    @cached_property
    def residual(self) -> Formula:
        """The difference of the sides in normal form."""
        if self.algebra is None:
            left, right = (sp.sympify(exact(x, False)) for x in (self.left, self.right))
            if isinstance(left, sp.MatrixBase) and 0 in left.shape:
                raise ValueError(
                    f"a claim about an empty matrix, {left.rows} x {left.cols}, "
                    "says nothing"
                )
            return left if self._is_bare() else left - right
        sound(*self._sides())
        left = self.algebra.normal(self.left)
        return left if self._is_bare() else left - self.algebra.normal(self.right)

    def _is_bare(self):
        return isinstance(self.right, int) and self.right == 0

    @property
    def is_zero(self) -> bool:
        """Whether the claim is proved."""
        residual = self.residual
        if self.algebra is not None:
            sides = tuple(self._sides())
            symmetric = self.algebra.symmetric
            cited = named(self.relations)
            return (
                residual.is_zero
                and not unfounded(cited, symmetric)
                and possible(cited, symmetric, sides)
            )
        entries = residual if isinstance(residual, sp.MatrixBase) else [residual]
        return all(map(is_nothing, entries))

    def proof(self) -> Proof:
        """The `Proof` of the claim, with a certificate that can be checked.

        Raises
        ------
        Unproved
            It does not follow from the relations, or the search met its limit.
        TypeError
            The claim is about explicit matrices or scalars: it is evaluated, and there
            is nothing to certify.
        """
        if self.algebra is None:
            raise TypeError("an explicit claim is evaluated; it has no certificate")
        left, right = (
            side.as_expr() if hasattr(side, "algebra") else side
            for side in (self.left, self.right)
        )
        return prove(left, right, self.relations, self.algebra.symmetric)

    @property
    def relations(self) -> tuple[Any, ...]:
        """What the claim takes for granted."""
        return () if self.algebra is None else self.algebra.relations

    def _sides(self):
        for side in (self.left, self.right):
            side = side.as_expr() if hasattr(side, "algebra") else side
            yield side if isinstance(side, (MatrixExpr, sp.Basic)) else sp.sympify(side)

    def __repr__(self):
        return " = ".join(map(text, self._sides()))

    def _repr_latex_(self):
        return f"$\\displaystyle {' = '.join(map(latex, self._sides()))}$"


def is_nothing(scalar: Formula) -> bool:
    """Whether a scalar is identically zero: as it stands, or simplified."""
    return scalar == 0 or sp.simplify(scalar) == 0
