"""Lines that do something to the line before: differentiate, transpose.

The lines that follow go on from the result.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import sympy as sp

from .blocks import Blocks
from .core import Algebra
from .dependence import Scope, letters
from .lines import Line
from .polynomials import Traces
from .reasons import cited_text, words
from .symbols import MatrixSymbol, Symmetric
from .typeset import Show, latex, text
from .words import Formula, Symbols, kept, plain


@dataclass(frozen=True, eq=False)
class Operator(Line):
    """A line whose right side is what an operation makes of the line before."""

    sign: ClassVar[str] = "="

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        try:
            value = self.applied(left, symmetric)
        except (TypeError, ValueError) as e:
            return [f"cannot be worked out: {e}"]
        return super().complaints(value, symmetric)

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        """The result of the operation, by the algebra's own rules."""
        raise NotImplementedError

    def hidden(self, left: Formula, scope: Scope) -> list[str]:
        """What the line takes for constant, and what says in a scope that it is not."""
        return []

    def constants(self, left: Formula) -> frozenset:
        """The letters that are not random on the whole page, if the line is right."""
        return frozenset()

    def head(self, show: Show) -> str:
        before, after = self.marks(show)
        dots = r"\,\cdot\," if show is latex else "·"
        return f"{before}[{dots}]{after}"

    def marks(self, show: Show) -> tuple[str, str]:
        """What stands before and after the brackets."""
        raise NotImplementedError


class Transposed(Operator):
    """The transpose of the line before.

    >>> from matrixproof import MatrixSymbol
    >>> A, B = MatrixSymbol("A", 2, 2), MatrixSymbol("B", 2, 2)
    >>> Transposed(B.T * A.T).complaints(A * B, ())
    []
    """

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        return Algebra(symmetric).normal(left).T.as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return "", "'"


@dataclass(frozen=True, eq=False)
class Derivative(Operator):
    """What gradients and differentials share: letters that move, and others held.

    Parameters
    ----------
    held : tuple of symbol
        Letters that a relation ties to what moves, and that are constant all the same,
        as a multiplier is.  The line says so.
    """

    held: tuple = ()

    @property
    def moving(self) -> frozenset:
        """The letters that move."""
        raise NotImplementedError

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        for x in letters(plain(left)) - self.moving:
            if text(x) in map(text, self.moving):
                return [f"{text(x)} is another letter than {text(x)} that moves"]
        return super().complaints(left, symmetric)

    def hidden(self, left: Formula, scope: Scope) -> list[str]:
        tied = scope.tied(self.moving)
        return [
            f"takes {text(x)} for constant, which {cited_text(tied[x])} ties to "
            f"{' and '.join(sorted(map(text, self.moving)))}: put that in first, or "
            "say that it is held"
            for x in sorted(letters(plain(left)) & set(tied) - set(self.held), key=str)
        ]

    def reason(self, show: Show) -> str:
        said = super().reason(show)
        if not self.held:
            return said
        word = words if show is latex else str
        mine = ", ".join(map(show, self.held)) + word(" held")
        return f"{said}, {mine}" if said else mine


