"""Numbers, tables and sentences that print the same on every machine.

Strict notebook tests compare text.  Everything a notebook prints therefore goes
through here: six significant digits at most, rounding noise and -0 shown as 0.
"""

from __future__ import annotations

import html
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

Cells = Iterable[object]  # of a row: shown as str() gives them
NOISE = 1e-12  # an entry this small beside the largest of its array is rounding


def number(value: complex, digits: int = 6, scale: float = 0.0) -> str:
    """One number as text; 0 where it is noise beside `scale`.

    >>> number(2 / 3), number(-0.0), number(3e-17, scale=1), number(1 - 2j, 3)
    ('0.666667', '0', '0', '1-2j')
    """
    if isinstance(value, int | np.integer):
        return str(value)
    value = complex(value)
    noise = NOISE * max(scale, abs(value)) if np.isfinite(value) else 0.0
    real, imag = (
        0.0 if abs(part) <= noise else part for part in (value.real, value.imag)
    )
    text = f"{real:.{digits}g}"
    return text if imag == 0 else f"{text}{imag:+.{digits}g}j"


def show(value: ArrayLike, label: str | None = None, digits: int = 6) -> None:
    """Print an array row by row, its columns aligned.

    >>> show([[1, 1e-20], [-0.0, 1 / 3]], "K")
    K =
    [1         0]
    [0  0.333333]
    """
    print("" if label is None else f"{label} =\n", array(value, digits), sep="")


def array(value: ArrayLike, digits: int = 6) -> str:
    """The text that `show` prints."""
    value = np.atleast_1d(np.asarray(value))
    finite = np.abs(value[np.isfinite(value)])
    scale = finite.max(initial=0.0)
    rows = value.reshape(-1, value.shape[-1]) if value.size else value.reshape(0, 0)
    cells = [[number(entry, digits, scale) for entry in row] for row in rows]
    if not cells:
        return f"empty, {' x '.join(map(str, value.shape))}"
    wide = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join(
        "[" + "  ".join(cell.rjust(w) for cell, w in zip(row, wide)) + "]"
        for row in cells
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
        self.rows = [[str(cell) for cell in row] for row in rows]
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
        lines = ["<table>", _row("th", self.header, right)]
        for k, cells in enumerate(self.rows):
            lines.append(_row("td", cells, right, k in self.marked))
        return "\n".join([*lines, "</table>"])

    def _numeric(self) -> list[bool]:
        """Whether each column holds numbers, and is set flush right."""
        return [
            any(row[k] for row in self.rows)
            and all(row[k][:1] in "0123456789-" for row in self.rows)
            for k in range(len(self.header))
        ]


def _row(tag: str, cells: list[str], styles: list[str], bold: bool = False) -> str:
    cells = [html.escape(cell) for cell in cells]
    cells = [f"<b>{cell}</b>" for cell in cells] if bold else cells
    inner = "".join(f"<{tag}{s}>{cell}</{tag}>" for cell, s in zip(cells, styles))
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
