"""When the readings of a record arrive: rows, or times of a table, as numbers.

Rows and arrivals get labels that can be compared: row numbers, the numbers of an index,
or nanoseconds.  A reading arrives at the first row whose label is not before its own,
but for rounding: t + 0.3 s may be a last digit after the row at that time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import few, short
from ..formats import dataframes, time_stamps
from ..numeric import Matrix, Vector
from ..plant import Plant
from . import checked

if TYPE_CHECKING:
    from .record import Rows

NEAR = 1e-6  # of a step between rows: an arrival so little after a row is at it
COARSE = 0.01  # of a step: the most that a last digit of times counts


def of(
    given: Any, arrival: Any, rows: Rows, plant: Plant, first: int, last: Any = None
) -> Rows:
    """The rows of a record, with the arrivals of their readings.

    Parameters
    ----------
    given, arrival : array_like, table or dict
        The rows as they were given, with their arrivals.
    rows : Rows
    plant : Plant
    first : int
        How many rows the record had before.
    last : number or None
        The label of the row before.

    Raises
    ------
    ValueError
        Naming the row and the output of an arrival that is not as it should be.
    """
    digit: float | None = None
    if isinstance(arrival, Mapping) or dataframes.is_table(arrival):
        due, never, labels, digit = _times(given, arrival, plant, first)
    else:
        due, never, labels = _rows(arrival, plant, first)
    if due.shape != rows.y.shape:
        raise ValueError(f"y has {len(rows.y)} rows but arrival has {len(due)}")

    def early(k: int, j: int) -> str:
        return (
            f"{_reading(plant, first + k, j)} arrives at {_said(given, due[k, j])}, "
            f"before it was measured at {_said(given, labels[k])}. An arrival is at "
            "least its own row; leave it empty where a reading never arrives."
        )

    return known(rows, due, never, labels, last, digit, early)


def known(
    rows: Rows, due: Matrix, never: Matrix, labels: Vector, last: Any,
    digit: float | None, early: Callable[[int, int], str],
) -> Rows:  # fmt: skip
    """Rows whose readings are known when `due`, but for rounding, or `never`.

    `last` is the label of the row before, None where there is none.  `digit` is what
    the last digit of a label is worth: 0 for that of a float, None where labels are
    exact.  `early` says that a reading would arrive before it was measured.
    """
    if digit is not None:
        due = np.where(never, due, _set_back(due, labels, last, digit))
    taken = ~np.isnan(rows.y) & ~never
    for k, j in np.argwhere(taken & (due < labels[:, None])).tolist():
        raise ValueError(early(k, j))
    return rows._replace(y=np.where(taken, rows.y, np.nan), due=due, labels=labels)


def _set_back(due: Matrix, labels: Vector, last: Any, digit: float) -> Matrix:
    """Arrivals, set back by what rounding may have put them behind a row.

    None is before its own row that was not, but for rounding.
    """
    steps = np.diff(labels if last is None else np.append(last, labels))
    if not len(steps) and digit:
        return due
    size = np.abs(labels.astype(float))[:, None] + np.abs(due.astype(float))
    digit = digit + 4 * np.finfo(float).eps * size  # dates may have been floats too
    if len(steps):
        digit = np.minimum(digit + NEAR * steps.min(), COARSE * steps.min())
    slack = digit.astype(due.dtype)
    own = labels[:, None]
    return np.where(due < own - slack, due, np.maximum(due - slack, own))


def _rows(arrival: Any, plant: Plant, first: int) -> tuple[Matrix, Matrix, Vector]:
    """Arrivals that are row numbers."""
    due = checked.real("arrival", arrival, "row numbers")
    if due.ndim == 1 and plant.p == 1:
        due = due[:, None]
    if due.ndim != 2 or due.shape[1] != plant.p:
        raise ValueError(f"arrival must be (N, {plant.p}), got {due.shape}")
    odd = np.argwhere(np.isfinite(due) & (due != np.floor(due)))
    if len(odd):
        k, j = odd[0].tolist()
        raise ValueError(
            f"an array arrival holds row numbers, but {_reading(plant, first + k, j)} "
            f"has {due[k, j]:g}. For times, give y as a DataFrame with times in its "
            "index, and arrival={output: column}."
        )
    never = np.isnan(due) | (due == np.inf)
    return due, never, np.arange(float(first), first + len(due))


def _times(
    y: Any, arrival: Any, plant: Plant, first: int
) -> tuple[Matrix, Matrix, Vector, float]:
    """Arrivals as the index of y tells times, where there is none, labels, a digit."""
    if not dataframes.is_table(y):
        raise ValueError(
            "arrival names columns or is a table, so y must be a DataFrame too, with "
            "the times of its rows in its index"
        )
    names, signals = plant.output_names, (*plant.output_names, *plant.input_names)
    numbered = type(y.index).__name__ == "RangeIndex" and y.index.name is None
    for name in getattr(y, "columns", ()) if numbered else ():
        if time_stamps.is_time(name, signals):
            raise ValueError(
                f"arrivals are told as the index of y tells the rows, which numbers "
                f"them, while the column {short(name)} holds their times. Give "
                f"y.set_index({name!r}) for arrivals that are times; for row numbers "
                f"leave that column out. A table of Polars becomes one of pandas by "
                "y.to_pandas()."
            )
    labels, missing, kind = dataframes.moments("the index of y", y.index)
    backwards = np.flatnonzero(np.diff(labels) <= 0)
    if missing.any() or len(backwards):
        k = int(missing.argmax() if missing.any() else backwards[0] + 1)
        raise ValueError(
            f"the index of y must grow from row to row, but at row {first + k} it is "
            f"{y.index[k]}"
        )
    if isinstance(arrival, Mapping):
        own, table, columns = "y", y, dict(arrival)
    elif arrival.index.equals(y.index):
        own, table, columns = "arrival", arrival, {k: k for k in arrival.columns}
    else:
        raise ValueError("y and arrival are tables with different rows")
    if foreign := [name for name in columns if name not in names]:
        told = f"the columns {few(foreign)}" if own == "arrival" else short(foreign[0])
        raise ValueError(f"arrival has {told}; outputs are {few(names)}")
    due, digit = np.repeat(labels[:, None], plant.p, axis=1), dataframes.digit(y.index)
    never = np.zeros(due.shape, dtype=bool)
    for output, label in columns.items():
        j, name = names.index(output), f"the column {short(label)} of {own}"
        column = dataframes.column(own, table, label)
        due[:, j], never[:, j], what = dataframes.moments(name, column)
        if what != kind:
            raise ValueError(f"{name} holds {what}, but the index of y holds {kind}")
        digit = max(digit, dataframes.digit(column))
    return due, never, labels, digit


def _reading(plant: Plant, row: int, output: int) -> str:
    return f"the reading of {short(plant.output_names[output])} in row {row}"


def _said(given: Any, label: Any) -> str:
    """A label as people write it."""
    if isinstance(label, np.int64):
        return str(label.astype("datetime64[ns]"))
    return f"{'' if dataframes.is_table(given) else 'row '}{label:g}"
