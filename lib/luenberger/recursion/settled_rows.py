"""Rows of a record with one gain, in lanes, and how far they can be from the recursion.

A lane is a part of the record.  It begins from zero so many rows early that nothing is
left of that where it is written, so lanes do not wait for each other.  They are counted
from the row at which the recursion stopped: however a record is cut into chunks, every
row is computed alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import kernels
from ..kernels.lanes import Lanes, in_lanes
from ..numeric import Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.factors import EPS
from ..papers.leondes_novak.derivation import settled_gain, settled_row
from .root_step import Spread
from .settings import Setting
from .settled import Ball
from .state import State

ROW = Lanes(settled_row, ("x_next", "x"), "r", "xs", "epsilon")
LONG = 8  # times as long as it begins early, a lane is
FADED = EPS / 16  # of a start, that is nothing
COUNT = 16  # lanes at once; half as many where the state is long
LARGE = 16  # states from which it is


class Stretch(NamedTuple):
    """Rows with one gain so far: `rows` of them.

    ``x`` is the lane that is written, ``early`` the next one, if it has begun, and
    ``largest`` has the largest entries met so far; see `kernels.lanes.source`.
    ``read`` (2, .) are y and u of the last row.
    """

    gain: OneGain
    rows: int
    x: np.ndarray
    early: np.ndarray
    largest: np.ndarray
    last: tuple[np.ndarray, np.ndarray]

    @property
    def bound(self) -> float:
        """How far covariances and estimates can be from those of the full recursion."""
        return self.gain.bound(self.largest)


class OneGain:
    """The filter of a `Ball`, for rows with the same outputs.

    A row reads its y and u, the u before, and with S the y before.
    """

    def __init__(self, now: Setting, ball: Ball, seen: Vector, cross: bool) -> None:
        self.now, self.ball, self.seen, self.cross = now, ball, seen, cross
        made = kernels.compiled(settled_gain)(
            B=now.B, C=now.C, E=now.E, J=now.J, As=now.As, K=ball.K
        )
        back = np.linalg.inv(np.linalg.cholesky(ball.M)) if len(ball.M) else ball.M
        read = [made["G_e"], made["G_u"]], [-now.E, -made["N_u"]]
        if cross:
            read[0].append(made["G_y"])
            read[1].append(-made["N_y"])
        self.Phi = np.ascontiguousarray(made["Phi"])
        self.G_r = np.concatenate([ball.K, *read[0]], axis=1)
        self.W_x = -back @ made["N_x"]
        self.W_r = back @ np.concatenate([np.eye(len(now.C)), *read[1]], axis=1)
        inner = np.linalg.inv(ball.inverse)
        scale = ball.unit[:, None]
        moved = now.As @ (np.eye(len(now.A)) - ball.K @ now.C)
        moved = ball.inverse @ (moved / scale * ball.unit) @ inner
        sums = Sums(moved)
        self.early = sums.fades(np.ones(len(inner)), FADED)
        self.long = LONG * self.early

    def begin(self, state: State) -> Stretch:
        """The stretch that begins after `state`."""
        n, k = self.G_r.shape
        y = np.full(len(self.seen), np.nan)
        y[self.seen] = (
            state.rho[:, 0] + (self.now.E @ state.u) + self.now.C @ state.x[:, 0]
        )
        return Stretch(
            self, 0, state.x[:, 0], np.zeros(n), np.zeros(n + k + 1), (y, state.u)
        )

    def read(self, at: Stretch, y: Matrix, u: Matrix) -> Matrix:
        """What each row reads (N, k), from y (N, p) and u (N, m) of the record."""
        shown = y if self.seen.all() else y[:, self.seen]
        if not u.shape[1] and not self.cross:
            return np.ascontiguousarray(shown)
        parts = [shown, u, np.concatenate([at.last[1][None], u[:-1]])]
        if self.cross:
            parts.append(np.concatenate([at.last[0][self.seen][None], shown[:-1]]))
        return np.concatenate(parts, axis=1)

    def over(
        self, at: Stretch, y: Matrix, u: Matrix, xs: Matrix, fast: bool
    ) -> Stretch:
        """Estimates of the rows of y, written to xs; the stretch after them."""
        r = self.read(at, y, u)
        if fast:
            x, early, largest = _LanesOver(self, at, r, xs).run()
        else:
            x, largest = self.one_by_one(at, r, xs)
            early = at.early
        largest = np.maximum(at.largest, largest)
        return Stretch(self, at.rows + len(r), x, early, largest, (y[-1], u[-1]))

    def one_by_one(self, at: Stretch, r: Matrix, xs: Matrix) -> tuple[Vector, Vector]:
        """The same in NumPy, row after row."""
        x, row = at.x[:, None], kernels.compiled(settled_row)
        given = dict(Phi=self.Phi, G_r=self.G_r, W_x=self.W_x, W_r=self.W_r)
        longest = 0.0
        for k in range(len(r)):
            made = row(**given, x=x, r=r[k, :, None])
            x = made["x_next"]
            xs[k] = x[:, 0]
            longest = max(longest, float(made["epsilon"][:, 0] @ made["epsilon"][:, 0]))
        sizes = np.abs(xs).max(axis=0), np.abs(r).max(axis=0), [longest]
        return x[:, 0], np.concatenate(sizes)

    def after(self, at: Stretch, instant: int, x: Vector) -> State:
        """The state after a stretch, whose last estimate is x."""
        y, u = at.last
        rho = y[self.seen] - self.now.E @ u - self.now.C @ x
        spread = Spread(self.ball.Sigma)
        return State(
            instant, x[:, None], spread, None, u, self.seen, rho[:, None], self.now
        )

    def bound(self, largest: Vector) -> float:
        """The bound for rows in which these are the largest numbers."""
        n, k = self.G_r.shape
        x, r, s = largest[:n], largest[n : n + k], float(np.sqrt(largest[-1]))
        ball, now = self.ball, self.now
        kept = np.eye(n) + np.abs(ball.K) @ np.abs(now.C)
        size = (
            kept @ (now.move.size @ x + self.size_read(r))
            + np.abs(ball.K) @ r[: len(now.C)]
        )
        size = 2 * (n + k + len(now.C) + 2) * EPS * size
        lost = FADED * n * ball.length(now.move.size @ x)
        apart = ball.apart(s, size, lost)
        return float(max(ball.variances.max(initial=0.0), apart.max(initial=0.0)))

    def size_read(self, r: Vector) -> Vector:
        """How large the numbers are that a row's readings add to a prediction."""
        now, p = self.now, len(self.now.C)
        m = now.B.shape[1]
        u_next, u, y = r[p : p + m], r[p + m : p + 2 * m], r[p + 2 * m :]
        found = (np.abs(now.B) + np.abs(now.J) @ np.abs(now.E)) @ u
        found += np.abs(self.ball.K) @ np.abs(now.E) @ u_next
        return found + (np.abs(now.J) @ y if self.cross else 0.0)


