"""A CSV file of numbers, read a piece at a time: memory does not grow with the file.

It is the standard library's `csv`, so that a cell that is wrong is named by its line.
"""

import csv
import math
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import short

PIECE = 1 << 18  # bytes that are parsed at once
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
MISSING = ("", "nan", "+nan", "-nan")


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows of a table.

    Attributes
    ----------
    lines : list of int
        The line of the file that each row is on.
    carried : list of str
        The cells of the column that is only carried along, as CSV; or empty.
    values : (N, k) ndarray
        The wanted columns, in the order in which they were asked for.
    texts : sequence of list of str
        The cells of each column that was wanted as it stands.
    """

    lines: list[int]
    carried: list[str]
    values: np.ndarray
    texts: Sequence[list[str]] = ()


class Table:
    """The rows of an open CSV file.

    Parameters
    ----------
    file : binary file
    where : str or Path
        What messages call it.
    piece : int
        About how many bytes are parsed at once.

    Attributes
    ----------
    header : list of str
        Names of the columns, from the first line that is not blank.
    """

    def __init__(self, file: BinaryIO, where: str | Path, piece: int = PIECE) -> None:
        self.file, self.where, self.piece = file, where, piece
        self.line = self.blank = 0  # the last that was read, and that was blank
        while raw := file.readline():
            for _, cells in self._cells([raw]):
                self.header, self.blank = [cell.strip() for cell in cells], 0
                return
        raise ValueError(f"{where}: the file is empty")

    def rows(
        self,
        wanted: Sequence[str],
        may_miss: Collection[str] = (),
        carry: str | None = None,
        texts: Sequence[str] = (),
    ) -> Iterator[Rows]:
        """Yield the rows that follow the header, as `Rows`.

        Parameters
        ----------
        wanted : sequence of str
            Columns of numbers; blanks around their names do not count.
        may_miss : collection of str
            Those in which a cell may be empty or `nan`; both give NaN.
        carry : str, optional
        texts : sequence of str
            Columns of any text.

        Raises
        ------
        ValueError
            Naming the line, and the column where it is a cell that is wrong.
        """
        none = True
        place = {name: j for j, name in enumerate(self.header)}
        wanted, texts = ([name.strip() for name in names] for names in (wanted, texts))
        may_miss = {name.strip() for name in may_miss}
        while raw := self.file.readlines(self.piece):
            lines, rows = [], []
            for line, cells in self._cells(raw):
                self._require_width(line, cells)
                lines.append(line)
                rows.append(cells)
            if not rows:
                continue
            none = False
            columns = [[cell.strip() for cell in column] for column in zip(*rows)]
            values = np.empty((len(rows), len(wanted)))
            for j, name in enumerate(wanted):
                own = columns[place[name]]
                values[:, j] = self._numbers(name, own, lines, name in may_miss)
            carried = (
                [] if carry is None else [as_csv(c) for c in columns[place[carry]]]
            )
            yield Rows(lines, carried, values, [columns[place[name]] for name in texts])
        if none:
            raise ValueError(
                f"{self.where}: there are column names but no measurements"
            )

    def at(self, line: int) -> str:
        """How messages begin."""
        return f"{self.where}, line {line}"

    def _cells(self, raw: list[bytes]) -> Iterator[tuple[int, list[str]]]:
        """Number and cells of each of the next lines that is not blank."""
        line, content = self.line, b"".join(raw)
        self.line += len(raw)
        try:
            text = content.decode("utf-8" if line else "utf-8-sig")
        except UnicodeDecodeError as error:
            at = self.at(line + 1 + content.count(b"\n", 0, error.start))
            raise ValueError(
                f"{at}: not UTF-8 text: the byte 0x{content[error.start]:02x}; save "
                "the file as UTF-8"
            ) from None
        lines = text.split("\n")[: len(raw)]
        reader = csv.reader(lines, strict=True)
        while (done := reader.line_num) < len(lines):
            at = self.at(line + done + 1)
            try:
                cells = next(reader)
            except csv.Error as error:
                why = "a quotation mark is not closed on its line, or text follows it"
                if "new-line" in str(error):
                    why = "a carriage return that does not end the line"
                if "field limit" in str(error):
                    why = "a cell that is too long for one of a table"
                raise ValueError(f"{at}: {why}") from None
            if reader.line_num > done + 1:
                raise ValueError(f"{at}: a quotation mark is not closed on its line")
            if lines[done].strip():
                yield line + done + 1, cells
            else:
                self.blank = line + done + 1

    def _require_width(self, line: int, cells: list[str]) -> None:
        if len(cells) != len(self.header):
            raise ValueError(
                f"{self.at(line)}: {len(cells)} cells, but the header names "
                f"{len(self.header)} columns"
            )
        if self.blank and len(self.header) == 1:
            raise ValueError(
                f"{self.at(self.blank)}: blank, with more lines after it; write nan "
                "for a measurement that is missing"
            )

    def _numbers(
        self, name: str, cells: list[str], lines: list[int], may_miss: bool
    ) -> np.ndarray:
        """The numbers of a column, NaN for those that may be missing and are."""
        try:
            found = np.array([float(cell or "nan") for cell in cells])
            fit = np.isfinite(found) | (np.isnan(found) & may_miss)
            text = "".join(cells)  # float() takes 1_0, and digits of every script
            if fit.all() and text.isascii() and "_" not in text:
                return found
        except ValueError:
            pass
        wrong = (k for k, cell in enumerate(cells) if not _fits(cell, may_miss))
        k = next(wrong)
        hint = "; write a point before the decimals" if "," in cells[k] else ""
        raise ValueError(
            f"{self.at(lines[k])}: {short(name)} is {short(cells[k])}, not a number"
            f"{hint}"
        )


def _fits(cell: str, may_miss: bool) -> bool:
    if cell.lower() in MISSING:
        return may_miss
    return bool(NUMBER.fullmatch(cell)) and math.isfinite(float(cell))


def as_csv(text: str) -> str:
    """A cell as it stands in a CSV file."""
    marked = any(mark in text for mark in ',"\r\n')
    return '"' + text.replace('"', '""') + '"' if marked else text


def separator(header: list[str]) -> str | None:
    """What else than commas seems to separate the cells of a header, or None."""
    only = header[0] if len(header) == 1 else ""
    return next((name for mark, name in SEPARATORS.items() if mark in only), None)
