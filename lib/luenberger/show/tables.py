"""Tables and paragraphs: a notebook shows them as HTML, a terminal as text."""

from __future__ import annotations

import html
from collections.abc import Iterable

Cells = Iterable[object]  # of a row: shown as str() gives them
MARKDOWN = str.maketrans({sign: f"\\{sign}" for sign in "\\`*_{}[]<>#|~$"})
LATEX = str.maketrans(
    {sign: f"\\{sign}" for sign in "&%$#_{}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}"}
    | {"^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}"}
    | {"|": r"\textbar{}", "[": "{[}", "]": "{]}"}
)


class Table:
    """Rows of text under a header; a notebook shows it as HTML, a terminal as text.

    >>> Table(["design", "order"], [["Kalman filter", "3"], ["minimal", "1"]])
    design         order
    Kalman filter      3
    minimal            1
    """

    def __init__(
        self, header: Cells, rows: Iterable[Cells], marked: Iterable[int] = ()
    ) -> None:
        self.header = [str(cell) for cell in header]
        rows = [list(row) for row in rows]
        self.rows = [[str(cell) for cell in row] for row in rows]
        self.markup = [[_markup(cell) for cell in row] for row in rows]
        self.marked = set(marked)  # indices of the rows to set in bold

    def __repr__(self) -> str:
        lines = [self.header, *self.rows]
        wide = [max(len(line[k]) for line in lines) for k in range(len(self.header))]
        right = self._numeric()
        return "\n".join(
            "  ".join(
                cell.rjust(w) if r else cell.ljust(w)
                for cell, w, r in zip(line, wide, right)
            ).rstrip()
            for line in lines
        )

    def _repr_html_(self) -> str:
        right = [' class="number"' if numeric else "" for numeric in self._numeric()]
        lines = ["<table>", _row("th", map(_markup, self.header), right)]
        for k, cells in enumerate(self.markup):
            lines.append(_row("td", cells, right, k in self.marked))
        return "\n".join([*lines, "</table>"])

    def to_markdown(self) -> str:
        """The table in Markdown, marked rows in bold; text stays text.

        >>> print(Table(["output", "n"], [["y_1", 3]], marked=[0]).to_markdown())
        | output | n |
        | :--- | ---: |
        | **y\\_1** | **3** |
        """
        rows = self._set(MARKDOWN, "**{}**")
        rule = ["---:" if numeric else ":---" for numeric in self._numeric()]
        lines = [[_escaped(cell, MARKDOWN) for cell in self.header], rule, *rows]
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def to_latex(self) -> str:
        """The table as a tabular of LaTeX without packages; text stays text.

        >>> print(Table(["output", "n"], [["y_1", 3]], marked=[0]).to_latex())
        \\begin{tabular}{lr}
        \\hline
        output & n \\\\
        \\hline
        \\textbf{y\\_1} & \\textbf{3} \\\\
        \\hline
        \\end{tabular}
        """
        columns = "".join("r" if numeric else "l" for numeric in self._numeric())
        header = [_escaped(cell, LATEX) for cell in self.header]
        rows = self._set(LATEX, r"\textbf{{{}}}")
        lines = [rf"{' & '.join(line)} \\" for line in (header, *rows)]
        begin, rule = rf"\begin{{tabular}}{{{columns}}}", r"\hline"
        body = [begin, rule, lines[0], rule, *lines[1:], rule, r"\end{tabular}"]
        return "\n".join(body)

    def _set(self, signs: dict[int, str], bold: str) -> list[list[str]]:
        """The rows in a markup, marked ones in bold."""
        return [
            [
                bold.format(text) if text and k in self.marked else text
                for text in (_escaped(cell, signs) for cell in row)
            ]
            for k, row in enumerate(self.rows)
        ]

    def _numeric(self) -> list[bool]:
        """Whether each column holds numbers, and is set flush right."""
        return [
            any(row[k] for row in self.rows)
            and all(row[k][:1] in "0123456789-" for row in self.rows)
            for k in range(len(self.header))
        ]


def _escaped(cell: str, signs: dict[int, str]) -> str:
    """A cell on one line, its signs as a markup writes them."""
    return " ".join(cell.split()).translate(signs)


def _markup(cell: object) -> str:
    """A cell in HTML: its own, or its text."""
    own = getattr(cell, "_repr_html_", None)
    return own() if own else html.escape(str(cell))


def _row(tag: str, cells: Iterable[str], styles: list[str], bold: bool = False) -> str:
    cells = [f"<b>{cell}</b>" for cell in cells] if bold else list(cells)
    tags = [tag if cell else "td" for cell in cells]  # no header without words
    inner = "".join(f"<{t}{s}>{cell}</{t}>" for t, s, cell in zip(tags, styles, cells))
    return f"<tr>{inner}</tr>"


class Prose:
    """Paragraphs of plain text; names from a user's file stay text, never markup.

    >>> Prose("One sentence.", "And another.")
    One sentence.
    And another.
    """

    def __init__(self, *paragraphs: str, heading: str | None = None) -> None:
        self.paragraphs, self.heading = paragraphs, heading

    def __repr__(self) -> str:
        return "\n".join(filter(None, [self.heading, *self.paragraphs]))

    def _repr_html_(self) -> str:
        lines = [f"<p>{html.escape(p)}</p>" for p in self.paragraphs]
        if self.heading:
            lines.insert(0, f"<h1>{html.escape(self.heading)}</h1>")
        return "\n".join(lines)
