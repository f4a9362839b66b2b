"""Many matrices of one size side by side, the last axis counting them.

Every operation does the same to all of them, entry by entry, so the bits of one do not
depend on the others: their number is a multiple of eight, or it is one, which stands
for all.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import Vector
from .factors import SAFE
from .linalg import SINGULAR_TOL

EIGHT = 8


class Columns:
    """Matrices (rows, cols, many), which add and multiply as one matrix does."""

    def __init__(self, X: np.ndarray) -> None:
        self.X = X

    @property
    def T(self) -> Columns:
        return Columns(self.X.swapaxes(0, 1))

    @property
    def diagonal(self) -> np.ndarray:
        """The diagonals (rows, many)."""
        every = np.arange(len(self.X))
        return self.X[every, every]

    def dot(self, other: Columns) -> Columns:
        return Columns(np.einsum("ijl,jkl->ikl", self.X, other.X))

    def __add__(self, other: Columns) -> Columns:
        return Columns(self.X + other.X)

    def __sub__(self, other: Columns) -> Columns:
        return Columns(self.X - other.X)

    @classmethod
    def one(cls, X: Any) -> Columns:
        """One matrix for all, (rows, cols), or a vector."""
        X = np.asarray(X, dtype=float)
        return cls(X.reshape(*X.shape, 1) if X.ndim == 2 else X.reshape(len(X), 1, 1))

    @classmethod
    def many(cls, X: Any) -> Columns:
        """From matrices (M, rows, cols), or vectors (M, rows)."""
        M = len(X)
        X = X.reshape(*X.shape[:2], *(X.shape[2:] or (1,)))
        room = np.zeros((*X.shape[1:], -(-M // EIGHT) * EIGHT))
        room[:, :, :M] = X.transpose(1, 2, 0)
        return cls(room)

    def of(self, which: Vector) -> Columns:
        """Some of them, in this order, and the first one behind them."""
        places = np.zeros(-(-len(which) // EIGHT) * EIGHT, dtype=int)
        places[: len(which)] = which
        return Columns(self.X[:, :, places])


def symmetrise(X: Columns) -> Columns:
    """(X + X') / 2."""
    return Columns(0.5 * (X.X + X.T.X))


def solve_right(N: Columns, M: Columns) -> Columns:
    """Y with Y M = N for symmetric definite M = L d L'; NaN where M is singular."""
    L, d = factored(M)
    d = np.where(d > SINGULAR_TOL * M.diagonal, d, np.nan)
    size = len(L)
    Y = np.array(np.broadcast_arrays(N.X, d[:1, None])[0])
    for j in range(1, size):
        Y[:, j] -= np.einsum("il,ikl->kl", L[j, :j], Y[:, :j].swapaxes(0, 1))
    Y /= d
    for j in reversed(range(size - 1)):
        Y[:, j] -= np.einsum("il,ikl->kl", L[j + 1 :, j], Y[:, j + 1 :].swapaxes(0, 1))
    return Columns(Y)


def factored(M: Columns) -> tuple[np.ndarray, np.ndarray]:
    """L and d (size, many) of M = L d L'; a pivot of zero divides nothing."""
    rest, size = M.X.copy(), len(M.X)
    for j in range(size - 1):
        pivot = rest[j, j].copy()
        below = rest[j + 1 :, j].copy()
        rest[j + 1 :, j] /= np.where(pivot == 0, 1.0, pivot)
        rest[j + 1 :, j + 1 :] -= rest[j + 1 :, j][:, None] * below
    return rest, Columns(rest).diagonal


def firm(X: Columns, size: np.ndarray) -> Vector:
    """Which are definite beside variances `size`, but for rows of zeros; see `factors`.

    The bounds on the pivots are those of compiled code.
    """
    _, pivots = factored(X)
    known = (size == 0) & ~X.X.any(axis=1)
    return np.asarray((known | (pivots > SAFE * (size + X.diagonal))).all(axis=0))


NAMESPACE: dict[str, Callable[..., Any]] = dict(
    symmetrise=symmetrise, solve_right=solve_right
)
