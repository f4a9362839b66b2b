"""The equation ledger: every numbered equation of the papers, and what vouches for it.

The entries are data, one file for each paper in `papers/`; they point at code.  An
entry's evidence is a proved step of a derivation, or a test; `ledger.evidence` finds
it.  The tests run every piece of evidence, damage it, and see it fail.

>>> from luenberger import ledger
>>> entry, = ledger.entries("moore", number="(5)")
>>> entry.says
'T A - F T = D C: what z tracks moves as z does.'
"""

import tomllib
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files

from ..show import Table

# The papers in the order in which they are dealt with; the keys name the files.
PAPERS = (
    "leondes_novak",
    "moore",
    "haddad_bernstein",
    "van_dooren",
    "kawazoe",
    "hsia",
)
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
    """One numbered equation, or a displayed definition without a number.

    Attributes
    ----------
    paper, number : str
        Key of the paper, as in `PAPERS`; the number as printed.
    says : str
        The equation in our words and letters.
    kind : str
        One of `KINDS`.
    level : str
        How well it is established: "proved at symbolic sizes", "proved at sizes
        n = 3, ..", "reproduced to ..".
    evidence : tuple of str
        "module: step" or "module.function: step" of `luenberger.derivations`, where
        a step is named in full or up to the sizes at its end; or
        "tests/test_file.py::test".
    used : str
        The public function or type that uses it.
    shown : str
        "notebook: words of a cell", or empty.
    misprints : tuple of Misprint
    """

    paper: str
    number: str
    says: str
    kind: str
    level: str
    evidence: tuple
    used: str
    shown: str = ""
    misprints: tuple = ()

    @property
    def source(self):
        """The paper as it is cited."""
        return title(self.paper)

    def as_dict(self):
        """Plain data, for JSON."""
        return asdict(self) | {"source": self.source}


@cache
def _file(paper):
    text = files(__package__).joinpath("papers", f"{paper}.toml").read_text("utf-8")
    return tomllib.loads(text)


@cache
def _entries(paper):
    found = []
    for row in _file(paper)["entry"]:
        misprints = tuple(Misprint(**slip) for slip in row.pop("misprint", ()))
        evidence = tuple(row.pop("evidence"))
        found.append(Entry(paper, evidence=evidence, misprints=misprints, **row))
    return tuple(found)


def title(paper):
    """How a paper is cited, by its key."""
    return _file(paper)["paper"]


def find_paper(name):
    """The key of a paper from part of its key or title, in any case.

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
        for paper in PAPERS
        if wanted in paper or wanted in title(paper).casefold() or wanted == "all"
    ]
    if not wanted or len(hits) != 1:
        problem = "no paper" if not hits else "more than one paper"
        raise ValueError(f"{problem} is called {name!r}: give one of {_listed()}")
    return hits[0]


def _listed():
    return ", ".join(repr(paper) for paper in PAPERS)


def entries(paper=None, *, number=None):
    """The entries of one paper or of all, in page order.

    Parameters
    ----------
    paper : str, optional
        Part of a paper's key or title, e.g. "moore".
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
    papers = PAPERS if paper is None else (find_paper(paper),)
    found = (entry for key in papers for entry in _entries(key))
    return tuple(entry for entry in found if number in (None, entry.number))


def count(paper=None):
    """Number of entries.

    >>> count("leondes"), count()
    (58, 192)
    """
    return len(entries(paper))


def misprints(paper=None):
    """Every misprint as (entry, misprint), in page order."""
    return tuple((e, slip) for e in entries(paper) for slip in e.misprints)


def table(paper=None):
    """The entries as a `show.Table`: number, what it says, kind, level, user."""
    header = ["equation", "says", "kind", "evidence", "used by"]
    header = header if paper is not None else ["paper", *header]
    rows = []
    for e in entries(paper):
        row = [e.number, e.says, e.kind, e.level, e.used.removeprefix("luenberger.")]
        rows.append(row if paper is not None else [e.source, *row])
    return Table(header, rows)


def summary():
    """One row for each paper: entries by kind, and misprints.

    >>> print(str(summary()).splitlines()[-1].split())
    ['all', '192', '71', '93', '16', '12', '94']
    """
    rows = [_counted(title(paper), paper) for paper in PAPERS]
    return Table(
        [
            "paper",
            "entries",
            *(f"{kind}s" for kind in KINDS[:3]),
            "data",
            "misprinted or lost",
        ],
        [*rows, _counted("all")],
        marked={len(rows)},
    )


def _counted(name, paper=None):
    kinds = [entry.kind for entry in entries(paper)]
    of_kind = [kinds.count(kind) for kind in KINDS]
    return [name, len(kinds), *of_kind, len(misprints(paper))]


def misprint_table(paper=None):
    """What is printed, and what is correct, place by place."""
    rows = [
        [e.source, e.number, slip.printed, slip.correct] for e, slip in misprints(paper)
    ]
    return Table(["paper", "equation", "printed or scanned", "correct"], rows)


def write_page(path, paper=None, *, formulas=True):
    """Write the ledger as one HTML page that needs no network and runs no script.

    Parameters
    ----------
    path : str or Path
        Written beside and renamed, so that an interrupted run leaves the old file.
    paper : str, optional
        One paper instead of all.
    formulas : bool
        With the proved claims, as MathML; this runs the derivations, which takes half
        a minute.  Without them the page is written at once.

    Raises
    ------
    ValueError
        If there is no such paper.
    ModuleNotFoundError
        If `latex2mathml`, of luenberger[report], is not installed and formulas are
        wanted.
    """
    from .page import write

    write(path, paper, formulas)
