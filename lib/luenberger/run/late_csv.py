"""A filter run over a table whose readings arrive late, in memory that stays flat."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from ..errors import DesignError, few, short
from ..formats import time_stamps
from ..formats.csv_reader import Rows, Table
from ..kernels import runs_compiled
from ..numeric import Vector
from ..plant import Plant
from ..recursion.late_pass import LatePass
from ..recursion.settings import Settings
from . import chunks, filter_chunks
from .arrivals import Arrivals, set_back
from .estimate_csv import Piece
from .filter_csv import Read, paired, reads

NEVER = ("", "nan", "nat")  # cells of readings that do not arrive
MICROSECOND = 1e-6  # the last digit of a date


def estimates(
    plant: Plant,
    table: Table,
    arrival: Mapping[str, str],
    horizon: int,
    undriven: bool = False,
    backend: str = "auto",
) -> tuple[list[str], Iterator[Piece]]:
    """Filter a table; memory does not grow with its length.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q, R and P0.
    table, undriven
        As in `filter_csv.reads`.
    arrival : dict of str to str
        Of outputs that may be late, the column that says when a reading is known:
        numbers or dates like those in the column of times, or numbers of rows from 1
        on where there is none.  A reading whose cell is empty never arrives.
    horizon : int
        For how many rows a reading is waited for.
    backend : str
        As in `filter_data`.

    Returns
    -------
    header, rows
        As `filter_csv.estimates`.

    Raises
    ------
    DesignError
        If the plant is continuous; naming a reading that arrives after the horizon.
    ValueError
        As `filter_csv.reads`; if a reading arrives before it was measured, or the
        cell that says when is not of the kind of the times.
    """
    runs_compiled(backend, 0)
    if plant.dt == 0:
        raise DesignError(
            "late readings need a discrete plant; give --sample DT, how many seconds "
            "the rows are apart"
        )
    _require_names(plant, table, arrival)
    header, found = reads(plant, table, undriven, list(arrival.values()))
    outputs = [plant.output_names.index(name) for name in arrival]
    blocks = _blocks(table, outputs, list(arrival.values()), found)
    run = LatePass(Settings(plant, 0), horizon)
    return header, paired(plant, table, blocks, partial(_filtered, run, backend))


def _require_names(plant: Plant, table: Table, arrival: Mapping[str, str]) -> None:
    """Raise unless there are such outputs and columns."""
    if foreign := [name for name in arrival if name not in plant.output_names]:
        names = few(plant.output_names)
        raise ValueError(f"--arrival has {few(foreign)}; outputs are {names}")
    if lacking := [name for name in arrival.values() if name not in table.header]:
        raise ValueError(f"{table.where} lacks the columns {few(lacking)} of arrivals")


class Late(NamedTuple):
    """Rows of a table, the inputs, and readings with when they arrive."""

    rows: Rows
    u: np.ndarray
    given: Arrivals


def _blocks(
    table: Table, outputs: list[int], columns: list[str], found: Iterator[Read]
) -> Iterator[Late]:
    """The rows, with labels that arrivals are compared with."""
    count, origin, last = 0, None, None
    for one in found:
        labels, origin = _labels(one.rows, count, origin)
        count += len(labels)
        due = np.repeat(labels[:, None], one.y.shape[1], axis=1)
        for j, column, cells in zip(outputs, columns, one.rows.texts):
            due[:, j] = _dues(table, one.rows, column, cells, origin)
        due = set_back(due, labels, last, 0 if origin is None else MICROSECOND)
        last = labels[-1] if len(labels) else last
        y = np.where(np.isnan(due), np.nan, one.y)
        early = np.argwhere(~np.isnan(y) & (due < labels[:, None]))
        if len(early):
            k, j = early[0].tolist()
            which = outputs.index(j)
            measured = one.rows.carried[k] if one.rows.carried else f"{labels[k]:g}"
            raise ValueError(
                f"{table.at(one.rows.lines[k])}: {short(columns[which])} is "
                f"{one.rows.texts[which][k]}, before the reading was measured at "
                f"{measured}. A reading arrives at its own row or later; leave the "
                "cell empty where it never does."
            )
        yield Late(one.rows, one.u, Arrivals(y, due, labels))


def _labels(
    rows: Rows, count: int, origin: time_stamps.Origin
) -> tuple[Vector, time_stamps.Origin]:
    """Numbers of the rows, from 1 on or their times, and what these count from."""
    if not rows.carried:
        return np.arange(count + 1.0, count + 1 + len(rows.lines)), 0
    return time_stamps.seconds(rows.carried, origin)  # of instants, as was seen


def _dues(
    table: Table, rows: Rows, column: str, cells: list[str], origin: time_stamps.Origin
) -> Vector:
    """When readings are known, in the numbers of `_labels`; NaN for never."""
    given = [k for k, cell in enumerate(cells) if cell.lower() not in NEVER]
    found = np.full(len(cells), np.nan)
    wrong, text = 0, ""
    try:
        found[given], own = time_stamps.seconds([cells[k] for k in given], origin)
        if own == origin:
            return found
        text = cells[given[0]]
    except time_stamps.NoStamp as error:
        wrong, text = error.row, str(error)
    kind = f"a date, or lacks the zone of {origin}" if origin else "a number"
    raise ValueError(
        f"{table.at(rows.lines[given[wrong]])}: {short(column)} is {text!r}, which is "
        f"not {kind}; when a reading is known is told as the times of the rows are"
    )


def _filtered(run: LatePass, backend: str, ys: Iterator, us: Iterator) -> Iterator:
    """What `filter_data` gives of each chunk."""
    plant = run.settings.plant
    step = partial(filter_chunks.arrived_chunk, run, backend)
    return iter(chunks.found(step, run.start(plant.x0, np.zeros(plant.m)), ys, us))
