"""A record: what was measured, what is known to have acted, and when."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..filtering.pack import End
from ..formats import dataframes
from ..plant import Plant
from . import arrivals, checked
from .clock import Clock

OF_ROWS = "y", "u", "periods", "due", "labels"


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

    def part(self, which: slice) -> Rows:
        """Some of the rows."""
        own = {k: X[which] for k in OF_ROWS if (X := getattr(self, k)) is not None}
        return self._replace(**own)

    def then(self, *later: Rows) -> Rows:
        """These rows and later ones."""
        own = {
            k: np.concatenate([X, *(getattr(one, k) for one in later)])
            for k in OF_ROWS
            if (X := getattr(self, k)) is not None
        }
        return [self, *later][-1]._replace(**own, u0=self.u0)


@dataclass(frozen=True, eq=False)
class Record:
    """Measurements of one run, or of many, with inputs and times.

    >>> import luenberger as lb
    >>> nan = float("nan")
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> lb.Filter(plant).run(lb.Record([[2], [nan], [2]])).std[:, 0].round(4)
    array([0.7071, 0.7071, 0.5774])

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
            self._of(slice(k, k + size), self.u0 if self.many or not k else None)
            for k in range(0, len(self.y), size)
        ]

    def each(self) -> Iterator[Record]:
        """Each of many runs as a record."""
        return (self._of(k, self.u0) for k in range(len(self.y)))

    def _of(self, part: slice | int, u0: Any) -> Record:
        """Some rows, or some runs, with y, u, time and arrival of theirs.

        What is not told of each run is that of all.
        """

        def own(X: Any, axes: int) -> Any:
            if X is None or isinstance(X, str | dict | int | float):
                return X
            listed = isinstance(X, list | tuple) and len(X) and _depth(X[0]) >= axes
            table = dataframes.is_table(X)
            if self.many and not (listed or (not table and np.ndim(X) > axes)):
                return X
            return X.iloc[part] if table else X[part]

        told = own(self.time, 1), own(self.arrival, 2)
        return Record(own(self.y, 0), own(self.u, 2), *told, u0=u0)

    def __len__(self) -> int:
        return len(self.y)

    def on(self, plant: Plant, start: End | None = None) -> Rows:
        """The rows of one run as arrays, behind those that ended in `start`."""
        outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
        y, u = checked.arrays(self.y, self.u, outputs, inputs, missing=True)
        u0 = dataframes.entries("u0", self.u0, plant.input_names)
        u0 = np.zeros(plant.m) if u0 is None else checked.single("u0", u0, plant.m)
        clock = copy(start.clock) if start and start.clock else Clock(plant)
        steps = clock.follow(self.y, self.time)
        rows = Rows(y, u, u0, steps, clock=clock)
        if self.arrival is None:
            return rows
        first = start.instant if start else 0
        before = start.awaited.rows.labels[-1] if start and start.awaited else None
        return arrivals.of(self.y, self.arrival, rows, plant, first, before)


def _depth(X: Any) -> int:
    """How many axes an array has, or lists in lists; nothing is converted."""
    if isinstance(X, list | tuple):
        return 1 + (_depth(X[0]) if len(X) else 0)
    return int(getattr(X, "ndim", 0))
