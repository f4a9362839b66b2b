"""The lines of a derivation: what each says of the line before it, and why.

Every kind of line has what follows the sign (`right`), what it cites (`by`), words
where nothing is cited (`why`), a sign, and `complaints(left, symmetric)`: [] when the
line follows from exactly what it cites and needs all of it.
"""

from dataclasses import dataclass
from typing import ClassVar

import sympy as sp

from .breaks import pieces
from .core import Algebra
from .prose import plain
from .reasons import Gap, cited_latex, cited_text, follows, gap, idle, vacuous, words
from .relations import Reasons, named, refuse_means
from .terms import opened
from .typeset import WIDEST, Show, latex, text, width
from .words import Formula, ShapeError, Symbols


@dataclass(frozen=True, eq=False)
class Line:
    r"""The next line of a chain of equations.

    Parameters
    ----------
    right : expression
        What the line before it is equal to.
    by : tuple of Relation
        The relations that the step needs, all of them and no others.
    why : str
        Words for the reason; where nothing is cited, say what was done.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol, Relation
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B, C = (MatrixSymbol(x, n, n) for x in "ABC")
    >>> meant, idle = Relation("A B = C", A * B, C), Relation("B A = C", B * A, C)
    >>> Line(C * B, by=(meant,)).complaints(A * B * B, ())
    []
    >>> print(*Line(C * B, by=(meant, idle)).complaints(A * B * B, ()))
    does not need B A = C
    """

    right: Formula
    by: tuple = ()
    why: str = ""

    sign: ClassVar[str] = "="
    latex_sign: ClassVar[str] = "="

    def __post_init__(self):
        object.__setattr__(self, "by", named(self.by))
        refuse_means(self.by)

    @property
    def cites(self) -> Reasons:
        """Every relation that the line rests on."""
        return self.by

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        """What is wrong with the step from `left` to this line, in plain language."""
        missing = self.gap(left, self.by, symmetric)
        if missing is not None:
            return [f"does not follow{self._sources()}: {missing}"]
        spare = idle(self.by, lambda others: self.follows(left, others, symmetric))
        return [f"does not need {cited_text(r)}" for r in spare] + self.vacuous(
            left, symmetric
        )

    def gap(self, left: Formula, cited: Reasons, symmetric: Symbols) -> Gap | None:
        return gap(*self.equation(left), cited, symmetric)

    def follows(self, left: Formula, cited: Reasons, symmetric: Symbols) -> bool:
        return follows(*self.equation(left), cited, symmetric)

    def vacuous(self, left: Formula, symmetric: Symbols) -> list[str]:
        return vacuous(*self.equation(left), self.by, symmetric)

    def equation(self, left: Formula) -> tuple[Formula, Formula]:
        """The two expressions that must be equal."""
        return left, self.right

    def too_wide(self) -> list[str]:
        """A complaint if the line does not fit on a page."""
        wide = width(self.right)
        if wide <= WIDEST:
            return []
        return [f"is {wide} characters wide; {WIDEST} fit, so it needs a letter"]

    def _sources(self):
        return " from " + " and ".join(map(cited_text, self.by)) if self.by else ""

    # -- shown ------------------------------------------------------------------------

    def head(self, show: Show) -> str:
        """What stands to the left of the sign: nothing, or what is done to the left."""
        return ""

    def body(self, show: Show) -> str:
        """What stands to the right of the sign."""
        return show(self.right)

    def pieces(self, show: Show) -> list[str]:
        """The body, in pieces between which a page may break it."""
        return pieces(self.right, show)

    def reason(self, show: Show) -> str:
        """Why the line follows, in words or formulas."""
        cite, word = (cited_latex, words) if show is latex else (cited_text, plain)
        said = [cite(r) for r in self.by] + ([word(self.why)] if self.why else [])
        return (r",\; " if show is latex else ", ").join(said)

    def __str__(self):
        return f"{self.head(text)} {self.sign} {self.body(text)}".strip()


class Cyclic(Line):
    """A line that holds because the trace of a product is that of its rotations.

    Multiplying out must not be enough, or the reason would be decoration.

    >>> from sympy import Trace, symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> Cyclic(Trace(B * A)).complaints(Trace(A * B), ())
    []
    >>> print(*Cyclic(Trace(A * B)).complaints(Trace(A * B), ()))
    does not need that the trace is cyclic
    """

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        found = super().complaints(left, symmetric)
        if (
            not found
            and not self.by
            and opened(left, Algebra()) == opened(self.right, Algebra())
        ):
            found = ["does not need that the trace is cyclic"]
        return found

    def reason(self, show: Show) -> str:
        said = super().reason(show)
        mine = words("the trace is cyclic") if show is latex else "the trace is cyclic"
        return f"{said}, {mine}" if said else mine


@dataclass(frozen=True, eq=False)
class Substitute(Line):
    """A definition put in, or a definition recognised.

    Each relation cited must define a symbol, its left side, and nothing but putting
    the definitions in is done.

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol, Relation
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B, S = (MatrixSymbol(x, n, n) for x in "ABS")
    >>> sum_ = Relation("S = A + B", S, A + B)
    >>> Substitute(A * (A + B), by=(sum_,)).complaints(A * S, ())
    []
    """

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        for relation in self.by:
            if not isinstance(relation.left, (sp.MatrixSymbol, sp.Symbol)):
                return [f"{cited_text(relation)} does not define a symbol"]
        return super().complaints(left, symmetric)

    def gap(self, left: Formula, cited: Reasons, symmetric: Symbols) -> Gap | None:
        return gap(*self._with_meanings(left, cited), (), symmetric)

    def follows(self, left: Formula, cited: Reasons, symmetric: Symbols) -> bool:
        try:
            return follows(*self._with_meanings(left, cited), (), symmetric)
        except ShapeError:  # blocks beside a symbol whose blocks are not put in
            return False

    def _with_meanings(self, left: Formula, cited: Reasons) -> tuple[Formula, Formula]:
        meant = {r.left: r.right for r in cited}
        left, right = self.equation(left)
        return with_meanings(left, meant), with_meanings(right, meant)


def with_meanings(expr, meant):
    """Definitions put in until nothing changes."""
    for _ in range(len(meant)):
        expr = expr.xreplace(meant)
    return expr
