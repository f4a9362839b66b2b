"""Linear maps that take covariances to covariances, and their spectral radius.

Such a map keeps the cone of positive semi-definite matrices, so its spectral radius
is one of its eigenvalues, with a covariance as eigenvector.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import scipy  # its parts load when first used
from numpy.typing import ArrayLike

from ..errors import CertificateError
from . import Matrix
from .linalg import radius, symmetrise

Pairs = Iterable[tuple[ArrayLike, ArrayLike]]  # A_i, C_i of noises times the state
DENSE_LIMIT = 8  # states up to which such a map is written as a matrix


class Sums:
    """L: X -> sum_k A^k X A^k' by doubling, the squares of A made once."""

    def __init__(self, A: Matrix) -> None:
        self.squares = [A]
        while np.abs(self.squares[-1]).max() > 1e-18 and len(self.squares) < 64:
            self.squares.append(self.squares[-1] @ self.squares[-1])

    def __call__(self, X: Matrix) -> Matrix:
        for power in self.squares:
            X = X + power @ X @ power.T
        return symmetrise(X)


def stack(A: Matrix, pairs: Pairs) -> Matrix:
    """The A_i that are not zero, (k, n, n)."""
    noise = [np.asarray(A1, float) for A1, _ in pairs if np.any(A1)]
    return np.array(noise).reshape(-1, *A.shape)


def spread(noise: Matrix, X: Matrix) -> Matrix:
    """Pi: X -> sum A_i X A_i'."""
    return sum((A1 @ X @ A1.T for A1 in noise), np.zeros_like(X))


def packing(n: int) -> tuple[Callable[[Matrix], Matrix], Callable[[Matrix], Matrix]]:
    """Symmetric matrices as vectors of n (n + 1) / 2 entries of equal length; back."""
    rows, columns = np.triu_indices(n)
    weight = np.where(rows == columns, 1.0, np.sqrt(2.0))

    def pack(X: Matrix) -> Matrix:
        return X[..., rows, columns] * weight

    def unpack(packed: Matrix) -> Matrix:
        X = np.zeros((*packed.shape[:-1], n, n))
        X[..., rows, columns] = X[..., columns, rows] = packed / weight
        return X

    return pack, unpack


def dominant(move: Callable[[Matrix], Matrix], n: int) -> float:
    """Spectral radius of a linear map that keeps covariances covariances.

    The eigenvalue furthest to the right.  The identity has a share of its
    eigenvector, so a map that takes it to zero in n steps has radius 0.
    """
    pack, unpack = packing(n)
    X = np.eye(n)
    for _ in range(n):
        X = move(X)
        size = np.abs(X).max()
        if size == 0:
            return 0.0
        X = X / size
    if n <= DENSE_LIMIT:
        basis = unpack(np.eye(n * (n + 1) // 2))
        return radius(pack(move(basis)))
    operator = scipy.sparse.linalg.LinearOperator(
        (n * (n + 1) // 2,) * 2, matvec=lambda v: pack(move(unpack(v))), dtype=float
    )
    for kept in (20, 60):
        try:
            found = scipy.sparse.linalg.eigs(
                operator, 1, which="LR", v0=pack(X), ncv=kept, tol=1e-13
            )[0]
            return float(found[0].real)
        except scipy.sparse.linalg.ArpackNoConvergence:
            continue
    raise CertificateError(
        "mean-square stability was not decided: Arnoldi's iteration for the spectral "
        "radius does not settle. Scale the states to similar sizes."
    )
