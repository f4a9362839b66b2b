"""One pass of a filter over a record, row by row or in compiled code.

Who does rows takes the `State` before them and gives the one after: `step` does one
row in NumPy, `Block.run` as many as it can.  Another way to do rows enters as another
``run(state, k, out)``, which returns the state and the first row that it left.
"""

from dataclasses import dataclass
from functools import cached_property

from ..numeric import Matrix
from .filter_stacks import Block, Stacks, stacks_of
from .known import Known, KnownRows
from .predicted import Predicted, by_predictions
from .settings import Settings
from .state import History, State, step


@dataclass(frozen=True)
class Pass:
    """The way of a filter over a record: for each row, who does it.

    NumPy's `step` can do every row.  Compiled code does the rows it can, and gives
    up, before it has written anything of the row, where a covariance is singular or
    outputs are noise-free; NumPy does such a row, and so decides what it means.
    """

    settings: Settings

    @cached_property
    def stacks(self) -> Stacks | None:
        return stacks_of(self.settings)

    @cached_property
    def by_predictions(self) -> bool:
        """Whether compiled code may go from prediction to prediction."""
        return by_predictions(self.settings)

    @cached_property
    def known(self) -> Known:
        """Whether a state may be known exactly."""
        return Known(self.settings)

    def over(
        self, state: State, y: Matrix, u: Matrix, compile: bool
    ) -> tuple[State, History]:
        """Filter the rows of y; return the state after them, and their `History`.

        `compile` asks for compiled code where it can be had.
        """
        block: Block | Predicted | None = None
        if not compile or not len(y):
            pass
        elif self.by_predictions:
            block = Predicted.of(self.settings, state, y, u)
        elif (stacks := self.stacks) is not None:
            block = stacks.block(state, y, u)
        known = self.known.block(state, y, u) if compile else None
        out = History.empty(len(y), self.settings.plant)
        rows = Rows(self.settings, y, u, block, known)
        return rows.run(out, state), out


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a record; `block` is None where NumPy does them all.

    `known` does those of a state that is known exactly.
    """

    settings: Settings
    y: Matrix
    u: Matrix
    block: Block | Predicted | None
    known: KnownRows | None = None

    def run(self, out: History, state: State) -> State:
        """From `state` before the first row on: the state behind the last."""
        k, stop = 0, len(self.y)
        while k < stop:
            if self.block is not None and self.block.ready(state):
                state, done = self.block.run(state, k, out, stop)
                if done == k:
                    state = state._replace(turn=state.turn.later(state.instant))
                k = done
            if k < stop and self.known is not None:
                state, k = self.known.run(state, k, out, stop)
            if k < stop:
                row = step(self.settings, state, self.y[k], self.u[k])
                out.put(k, row)
                state, k = row.state, k + 1
        return state
