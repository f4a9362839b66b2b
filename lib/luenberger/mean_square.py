"""Second moments of a plant whose matrices are noisy: x+ = (A + sum g_i A_i) x + w.

With white g_i of unit variance, E[x x'] obeys X+ = T(X) + V, where

    T(X) = A X A' + sum A_i X A_i'

maps covariances to covariances.  With L(X) = sum_k A^k X A^k' and Pi(X) = sum A_i X
A_i', the steady state X = T(X) + V is X = L(V + Pi(X)), and it exists exactly when A
is stable and the spectral radius of L Pi is below 1.  Nothing of size n^2 x n^2 is
formed beyond a few states.  (Haddad and Bernstein (4.3)-(4.5), Lemma 4.1.)
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, gmres

from . import linalg
from .errors import CertificateError, DesignError
from .linalg import modes, semidefinite, symmetrise

RESIDUAL_TOL = 1e-12  # of X = T(X) + V, relative to its terms
DENSE_LIMIT = 8  # states up to which a map of covariances is written as a matrix
KRYLOV = 60  # vectors that GMRES keeps
ROUNDS = 20  # solutions with GMRES, each for what the last one left over


class EquivalentNoise(NamedTuple):
    """The second moment X of the state, and the noises of the additive plant.

    A linear estimator's steady error is the same on the plant with constant A, C and
    noise covariances Q, R, S as on the one with multiplicative noise.
    """

    X: np.ndarray  # (n, n) E[x x']
    Q: np.ndarray  # (n, n) of w + sum g_i A_i x
    S: np.ndarray  # (n, p) of those two
    R: np.ndarray  # (p, p) of v + sum g_i C_i x


def second_moment(A, pairs, V):
    r"""Solve the generalised Lyapunov equation of the state's second moment,

    .. math:: X = A X A' + \sum_i A_i X A_i' + V .

    Parameters
    ----------
    A : (n, n) ndarray
    pairs : sequence of (A_i, C_i)
        As in ``plant.multiplicative``; the C_i play no part.
    V : (n, n) ndarray
        Covariance of the additive noise.

    Returns
    -------
    (n, n) ndarray
        Positive semi-definite, with a relative residual below 1e-12.

    Raises
    ------
    DesignError
        If A is not stable, or the noise too strong for a steady state.
    CertificateError
        If rounding keeps the residual above 1e-12.

    References
    ----------
    Haddad and Bernstein (1987), equation (4.4), first block.

    Examples
    --------
    >>> X = second_moment(np.array([[0.5]]), [([[0.25]], [[0]])], np.eye(1))
    >>> X.round(12)
    array([[1.45454545]])
    """
    _require_stable(A, pairs)
    noise, sums = _stack(A, pairs), _Sums(A)
    # at unit diagonal, so that the units of the states play no part
    size = np.sqrt(sums(V + _spread(noise, sums(V))).diagonal())
    size = np.where(size > 0, size, 1.0)
    unit = size / size[:, None]
    X = _solve(A * unit, noise * unit, V / size / size[:, None])
    return X * size * size[:, None]


def _solve(A, noise, V):
    """X = L(V + Pi(X)) by GMRES, and again for what each answer leaves over."""
    sums, (pack, unpack) = _Sums(A), _packing(len(A))

    def left_over(packed):
        return packed - pack(sums(_spread(noise, unpack(packed))))

    operator = LinearOperator((pack(V).size,) * 2, matvec=left_over, dtype=float)
    strength = 1 + sum(np.linalg.norm(M, 2) ** 2 for M in (A, *noise))
    X, best = np.zeros_like(V), (np.inf, None)
    for _ in range(ROUNDS):
        gap = V + A @ X @ A.T + _spread(noise, X) - X
        size = np.linalg.norm(V) + strength * np.linalg.norm(X)
        residual = np.linalg.norm(gap) / size if size > 0 else 0.0
        if not residual < 0.5 * best[0]:
            break
        best = residual, X
        more, _ = gmres(operator, pack(sums(gap)), rtol=1e-6, restart=KRYLOV)
        X = X + unpack(more)
    residual, X = best
    if not residual <= RESIDUAL_TOL:
        raise CertificateError(
            "the second moment of the state was not found to rounding: the relative "
            f"residual stays at {residual:.1e}. The plant is close to the limit of "
            "mean-square stability; reduce its multiplicative noise."
        )
    return semidefinite(X, X)


def radius(A, pairs):
    """Spectral radius of A(x)A + sum A_i(x)A_i, which decides mean-square stability.

    The map X -> A X A' + sum A_i X A_i' keeps covariances covariances, so its radius
    is its eigenvalue of largest real part.

    Examples
    --------
    >>> round(radius(np.array([[0.5]]), [([[1.2]], [[0]])]), 12)  # 0.25 + 1.44
    1.69
    """
    alone = linalg.radius(A) ** 2
    noise = _stack(A, pairs)
    if len(noise) == 0:
        return alone
    return max(alone, _dominant(lambda X: A @ X @ A.T + _spread(noise, X), len(A)))


def largest_scaling(A, pairs):
    """The s at which the plant with noises s A_i stops being mean-square stable.

    s = 1 / sqrt(radius of L Pi); inf when no noise feeds back on itself, 0 when A
    alone is not stable.

    Examples
    --------
    >>> round(largest_scaling(np.array([[0.6]]), [([[0.4]], [[1]])]), 12)
    2.0
    """
    if not linalg.radius(A) < 1:
        return 0.0
    noise, sums = _stack(A, pairs), _Sums(A)
    if len(noise) == 0:
        return np.inf
    found = _dominant(lambda X: sums(_spread(noise, X)), len(A))
    return float(1 / np.sqrt(found)) if found > 0 else np.inf


def require_mean_square_stable(plant):
    """Raise DesignError unless the plant's state has a steady second moment."""
    if plant.steps is not None:
        raise DesignError(
            "mean-square stability is of a constant plant, and this one varies in time"
        )
    _require_stable(plant.A, plant.multiplicative)


