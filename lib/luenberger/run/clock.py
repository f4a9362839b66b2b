"""Instants of a record: evenly dt apart, or those a continuous plant is sampled at."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..errors import DesignError, short
from ..formats import dataframes, time_stamps
from ..numeric import Vector
from ..observer import Observer
from ..plant import Plant

DRIFT = 0.01  # of the time since the first row, that a clock may be off by
AHEAD = (
    "Give a row for each sample, with empty cells (NaN) for what was not measured; or "
    "give Filter, or the command `filter`, the continuous plant, which is sampled at "
    "these instants."
)
ALIKE = "Write the times of all rows in one way."
MEND = (
    f"{ALIKE} A column of labels needs another name; without a column of times the "
    "rows are taken to be dt apart."
)
UNKNOWN = (
    "the plant is continuous (dt = 0), so the record must say when each row was "
    "measured: give time=, or a table with an index of dates or seconds. Of a record "
    "with a constant period, plant.sampled(0.1) is the plant."
)
ONE_ROW = "one row has no sampling period; give at least two, or plant.sampled(0.1)"
Place = Callable[[int], str]  # how a message names row k


def row(k: int) -> str:
    return f"row {k}"


class Clock:
    """The instants of a record, as its rows come in.

    Those of a discrete system are held against dt.  Those of a continuous plant say
    how long its steps are.
    """

    def __init__(self, of: Plant | Observer) -> None:
        self.dt = of.dt
        self.names = (*(of.output_names or ()), *(of.input_names or ()))
        self.first = self.last = 0.0
        self.count = 0
        self.origin: Any = None  # of dates

    def follow(self, y: Any, time: Any) -> Vector | None:
        """`steps` of the next rows y, whose time is that of `Record`."""
        first = self.count
        found = instants(y, time, self.names, self.origin, first)
        if found is None:
            if self.dt == 0:
                raise DesignError(UNKNOWN)
            return None
        seconds, self.origin = found
        return self.steps(seconds, lambda k: row(first + k))

    def steps(self, seconds: Vector, at: Place) -> Vector | None:
        """The periods that lead to the next rows; None of a discrete system.

        To the first row of a record leads a period as long as the one behind it.

        Raises
        ------
        ValueError
            If an instant is missing, or unless rows are about dt apart and keep in
            step: a step may be off by less than dt / 2, the whole by dt / 2 or 1 %.
            Of a continuous plant, if times do not grow, or a record has one row.
        """
        seconds, found, begins = _finite(seconds, at), None, not self.count
        if begins and len(seconds):
            self.first = self.last = float(seconds[0])
        if self.dt > 0:
            self._require(seconds, at)
        elif begins:
            if len(seconds) == 1:
                raise ValueError(ONE_ROW)
            found = periods(seconds, at)
            found = np.concatenate([found[:1], found])
        else:
            whole = np.concatenate([[self.last], seconds])
            found = periods(whole, lambda k: at(k - 1))
        self.count += len(seconds)
        self.last = float(seconds[-1]) if len(seconds) else self.last
        return found

    def _require(self, seconds: Vector, at: Place) -> None:
        """Raise unless the next rows are about dt apart, and keep in step."""
        dt, steps = self.dt, np.diff(seconds, prepend=self.last)
        if not self.count:
            steps[:1] = dt
        since = seconds - self.first
        due = dt * (self.count + np.arange(len(seconds)))
        jump = np.abs(steps - dt) >= dt / 2
        most = np.maximum(dt / 2, DRIFT * np.abs(due)) * (1 + 1e-9)
        for k in np.flatnonzero(jump | (np.abs(since - due) > most))[:1]:
            said = (
                f"its time is {steps[k]:.6g} s after that of the row before, but one "
                f"step is dt = {dt:g} s"
            )
            if not jump[k]:
                said = (
                    f"it is {since[k]:.6g} s after the first row, but by "
                    f"dt = {dt:g} s it should be {due[k]:.6g} s"
                )
            raise ValueError(f"{at(k)}: {said}. {AHEAD}")


def periods(seconds: Vector, at: Place = row) -> Vector:
    """Seconds from each row to the next; those that differ by rounding are equal."""
    steps = np.diff(seconds)
    if not (steps > 0).all():
        k = int(np.argmin(steps > 0)) + 1
        raise ValueError(
            f"{at(k)}: its time is {steps[k - 1]:.6g} s after that of the row before; "
            "times must grow from row to row"
        )
    rounding = 4 * np.finfo(float).eps * np.abs(seconds).max(initial=0.0)
    unique, where = np.unique(steps, return_inverse=True)
    group = np.cumsum(np.diff(unique, prepend=unique[:1]) > rounding)
    middle = np.bincount(group, unique) / np.maximum(np.bincount(group), 1)
    return _shortest(middle, rounding)[group][where]


def _shortest(values: Vector, rounding: float) -> Vector:
    """For each of positive values the number with the fewest digits within `rounding`.

    >>> _shortest(np.array([0.1 + 1e-16, 600.0000001, 1 / 3]), 1e-6)
    array([1.00000e-01, 6.00000e+02, 3.33333e-01])
    """
    found, left = values.copy(), np.ones(len(values), dtype=bool)
    before_point = np.floor(np.log10(values)).astype(int) + 1
    for digits in range(1, 17):
        if not left.any():
            break
        after_point = digits - before_point[left]
        up, down = (10.0 ** np.maximum(k, 0) for k in (after_point, -after_point))
        tried = np.rint(values[left] * up / down) * down / up
        near = np.abs(tried - values[left]) <= rounding
        here = np.flatnonzero(left)[near]
        found[here], left[here] = tried[near], False
    return found


class Column(Clock):
    """The time column of a CSV file, read a piece at a time.

    Its cells are seconds or dates, or instants: numbers of samples.
    """

    def __init__(self, name: str, of: Plant | Observer) -> None:
        super().__init__(of)
        counts = name.lower() == "instant"
        if counts and self.dt == 0:
            raise ValueError(
                f"the column {name!r} counts samples, but a continuous plant has no "
                "period; give a column 'time', or the plant.sampled(0.1) that was read"
            )
        self.name, self.unit = name, self.dt if counts else 1.0

    def seconds(self, cells: Sequence[str], at: Place) -> Vector:
        """The seconds of the next rows; `at` names the line of a cell that is none."""
        try:
            found, self.origin = time_stamps.seconds(cells, self.origin)
        except time_stamps.NoStamp as error:
            raise ValueError(
                f"{at(error.row)}: {self.name!r} is {short(str(error))}, {error.lacks}"
                f". {MEND if self.dt > 0 else ALIKE}"
            ) from None
        return found * self.unit


def instants(
    y: Any, time: Any, names: Sequence[str], origin: Any = None, first: int = 0
) -> time_stamps.Instants | None:
    """Instants of a record in seconds and what they count from; None if not known.

    `first` is the number of its first row, for messages.
    """
    if isinstance(time, str):
        if time != "rows":
            raise ValueError(f"time must be instants or 'rows', got {time!r}")
        return None
    try:
        if time is None:
            table = dataframes.is_table(y)
            return time_stamps.of_table(y, names, origin) if table else None
        found = time_stamps.of_values(time, origin)
    except time_stamps.NoStamp as error:
        raise ValueError(
            f"{row(first + error.row)}: the time is {short(str(error))}, {error.lacks}"
            f". {ALIKE}"
        ) from None
    if found[0].shape != (len(y),):
        got = found[0].shape
        raise ValueError(f"time must have {len(y)} instants, got shape {got}")
    return found


def require_instants(plant: Plant, last: int) -> None:
    """Raise unless the plant's matrices are given up to the instant `last`."""
    if plant.steps is not None and last >= plant.steps:
        raise ValueError(
            f"the plant has rows for instants 0 .. {plant.steps - 1}, the data "
            f"reach instant {last}"
        )


def _finite(seconds: Vector, at: Place) -> Vector:
    if not np.isfinite(seconds).all():
        k = int(np.argmin(np.isfinite(seconds)))
        raise ValueError(f"{at(k)}: its time is missing")
    return seconds
