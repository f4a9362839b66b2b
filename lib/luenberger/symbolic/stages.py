"""The stages of a recursion: what the kernels compile, and the chains behind it."""

from dataclasses import dataclass

import sympy as sp

from .lines import Line, Substitute
from .relations import Reasons
from .typeset import Show, latex, text
from .words import Formula, Shape, Symbols


@dataclass(frozen=True)
class Solve:
    """The matrix X with X M = N, M symmetric and positive definite: N M^-1.

    Kernels lower it to a factorisation of M and never form the inverse.
    """

    N: sp.MatrixExpr
    M: sp.MatrixExpr

    @property
    def shape(self) -> Shape:
        return self.N.shape[0], self.M.shape[0]

    def as_inverse(self) -> Formula:
        """The same matrix written with an inverse, for reading and for exact checks."""
        return self.N * self.M.I

    def __str__(self):
        return text(self.as_inverse())

    def _repr_latex_(self):
        return f"$\\displaystyle {latex(self.as_inverse())}$"


@dataclass(frozen=True, repr=False)
class Stage:
    """One assignment of a recursion, at symbolic sizes.

    Attributes
    ----------
    target : MatrixSymbol
        What is assigned.
    formula : MatrixExpr or Solve
        In terms of the derivation's `given` and of earlier targets.
    equation : str
        Where the paper has it, e.g. "(29)"; empty for a step of our own.
    symmetric : bool
        The target is symmetric; kernels store it symmetrically, because rounding
        that is not symmetric grows from step to step.
    by : tuple of Relation or Chain
        What justifies it: target = formula must follow from these and need them all.

    Examples
    --------
    >>> from sympy import symbols
    >>> from luenberger.symbolic import MatrixSymbol, Relation
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B, S = (MatrixSymbol(name, n, n) for name in "ABS")
    >>> meant = Relation("S = A + B", S, A + B)
    >>> Stage(S, A + B, by=(meant,)).complaints()
    []
    >>> print(Stage(S, A - B, by=(meant,)).complaints()[0].partition(":")[0])
    S = A - B does not follow from S = A + B
    """

    target: sp.MatrixSymbol
    formula: Formula
    equation: str = ""
    symmetric: bool = False
    by: tuple = ()

    @property
    def expression(self) -> Formula:
        """The formula, with an inverse where there is a `Solve`."""
        solve = isinstance(self.formula, Solve)
        return self.formula.as_inverse() if solve else self.formula

    @property
    def reasons(self) -> Reasons:
        """What justifies the stage, as relations."""
        return tuple(getattr(r, "relation", r) for r in self.by)

    def complaints(self, symmetric: Symbols = ()) -> list[str]:
        """Why the stage is not what its chains prove; [] if it is, or has none."""
        if not self.by:
            return []
        found = self.line.complaints(self.target, symmetric)
        return [f"{self.shown(text)} {complaint}" for complaint in found]

    @property
    def line(self) -> Line:
        """The stage as a line of a chain that begins with its target."""
        blocks = isinstance(self.expression, sp.BlockMatrix)
        return (Substitute if blocks else Line)(self.expression, self.reasons)

    def shown(self, show: Show) -> str:
        """The assignment, set by `show`: `latex` or `text`."""
        return f"{show(self.target)} = {show(self.expression)}"

    def __str__(self):
        return f"{self.shown(text)}  {self.equation}".rstrip()

    __repr__ = __str__

    def _repr_latex_(self):
        tag = rf" \qquad \text{{{self.equation}}}" if self.equation else ""
        return f"$\\displaystyle {self.shown(latex)}{tag}$"
