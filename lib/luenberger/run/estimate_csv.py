"""An observer run over a table of any length, in memory that does not grow."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

import numpy as np

from ..at_work import start
from ..certificate import require_match
from ..errors import few, short
from ..formats.csv_reader import Rows, Table
from ..formats.spreadsheets import require_plain
from ..numeric import Matrix, Vector
from ..numeric.validation import names
from ..observer import Observer
from ..plant import Plant
from .clock import Column
from .estimate import estimated
from .measurements import require_finite, time_column

Piece = tuple[Rows, np.ndarray]  # some rows of a table, the estimates at them


def estimates(
    observer: Observer, table: Table, plant: Plant | None = None
) -> tuple[list[str], Iterator[Piece]]:
    """Run an observer over a table; memory does not grow with its length.

    Parameters
    ----------
    observer : Observer
    table : Table
        With a column for each of its outputs and inputs, among others; the names are
        the observer's own, or the plant's, or else y1, y2, ..., u1, u2, ...
    plant : Plant, optional
        Its mean x0, carried to the first sample, is where the estimates start.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", and the names of the estimates.
    rows : iterator of (Rows, (N, q) ndarray)
        Some rows of the table, and the estimates at them.

    Raises
    ------
    ValueError
        Naming line and column, if a value is missing, an estimate overflows, or a
        time is none or contradicts dt.
    """
    x0 = None
    if plant is not None:
        observer = _named(observer, plant)
        x0 = plant.x0 if observer.steps else plant.first_step()[0] @ plant.x0
    outputs = observer.output_names or names("y output", None, observer.D.shape[-1])
    inputs = observer.input_names or names("u input", None, observer.G.shape[-1])
    clock = time_column(table, outputs, inputs, others=True)
    header = [clock or "instant", *observer.estimate_names]
    if header[0] in header[1:]:
        raise ValueError(
            f"{table.where}: {short(header[0])} would be the name of a column of times "
            "and of an estimate; rename one"
        )
    require_plain("state", observer.estimate_names)
    rows = table.rows([*outputs, *inputs], outputs, clock)
    times = None if clock is None else Column(clock, observer)
    return header, _estimated(observer, table, rows, outputs, x0, times)


def _named(observer: Observer, plant: Plant) -> Observer:
    """The observer with the names of its plant, once they are seen to fit."""
    require_match(observer, plant)
    for kind in ("state", "output", "input"):
        mine, theirs = (getattr(one, f"{kind}_names") for one in (observer, plant))
        if mine and mine != theirs:
            raise ValueError(
                f"the observer's {kind}s are {few(mine)} and the plant's "
                f"{few(theirs)}; give the plant that the observer was designed for"
            )
    return observer.named(plant)


def _estimated(
    observer: Observer,
    table: Table,
    rows: Iterator[Rows],
    outputs: Sequence[str],
    x0: Vector | None,
    times: Column | None,
) -> Iterator[Piece]:
    """The pieces of a table with their estimates; no piece is kept."""
    state = 0, start(observer, x0=x0)
    for piece in rows:
        lines = piece.lines

        def at(k: int, lines: Sequence[int] = lines) -> str:
            return table.at(lines[k])

        if times is not None:
            times.seconds(piece.carried, at)
        y, u = _measured(table, outputs, piece), piece.values[:, len(outputs) :]
        state, x = estimated(observer, state, y, u)
        require_finite(x, observer.estimate_names, at)
        yield piece, x


def _measured(table: Table, outputs: Sequence[str], piece: Rows) -> Matrix:
    """The measurements of some rows, none of which may be missing."""
    y = piece.values[:, : len(outputs)]
    if np.isnan(y).any():
        k, j = np.argwhere(np.isnan(y))[0]
        raise ValueError(
            f"{table.at(piece.lines[k])}: {short(outputs[j])} was not measured, and an "
            "observer whose gains are fixed beforehand cannot leave a measurement out. "
            "`python -m luenberger filter PLANT.json` can, and so does lb.Filter(plant)"
        )
    return y


def write(file: TextIO, header: Sequence[str], rows: Iterable[Piece]) -> int:
    """Write what `estimates` returns to an open file; returns the number of rows."""
    csv.writer(file, lineterminator="\n").writerow(header)
    count = 0
    for piece, x in rows:
        if not len(x):
            continue
        times = piece.carried or map(str, range(count + 1, count + len(x) + 1))
        numbers = repr(x.tolist())[2:-2].replace(", ", ",").split("],[")
        file.write("".join([f"{time},{row}\n" for time, row in zip(times, numbers)]))
        count += len(x)
    return count
