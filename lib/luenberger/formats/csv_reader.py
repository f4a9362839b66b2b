"""A CSV file of numbers, read a piece at a time: memory does not grow with the file.

A piece that is plain (no quotes, equally many cells in every line) is parsed by NumPy.
Any other is read cell by cell, which is slower and finds the line and the column at
fault.  Both give the same numbers.
"""

import csv
import io
import math
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import short
from .json_files import named

PIECE = 1 << 18  # bytes that are parsed at once
LINE = 1 << 20  # bytes of the longest line; a longer one is not of a table
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}
GAP = re.compile("(?<![^,\n])(?=[,\n])")  # where a cell is empty
UTF16 = (b"\xff\xfe", b"\xfe\xff")


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows of a table.

    Attributes
    ----------
    lines : (N,) sequence of int
        The line of the file that each row is on.
    carried : list of str
        The cells of the column that is only carried along, as CSV; or empty.
    values : (N, k) ndarray
        The wanted columns, in the order in which they were asked for.
    texts : sequence of list of str
        The cells of each column that was wanted as it stands.
    """

    lines: Sequence[int]
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
        Bytes to parse at once, at most `LINE`.

    Attributes
    ----------
    header : list of str
        Names of the columns, from the first line that is not blank.
    """

    def __init__(self, file: BinaryIO, where: str | Path, piece: int = PIECE) -> None:
        self.file, self.where, self.piece = file, where, piece
        self.line = 0
        self.blank: int | None = None
        self.header = self._read_header()

    def _read_header(self) -> list[str]:
        while raw := self._read(self.file.readline, LINE + 1):
            self.line += 1
            if self.line == 1 and raw.startswith(UTF16):
                raise ValueError(f"{self.where}: this is UTF-16; save it as UTF-8")
            raw = raw.removeprefix(b"\xef\xbb\xbf") if self.line == 1 else raw
            _require_line(self.where, self.line, len(raw.rstrip(b"\r\n")))
            if cells := self._cells(self.line, raw):
                return [cell.strip() for cell in cells]
        raise ValueError(f"{self.where}: the file is empty")

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
        place = {name: j for j, name in enumerate(self.header)}
        places = [place[name.strip()] for name in wanted]
        may_miss = np.array([name in may_miss for name in wanted], dtype=bool)
        carried = None if carry is None else place.get(carry)
        as_text = [carried, *(place[name.strip()] for name in texts)]
        none = True
        for line, text in self._pieces():
            found = self._plain(line, text, places, may_miss, as_text)
            if found is None:
                found = self._careful(line, text, places, may_miss, as_text)
            if len(found.lines):
                none = False
                yield found
        if none:
            raise ValueError(
                f"{self.where}: there are column names but no measurements"
            )

    def _pieces(self) -> Iterator[tuple[int, bytes]]:
        """Whole lines, about `piece` bytes of them, and the number of the first."""
        line, rest = self.line + 1, b""
        while block := self._read(self.file.read, self.piece):
            cut = block.rfind(b"\n") + 1
            first = block.find(b"\n") if cut else len(block)
            _require_line(self.where, line, len(rest) + first)
            if not cut:
                rest += block
                continue
            text = rest + block[:cut]
            yield line, text
            line, rest = line + text.count(b"\n"), block[cut:]
        if rest:
            yield line, rest + b"\n"

    def _read(self, how: Callable[[int], bytes], size: int) -> bytes:
        with named(self.where):
            return how(size)

    def _plain(
        self,
        line: int,
        text: bytes,
        places: list[int],
        may_miss: np.ndarray,
        as_text: list[int | None],
    ) -> Rows | None:
        """The rows of a piece without anything unusual, or None."""
        text, width = text.replace(b"\r\n", b"\n"), len(self.header)
        odd = any(mark in text for mark in (b'"', b"\r", b"\0", b"\n\n"))
        odd = odd or text.startswith(b"\n") or (self.blank and width == 1)
        if odd or not (text.isascii() and places):
            return None
        codes = np.frombuffer(text, dtype=np.uint8)
        ends = np.flatnonzero((codes == ord(",")) | (codes == ord("\n")))
        if len(ends) % width:
            return None
        last = (codes[ends] == ord("\n")).reshape(-1, width)
        if last[:, :-1].any() or not last[:, -1].all():
            return None
        text = text.decode("ascii")
        gaps = ends[0] == 0 or (np.diff(ends) == 1).any()
        full = GAP.sub("nan", text) if gaps else text
        try:
            values = np.loadtxt(
                io.StringIO(full, newline="\n"), delimiter=",", comments=None,
                usecols=places, ndmin=2,
            )  # fmt: skip
        except ValueError:
            return None
        if not (np.isfinite(values) | (np.isnan(values) & may_miss)).all():
            return None
        carried, *texts = (
            [] if j is None else _between(text, ends, j, width) for j in as_text
        )
        return Rows(range(line, line + len(values)), carried, values, texts)

    def _careful(
        self,
        line: int,
        text: bytes,
        places: list[int],
        may_miss: np.ndarray,
        as_text: list[int | None],
    ) -> Rows:
        """Read the rows of a piece cell by cell."""
        lines, values = [], []
        found: list[list[str]] = [[] for _ in as_text]
        for k, raw in enumerate(text.split(b"\n")[:-1], line):
            cells = self._cells(k, raw)
            if not cells:
                self.blank = k
                continue
            self._require_width(k, cells)
            lines.append(k)
            for column, j in zip(found, as_text):
                column += [] if j is None else [as_csv(cells[j].strip())]
            values.append(
                [
                    number(self.where, k, self.header[j], cells[j], missing)
                    for j, missing in zip(places, may_miss)
                ]
            )
        values = np.array(values, dtype=float).reshape(len(lines), len(places))
        return Rows(lines, found[0], values, found[1:])

    def at(self, line: int) -> str:
        """How messages begin."""
        return f"{self.where}, line {line}"

    def _require_width(self, line: int, cells: list[str]) -> None:
        if len(cells) != len(self.header):
            raise ValueError(
                f"{self.where}, line {line}: {len(cells)} cells, but the header names "
                f"{len(self.header)} columns"
            )
        if self.blank and len(self.header) == 1:
            raise ValueError(
                f"{self.where}, line {self.blank}: blank, with more lines after it; "
                "write nan for a measurement that is missing"
            )

    def _cells(self, line: int, raw: bytes) -> list[str]:
        """The cells of one line.  A blank line has none."""
        at = self.at(line)
        if b"\0" in raw:
            raise ValueError(f"{at}: a NUL byte, so this is not a CSV file")
        try:
            text = raw.decode("utf-8").removesuffix("\n").removesuffix("\r")
        except UnicodeDecodeError as error:
            byte = raw[error.start]
            raise ValueError(
                f"{at}: not UTF-8 text: the byte 0x{byte:02x}; save the file as UTF-8"
            ) from None
        if "\r" in text:
            raise ValueError(f"{at}: a carriage return that does not end the line")
        if not text.strip():
            return []
        if '"' not in text:
            return text.split(",")
        try:
            return next(csv.reader([text], strict=True))
        except csv.Error:
            raise ValueError(
                f"{at}: a quotation mark is not closed on its line, or text follows it"
            ) from None


