"""What a page of a derivation says under a number, and how well it is established."""

import html
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from matrixproof import Derivation, Explicit, Relation, latex, text
from matrixproof.derivation import title
from matrixproof.explicit import Construction, Counterexample
from matrixproof.lines import AtLeast, bare_number
from matrixproof.operators import Operator
from matrixproof.prose import plain, typeset
from matrixproof.relations import Let
from matrixproof.typeset import Show, pieces


@dataclass(frozen=True, repr=False)
class Statement:
    """A definition, a supposition, or what is proved, on a page.

    Attributes
    ----------
    page : str
        Where it stands, "room.module".
    item : Relation, Chain, Construction, Counterexample, Explicit or Derivation
    """

    page: str
    item: Any

    @property
    def proved(self) -> bool:
        """Whether it is shown to hold, and not supposed or given a letter."""
        return not isinstance(self.item, Relation)

    @property
    def says(self) -> str:
        """What it is called in a few words; of what is not proved, how it is meant."""
        return self.item.says if self.proved else self.item.word.lower().rstrip(":")

    @property
    def pointer(self) -> str:
        """Where it stands, by its page and its title."""
        return f"{self.page}: {title(self.item) if self.proved else self.item.name}"

    def check(self) -> list[str]:
        """What is wrong with its proof; of a definition, nothing."""
        return self.item.check() if self.proved else []

    @property
    def explicit(self) -> bool:
        """Whether it is evaluated, and not proved for matrices of all sizes."""
        return isinstance(self.item, Explicit)

    @property
    def sizes(self) -> str:
        """Where it is proved, if that is not for all sizes."""
        if isinstance(self.item, Counterexample):
            return "by a counterexample"
        return where(self.item.cases) if self.explicit else ""

    def pieces(self, show: Show) -> list[str]:
        """Its formula, set by `latex` or `text`, in pieces that a page may part.

        Of a chain it has both ends.
        """
        return ends(self.item, show)

    def called(self, show: Callable[[str], str]) -> str:
        """What stands before the formula."""
        if not self.says:
            return ""
        return f"{show(self.says)}: " if self.proved else f"{self.says} "

    def unbroken(self) -> str:
        """It in Unicode, with no-break spaces where a line must not end."""
        found = " ".join(x.replace(" ", "\u00a0") for x in self.pieces(text))
        found = f"{self.called(plain)}{found}"
        return f"{found} ({self.sizes})" if self.sizes else found

    @property
    def key(self) -> tuple[str, ...]:
        """What two pages that say the same have in common."""
        return (self.says * self.proved, *self.pieces(text))

    def __str__(self) -> str:
        return self.unbroken().replace("\u00a0", " ")

    __repr__ = __str__


class Says(tuple[Statement, ...]):
    """Statements of one entry, under a heading; a notebook shows them typeset."""

    heading = ""

    def lines(self) -> list[str]:
        """The heading and each statement, with no-break spaces in formulas."""
        found = [plain(self.heading), *(one.unbroken() for one in self)]
        return list(filter(None, found))

    def __str__(self) -> str:
        return "; ".join(self.lines()).replace("\u00a0", " ")

    __repr__ = __str__

    def _repr_html_(self) -> str:
        r"""A row for each; formulas as MathJax finds them, `\(...\)`."""
        return "".join(
            f"<div>{row}</div>"
            for row in self.rows(lambda x: rf'<span class="math">\({x}\)</span>')
        )

    def rows(self, math: Callable[[str], str] | None) -> Iterator[str]:
        """The heading and each statement as HTML.

        Formulas are as `math` writes what is LaTeX, without it in Unicode.
        """
        if self.heading:
            yield with_formulas(self.heading, math)
        for one in self:
            if math is None:
                yield html.escape(str(one))
                continue
            first, *rest = one.pieces(latex)
            shown = " ".join(map(math, (first, *(f"{{}}{x}" for x in rest))))
            says = one.called(lambda words: with_formulas(words, math))
            sizes = html.escape(f" ({one.sizes})") if one.sizes else ""
            yield f"{says}{shown}{sizes}"


def with_formulas(words: str, math: Callable[[str], str] | None) -> str:
    """Words as HTML; what stands between backquotes is a formula."""
    if math is None:
        return html.escape(plain(words))
    return "".join(
        math(piece) if is_latex else html.escape(piece)
        for is_latex, piece in typeset(words)
    )


