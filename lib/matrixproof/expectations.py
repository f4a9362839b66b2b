"""Lines that average: an expectation by the moments of random letters."""

from dataclasses import dataclass

from .core import Algebra
from .dependence import Scope, letters
from .operators import Operator, refuse_functions
from .page_model import impossible
from .polynomials import Polynomial, Traces
from .reasons import cited_text
from .relations import Moment, Reasons, named
from .typeset import Show, latex, text
from .words import Formula, Symbols, plain, rotations


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
    >>> from matrixproof import MatrixSymbol, ZeroMatrix
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
        return found or impossible(self.cites, symmetric)

    def applied(self, left: Formula, symmetric: Symbols) -> Formula:
        moments = Moments(self.moments, symmetric)
        if letters(plain(self.right)) & moments.random:
            raise ValueError("the right side still has a random symbol")
        return moments.expectation(left).as_expr()

    def constants(self, left: Formula) -> frozenset:
        """The letters that the line takes for constant."""
        return (letters(plain(left)) | letters(plain(self.right))) - self.random

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
        refuse_functions(value, "the expectation")
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
