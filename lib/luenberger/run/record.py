"""A record: what was measured, what is known to have acted, and when."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..formats import dataframes
from ..numeric import Vector
from ..plant import Plant
from . import arrivals, chunks
from .clock import Clock, known, leading, row


class Rows(NamedTuple):
    """A record on a plant, as arrays.

    Attributes
    ----------
    y : (N, p) ndarray
        NaN where an output was not measured.
    u : (N, m) ndarray
    u0 : (m,) ndarray
        The input that acted until the first row.
    periods : (N,) ndarray or None
        Seconds that lead to each row of a continuous plant.
    due : (N, p) ndarray or None
        When each reading arrived, as `labels` say it; None where all were on time.
        Of a reading that never arrives y is NaN.
    labels : (N,) ndarray or None
        Numbers of the rows, or their times, where readings have arrivals.
    clock : object
        What has to be known of the times of these rows for those of later ones.
    """

    y: np.ndarray
    u: np.ndarray
    u0: np.ndarray
    periods: np.ndarray | None
    due: np.ndarray | None = None
    labels: np.ndarray | None = None
    clock: Any = None


@dataclass(frozen=True, eq=False)
class Record:
    """Measurements of one run, or of many, with inputs and times.

    Row k is instant k + 1, the k-th sample after the initial condition.

    Parameters
    ----------
    y : (N, p) array_like or pandas.DataFrame, or (M, N, p), or a list of records
        Measurements.  NaN, None, pandas.NA and what a mask covers were not measured.
        The columns of a table are found by the names of the plant's outputs.  Polars
        tables and named xarray arrays are found by name as well.
    u : (N, m) array_like or DataFrame, optional
        Known inputs at the same instants; u[k] acts until the next row.  By default
        the columns of the table y that are named as inputs, else zero.
    time : (N,) array_like or "rows", optional
        When each row was measured: seconds, dates or durations.  By default the index
        of a table, or its column `time` or `t`.  They must agree with dt, and a
        continuous plant is sampled at them; "rows" leaves them out of account.
    arrival : (N, p) array_like, dict or DataFrame, optional
        When each reading became known, where that is later than its own row: row
        numbers, or times as those of the index: ``{"gps": "gps_known_at"}``.  Never,
        where it is missing.
    u0 : (m,) array_like, optional
        The input that acted until the first row, default zero.

    Raises
    ------
    ValueError
        When it is used with a plant: where sizes or names disagree, a value is
        infinite, or times contradict dt or do not grow.

    Examples
    --------
    >>> import luenberger as lb
    >>> nan = float("nan")
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> lb.Filter(plant).run(lb.Record([[2], [nan], [2]])).std[:, 0].round(4)
    array([0.7071, 0.7071, 0.5774])
    """

    y: Any
    u: Any = None
    time: Any = None
    arrival: Any = None
    u0: Any = None

    def __post_init__(self) -> None:
        given = dict(y=self.y, u=self.u, arrival=self.arrival)
        for name, value in zip(given, dataframes.taken(**given)):
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, record: Any) -> Record:
        """The record itself, or a record of measurements."""
        return record if isinstance(record, cls) else cls(record)

    @property
    def index(self) -> Any:
        """The index of a table, or None."""
        return self.y.index if dataframes.is_table(self.y) else None

    @property
    def many(self) -> bool:
        """Whether there are several runs."""
        if isinstance(self.y, list | tuple) and len(self.y):
            return dataframes.is_table(self.y[0]) or _depth(self.y[0]) == 2
        return not dataframes.is_table(self.y) and getattr(self.y, "ndim", 0) == 3

    def split(self, size: int) -> list[Record]:
        """Parts of so many runs, or of so many rows of one run.

        The parts of one run are filtered one after the other, each with
        ``start=`` the `end` of the one before.
        """
        if not isinstance(size, int | np.integer) or size < 1:
            raise ValueError(f"a part has at least 1 record or row, got {size!r}")
        return [
            Record(
                *self._of(slice(k, k + size)), self.u0 if self.many or not k else None
            )
            for k in range(0, len(self.y), size)
        ]

    def each(self) -> Iterator[Record]:
        """Each of many runs as a record."""
        for k in range(len(self.y)):
            yield replace(Record(*self._of(k)), u0=self.u0)

    def _of(self, part: slice | int) -> Iterator[Any]:
        """y, u, time and arrival of some rows, or of some runs.

        What is not told of each run is that of all.
        """
        for X, axes in ((self.y, 0), (self.u, 2), (self.time, 1), (self.arrival, 2)):
            own = isinstance(X, list | tuple) and len(X) and _depth(X[0]) >= axes
            each = own or (not dataframes.is_table(X) and np.ndim(X) > axes)
            yield X if self.many and not each else _part(X, part)

    def __len__(self) -> int:
        return len(self.y)

    def on(
        self, plant: Plant, first: int = 0, clock: Any = None, last: Any = None
    ) -> Rows:
        """The rows of one run as arrays; `first` of its rows came before.

        `clock` is that of the rows before, `last` the label of the last of them.
        """
        outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
        y, u = chunks.arrays(self.y, self.u, outputs, inputs, missing=True)
        u0 = dataframes.entries("u0", self.u0, plant.input_names)
        u0 = np.zeros(plant.m) if u0 is None else chunks.single("u0", u0, plant.m)
        steps = None
        if plant.dt > 0:
            clock = Clock(plant) if clock is None else copy(clock)
            clock.time = self.time
            clock.follow(self.y)
        else:
            steps, clock = self._steps(plant, first, clock)
        if self.arrival is None:
            return Rows(y, u, u0, steps, clock=clock)
        found = arrivals.of(self.y, self.arrival, y, plant, first, last)
        return Rows(found.y, u, u0, steps, found.due, found.labels, clock)

    def _steps(
        self, plant: Plant, first: int, clock: Any
    ) -> tuple[Vector, tuple[Vector, Any]]:
        """Seconds that lead to each row, the last instant and what it counts from."""
        last, origin = clock or (np.empty(0), None)
        seconds, origin = known(plant, self.y, self.time, origin, first)
        steps = leading(last, seconds, lambda k: row(first + k))
        return steps, (seconds[-1:] if len(seconds) else last, origin)


def _depth(X: Any) -> int:
    """How many axes an array has, or lists in lists; nothing is converted."""
    if isinstance(X, list | tuple):
        return 1 + (_depth(X[0]) if len(X) else 0)
    return int(getattr(X, "ndim", 0))


def _part(X: Any, part: slice | int) -> Any:
    """Some rows, or some runs."""
    if X is None or isinstance(X, str | dict | int | float):
        return X
    return X.iloc[part] if dataframes.is_table(X) else X[part]
