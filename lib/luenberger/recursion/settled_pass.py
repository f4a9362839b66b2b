"""A filter's pass over a record that stops the recursion where it has settled.

Whether it has is looked at after so many rows with the same outputs, and then at rows
further and further apart: which rows these are does not depend on chunks.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ..numeric import Matrix, Vector
from ..plant import Plant
from .alike import arrived, every
from .filter_pass import Pass
from .growth import may_grow, passed, require_digits
from .held import Behind
from .innovations import largest
from .looks import Looks
from .progress import Progress
from .settings import Settings
from .settled import Near, ball, distance, near
from .settled_rows import OneGain
from .state import History, State

PATTERNS = 50  # of outputs, whose settled filters are kept at most
SOON, LATE = 16, 16_384  # rows before the first look
CHEAP = 1_300_000  # such rows, divided by n^4, and a look that finds a ball pays soon
CHEAPER = 30_000  # the same of a look whether a gain that is known fits again
NEVER = 2**62  # rows
SHORT = 8  # states up to which a mode that lasts is looked for first
FAR, NEAR = 8.0, 1.5  # how many times as far the next look is, compiled or not


class SettledPass:
    """The way of a filter over a record of a plant that does not change.

    Parameters
    ----------
    settings : Settings
    tolerance : float or None
        How far covariances, and estimates for innovations of one unit, may be from
        those of the full recursion, relative to variances and standard deviations;
        None is the full recursion.
    """

    def __init__(self, settings: Settings, tolerance: float | None) -> None:
        self.run = Pass(settings)
        self.tolerance = None if settings.steps is not None else tolerance
        self.cross = settings.plant.S is not None and bool(settings.plant.S.any())
        self.gains: dict[bytes, OneGain | None] = {}  # None: it will never settle

    @property
    def plant(self) -> Plant:
        """The plant that is filtered."""
        return self.run.plant

    @property
    def settings(self) -> Settings:
        """Its settings."""
        return self.run.settings

    @property
    def accurate(self) -> tuple[int, ...]:
        """The indices of its accurate outputs."""
        return self.run.accurate

    def at_hand(self, state: State, y: Matrix, rows: int) -> bool:
        """As `Pass.at_hand`."""
        return self.run.at_hand(state, y, rows)

    def over(
        self, begin: Progress, y: Matrix, u: Matrix, compile: bool,
        history: bool = False,
    ) -> tuple[Progress, History]:  # fmt: skip
        """Filter the rows of y: where that leads, and their `History`."""
        begun = self.tolerance is not None
        out = History.empty(len(y), self.plant, history, begun)
        return self.into(out, begin, y, u, compile)

    def into(
        self, out: History, begin: Progress, y: Matrix, u: Matrix, compile: bool
    ) -> tuple[Progress, History]:
        """Filter the rows of y into `out`: where that leads, and `out`."""
        if not len(y):
            return begin, out
        if self.tolerance is None:
            found = Progress(self.run.into(out, begin.state, y, u, compile))
            whole = False
        else:
            rows = _Rows(self, begin, y, u, compile, out)
            found, whole, out = rows.run(), every(rows.seen), rows.out
        if found.stretch is not None and whole and begin.gap is None:
            return found, out  # all modes that last are seen, or it had not settled
        if not may_grow(begin.gap, self.settings, whole):
            return found, out
        if found.still is not None:
            out = out.reaching(len(y))
            out.spread(slice(found.still, len(y)), found.Sigma)
            found = found._replace(still=None)
        P = out.P if out.kept else None
        past = passed(self.run, begin.state, y, u, out.variances, compile, P)
        return found._replace(gap=require_digits(begin.gap, past)), out

    def known(self, seen: Vector) -> bool:
        """Whether the gain for these outputs has been found."""
        return self.gains.get(seen.tobytes()) is not None

    @cached_property
    def lasting(self) -> bool:
        """Whether a mode lasts that no output shows, so that no filter ever settles.

        Where the state is long a look tells it in less time.
        """
        return self.plant.n <= SHORT and bool(self.settings.unseen_lasting)

    def gain(self, at: Near, seen: Vector) -> tuple[OneGain | None, bool]:
        """The one gain that rows with outputs `seen` may have behind a step, if any.

        Else the other result tells whether to look again.
        """
        assert self.tolerance is not None
        found, more = ball(at, self.tolerance)
        if found is None:
            return None, more
        return OneGain(at.now, found, seen, self.cross), True

    def keep(self, gain: OneGain | None, seen: Vector) -> None:
        """Keep the gain for these outputs; None if there will never be one."""
        if len(self.gains) < PATTERNS:
            self.gains[seen.tobytes()] = gain


class _Rows:
    """The rows of a chunk, of which the first `done` are done."""

    def __init__(
        self, way: SettledPass, begin: Progress, y: Matrix, u: Matrix, compile: bool,
        out: History,
    ) -> None:  # fmt: skip
        self.way, self.y, self.u, self.out = way, y, u, out
        self.state, self.alike, self.look, self.stretch = begin[:4]
        self.behind, self.near = begin.behind, begin.near
        self.looks = begin.looks or Looks.none(way.plant.n)
        self.rows = way.run.rows(begin.state, y, u, compile)
        block = self.rows.block
        self.seen = arrived(y) if block is None else block.seen
        self.fast = block is not None
        self.first, self.soon = (
            min(max(SOON, rows if self.fast else 0), LATE)
            for rows in (CHEAP // way.plant.n**4, CHEAPER // way.plant.n**3)
        )
        self.done, self.settled, self.bound = 0, list[int](), 0.0
        self.still: int | None = None

    def run(self) -> Progress:
        """All rows: where that leads."""
        for first, last in self.parts():
            same = first == 0 < self.look
            if not (same and (self.seen[0] == self.state.seen).all()):
                self.changes(first)
            while first < last:
                first = self.some(first, last)
        if self.stretch is None:
            self.recur(len(self.y))
        at = self.alike, self.look, self.stretch, self.behind, self.near
        found = Progress(self.state, *at, tuple(self.settled), self.bound, self.still)
        return found._replace(looks=self.looks)

    def changes(self, first: int) -> None:
        """Other outputs arrive from this row on."""
        if self.stretch is not None:
            self.behind = self.stretch.behind
        known = self.way.known(self.seen[first])
        self.stretch, self.near, self.alike = None, None, 0
        self.look = self.soon if known else self.first

    def parts(self) -> Iterator[tuple[int, int]]:
        """The rows (first, last) that have the same outputs, if they are many.

        The first rows and the last ones are parts in any case.
        """
        N = len(self.seen)
        if every(self.seen):
            yield 0, N
            return
        other = np.zeros(N - 1, dtype=bool)
        for output in self.seen.T:
            other |= output[1:] != output[:-1]
        ends = np.concatenate([[0], np.flatnonzero(other) + 1, [N]])
        many = np.diff(ends) >= self.soon
        many[0] = many[-1] = True
        for part in np.flatnonzero(many):
            yield int(ends[part]), int(ends[part + 1])

    def some(self, k: int, last: int) -> int:
        """Rows with the same outputs from k on, up to the row that is returned."""
        if self.stretch is not None:
            self.settled.append(k)
            self.constant(k, last)
            return last
        count = min(self.look - self.alike, last - k)
        self.alike += count
        if self.alike == self.look:
            self.recur(k + count)
            self.look = int(self.look * (FAR if self.fast else NEAR))
            new = not self.way.known(self.state.seen)
            gain = self.gain()
            if gain is not None:
                self.begin(gain, new)
            elif self.state.seen.tobytes() in self.way.gains:
                self.look = NEVER
        return k + count

    def gain(self) -> OneGain | None:
        """The one gain that rows to come may have, if it is worth to look for it."""
        state, tolerance = self.state, self.way.tolerance
        assert tolerance is not None and state.setting is not None
        if state.spread.half is not None:
            return None
        if (key := state.seen.tobytes()) in self.way.gains:
            return self.way.gains[key]
        if not self.looks.worth(tolerance, self.fast):
            return None
        gain, at, more = None, None, not self.way.lasting
        if more:
            at, more = near(state.setting, state.spread, tolerance)
        if at is not None:
            gain, more = self.way.gain(at, state.seen)
        if gain is None:
            self.looks = self.looks.failed(self.fast, quick=at is None)
        if gain is not None or not more:
            self.way.keep(gain, state.seen)
        return gain

    def begin(self, gain: OneGain, new: bool) -> None:
        """Rows with one gain, or a look when they can begin.

        One that is new was found from the covariance that is there.
        """
        assert self.way.tolerance is not None
        own = 0.0
        if not new:
            own = distance(self.state, gain.ball, self.way.tolerance)
        before = self.behind or Behind(0.0, 0.0)
        t = own + before.g * (1 + own)
        if self.near is not None and self.alike >= self.near[0]:
            t = max(own, min(t, self.near[1]))
        if gain.ball.fits(self.way.tolerance, t):
            held, alone = gain.ball.held(t), gain.ball.held(own)
            assert held is not None and alone is not None
            self.stretch = gain.begin(self.state, held, alone, before)
        elif self.near is None and np.isfinite(own):
            wait = gain.ball.rows_until(t, self.way.tolerance)
            if wait is not None:
                self.near = self.alike + wait[0], wait[1]
                self.look = min(self.look, self.near[0])

    def recur(self, stop: int) -> None:
        """The full recursion, up to a row."""
        begin, rows = self.state, slice(self.done, stop)
        self.out = self.out.reaching(stop)
        self.state = self.rows.run(self.out, begin, self.done, stop)
        self.done = stop
        self.looks = self.looks.after(self.out.variances[rows])
        if self.behind is not None:
            read = self.y[rows], self.u[rows], self.out.x[rows]
            s = largest(self.way.settings, begin, *read)
            self.behind = self.behind.after(len(read[0]), s)
            self.bound = max(self.bound, self.behind.bound)

    def constant(self, first: int, last: int) -> None:
        """Rows with one gain."""
        assert self.stretch is not None
        gain, rows = self.stretch.gain, slice(first, last)
        made = gain.over(
            self.stretch, self.y[rows], self.u[rows], self.out.x[rows], self.fast
        )
        self.out.repeat(rows, gain.ball.Sigma, gain.ball.K, gain.seen)
        instant = self.state.instant + last - first
        self.state = gain.after(made, instant, self.out.x[last - 1])
        self.stretch, self.done = made, last
        self.still = first if last == len(self.y) else None
        if self.still is None:
            self.out = self.out.reaching(last)
            self.out.spread(rows, gain.ball.Sigma)
        self.bound = max(self.bound, made.bound)
