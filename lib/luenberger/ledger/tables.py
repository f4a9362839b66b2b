"""The ledger as tables: of entries, of counts, of misprints."""

import html

from ..show import Table
from .records import KINDS, PARTS, count, entries, misprints, title


def table(paper: str | None = None) -> Table:
    """The entries as a `show.Table`: number, what it says, kind, level, user."""
    header = ["equation", "says", "kind", "evidence", "used by"]
    header = header if paper is not None else ["paper", *header]
    rows = []
    for e in entries(paper):
        row = [e.number, e.says, e.kind, e.level, e.used.removeprefix("luenberger.")]
        rows.append(row if paper is not None else [e.source, *row])
    return Table(header, rows)


def summary() -> Table:
    """One row for each paper, one for our own: entries by kind, and misprints.

    >>> print(str(summary()).splitlines()[2].split())
    ['Moore', '(1973)', '15', '5', '7', '3', '0', '10']
    """
    rows = [_counted(title(paper), paper) for paper in PARTS]
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


def _counted(name: str, paper: str | None = None) -> list[object]:
    kinds = [entry.kind for entry in entries(paper)]
    of_kind = [kinds.count(kind) for kind in KINDS]
    return [name, len(kinds), *of_kind, len(misprints(paper))]


def misprint_table(paper: str | None = None) -> Table:
    """What is printed, and what is correct, place by place."""
    rows = [
        [e.source, e.number, slip.printed, slip.correct] for e, slip in misprints(paper)
    ]
    return Table(["paper", "equation", "printed or scanned", "correct"], rows)


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
