"""One pass of a filter over a record, row by row or in compiled code."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .filter_stacks import Stacks
from .settings import Settings
from .state import step


class History(NamedTuple):
    """What a pass found, a row for each row of the record.

    ``x, variances`` (N, n) are estimates and the diagonals of P (N, n, n); K is
    (N, n, p).  P and K have no rows where they are not kept.
    """

    x: np.ndarray
    variances: np.ndarray
    P: np.ndarray
    K: np.ndarray

    @classmethod
    def empty(cls, rows, plant, kept):
        """Room for so many rows of a plant, with P and K if they are `kept`."""
        n, all_ = plant.n, rows if kept else 0
        x, variances = np.empty((rows, n)), np.empty((rows, n))
        return cls(x, variances, np.empty((all_, n, n)), np.zeros((all_, n, plant.p)))

    def put(self, k, state, gain):
        """Write row k."""
        self.x[k], self.variances[k] = state.x[:, 0], state.Sigma.diagonal()
        if len(self.P):
            self.P[k], self.K[k][:, state.seen] = state.Sigma, gain


@dataclass(frozen=True)
class Pass:
    """The way of a filter over a record: for each row, who does it.

    NumPy's `step` can do every row.  Compiled code does the rows it can, and gives
    up, before it has written anything of the row, where a covariance is singular or
    outputs are noise-free; NumPy does such a row, and so decides what it means.
    """

    settings: Settings

    @cached_property
    def stacks(self):
        return Stacks(self.settings)

    def over(self, state, y, u, compile, history=False):
        """Filter the rows of y; return the state after them, and their `History`.

        `compile` asks for compiled code where it can be had.
        """
        out = History.empty(len(y), self.settings.plant, history)
        block = None
        if compile and len(y) and self.stacks.applies:
            block = self.stacks.block(state, y, u)
        k = 0
        while k < len(y):
            if block is not None and state.ready:
                state, done = block.run(state, k, out)
                if done == k:
                    state = replace(state, turn=state.turn.later(state.instant))
                k = done
            if k < len(y):
                state, gain = step(self.settings, state, y[k], u[k])
                out.put(k, state, gain)
                k += 1
        return state, out