class _LanesOver:
    """The rows of a chunk in lanes."""

    def __init__(self, gain: OneGain, at: Stretch, r: Matrix, xs: Matrix) -> None:
        self.gain, self.at = gain, at
        n, k = gain.G_r.shape
        self.n, self.count = n, COUNT if n < LARGE else COUNT // 2
        sizes = ("n", n), ("k", k), ("j", len(gain.W_x))
        self.kernel = in_lanes(ROW, sizes, self.count)
        self.given = dict(Phi=gain.Phi, G_r=gain.G_r, W_x=gain.W_x, W_r=gain.W_r)
        self.given |= dict(r=r, xs=xs)
        self.largest = np.zeros((n + k + 1) * self.count)
        self.begin, self.end = at.rows, at.rows + len(r)

    def run(self) -> tuple[Vector, Vector, Vector]:
        """The lane that is written last, the one begun early, the largest entries."""
        m, w, first, end = self.gain.long, self.gain.early, self.begin, self.end
        here, last = first // m, end // m
        whole = range(max(here + 1, -(-(first + w) // m)), last)  # begun, ended here
        lanes = dict[int, np.ndarray]()
        for b in range(here, last + 2):
            if b not in whole and (b == here or end > b * m - w):
                lanes[b] = self.alone(b)
        for k in range(0, len(whole), self.count):
            self.together(whole[k : k + self.count])
        none = np.zeros(self.n)
        return lanes[last], lanes.get(last + 1, none), self.most()

    def alone(self, b: int) -> Vector:
        """The part of lane b that is in this chunk; its vector after it."""
        m, w = self.gain.long, self.gain.early
        if b == self.begin // m:
            x = self.at.x
        else:
            x = self.at.early if self.begin > b * m - w else np.zeros(self.n)
        x = np.repeat(x, self.count)
        starts = max(self.begin, b * m - w), max(self.begin, b * m)
        ends = min(self.end, b * m), min(self.end, (b + 1) * m)
        for write in (False, True):
            rows = ends[write] - starts[write]
            if rows > 0:
                self.call(np.repeat(starts[write], self.count), rows, write, x)
        return x[:: self.count].copy()

    def together(self, group: range) -> None:
        """Lanes that begin and end in this chunk."""
        m, w = self.gain.long, self.gain.early
        b = np.array([*group, *[group[-1]] * (self.count - len(group))])
        x = np.zeros(self.n * self.count)
        self.call(b * m - w, w, False, x)
        self.call(b * m, m, True, x)

    def call(self, first: Vector, rows: int, write: bool, x: Vector) -> None:
        largest = self.largest if write else np.zeros_like(self.largest)
        first = first - self.begin
        self.kernel(
            **self.given, rows=rows, write=write, first=first, x=x, largest=largest
        )

    def most(self) -> Vector:
        return self.largest.reshape(-1, self.count).max(axis=1)
