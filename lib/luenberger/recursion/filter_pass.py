"""One pass of a filter over a record, row by row or in compiled code.

Who does rows takes the `State` before them and gives the one after: `step` does one
row in NumPy, `Block.run` as many as it can.  Another way to do rows enters as another
``run(state, k, out)``, which returns the state and the first row that it left.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..kernels import at_hand, may_be_at_hand
from ..numeric import Matrix
from ..plant import Plant
from .filter_stacks import Block, Stacks, stacks_of
from .known import Known, KnownRows
from .predicted import FILTERED, Loops, Predicted, asked, by_predictions
from .settings import Settings
from .state import Book, History, State, step


@dataclass(frozen=True)
class Pass:
    """The way of a filter over a record: for each row, who does it.

    NumPy's `step` can do every row.  Compiled code does the rows it can, and gives
    up, before it has written anything of the row, where a covariance is singular or
    outputs are noise-free; NumPy does such a row, and so decides what it means.
    """

    settings: Settings

    @property
    def plant(self) -> Plant:
        """The plant that is filtered."""
        return self.settings.plant

    @property
    def accurate(self) -> tuple[int, ...]:
        """The indices of its accurate outputs."""
        return self.settings.accurate

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

    def at_hand(
        self, state: State, y: Matrix, rows: int, loops: Loops = FILTERED
    ) -> bool:
        """Whether the code for rows like y, `rows` in all, has been compiled before."""
        if not may_be_at_hand(rows):
            return False
        if self.by_predictions and loops.predictions is not None:
            whole = not np.isnan(y).any()
            return at_hand(rows, *asked(self.plant, loops.predictions, whole))
        if (stacks := self.stacks) is None:
            return False
        changing = stacks.changing(stacks.complete(state, ~np.isnan(y)))
        known = stacks.entries(changing)
        return at_hand(rows, loops.estimates, stacks.sizes, known, changing)

    def over(
        self, state: State, y: Matrix, u: Matrix, compile: bool, history: bool = False
    ) -> tuple[State, History]:
        """Filter the rows of y; return the state after them, and their `History`.

        `compile` asks for compiled code where it can be had.
        """
        out = History.empty(len(y), self.settings.plant, history)
        return self.into(out, state, y, u, compile), out

    def into(
        self, out: Book, state: State, y: Matrix, u: Matrix, compile: bool,
        loops: Loops = FILTERED,
    ) -> State:  # fmt: skip
        """Filter the rows of y into `out`; return the state after them.

        `loops` is the compiled code, which writes the arrays of `out`.
        """
        rows = self.rows(state, y, u, compile, loops)
        return rows.run(out, state, 0, len(y))

    def rows(
        self, state: State, y: Matrix, u: Matrix, compile: bool,
        loops: Loops = FILTERED,
    ) -> "Rows":  # fmt: skip
        """The same rows, which begin at `state`, ready to be run in parts."""
        block: Block | Predicted | None = None
        if not compile or not len(y):
            pass
        elif self.by_predictions and loops.predictions is not None:
            block = Predicted.of(self.settings, loops.predictions, state, y, u)
        elif (stacks := self.stacks) is not None:
            block = stacks.block(state, y, u, loops.estimates)
        known = self.known.block(state, y, u) if compile and loops.known else None
        return Rows(self.settings, y, u, block, known)


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

    def run(self, out: Book, state: State, k: int, stop: int) -> State:
        """From `state` before row k on: the state before row `stop`."""
        while k < stop:
            if self.block is not None and self.block.ready(state):
                state, done = self.block.run(state, k, out, stop)
                if done == k:
                    state = state._replace(turn=state.turn.later(state.instant))
                k = done
            if k < stop and self.known is not None and isinstance(out, History):
                state, k = self.known.run(state, k, out, stop)
            if k < stop:
                row = step(self.settings, state, self.y[k], self.u[k])
                out.put(k, row)
                state, k = row.state, k + 1
        return state
