"""Lines that drop or add a square: what follows is less, or more, by a square."""

from dataclasses import dataclass
from typing import ClassVar

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .lines import Line
from .typeset import Show, latex
from .words import Formula


@dataclass(frozen=True, eq=False)
class AtLeast(Line):
    """An inequality: a square is dropped.

    Parameters
    ----------
    root : MatrixExpr
        What is dropped is X X' with this X; between scalars, the trace of X X'.

    >>> from sympy import symbols
    >>> from luenberger.symbolic import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> AtLeast(A, root=B).complaints(A + B * B.T, ())
    []
    """

    root: Formula = None

    sign: ClassVar[str] = "≥"
    latex_sign: ClassVar[str] = r"\ge"
    side: ClassVar[int] = 1

    def equation(self, left: Formula) -> tuple[Formula, Formula]:
        square = self.root * self.root.T
        if not isinstance(left, MatrixExpr) and not hasattr(left, "shape"):
            square = sp.Trace(square)
        return left, self.right + self.side * square

    def reason(self, show: Show) -> str:
        turned = isinstance(self.root, sp.Transpose)
        other = self.root.arg if turned else sp.Transpose(self.root)
        square = sp.MatMul(self.root, other, evaluate=False)
        mine = show(square) + (r" \ge 0" if show is latex else " ≥ 0")
        said = super().reason(show)
        joint = r",\; " if show is latex else ", "
        return f"{mine}{joint}{said}" if said else mine


class AtMost(AtLeast):
    """The reverse inequality: a square is added.

    >>> from sympy import symbols
    >>> from luenberger.symbolic import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> AtMost(A + B * B.T, root=B).complaints(A, ())
    []
    """

    sign: ClassVar[str] = "≤"
    latex_sign: ClassVar[str] = r"\le"
    side: ClassVar[int] = -1
