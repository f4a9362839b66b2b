"""What the texts for numba call: the functions of `numeric.linalg`, for matrices.

They are written so that numba compiles them as well; see `jit`.
"""

import numpy as np

from ..numeric import Matrix
from ..numeric.linalg import SINGULAR_TOL

SOLVED = 1e-6  # of the terms of a residual: more is no solution


def eye(n: int) -> Matrix:
    return np.eye(n)


def symmetrise(X: Matrix) -> Matrix:
    """(X + X') / 2: rounding that is not symmetric would grow from step to step."""
    return 0.5 * (X + X.T)


def solve_right(N: Matrix, M: Matrix) -> Matrix:
    """X with X M = N for a symmetric M, by M = L d L'; of least norm if it is singular.

    Raises LinAlgError if there is none, or if M is not positive semi-definite.  Below
    the diagonal `L` is the factor; on it are the reciprocals of d.
    """
    size = len(M)
    L, X = np.empty((size, size)), np.empty(N.shape)
    for i in range(size):
        for j in range(i):  # L d, until the row is divided by d
            s = M[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = s
        pivot = M[i, i]
        for j in range(i):
            s = L[i, j] * L[j, j]
            pivot -= L[i, j] * s
            L[i, j] = s
        if not pivot > SINGULAR_TOL * M[i, i]:
            return of_least_norm(N, M)
        L[i, i] = 1.0 / pivot
    for row in range(len(N)):
        for i in range(size):
            s = N[row, i]
            for k in range(i):
                s -= L[i, k] * X[row, k]
            X[row, i] = s
        for i in range(size - 1, -1, -1):
            s = X[row, i] * L[i, i]
            for k in range(i + 1, size):
                s -= L[k, i] * X[row, k]
            X[row, i] = s
    return X


def of_least_norm(N: Matrix, M: Matrix) -> Matrix:
    X = N @ pseudo_inverse(M)
    off = np.abs(X @ M - N) > SOLVED * (np.abs(X) @ np.abs(M) + np.abs(N))
    if off.any():
        raise np.linalg.LinAlgError(
            "a matrix that a solve needs is not positive definite"
        )
    return X


def pseudo_inverse(M: Matrix) -> Matrix:
    """Moore-Penrose inverse of a covariance; the rank is decided at unit diagonal."""
    size = len(M)
    scale = np.ones(size)
    for i in range(size):
        if M[i, i] > 0:
            scale[i] = 1 / np.sqrt(M[i, i])
    values, vectors = np.linalg.eigh(M * scale * scale.reshape((size, 1)))
    for k in range(size):
        kept = values[k] > SINGULAR_TOL * max(size, 1)
        for i in range(size):
            vectors[i, k] *= scale[i] / np.sqrt(values[k]) if kept else 0.0
    return vectors @ vectors.T


FUNCTIONS = eye, symmetrise, pseudo_inverse, of_least_norm, solve_right
