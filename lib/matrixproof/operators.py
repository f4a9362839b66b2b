"""Lines that do something to the line before: differentiate, transpose, average.

The lines that follow go on from the result.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import sympy as sp

from .algebra import Algebra, Blocks, Polynomial, Traces
from .dependence import Scope, letters
from .families import over, renamed, sums
from .lines import Line, cited_text, worded
from .page_model import impossible
from .relations import Moment, Reasons, named
from .symbols import MatrixSymbol, Member, Symmetric, first
from .typeset import Show, latex, text
from .words import Formula, Symbols, kept, plain, rotations


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
    """The transpose of the line before."""

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        return Algebra(symmetric).normal(left).T.as_expr()

    def marks(self, show: Show) -> tuple[str, str]:
        return "", "'"


@dataclass(frozen=True, eq=False)
class Derivative(Operator):
    """What gradients and differentials share: letters that move, and others held.

    `held` are letters that a relation ties to what moves, and that are constant all the
    same, as a multiplier is.  The line says so.
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
        here = {first(x) for x in letters(plain(left))}
        return [
            f"takes {text(x)} for constant, which {cited_text(tied[x])} ties to "
            f"{' and '.join(sorted(map(text, self.moving)))}: put that in first, or "
            "say that it is held"
            for x in sorted(here & set(tied) - set(self.held), key=str)
        ]

    def reason(self, show: Show) -> str:
        said = super().reason(show)
        if not self.held:
            return said
        mine = ", ".join(map(show, self.held)) + worded(" held", show)
        return f"{said}, {mine}" if said else mine


@dataclass(frozen=True, eq=False)
class Gradient(Derivative):
    r"""The gradient of a scalar in a matrix: g with d scalar = tr(g' dX).

    It knows that d log det M = tr(M^-1 dM).  What it cannot differentiate is refused.

    Parameters
    ----------
    of : MatrixSymbol or Symbol
        In what the scalar is differentiated; the gradient in a symmetric symbol is
        symmetric.  In a number it is the derivative, of a scalar without traces.
    held : tuple of symbol
        Letters that are constant although a relation ties them to `of`.

    Examples
    --------
    >>> from sympy import Determinant, Trace, log
    >>> from matrixproof import letters
    >>> A, X, t = letters("A:n*n X:n*n t")
    >>> Gradient(A.T, of=X).complaints(Trace(A * X), ())
    []
    >>> print(*Gradient(A, of=X).complaints(Trace(A * X), ()))  # doctest: +ELLIPSIS
    does not follow: what is left over is ...
    >>> Gradient(2 * t - 1 / t**2, of=t).complaints(t**2 + 1 / t, ())
    []
    >>> Gradient(X.T.I, of=X).complaints(log(Determinant(X)), ())
    []
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

    `of` is {what moves: its increment}, both letters.

    >>> from matrixproof import letters
    >>> A, X, dX = letters("A:n*n X:n*n dX:n*n")
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
    >>> from matrixproof import letters
    >>> F, P, Q, e, w = letters("F:n*n P:n*n Q:n*n e:n w:n")
    >>> white = (w * w.T, Q), (e * e.T, P), (e * w.T, 0 * Q)
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
        return found or impossible(self.cites, symmetric)

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        moments = Moments(self.moments, symmetric)
        if {first(x) for x in letters(plain(self.right))} & moments.random:
            raise ValueError("the right side still has a random symbol")
        return moments.expectation(left).as_expr()

    def constants(self, left: Formula) -> frozenset:
        """The letters that the line takes for constant."""
        inside = letters(plain(left)) | letters(plain(self.right))
        return frozenset(map(first, inside)) - self.random

    @property
    def random(self) -> frozenset:
        """The letters of its moments."""
        return frozenset().union(*(letters(plain(r.left)) for r in self.moments))

    def hidden(self, left: Formula, scope: Scope) -> list[str]:
        found, known = [], scope.not_constant
        for x in sorted(self.constants(left), key=str):
            if x in scope.random:
                why, mend = scope.random[x].show(text), "give its moments"
            elif x in known:
                why, mend = cited_text(known[x]), "put that in first"
            else:
                continue
            found.append(
                f"takes {text(x)} for constant, which is random by {why}: {mend}"
            )
        return found

    def marks(self, show: Show) -> tuple[str, str]:
        return (r"\mathrm{E}" if show is latex else "E"), ""

    def reasons(self, show: Show) -> list[str]:
        return [*(r.show(show) for r in self.moments), *super().reasons(show)]


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
        self.random = {first(x.atom) for word in self.known for x in word}

    def expectation(self, expr):
        """The normal form of E[expr]."""
        value = self.algebra.normal(expr)
        refuse_functions(value, "the expectation")
        scalar = isinstance(value, Traces)
        total = Traces(self.algebra, []) if scalar else value.like([])
        for word, c in value.terms.items():
            word, c = self._alike(self._turned(word) if scalar else word, c)
            if not word:
                part = value.like([((), 1)])
            else:
                part = self._of(word).trace() if scalar else self._of(word)
            total = total + c * part
        return total

    def _alike(self, word, c):
        """Of the sums over two members that are apart, the terms in which they are one.

        The other terms vanish: that is what the moment of two different members says.
        """
        pair = [word[i] for i in self._places(word)]
        if len(pair) != 2 or pair[0].atom == pair[1].atom:
            return word, c
        x, y = (z.atom for z in pair)
        if not all(isinstance(z, Member) and over(z.index) in sums(c) for z in (x, y)):
            return word, c
        if x.index == y.index:
            return word, c
        apart = self.known.get(tuple(pair))
        if apart is None or not apart[1].is_zero:
            said = text(self._product(tuple(pair)).as_expr())
            raise ValueError(f"it is not among the moments that E[{said}] = 0")
        self.seen.append(apart[0])
        return renamed(word, {y.index: x.index}), sp.cancel(c / over(y.index))

    def _turned(self, word):
        """A rotation of the word in which the random factors are neighbours."""
        at = [w for w in rotations(word) if self._places(w)[-1:] == [len(w) - 1]]
        return next((w for w in at if self._places(w)[0] == len(w) - 2), word)

    def _places(self, word):
        return [i for i, x in enumerate(word) if first(x.atom) in self.random]

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
