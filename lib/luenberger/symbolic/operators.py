"""Lines that do something to the line before: differentiate, transpose, average.

The lines that follow go on from the result.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import sympy as sp

from .core import Algebra
from .lines import Line
from .polynomials import Polynomial, Traces
from .relations import Moment, Reasons, named
from .typeset import Show, latex, text
from .words import Formula, Symbols, rotations


@dataclass(frozen=True, eq=False)
class Operator(Line):
    """A line whose right side is what an operation makes of the line before."""

    sign: ClassVar[str] = "="

    def complaints(self, left, symmetric):
        try:
            value = self.applied(left, symmetric)
        except (TypeError, ValueError) as e:
            return [f"cannot be worked out: {e}"]
        return super().complaints(value, symmetric)

    def applied(self, left, symmetric):
        """The result of the operation, by the algebra's own rules."""
        raise NotImplementedError

    def head(self, show):
        before, after = self.marks(show)
        dots = r"\,\cdot\," if show is latex else "·"
        return f"{before}[{dots}]{after}"

    def marks(self, show):
        """What stands before and after the brackets."""
        raise NotImplementedError


class Transposed(Operator):
    """The transpose of the line before.

    >>> from luenberger.symbolic import MatrixSymbol
    >>> A, B = MatrixSymbol("A", 2, 2), MatrixSymbol("B", 2, 2)
    >>> Transposed(B.T * A.T).complaints(A * B, ())
    []
    """

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        return Algebra(symmetric).normal(left).T.as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return "", "'"


@dataclass(frozen=True, eq=False)
class Gradient(Operator):
    r"""The gradient of a scalar in a matrix: g with d scalar = tr(g' dX).

    Parameters
    ----------
    of : MatrixSymbol or Symbol
        In what the scalar is differentiated; the gradient in a symmetric symbol is
        symmetric.  In a number it is the derivative, of a scalar without traces.

    Examples
    --------
    >>> from sympy import Trace
    >>> from luenberger.symbolic import MatrixSymbol
    >>> A, X = MatrixSymbol("A", 2, 2), MatrixSymbol("X", 2, 2)
    >>> Gradient(A.T, of=X).complaints(Trace(A * X), ())
    []
    >>> print(*Gradient(A, of=X).complaints(Trace(A * X), ()))  # doctest: +ELLIPSIS
    does not follow: what is left over is ...
    >>> from sympy import Symbol
    >>> t = Symbol("t")
    >>> Gradient(2 * t - 1 / t**2, of=t).complaints(t**2 + 1 / t, ())
    []
    """

    of: Formula = None

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        value = Algebra(symmetric).normal(left)
        if not isinstance(value, Traces):
            raise TypeError("only a scalar has a gradient")
        if isinstance(self.of, sp.Symbol):
            if value.atoms():
                raise TypeError("a scalar with traces has a gradient in a matrix only")
            return sp.diff(left, self.of)
        return value.algebra.gradient(value, self.of).as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        d, latex_d = "∂", r"\partial "
        if isinstance(self.of, sp.Symbol):
            d, latex_d = "d", r"\mathrm{d}"
        if show is latex:
            return rf"\frac{{{latex_d.strip()}}}{{{latex_d}{latex(self.of)}}}", ""
        return f"{d}/{d}{text(self.of)} ", ""


@dataclass(frozen=True, eq=False)
class Differential(Operator):
    """The first differential.

    Parameters
    ----------
    of : dict of MatrixSymbol to MatrixSymbol
        What moves, and the symbol of its increment.

    Examples
    --------
    >>> from luenberger.symbolic import MatrixSymbol
    >>> A, X, dX = (MatrixSymbol(name, 2, 2) for name in ("A", "X", "dX"))
    >>> Differential(-X.I * dX * X.I * A, of={X: dX}).complaints(X.I * A, ())
    []
    """

    of: dict = field(default_factory=dict)

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        return Algebra(symmetric).differential(left, self.of).as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return (r"\mathrm{d}" if show is latex else "d"), ""