def ends(item: Any, show: Show) -> list[str]:
    """What is stated or proved, without the way there."""
    if isinstance(item, Relation):
        return [item.show(show) + item.condition(show)]
    if isinstance(item, Construction):
        found = [f"{show(s)} = {show(v)}" for s, v in item.values.items()]
        return [*(f"{one}," for one in found[:-1]), found[-1]]
    if isinstance(item, Counterexample):
        sign = r"\ne" if show is latex else "≠"
        return [f"{show(item.left)} {sign} {show(item.right)}"]
    if isinstance(item, Explicit):
        first, *rest = pieces(item.right, show)
        return [*pieces(item.left, show), f"{item.sign} {first}", *rest]
    stated = hasattr(item.left, "show")  # one equation leads to another
    left = [item.start(show)] if stated else pieces(item.left, show)
    between = "="
    for line in item.lines:
        if isinstance(line, Operator):  # done to all that stands before
            before, after = line.marks(show)
            left = [f"{before}[{left[0]}", *left[1:]]
            left[-1] += f"]{after}"
        elif isinstance(line, AtLeast) or stated:
            between = line.latex_sign if show is latex else line.sign
    first, *rest = item.lines[-1].pieces(show)
    return [*left, f"{between} {first}", *rest]


# -- numbers ---------------------------------------------------------------------------


def numbers(label: str) -> set[str]:
    """The equation numbers in the label of a step.

    >>> sorted(numbers("41–43, 3.10'"))
    ["3.10'", '41', '42', '43']
    """
    found = set()
    for one in filter(None, label.split(", ")):
        first, dash, last = one.partition("–")
        span = range(int(first), int(last) + 1) if dash else [one]
        found |= set(map(str, span))
    return found


def number_of(item: Any) -> str:
    """The label of what stands on a page; words and stage lists have none."""
    if isinstance(item, Relation):
        return bare_number(item)
    return getattr(item, "number", "")


def carried(
    derivation: Derivation, number: str, about: str = "", page: str = ""
) -> tuple[Statement, ...]:
    """What a page says under a number.

    Parameters
    ----------
    derivation : Derivation
    number : str
        As pages write it, "33" or "section 2".
    about : str
        The name of a letter: only what has it alone on one side.
    page : str
        How the page is called in what is found.
    """
    return tuple(
        Statement(page, item)
        for item in derivation.page
        if number in numbers(number_of(item))
        if about in ("", *map(str, sides(item)))
    )


def sides(item: Any) -> tuple:
    """What stands before and behind the sign; of a construction, its letters."""
    if isinstance(item, Construction):
        return tuple(item.values)
    return item.left, item.right


def proofs(derivation: Derivation, page: str = "") -> tuple[Statement, ...]:
    """All that is proved on a page."""
    steps = (x for x in derivation.page if hasattr(x, "check"))
    return tuple(Statement(page, x) for x in steps if not isinstance(x, Derivation))


def resting(
    found: Iterable[Statement], derivation: Derivation, page: str
) -> Iterator[Statement]:
    """What a page proves by those definitions that nothing found rests on so far.

    A stage list rests on what its stages cite.
    """
    known = {r for one in found if one.proved for r in one.item.relations}
    loose = {one.item for one in found if not one.proved} - known
    for item in (x for x in derivation.page if hasattr(x, "check")):
        stages = getattr(item, "stages", ())
        cited = [r for stage in stages for r in stage.reasons]
        if loose & {*cited, *getattr(item, "relations", ())}:
            yield Statement(page, item)


# -- levels ----------------------------------------------------------------------------


def where(cases: Iterable[str]) -> str:
    """At what something is evaluated; without names, it is so for all numbers."""
    named = list(dict.fromkeys(filter(None, cases)))
    if len(named) > 2:
        return f"at {len(named)} cases from {named[0]} to {named[-1]}"
    return f"at {' and '.join(named)}" if named else "for all values of the symbols"


def level(found: Collection[Statement]) -> str:
    """How well statements are established: what stays at explicit sizes says so."""
    proved = [one for one in found if one.proved]
    explicit = [one.item for one in proved if one.explicit]
    parts = ["at symbolic sizes"] if any(not one.sizes for one in proved) else []
    if explicit:
        parts.append(where(name for item in explicit for name in item.cases))
    if any(isinstance(one.item, Counterexample) for one in proved):
        parts.append("by a counterexample")
    if parts:
        return f"proved {', and '.join(parts)}"
    lets = all(isinstance(one.item, Let) for one in found)
    return "a definition" if lets else "a supposition"
