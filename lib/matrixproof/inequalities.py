"""Lines that drop or add a square: what follows is less, or more, by a square."""

from dataclasses import dataclass
from typing import ClassVar

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .lines import Line
from .reasons import Gap
from .relations import Reasons
from .typeset import Show, latex, text
from .words import Formula, Symbols


@dataclass(frozen=True, eq=False)
class AtLeast(Line):
    """An inequality: a square is dropped.

    Parameters
    ----------
    root : MatrixExpr
        What is dropped is X X' with this X; between scalars, the trace of X X'.  The
        numbers in it must be real: sqrt(c) B needs a c that is not negative.

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> AtLeast(A, root=B).complaints(A + B * B.T, ())
    []
    """

    root: Formula = None

    sign: ClassVar[str] = "≥"
    latex_sign: ClassVar[str] = r"\ge"
    side: ClassVar[int] = 1

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        return self.unreal() or super().complaints(left, symmetric)

    def gap(self, left: Formula, cited: Reasons, symmetric: Symbols) -> Gap | None:
        faults = self.unreal()
        return Gap(why=faults[0]) if faults else super().gap(left, cited, symmetric)

    def unreal(self) -> list[str]:
        """A complaint about each number in the root that may not be real."""
        return [
            f"drops no square: {text(c)} may not be real"
            + (
                "; say of its letters that they are nonnegative"
                if c.free_symbols
                else ""
            )
            for c in numbers(self.root)
            if not real(c)
        ]

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
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> AtMost(A + B * B.T, root=B).complaints(A, ())
    []
    """

    sign: ClassVar[str] = "≤"
    latex_sign: ClassVar[str] = r"\le"
    side: ClassVar[int] = -1


def numbers(expr):
    """The numbers in a matrix expression: its coefficients, the entries of tables."""
    if isinstance(expr, sp.MatrixBase):
        return [x for entry in expr for x in numbers(entry)]
    if not isinstance(expr, MatrixExpr):
        return [expr]
    if isinstance(expr, sp.BlockMatrix):
        return numbers(expr.blocks)
    if isinstance(expr, sp.MatrixSymbol | sp.Identity | sp.ZeroMatrix):
        return []
    return [x for arg in expr.args for x in numbers(arg)]


def real(number):
    """Whether a number is real for all its letters; a plain letter is a real number."""
    letters = {
        s: sp.Dummy(s.name, **{**s.assumptions0, "extended_real": True})
        for s in number.free_symbols
        if isinstance(s, sp.Symbol) and s.is_extended_real is None
    }
    traces = {t: sp.Dummy("trace", real=True) for t in number.atoms(sp.Trace)}
    return number.xreplace(traces).xreplace(letters).is_extended_real is True
