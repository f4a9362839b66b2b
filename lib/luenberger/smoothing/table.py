"""A table of measurements smoothed: whole, or with a fixed lag in flat memory."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..formats.csv_reader import Table
from ..numeric import Matrix
from ..plant import Plant
from ..run import filter_csv
from ..run.estimate_csv import Piece
from ..run.timed import Timed
from .record import Smoothed
from .smooth import smoothed


def estimates(
    plant: Plant,
    table: Table,
    lag: int | None = None,
    backend: str = "numpy",
    undriven: bool = False,
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
    undriven : bool
        No known input acts, so no column of one is needed.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", then each state and its one sigma.
    rows : iterator of (Rows, (N, 2 n) ndarray)

    Raises
    ------
    ValueError
        Naming line and column, as `run.filter_csv.estimates`.
    """
    header, found = filter_csv.reads(plant, table, undriven)
    kind = _whole if lag is None else partial(_lagged, lag)
    way = partial(kind, plant, backend)
    return header, filter_csv.paired(plant, table, found, way)


def _whole(
    plant: Plant, backend: str, ys: Iterator, us: Iterator
) -> Iterator[Smoothed]:
    parts = [(y, next(us)) for y in ys]
    u = np.concatenate([u for _, u in parts])
    if plant.dt > 0:
        y: Matrix | Timed = np.concatenate([y for y, _ in parts])
    else:
        periods = np.concatenate([block.periods for block, _ in parts])
        y = Timed(np.concatenate([block.y for block, _ in parts]), periods)
    yield smoothed(plant, y, u, None, backend)


def _lagged(
    lag: int, plant: Plant, backend: str, ys: Iterator, us: Iterator
) -> Iterator[Smoothed]:
    return smoothed(plant, ys, us, lag, backend)
