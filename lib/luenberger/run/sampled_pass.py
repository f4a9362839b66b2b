"""A filter's pass over a record of a continuous plant, sampled at the record's rows."""

from __future__ import annotations

from typing import Any

from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.progress import Progress
from ..recursion.settings import Settings, accurate_outputs
from ..recursion.settled_pass import SettledPass
from ..recursion.state import History, State
from .discretise import discretise

ROWS = 1 << 13  # whose matrices are held at once


class SampledPass:
    """The way of a filter over a record of a continuous plant.

    The matrices of a stretch of rows are made when these are filtered, and then
    forgotten, so memory does not grow with the record.

    Parameters
    ----------
    plant : Plant
        Continuous.
    m1, weight
        Those of `Settings`.
    tolerance : float or None
        That of `SettledPass`.
    """

    def __init__(
        self, plant: Plant, m1: Any, weight: Any = None,
        tolerance: float | None = None,
    ) -> None:  # fmt: skip
        self.plant, self.weight, self.tolerance = plant, weight, tolerance
        self.accurate = accurate_outputs(plant, m1)
        self._even: tuple[float, SettledPass] | None = None  # a period, and its pass
        self._last: SettledPass | None = None

    def at_hand(self, state: State, y: Matrix, rows: int) -> bool:
        """As `Pass.at_hand`: no, because the discrete plant is not known yet."""
        return False

    def over(
        self, begin: Progress, y: Matrix, u: Matrix, periods: Vector, compile: bool,
        history: bool = False,
    ) -> tuple[Progress, History]:  # fmt: skip
        """Filter the rows of y; return where that leads, and their `History`.

        `periods` (N,) lead to the rows; the rest is as in `Pass.over`.
        """
        out, at = History.empty(len(y), self.plant, history), begin
        settled, bound = list[int](), 0.0
        for k in range(0, len(y), ROWS):
            rows = slice(k, k + ROWS)
            run = self.at(periods[rows], at.instant)
            if run is not self._last:
                state = at.state.under(run.settings)
                at, self._last = Progress(state, gap=at.gap), run
            part = out.part(rows)
            at, _ = run.into(part, at, y[rows], u[rows], compile)
            if at.still is not None:
                part.spread(slice(at.still, len(part.x)), at.Sigma)
            settled += [k + row for row in at.settled]
            bound = max(bound, at.bound)
        return at._replace(settled=tuple(settled), bound=bound, still=None), out

    def at(self, periods: Vector, instant: int) -> SettledPass:
        """The pass over rows to which these periods lead, from an instant on."""
        first = float(periods[0])
        if (periods != first).any():
            uneven = window(self.plant, periods, self.accurate, self.weight, instant)
            return SettledPass(uneven, None)
        if self._even is None or self._even[0] != first:
            even = window(self.plant, periods, self.accurate, self.weight, instant)
            self._even = first, SettledPass(even, self.tolerance)
        return self._even[1]


def window(
    plant: Plant, periods: Vector, m1: Any, weight: Any, instant: int
) -> Settings:
    """The settings of a continuous plant over some periods, from an instant on."""
    even = (periods == periods[0]).all()
    sampled = plant.sampled(periods[0]) if even else discretise(plant, periods)
    return Settings(sampled, m1, weight, origin=instant)
