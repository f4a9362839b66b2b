"""One pass of a filter over a record whose readings may arrive late.

Three ways give the same numbers.  `InOrder` does many rows at a time, and the cost of a
row does not hang on how many are late.  `Waiting` carries the readings that have not
arrived beside the state, and costs (n + q)^2 with q of them; it takes any covariances.
With noisy outputs that are taken as accurate, the gain of every row hangs on all that
is known by then: so `Again` runs the filter again from the first row at which something
arrived.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import DesignError, short
from ..numeric import Matrix, Vector
from . import late_state, late_step
from .growth import Gap, Passed, require_digits
from .late_in_order import InOrder
from .late_queue import Block, Queue
from .late_state import Label, LateState, Row
from .settings import Settings
from .state import History, State, start, step


class Done(NamedTuple):
    """A row that was done: the state x (n,), its covariance, the gain (n, p)."""

    x: np.ndarray
    Sigma: np.ndarray
    K: np.ndarray


class Way(Protocol):
    """How rows are done: from a state before a row to the one after it."""

    def start(self, settings: Settings, x: Vector, u: Vector) -> Any:
        """The state before the first row."""

    def row(self, settings: Settings, state: Any, row: Row) -> tuple[Any, Done]:
        """One row."""

    def Sigma(self, state: Any, n: int) -> Matrix:
        """The covariance (n, n) of the error of the estimate."""

    def awaited(self, state: Any) -> Iterable[tuple[int, int]]:
        """Instant and output of the readings that have not arrived yet."""


class Waiting:
    """The state beside the readings that have not arrived."""

    def start(self, settings: Settings, x: Vector, u: Vector) -> LateState:
        return late_state.start(settings, x, u)

    def row(
        self, settings: Settings, state: LateState, row: Row
    ) -> tuple[LateState, Done]:
        state, K = late_step.step(settings, state, row)
        n = settings.plant.n
        return state, Done(state.xi[:n, 0], state.spread.Sigma[:n, :n], K)

    def Sigma(self, state: LateState, n: int) -> Matrix:
        return state.spread.Sigma[:n, :n]

    def awaited(self, state: LateState) -> Iterable[tuple[int, int]]:
        return [(h.instant, h.output) for h in state.held if h.value == h.value]


class Window(NamedTuple):
    """The rows since the first that awaits a reading, and the filter before each.

    ``states`` has one more than ``rows``: the last is the filter now.
    """

    states: tuple[State, ...]
    rows: tuple[Row, ...]
    label: Label
    gap: Gap | None = None

    @property
    def instant(self) -> int:
        """That of the last row."""
        return self.states[-1].instant


class Again:
    """The filter, run again from the first row at which a reading arrived."""

    def start(self, settings: Settings, x: Vector, u: Vector) -> Window:
        return Window((start(settings, x, u),), (), None)

    def row(self, settings: Settings, window: Window, row: Row) -> tuple[Window, Done]:
        rows, states, now = [*window.rows, row], list(window.states), row.label
        news = [_arrived(one, window.label, now).any() for one in rows[:-1]]
        first = [*news, True].index(True)
        del states[first + 1 :]
        for one in rows[first:]:
            state, new, _ = step(settings, states[-1], _known(one, now), one.u)
            states.append(state)
        gain = np.zeros((settings.plant.n, settings.plant.p))
        gain[:, state.seen] = new["K"]
        waits = [_awaited(one, now).any() for one in rows]
        keep = [*waits, True].index(True)
        kept = Window(tuple(states[keep:]), tuple(rows[keep:]), now)
        return kept, Done(state.x[:, 0], state.Sigma, gain)

    def Sigma(self, window: Window, n: int) -> Matrix:
        return window.states[-1].Sigma

    def awaited(self, window: Window) -> Iterable[tuple[int, int]]:
        for state, row in zip(window.states, window.rows):
            for j in np.flatnonzero(_awaited(row, window.label)).tolist():
                yield state.instant + 1, j


def _known(row: Row, now: Label) -> Vector:
    return np.where(_awaited(row, now), np.nan, row.y)


def _awaited(row: Row, now: Label) -> Vector:
    return ~np.isnan(row.y) & (row.due > now)


def _arrived(row: Row, before: Label, now: Label) -> Vector:
    return ~np.isnan(row.y) & (row.due > before) & (row.due <= now)


@dataclass(frozen=True)
class LatePass:
    """The way of a filter over a record whose readings arrive late.

    ``horizon`` is the number of rows after which a reading is refused, or None.  With
    a ``history`` the covariance and gain of every row are kept.
    """

    settings: Settings
    horizon: int | None
    history: bool = False

    @cached_property
    def way(self) -> Way:
        """How rows are done one by one."""
        accurate = list(self.settings.accurate)
        return Again() if self.settings.R[..., accurate, :].any() else Waiting()

    @cached_property
    def many(self) -> InOrder | None:
        """How many rows are done at a time, where that is possible."""
        settings, S = self.settings, self.settings.plant.S
        cross = S is not None and S.any()
        if self.history or cross or settings.accurate or settings.noise_free:
            return None
        return InOrder(settings)

    def start(self, x: Vector, u: Vector) -> Any:
        """The state before the first row."""
        if self.many is not None:
            return self.many.start(x, u)
        return self.way.start(self.settings, x, u)

    def Sigma(self, state: Any) -> Matrix:
        """The covariance (n, n) of the error of the estimate."""
        if isinstance(state, Queue):
            return state.Sigma
        return self.way.Sigma(state, self.settings.plant.n)

    def over(
        self,
        state: Any,
        y: Matrix,
        u: Matrix,
        due: Matrix,
        labels: Vector,
        compile: bool = False,
    ) -> tuple[Any, History]:
        """Filter the rows of y; return the state after them, and their `History`.

        `compile` asks for compiled code where it can be had.
        """
        settings, way, history = self.settings, self.way, self.history
        if state.label is not None and len(labels) and not state.label < labels[0]:
            raise ValueError(
                f"rows are in order of their index, but row {state.instant} does not "
                "come after the row before it: it is the first of a chunk. Give each "
                "chunk the index that its rows have in the whole record."
            )
        out, begin = History.empty(len(y), settings.plant, history), state
        block = Block(y, u, due, labels)
        if self.many is not None:
            self.require_known(state.rows, block, state.base.instant)
            state = self.many.over(state, block, out, compile)
            return self.require_digits(begin, state, block, out), out
        for k, row in enumerate(map(Row, *block)):
            state, done = way.row(settings, state, row)
            out.x[k], out.variances[k] = done.x, done.Sigma.diagonal()
            if history:
                out.P[k], out.K[k] = done.Sigma, done.K
            if self.horizon is not None:
                self.require_in_time(way.awaited(state), state.instant)
        return self.require_digits(begin, state, block, out), out

    def require_digits(self, begin: Any, state: Any, block: Block, out: History) -> Any:
        """The `state` after a block, unless states have grown too far in it.

        Readings that are late are missing in their rows.
        """
        y = np.where(block.due > block.labels[:, None], np.nan, block.y)

        def Sigma(first: int, last: int) -> Matrix:
            at, found, n = begin, [], self.settings.plant.n
            if isinstance(begin, Queue) and self.many is not None:
                at = begin.late or self.many.beside(begin)
            for row in map(Row, *block.part(slice(last))):
                at, _ = self.way.row(self.settings, at, row)
                found.append(self.way.Sigma(at, n))
            return np.array(found[first:])

        rows = Passed(self.settings, begin.instant + 1, out.variances, y, Sigma)
        return state._replace(gap=require_digits(begin.gap, rows))

    def require_in_time(self, awaited: Iterable[tuple[int, int]], instant: int) -> None:
        """Raise if a reading has been waited for as long as the horizon says."""
        for taken, output in awaited:
            if self.horizon is not None and instant - taken >= self.horizon:
                name = short(self.settings.plant.output_names[output])
                raise DesignError(
                    f"the reading of {name} in row {taken - 1} has not arrived by row "
                    f"{instant - 1}, and horizon={self.horizon} rows is the longest "
                    "wait. Raise horizon, or give it no arrival: then it never arrives."
                )

    def require_known(self, awaited: Block, block: Block, before: int) -> None:
        """The same of a block of rows behind some that await readings.

        `before` is the instant before the first of these.
        """
        if self.horizon is None:
            return
        rows = awaited.then(block) if len(awaited.labels) else block
        last = np.arange(len(rows.labels)) + self.horizon
        there = (last < len(rows.labels)) & (last >= len(awaited.labels))
        taken = np.flatnonzero(there)
        late = _awaited(
            Row(rows.y[taken], rows.u, rows.due[taken], None),
            rows.labels[last[taken], None],
        )
        for k, j in np.argwhere(late)[:1].tolist():
            row = before + int(taken[k]) + 1
            self.require_in_time([(row, j)], row + self.horizon)
