"""A derivation: words, definitions, chains and stages, in the order of the page.

A `Page` is written statement by statement.  A derivation without a page is a *stage
list*: what a program is to compute, and why.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from textwrap import fill
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .algebra import Blocks, Sum
from .chains import Chain, Foundation, chains_behind, foundation, framed
from .dependence import behind, hidden, letters, sides
from .deriving import Derived
from .explicit import Claim, Construction, Counterexample, Explicit, Positive
from .induction import Induced
from .instances import Instance
from .lines import bare_number, numbered
from .page_model import impossible
from .proofs import Unproved
from .prose import markdown, plain
from .relations import Let, Moment, Relation, Result, Steady, named, under
from .stages import Stage, faults
from .typeset import latex, padded, text, width
from .words import Formula, refuse_truth, same_shape

# by itself
CHECKED = Chain, Derived, Instance, Construction, Counterexample, Explicit, Positive


@dataclass(frozen=True, repr=False)
class End:
    """On a page, the end of what some relations were said for.

    Everything from the first of them on is closed: what stands after this cites
    nothing of it, and no chain that rests on it.
    """

    relations: tuple
    also: tuple = ()  # what else was introduced there

    def stated(self, show: Any) -> str:
        """What is no longer supposed, as a sentence."""
        said = [r.show(show) for r in self.relations]
        said = " and ".join(f"${x}$" if show is latex else x for x in said)
        them = "it" if len(self.relations) == 1 else "them"
        rest = f", nor on what was introduced with {them}" if self.also else ""
        return f"What follows does not rest on {said}{rest}."

    def __str__(self):
        return self.stated(text)

    __repr__ = __str__


class Steps(dict):
    """What is proved, by name.

    >>> Steps({"(33) the gain": None})["(33) the gains"]
    Traceback (most recent call last):
        ...
    KeyError: "there is no step '(33) the gains'; near it are '(33) the gain'"
    """

    def __missing__(self, name):
        near = get_close_matches(str(name), self, cutoff=0.4) or [*self]
        said = ", ".join(map(repr, near))
        raise KeyError(f"there is no step {name!r}; near it are {said}")


@dataclass(frozen=True, repr=False)
class Derivation:
    """What a method rests on, in reading order, or one stage list of it.

    Attributes
    ----------
    given : tuple of MatrixSymbol
        What the stages need, by name.
    stages : tuple of Stage
        The assignments that a program carries out, in order.
    steps : dict of str to Claim, Chain, Construction or Counterexample
        What is proved, by name: what is on the page, what the stages cite, and claims
        that stand on no page.
    source : str
        Where the result is published.
    page : tuple
        Words (a formula in them stands between backquotes), relations, what is proved,
        ends of scopes and stage lists, in the order in which one reads them.
    letters : Notation
        What the symbols stand for.
    says : str
        What a stage list does, in a few words.
    witness : dict of symbol to matrix or number, optional
        Explicit values of some letters, where the search for a model of all that the
        page defines and supposes finds none without them.
    limits : tuple of dict of size to size
        What parts of the page set sizes to, as {r: n} where all of a state is wanted.
        Only so a letter occurs in another size than the one that it has.
    """

    given: tuple = ()
    stages: tuple = ()
    steps: dict = field(default_factory=dict)
    source: str = ""
    page: tuple = ()
    letters: Any = None
    says: str = ""
    witness: dict = field(default_factory=dict)
    limits: tuple = ()

    def __post_init__(self):
        found = {title(item): item for item in self._shown}
        object.__setattr__(self, "steps", Steps({**self.steps, **found}))
        for name, step in self.steps.items():
            refuse_truth(step, f"step {name!r}")
            is_checked(step)

    @property
    def _shown(self):
        """What is checked by itself: of the page, and cited by stages."""
        cited = (r for stage in self.stages for r in stage.by)
        return [item for item in (*cited, *self.page) if is_checked(item)]

    # -- checked ------------------------------------------------------------------

    def check(self) -> list[str]:
        """What is wrong, in plain language; [] when everything on the page is right."""
        found = list(self._faults)
        for name, step in self.steps.items():
            if is_checked(step):
                found += [f"{name}: {fault}" for fault in step.check()]
            elif not holds(step):
                found.append(f"{name} is not proved")
        return found

    @cached_property
    def _faults(self):
        """What is wrong beside the steps: stages, and formulas that nothing uses."""
        symmetric = getattr(self.letters, "symmetric", ())
        clash = self._without_model()  # first: what has one here has one in each chain
        found = faults(self.stages, self.given, symmetric)
        names = {id(item): title(item) for item in self._shown}.values()
        twice = sorted(name for name, k in Counter(names).items() if k > 1)
        found += [f"two things are called {name!r}" for name in twice]
        assigned = [e for s in self.stages for e in (s.target, s.expression)]
        found += look_alikes([*self.given, *assigned])
        if self.page:
            introduced = [item for item in self.page if isinstance(item, Relation)]
            used = {r for item in self.page for r in relations_of(item)}
            found += [f"nothing uses {r.name}" for r in introduced if r not in used]
            for k, item in enumerate(self.page):
                found += misplaced(item, self.page[:k])
            meaning = self.letters.meaning
            unknown = sorted(
                {s.name for s in symbols(self)} - {s.name for s in meaning}
            )
            found += [f"it is not said what {name} stands for" for name in unknown]
            found += self._taken_for_constant(introduced)
            found += [
                f"{title(item)}: {fault}"
                for item in self.page
                if is_checked(item)
                for fault in look_alikes(getattr(item, "expressions", ()))
            ]
            found += self._taken_twice()
            found += [
                f"{title(item)}: supposes that {text(s)} is symmetric, and the letters "
                "of the page do not"
                for item in self.page
                for s in supposed(item)
                if s not in symmetric
            ]
        return found + clash

    def _taken_twice(self):
        """Complaints about letters of the page that are not those it declares."""
        shown = [e for item in self.page for e in getattr(item, "expressions", ())]
        found = {s for e in shown if isinstance(e, sp.Basic) for s in letters(e)}
        numbers = look_alikes(s for s in found if isinstance(s, sp.Symbol))
        declared = {text(s): s for s in self.letters.meaning}
        return numbers + [
            f"{text(s)} is {declared[text(s)].shape} among the letters and {s.shape} "
            "on the page: rename it, or say in limits= which size is set to what"
            for s in sorted(found - set(self.letters.meaning), key=str)
            if isinstance(s, sp.MatrixSymbol) and text(s) in declared
            if not any(  # a limit makes it so
                same_shape([sp.sympify(d).subs(at) for d in known.shape], s.shape)
                for known in [declared[text(s)]]
                for at in self.limits
            )
        ]

    def _taken_for_constant(self, introduced):
        """What lines take for constant that the page says is not."""
        chains = [item for item in self.page if isinstance(item, Chain)]
        return [
            f"{title(chain)}: line {k} {fault}"
            for chain, lines in hidden(chains, introduced).items()
            for k, faults in lines.items()
            for fault in faults
        ]

    def _without_model(self):
        """Complaints if nothing is known to satisfy all that holds at once.

        That is the page without what is closed, and before each end what is open.
        """
        ends = [k for k, item in enumerate(self.page) if isinstance(item, End)]
        at_once = [open_before(self.page[:k]) for k in (*ends, len(self.page))]
        return [fault for page in at_once for fault in self._impossible(page)]

    def _impossible(self, page):
        """A complaint if nothing is known to satisfy what these items rely on."""
        own = [item for item in page if isinstance(item, Relation)]
        stages = [r for stage in self.stages for r in stage.reasons]
        chains = [x for x in page if isinstance(x, Chain)]
        cited = [r for chain in chains for r in chain.relations]
        relations = dict.fromkeys([*own, *behind([*stages, *cited])])
        also = [stage.expression for stage in self._every_stage(page)]
        also += [e for chain in chains for e in chain.expressions]
        symmetric = getattr(self.letters, "symmetric", ())
        return impossible(relations, symmetric, also, self.witness)

    def unproved(self) -> list[str]:
        """Names of the steps that are not proved, and what is wrong beside them."""
        found = self._faults
        return [name for name, step in self.steps.items() if not holds(step)] + found

    def proved(self) -> bool:
        """True if there are steps, or stages with reasons, and nothing is wrong."""
        reasoned = bool(self.steps) or any(stage.by for stage in self.stages)
        return reasoned and not self.unproved()

    def rests_on(self) -> Foundation:
        """What its chains and its stages rest on, through all that they cite."""
        cited = [r for stage in self._every_stage(self.page) for r in stage.reasons]
        return foundation(self._chains, cited)

    @property
    def _chains(self):
        return [x for x in self.steps.values() if isinstance(x, Chain)]

    def _every_stage(self, page):
        """Its own stages, and those of the stage lists among items of the page."""
        lists = [self, *(x for x in page if isinstance(x, Derivation))]
        return [stage for found in lists for stage in found.stages]

    def tied(self) -> dict[Any, tuple[str, ...]]:
        """What says something of each target of a stage list: titles of theorems.

        They end with it, or begin, or cite what it is.  Where there are none it is
        ("definition",): the stage is what its letter stands for, and nothing follows.
        """
        chains, found = list(chains_behind(self._chains)), {}
        for stage in self._every_stage(self.page):
            cited = [r for r in stage.reasons if isinstance(r, Result)]
            own = {r for r in stage.reasons if stage.target in letters(sp.Tuple(*r))}
            says = [r.chain.title for r in cited]
            says += [
                chain.title
                for chain in chains
                if own & set(chain.relations)
                or stage.target in letters(sp.Tuple(*chain.ends))
            ]
            found[stage.target] = tuple(dict.fromkeys(says)) or ("definition",)
        return found

    # -- shown --------------------------------------------------------------------

    def __str__(self):
        if self.page:
            return as_text(self)
        rows = [(stage.shown(text), stage.equation) for stage in self.stages]
        wide = max((len(row) for row, _ in rows), default=0)
        lines = [f"  {padded(row, wide)}  {number}".rstrip() for row, number in rows]
        return "\n".join([self.says or self.source or "Our own", *lines])

    __repr__ = __str__

    def _repr_markdown_(self):
        if self.page:
            return as_markdown(self)
        return None

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


class Page(Derivation):
    """A derivation that is written statement by statement.

    A statement returns what it is given, so that later ones can cite it.  One that
    cannot stand where it is written is refused, and the page is as it was before.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import Line, Notation, Page
    >>> n, p = symbols("n p", integer=True, positive=True)
    >>> letters = Notation()
    >>> C = letters("C", p, n, "a linear map")
    >>> Omega = letters("Omega", n, n, "the covariance of x", symmetric=True)
    >>> N = letters("N", n, p, "the covariance of x and C x")
    >>> page = Page(letters=letters)
    >>> is_N = page.let(N, Omega * C.T, "33")
    >>> page.chain("33", "it turned", N.T, Line(C * Omega, by=[is_N]))
    (33) it turned
      N'
        = C Ω  (33) N = Ω C'  ✓
    >>> page.check()
    []
    >>> page.let(N, C.T)
    Traceback (most recent call last):
        ...
    ValueError: let N = C': (33) N = Ω C' says what N is; write suppose(...)

    What is supposed in a scope may be cited inside it, and not after it:

    >>> with page.scope(letters.suppose(C * Omega, C)) as exact:
    ...     _ = page.chain("", "seen", N.T, Line(C, by=[is_N, exact]))
    >>> page.chain("", "again", C * Omega, Line(C, by=[exact]))
    Traceback (most recent call last):
        ...
    ValueError: again: rests on C Ω = C, whose scope has ended
    """

    def __call__(self, *statements: Any) -> Any:
        """Write statements; one is returned as it is, several as a tuple."""
        items = self.page
        for item in statements:
            if wrong := misplaced(item, items):
                raise ValueError(wrong[0])
            items = (*items, item)
        self._write(items, self.steps)
        return statements[0] if len(statements) == 1 else statements

    def let(self, *said: Any, **more: Any) -> Let:
        """Write what a new letter stands for, as `Notation.let` makes it."""
        return self(self.letters.let(*said, **more))

    def suppose(self, *said: Any, **more: Any) -> Relation:
        """Write a hypothesis, as `Notation.suppose` makes it."""
        return self(self.letters.suppose(*said, **more))

    def steady(self, *said: Any, **more: Any) -> Steady:
        """Write a fixed point, as `Notation.steady` makes it."""
        return self(self.letters.steady(*said, **more))

    def moment(self, *said: Any, **more: Any) -> Moment:
        """Write an expectation, as `Notation.moment` makes it."""
        return self(self.letters.moment(*said, **more))

    def chain(self, *said: Any, **more: Any) -> Chain:
        """Write a chain in the letters of the page, as `Notation.chain` makes it."""
        return self(self.letters.chain(*said, **more))

    def induction(
        self,
        number: str,
        says: str,
        statement: Relation,
        *,
        base: Chain,
        step: Chain,
        first: Mapping[Any, Any],
        then: Mapping[Any, Any],
    ) -> Chain:
        """Write that a statement holds at every k: at the first, and from k on.

        Parameters
        ----------
        number, says : str
            As for a `Chain`.
        statement : Relation
            What is claimed of k, as it was supposed in the scope of the step.
        base : Chain
            It proves the statement at the first k.
        step : Chain
            It supposes the statement, and proves it one step on.
        first, then : dict of letter to expression
            What the letters that depend on k are at the first k, and one step on.

        Returns
        -------
        Chain
            Its end may be cited at any k.  What the base and the step rest on is said
            for every k.

        Examples
        --------
        All powers of F take a vector that F does not move to itself.

        >>> from sympy import symbols
        >>> from matrixproof import Line, Notation, Page
        >>> n = symbols("n", integer=True, positive=True)
        >>> letters = Notation()
        >>> F, F_k, F_next = (
        ...     letters(name, n, n, "a power") for name in ("F", "F_k", "F_next")
        ... )
        >>> x = letters("x", n, 1, "a column")
        >>> page = Page(letters=letters)
        >>> stays = page(letters.suppose(F * x, x))
        >>> more = page(letters.let(F_next, F * F_k))
        >>> one = page.chain("", "F does not move it", F * x, Line(x, by=[stays]))
        >>> with page.scope(letters.suppose(F_k * x, x)) as so_far:
        ...     next = page.chain(
        ...         "", "one more", F_next * x, Line(x, by=[more, so_far, stays])
        ...     )
        >>> at = {"first": {F_k: F}, "then": {F_k: F_next}}
        >>> page.induction("", "none moves it", so_far, base=one, step=next, **at)
        none moves it
          F_k x
            = x  induction: F does not move it; one more  ✓
        """
        line = Induced(
            statement.right,
            statement=statement,
            base=base,
            step=step,
            first=first,
            then=then,
        )
        return self.chain(number, says, statement.left, line)

    def at(self, number: str, says: str, theorem: Chain, **letters: Any) -> Instance:
        """Write a theorem in the letters of the page, named as in `Chain.at`.

        What it supposes must stand on the page, as a relation or as a chain's result.
        """
        said = open_before(self.page)
        given = [x for x in said if isinstance(x, Relation)]
        given += [x.relation for x in said if isinstance(x, Chain) and x.equates]
        more = {"number": number, "says": says, "symmetric": self.letters.symmetric}
        return self(theorem.at({}, *given, **more, **letters))

    def program(self, says: str, given: Iterable[Any], *stages: Any) -> Derivation:
        """Write a stage list in the letters of the page.

        Parameters
        ----------
        says : str
            What it does, in a few words.
        given : iterable of MatrixSymbol
            What it needs, by name.
        *stages : Stage, Relation or pair
            What it computes, in order.  A relation gives its left side the value of its
            right side; in a pair, the number of the equation comes behind it.

        Examples
        --------
        >>> from matrixproof import Notation, Page, letters
        >>> known, (A, P, P_next) = Notation(), letters("A:n*n P:n*n P_next:n*n")
        >>> page = Page(letters=known)
        >>> moves = page.let(P_next, A * P * A.T)
        >>> print(page.program("a step", (A, P), (moves, "(4)")))
        a step
          P₊ = A P A'  (4)
        """
        symmetric = getattr(self.letters, "symmetric", ())
        made = tuple(assigned(stage, symmetric) for stage in stages)
        more = {"source": self.source, "letters": self.letters, "says": says}
        return self(Derivation(tuple(given), made, **more))

    @contextmanager
    def scope(self, *statements: Relation) -> Iterator[Any]:
        """`with page.scope(suppose(X, Y)) as name:` what is supposed only inside."""
        if not statements or not all(isinstance(r, Relation) for r in statements):
            raise ValueError("a scope begins with what is supposed in it")
        before, first = (self.page, self.steps), len(self.page) + len(statements)
        try:
            yield self(*statements)
        except BaseException:
            self._write(*before)  # nothing of it is said
            raise
        inside = open_before(self.page)[len(open_before(self.page[:first])) :]
        self(End(statements, tuple(r for r in inside if isinstance(r, Relation))))

    def _write(self, items, steps):
        for name, value in (("page", items), ("steps", steps)):
            object.__setattr__(self, name, value)
        self.__dict__.pop("_faults", None)  # which were those of another page
        self.__post_init__()


def assigned(said, symmetric):
    """The stage that a relation, or a pair of it and of its number, stands for."""
    if isinstance(said, Stage):
        return said
    by, equation = said if isinstance(said, tuple) else (said, "")
    return Stage(by.left, by.right, equation, by.left in symmetric, (by,))


def open_before(page):
    """The items of a page that may be cited after it: those in no scope that ended."""
    found = []
    for item in page:
        if isinstance(item, End):
            first = item.relations[0]
            del found[max(k for k, one in enumerate(found) if one is first) :]
        else:
            found.append(item)
    return found


def misplaced(item, before):
    """Why a statement cannot stand after these, of a page."""
    here = {r: None for r in open_before(before) if isinstance(r, Relation)}
    if isinstance(item, Let) and (why := not_new(item, here)):
        return [f"let {item.show(text)}: {why}"]
    closed = {r for r in before if isinstance(r, Relation)}.difference(here)
    found = []
    for r in dict.fromkeys(relations_of(item)):
        if isinstance(r, Result):
            gone = closed.intersection(behind([r]))
        elif r in here:
            continue
        elif r not in closed:
            found.append(f"{r.name} is cited and not introduced")
            continue
        else:
            gone = [r]
        found += [f"rests on {x.name}, whose scope has ended" for x in gone]
    return [f"{title(item)}: {fault}" for fault in found]


def not_new(item, known):
    """Why a letter cannot be defined after these relations."""
    letter, means = item.left, {r.left: r for r in known if isinstance(r, Let)}
    if letter in means:
        return f"{means[letter].name} says what {text(letter)} is; write suppose(...)"
    for r in known:
        if not isinstance(r, Let) and letter in sides(r)[0] | sides(r)[1]:
            return (
                f"{r.name} is said of {text(letter)} before; introduce the letter "
                "first, or write suppose(...)"
            )
    waiting, seen = [*sides(item)[1]], set()
    while waiting:
        other = waiting.pop()
        if other == letter:
            return f"{text(letter)} is part of what it stands for; write suppose(...)"
        if other in means and other not in seen:
            seen.add(other)
            waiting += sides(means[other])[1]
    return ""


def relations_of(item):
    """What an item of a page cites."""
    if isinstance(item, Derivation):
        return [r for stage in item.stages for r in stage.reasons]
    return item.relations if is_checked(item) else ()


def title(step: Any) -> str:
    """The name of what is proved: its number and what it says.

    A stage list is named by what it does.
    """
    return under(getattr(step, "number", ""), step.says)


def supposed(item):
    """The symbols in an item that it takes to equal their transposes."""
    inside = sp.Tuple(*getattr(item, "expressions", ())).atoms(sp.MatrixSymbol)
    return [s for s in getattr(item, "symmetric", ()) if s in inside]


def look_alikes(expressions):
    """Complaints about letters of one chain that differ and are printed alike."""
    known = {}
    for expr in expressions:
        if isinstance(expr, sp.Basic):
            for s in expr.atoms(sp.MatrixSymbol, sp.Symbol):
                known.setdefault(text(s), {})[s] = getattr(s, "shape", "a number")
    return [
        f"{shown} is printed for several letters, {', '.join(map(str, each.values()))}:"
        " rename one of them"
        for shown, each in known.items()
        if len(each) > 1
    ]


def symbols(derivation):
    """The matrix symbols on a page, and the numbers that are letters."""
    found, known = set(), set(getattr(derivation.letters, "meaning", ()))
    for item in derivation.page:
        for expr in getattr(item, "expressions", ()):
            if isinstance(expr, MatrixExpr | sp.Basic):
                found |= expr.atoms(sp.MatrixSymbol) | (expr.atoms(sp.Symbol) & known)
    return found


def is_checked(item: Any) -> bool:
    """Whether an item is checked by itself.

    Raises
    ------
    TypeError
        It has a check of its own making, which may accept anything.
    """
    if type(item) in (*CHECKED, Derivation):
        return True
    if hasattr(item, "check"):
        raise TypeError(
            f"{item} is a {type(item).__name__}, whose check is not of this package: "
            "give a Chain, Construction, Counterexample, Explicit, Positive, "
            "Derivation or Claim"
        )
    return False


def holds(step: Any) -> bool:
    """Whether a step is proved: a chain and its like, a claim, or a bare residual."""
    if is_checked(step):
        return not step.check()
    refuse_truth(step, "what is to hold")
    return vanishes(step)


def vanishes(residual: Formula) -> bool:
    """Whether a residual is identically zero.

    Accepts the normal forms of this package, explicit SymPy matrices and scalars.
    """
    known = isinstance(residual, Sum | Blocks | Claim)
    return (residual if known else Claim(residual)).is_zero


# -- read in a terminal, in a notebook -----------------------------------------------


def used_letters(derivation):
    """{symbol: meaning} of what stands on a page, in the order of the notation."""
    here = symbols(derivation)
    named = {
        s.name: s for s in sorted(here, key=lambda s: str(getattr(s, "shape", "")))
    }  # of a letter's sizes, one
    meaning = derivation.letters.meaning.items()
    return {
        (s if s in here else named[s.name]): says
        for s, says in meaning
        if s.name in named
    }


def as_text(derivation):
    """A page for a terminal."""
    parts = [derivation.source]
    rows = [(text(s), plain(says)) for s, says in used_letters(derivation).items()]
    wide = max((width(s) for s in used_letters(derivation)), default=0)
    parts.append("\n".join(f"  {padded(s, wide)}  {says}" for s, says in rows))
    for item in derivation.page:
        if isinstance(item, str):
            parts.append(fill(" ".join(plain(item).split()), 88))
        elif isinstance(item, Relation):
            parts.append(f"  {item.stated(text)}  {numbered(item)[0]}".rstrip())
        else:
            parts.append(str(item))
    return "\n\n".join(filter(None, parts))


def size(symbol, letters, show):
    """Rows and columns of a symbol."""
    if not hasattr(symbol, "shape"):
        return r"\text{number}" if show is latex else "number"
    times = r" \times " if show is latex else " × "
    return times.join(show(letters.sizes.get(k, k)) for k in symbol.shape)


def as_markdown(derivation):
    """A page for a notebook."""
    rows = [
        f"- ${latex(s)}$, ${size(s, derivation.letters, latex)}$: {markdown(says)}"
        for s, says in used_letters(derivation).items()
    ]
    parts = ["\n".join(rows)]
    for item in derivation.page:
        if isinstance(item, str):
            parts.append(markdown(" ".join(item.split())))
        elif isinstance(item, End):
            parts.append(item.stated(latex))
        elif isinstance(item, Relation):
            parts.append(framed([item.stated(latex)], bare_number(item)))
        else:
            parts.append(item._repr_latex_())
    return "\n\n".join(filter(None, parts))


def equivalent(
    fast: Derivation,
    slow: Derivation,
    *given: Any,
    same: Mapping[Any, Any] = {},
    says: str = "",
) -> tuple[Derived, ...]:
    """Prove that a stage list computes what another one does.

    Parameters
    ----------
    fast, slow : Derivation
        Stage lists.
    *given : Relation or Chain
        What is known of what they are given.
    same : dict of expression to expression, optional
        What of the fast one equals what of the slow one; by default every target that
        both assign.
    says : str, optional
        What is proved, in a few words; by default what the fast one does.

    Returns
    -------
    tuple of Chain
        For each target one that begins with what the fast list computes and ends with
        what the slow one does, and cites what the proof needs.

    Raises
    ------
    Unproved
        One of them differs; the message names it and what is left over.
    ValueError
        A list fails, or no target is assigned by both.

    Examples
    --------
    >>> from matrixproof import Derivation, Notation, Stage, letters
    >>> A, B, S, X = letters("A:n*n B:n*n S:n*n X:n*n")
    >>> is_S, is_X = Notation().let(S, A + B), Notation().let(X, A * A + A * B)
    >>> slow = Derivation((A, B), [Stage(X, A * A + A * B, by=[is_X])], says="two")
    >>> by = [is_S, is_X]
    >>> stages = [Stage(S, A + B, by=[is_S]), Stage(X, A * S, by=by)]
    >>> fast = Derivation((A, B), stages, says="one product")
    >>> print(*equivalent(fast, slow))
    one product
      A S
        = X  S = A + B, X = A A + A B  ✓
    """
    for one in (fast, slow):
        if wrong := one.check():
            raise ValueError(f"{one.says} fails: {wrong[0]}")
    theirs = {stage.target: stage for stage in slow.stages}
    ours = [stage for stage in fast.stages if stage.target not in theirs]
    put = {s.target: s.expression for s in fast.stages if s.target in theirs}
    pairs = same or {target: target for target in put}
    if not pairs:
        raise ValueError(
            f"no target of {fast.says} is one of {slow.says}: say what equals what, "
            "same={left: right}"
        )
    reasons = [r for stage in (*ours, *slow.stages) for r in stage.reasons]
    known = [getattr(x.letters, "symmetric", ()) for x in (fast, slow)]
    symmetric = tuple(dict.fromkeys(x for one in known for x in one))
    found = []
    for left, right in pairs.items():
        stage = theirs.get(right)
        number = stage.equation.strip("()") if stage else ""
        start = left
        for _ in put:
            start = start.xreplace(put)
        begun = Derived(number, says or fast.says, start, (), symmetric)
        try:
            found.append(begun.by(right, *dict.fromkeys((*reasons, *named(given)))))
        except Unproved as e:
            said = f"{text(right)} of {fast.says} is not that of {slow.says}: {e}"
            raise Unproved(said, e.left_over, e.complete, e.counterexample) from None
    return tuple(found)
