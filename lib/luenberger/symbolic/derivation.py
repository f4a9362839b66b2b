"""What a derivation is made of: formulas, claims and the stage list.

A module's `derive()` returns a `Derivation`: the formulas a method defines, the
claims that were proved about them, and the ordered list of small assignments
(the *stage list*) that the kernels compile.
"""

from dataclasses import dataclass, field

import sympy as sp

from .typeset import latex, padded, text


@dataclass(frozen=True)
class Solve:
    """The matrix X with X M = N, M symmetric and positive definite: N M^-1.

    Kernels lower it to a factorisation of M and never form the inverse.
    """

    N: sp.MatrixExpr
    M: sp.MatrixExpr

    @property
    def shape(self):
        return self.N.shape[0], self.M.shape[0]

    def as_inverse(self):
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
    """

    target: sp.MatrixSymbol
    formula: object
    equation: str = ""
    symmetric: bool = False

    def shown(self, show):
        """The assignment, set by `show`: `latex` or `text`."""
        formula = self.formula
        formula = formula.as_inverse() if isinstance(formula, Solve) else formula
        return f"{show(self.target)} = {show(formula)}"

    def __str__(self):
        return f"{self.shown(text)}  {self.equation}".rstrip()

    __repr__ = __str__

    def _repr_latex_(self):
        tag = rf" \qquad \text{{{self.equation}}}" if self.equation else ""
        return f"$\\displaystyle {self.shown(latex)}{tag}$"


@dataclass(frozen=True, repr=False)
class Derivation:
    """Formulas for one method, with the proof of what is claimed of them.

    Attributes
    ----------
    given : tuple of MatrixSymbol
        What the stages need, by name.
    stages : tuple of Stage
        The assignments that the kernels compile, in order.
    formulas : dict of str to expression
        Every definition, in page order; the key begins with the paper's equation
        number where there is one, e.g. "(25) T".
    steps : dict of str to residual
        Every claim: an object that must be zero.  The key states the claim in
        words and begins with the equation number, e.g. "(13) P T + V H = I".
    source : str
        Where the result is published.
    """

    given: tuple = ()
    stages: tuple = ()
    formulas: dict = field(default_factory=dict)
    steps: dict = field(default_factory=dict)
    source: str = ""

    def __str__(self):
        rows = [(stage.shown(text), stage.equation) for stage in self.stages]
        wide = max((len(row) for row, _ in rows), default=0)
        lines = [f"  {padded(row, wide)}  {number}".rstrip() for row, number in rows]
        ending = f"{len(self.formulas)} formulas, {len(self.steps)} claims"
        return "\n".join([self.source or "Our own", *lines, f"  {ending}"])

    __repr__ = __str__

    def _repr_latex_(self):
        if not self.stages:
            return None
        rows = (
            stage.shown(latex).replace(" = ", " &= ", 1)
            + (rf" && \text{{{stage.equation}}}" if stage.equation else "")
            for stage in self.stages
        )
        body = r" \\[2pt] ".join(rows)
        return rf"$$\begin{{aligned}} {body} \end{{aligned}}$$"

    def unfolded(self, keep=()):
        """Every target, by name, in terms of `given` and of the targets in `keep`."""
        known = {}
        for stage in self.stages:
            formula = stage.formula
            if isinstance(formula, Solve):
                formula = formula.as_inverse()
            known[stage.target] = formula.xreplace(
                {s: value for s, value in known.items() if s.name not in keep}
            )
        return {target.name: formula for target, formula in known.items()}

    def unproved(self):
        """Names of the steps that do not come out as zero."""
        return [name for name, residual in self.steps.items() if not vanishes(residual)]

    def proved(self):
        """True if there are steps and every one of them is zero."""
        return bool(self.steps) and not self.unproved()


def vanishes(residual):
    """Whether a residual is identically zero.

    Accepts the normal forms of this room, explicit SymPy matrices and scalars.
    """
    if isinstance(residual, sp.MatrixBase):  # whose is_zero is about something else
        return all(sp.simplify(entry) == 0 for entry in residual)
    known = getattr(residual, "is_zero", None)
    if isinstance(known, bool):
        return known
    return sp.simplify(residual) == 0


def named(derivation):
    """The symbols of a stage list by name."""
    targets = (stage.target for stage in derivation.stages)
    return {s.name: s for s in (*derivation.given, *targets)}
