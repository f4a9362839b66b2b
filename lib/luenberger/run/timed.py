"""The periods that lead to the rows of a record, as its chunks come in."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..numeric import Vector
from .clock import ONE_ROW, Place, periods


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
