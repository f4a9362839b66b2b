"""The periods that lead to the rows of a record, as its chunks come in."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

from ..numeric import Vector
from ..plant import Plant
from .clock import ONE_ROW, Place, known, periods, row


class Stretch(NamedTuple):
    """Instants of consecutive rows; `at(k)` says where row k of them is."""

    seconds: np.ndarray
    at: Place


def leading(stretches: Iterator[Stretch]) -> Iterator[Vector]:
    """The periods that lead to the rows of each stretch, from the row before each.

    To the first row leads a period as long as the one behind it.

    Raises
    ------
    ValueError
        If there is one row only, or times do not grow.
    """
    begun: list[Stretch] = []
    while sum(len(one.seconds) for one in begun) < 2:
        if (one := next(stretches, None)) is None:
            break
        begun.append(one)
    if begun:
        at = [partial(one.at, k) for one in begun for k in range(len(one.seconds))]
        seconds = np.concatenate([one.seconds for one in begun])
        steps = periods(seconds, lambda k: at[k]())
        if len(seconds) == 1:
            raise ValueError(ONE_ROW)
        last, steps = seconds[-1:], np.concatenate([steps[:1], steps])
        yield from np.split(steps, np.cumsum([len(one.seconds) for one in begun])[:-1])
    for one in stretches:
        steps = periods(np.concatenate([last, one.seconds]), partial(_later, one.at))
        last = one.seconds[-1:] if len(one.seconds) else last
        yield steps


def _later(at: Place, k: int) -> str:
    return at(k - 1)


@dataclass(frozen=True)
class Timed:
    """Rows of a record as they were given, and the periods (N,) that lead to them."""

    y: Any
    periods: np.ndarray

    def __len__(self) -> int:
        return len(self.y)


def timed(plant: Plant, y: Any, time: Any) -> Any:
    """A record of a continuous plant as `Timed`; of an iterator, an iterator of them.

    `time` is that of `filter_data`; of an iterator, an iterator of chunks like y's.
    """
    if not isinstance(y, Iterator):
        return next(_timed(plant, iter([y]), iter([time])))
    if time is None or isinstance(time, str):
        time = repeat(time)
    if not isinstance(time, Iterator):
        raise ValueError("y is an iterator of chunks, so time must be one too")
    return _timed(plant, y, time)


def _timed(plant: Plant, ys: Iterator, times: Iterator) -> Iterator[Timed]:
    read: deque[Any] = deque()

    def stretches() -> Iterator[Stretch]:
        count, origin = 0, None
        for y in ys:
            read.append(y)
            seconds, origin = known(plant, y, next(times, ()), origin, count)
            yield Stretch(seconds, partial(_row_after, count))
            count += len(y)

    for steps in leading(stretches()):
        yield Timed(read.popleft(), steps)


def _row_after(count: int, k: int) -> str:
    return row(count + k)