def _require_line(where: str | Path, line: int, size: int) -> None:
    if size > LINE:
        raise ValueError(
            f"{where}, line {line}: longer than {LINE} bytes, so not a line of a table"
        )


def _between(text: str, ends: np.ndarray, column: int, width: int) -> list[str]:
    """The text of one column, given where every cell ends."""
    stops = ends[column::width]
    starts = np.append(-1, ends)[column::width][: len(stops)] + 1
    cuts = map(slice, starts.tolist(), stops.tolist())
    return list(map(str.strip, map(text.__getitem__, cuts)))


def number(
    where: str | Path, line: int, name: str, text: str, may_miss: bool = False
) -> float:
    """The number a cell holds, or NaN for one that may be missing and is."""
    text = text.strip()
    try:
        value = float(text or "nan")
    except ValueError:
        value = math.inf
    # float() also takes 1_0 and the digits of every script
    if math.isfinite(value) and "_" not in text and text.isascii():
        return value
    if math.isnan(value) and may_miss:
        return value
    hint = "; write a point before the decimals" if "," in text else ""
    raise ValueError(
        f"{where}, line {line}: {short(name)} is {short(text)}, not a number{hint}"
    )


def as_csv(text: str) -> str:
    """A cell as it stands in a CSV file."""
    marked = any(mark in text for mark in ',"\r\n')
    return '"' + text.replace('"', '""') + '"' if marked else text


def separator(header: list[str]) -> str | None:
    """What else than commas seems to separate the cells of a header, or None."""
    only = header[0] if len(header) == 1 else ""
    return next((name for mark, name in SEPARATORS.items() if mark in only), None)
