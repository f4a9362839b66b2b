"""The entries: what is kept by hand in `entries/`, and what the pages say to it."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

# The papers in the order in which they are dealt with; the keys name the files.
PAPERS = (
    "leondes_novak",
    "moore",
    "haddad_bernstein",
    "van_dooren",
    "kawazoe",
    "hsia",
)
OURS = "ours"  # theorems that are in no paper: each of these pages is an entry as well
PARTS = (*PAPERS, OURS)
# Where something is wrong: in our scan, and perhaps in print; in print for sure; or in
# what the paper says.
KINDS = {"scan": "in our scan", "print": "in print", "mathematics": "in the paper"}


@dataclass(frozen=True)
class Misprint:
    """What a page prints, or the scan leaves, and what it should say.

    Attributes
    ----------
    printed, correct : str
    kind : str
        "scan" for what our scan has, which may be the scan's fault or the printer's;
        "print" for what no scan makes of a page; "mathematics" where the statement
        itself needs a change.
    tried : str
        The step, test or entry of an errata module that tries both; empty where
        letters were lost and there is nothing to try.
    """

    printed: str
    correct: str
    kind: str
    tried: str = ""

    @property
    def where(self) -> str:
        """Where it is, as in "wrong in our scan"."""
        return KINDS[self.kind]


@dataclass(frozen=True)
class Entry:
    """One numbered equation, a displayed definition without a number, or our theorem.

    What is kept by hand is read from a file.  What the pages of the derivations say
    under the number is found when it is asked for; this loads SymPy and these pages.

    Attributes
    ----------
    paper, number : str
        Key of the paper, as in `PARTS`; the number as printed.  Of our own theorems the
        key is `OURS`, and a name takes the place of the number.
    pages : tuple of str
        The pages that may carry the number, "room.module", in reading order.
    used : str
        The public function or type that uses it.
    shown : str
        "notebook: words of a cell".
    misprints : tuple of Misprint
    carries : tuple of str
        The number as the pages write it, where that is another one.
    about : str
        The name of a letter, where several definitions have one number.
    tests : tuple of str
        Tests that vouch for numbers, "tests/room/test_file.py::test".
    reproduced : str
        How well they do.
    words : str
        A sentence for what no page says.
    """

    paper: str
    number: str
    pages: tuple[str, ...]
    used: str
    shown: str
    misprints: tuple[Misprint, ...] = ()
    carries: tuple[str, ...] = ()
    about: str = ""
    tests: tuple[str, ...] = ()
    reproduced: str = ""
    words: str = ""

    @property
    def used_by(self) -> str:
        """The name that uses it, as it follows ``lb.``, or its own in another room."""
        name = self.used.removeprefix("luenberger.")
        return name if name.count(".") < 2 else name.rpartition(".")[2]

    @property
    def source(self) -> str:
        """The paper as it is cited, or "Our own"."""
        return title(self.paper)

    @cached_property
    def says(self) -> Any:
        """What the pages say under the number, definitions and what is proved."""
        from .evidence import derivation, module
        from .statements import Says, carried, proofs

        found: list[Any] = []
        for page in self.pages:
            if self.paper == OURS:
                found += proofs(derivation(page), page)
            for label in self.labels:
                found += carried(derivation(page), label, self.about, page)
        alike: dict[Any, Any] = {}  # what several pages say is said once
        for one in found:
            alike.setdefault(one.key, one)
        says = Says(alike.values())
        says.heading = self.words
        if self.paper == OURS:
            says.heading = str(module(self.pages[0]).__doc__).partition("\n")[0]
        return says

    @property
    def labels(self) -> tuple[str, ...]:
        """Its number as pages write it."""
        if self.paper == OURS:
            return ()
        plain = re.sub(r"\((\d[\d.]*)\)", r"\1", self.number.partition(": ")[0])
        return self.carries or (plain,)

    @property
    def level(self) -> str:
        """How well it is established, from the kind of its evidence.

        "a definition" or "a supposition", "proved at symbolic sizes", "proved at
        n = 3, ..", or, where tests vouch for numbers, "reproduced to ..".
        """
        from .statements import level

        proved = level(self.says) if self.says else ""
        return "; ".join(filter(None, [proved, self.reproduced]))

    @cached_property
    def proofs(self) -> tuple[Any, ...]:
        """What is proved under the number, and what rests on its definitions.

        A definition is vouched for by what is proved with it.
        """
        from .evidence import derivation
        from .statements import resting

        pages = dict.fromkeys(one.page for one in self.says)
        rest = (resting(self.says, derivation(page), page) for page in pages)
        own = (one for one in self.says if one.proved)
        return (*own, *(one for of_page in rest for one in of_page))

    @property
    def evidence(self) -> tuple[str, ...]:
        """Where its proofs stand, and its tests."""
        return (*(one.pointer for one in self.proofs), *self.tests)

    def check(self) -> list[str]:
        """What of its evidence is not proved, and why; [] if all of it is.

        >>> entries("leondes", number="(37)")[0].check()
        []
        """
        return [f"{one.pointer}: {why}" for one in self.proofs for why in one.check()]

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        return {
            "paper": self.paper,
            "number": self.number,
            "source": self.source,
            "says": [row.replace("\u00a0", " ") for row in self.says.lines()],
            "level": self.level,
            "evidence": self.evidence,
            "used": self.used,
            "shown": self.shown,
            "misprints": [asdict(slip) for slip in self.misprints],
        }


@cache
def _file(paper: str) -> dict[str, Any]:
    text = files(__package__).joinpath("entries", f"{paper}.toml").read_text("utf-8")
    return tomllib.loads(text)


@cache
def _entries(paper: str) -> tuple[Entry, ...]:
    return tuple(_read(paper))


def _read(paper: str) -> Iterator[Entry]:
    file = _file(paper)
    slips = file.get("misprints", {})
    for number, row in file["entries"].items():
        pages = [row["page"]] if "page" in row else file["pages"]
        yield Entry(
            paper,
            number,
            tuple(page if paper == OURS else f"{paper}.{page}" for page in pages),
            f"luenberger.{row['used']}",
            row["shown"],
            tuple(Misprint(**slip) for slip in slips.get(number, ())),
            tuple(row.get("carries", ())),
            row.get("about", ""),
            tuple(row.get("tests", ())),
            row.get("reproduced", ""),
            row.get("words", ""),
        )


def title(paper: str) -> str:
    """How a paper is cited, by its key."""
    return _file(paper)["paper"]


def find_paper(name: str) -> str:
    """The key of a paper from part of its key or title, in any case; or "ours".

    Raises
    ------
    ValueError
        If no paper or several have `name` in them.

    Examples
    --------
    >>> find_paper("Van Dooren")
    'van_dooren'
    """
    wanted = str(name).casefold().replace("-", "_")
    hits = [
        paper
        for paper in PARTS
        if wanted and (wanted in paper or wanted in title(paper).casefold())
    ]
    if len(hits) != 1:
        problem = "no paper" if not hits else "more than one paper"
        raise ValueError(f"{problem} is called {name!r}: give one of {_listed()}")
    return hits[0]


def _listed() -> str:
    return ", ".join(repr(paper) for paper in PARTS)


def entries(
    paper: str | None = None, *, number: str | None = None
) -> tuple[Entry, ...]:
    """The entries of one paper, of our own theorems, or of all, in page order.

    Parameters
    ----------
    paper : str, optional
        Part of a paper's key or title, e.g. "moore", or "ours".
    number : str, optional
        Only the entry with this number, e.g. "(33)".

    Returns
    -------
    tuple of Entry

    Raises
    ------
    ValueError
        If there is no such paper.
    """
    papers = PARTS if paper is None else (find_paper(paper),)
    found = (entry for key in papers for entry in _entries(key))
    return tuple(entry for entry in found if number in (None, entry.number))


def count(paper: str | None = None) -> int:
    """Number of entries.

    >>> count("leondes"), count() == sum(map(count, PARTS))
    (61, True)
    """
    return len(entries(paper))


def misprints(paper: str | None = None) -> tuple[tuple[Entry, Misprint], ...]:
    """Every misprint as (entry, misprint), in page order."""
    return tuple((e, slip) for e in entries(paper) for slip in e.misprints)
