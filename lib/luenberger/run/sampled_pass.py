"""A filter's pass over a record of a continuous plant, sampled at the record's rows."""

from __future__ import annotations

from typing import Any

from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.settings import Settings, accurate_outputs
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
    """

    def __init__(self, plant: Plant, m1: Any, weight: Any = None) -> None:
        self.plant, self.weight = plant, weight
        self.accurate = accurate_outputs(plant, m1)
        self._even: tuple[float, Pass] | None = None  # a period, and its pass

    def over(
        self, state: State, y: Matrix, u: Matrix, periods: Vector, compile: bool,
        history: bool = False,
    ) -> tuple[State, History]:  # fmt: skip
        """Filter the rows of y; return the state after them, and their `History`.

        `periods` (N,) lead to the rows; the rest is as in `Pass.over`.
        """
        out = History.empty(len(y), self.plant, history)
        for begin in range(0, len(y), ROWS):
            rows = slice(begin, begin + ROWS)
            run = self.at(periods[rows], state.instant)
            state = state.under(run.settings)
            state = run.into(out.part(rows), state, y[rows], u[rows], compile)
        return state, out

    def at(self, periods: Vector, instant: int) -> Pass:
        """The pass over rows to which these periods lead, from an instant on."""
        first = float(periods[0])
        if (periods != first).any():
            return Pass(
                window(self.plant, periods, self.accurate, self.weight, instant)
            )
        if self._even is None or self._even[0] != first:
            even = window(self.plant, periods, self.accurate, self.weight, instant)
            self._even = first, Pass(even)
        return self._even[1]


def window(
    plant: Plant, periods: Vector, m1: Any, weight: Any, instant: int
) -> Settings:
    """The settings of a continuous plant over some periods, from an instant on."""
    even = (periods == periods[0]).all()
    sampled = plant.sampled(periods[0]) if even else discretise(plant, periods)
    return Settings(sampled, m1, weight, origin=instant)
