"""A relation: an equation between matrices that a proof may cite by its name."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

from .symbols import Member, shown
from .typeset import Show, latex, text
from .words import Formula, Symbols, plain


@dataclass(frozen=True, repr=False)
class Relation:
    """`left = right`, under a name that a line of a derivation can cite.

    On a page it is a hypothesis.

    Attributes
    ----------
    name : str
        How the relation is cited, e.g. "M = C P C' + R" or "(3.8)".
    left, right : MatrixExpr
        Any two matrix expressions of one shape.

    Examples
    --------
    A relation unpacks to its two sides, so that it can stand wherever a pair does.

    >>> from matrixproof import Identity, Relation, letters
    >>> A, B = letters("A:n*n B:n*n")
    >>> inverse = Relation("A B = I", A * B, Identity(A.rows))
    >>> left, right = inverse
    >>> left
    A*B
    """

    name: str
    left: Formula
    right: Formula

    word: ClassVar[str] = "Suppose"  # before it, where a page introduces it

    def __iter__(self):
        return iter((self.left, self.right))

    def show(self, show: Show) -> str:
        """The equation, set by `latex` or `text`."""
        return equation(self.left, self.right, show)

    def condition(self, show: Show) -> str:
        """What it supposes beside itself, in words; nothing, of most."""
        return ""

    def stated(self, show: Show) -> str:
        """As a page introduces it: its word, the equation, what it supposes beside."""
        word = rf"\text{{{self.word} }}" if show is latex else f"{self.word} "
        return word * bool(self.word) + self.show(show) + self.condition(show)

    def __str__(self):
        says = self.show(text)
        says = self.name if says in self.name else f"{self.name}: {says}"
        return f"{self.word} {says}".strip() + self.condition(text)

    __repr__ = __str__

    def _repr_latex_(self):
        return rf"$$ {self.stated(latex)} $$"

    @property
    def expressions(self) -> tuple[Formula, Formula]:
        return self.left, self.right

    def mapped(self, put: Callable[[Formula], Formula]) -> Self:
        """The relation between what `put` makes of its sides, under its number."""
        found = replace(self, left=put(self.left), right=put(self.right))
        return replace(found, name=self.name.replace(self.show(text), found.show(text)))


class Let(Relation):
    """What a letter stands for, which nothing was said of before."""

    word = "Let"

    def mapped(self, put: Callable[[Formula], Formula]) -> Any:
        """Where another formula takes the place of the letter, a hypothesis."""
        found = super().mapped(put)
        if getattr(found.left, "is_symbol", False):
            return found
        return Relation(found.name, found.left, found.right)


class Steady(Relation):
    """A fixed point, X = f(X): what a recursion of X has in the long run."""

    word = "Steady:"


class Moment(Relation):
    """What an expectation is: E[left] = right, as a line that takes one cites it."""

    word = ""

    def show(self, show: Show) -> str:
        E = r"\mathrm{E}" if show is latex else "E"
        says = f"{E}[{show(self.left)}] = {show(self.right)}"
        apart = [shown(x.index) for x in plain(self.left).atoms(Member)]
        if len(set(apart)) < 2:
            return says
        i, j = sorted(set(apart))
        unlike = rf",\; {i} \ne {j}" if show is latex else f" ({i} ≠ {j})"
        return says + unlike


@dataclass(frozen=True, repr=False)
class Result(Relation):
    """What a chain has proved, as a later one cites it.

    Attributes
    ----------
    chain : Chain
        What proves it: whoever cites the result rests on every line of that chain.
    """

    chain: Any

    word = ""

    def faults(self, symmetric: Symbols) -> list[str]:
        """Why it cannot be cited where these letters equal their transposes."""
        if (self.left, self.right) != (self.chain.left, self.chain.right):
            return [f"rests on {self.name}, which is not what its chain proves"]
        if wrong := self.chain.check():
            return [f"rests on {self.chain.title}, which fails: {wrong[0]}"]
        missing = [s for s in self.chain.supposes if s not in symmetric]
        if not missing or self.chain.holds_without(*missing):
            return []
        said = " and ".join(map(text, missing))
        return [
            f"rests on {self.chain.title}, which supposes that {said} "
            f"{'is' if len(missing) == 1 else 'are'} symmetric: say so here, too"
        ]

    def mapped(self, put: Callable[[Formula], Formula]) -> Any:
        """A supposition: in other letters it is not what the chain has proved."""
        return Relation(self.name, self.left, self.right).mapped(put)


def equation(left: Formula, right: Formula, show: Show = text) -> str:
    """`left = right`, set by `latex` or `text`."""
    return f"{show(left)} = {show(right)}"


def under(number: str, says: str) -> str:
    """Words, behind the number of an equation where there is one."""
    return f"({number}) {says}" if number else says


def unfounded(cited: Iterable[Relation], symmetric: Symbols) -> list[str]:
    """What is wrong with the chains behind what is cited."""
    known = frozenset(symmetric)
    return [fault for r in cited if isinstance(r, Result) for fault in r.faults(known)]


def refuse_means(cited: Iterable[Any]) -> None:
    """Raise for a mean where an equation is meant."""
    if means := [r for r in cited if isinstance(r, Moment)]:
        raise TypeError(
            f"{means[0].show(text)} is a mean, and equal to nothing without its E: "
            "cite it among the moments of Expect"
        )


Reasons = tuple[Relation, ...]
Given = Iterable[Relation | tuple[Formula, Formula]]


def named(given):
    """`Relation`s from relations and (left, right) pairs; a pair is named by its sides.

    Raises
    ------
    TypeError
        Something is neither a relation nor a pair.
    """
    if isinstance(given, Relation) or hasattr(given, "relation"):
        (one,) = named([given])
        raise TypeError(
            f"{one.name} is one relation where several are meant: write (relation,), "
            "with a comma"
        )
    return tuple(_named(item) for item in given)


def _named(item):
    if isinstance(item, Relation):
        return item
    if hasattr(item, "relation"):  # a chain
        return item.relation
    if isinstance(item, list | tuple) and any(isinstance(x, Relation) for x in item):
        raise TypeError(
            f"a {type(item).__name__} of relations stands where one is meant: write "
            "them one after the other"
        )
    try:
        left, right = item
    except (TypeError, ValueError):
        raise TypeError(
            f"{item!r} is not a relation: give Relation(name, left, right) "
            "or a pair (left, right)"
        ) from None
    return Relation(f"{left} = {right}", left, right)
