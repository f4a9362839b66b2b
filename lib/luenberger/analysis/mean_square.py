"""Second moments of a plant whose matrices are noisy: x+ = (A + sum g_i A_i) x + w.

With white g_i of unit variance, E[x x'] obeys X+ = T(X) + V, where

    T(X) = A X A' + sum A_i X A_i'

maps covariances to covariances.  With L(X) = sum_k A^k X A^k' and Pi(X) = sum A_i X
A_i', the steady state X = T(X) + V is X = L(V + Pi(X)), and it exists exactly when A
is stable and the spectral radius of L Pi is below 1.  Nothing of size n^2 x n^2 is
formed beyond a few states.  (Haddad and Bernstein (1987), (4.3)-(4.5), lemma 4.1;
papers/haddad_bernstein/derivation/mean_square.py.)
"""

from typing import NamedTuple

import numpy as np
import scipy  # its parts load when first used

from .. import kernels
from ..errors import FIT, SAMPLE, CertificateError, DesignError
from ..numeric import Matrix, Vector, linalg
from ..numeric.covariance_maps import Pairs, Sums, dominant, packing, spread, stack
from ..numeric.factors import CLEAR, EPS, semidefinite
from ..numeric.linalg import modes
from ..papers.haddad_bernstein.derivation import equivalent_noise as noise_added
from ..papers.haddad_bernstein.derivation import moment_ahead
from ..plant import Plant

RESIDUAL_TOL = 1e-12  # of X = T(X) + V, relative to X at unit diagonal
KRYLOV = 60  # vectors that GMRES keeps
ROUNDING = 1e-15  # below this nothing is left to improve
TINY = 1e-100  # a spectral radius below this is zero
ROUNDS = 20  # solutions with GMRES, each for what the last one left over


class EquivalentNoise(NamedTuple):
    """The second moment X of the state, and the noises of the equivalent plant.

    A linear estimator's steady error is the same on the plant with constant A, C and
    noise covariances Q, R, S as on the one with multiplicative noise.
    """

    X: np.ndarray  # (n, n) E[x x']
    Q: np.ndarray  # (n, n) of w + sum g_i A_i x
    S: np.ndarray  # (n, p) of those two
    R: np.ndarray  # (p, p) of v + sum g_i C_i x


def second_moment(A: Matrix, pairs: Pairs, V: Matrix) -> Matrix:
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
    noise = stack(A, pairs)
    X = _sum_up(A, noise, V)
    # at unit diagonal, so that the units of the states play no part
    real = X.diagonal() > CLEAR * EPS * _made_of(A, noise, V, X)
    driven = np.sqrt(np.where(real, X.diagonal(), 0))  # 0 where no noise comes, stays 0
    size = np.where(driven > 0, driven, 1.0)
    unit, both = size / size[:, None], np.outer(size, size)
    found = _solve(A * unit, noise * unit, V / both, X / both)
    return found * np.outer(driven, driven)


def _sum_up(A: Matrix, noise: Matrix, V: Matrix) -> Matrix:
    """n + 1 terms of X = L V + L Pi L V + ...: all there are if nothing feeds back."""
    sums = Sums(A)
    X = sums(V)
    for _ in range(len(A)):
        more, X = X, sums(V + spread(noise, X))
        if (X.diagonal() - more.diagonal() <= ROUNDING * X.diagonal()).all():
            break
    return X


def _solve(A: Matrix, noise: Matrix, V: Matrix, X: Matrix) -> Matrix:
    """X = L(V + Pi(X)) by GMRES, and again for what each answer leaves over."""
    sums, (pack, unpack) = Sums(A), packing(len(A))

    def left_over(packed: Vector) -> Vector:
        return packed - pack(sums(spread(noise, unpack(packed))))

    operator = scipy.sparse.linalg.LinearOperator(
        (pack(V).size,) * 2, matvec=left_over, dtype=float
    )
    best = np.inf, X
    for _ in range(ROUNDS):
        gap = _ahead(A, noise, X, V) - X
        size = np.linalg.norm(X)
        residual = np.linalg.norm(gap) / size if size > 0 else 0.0
        if not residual < 0.5 * best[0]:
            break
        best = residual, X
        if residual <= ROUNDING:
            break
        left = pack(sums(gap))
        more, _ = scipy.sparse.linalg.gmres(
            operator, left, rtol=1e-6, restart=KRYLOV, maxiter=9
        )
        X = X + unpack(more)
    residual, X = best
    if not residual <= RESIDUAL_TOL:
        raise CertificateError(
            "the second moment of the state was not found to rounding: the relative "
            f"residual stays at {residual:.1e}. The plant is close to the limit of "
            "mean-square stability, or its A far from normal; reduce the "
            "multiplicative noise, or scale the states to similar sizes."
        )
    return semidefinite(X, _made_of(A, noise, V, X))


