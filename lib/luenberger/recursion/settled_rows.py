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
from ..kernels import lanes
from ..numeric import Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.factors import EPS
from ..numeric.rounded import Rounded, joined
from ..papers.leondes_novak.derivation import settled_gain, settled_row
from .held import Ball, Behind, Held
from .measure import Measure
from .root_step import Spread
from .settings import Setting
from .state import State

ROW = lanes.Lanes(settled_row, ("x_next", "x"), "r", "epsilon")
LONG = 16  # times as long as it begins early, a lane is; half where the state is long
FADED = EPS / 16  # of a start, that is nothing
COUNT = 16  # lanes at once; half as many where the state is long
LARGE, LARGER = 8, 16  # states from which it is, for lanes at once and their length


class Stretch(NamedTuple):
    """Rows with one gain so far: `rows` of them.

    ``held`` holds the covariances that the full recursion has, ``own`` those that it
    would have, carried on from here.  ``before`` tells how far the row before is from
    the full recursion.  ``x`` is the lane that is written, ``early`` the next one, if
    it has begun, and ``largest`` has the largest entries met so far; see
    `kernels.lanes.source`.
    ``last`` are y and u of the last row.
    """

    gain: OneGain
    held: Held
    own: Held
    before: Behind
    rows: int
    x: np.ndarray
    early: np.ndarray
    largest: np.ndarray
    last: tuple[np.ndarray, np.ndarray]

    @property
    def bound(self) -> float:
        """How far covariances and estimates can be from those of the full recursion."""
        s, rounding, lost = self.gain.sizes(self.largest)
        held, variances = self.held, self.held.variances.max(initial=0.0)
        apart = held.apart(s, held.drift(s, rounding, lost), rounding)
        first = held.reach * self.begins, self.before.drift * (1 + self.before.g)
        apart = apart.max(initial=0.0) + min(first[0], first[1] * (1 + variances))
        return float(max(variances, apart))

    @property
    def behind(self) -> Behind:
        """How far what follows the last row can be from the full recursion.

        What was there before stays, as it does in the full recursion; or little is left
        of it.
        """
        s, rounding, lost = self.gain.sizes(self.largest)
        held, (g, drift) = self.held, self.before
        ratio = min(held.ratio(self.rows), g + self.own.ratio(self.rows) * (1 + g))
        driven = held.driven(s, held.drift(s, rounding, lost), rounding)
        left = held.handed_on(self.begins, self.rows), drift * (1 + g) * (1 + ratio)
        return Behind(ratio, float(driven + min(left)))

    @property
    def begins(self) -> float:
        """How far the first prediction is from the full recursion, in units of H."""
        return self.before.drift * float(np.sqrt(1 + self.own.t))


class OneGain:
    """The filter of a `Ball`, for rows with the same outputs.

    A row reads its y and u, the u before, and with S the y before.
    """

    def __init__(self, now: Setting, ball: Ball, seen: Vector, cross: bool) -> None:
        self.now, self.ball, self.seen, self.cross = now, ball, seen, cross
        given = dict(B=now.B, C=now.C, E=now.E, J=now.J, As=now.As, K=ball.K)
        exact = {name: Rounded.of(X) for name, X in given.items()}
        made = kernels.bounded(settled_gain)(**exact)
        weigh = Measure(np.linalg.cholesky(ball.M))
        back, one = Rounded.of(weigh.inverse), np.eye(len(now.C))
        read = [exact["K"], made["G_e"], made["G_u"]]
        shown = [Rounded.of(one), -exact["E"], -made["N_u"]]
        if cross:
            read.append(made["G_y"])
            shown.append(-made["N_y"])
        parts = made["Phi"], joined(*read), -back.dot(made["N_x"])
        self.parts = *parts, back.dot(joined(*shown))
        self.Phi, self.G_r, self.W_x, self.W_r = (
            np.ascontiguousarray(X.value) for X in self.parts
        )
        self.slack = weigh.slack * ball.sure
        inner, ahead = ball.H.root, made["Phi"].value / ball.unit[:, None] * ball.unit
        sums = Sums(ball.H.inverse @ ahead @ inner)
        self.early = sums.fades(np.ones(len(inner)), FADED)
        self.long = (LONG if len(inner) < LARGER else LONG // 2) * self.early

    def begin(self, state: State, held: Held, own: Held, before: Behind) -> Stretch:
        """The stretch that begins after `state`."""
        n, k = self.G_r.shape
        y = np.full(len(self.seen), np.nan)
        y[self.seen] = (
            state.rho[:, 0] + (self.now.E @ state.u) + self.now.C @ state.x[:, 0]
        )
        return Stretch(
            self, held, own, before, 0, state.x[:, 0], np.zeros(n), np.zeros(n + k + 1),
            (y, state.u),
        )  # fmt: skip

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
            x, early, largest = in_lanes(self, at, r, xs)
        else:
            x, largest = self.one_by_one(at, r, xs)
            early = at.early
        largest = np.maximum(at.largest, largest)
        rows, last = at.rows + len(r), (y[-1], u[-1])
        return at._replace(rows=rows, x=x, early=early, largest=largest, last=last)

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

    def sizes(self, largest: Vector) -> tuple[float, Vector, float]:
        """What `Held.drift` asks for, of rows whose largest numbers are these."""
        x, r, s = np.split(largest, [len(self.Phi), len(largest) - 1])
        Phi, G_r, W_x, W_r = (_lost(X, len(largest)) for X in self.parts)
        most = self.slack * (np.sqrt(s[0]) + np.linalg.norm(W_x @ x + W_r @ r))
        lost = FADED * len(x) * self.ball.length(np.abs(self.now.As) @ x)
        return float(most), Phi @ x + G_r @ r, lost


def _lost(X: Rounded, terms: int) -> Matrix:
    """What a sum of so many products with X lacks, for each of the sizes in it."""
    return X.off + (terms + 2) * EPS * np.abs(X.value)


def in_lanes(
    gain: OneGain, at: Stretch, r: Matrix, xs: Matrix
) -> tuple[Vector, Vector, Vector]:
    """The rows of a chunk in lanes.

    Returned are the lane that is written last, the one that begins early behind it, and
    the largest entries.
    """
    m, w, first, end = gain.long, gain.early, at.rows, at.rows + len(r)
    here, last = first // m, end // m
    b = np.arange(here, last + 1 + (end > (last + 1) * m - w))
    x, count = np.zeros((len(b), len(at.x))), COUNT if len(at.x) < LARGE else COUNT // 2
    x[0] = at.x
    if len(b) > 1 and first > (here + 1) * m - w:
        x[1] = at.early
    rows = np.maximum(b * m - w, first), np.clip(b * m, first, end), (b + 1) * m
    begins, shows, ends = rows[0] - first, rows[1] - first, np.minimum(rows[2], end)
    whole = np.minimum(np.arange(-(-len(b) // count) * count), len(b) - 1)  # one again
    made, largest = x[whole], np.zeros(len(at.largest))
    sizes = ("n", len(at.x)), ("k", r.shape[1]), ("j", len(gain.W_x))
    lanes.in_lanes(ROW, sizes, count)(
        begins=begins[whole], shows=shows[whole], ends=(ends - first)[whole],
        Phi=gain.Phi, G_r=gain.G_r, W_x=gain.W_x, W_r=gain.W_r,
        x=made, r=r, written=xs, largest=largest,
    )  # fmt: skip
    early = made[len(b) - 1] if b[-1] > last else np.zeros(len(at.x))
    return made[last - here], early, largest