@dataclass(frozen=True, eq=False)
class Expect(Operator):
    """The expectation of an expression of second degree in random symbols.

    Parameters
    ----------
    moments : tuple of Relation
        What the expectations are: ``Relation("", w * v.T, S)`` says E[w v'] = S, and
        ``Relation("", w, x)`` that E[w] = x.  Symbols that occur in no moment are not
        random.

    Examples
    --------
    >>> from sympy import symbols
    >>> from luenberger.symbolic import MatrixSymbol, ZeroMatrix
    >>> n = symbols("n", integer=True, positive=True)
    >>> F, P, Q = (MatrixSymbol(name, n, n) for name in "FPQ")
    >>> e, w = MatrixSymbol("e", n, 1), MatrixSymbol("w", n, 1)
    >>> white = (w * w.T, Q), (e * e.T, P), (e * w.T, ZeroMatrix(n, n))
    >>> line = Expect(F * P * F.T + Q, moments=white)
    >>> line.complaints((F * e + w) * (F * e + w).T, ())
    []
    >>> print(*Expect(Q, moments=white[:2]).complaints((e + w) * (e + w).T, ()))
    cannot be worked out: E[e w'] is not among the moments
    """

    moments: tuple = ()

    def __post_init__(self):
        super().__post_init__()
        known = [Moment(r.name, *r) for r in named(self.moments)]
        object.__setattr__(self, "moments", tuple(known))

    @property
    def cites(self) -> Reasons:
        return (*self.by, *self.moments)

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        found = super().complaints(left, symmetric)
        if not found:
            used = Moments(self.moments, symmetric)
            used.expectation(left)
            found = [
                f"does not need {r.show(text)}"
                for r in self.moments
                if r not in used.seen
            ]
        return found

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        moments = Moments(self.moments, symmetric)
        if Algebra().normal(self.right).atoms() & moments.random:
            raise ValueError("the right side still has a random symbol")
        return moments.expectation(left).as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return (r"\mathrm{E}" if show is latex else "E"), ""

    def reason(self, show: Show) -> str:
        mine = [r.show(show) for r in self.moments]
        rest = super().reason(show)
        joint = r",\; " if show is latex else ", "
        return joint.join([*mine, rest] if rest else mine)


class Moments:
    """First and second moments of random symbols, put in one word at a time."""

    def __init__(self, relations, symmetric):
        self.algebra, self.seen, self.known = Algebra(symmetric), [], {}
        for relation in relations:
            left = self.algebra.normal(relation.left)
            right = self.algebra.normal(relation.right)
            ((word, c),) = left.terms.items()
            if c != 1 or len(word) > 2:
                raise ValueError(f"{text(relation.left)} is not one or two symbols")
            self.known[word] = relation, right
            self.known.setdefault(self.algebra.flipped(word), (relation, right.T))
        self.random = {x.atom for word in self.known for x in word}

    def expectation(self, expr):
        """The normal form of E[expr]."""
        value = self.algebra.normal(expr)
        scalar = isinstance(value, Traces)
        total = Traces(self.algebra, []) if scalar else value.like([])
        for word, c in value.terms.items():
            if not word:
                part = value.like([((), 1)])
            elif scalar:
                part = self._of(self._turned(word)).trace()
            else:
                part = self._of(word)
            total = total + c * part
        return total

    def _turned(self, word):
        """A rotation of the word in which the random factors are neighbours."""
        at = [w for w in rotations(word) if self._places(w)[-1:] == [len(w) - 1]]
        return next((w for w in at if self._places(w)[0] == len(w) - 2), word)

    def _places(self, word):
        return [i for i, x in enumerate(word) if x.atom in self.random]

    def _of(self, word):
        places = self._places(word)
        if not places:
            return self._product(word)
        i, j = places[0], places[-1] + 1
        if len(places) > 2 or j - i > 2:
            raise ValueError(
                f"{text(self._product(word).as_expr())} is not of second degree, or "
                "its random symbols are not neighbours"
            )
        if word[i:j] not in self.known:
            missing = text(self._product(word[i:j]).as_expr())
            raise ValueError(f"E[{missing}] is not among the moments")
        relation, moment = self.known[word[i:j]]
        self.seen.append(relation)
        for x in reversed(word[:i]):
            moment = self._product((x,)) @ moment
        for x in word[j:]:
            moment = moment @ self._product((x,))
        return moment

    def _product(self, word):
        columns = word[-1].atom.shape[0 if word[-1].transposed else 1]
        shape = (word[0].rows, columns)
        return Polynomial(self.algebra, [(word, 1)], shape)
