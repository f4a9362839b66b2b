"""An observer's pass over the rows of records."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..filtering.compiling import Text
from ..numeric import Matrix, Vector
from ..observer import Observer


@Text
def steps(S: Matrix, y: Matrix, u: Matrix, z: Matrix, found: Matrix) -> None:
    """[z+, w^] = S' [z, y, u] of each row of records; z (M, r) becomes what is last.

    S is one matrix (1, r + p + m, r + q), or one for each row; u may be one record for
    all.
    """
    (M, rows, p), r, m = y.shape, z.shape[1], u.shape[2]
    last, wide = len(S) - 1, S.shape[2]
    now, out = np.zeros(r + p + m), np.zeros(wide)
    for s in range(M):
        acts = u[s if len(u) > 1 else 0]
        for i in range(r):
            now[i] = z[s, i]
        for k in range(rows):
            for i in range(p):
                now[r + i] = y[s, k, i]
            for i in range(m):
                now[r + p + i] = acts[k, i]
            T = S[min(k, last)]
            out[:] = 0
            for j in range(r + p + m):
                row, a = T[j], now[j]
                for i in range(wide):
                    out[i] += row[i] * a
            for i in range(r):
                now[i] = out[i]
            for i in range(r, wide):
                found[s, k, i - r] = out[i]
        for i in range(r):
            z[s, i] = now[i]


@Text
def along(F: Matrix, drive: Matrix, z: Matrix) -> None:
    """z[k + 1] = F[k] z[k] + drive[k] of runs side by side: z (N + 1, r, runs).

    F is one matrix (1, r, r), or one for each row; z[0] is given.
    """
    rows, r, runs = drive.shape
    last = len(F) - 1
    for k in range(rows):
        A = F[min(k, last)]
        for i in range(r):
            out, acts = z[k + 1, i], drive[k, i]
            for s in range(runs):
                out[s] = acts[s]
            for j in range(r):
                a, now = A[i, j], z[k, j]
                for s in range(runs):
                    out[s] += a * now[s]


def over_rows(
    observer: Observer, z: Vector, y: Matrix, u: Matrix, here: slice
) -> tuple[Vector, Matrix]:
    """The states after the rows `here`, and their estimates.

    y is (N, p) and u (N, m); or y is (M, N, p), of many records, and u (M, N, m) or
    (1, N, m).
    """
    if y.ndim == 2:
        z, found = over_rows(observer, z, y[None], u[None], here)
        return z[0], found[0]
    F, G, D, P, V, W = _rows(observer, here)
    both = (np.concatenate(X, axis=-2) for X in ((F, P), (D, V), (G, W)))
    S = np.concatenate([*both], axis=-1).mT
    S = np.ascontiguousarray(S if S.ndim == 3 else S[None])
    after = np.tile(z, (len(y), 1)).astype(float)
    found = np.empty((*y.shape[:2], P.shape[-2]))
    y, u = (np.ascontiguousarray(X) for X in (y, u))
    steps(S, y, u, after, found)
    return after, found


def plain(
    observer: Observer,
    y: Matrix,
    u: Matrix,
    kept: Callable[[Vector], Vector] = np.positive,
) -> Matrix:
    """Estimates of a constant observer from z0 on; of each state it keeps kept(z)."""
    F, G, D, P, V, W = _rows(observer, slice(0, len(y)))
    z, drive, states = kept(observer.z0), u @ G.T + y @ D.T, []
    for now in drive:
        states.append(z)
        z = kept(F @ z + now)
    return np.array(states).reshape(drive.shape) @ P.T + y @ V.T + u @ W.T


def _rows(observer: Observer, here: slice) -> list[Matrix]:
    """F, G, D, P, V, W, at the rows `here` if they change."""
    every = (np.ascontiguousarray(getattr(observer, name), float) for name in "FGDPVW")
    return [X if X.ndim == 2 else X[here] for X in every]
