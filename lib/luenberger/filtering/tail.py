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
from .maps import factors
from .passes import Maps, State, Tape

if TYPE_CHECKING:
    from .pack import Packed

EPS = 1e-11  # so that estimates differ by 1e-8 of their deviations at most
ROUNDED = 1e-9  # of a covariance that was found as such, where that is its rounding
LOOK = 512  # complete rows before the first look; the next one is at twice as many
DOUBLED = 13  # how often rows are doubled, from none known on, to find what is steady
HALF = 256  # rows in which an error has to halve
HUGE = 1e50  # what is beyond it has no digits left
LOST = 8  # times that, until what rounding has left of the doubling is gone


class Steady(NamedTuple):
    """A steady filter: W with Sigma = W W', its factors V and D, and its gain."""

    W: np.ndarray
    V: np.ndarray
    D: np.ndarray
    K: np.ndarray

    def holds(self, V: Matrix, D: Vector, eps: float) -> bool:
        """Whether the covariance of V and D is inside."""
        T = solve_triangular(self.W, V.T * np.sqrt(D), check_finite=False)
        return bool(np.linalg.norm(T @ T.T - np.eye(len(T))) <= eps)


def steady(maps: Maps, run: Callable) -> Steady | None:
    """The steady filter of maps for complete rows; None where none is certified."""
    A, C, r, Q = maps.B[0], maps.C[0], maps.r[0], maps.G[0] @ maps.G[0].T
    n, p = len(A), len(C)
    if not (r > 0).all():
        return None
    X, G, S = A.T, (C.T / r) @ C, Q
    for _ in range(DOUBLED):  # S is the covariance ahead of so many rows
        if not np.linalg.norm(S) < HUGE:
            return None
        T = np.linalg.solve(np.eye(n) + G @ S, np.hstack([X, G]))
        S, G, X = S + X.T @ S @ T[:, :n], G + X @ T[:, n:] @ X.T, X @ T[:, :n]
    state = State(np.zeros(n), *factors(S), np.zeros((p, n)), np.zeros(p))
    if (one := _behind(state, maps, run, 1, start=-1)) is None:
        return None
    X, many = solve_triangular(one.W, (A - one.K @ C @ A) @ one.W), 1
    while (size := np.linalg.norm(X, 2)) > 0.5:
        X, many = X @ X, 2 * many
        if many > HALF:
            return None
    last = _behind(state, maps, run, LOST * many)
    one = _behind(state, maps, run, 1)
    total = float(many / (1 - size))  # the sum of |W^-1 Phi^k W|, each at most 1
    return one if last and one and one.holds(last.V, last.D, EPS / 2 / total) else None


def _behind(
    state: State, maps: Maps, run: Callable, rows: int, start: int = 0
) -> Steady | None:
    """What is known behind rows, with the gain of the last; None if it is singular."""
    (n, p), at = state.E.T.shape, np.zeros(rows + 1, dtype=np.int64)
    at[0] = start
    tape = Tape(
        np.zeros((0, n)), np.zeros((0, n)), np.zeros((0, n, n)), np.zeros((0, n)),
        np.zeros((rows, p, n)), np.zeros((rows, p)), np.zeros((rows, p)),
    )  # fmt: skip
    room = np.zeros((3, rows, n))
    run(np.zeros((rows, p)), room[0], at, maps, state, room[1], room[2], tape)
    V, D = state.V.copy(), state.D.copy()
    if not (np.isfinite(D).all() and (D > 0).all() and np.isfinite(V).all()):
        return None
    K, C = np.zeros((n, p)), maps.C[0]
    for j in range(p):  # one reading after the other moves the estimate
        k = tape.K[-1, j] / tape.pivot[-1, j]
        K -= np.outer(k, C[j] @ K)
        K[:, j] += k
    return Steady(V.T * np.sqrt(D), V, D, K)


class Way(NamedTuple):
    """What goes over rows.

    Attributes
    ----------
    rows : callable
        Passes over a slice of rows, and returns what `passes.forward` does.
    factors, settle : callable
        V and D of the covariance behind the last row; sets them.
    z : (n,) ndarray
        The estimate behind the last row.
    x, variances : (N, n) ndarray
        Where what is found of each row is written.
    eps : float
        By how much the covariance may differ from the steady one.
    """

    rows: Callable[[slice], int]
    factors: Callable[[], tuple[Matrix, Vector]]
    settle: Callable[[Matrix, Vector], None]
    z: np.ndarray
    x: np.ndarray
    variances: np.ndarray
    eps: float = EPS / 2  # rounding has the other half


def over(
    way: Way, pack: Packed, found: Callable[[], Steady | None], calm: int,
    gained: Callable[..., Callable],
) -> tuple[int, int, list[int]]:  # fmt: skip
    """Pass over rows behind so many complete ones; -1 where the filter is settled.

    `gained` is the text that goes over so many rows with one gain.
    Returns what `passes.forward` does, how many complete rows there are at the end,
    and the rows from which on there was one gain.
    """
    y, drive, at, maps, mix = pack
    rows, k, settled = len(y), 0, []
    n = len(way.z)
    broken = np.append(np.flatnonzero(np.isnan(y)) // y.shape[1], rows)
    while k < rows:
        ends = broken[np.searchsorted(broken, k) :]
        if calm < 0 and (one := found()):
            stop = int(ends[0])
            if stop > k:
                settled.append(k)
                part, full = slice(k, stop), at[k + 1]
                A, given = maps.B[full], drive[part]
                J = np.eye(n) - one.K @ maps.C[full]
                J, A = J[:, : n if given.any() else 0].copy(), J @ A
                K = one.K @ mix[full]
                sizes = (one.W**2).sum(axis=1)
                rest = way.z, sizes, way.x[part], way.variances[part]
                gained(y[part], J)(y[part], given, A, J, K, *rest)
            calm = -1 if stop == rows else 0
        else:
            firsts = np.append(k - calm, ends[:-1] + 1)
            goals = np.full(len(ends), LOOK)
            while goals[0] <= calm:
                goals[0] *= 2
            long = np.flatnonzero(ends - firsts >= goals)
            stop = int((firsts + goals)[long[0]]) if len(long) else rows
            clash = way.rows(slice(k, stop))
            if clash >= 0:
                return k * pack.y.shape[1] + clash, 0, settled
            calm = stop - int(firsts[long[0]] if len(long) else firsts[-1])
            if len(long) and (one := found()) and one.holds(*way.factors(), way.eps):
                way.settle(one.V, one.D)
                calm = -1
        k = stop
    return -1, calm, settled
