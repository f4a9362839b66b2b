"""The ledger as tables: of entries, of counts, of misprints."""

import html

from ..show import Table
from .records import KINDS, PARTS, Entry, count, entries, find_paper, misprints, title


def table(paper: str | None = None) -> Table:
    """The entries as a `show.Table`: number, what it says, level, user."""
    header = ["equation", "says", "level", "used by"]
    header = header if paper is not None else ["paper", *header]
    rows = []
    for e in entries(paper):
        row = [e.number, e.says, e.level, e.used_by]
        rows.append(row if paper is not None else [e.source, *row])
    return Table(header, rows)


def summary() -> Table:
    """One row for each paper, one for our own: entries, and what is wrong by kind.

    >>> print(str(summary()).splitlines()[2].split())
    ['Moore', '(1973)', '15', '7', '0', '3']
    """
    header = ["paper", "entries", *(f"wrong {where}" for where in KINDS.values())]
    rows = [_counted(title(paper), paper) for paper in PARTS]
    return Table(header, [*rows, _counted("all")], marked={len(rows)})


def _counted(name: str, paper: str | None = None) -> list[object]:
    kinds = [slip.kind for _, slip in misprints(paper)]
    return [name, count(paper), *map(kinds.count, KINDS)]


LEVELS = (
    "let or supposed",
    "proved at all sizes",
    "in part at explicit sizes",
    "at explicit sizes",
    "by numbers",
)


def _level(entry: Entry) -> str:
    """Which of `LEVELS` an entry is at."""
    proved = [one for one in entry.says if one.proved]
    explicit = [one for one in proved if one.explicit]
    if not entry.says:
        return "by numbers"
    if not proved:
        return "let or supposed"
    if not explicit:
        return "proved at all sizes"
    part = len(explicit) < len(proved)
    return "in part at explicit sizes" if part else "at explicit sizes"


def levels(paper: str | None = None) -> Table:
    """Entries by how they are established: a row for each paper, or for one."""
    parts = PARTS if paper is None else (find_paper(paper),)
    rows = []
    for part in (*parts, None)[: len(parts) + (paper is None)]:
        found = list(map(_level, entries(part)))
        counts = map(found.count, LEVELS)
        rows.append([title(part) if part else "all", len(found), *counts])
    marked = {len(PARTS)} if paper is None else ()
    return Table(["paper", "entries", *LEVELS], rows, marked=marked)


def misprint_table(paper: str | None = None) -> Table:
    """What our scan has, what is correct, and whose fault it is, place by place."""
    rows = [
        [e.source, e.number, slip.printed, slip.correct, slip.where]
        for e, slip in misprints(paper)
    ]
    header = ["paper", "equation", "is", "should be", "where"]
    return Table(header, rows)


class Folded:
    """Tables under headings that a notebook unfolds; a terminal shows the headings.

    Attributes
    ----------
    tables : dict of str to Table
    """

    def __init__(self, tables: dict[str, Table]) -> None:
        self.tables = dict(tables)

    def __repr__(self) -> str:
        return "\n".join(self.tables)

    def _repr_html_(self) -> str:
        return "\n".join(
            f"<details><summary>{html.escape(heading)}</summary>\n"
            f"{table._repr_html_()}</details>"
            for heading, table in self.tables.items()
        )


def by_paper() -> Folded:
    """Every entry, one folded table for each paper and our own, with its count.

    >>> list(by_paper().tables)[1]
    'Moore (1973): 15 entries'
    """
    return Folded({f"{title(p)}: {count(p)} entries": table(p) for p in PARTS})
