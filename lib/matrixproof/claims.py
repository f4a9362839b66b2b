"""A claim about explicit values: two sides whose difference must vanish."""

from dataclasses import dataclass

import sympy as sp

from .words import Formula, exact


@dataclass(frozen=True, eq=False)
class Claim:
    """`left = right`, of explicit matrices or scalars; it is evaluated.

    Attributes
    ----------
    left, right : Matrix or scalar
        A right side of 0 fits every left side.
    """

    left: Formula
    right: Formula = 0

    @property
    def residual(self) -> Formula:
        """The difference of the sides."""
        left, right = (sp.sympify(exact(x, False)) for x in (self.left, self.right))
        if isinstance(left, sp.MatrixBase) and 0 in left.shape:
            raise ValueError(
                f"a claim about an empty matrix, {left.rows} x {left.cols}, "
                "says nothing"
            )
        bare = isinstance(self.right, int) and self.right == 0
        return left if bare else left - right

    @property
    def is_zero(self) -> bool:
        """Whether every entry is identically zero, as it stands or simplified."""
        residual = self.residual
        entries = residual if isinstance(residual, sp.MatrixBase) else [residual]
        return all(x == 0 or sp.simplify(x) == 0 for x in entries)
