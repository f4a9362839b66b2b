"""Calculational chains: a derivation line by line, each checked against its reasons.

    start
      = next line         reason: the relations cited, and nothing else
      = ...

as `calc` in Lean and `also ... finally` in Isabelle.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy as sp

from .contents import parts
from .dependence import behind, declared, hidden
from .dependence import letters as inside
from .lines import WIDEST_REASON, AtLeast, Equation, Implies, Line
from .operators import Derivative, Operator
from .page_model import impossible
from .relations import Reasons, Relation, Result, equation, under, unfounded
from .symbols import Symmetric
from .typeset import Show, columns, latex, padded, text
from .words import Formula, Symbols, Values, kept, plain

if TYPE_CHECKING:
    from .instances import Instance

TYPED = "inserted"  # how a derivation says that a line was not found but typed


@dataclass(frozen=True, repr=False)
class Foundation:
    """What a theorem or a page rests on, through all the chains that it cites."""

    relations: tuple = ()  # definitions, hypotheses and moments: what no chain proves
    invertible: tuple = ()  # in a formula, or to find a solution
    symmetric: tuple = ()  # letters that must equal their transposes
    held: tuple = ()  # letters that are constant although a relation ties them
    inserted: tuple = ()  # (title, line): what was typed and not found

    def said(self, show: Show) -> list[str]:
        """Each thing, set by `latex` or `text`."""
        found = [r.stated(show) for r in self.relations]
        for letters, word in (
            (self.invertible, "can be inverted"),
            (self.symmetric, "is symmetric"),
            (self.held, "is held constant"),
        ):
            said = rf"\text{{ {word}}}" if show is latex else f" {word}"
            found += [show(x) + said for x in letters]
        word = r"\text{Inserted }" if show is latex else "Inserted "
        return found + [f"{word}{x.sign} {x.body(show)}" for _, x in self.inserted]

    def __str__(self):
        return "\n".join(self.said(text)) or "nothing"

    __repr__ = __str__

    def _repr_markdown_(self):
        return "\n".join(f"- ${x}$" for x in self.said(latex)) or "nothing"


def chains_behind(chains: Iterable[Any]) -> Iterator[Any]:
    """Chains, and those whose results they cite, each once."""
    waiting, seen = list(chains), set()
    while waiting:
        chain = waiting.pop(0)
        if id(chain) not in seen:
            seen.add(id(chain))
            yield chain
            waiting += [r.chain for r in chain.relations if isinstance(r, Result)]
            waiting += [x for line in chain.lines for x in proved_by(line)]


def proved_by(line):
    """The base and the step of an induction; nothing, of other lines."""
    both = getattr(line, "base", None), getattr(line, "step", None)
    return [chain for chain in both if chain is not None]


def foundation(chains: Iterable[Any], cited: Iterable[Relation] = ()) -> Foundation:
    """What chains rest on, and stages that cite these relations."""
    chains, cited = list(chains), list(cited)
    every = list(
        chains_behind([*chains, *(r.chain for r in cited if isinstance(r, Result))])
    )
    relations = [r for r in cited if not isinstance(r, Result)]
    relations += [r for c in every for r in c.relations if not isinstance(r, Result)]
    shown = [line.statement for c in every for line in c.lines if proved_by(line)]
    relations = [r for r in relations if r not in shown]
    expressions = [e for chain in every for e in chain.expressions]
    expressions += [e for r in relations for e in r.expressions]
    inverted = [x for e in expressions for x in parts(plain(e)).inverted]
    inverted += [x for r in relations for x in getattr(r, "invertible", ())]
    inverted += [x for e in expressions for x in divisors(plain(e))]
    symmetric = [x for chain in chains for x in needed(chain)]
    lines = [(chain.title, line) for chain in every for line in chain.lines]
    held = [x for _, line in lines for x in getattr(line, "held", ())]
    inserted = [(title, x) for title, x in lines if TYPED in x.why]
    found = relations, inverted, symmetric, held, inserted
    return Foundation(*(tuple(dict.fromkeys(x)) for x in found))


def divisors(expr):
    """What numbers are divided by, where that may be zero."""
    powers = [x for x in expr.atoms(sp.Pow) if x.exp.is_negative]
    return sorted({x.base for x in powers if x.base.is_zero is not False}, key=str)


def needed(chain):
    """The letters that a chain takes to be symmetric, and does not hold without."""
    spare: tuple = ()
    for x in chain.supposes:
        if chain.holds_without(*spare, x):
            spare += (x,)
    kinds = [x for x in declared((), chain.expressions) if isinstance(x, Symmetric)]
    return [*(x for x in chain.supposes if x not in spare), *kinds]


CHECKED, FAILED = "✓", "✗"
LATEX_MARKS = {CHECKED: r"\checkmark", "(✓)": r"(\checkmark)", FAILED: r"\times"}


class Row(NamedTuple):
    """A line of a chain as it is set."""

    left: str
    sign: str
    right: str
    reason: str = ""
    pieces: tuple = ()
    follows: bool = True


class Shown:
    """What has a number and words, is checked, and is shown with what is wrong."""

    number: str
    says: str
    _faults: Any

    @property
    def title(self) -> str:
        """Its number and what it says."""
        return under(self.number, self.says)

    def check(self) -> list[str]:
        """What is wrong; [] when it is as it says."""
        return list(self._faults)

    @property
    def mark(self) -> str:
        """✓ or ✗."""
        return FAILED if self.check() else CHECKED

    def _as_text(self):
        """Its lines in Unicode, under the title."""
        raise NotImplementedError

    def _as_latex(self):
        """Its rows in LaTeX, between the columns of which stands &."""
        raise NotImplementedError

    def __str__(self):
        faults = (f"  {fault}" for fault in self.check())
        return "\n".join([*filter(None, [self.title]), *self._as_text(), *faults])

    def __repr__(self):
        return str(self)

    def _repr_latex_(self):
        return framed(self._as_latex(), self.number)


@dataclass(frozen=True, eq=False, repr=False)
class Chain(Shown):
    r"""A derivation that reads from top to bottom.

    Parameters
    ----------
    number : str
        The number of the equation, e.g. "27–29"; empty if it has none.
    says : str
        What the chain shows, in a few words.
    left : expression or Equation
        What it begins with.
    lines : sequence of Line
        `Line` says that the line before is equal to this one, for the reasons cited;
        the other kinds of line differentiate, average, drop a square, and so on.
        After an `Equation` every line is an `Implies` or an `Iff`.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose.
    witness : dict of symbol to matrix or number, optional
        As for a `Derivation`, where no model of all that is cited is found without it.

    Notes
    -----
    A chain never changes, so it is checked once.  A line is checked against what it
    cites and nothing else: without one of its reasons it must fail, a model of them is
    found, and the line is true there.  What all lines cite has one model, too.

    Examples
    --------
    >>> from matrixproof import Relation, letters
    >>> A, B, S = letters("A:n*n B:n*n S:n*n")
    >>> meant = Relation("S = A + B", S, A + B)
    >>> chain = Chain("2", "a product", A * S, [
    ...     Line(A * (A + B), by=[meant]),
    ...     Line(A * A + A * B, why="multiply out"),
    ... ])
    >>> chain.check()
    []
    >>> print(chain)
    (2) a product
      A S
        = A (A + B)  S = A + B     ✓
        = A A + A B  multiply out  ✓
    >>> Chain("", "wrong", A * B, [Line(B * A)]).check()[0]  # doctest: +ELLIPSIS
    'line 1 does not follow: what is left over is ...; with A = ...'
    """

    number: str
    says: str
    left: Formula
    lines: tuple
    symmetric: tuple = ()
    witness: Values = field(default_factory=dict)

    def __post_init__(self):
        if isinstance(self.lines, Line):
            raise TypeError("lines are given in a list, also a single one: [Line(...)]")
        object.__setattr__(self, "lines", tuple(self.lines))
        object.__setattr__(self, "witness", kept(self.witness))
        object.__setattr__(self, "symmetric", tuple(self.symmetric))
        stated = isinstance(self.left, Equation)
        for k, line in enumerate(self.lines, 1):
            if not isinstance(line, Line) or isinstance(line, Implies) != stated:
                wanted = "Implies or Iff" if stated else "Line"
                start = type(self.left).__name__
                mend = f"what begins with {start} goes on with {wanted}"
                if isinstance(line, list | tuple):
                    mend = "write its lines one after the other"
                kind = type(line).__name__
                raise TypeError(
                    f"line {k} of chain ({self.number}) is a {kind}; {mend}"
                )
        bounded = False
        for k, line in enumerate(self.lines, 1):
            bounded = bounded or isinstance(line, AtLeast)
            if bounded and isinstance(line, Derivative):
                raise ValueError(
                    f"line {k} of chain ({self.number}) {self.says} differentiates a "
                    "bound, which says nothing of the derivative of what is bounded"
                )
        signs = {line.sign for line in self.lines if isinstance(line, AtLeast)}
        if len(signs) > 1:
            raise ValueError(
                f"chain ({self.number}) {self.says} goes up and down, so it says "
                f"nothing of its ends: write one chain for ≥ and another for ≤"
            )

    @property
    def right(self) -> Formula:
        """Where the chain ends."""
        return self.lines[-1].right if self.lines else self.left

    @property
    def ends(self) -> tuple[Formula, ...]:
        """What it begins and ends with; both sides of an equation."""
        sides = self.left, self.right
        return tuple(
            plain(e) for side in sides for e in getattr(side, "expressions", (side,))
        )

    @property
    def relations(self) -> Reasons:
        """Everything cited, each once, in order."""
        return tuple(dict.fromkeys(r for line in self.lines for r in line.cites))

    @property
    def equates(self) -> bool:
        """Whether it proves that its two ends are equal."""
        kinds = Operator, AtLeast
        return not self._stated and not any(isinstance(x, kinds) for x in self.lines)

    @cached_property
    def relation(self) -> Relation:
        """What the chain has proved, for a later chain or a stage to cite."""
        if not self.equates:
            raise TypeError(f"chain ({self.number}) {self.says} proves no equality")
        says = equation(self.left, self.right)
        if columns(says) > WIDEST_REASON:
            says = self.says
        return Result(under(self.number, says), self.left, self.right, self)

    @cached_property
    def supposes(self) -> Symbols:
        """The symbols of its formulas that it takes to equal their transposes.

        Those of the chains behind what it cites are among them.
        """
        found = {
            x for e in self.expressions for x in sp.sympify(e).atoms(sp.MatrixSymbol)
        }
        cited = (r.chain for r in self.relations if isinstance(r, Result))
        found |= {x for chain in cited for x in chain.supposes}
        return tuple(x for x in self.symmetric if x in found)

    def holds_without(self, *symbols: sp.MatrixSymbol) -> bool:
        """Whether every line follows where these symbols need not be symmetric."""
        kept = tuple(x for x in self.symmetric if x not in symbols)
        if kept not in self._weaker:
            self._weaker[kept] = not replace(self, symmetric=kept).check()
        return self._weaker[kept]

    @cached_property
    def _weaker(self):
        """Whether it holds with fewer symmetric symbols, by what is left of them."""
        return {}

    @property
    def expressions(self) -> list[Formula]:
        """Every expression in it."""
        sides = (self.left, *(line.right for line in self.lines), *self.relations)
        return [e for side in sides for e in getattr(side, "expressions", (side,))]

    def check(self) -> list[str]:
        """What is wrong, line by line; [] when every line follows as it says."""
        return [
            f"line {k} {fault}"
            for k, faults in enumerate(self._faults, 1)
            for fault in faults
        ]

    @cached_property
    def _faults(self):
        """The faults of each line."""
        before = (self.left, *(line.right for line in self.lines))
        constant = hidden([self])[self]
        found = [
            self._complaints(line, left) + constant.get(k, [])
            for k, (left, line) in enumerate(zip(before, self.lines), 1)
        ]
        if found and not any(found):
            found[-1] += self._without_model()
        return found

    def _complaints(self, line, left):
        """What is wrong with a line; one that cannot even be read says so."""
        try:
            found = unfounded(line.cites, self._known)
            return found + line.complaints(left, self._known) + self.too_wide(line)
        except (TypeError, ValueError) as e:
            return [f"cannot be checked: {e}"]

    def too_wide(self, line: Line) -> list[str]:
        """A complaint if a line that is shown does not fit on a page."""
        return line.too_wide()

    def _without_model(self):
        """A complaint if what its lines cite cannot all hold at once."""
        relations = tuple(dict.fromkeys(behind(self.relations)))
        inverted = any(parts(plain(e)).inverted for e in self.expressions)
        if not inverted and any(set(relations) <= set(x.cites) for x in self.lines):
            return []  # which has a model
        return impossible(relations, self._known, self.expressions, self.witness)

    @cached_property
    def _known(self):
        """The symbols that equal their transposes: those told, and those made so."""
        return declared(self.symmetric, self.expressions)

    # -- used ---------------------------------------------------------------------

    def rests_on(self) -> Foundation:
        """What the chain rests on, through every chain that it cites.

        >>> from matrixproof import derive, letters
        >>> K, M, N, W, X = letters("K:n*p M:p*p N:n*p W:n*n X:n*n")
        >>> gain = derive(2 * W * (K * M - N)).solve(K)
        >>> derive(X * X.I * K * M).use(gain).rests_on()
        K M = N, if W can be inverted
        X can be inverted
        W can be inverted
        """
        return foundation([self])

    def at(
        self,
        letters: Mapping[Any, Any],
        *given: Any,
        number: str = "",
        says: str = "",
        symmetric: Symbols = (),
        **named: Any,
    ) -> Instance:
        """The theorem in other letters, which is checked anew.

        Parameters
        ----------
        letters : dict of letter to expression, or of size to size
            What the letters of the theorem stand for, or else themselves.  Sizes follow
            from the letters.
        *given : Relation or Chain
            What the theorem supposes, in these letters.  What becomes an identity
            need not be given.
        number, says : str
            Of the instance.  Without words it says what the theorem does.
        symmetric : iterable of MatrixSymbol
            Letters that equal their transposes, beside those that stand for such.
        **named : expression
            What letters stand for, by their names; one that the theorem does not have
            is passed over, so that several theorems can share what is named.

        Examples
        --------
        >>> from matrixproof import Relation, derive, letters
        >>> A, B, M, N = letters("A:n*n B:n*n M:n*n N:n*n")
        >>> F, G, L = letters("F:r*r G:r*r L:r*r")
        >>> known = Relation("A M = N", A * M, N)
        >>> theorem = derive(B * A * M, says="a product").use(known)
        >>> used = Relation("F G = L", F * G, L)
        >>> print(theorem.at({}, used, A=F, B=F.T, M=G, N=L))
        a product
          F' F G
            = F' L  theorem: a product, with F G = L  ✓
        >>> theorem.at({A: F, B: F, M: G, N: L})
        Traceback (most recent call last):
            ...
        ValueError: a product rests on A M = N, which is here F G = L: give it, as in \
