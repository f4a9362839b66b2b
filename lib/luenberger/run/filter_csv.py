"""A plant's filter or smoother run over a table of any length, a few rows at a time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from ..errors import DesignError, few, short
from ..filtering import back
from ..filtering.pack import begin
from ..formats import csv_reader, time_stamps
from ..formats.csv_reader import Table
from ..formats.spreadsheets import require_plain
from ..numeric import Matrix, Vector
from ..plant import Plant
from .arrivals import set_back
from .clock import Column, leading
from .estimate_csv import Piece
from .filter import Filter
from .measurements import require_finite, time_column
from .record import Rows
from .smoothed import over

NEVER = ("", "nan", "nat")  # cells of readings that do not arrive
MICROSECOND = 1e-6  # the last digit of a date
Read = tuple[csv_reader.Rows, Rows]  # some rows of a table, and what they hold
Found = tuple[csv_reader.Rows, Matrix, Matrix]  # estimates and deviations at them


def estimates(
    plant: Plant,
    table: Table,
    undriven: bool = False,
    arrival: Mapping[str, str] | None = None,
) -> tuple[list[str], Iterator[Piece]]:
    """Filter a table; memory does not grow with its length.

    Parameters
    ----------
    plant : Plant
        With Q and R, continuous or discrete.  Its names are those of the columns, among
        others; empty cells of outputs were not measured.  Times agree with dt, or say
        when a continuous plant is sampled.
    table : Table
    undriven : bool
        No known input acts, so no column of one is needed.
    arrival : dict of str to str, optional
        Of outputs that may be late, the column that says when a reading is known:
        numbers or dates like those in the column of times, or numbers of rows from 1
        on where there is none.  A reading whose cell is empty never arrives.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", then each state and its one sigma.
    rows : iterator of (Rows, (N, 2 n) ndarray)

    Raises
    ------
    ValueError
        Naming line and column, as `estimate_csv.estimates`; and as `Filter.run`; if a
        reading arrives before it was measured, or the cell that says when is not of the
        kind of the times.
    """
    header, parts = _reads(plant, table, undriven, arrival or {})
    return header, _paired(plant, table, _filtered(Filter(plant), parts))


def smoothed(
    plant: Plant, table: Table, lag: int | None = None, undriven: bool = False
) -> tuple[list[str], Iterator[Piece]]:
    """Smooth a table; `lag` as in `Filter.smooth`, and without one it is held whole.

    What is returned and raised is as in `estimates`.
    """
    header, parts = _reads(plant, table, undriven, {})
    if lag is None:
        return header, _paired(plant, table, _whole(Filter(plant), parts))
    return header, _paired(plant, table, _lagged(Filter(plant), parts, lag))


def _filtered(run: Filter, parts: Iterator[Read]) -> Iterator[Found]:
    """Each part from the end of the one before."""
    end = None
    for rows, part in parts:
        found = run.over(part, end)
        end = found.end
        yield rows, found.x, found.std


def _whole(run: Filter, parts: Iterator[Read]) -> Iterator[Found]:
    """All parts together, and then of each part its rows."""
    rows, held = zip(*parts)
    found, k = over(run, _joined(held)), 0
    for one in rows:
        own = slice(k, k + len(one.lines))
        yield one, found.x[own], found.std[own]
        k = own.stop


def _lagged(run: Filter, parts: Iterator[Read], lag: int) -> Iterator[Found]:
    """Each part as soon as so many rows behind it are there."""
    held: deque[Read] = deque()
    more, start = 0, None  # rows behind the first that is held
    for part in chain(parts, [None]):
        if part is not None:
            more += len(part[0].lines) if held else 0
            held.append(part)
        while held and (part is None or more >= lag):
            rows, first = held.popleft()
            more -= len(held[0][0].lines) if held else 0
            known = _joined([first, *(one for _, one in held)], len(first.y) + lag)
            settings = next(run.parts(known, start.instant if start else 0))[1]
            start = start or begin(settings, first.u0)
            windows = [*run._windows(known, start, "all")]
            passed = back.Passed.of(windows, settings)
            found, own = back.smoothed(passed, lag, whole=False), slice(len(first.y))
            std = np.sqrt(np.maximum(found.variances[own], 0.0))
            yield rows, found.z[own, : run.plant.n], std
            for one in run._windows(first, start, "all"):
                start = one.end


def _joined(parts: Iterable[Rows], most: int | None = None) -> Rows:
    """Parts of a record as one, or the first rows of them."""
    y, u, u0, periods, *_ = zip(*parts)
    steps = None if periods[0] is None else np.concatenate(periods)[:most]
    return Rows(np.concatenate(y)[:most], np.concatenate(u)[:most], u0[0], steps)


def _paired(plant: Plant, table: Table, found: Iterator[Found]) -> Iterator[Piece]:
    """Rows of a table with their estimates and one sigmas side by side."""
    with np.errstate(over="ignore", invalid="ignore"):
        for rows, x, std in found:
            require_finite(x, plant.state_names, partial(_line, table, rows))
            yield rows, np.stack([x, std], axis=2).reshape(len(x), 2 * plant.n)


def _line(table: Table, rows: csv_reader.Rows, k: int) -> str:
    return table.at(rows.lines[k])


def _reads(
    plant: Plant, table: Table, undriven: bool, arrival: Mapping[str, str]
) -> tuple[list[str], Iterator[Read]]:
    """The header of estimates with their sigmas, and the rows of a plant's record."""
    outputs = plant.output_names
    if foreign := [name for name in arrival if name not in outputs]:
        raise ValueError(f"--arrival has {few(foreign)}; outputs are {few(outputs)}")
    if lacking := [name for name in arrival.values() if name not in table.header]:
        raise ValueError(f"{table.where} lacks the columns {few(lacking)} of arrivals")
    inputs = () if undriven else plant.input_names
    clock = time_column(table, outputs, inputs, others=True)
    if plant.dt == 0 and clock is None:
        raise DesignError(
            f"the plant is continuous, and {table.where} has no column 'time'; add it, "
            "or give --sample DT, how many seconds its rows are apart"
        )
    pairs = [name + wide for name in plant.state_names for wide in ("", "_sigma")]
    header = [clock or "instant", *pairs]
    if len(set(header)) < len(header):
        twice = next(name for name in header if header.count(name) > 1)
        raise ValueError(
            f"{table.where}: {short(twice)} would be the name of two columns; rename "
            "a state or the column of times"
        )
    require_plain("state", plant.state_names)
    given = [*outputs, *inputs], {*outputs}, clock, [*arrival.values()]
    times = None if clock is None else Column(clock, plant)
    return header, _read(plant, table, table.rows(*given), times, arrival)


