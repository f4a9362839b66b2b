"""A plant's filter run over a table of any length, in memory that does not grow."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

from ..errors import DesignError, short
from ..formats.csv_reader import Rows, Table
from ..formats.spreadsheets import require_plain
from ..numeric import Matrix
from ..plant import Plant
from . import record
from .clock import Column
from .estimate_csv import Piece, require_times
from .filter import Filter, Filtered
from .measurements import require_finite, time_column
from .smoothed import Smoothed, over
from .timed import Stretch, Timed, leading


class Read(NamedTuple):
    """Consecutive rows of a table: measurements and inputs, checked.

    Attributes
    ----------
    rows : Rows
    y, u : (N, p), (N, m) ndarray
        NaN in y was not measured.
    periods : (N,) ndarray or None
        Seconds that lead to each row, where the plant is continuous.
    """

    rows: Rows
    y: np.ndarray
    u: np.ndarray
    periods: np.ndarray | None = None

    @property
    def given(self) -> Matrix | Timed:
        """The measurements as a pass takes them, with the periods if there are any."""
        return self.y if self.periods is None else Timed(self.y, self.periods)


def reads(
    plant: Plant, table: Table, undriven: bool = False, texts: Sequence[str] = ()
) -> tuple[list[str], Iterator[Read]]:
    """The rows of a plant's record, and the header of estimates with their sigmas.

    Parameters
    ----------
    plant : Plant
        Its names are those of the columns, among others; empty cells of outputs were
        not measured.  Times agree with dt, or say when a continuous plant is sampled.
    table : Table
    undriven : bool
        No known input acts, so no column of one is needed.
    texts : sequence of str
        Further columns, which are read as they stand.

    Raises
    ------
    ValueError
        Naming line and column, as `estimate_csv.estimates`.
    """
    outputs = plant.output_names
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
    rows = table.rows([*outputs, *inputs], {*outputs}, clock, texts)
    times = None if clock is None else Column(clock, plant)
    found = _read(plant, table, rows, None if plant.dt == 0 else times)
    return header, found if plant.dt > 0 or times is None else _timed(
        table, found, times
    )


def _read(
    plant: Plant, table: Table, rows: Iterator[Rows], times: Column | None
) -> Iterator[Read]:
    for piece in rows:
        require_times(table, piece, times)
        y, u = np.split(piece.values, [plant.p], axis=1)
        u = u if u.shape[1] else np.zeros((len(y), plant.m))
        yield Read(piece, y, u)


def _timed(table: Table, found: Iterator[Read], times: Column) -> Iterator[Read]:
    """The same with the periods that lead to the rows."""
    waiting: deque[Read] = deque()

    def stretches() -> Iterator[Stretch]:
        for one in found:
            waiting.append(one)
            at = partial(line, table, one.rows)
            yield Stretch(times.seconds(one.rows.carried, at), at)

    for periods in leading(stretches()):
        yield waiting.popleft()._replace(periods=periods)


def line(table: Table, rows: Rows, k: int) -> str:
    return table.at(rows.lines[k])


def estimates(
    plant: Plant, table: Table, undriven: bool = False
) -> tuple[list[str], Iterator[Piece]]:
    """Filter a table; memory does not grow with its length.

    Parameters
    ----------
    plant : Plant
        With Q, R and P0, continuous or discrete.
    table, undriven
        As in `reads`.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", then each state and its one sigma.
    rows : iterator of (Rows, (N, 2 n) ndarray)

    Raises
    ------
    ValueError
        As `reads`; and as `Filter.run`.
    """
    header, found = reads(plant, table, undriven)
    return header, paired(plant, table, found, partial(_filtered, plant))


def smoothed(
    plant: Plant, table: Table, lag: int | None = None, undriven: bool = False
) -> tuple[list[str], Iterator[Piece]]:
    """Smooth a table, which is held as a whole; `lag` as in `Filter.smooth`.

    What is returned and raised is as in `estimates`.
    """
    header, found = reads(plant, table, undriven)
    return header, paired(plant, table, found, partial(_smoothed, plant, lag))


Way = Callable[[Iterator, Iterator], Iterator]  # from y and u, chunk by chunk


def paired(
    plant: Plant, table: Table, found: Iterator[Any], way: Way
) -> Iterator[Piece]:
    """Rows of a table with their estimates and one sigmas side by side.

    What is `found` has rows, u and what is given, as `Read` does.  `way` may give the
    rows of a chunk later, among others.
    """
    waiting: deque[Rows] = deque()
    inputs: deque[Matrix] = deque()

    def ys() -> Iterator[Matrix | Timed]:
        for one in found:
            waiting.append(one.rows)
            inputs.append(one.u)
            yield one.given

    blocks = way(ys(), (inputs.popleft() for _ in repeat(None)))
    with np.errstate(over="ignore", invalid="ignore"):
        for block in blocks:
            rows = waiting.popleft()
            require_finite(block.x, plant.state_names, partial(line, table, rows))
            pairs = np.stack([block.x, block.std], axis=2)
            yield rows, pairs.reshape(len(pairs), 2 * plant.n)


def _filtered(plant: Plant, ys: Iterator, us: Iterator) -> Iterator[Filtered]:
    """What the filter gives of each part, from the end of the one before."""
    run, end, u0 = Filter(plant), None, np.zeros(plant.m)
    for part, u in zip(ys, us):
        y, steps = (part.y, part.periods) if plant.dt == 0 else (part, None)
        found = run.over(record.Rows(y, u, u0, steps), end)
        end = found.end
        yield found


def _smoothed(
    plant: Plant, lag: int | None, ys: Iterator, us: Iterator
) -> Iterator[Smoothed]:
    """All parts together, and then of each part its rows."""
    parts, inputs = zip(*zip(ys, us))
    y, u, steps = parts, np.concatenate(inputs), None
    if plant.dt == 0:
        y = [part.y for part in parts]
        steps = np.concatenate([part.periods for part in parts])
    y = np.concatenate(y)
    rows = record.Rows(y, u, np.zeros(plant.m), steps, None)
    found, k = over(Filter(plant), rows, lag), 0
    for part in parts:
        own = slice(k, k + len(part))
        yield replace(found, x=found.x[own], std=found.std[own])
        k += len(part)
