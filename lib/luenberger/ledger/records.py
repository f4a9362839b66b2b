"""The entries, read from the files in `entries/`, and what can be asked of them."""

import tomllib
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from .words import Words

# The papers in the order in which they are dealt with; the keys name the files.
PAPERS = (
    "leondes_novak",
    "moore",
    "haddad_bernstein",
    "van_dooren",
    "kawazoe",
    "hsia",
)
OURS = "ours"  # theorems that are in no paper: each is an entry as well
PARTS = (*PAPERS, OURS)
KINDS = ("definition", "claim", "algorithm", "data")


@dataclass(frozen=True)
class Misprint:
    """What a page prints, or the scan leaves, and what it should say.

    Attributes
    ----------
    printed, correct : str
    tried : str
        The step, test or entry of an errata module that tries both; empty where
        letters were lost and there is nothing to try.
    """

    printed: str
    correct: str
    tried: str = ""


@dataclass(frozen=True)
class Entry:
    """One numbered equation, a displayed definition without a number, or our theorem.

    Attributes
    ----------
    paper, number : str
        Key of the paper, as in `PARTS`; the number as printed.  Of our own theorems the
        key is `OURS`, and a name takes the place of the number.
    says : Words
        The equation in our words and letters; its formulas are those of the evidence.
    kind : str
        One of `KINDS`.
    level : str
        How well it is established: "proved at symbolic sizes", "proved at sizes
        n = 3, ..", "reproduced to ..".
    evidence : tuple of str
        "room.module: step" or "room.module.function: step" of the derivations of a
        paper or of a room of our own, where a step is named in full or up to the
        sizes at its end; or "tests/room/test_file.py::test".
    used : str
        The public function or type that uses it.
    shown : str
        "notebook: words of a cell", or empty.
    misprints : tuple of Misprint
    """

    paper: str
    number: str
    says: Words
    kind: str
    level: str
    evidence: tuple[str, ...]
    used: str
    shown: str = ""
    misprints: tuple[Misprint, ...] = ()

    @property
    def source(self) -> str:
        """The paper as it is cited, or "Our own"."""
        return title(self.paper)

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        return asdict(self) | {"says": str(self.says), "source": self.source}


@cache
def _file(paper: str) -> dict[str, Any]:
    text = files(__package__).joinpath("entries", f"{paper}.toml").read_text("utf-8")
    return tomllib.loads(text)


@cache
def _entries(paper: str) -> tuple[Entry, ...]:
    found = []
    for row in _file(paper)["entry"]:
        fields = row | {
            "says": Words(row["says"]),
            "evidence": tuple(row["evidence"]),
            "misprints": tuple(Misprint(**slip) for slip in row.get("misprint", ())),
        }
        fields.pop("misprint", None)
        found.append(Entry(paper, **fields))
    return tuple(found)


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