@dataclass(frozen=True, eq=False)
class Gradient(Derivative):
    r"""The gradient of a scalar in a matrix: g with d scalar = tr(g' dX).

    Parameters
    ----------
    of : MatrixSymbol or Symbol
        In what the scalar is differentiated; the gradient in a symmetric symbol is
        symmetric.  In a number it is the derivative, of a scalar without traces.
    held : tuple of symbol
        Letters that are constant although a relation ties them to `of`.

    Examples
    --------
    >>> from sympy import Trace
    >>> from matrixproof import MatrixSymbol
    >>> A, X = MatrixSymbol("A", 2, 2), MatrixSymbol("X", 2, 2)
    >>> Gradient(A.T, of=X).complaints(Trace(A * X), ())
    []
    >>> print(*Gradient(A, of=X).complaints(Trace(A * X), ()))  # doctest: +ELLIPSIS
    does not follow: what is left over is ...
    >>> from sympy import Symbol
    >>> t = Symbol("t")
    >>> Gradient(2 * t - 1 / t**2, of=t).complaints(t**2 + 1 / t, ())
    []

    It knows that d log det M = tr(M^-1 dM).

    >>> from sympy import Determinant, log
    >>> Gradient(X.T.I, of=X).complaints(log(Determinant(X)), ())
    []

    What it cannot differentiate is refused.

    >>> print(*Gradient(0 * X, of=X).complaints(Determinant(X), ()))
    cannot be worked out: the derivative of det(X) is not known here
    """

    of: Formula = None

    @property
    def moving(self) -> frozenset:
        return frozenset([self.of])

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        algebra = Algebra(symmetric)
        left, inverses = as_traces(left, algebra)
        value = algebra.normal(left)
        if not isinstance(value, Traces):
            raise TypeError("only a scalar has a gradient")
        refuse_functions(value, "the derivative")
        if isinstance(self.of, sp.Symbol):
            if value.atoms():
                raise TypeError("a scalar with traces has a gradient in a matrix only")
            found = sp.diff(plain(left), self.of)
            if self.of.is_integer:
                raise TypeError(f"{self.of} is a whole number, and does not move")
            if found.has(sp.Derivative, sp.Subs):
                raise TypeError(f"the derivative of {left} is not known here")
            return found
        found = value.algebra.gradient(value, self.of).as_expr()
        return plain(found).xreplace(inverses)

    def marks(self, show: Show) -> tuple[str, str]:
        d, latex_d = "∂", r"\partial "
        if isinstance(self.of, sp.Symbol):
            d, latex_d = "d", r"\mathrm{d}"
        if show is latex:
            return rf"\frac{{{latex_d.strip()}}}{{{latex_d}{latex(self.of)}}}", ""
        return f"{d}/{d}{text(self.of)} ", ""


@dataclass(frozen=True, eq=False)
class Differential(Derivative):
    """The first differential.

    Parameters
    ----------
    of : dict of MatrixSymbol to MatrixSymbol
        What moves, and the symbol of its increment.
    held : tuple of symbol
        Letters that are constant although a relation ties them to what moves.

    Examples
    --------
    >>> from matrixproof import MatrixSymbol
    >>> A, X, dX = (MatrixSymbol(name, 2, 2) for name in ("A", "X", "dX"))
    >>> Differential(-X.I * dX * X.I * A, of={X: dX}).complaints(X.I * A, ())
    []
    """

    of: dict = field(default_factory=dict)

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "of", kept(self.of))

    @property
    def moving(self) -> frozenset:
        return frozenset(self.of)

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        algebra = Algebra(symmetric)
        value = algebra.normal(left)
        refuse_functions(value, "the differential", self.of)
        increments = tuple(self.of.values())
        if len(set(increments)) < len(increments) or self.moving & set(increments):
            raise ValueError("an increment has a letter of its own")
        for moved, increment in self.of.items():
            if moved in algebra.symmetric and increment not in algebra.symmetric:
                raise ValueError(
                    f"{text(moved)} is symmetric and its increment {text(increment)} "
                    "is not: declare that symmetric, too"
                )
        return algebra.differential(value, self.of).as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return (r"\mathrm{d}" if show is latex else "d"), ""


def as_traces(scalar, algebra):
    """What has the gradient of a scalar: tr(W M) for log det M, and {W: M^-1}."""
    scalar, inverses = plain(scalar), {}
    for term in sorted(scalar.atoms(sp.log), key=str):
        if isinstance(term.args[0], sp.Determinant):
            M = term.args[0].arg
            same = not algebra.normal(M - M.T).terms
            made = Symmetric if same else MatrixSymbol
            W = made(f"inverse {len(inverses) + 1}", *M.shape)
            inverses[W] = M.I
            scalar = scalar.xreplace({term: sp.Trace(W * M)})
    return scalar, inverses


def refuse_functions(value, what, numbers=()):
    """Raise for a coefficient that is a function of matrices, or of given numbers."""
    entries = sum(value.entries, ()) if isinstance(value, Blocks) else (value,)
    for entry in entries:
        for c in entry.terms.values():
            inside = sp.sympify(c).atoms(sp.MatrixSymbol, sp.Symbol)
            if any(isinstance(x, sp.MatrixSymbol) or x in numbers for x in inside):
                raise TypeError(f"{what} of {text(c)} is not known here")