def _read(
    plant: Plant,
    table: Table,
    pieces: Iterator[csv_reader.Rows],
    times: Column | None,
    arrival: Mapping[str, str],
) -> Iterator[Read]:
    """The rows, with the periods that lead to them and what arrivals are told by."""
    if plant.dt == 0:
        pieces = _two_first(pieces)
    last, count = np.empty(0), 0
    for rows in pieces:
        at, N = partial(_line, table, rows), len(rows.lines)
        y, u = np.split(rows.values, [plant.p], axis=1)
        u = u if u.shape[1] else np.zeros((N, plant.m))
        labels, steps, due = np.arange(count + 1.0, count + 1 + N), None, None
        if times is not None:
            labels = times.seconds(rows.carried, at)
        if plant.dt == 0:
            steps = leading(last, labels, at)
        if arrival:
            y, due = _late(plant, table, rows, labels, last, times, y, arrival)
        part = Rows(y, u, np.zeros(plant.m), steps, due, labels if arrival else None)
        yield rows, part
        last, count = labels[-1:], count + N


def _two_first(pieces: Iterator[csv_reader.Rows]) -> Iterator[csv_reader.Rows]:
    """The same, but the first piece has two rows: no period leads to a single one."""
    first = next(pieces)
    while len(first.lines) < 2 and (more := next(pieces, None)) is not None:
        first = csv_reader.Rows(
            [*first.lines, *more.lines],
            [*first.carried, *more.carried],
            np.concatenate([first.values, more.values]),
            [[*a, *b] for a, b in zip(first.texts, more.texts)],
        )
    yield from chain([first], pieces)


def _late(
    plant: Plant,
    table: Table,
    rows: csv_reader.Rows,
    labels: Vector,
    last: Vector,
    times: Column | None,
    y: Matrix,
    arrival: Mapping[str, str],
) -> tuple[Matrix, Matrix]:
    """Readings that arrive, and labels of the rows at which they do."""
    due = np.repeat(labels[:, None], plant.p, axis=1)
    of = {plant.output_names.index(name): k for k, name in enumerate(arrival)}
    columns = list(arrival.values())
    for j, k in of.items():
        due[:, j] = _dues(table, rows, columns[k], rows.texts[k], times)
    due = set_back(due, labels, last[0] if len(last) else None, MICROSECOND)
    y = np.where(np.isnan(due), np.nan, y)
    early = np.argwhere(~np.isnan(y) & (due < labels[:, None]))
    if len(early):
        row, j = early[0].tolist()
        measured = rows.carried[row] if rows.carried else f"{labels[row]:g}"
        raise ValueError(
            f"{table.at(rows.lines[row])}: {short(columns[of[j]])} is "
            f"{rows.texts[of[j]][row]}, before the reading was measured at {measured}. "
            "A reading arrives at its own row or later; leave the cell empty where it "
            "never does."
        )
    return y, due


def _dues(
    table: Table,
    rows: csv_reader.Rows,
    column: str,
    cells: list[str],
    times: Column | None,
) -> Vector:
    """When readings are known, as the times of rows are told; NaN for never."""
    origin: Any = 0 if times is None else times.origin
    given = [k for k, cell in enumerate(cells) if cell.lower() not in NEVER]
    found = np.full(len(cells), np.nan)
    wrong, text = 0, ""
    try:
        seconds, own = time_stamps.seconds([cells[k] for k in given], origin)
        if own == origin:
            found[given] = seconds * (1.0 if times is None else times.unit)
            return found
        text = cells[given[0]]
    except time_stamps.NoStamp as error:
        wrong, text = error.row, str(error)
    kind = f"a date, or lacks the zone of {origin}" if origin else "a number"
    raise ValueError(
        f"{table.at(rows.lines[given[wrong]])}: {short(column)} is {text!r}, which is "
        f"not {kind}; when a reading is known is told as the times of the rows are"
    )
