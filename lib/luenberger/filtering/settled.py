"""Innovations and score of rows in which a filter has settled: vectors alone move.

Where the covariance of complete rows no longer changes, every row has the gains and
pivots of the last one.  The same is true of what the way back carries.  Both are judged
by what one row still changes: a map that does not expand Thompson's metric keeps a
covariance within N times that after N rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..numeric import Matrix, Vector
from .compiling import Text
from .passes import FEW, Maps, Tape, score

if TYPE_CHECKING:
    from .pack import Packed
    from .tail import Way

STILL = 1e-12  # of a covariance, that a row may still change
LOOK = 40  # rows, after which it is looked at; then twice as many


@Text
def same_gain(y, drive, A, C, K, share, z, nu):
    """Filter complete rows whose readings have the gains K share; nu is written."""
    ahead = np.zeros(len(z), z.dtype)
    for t in range(len(y)):
        for i in range(len(z)):
            s = drive[t, i]
            for k in range(len(z)):
                s += A[i, k] * z[k]
            ahead[i] = s
        for j in range(len(C)):
            v = y[t, j]
            for i in range(len(z)):
                v -= C[j, i] * ahead[i]
            nu[t, j] = v
            v *= share[j]
            for i in range(len(z)):
                ahead[i] += K[j, i] * v
        for i in range(len(z)):
            z[i] = ahead[i]


@Text
def same_score(A, C, K, share, nu, lam, Q, R):
    """The way back over such rows: adds lam lam' to Q and u u' to R, as `score`."""
    n, p = len(lam), len(C)
    a, told = np.zeros(n, lam.dtype), np.zeros(p, lam.dtype)
    for t in range(len(nu) - 1, -1, -1):
        for i in range(n):
            a[i] = 0
        for k in range(n):
            for i in range(n):
                a[i] += A[k, i] * lam[k]
        for j in range(p - 1, -1, -1):
            u = nu[t, j]
            for i in range(n):
                u -= K[j, i] * a[i]
            told[j] = u = u * share[j]
            for i in range(n):
                a[i] += C[j, i] * u
            for m in range(j + 1, p):
                R[j, m] += u * told[m]
                R[m, j] += u * told[m]
            R[j, j] += u * u
        for i in range(n):
            lam[i] = a[i]
            for k in range(n):
                Q[i, k] += a[i] * a[k]


def text(one: Text, n: int) -> Callable:
    return one.exact if n <= FEW else one.fast


def stretches(y: Matrix) -> list[tuple[int, int]]:
    """First row and end of all complete rows in which a filter may settle."""
    gone = np.flatnonzero(np.isnan(y).any(axis=1))
    edges = np.concatenate([[-1], gone, [len(y)]])
    long = np.flatnonzero(np.diff(edges) > 2 * LOOK + 1)
    return [(int(edges[k]) + 1, int(edges[k + 1])) for k in long]


def settled(
    rows: int, over: Callable[[slice], object], now: Callable[[], Any],
    same: Callable[[Any, Any], bool],
) -> int:  # fmt: skip
    """How many rows were passed over until one of them left what is `now` as it was."""
    k, look = 0, LOOK
    while rows - k > look + LOOK:
        over(slice(k, k + look - 1))
        before = now()
        over(slice(k + look - 1, k + look))
        k, look = k + look, 2 * look
        if same(before, now()):
            return k
    over(slice(k, rows))
    return rows


def same_covariance(one: tuple[Matrix, Vector], other: tuple[Matrix, Vector]) -> bool:
    """Whether two covariances V' D V are alike, in each other's units."""
    W, X = (V.T * np.sqrt(D) for V, D in (one, other))
    if not (W.diagonal() > 0).all():
        return False
    T = np.linalg.solve(W, X)
    return bool(np.linalg.norm(T @ T.T - np.eye(len(T))) <= STILL)


def same_entries(one: Matrix, other: Matrix) -> bool:
    """Whether two matrices that are not negative are alike, by their diagonals."""
    unit = np.sqrt(np.maximum(other.diagonal(), 0))
    return bool((np.abs(other - one) <= STILL * unit * unit[:, None]).all())


def forward(way: Way, pack: Packed, tape: Tape) -> list[slice]:
    """Pass over rows and write their tape; returns those with the gain before them.

    No estimates of these are found.
    """
    found, done, rows = list[slice](), 0, len(pack.y)
    for a, b in stretches(pack.y):
        way.rows(slice(done, a))
        over = lambda rows, a=a: way.rows(slice(a + rows.start, a + rows.stop))  # noqa: E731
        now = lambda: tuple(X.copy() for X in way.factors())  # noqa: E731
        k, done = a + settled(b - a, over, now, same_covariance), b
        rest, last = slice(k, b), k - 1
        if k < b:
            found.append(rest)
            K, pivot = tape.K[last].copy(), tape.pivot[last].copy()
            y, drive, at, maps = pack.part(rest)
            given = y, drive, maps.B[at[0]], maps.C[at[0]], K, 1 / pivot
            text(same_gain, len(K.T))(*given, way.z, tape.nu[rest])
            tape.K[rest], tape.pivot[rest] = K, pivot
    way.rows(slice(done, rows))
    return found


def back(
    at: Vector, maps: Maps, tape: Tape, lam: Vector, Lam: Matrix, Q: Matrix, R: Matrix,
) -> None:  # fmt: skip
    """What `passes.score` finds, of rows that all have the same gain; no S."""
    rows, n = len(tape.nu), len(lam)
    none = np.zeros((0, n, R.shape[1]))

    def over(behind: slice) -> None:
        some = slice(rows - behind.stop, rows - behind.start)
        here = at[some.start : some.stop + 1]
        score.fast(here, maps, part(tape, some), lam, Lam, Q, R, none)

    rest = rows - settled(rows, over, Lam.copy, same_entries)
    if not rest:
        return
    first, once = part(tape, slice(0, 1)), (np.zeros_like(Q), np.zeros_like(R))
    still = first._replace(nu=np.zeros_like(first.nu))
    score.fast(at[:2], maps, still, np.zeros(n), Lam.copy(), *once, none)
    Q += rest * once[0]  # each row has the same -Lam, and what is beside u u'
    R += rest * once[1]
    k = at[0]
    given = maps.B[k], maps.C[k], tape.K[0], 1 / tape.pivot[0], tape.nu[:rest]
    text(same_score, n)(*given, lam, Q, R[k])


def part(tape: Tape, rows: slice) -> Tape:
    """Some rows of a tape."""
    return Tape(*(X[rows] for X in tape))
