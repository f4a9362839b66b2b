"""A pass over a record whose late readings arrive in order, many rows at a time.

Where a reading arrives before one of an earlier row, or digits would be lost, rows are
done one by one with the readings beside the state, and then it goes on as before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..numeric import Matrix, Vector
from ..plant import Plant
from . import late_step
from .filter_pass import Pass
from .filter_stacks import Stacks, stacks_of
from .late_passage import Ends, Stretches, gone_through
from .late_queue import Block, Plan, Queue, Turns
from .late_state import LateState, Row
from .late_stretches import Rows, Singles
from .settings import Settings
from .state import History, State, flat, start, step

SHORT, LONG = 64, 4096  # rows that are done at a time, from the first on
MOSTLY = 1.1  # copying costs more than that many rows of no use


class InOrder:
    """The way of such a filter: of the Kalman filter, without S, with noisy outputs."""

    def __init__(self, settings: Settings) -> None:
        self.settings, self.run = settings, Pass(settings)
        self.stacks: dict[bytes, Stacks | None] = {}

    def start(self, x: Vector, u: Vector) -> Queue:
        """The filter before the first row."""
        plant, base = self.settings.plant, start(self.settings, x, u)
        none = np.zeros((0, plant.p))
        rows = Block(none, np.zeros((0, plant.m)), none, np.zeros(0))
        few = Stretches.empty(1, plant.n)
        return Queue(base, rows, -1, few.at([]), few, x, base.Sigma, None, None, True)

    def over(self, queue: Queue, block: Block, out: History, compile: bool) -> Queue:
        """Filter the rows of a block; return the filter after them."""
        N, k, length, patience = len(block.labels), 0, SHORT, 1
        if not len(queue.rows.labels):
            queue = queue._replace(rows=block.part(slice(0)))
        quiet = block.quiet() if queue.silent else 0
        while k < N:
            if k >= quiet:
                queue = queue._replace(silent=False)
            rows = slice(k, min(k + length, N if k >= quiet else quiet))
            queue, done = self.many(queue, block.part(rows), out.part(rows), compile)
            k += done
            if k == rows.stop:
                length, patience = min(2 * length, LONG), 1
                continue
            rows = slice(k, min(k + patience, rows.stop))
            queue = self.singly(queue, block.part(rows), out.part(rows), compile)
            length, patience = SHORT, min(2 * patience, LONG)
            k = rows.stop
        return queue

    # -- one by one --------------------------------------------------------------------

    def singly(self, queue: Queue, block: Block, out: History, compile: bool) -> Queue:
        """The rows of a block, with the readings that are awaited beside the state."""
        late, old = queue.late, len(queue.rows.labels)
        if late is None:
            late = self.beside(queue)
        for k, row in enumerate(map(Row, *block)):
            late, _ = late_step.step(self.settings, late, row)
            out.x[k] = late.xi[: self.settings.plant.n, 0]
            out.variances[k] = self.Sigma(late).diagonal()
        rows = queue.rows.then(block)
        absorbed = int(Plan.of(rows).absorbed[old:][-1])
        base, _ = self.run.over(
            queue.base, rows.y[:absorbed], rows.u[:absorbed], compile
        )
        return queue._replace(
            base=base, rows=rows.part(slice(absorbed, None)), turn=-1,
            first=queue.first.at([]), x=out.x[-1], Sigma=self.Sigma(late),
            label=rows.labels[-1], late=late,
        )  # fmt: skip

    def Sigma(self, late: LateState) -> Matrix:
        n = self.settings.plant.n
        return late.spread.Sigma[:n, :n]

    def beside(self, queue: Queue) -> LateState:
        """The same filter, with the readings that are awaited beside the state."""
        base, p = queue.base, self.settings.plant.p
        setting = self.settings.at(base.instant) if base.instant else None
        late = LateState(
            base.instant, base.x, base.spread, base.rounding, base.u,
            np.zeros((p if base.instant else 0, 1)), (), setting,
        )  # fmt: skip
        for row in map(Row, *queue.rows):
            late, _ = late_step.step(self.settings, late, row)
        return late

    # -- many at a time ----------------------------------------------------------------

    def many(
        self, queue: Queue, block: Block, out: History, compile: bool
    ) -> tuple[Queue, int]:
        """Rows of a block as far as they can be done: the filter, and how many."""
        rows, old = queue.rows.then(block), len(queue.rows.labels)
        plan = Plan.of(rows)
        if plan.in_order < len(rows.labels):
            rows = rows.part(slice(plan.in_order))
            plan = plan.part(plan.in_order)
        if len(rows.labels) <= old:
            return queue, 0
        stacks, seen = self.on_time(plan.y)
        if stacks is None:
            return queue, 0
        base, known = self.known(queue, rows, plan, compile)
        begin = np.maximum(plan.absorbed, 0 if queue.base.instant else 1)
        turns = Turns.of(begin, old, queue.turn)
        here = self.under(queue.base, stacks)
        given = Rows.of(stacks, here, plan.y[:, seen], rows.u, compile, queue.silent)
        first, last, good = stretches(queue, given, turns, old)
        ends = through(known, plan.absorbed, turns, first, last, good, old, given)
        bad = np.flatnonzero(~ends.good)
        if len(bad):
            done = int(bad[0])
            if not done:
                return queue, 0
            return self.many(queue, block.part(slice(done)), out, compile)
        done, n = len(ends.x), self.settings.plant.n
        out.x[:done] = ends.x
        out.variances[:done] = ends.P[:, :: n + 1]
        gone, turn = int(plan.absorbed[-1]), int(turns.at[-1])
        return Queue(
            base, rows.part(slice(gone, None)), turn - gone,
            first.at(slice(gone, turn)).copy(),
            last.at([len(rows.labels) - 1 if turn < len(rows.labels) else -1]),
            ends.x[-1], ends.P[-1].reshape(n, n), rows.labels[-1], None,
            queue.silent,
        ), done  # fmt: skip

    def known(
        self, queue: Queue, rows: Block, plan: Plan, compile: bool
    ) -> tuple[State, Ends]:
        """The filter that has every reading, after each of the rows that have them."""
        gone, plant = int(plan.absorbed[-1]), self.settings.plant
        out = History.empty(gone + 1, plant, True)
        base = self.run.into(
            out.part(slice(1, None)), queue.base, rows.y[:gone], rows.u[:gone], compile
        )
        begun = queue.base
        if not begun.instant:  # what leads to the first row may be of its own kind
            begun = step(self.settings, begun, plan.y[0], rows.u[0]).state
        out.x[0], out.P[0] = begun.x[:, 0], begun.Sigma
        return base, Ends(out.x, flat(out.P), np.ones(gone + 1, dtype=bool))

    def on_time(self, y: Matrix) -> tuple[Stacks | None, Vector]:
        """The plant with the outputs that are on time in some row, and which."""
        seen = ~np.isnan(y).all(axis=0)
        if not seen.any():
            seen[:1] = True
        key = seen.tobytes()
        if key not in self.stacks:
            settings = self.settings
            if not seen.all():
                plant = _with_outputs(settings.plant, seen)
                settings = Settings(plant, 0, origin=settings.origin)
            self.stacks[key] = stacks_of(settings)
        return self.stacks[key], seen

    def under(self, base: State, stacks: Stacks) -> State:
        """The state with the outputs of these stacks."""
        seen = np.ones(stacks.plant.p, dtype=bool)
        setting = stacks.settings.at(base.instant) if base.instant else None
        return base._replace(seen=seen, setting=setting)


def _with_outputs(plant: Plant, seen: Vector) -> Plant:
    """A plant with some of its outputs."""
    assert plant.R is not None
    S = None if plant.S is None else plant.S[..., seen]
    names = tuple(name for name, one in zip(plant.output_names, seen) if one)
    return replace(
        plant, C=plant.C[..., seen, :], E=plant.E[..., seen, :], S=S,
        R=plant.R[..., seen, :][..., seen], output_names=names,
    )  # fmt: skip


def stretches(
    queue: Queue, rows: Rows, turns: Turns, old: int
) -> tuple[Stretches, Stretches, Vector]:
    """Up to the turn from each row, from the turn to each row, and which are clear."""
    N, n, flips = len(turns.begin), len(queue.x), turns.flips
    first, last = (Stretches.unknown(N + 1, n, rows.silent) for _ in range(2))
    for some in (first, last):
        some.put([N], Stretches.empty(1, n))
    if queue.turn > 0:
        first.put(slice(queue.turn), queue.first)
    ends = [*flips, N]
    fresh = np.zeros(N, dtype=bool)
    fresh[flips] = True
    clear = np.ones(N, dtype=bool)
    if flips:
        singles, span = Singles(rows), range(turns.begin[flips[0]], flips[-1] + 1)
        if rows.compile:
            singles.growing(fresh, span, first)
        else:
            down(singles, [range(turns.begin[f], f + 1) for f in flips], first)
        inside = np.arange(span.start, span.stop)
        clear[inside] = singles.clear(first, inside) | fresh[inside]
    if rows.compile:
        after = np.concatenate([[False], fresh[:-1]])
        if ends[0] > old:
            rows.growing(queue.last, np.zeros_like(fresh), range(old, ends[0]), last)
        if flips and flips[0] + 1 < N:
            rows.growing(last.at([N]), after, range(flips[0] + 1, N), last)
    else:
        begun = [queue.last, *(last.at([N]) for _ in flips)]
        parts = [range(a, b) for a, b in zip([old, *(f + 1 for f in flips)], ends)]
        up(rows, parts, begun, last)
    return first, last, clear


def up(rows: Rows, parts: list[range], begun: list[Stretches], out: Stretches) -> None:
    """Write the stretch from the first row of each part to each row of it."""
    now = Stretches(*map(np.concatenate, zip(*begun)))
    for turn in range(max(map(len, parts))):
        live = [k for k, part in enumerate(parts) if turn < len(part)]
        index = np.array([parts[k][turn] for k in live])
        grown = rows.grown(now.at(live), index)
        now.put(live, grown)
        out.put(index, grown)


def down(singles: Singles, parts: list[range], out: Stretches) -> None:
    """Write the stretch from each row of each part to the last row of it."""
    now = Stretches.empty(len(parts), singles.n)
    for turn in range(max(map(len, parts))):
        live = [k for k, part in enumerate(parts) if turn < len(part)]
        index = np.array([parts[k][-1 - turn] for k in live])
        longer = singles.before(now.at(live), index)
        now.put(live, longer)
        out.put(index, longer)


def through(
    known: Ends, absorbed: Vector, turns: Turns, first: Stretches, last: Stretches,
    clear: Vector, old: int, given: Rows,
) -> Ends:  # fmt: skip
    """The estimates at the rows from the number `old` on."""
    rows = np.arange(old, len(absorbed))
    begin, at = turns.begin[old:], turns.at[old:]
    how, now, origin = (given.compile, given.silent), known, absorbed[old:]
    for which, some, index in (
        (begin < at, first, begin),
        (at <= rows, last, rows),
    ):
        if MOSTLY * np.count_nonzero(which) > len(which):  # the others through no rows
            now = gone_through(now, origin, some, np.where(which, index, -1), *how)
        else:
            now = now.at(origin)
            found = gone_through(now, np.flatnonzero(which), some, index[which], *how)
            for X, part in zip(now, found):
                X[which] = part
        origin = np.arange(len(rows))
    murky = np.concatenate([[0], np.cumsum(~clear)])
    now.good[:] &= murky[np.maximum(at, begin)] == murky[begin]
    return now
