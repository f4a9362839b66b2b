"""Covariances as factors, X = H H', and what of them is rounding.

What rounding does to H is eps beside what H was made of, so eps^2 in X: a factor
tells variances apart that differ by 30 digits.  Rounding is judged against the
numbers that were computed with, never against the difference they left.
"""

import numpy as np
from scipy.linalg.lapack import dgeqrf, dpotrf, dpstrf

from . import Matrix, Vector

EPS = np.finfo(float).eps
CLEAR = 30.0  # roundings; a standard deviation above them is real
ENTRY = 8 * EPS  # a covariance below it, at unit diagonal, is rounding
SPOILED = 1e-12  # of a variance: an error that no random number may have
SAFE = 1e-10  # a pivot above this, beside the variance before, leaves six digits


def factor(X: Matrix, size: Vector | None = None) -> Matrix:
    """H with H H' = X and a column for each direction that is not rounding.

    Cholesky with pivots, at unit diagonal of `size`: the variances that X was made
    of, default its own.  An entry that is rounding of X is zero: a row that repeats
    another one does so exactly.
    """
    size = X.diagonal() if size is None else size
    scale = np.sqrt(np.where(size > 0, size, 1.0))
    lower, order, rank, _ = dpstrf(
        X / scale / scale[:, None], lower=1, tol=10 * EPS * len(X)
    )
    H = np.empty((len(X), rank))
    lower = np.tril(lower)[:, :rank]
    lower[np.abs(lower) * lower.diagonal() < ENTRY] = 0
    H[order - 1] = lower
    return scale[:, None] * H


def square_root(X: Matrix) -> Matrix:
    """H with H H' = X and as many columns as rows, for a fixed count of random numbers.

    From the eigenvalues of X: at unit diagonal where units would spoil them, and
    without the directions that `factor` leaves out, of which rounding would leave its
    square root in H.
    """
    scale = np.sqrt(np.where(X.diagonal() > 0, X.diagonal(), 1.0))[:, None]
    half, kept = _eigenroot(X), factor(X) / scale
    if np.abs((half @ half.T - X) / scale / scale.T).max(initial=0) > SPOILED:
        half = scale * _eigenroot(X / scale / scale.T)
    if kept.shape[1] == len(X):
        return half
    span = np.linalg.qr(kept)[0] * (X.diagonal() > 0)[:, None]  # zeros stay zeros
    return scale * (span @ (span.T @ (half / scale)))


def _eigenroot(X: Matrix) -> Matrix:
    values, vectors = np.linalg.eigh(X)
    return vectors * np.sqrt(np.clip(values, 0, None))


def shorten(H: Matrix) -> Matrix:
    """A factor of the same covariance with no more columns than rows."""
    n, columns = H.shape
    if columns <= n:
        return H
    return np.tril(dgeqrf(H.T)[0][:n].T)


def lengths(H: Matrix) -> Vector:
    """The standard deviations of the covariance H H'."""
    return np.sqrt(np.add.reduce(H * H, axis=1))


def rounded(X: Matrix, size: Vector) -> Matrix:
    """X, a covariance of rounding, and that of the next sums, of numbers of `size`."""
    X.flat[:: len(X) + 1] += (EPS * size) ** 2
    return X


def clear(H: Matrix, size: Vector) -> Matrix:
    """H without the directions that are rounding of numbers of `size`, by rows."""
    unit = EPS * np.where(size > 0, size, 1.0)
    left, values, _ = np.linalg.svd(H / unit[:, None], full_matrices=False)
    keep = values > CLEAR
    return unit[:, None] * (left[:, keep] * values[keep])


def safe(X: Matrix, size: Vector) -> bool:
    """Whether X is definite by more than the rounding of variances of `size`."""
    upper, info = dpotrf(X)
    if info != 0:
        return False
    pivots = upper.diagonal()
    return min((pivots * pivots - SAFE * (size + X.diagonal())).tolist(), default=1) > 0


def firm(X: Matrix, size: Vector) -> bool:
    """Whether X is safe but for what is known exactly: rows of zeros made of zeros."""
    known = (size == 0) & ~X.any(axis=1)
    if not known.any():
        return safe(X, size)
    return safe(X[np.ix_(~known, ~known)], size[~known])


def semidefinite(X: Matrix, size: Vector) -> Matrix:
    """X, raised where rounding of variances of `size` has left it indefinite."""
    if len(X) == 0 or dpotrf(X)[1] == 0:
        return X
    H = factor(X, size)
    return H @ H.T