def _made_of(A: Matrix, noise: Matrix, V: Matrix, X: Matrix) -> Vector:
    """The variances that those of A X A' + sum A_i X A_i' + V are differences of."""
    std = np.sqrt(np.maximum(X.diagonal(), 0))
    return sum((np.abs(one) @ std) ** 2 for one in (A, *noise)) + V.diagonal()


def _ahead(A: Matrix, noise: Matrix, X: Matrix, V: Matrix | float = 0.0) -> Matrix:
    """T(X) + V."""
    step = kernels.compiled(moment_ahead)
    return step(A=A, Q1=X, V1=V + spread(noise, X))["Q1_next"]


def radius(A: Matrix, pairs: Pairs) -> float:
    """Spectral radius of A(x)A + sum A_i(x)A_i, which decides mean-square stability.

    It is the r at which the plant A / sqrt(r), A_i / sqrt(r) is at its limit, or the
    squared radius of A where the noises do not add to that.

    Examples
    --------
    >>> round(radius(np.array([[0.5]]), [([[1.2]], [[0]])]), 12)  # 0.25 + 1.44
    1.69
    """
    alone, noise = linalg.radius(A) ** 2, stack(A, pairs)

    def short_of_limit(r: float) -> float:
        feedback = _feedback(A / np.sqrt(r), noise)
        return r / feedback - 1 if feedback > 0 else np.inf

    bound = float(np.linalg.norm(_ahead(A, noise, np.eye(len(A))), 2))
    low = high = bound * (1 + 1e-9)
    above = high - alone
    while short_of_limit(low) >= 0:
        high, above = low, above / 8
        low = alone + above
        if not above > 1e-9 * max(alone, TINY):
            return alone
    return float(
        scipy.optimize.brentq(short_of_limit, low, high, rtol=1e-14, xtol=1e-14 * low)
    )


def largest_scaling(A: Matrix, pairs: Pairs) -> float:
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
    feedback = _feedback(A, stack(A, pairs))
    return float(1 / np.sqrt(feedback)) if feedback > 0 else np.inf


def _feedback(A: Matrix, noise: Matrix) -> float:
    """Spectral radius of L Pi for a stable A: how the noise acts back on itself."""
    sums = Sums(A)
    return dominant(lambda X: sums(spread(noise, X)), len(A))


def require_mean_square_stable(plant: Plant) -> None:
    """Raise DesignError unless the plant's state has a steady second moment."""
    _require_constant(plant)
    _require_stable(plant.A, plant.multiplicative)


def _require_constant(plant: Plant) -> None:
    if plant.steps is not None:
        raise DesignError(
            "mean-square stability is of a constant plant, and this one varies in time"
        )


def _require_stable(A: Matrix, pairs: Pairs) -> None:
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
            f"bound. The noises A_i must be less than {scaling:.6g} times what they "
            "are."
        )


def equivalent_noise(plant: Plant) -> EquivalentNoise:
    """The additive noises that trouble linear estimators as the plant's own do.

    In the steady state w + sum g_i A_i x and v + sum g_i C_i x are white and
    uncorrelated with the past, so a linear estimator errs as on the plant with A and
    C constant and the noise covariances returned here.

    Parameters
    ----------
    plant : Plant
        Discrete and constant, with Q and R.

    Returns
    -------
    EquivalentNoise
        X, Q, S, R; without multiplicative noise the last three are the plant's.

    Raises
    ------
    DesignError
        If the plant is not mean-square stable; the radius and the largest stable
        scaling of the noise are named.

    References
    ----------
    Haddad and Bernstein (1987), equation (4.4);
    papers/haddad_bernstein/derivation/augmented.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0.5]],
    ...                  multiplicative=[([[0.25]], [[0]]), ([[0]], [[0.5]])])
    >>> [round(float(one[0, 0]) * 11, 12) for one in equivalent_noise(plant)]
    [16.0, 12.0, 0.0, 9.5]
    """
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        raise DesignError(
            "equivalent noises need dt > 0 and the covariances Q and R; "
            f"{FIT if plant.dt else SAMPLE}"
        )
    _require_constant(plant)
    X = second_moment(plant.A, plant.multiplicative, plant.Q)
    return EquivalentNoise(X, *noise_at(plant, 0, X))


def noise_at(plant: Plant, i: int, X: Matrix | None) -> tuple[Matrix, Matrix, Matrix]:
    """Q, S, R of the additive noises at instant i, where E[x x'] = X."""
    Q, R, S = plant.at(i).covariances()
    for A1, C1 in plant.multiplicative:
        more = kernels.compiled(noise_added)(A1=A1, C1=C1, X=X)
        Q, S, R = Q + more["dV1"], S + more["dV12"], R + more["dV2"]
    return Q, S, R
