"""Equations as statements, and lines that lead from one to the next."""

from dataclasses import dataclass
from typing import ClassVar

from .breaks import pieces
from .lines import Line
from .reasons import cited_text, follows, gap, idle, vacuous
from .relations import Relation
from .typeset import Show, text
from .words import Formula, Symbols


@dataclass(frozen=True, eq=False)
class Equation:
    """An equation as a statement, which a chain of equivalences leads on.

    >>> from matrixproof import MatrixSymbol
    >>> print(Equation(MatrixSymbol("x_next", 2, 1), MatrixSymbol("x", 2, 1)))
    x₊ = x
    """

    left: Formula
    right: Formula

    def relation(self, name: str = "the line before") -> Relation:
        return Relation(name, self.left, self.right)

    @property
    def expressions(self) -> tuple[Formula, Formula]:
        return self.left, self.right

    def show(self, show: Show) -> str:
        return f"{show(self.left)} = {show(self.right)}"

    def __str__(self):
        return self.show(text)


class Implies(Line):
    """An equation that follows from the one before it.

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B, C = (MatrixSymbol(x, n, n) for x in "ABC")
    >>> Implies(Equation(A * C, B * C)).complaints(Equation(A, B), ())
    []
    >>> said = Implies(Equation(A, B)).complaints(Equation(A * C, B * C), ())
    >>> print(said[0].partition(":")[0])
    does not follow from the line before
    """

    sign: ClassVar[str] = "⇒"
    latex_sign: ClassVar[str] = r"\Rightarrow"

    def complaints(self, left: Equation, symmetric: Symbols) -> list[str]:
        found = self._one_way(left, self.right, "the line before", symmetric)
        if found:
            return found
        holds = lambda others: self._holds(left, others, symmetric)  # noqa: E731
        found = [f"does not need {cited_text(r)}" for r in idle(self.by, holds)]
        if follows(self.right.left, self.right.right, self.by, symmetric):
            found.append("does not need the line before")
        given = (*self.by, left.relation())
        return found + vacuous(self.right.left, self.right.right, given, symmetric)

    def _one_way(self, given, wanted, name, symmetric):
        cited = (*self.by, given.relation(name))
        missing = gap(wanted.left, wanted.right, cited, symmetric)
        if missing is None:
            return []
        sources = " and ".join(map(cited_text, cited))
        return [f"does not follow from {sources}: {missing}"]

    def _holds(self, left, cited, symmetric):
        given = (*cited, left.relation())
        return follows(self.right.left, self.right.right, given, symmetric)

    def too_wide(self) -> list[str]:
        halves = (Line(self.right.left), Line(self.right.right))
        return [complaint for half in halves for complaint in half.too_wide()]

    def body(self, show: Show) -> str:
        return self.right.show(show)

    def pieces(self, show: Show) -> list[str]:
        left, right = (pieces(side, show) for side in self.right.expressions)
        return [*left, f"= {right[0]}", *right[1:]]


class Iff(Implies):
    """An equation that says the same as the one before it.

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B, C = (MatrixSymbol(x, n, n) for x in "ABC")
    >>> Iff(Equation(A, B * C.I)).complaints(Equation(A * C, B), ())
    []
    """

    sign: ClassVar[str] = "⇔"
    latex_sign: ClassVar[str] = r"\Leftrightarrow"

    def complaints(self, left: Equation, symmetric: Symbols) -> list[str]:
        back = self._one_way(self.right, left, "this line, back,", symmetric)
        return back or super().complaints(left, symmetric)

    def _holds(self, left, cited, symmetric):
        back = (*cited, self.right.relation())
        return super()._holds(left, cited, symmetric) and follows(
            left.left, left.right, back, symmetric
        )
