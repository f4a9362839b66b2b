"""Stages: the assignments that a program carries out, and the chains behind them."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from .lines import Line, cited_text, idle
from .proofs import attempted
from .relations import Reasons, Relation, unfounded
from .rewriting import Contradiction
from .search import LIMITS
from .typeset import Show, latex, text
from .words import Formula, Shape, Symbols

SHOW_IT = "declare letters symmetric, or cite what shows it"


@dataclass(frozen=True)
class Solve:
    """The matrix X with X M = N, M symmetric and positive definite: N M^-1.

    It stands for a factorisation of M, from one triangle; the inverse is never formed.
    That M is symmetric must follow where the stage stands; that it is definite is seen
    when it is factored.
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
    """One assignment of a program, at symbolic sizes.

    Attributes
    ----------
    target : MatrixSymbol
    formula : MatrixExpr or Solve
        In terms of the derivation's `given` and of earlier targets.
    equation : str
        Its number where it is published, e.g. "(29)".
    symmetric : bool
        The target is symmetric, and a program should keep it so: rounding that is
        not symmetric grows from step to step.  That the formula is symmetric must
        follow from symmetric letters, from earlier stages and from `by`.
    by : tuple of Relation or Chain
        What justifies it: target = formula, and the symmetry that is claimed, must
        follow from these and need them all.

    Examples
    --------
    >>> from matrixproof import Relation, letters
    >>> A, B, S = letters("A:n*n B:n*n S:n*n")
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

    def complaints(
        self, symmetric: Symbols = (), made: Iterable[Relation] = ()
    ) -> list[str]:
        """Why the stage is not what its reasons prove; [] if it is.

        The target is used as one of the symmetric symbols only if its formula is shown
        to be symmetric.  `made` is what earlier stages assign, target = formula.
        """
        if not self.by:
            return [f"nothing proves {self.shown(text)}"]
        known, made = tuple(s for s in symmetric if s != self.target), tuple(made)
        declared = self.symmetric or self.target in symmetric
        turned = declared and self.turned(self.expression, self.reasons, known, made)
        here = (*known, self.target) if turned else known
        found = unfounded(self.reasons, here)
        if self.symmetric and not turned:
            found.append(
                f"is kept as symmetric, and nothing shows that it is: {SHOW_IT}"
            )
        solved = self.formula.M if isinstance(self.formula, Solve) else None
        if solved and not self.turned(solved, self.reasons, known, made):
            found.append(
                f"solves with {text(solved)} by one triangle of it, and nothing shows "
                f"that it is symmetric: {SHOW_IT}"
            )
        missing = self.line.gap(self.target, self.reasons, here)
        if missing is not None:
            sources = " and ".join(map(cited_text, self.reasons))
            found.append(f"does not follow from {sources}: {missing}")
        if not found:
            found = self._spare(turned, solved, known, made)
            found += self.line.vacuous(self.target, here)
        return [f"{self.shown(text)} {complaint}" for complaint in found]

    def _spare(self, turned, solved, known, made):
        """A complaint for each reason that neither formula nor symmetry needs."""

        def holds(others):
            same = turned and self.turned(self.expression, others, known, made)
            here = (*known, self.target) if same else known
            return (
                (same or not self.symmetric)
                and (not solved or self.turned(solved, others, known, made))
                and self.line.follows(self.target, others, here)
            )

        return [f"does not need {cited_text(r)}" for r in idle(self.reasons, holds)]

    @staticmethod
    def turned(
        expr: Formula, reasons: Reasons, symmetric: Symbols, made: Reasons
    ) -> bool:
        """Whether a matrix is its own transpose, as computed or by the reasons."""
        if expr in symmetric:
            return True
        needed, symmetric = behind(expr, made), tuple(symmetric)
        return shown_turned(expr, needed, symmetric) or shown_turned(
            expr, (*reasons, *needed), symmetric
        )

    @property
    def line(self) -> Line:
        """The stage as a line of a chain that begins with its target."""
        return Line(self.expression, self.reasons)

    def shown(self, show: Show) -> str:
        """The assignment, set by `show`: `latex` or `text`."""
        return f"{show(self.target)} = {show(self.expression)}"

    def __str__(self):
        return f"{self.shown(text)}  {self.equation}".rstrip()

    __repr__ = __str__

    def _repr_latex_(self):
        tag = rf" \qquad \text{{{self.equation}}}" if self.equation else ""
        return f"$\\displaystyle {self.shown(latex)}{tag}$"


def faults(stages: Iterable[Stage], given: Symbols, symmetric: Symbols) -> list[str]:
    """What is wrong with a stage list, stage by stage."""
    stages = tuple(stages)
    targets = {stage.target for stage in stages}
    known = [s for s in symmetric if s not in targets]
    ready, found = set(given), list[str]()
    made: list[Relation] = []
    for stage in stages:
        name, e = stage.target, stage.expression
        if early := sorted({text(s) for s in e.atoms(sp.MatrixSymbol) - ready}):
            found.append(
                f"{stage.shown(text)} reads {', '.join(early)}, which is not given and "
                "not assigned by an earlier stage"
            )
        if name in ready:
            found.append(f"{text(name)} is there before {stage.shown(text)}")
        declared = stage.symmetric or name in symmetric
        wrong = stage.complaints((*known, name) if declared else known, made)
        found += wrong
        if (
            declared
            and not wrong
            and stage.turned(e, stage.reasons, known, tuple(made))
        ):
            known.append(name)
        ready.add(name)
        if not isinstance(e, sp.BlockMatrix):
            made.append(Relation(f"{text(name)} as computed", name, e))
    return found


@lru_cache(maxsize=256)
def shown_turned(expr: Formula, cited: Reasons, symmetric: tuple) -> bool:
    """Whether what is cited shows that a matrix is its own transpose.

    It is nearly always true where it is asked, so no model is sought that denies it.
    """
    try:
        proof = attempted(expr.T, expr, cited, symmetric, LIMITS[:2])[0]
    except Contradiction:
        return False
    return proof is not None and proof.check()


def behind(expr: Formula, made: Reasons) -> Reasons:
    """Those of the assignments that an expression rests on."""
    reached, needed = expr.atoms(sp.MatrixSymbol), []
    for relation in reversed(made):
        if relation.left in reached:
            needed.append(relation)
            reached |= relation.right.atoms(sp.MatrixSymbol)
    return tuple(needed)
