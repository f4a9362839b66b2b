"""Instants as seconds, from numbers or dates of a file or of a pandas table."""

import math
import re
from collections.abc import Sequence
from datetime import datetime
from typing import Any

import numpy as np

NAMES = ("time", "t")  # of columns and indices that hold instants
NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)


Instants = tuple[np.ndarray, Any]  # seconds, and what they count from


class NoStamp(ValueError):
    """Row `row` of the texts is no instant; the message is its text."""

    def __init__(self, row: int, text: str) -> None:
        super().__init__(text)
        self.row = row


def seconds(
    texts: Sequence[str], origin: datetime | None = None
) -> tuple[np.ndarray, datetime | None]:
    """Instants in seconds; dates count from `origin`, by default the first of them.

    Returns the seconds and the origin, which is None for numbers.

    >>> seconds(["2026-01-05T10:00:00", "2026-01-05T10:00:01.5"])[0]
    array([0. , 1.5])
    """
    if not texts:
        return np.zeros(0), origin
    if origin is None and NUMBER.fullmatch(texts[0]):
        return np.array([_number(k, text) for k, text in enumerate(texts)]), None
    start = origin or _date(texts[0])
    found = np.empty(len(texts))
    for k, text in enumerate(texts):
        date = _date(text)
        if (
            date is None
            or start is None
            or (date.tzinfo is None) != (start.tzinfo is None)
        ):
            raise NoStamp(k, text)
        found[k] = (date - start).total_seconds()
    return found, start


def _number(row: int, text: str) -> float:
    value = float(text) if NUMBER.fullmatch(text) else math.inf
    if not math.isfinite(value):
        raise NoStamp(row, text)
    return value


def _date(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text.strip())
    except ValueError:
        return None


def of_table(table: Any, signals: Sequence[str], origin: Any = None) -> Instants | None:
    """The instants (N,) of a DataFrame or Series in seconds, or None if it has none.

    They are an index of dates, durations or decimal numbers, or one called `time` or
    `t`; or a column of such a name that is no signal.  NaN is a missing one.  Dates
    count from `origin`, by default the first; it is returned beside them.
    """
    index = table.index
    kind = getattr(index.dtype, "kind", "O")
    if type(index).__name__ == "PeriodIndex":
        return of_values(index.to_timestamp(), origin)
    if kind in "mMf" or index.name in NAMES or type(index).__name__ == "DatetimeIndex":
        return of_values(index, origin)
    for name in getattr(table, "columns", ()):
        if isinstance(name, str) and name.lower() in NAMES and name not in signals:
            return of_values(table[name], origin)
    return None


def of_values(values: Any, origin: Any = None) -> Instants:
    """The same of an array, index or column: numbers, dates, durations or text."""
    if getattr(values, "tz", None) is not None:
        values = values.tz_convert("UTC").tz_localize(None)
    array = np.asarray(values)
    if array.dtype.kind in "biuf":
        return array.astype(float), None
    if array.dtype.kind not in "mM":
        return seconds([str(value) for value in array], origin)
    if array.dtype.kind == "M":
        origin = array[:1] if origin is None else origin
        array = array - origin
    return array / np.timedelta64(1, "s"), origin
