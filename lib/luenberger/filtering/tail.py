"""The settled tail: rows with one gain, where the covariance is all but steady.

Let Sigma be steady under the map f of a row, Sigma = f(Sigma), and positive definite.
f is monotone, and f(c S) <= c f(S) for c >= 1, because Q and R are not negative.  So

    (1 - eps) Sigma <= S <= (1 + eps) Sigma

holds in every later row once it holds in one.  Then a row has the gain of Sigma.  With
Sigma = W W' that differs from its own by at most 2 eps / (1 - eps) in these units, and
an estimate by at most 2 eps sum |W^-1 Phi^k W| of its deviations, for innovations whose
normalised length is one.  Behind a gap the recursion runs until it is inside again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..numeric import Matrix, Vector
from .passes import FEW, Maps, State, Tape, one_gain

if TYPE_CHECKING:
    from .pack import Packed

EPS = 1e-11  # so that estimates differ by 1e-8 of their deviations at most
LOOK = 512  # rows from one look to the next
LONG = 2048  # rows in which a covariance is steady, from none on
HALF = 256  # rows in which an error has to halve


class Steady(NamedTuple):
    """A steady filter: W with Sigma = W W', its factors V and D, and its gain."""

    W: np.ndarray
    V: np.ndarray
    D: np.ndarray
    K: np.ndarray

    def holds(self, V: Matrix, D: Vector, eps: float = EPS / 2) -> bool:
        """Whether the covariance of V and D is inside; rounding has the other half."""
        T = solve_triangular(self.W, V.T * np.sqrt(D), check_finite=False)
        return bool(np.linalg.norm(T @ T.T - np.eye(len(T))) <= eps)


def steady(maps: Maps, run: Callable) -> Steady | None:
    """The steady filter of maps for complete rows; None where none is certified."""
    A, C = maps.B[0], maps.C[0]
    (n, _), p = A.shape, len(C)
    if not (maps.r[0] > 0).all():
        return None
    state = State(np.zeros(n), np.eye(n), np.zeros(n), np.zeros((p, n)), np.zeros(p))
    tape = Tape(
        np.zeros((0, n)), np.zeros((0, n)), np.zeros((0, n, n)), np.zeros((0, n)),
        np.zeros((1, p, n)), np.zeros((1, p)), np.zeros((1, p)),
    )  # fmt: skip
    none = tape._replace(K=tape.K[:0], pivot=tape.pivot[:0], nu=tape.nu[:0])
    for rows, kept in (LONG, none), (1, tape):
        last = State(*(X.copy() for X in state))
        zero, at = np.zeros((rows, p)), np.zeros(rows + 1, dtype=np.int64)
        room = np.zeros((2, rows, n))
        run(zero, room[0].copy(), at, maps, state, *room, kept)
    V, D = state.V, state.D
    if not (np.isfinite(D).all() and (D > 0).all() and np.isfinite(V).all()):
        return None
    K = np.zeros((n, p))
    for j in range(p):  # one reading after the other moves the estimate
        k = tape.K[0, j] / tape.pivot[0, j]
        K -= np.outer(k, C[j] @ K)
        K[:, j] += k
    W = V.T * np.sqrt(D)
    found = Steady(W, V, D, K)
    X, many = solve_triangular(W, (A - K @ C @ A) @ W), 1
    while (size := np.linalg.norm(X, 2)) > 0.5:
        X, many = X @ X, 2 * many
        if many > HALF:
            return None
    many = many / (1 - size)  # the sum of |W^-1 Phi^k W|, none of which is above 1
    return found if found.holds(last.V, last.D, float(EPS / 2 / many)) else None


class Way(NamedTuple):
    """What goes over rows.

    Attributes
    ----------
    rows : callable
        Passes over a slice of rows, and returns what `passes.forward` does.
    factors, settle : callable
        V and D of the covariance behind the last row; sets them.
    z : (n,) ndarray
        The estimate there.
    x, variances : (N, n) ndarray
        Where what is found of each row is written.
    """

    rows: Callable[[slice], int]
    factors: Callable[[], tuple[Matrix, Vector]]
    settle: Callable[[Matrix, Vector], None]
    z: np.ndarray
    x: np.ndarray
    variances: np.ndarray


def over(
    way: Way, pack: Packed, found: Callable[[], Steady | None], instant: int,
    still: bool,
) -> tuple[int, bool, list[int]]:  # fmt: skip
    """Pass over rows behind an instant; with one gain where the filter is `still`.

    Returns what `passes.forward` does, whether the filter is still at the end, and the
    rows from which on there was one gain.
    """
    y, drive, at, maps, _ = pack
    (rows, p), k, settled = y.shape, 0, []
    gained = one_gain.exact if len(way.z) <= FEW else one_gain.fast
    gone = np.isnan(y)
    broken = np.flatnonzero(gone.any(axis=1)) if gone.any() else np.empty(0, int)
    while k < rows:
        if still and (one := found()):
            next_ = np.searchsorted(broken, k)
            stop = int(broken[next_]) if next_ < len(broken) else rows
            if stop > k:
                settled.append(k)
                part, full = slice(k, stop), at[k + 1]
                given = y[part], drive[part], maps.B[full], maps.C[full], one.K
                gained(*given, way.z, way.x[part])
                way.variances[part] = (one.W**2).sum(axis=1)
            still = stop == rows
        else:
            stop = min(rows, k + LOOK - (instant + k) % LOOK)
            clash = way.rows(slice(k, stop))
            if clash >= 0:
                return k * p + clash, False, settled
            looked = (instant + stop) % LOOK == 0 and not np.isnan(y[stop - 1]).any()
            one = found() if looked else None
            still = one is not None and one.holds(*way.factors())
            if one is not None and still:
                way.settle(one.V, one.D)
        k = stop
    return -1, still, settled
