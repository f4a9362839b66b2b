"""A table of measurements smoothed: whole, or with a fixed lag in flat memory."""

from collections.abc import Iterator
from itertools import repeat

import numpy as np

from ..errors import short
from ..formats.csv_reader import Rows, Table
from ..formats.spreadsheets import require_plain
from ..numeric import Matrix
from ..plant import Plant
from ..run.estimate_csv import Piece, require_times
from ..run.measurements import require_finite, time_column
from .smooth import Smoothed, smooth


def estimates(
    plant: Plant, table: Table, lag: int | None = None, backend: str = "numpy"
) -> tuple[list[str], Iterator[Piece]]:
    """Smooth a table; with a lag, memory does not grow with its length.

    Parameters
    ----------
    plant : Plant
        Its names are those of the columns, among others; empty cells of outputs were
        not measured.
    table : Table
    lag : int, optional
        As in `smooth`.
    backend : str
        As in `smooth`.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", then each state and its one sigma.
    rows : iterator of (Rows, (N, 2 n) ndarray)

    Raises
    ------
    ValueError
        Naming line and column, as `run.estimate_csv.estimates`.
    """
    outputs, inputs = plant.output_names, plant.input_names
    clock = time_column(table, outputs, inputs, others=True)
    pairs = [name + wide for name in plant.state_names for wide in ("", "_sigma")]
    header = [clock or "instant", *pairs]
    if len(set(header)) < len(header):
        twice = next(name for name in header if header.count(name) > 1)
        raise ValueError(
            f"{table.where}: {short(twice)} would be the name of two columns; rename "
            "a state or the column of times"
        )
    require_plain("state", plant.state_names)
    rows = table.rows([*outputs, *inputs], outputs, clock)
    return header, _smoothed(plant, table, rows, lag, backend)


def _smoothed(
    plant: Plant, table: Table, rows: Iterator[Rows], lag: int | None, backend: str
) -> Iterator[Piece]:
    waiting: list[Rows] = []

    def ys() -> Iterator[Matrix]:
        for piece in rows:
            require_times(table, piece)
            waiting.append(piece)
            yield piece.values[:, : plant.p]

    if lag is None:
        y = np.concatenate([*ys(), np.empty((0, plant.p))])
        u = np.concatenate([np.empty((0, plant.m)), *(_inputs(plant, waiting))])
        blocks = iter([smooth(plant, y, u, backend=backend)])
    else:
        us = (_inputs(plant, waiting)[-1] for _ in repeat(None))
        blocks = smooth(plant, ys(), us, lag=lag, backend=backend)
    with np.errstate(over="ignore", invalid="ignore"):
        for found in blocks:
            piece = _taken(waiting, len(found.x))
            yield piece, _pairs(plant, table, piece, found)


def _inputs(plant: Plant, pieces: list[Rows]) -> list[Matrix]:
    return [piece.values[:, plant.p :] for piece in pieces]


def _taken(waiting: list[Rows], count: int) -> Rows:
    """The first rows of those that wait, taken out."""
    lines = [line for piece in waiting for line in piece.lines]
    carried = [cell for piece in waiting for cell in piece.carried]
    values = np.concatenate([*(piece.values for piece in waiting)]) if waiting else None
    if values is None:
        return Rows([], [], np.empty((0, 0)))
    waiting[:] = [Rows(lines[count:], carried[count:], values[count:])]
    return Rows(lines[:count], carried[:count], values[:count])


def _pairs(plant: Plant, table: Table, piece: Rows, found: Smoothed) -> Matrix:
    """Each state and its one sigma side by side."""
    require_finite(found.x, plant.state_names, lambda k: table.at(piece.lines[k]))
    return np.stack([found.x, found.std], axis=2).reshape(len(found.x), -1)
