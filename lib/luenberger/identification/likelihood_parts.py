"""The likelihood of some records of one plant, and its gradient: one part of many.

Parts do not depend on who works on them, and so neither do the bits of their sum.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..numeric import Matrices
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.state import start
from . import diffuse, score
from .predictions import trail_of
from .records import named
from .settled_record import Evaluator
from .trail import Trail

MANY = 64  # records of a part


class Record(NamedTuple):
    """A record as arrays: y (N, p) with NaN, u (N, m), and the input before them."""

    y: np.ndarray
    u: np.ndarray
    u0: np.ndarray


@dataclass(frozen=True)
class Part:
    """Some records of `of`, numbered from `first`.

    Attributes
    ----------
    wanted : tuple of str
        Matrices in which there are to be gradients.
    each : bool
        Whether values of each record are wanted, or of all together.
    """

    plant: Plant
    records: Sequence[Record]
    fast: bool
    wanted: tuple[str, ...]
    each: bool
    first: int
    of: int

    def found(self) -> list[tuple[float, Matrices]]:
        """The values and gradients."""
        if not self.each:
            return [self.together(self.records, self.first)]
        return [
            self.together([one], self.first + k) for k, one in enumerate(self.records)
        ]

    def together(self, records: Sequence[Record], first: int) -> tuple[float, Matrices]:
        """The likelihood of records, with one gain where theirs has settled."""
        plant = self.plant
        if self.fast and plant.steps is None and records:
            known = None if plant.P0 is None else plant
            settled = Evaluator(records, self.fast)(plant.at(0), known, self.wanted)
            if settled is not None:
                return settled
        return row_by_row(plant, records, self.fast, self.wanted, first, self.of)


def parts(
    plant: Plant, records: Sequence[Record], fast: bool, wanted: tuple[str, ...],
    each: bool,
) -> Iterator[Part]:  # fmt: skip
    """All records, in order."""
    of = len(records)
    for begin in range(0, max(of, 1), MANY):
        end = min(begin + MANY, of)
        yield Part(plant, records[begin:end], fast, wanted, each, begin, of)


def row_by_row(
    plant: Plant, records: Sequence[Record], fast: bool, wanted: tuple[str, ...],
    first: int = 0, of: int | None = None,
) -> tuple[float, Matrices]:  # fmt: skip
    """The likelihood of records, and its gradients in the matrices of `wanted`.

    They are numbered from `first`, `of` in all.
    """
    of = len(records) if of is None else of
    unknown = plant.P0 is None
    settings = Settings(plant, 0)
    total, slopes = 0.0, dict[str, np.ndarray]()
    for k, one in enumerate(records):
        with named(first + k, of):
            found, slope = _of_record(settings, unknown, one, fast, wanted)
        total += found
        slopes = {name: slopes.get(name, 0) + X for name, X in slope.items()}
    return total, slopes


def _of_record(
    settings: Settings,
    unknown: bool,
    record: Record,
    fast: bool,
    wanted: tuple[str, ...],
) -> tuple[float, Matrices]:
    """The likelihood of one record, and its gradients if some are wanted."""
    plant, (y, u, u0) = settings.plant, record
    first, found, beginning = 0, 0.0, None
    if unknown:
        beginning = diffuse.head(settings, y, u)
        found, first, state = (
            beginning.value,
            len(beginning.trail.free),
            beginning.state,
        )
    else:
        state = start(settings, plant.x0, u0)
    gap = None if beginning is None else beginning.gap
    trail = trail_of(settings, state, y[first:], u[first:], fast, bool(wanted), gap)
    found += value(trail.settled())
    if not wanted:
        return found, {}
    sums, now = score.Sums(plant, wanted), score.Adjoint.after(plant.n)
    now = score.back(trail, plant, u[first:], sums, now, first + 1)
    if beginning is None:
        return found, sums.found | score.at_start(plant, now, u0, sums)
    diffuse.back(beginning, plant, u[:first], sums, now)
    return found, sums.found


def value(trail: Trail) -> float:
    """The logarithm of the likelihood, from its rows."""
    count = int(trail.free.sum())
    exponent = float(trail.log_det.sum() + trail.square.sum())
    return -0.5 * float(count * np.log(2 * np.pi) + exponent)
