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
    """Row `row` of the texts is no instant; the message is its text.

    `lacks` says what it is not, and what the rows before it are.
    """

    def __init__(self, row: int, text: str, lacks: str) -> None:
        super().__init__(text)
        self.row, self.lacks = row, lacks


Origin = datetime | int | None  # a date, 0 of numbers, None of what is not known yet


def seconds(texts: Sequence[str], origin: Origin = None) -> tuple[np.ndarray, Origin]:
    """Instants in seconds; dates count from `origin`, by default the first of them.

    Returns the seconds and the origin, with which later texts have to agree.

    >>> seconds(["2026-01-05T10:00:00", "2026-01-05T10:00:01.5"])[0]
    array([0. , 1.5])
    """
    if not texts:
        return np.zeros(0), origin
    if isinstance(origin, int) or (origin is None and NUMBER.fullmatch(texts[0])):
        return np.array([_number(k, text) for k, text in enumerate(texts)]), 0
    start = origin or _date(texts[0])
    found = np.empty(len(texts))
    for k, text in enumerate(texts):
        date = _date(text)
        if start is None:
            raise NoStamp(
                k,
                text,
                "not a number of seconds nor a date such as 2026-01-05T10:00:00",
            )
        if date is None:
            raise NoStamp(k, text, "not a date, as in the rows before")
        if (date.tzinfo is None) != (start.tzinfo is None):
            has, have = ("a", "none") if start.tzinfo is None else ("no", "one")
            raise NoStamp(
                k, text, f"with {has} zone, where the rows before have {have}"
            )
        found[k] = (date - start).total_seconds()
    return found, start


def _number(row: int, text: str) -> float:
    value = float(text) if NUMBER.fullmatch(text) else math.inf
    if not math.isfinite(value):
        raise NoStamp(row, text, "not a number of seconds, as in the rows before")
    return value


def _date(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text.strip(' "\t'))  # quotes of 10:00:00,5
    except ValueError:
        return None


def of_table(table: Any, signals: Sequence[str], origin: Any = None) -> Instants | None:
    """The instants (N,) of a DataFrame or Series in seconds, or None if it has none.

    They are an index of dates, durations or decimal numbers, or one called `time` or
    `t`; or a column of such a name that is no signal; or an index of text of which
    some is a date.  NaN is a missing one.  Dates count from `origin`, by default the
    first; it is returned beside them.
    """
    index = table.index
    kind = getattr(index.dtype, "kind", "O")
    if type(index).__name__ == "PeriodIndex":
        return of_values(index.to_timestamp(), origin)
    dates = type(index).__name__ == "DatetimeIndex"
    if kind in "mMf" or str(index.name).lower() in NAMES or dates:
        return of_values(index, origin)
    for name in getattr(table, "columns", ()):
        if is_time(name, signals):
            return of_values(table[name], origin)
    if kind not in "biu" and any(map(_is_date, index)):
        return of_values(index, origin)
    return None


def _is_date(value: Any) -> bool:
    text = str(value)
    return not NUMBER.fullmatch(text) and _date(text) is not None


def is_time(name: object, signals: Sequence[str]) -> bool:
    """Whether a column of that name, beside those of signals, holds instants."""
    return isinstance(name, str) and name.lower() in NAMES and name not in signals


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