.at({...}, relation)
        """
        from .instances import Instance, instance

        every = [e for chain in chains_behind([self]) for e in chain.expressions]
        known = {x.name: x for e in every for x in inside(plain(e))}
        put = {known[x]: value for x, value in named.items() if x in known}
        made = instance(self, {**letters, **put}, given, tuple(symmetric))
        says = says or self.says
        return Instance(number, says, made.left, made.lines, made.symmetric, {}, self)

    # -- shown --------------------------------------------------------------------

    def _as_text(self):
        rows = [
            (f"{head} {sign} {body}".strip(), reason, FAILED if faults else CHECKED)
            for head, sign, body, _, reason, faults in self.displayed(text)
        ]
        wide = [max((columns(row[k]) for row in rows), default=0) for k in range(2)]
        yield f"  {self.start(text)}"
        for body, reason, mark in rows:
            yield f"    {padded(body, wide[0])}  {padded(reason, wide[1])}  {mark}"

    def _as_latex(self):
        for row in self.rows(latex):
            mark = LATEX_MARKS[CHECKED if row.follows else FAILED]
            rest = f"&& {row.reason} && {mark}" if row.sign else ""
            yield f"{row.left} &{row.sign} {row.right} {rest}".strip()

    def start(self, show: Show) -> str:
        """What the chain begins with, set by `latex` or `text`."""
        return self.left.show(show) if self._stated else show(self.left)

    def rows(self, show: Show) -> list[Row]:
        """The chain as it is set: a `Row` for each line.

        What it begins with stands before the first sign; before an operation, or as an
        equation, it has a row without a sign.
        """
        start, rows = self.start(show), []
        shown = self.displayed(show)
        if self._stated or (shown and shown[0][0]):  # an operation begins
            rows.append(Row("", "", start))
            start = ""
        for head, sign, body, pieces, reason, faults in shown:
            parts = start or head, sign, body, reason
            rows.append(Row(*parts, tuple(pieces), not faults))
            start = ""
        return rows

    def displayed(self, show: Show) -> list[tuple]:
        """Of each line that is shown: head, sign, body, pieces, reason, faults."""
        return [
            (
                line.head(show),
                line.latex_sign if show is latex else line.sign,
                line.body(show),
                line.pieces(show),
                line.reason(show),
                faults,
            )
            for line, faults in zip(self.lines, self._faults)
        ]

    @property
    def _stated(self):
        return isinstance(self.left, Equation)


def framed(rows, number):
    """Rows as one display with its number."""
    tag = rf" \tag{{{number}}}" if number else ""
    body = r" \\[2pt] ".join(rows)
    return rf"$$\begin{{aligned}} {body} \end{{aligned}}{tag}$$"
