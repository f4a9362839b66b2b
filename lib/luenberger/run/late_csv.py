"""A filter run over a table whose readings arrive late, in memory that stays flat."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from ..errors import few, short
from ..formats import time_stamps
from ..formats.csv_reader import Rows, Table
from ..numeric import Vector
from ..plant import Plant
from . import record
from .arrivals import set_back
from .estimate_csv import Piece
from .filter import Filter
from .filter_csv import Read, line, reads
from .measurements import require_finite

NEVER = ("", "nan", "nat")  # cells of readings that do not arrive
MICROSECOND = 1e-6  # the last digit of a date


def estimates(
    plant: Plant,
    table: Table,
    arrival: Mapping[str, str],
    undriven: bool = False,
) -> tuple[list[str], Iterator[Piece]]:
    """Filter a table; memory does not grow with its length.

    Parameters
    ----------
    plant : Plant
        With Q, R and P0.
    table, undriven
        As in `filter_csv.reads`.
    arrival : dict of str to str
        Of outputs that may be late, the column that says when a reading is known:
        numbers or dates like those in the column of times, or numbers of rows from 1
        on where there is none.  A reading whose cell is empty never arrives.

    Returns
    -------
    header, rows
        As `filter_csv.estimates`.

    Raises
    ------
    ValueError
        As `filter_csv.reads`; if a reading arrives before it was measured, or the
        cell that says when is not of the kind of the times.
    """
    _require_names(plant, table, arrival)
    header, found = reads(plant, table, undriven, list(arrival.values()))
    outputs = [plant.output_names.index(name) for name in arrival]
    blocks = _blocks(table, outputs, list(arrival.values()), found)
    return header, _filtered(Filter(plant), table, blocks)


def _filtered(
    run: Filter, table: Table, blocks: Iterator[tuple[Rows, record.Rows]]
) -> Iterator[Piece]:
    """Estimates and sigmas side by side, block by block."""
    end, names = None, run.plant.state_names
    for rows, one in blocks:
        found = run.over(one, end)
        end = found.end
        require_finite(found.x, names, partial(line, table, rows))
        pairs = np.stack([found.x, found.std], axis=2)
        yield rows, pairs.reshape(len(pairs), 2 * len(names))


def _require_names(plant: Plant, table: Table, arrival: Mapping[str, str]) -> None:
    """Raise unless there are such outputs and columns."""
    if foreign := [name for name in arrival if name not in plant.output_names]:
        names = few(plant.output_names)
        raise ValueError(f"--arrival has {few(foreign)}; outputs are {names}")
    if lacking := [name for name in arrival.values() if name not in table.header]:
        raise ValueError(f"{table.where} lacks the columns {few(lacking)} of arrivals")


def _blocks(
    table: Table, outputs: list[int], columns: list[str], found: Iterator[Read]
) -> Iterator[tuple[Rows, record.Rows]]:
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
        u0 = np.zeros(one.u.shape[1])
        yield one.rows, record.Rows(y, one.u, u0, one.periods, due, labels)


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
