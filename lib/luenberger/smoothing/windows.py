"""A fixed lag: every row smoothed with the rows up to the lag, all rows at once.

What a stretch of rows says is one map, and two stretches are joined to one.  Stretches
of 1, 2, 4, ... rows are made by doubling, and put together to the lag.  So a lag of a
thousand rows takes some ten times the work of a lag of one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.factors import SAFE
from .backward import clear, known, root, through_next
from .carried import LEFT, MOST, Back, Ways
from .derivation import backward_step, joined, row
from .forward import Kept

GROWN = 1e6  # times the variance of a row, within its lag


class Said(NamedTuple):
    """What stretches of rows say: a (N, n, 1), F and D (N, n, n); one from each row."""

    a: np.ndarray
    F: np.ndarray
    D: np.ndarray

    def later(self, rows: int) -> Said:
        """Those that begin so many rows later; nothing behind the last row."""
        N = len(self.a)
        kept = min(rows, N)
        nothing = self.none(kept, self.a.shape[1])
        return Said(*(np.concatenate([X[kept:], Z]) for X, Z in zip(self, nothing)))

    def then(self, other: Said) -> Said:
        """These stretches and those of `other` behind them."""
        both = dict(zip(("a_1", "F_1", "D_1"), self))
        both |= dict(zip(("a_2", "F_2", "D_2"), other))
        found = kernels.run(joined, both, stacks=True)
        return Said(found["a"], found["F"], found["D"])

    @classmethod
    def none(cls, rows: int, n: int) -> Said:
        """No row at all: nothing is said."""
        unit = np.broadcast_to(np.eye(n), (rows, n, n))
        return cls(np.zeros((rows, n, 1)), unit, np.zeros((rows, n, n)))

    def windows(self, length: int) -> Said:
        """From single rows to stretches of `length` rows, or as many as there are."""
        stretch, reach, found = self, 1, None
        length = min(length, len(self.a))
        done = 0
        while length:
            if length & 1:
                behind = stretch.later(done)
                found = behind if found is None else found.then(behind)
                done += reach
            length >>= 1
            if length:
                stretch, reach = stretch.then(stretch.later(reach)), 2 * reach
        return self.none(len(self.a), self.a.shape[1]) if found is None else found


def lagged(kept: Kept, ways: Ways, lag: int, rows: int) -> Back:
    """The first rows of a pass smoothed, each with `lag` rows behind it.

    Row k + 1 of lamda is what they say of the next prediction.  The first of U is for
    the caller to fill.
    """
    have = dict(
        As=ways.As, C=ways.C, K=kept.K[:-1], W=kept.W[:-1],
        innovation=kept.innovation[..., None],
    )  # fmt: skip
    found = kernels.run(row, have, stacks=True)
    single = Said(
        found["a"], *(np.broadcast_to(found[k], kept.Sigma.shape) for k in "FD")
    )
    said = single.windows(lag).later(1)
    have |= dict(
        Sigma=kept.Sigma, x=kept.x[..., None], lamda_next=said.a, Lambda_next=said.D
    )
    wanted = ("x_s", "Sigma_s", "Ahead", "Theta")
    found = kernels.run(backward_step, have, *wanted, stacks=True)
    have["Ahead_next"] = np.concatenate([found["Ahead"][1:], found["Ahead"][-1:]])
    U = kernels.run(backward_step, have, "U_next", stacks=True)["U_next"]
    n = kept.x.shape[1]
    U = np.concatenate([np.zeros((1, n, n)), U])[:rows]
    out = Back(
        found["x_s"][:rows, :, 0],
        found["Sigma_s"][:rows],
        U,
        np.concatenate([np.zeros((1, n)), said.a[:rows, :, 0]]),
    )
    again, grown = [], _grown(kept.variances, lag)[:rows]
    for k in _doubtful(out.Sigma, found["Theta"], kept, grown):
        mine = {name: found[name][k] for name in ("Sigma_s", "Theta")}
        Sigma_s = None if grown[k] else clear(kept.spread(k), mine)
        if Sigma_s is None:
            _one(kept, ways, k, min(k + lag, len(kept) - 1), out)
            again.append(k)
        else:
            out.Sigma[k] = Sigma_s
    pairs = {*again, *(k + 1 for k in again)} & set(range(1, rows))
    for k in sorted(pairs):
        carried = known(out.x[k], root(out.Sigma[k]))
        U[k] = through_next(kept, ways.move(k - 1), k - 1, carried)[1]["U_next"]
    return out


def _grown(variances: Matrix, lag: int) -> Vector:
    """Rows behind which, within the lag, a variance is a large multiple of theirs.

    What a stretch says is then a difference of products that large.
    """
    if lag == 0 or len(variances) == 0:
        return np.zeros(len(variances), dtype=bool)
    lag = min(lag, len(variances))
    padded = np.pad(variances, ((0, lag), (0, 0)), "edge")
    behind = np.lib.stride_tricks.sliding_window_view(padded, lag + 1, axis=0)
    much = (behind.max(axis=2) > GROWN * variances) & (variances > 0)
    return much.any(axis=1)


def _doubtful(Sigma_s: Matrix, Theta: Matrix, kept: Kept, grown: Vector) -> list[int]:
    """Rows whose covariance is singular, or has lost too many digits."""
    size = kept.variances[: len(Sigma_s)]
    unit = np.sqrt(np.where(size > 0, size, 1.0))
    least = np.linalg.eigvalsh(Sigma_s / unit[:, :, None] / unit[:, None])[:, 0]
    few = Sigma_s.diagonal(axis1=1, axis2=2) <= LEFT * size
    few |= Theta[: len(Sigma_s)].diagonal(axis1=1, axis2=2) * size > MOST
    bad = set(np.flatnonzero(few.any(axis=1) | (least <= SAFE) | grown).tolist())
    return sorted(bad | {k for k in kept.spreads if k < len(Sigma_s)})


def _one(kept: Kept, ways: Ways, k: int, end: int, out: Back) -> None:
    """Row k through the next states, from the filter's estimate at row `end`."""
    carried = known(kept.x[end], kept.spread(end).factored()[0])
    for j in range(end - 1, k - 1, -1):
        carried, _, out.lamda[k + 1] = through_next(kept, ways.move(j), j, carried)
    assert carried.half is not None
    out.x[k], out.Sigma[k] = carried.x[:, 0], carried.half @ carried.half.T
