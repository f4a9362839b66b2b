"""Instants of a record: evenly dt apart, or those a continuous plant is sampled at."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..errors import short
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
ONE_ROW = "one row has no sampling period; give at least two, or plant.sampled(0.1)"
Place = Callable[[int], str]  # how a message names row k


def row(k: int) -> str:
    return f"row {k}"


class Clock:
    """The instants of a record of a discrete system, as its chunks come in.

    `time` is that of `Record`.
    """

    def __init__(self, of: Plant | Observer, time: Any = None) -> None:
        self.dt, self.time = of.dt, time
        self.names = (*(of.output_names or ()), *(of.input_names or ()))
        self.first = self.last = 0.0
        self.count = 0
        self.origin: Any = None  # of dates

    def follow(self, y: Any) -> None:
        """`require` of the instants of the next rows y, where they are known."""
        first = self.count
        found = instants(y, self.time, self.names, self.origin, first)
        if found is not None:
            seconds, self.origin = found
            self.require(seconds, lambda k: row(first + k))

    def require(self, seconds: Vector, at: Place = row) -> None:
        """Raise ValueError unless the next rows are about dt apart, and keep in step.

        A step may be off by less than dt / 2, the whole by dt / 2 or 1 %.
        """
        seconds, dt = _finite(seconds, at), self.dt
        if not len(seconds):
            return
        if not self.count:
            self.first = self.last = float(seconds[0])
        steps = np.diff(seconds, prepend=self.last)
        if not self.count:
            steps[0] = dt
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
        self.last, self.count = float(seconds[-1]), self.count + len(seconds)


def periods(seconds: Vector, at: Place = row) -> Vector:
    """Seconds from each row to the next; those that differ by rounding are equal.

    Raises
    ------
    ValueError
        If an instant is missing or is not after the one before.
    """
    seconds = _finite(seconds, at)
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


def leading(last: Vector, seconds: Vector, at: Place) -> Vector:
    """The periods that lead to each row; `last` has the instant before, if any.

    To the first row of a record leads a period as long as the one behind it.

    Raises
    ------
    ValueError
        If the record has one row only, or times do not grow.
    """
    before = len(last)
    steps = periods(np.concatenate([last, seconds]), lambda k: at(k - before))
    if not before and len(seconds) == 1:
        raise ValueError(ONE_ROW)
    return steps if before else np.concatenate([steps[:1], steps])


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


class Column:
    """The time column of a CSV file, read a piece at a time.

    Its cells are seconds or dates, or instants: numbers of samples.
    """

    def __init__(self, name: str, of: Plant | Observer) -> None:
        dt = of.dt
        if dt == 0 and name.lower() == "instant":
            raise ValueError(
                f"the column {name!r} counts samples, but a continuous plant has no "
                "period; give a column 'time', or the plant.sampled(0.1) that was read"
            )
        self.name, self.watch = name, Clock(of) if dt > 0 else None
        self.unit = dt if name.lower() == "instant" else 1.0
        self.origin: Any = None

    def seconds(self, cells: Sequence[str], at: Place) -> Vector:
        """The seconds of the next rows, in step with dt.

        Raises
        ------
        ValueError
            Naming the line of a cell that is no instant, or contradicts dt.
        """
        try:
            found, self.origin = time_stamps.seconds(cells, self.origin)
        except time_stamps.NoStamp as error:
            raise ValueError(
                f"{at(error.row)}: {self.name!r} is {short(str(error))}, {error.lacks}"
                f". {MEND if self.watch else ALIKE}"
            ) from None
        found = found * self.unit
        if self.watch is not None:
            self.watch.require(found, at)
        return found


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