def _require_stable(A, pairs):
    poles = np.linalg.eigvals(A)
    if not (np.abs(poles) < 1).all():
        raise DesignError(
            "not mean-square stable: A itself has the mode "
            f"{modes(poles[np.abs(poles) >= 1])} on or outside the unit circle, so "
            "the state has no steady second moment"
        )
    scaling = largest_scaling(A, pairs)
    if not scaling > 1:
        raise DesignError(
            "not mean-square stable: the spectral radius of A(x)A + sum A_i(x)A_i is "
            f"{radius(A, pairs):.6g}, so the second moment of the state grows without "
            f"bound. The noise A_i would have to be {scaling:.6g} times what it is, "
            "or less."
        )


def equivalent_noise(plant):
    """The additive noises that trouble linear estimators as the plant's own do.

    In the steady state w + sum g_i A_i x and v + sum g_i C_i x are white and
    uncorrelated with the past, so an estimator sees a plant with A and C constant and
    the noise covariances returned here.

    Parameters
    ----------
    plant : Plant
        Discrete and constant, with Q and R.

    Returns
    -------
    EquivalentNoise
        X, Q, S, R; without multiplicative noise those of the plant.

    Raises
    ------
    DesignError
        If the plant is not mean-square stable; the radius and the largest stable
        scaling of the noise are named.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0.5]],
    ...                  multiplicative=[([[0.25]], [[0]]), ([[0]], [[0.5]])])
    >>> [round(float(one[0, 0]) * 11, 12) for one in equivalent_noise(plant)]
    [16.0, 12.0, 0.0, 9.5]
    """
    require_mean_square_stable(plant)
    X = second_moment(plant.A, plant.multiplicative, plant.Q)
    return EquivalentNoise(X, *noise_at(plant.at(0), plant.multiplicative, X))


def noise_at(now, pairs, X):
    """Q, S, R with what multiplicative noise adds where E[x x'] = X."""
    S = np.zeros(now.C.T.shape) if now.S is None else now.S
    Q, R = now.Q, now.R
    for A1, C1 in pairs:
        Q, S, R = Q + A1 @ X @ A1.T, S + A1 @ X @ C1.T, R + C1 @ X @ C1.T
    return symmetrise(Q), S, symmetrise(R)


class _Sums:
    """L: X -> sum_k A^k X A^k' by doubling, the squares of A made once."""

    def __init__(self, A):
        self.squares = [A]
        while np.abs(self.squares[-1]).max() > 1e-18 and len(self.squares) < 64:
            self.squares.append(self.squares[-1] @ self.squares[-1])

    def __call__(self, X):
        for power in self.squares:
            X = X + power @ X @ power.T
        return symmetrise(X)


def _stack(A, pairs):
    """The A_i that are not zero, (k, n, n)."""
    noise = [np.asarray(A1, float) for A1, _ in pairs if np.any(A1)]
    return np.array(noise).reshape(-1, *A.shape)


def _spread(noise, X):
    """Pi: X -> sum A_i X A_i'."""
    return sum((A1 @ X @ A1.T for A1 in noise), np.zeros_like(X))


def _packing(n):
    """Symmetric matrices as vectors of n (n + 1) / 2 entries of equal length; back."""
    rows, columns = np.triu_indices(n)
    weight = np.where(rows == columns, 1.0, np.sqrt(2.0))

    def pack(X):
        return X[..., rows, columns] * weight

    def unpack(packed):
        X = np.zeros((*packed.shape[:-1], n, n))
        X[..., rows, columns] = X[..., columns, rows] = packed / weight
        return X

    return pack, unpack


def _dominant(move, n):
    """Spectral radius of a linear map that keeps covariances covariances.

    It is an eigenvalue, and the real one furthest to the right.  The identity has a
    share of its eigenvector, so a map that takes it to zero in n steps has radius 0.
    """
    pack, unpack = _packing(n)
    X = np.eye(n)
    for _ in range(n):
        X = move(X)
        size = np.abs(X).max()
        if size == 0:
            return 0.0
        X = X / size
    if n <= DENSE_LIMIT:
        basis = unpack(np.eye(n * (n + 1) // 2))
        return linalg.radius(pack(move(basis)))
    operator = LinearOperator(
        (n * (n + 1) // 2,) * 2, matvec=lambda v: pack(move(unpack(v))), dtype=float
    )
    try:
        found = eigs(operator, 1, which="LR", v0=pack(X), ncv=20, tol=1e-13)[0]
    except ArpackNoConvergence:
        raise CertificateError(
            "the spectral radius that decides mean-square stability was not found: "
            "Arnoldi's iteration did not settle. Scale the states to similar sizes."
        ) from None
    return float(found[0].real)
