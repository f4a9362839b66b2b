"""Noise covariances from autocovariances of innovations, by least squares.

A constant gain, first that for noises of size one and then that of the last estimate,
leaves innovations whose autocovariances are linear in Q and R.  Near the best gain they
are nearly white, so that their sample autocovariances err independently and equally in
units of their own covariance, which is the weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy  # its parts load when first used

from .. import kernels
from ..errors import CertificateError, DesignError
from ..numeric import Matrix, Vector
from ..numeric.covariance_maps import Sums, packing
from ..numeric.linalg import UNIT_TOL, radius
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.steady_gain import steady_gain
from .derivation import autocovariance_step, error_noise, first_autocovariances
from .forms import Shape
from .unknowns import require_room

ROUNDS = 4  # gains: that of noises of size one, and then of the estimates
LAGS = 60  # at most
FADED = 0.05  # lags go on until the errors of the gain have died out to this
PART = 8  # lags take at most this part of a record
DRIVEN = 1e-4  # process noise, beside its size, that every gain is made for

Records = Sequence[tuple[Matrix, Matrix]]  # (y, u) of complete rows


class Moments(NamedTuple):
    """Sample autocovariances h, and the map H of (Q, R) to what they are to be.

    Both in units of the innovation's deviation; each entry of h errs by one over the
    square root of `rows`, independently.  What a known S explains is taken off.
    """

    h: np.ndarray
    H: np.ndarray
    rows: int


class Fitted(NamedTuple):
    """The vector of both forms, and the covariance of its error."""

    theta: np.ndarray
    covariance: np.ndarray


def noise_of_size_one(plant: Plant, records: Records) -> tuple[Vector, Matrix]:
    """Deviations (p,) of the innovations of a filter for noises of size one, its gain.

    The plant is in even units.
    """
    gain = gain_for(plant, np.eye(plant.n), np.eye(plant.p))
    found = np.concatenate([left(plant, gain, y, u) for y, u in records])
    return np.sqrt((found**2).mean(axis=0)), gain


def gain_for(plant: Plant, Q: Matrix, R: Matrix, S: Matrix | None = None) -> Matrix:
    """The predictor's steady gain for these noises."""
    A, C = plant.A, plant.C
    cross = np.zeros((plant.n, plant.p)) if S is None else S
    try:
        X = scipy.linalg.solve_discrete_are(A.T, C.T, Q, R, s=cross)
        gain: Matrix = np.linalg.solve(C @ X @ C.T + R, (A @ X @ C.T + cross).T).T
        if radius(A - gain @ C) < 1 - UNIT_TOL:
            return gain
    except (np.linalg.LinAlgError, ValueError):
        pass
    require_room(Q, R, S)
    noisy = Plant(A, None, C, dt=1.0, Q=Q, R=R, S=S)
    setting = Settings(noisy, 0).at(0)
    return setting.predictor(steady_gain(setting, ()))


def carried(A: Matrix, rows: Matrix) -> Matrix:
    """Rows z[0] = rows[0], z[k] = A z[k - 1] + rows[k]; each takes up twice as many."""
    step = 1
    while step < len(rows) and np.abs(A).max(initial=0) > FADED**10:
        rows = np.concatenate([rows[:step], rows[step:] + rows[:-step] @ A.T])
        A, step = A @ A, 2 * step
    return rows


def left(plant: Plant, gain: Matrix, y: Matrix, u: Matrix) -> Matrix:
    """Innovations (N, p) of a constant gain, less what the unknown start explains."""
    A_L = plant.A - gain @ plant.C
    shown = y - u @ plant.E.T
    drive = shown @ gain.T + u @ plant.B.T
    x = carried(A_L, np.concatenate([np.zeros((1, plant.n)), drive[:-1]]))
    nu = shown - x @ plant.C.T
    seen: list[Matrix] = []
    rows = plant.C
    while len(seen) < len(y) and np.abs(rows).max(initial=0) > 1e-9:
        seen.append(rows)
        rows = rows @ A_L
    stack = np.concatenate(seen)
    x0 = np.linalg.lstsq(stack, nu[: len(seen)].ravel(), rcond=None)[0]
    nu[: len(seen)] -= (stack @ x0).reshape(-1, plant.p)
    return nu


def moments(
    plant: Plant, gain: Matrix, records: Records, cross: Matrix | None = None
) -> Moments:
    """What a gain leaves of records, and how Q and R enter that; `cross` is S."""
    n, p = plant.n, plant.p
    series = [left(plant, gain, y, u) for y, u in records]
    rows = sum(map(len, series))
    A_L = plant.A - gain @ plant.C
    lags = _lags(radius(A_L), n, min(map(len, series)))
    sample = np.array(
        [sum(nu[k:].T @ nu[: len(nu) - k] for nu in series) / rows for k in range(lags)]
    )
    white = np.linalg.inv(np.linalg.cholesky(sample[0]))
    (_, unpack), (pack, unpack_y) = packing(n), packing(p)
    wide, high = n * (n + 1) // 2, p * (p + 1) // 2
    Q = np.concatenate([unpack(np.eye(wide)), np.zeros((high + 1, n, n))])
    R = np.concatenate(
        [np.zeros((wide, p, p)), unpack_y(np.eye(high)), np.zeros((1, p, p))]
    )
    S = np.zeros((wide + high + 1, n, p))
    if cross is not None:
        S[-1] = cross
    model = _autocovariances(plant, gain, Q, R, S, lags)

    def packed(X: Matrix) -> Matrix:
        X = white @ X @ white.T
        first = pack(X[..., 0, :, :]) / np.sqrt(2)
        return np.concatenate(
            [first, X[..., 1:, :, :].reshape(*first.shape[:-1], -1)], -1
        )

    H = packed(model)
    return Moments(packed(sample) - H[-1], H[:-1].T, rows)


def _lags(size: float, n: int, rows: int) -> int:
    wanted = (
        LAGS if size >= 1 else int(np.ceil(np.log(FADED) / np.log(max(size, 1e-9))))
    )
    return max(min(max(wanted, n + 2), LAGS, rows // PART), 2)


def _autocovariances(
    plant: Plant, gain: Matrix, Q: Matrix, R: Matrix, S: Matrix, lags: int
) -> Matrix:
    """(k, lags, p, p): what noises Q, R, S, stacks of k, make of the innovations."""
    A_L = plant.A - gain @ plant.C
    W = kernels.compiled(error_noise, stacks=True)(Q=Q, R=R, S=S, L=gain)["W"]
    first = kernels.compiled(first_autocovariances, stacks=True)(
        A_L=A_L, C=plant.C, L=gain, R=R, S=S, P=Sums(A_L)(W)
    )
    step = kernels.compiled(autocovariance_step, stacks=True)
    found, N = [first["Lambda_0"]], first["N_1"]
    for _ in range(lags - 1):
        now = step(A_L=A_L, C=plant.C, N_k=N)
        found.append(now["Lambda_k"])
        N = now["N_next"]
    return np.stack(found, axis=1)


def least_squares(data: Moments, Q: Shape, R: Shape, theta: Vector) -> Fitted:
    """The semidefinite Q and R nearest to the autocovariances, from a start theta."""
    (pack, _), (pack_y, _) = packing(len(Q.known)), packing(len(R.known))

    def entries(X: Matrix, Y: Matrix) -> Matrix:
        return np.concatenate([pack(X), pack_y(Y)], axis=-1)

    def error(theta: Vector) -> Vector:
        parts = theta[: Q.count], theta[Q.count :]
        return data.H @ entries(Q.matrix(parts[0]), R.matrix(parts[1])) - data.h

    def slope(theta: Vector) -> Matrix:
        dQ, dR = Q.slopes(theta[: Q.count]), R.slopes(theta[Q.count :])
        none = np.zeros((len(dR), *Q.known.shape)), np.zeros((len(dQ), *R.known.shape))
        wide = entries(np.concatenate([dQ, none[0]]), np.concatenate([none[1], dR]))
        return data.H @ wide.T

    found = scipy.optimize.least_squares(  # a step: SciPy's first is as long as x0
        lambda step: error(theta + step), np.zeros(len(theta)),
        jac=lambda step: slope(theta + step),
        xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=200,
    )  # fmt: skip
    spread = np.linalg.pinv(found.jac.T @ found.jac, hermitian=True) / data.rows
    return Fitted(theta + found.x, spread)


def by_autocovariances(
    plant: Plant, Q: Shape, R: Shape, S: Matrix | None, theta: Vector, gain: Matrix,
    records: Records, rounds: int = ROUNDS,
) -> Fitted:  # fmt: skip
    """Fit Q and R to records of a constant plant in even units, round by round.

    Parameters
    ----------
    plant : Plant
    Q, R : Form
        In the same units.
    S : (n, p) ndarray or None
    theta : (k,) ndarray
        Where the first search begins.
    gain : (n, p) ndarray
        The first gain.
    records : sequence of (y, u)
    rounds : int
        How many gains; two are enough for a start.
    """
    for k in range(rounds):
        found = least_squares(moments(plant, gain, records, S), Q, R, theta)
        theta = found.theta
        if k == rounds - 1:
            break
        unit = Q.matrix(theta[: Q.count]), R.matrix(theta[Q.count :])
        size = max(unit[1].diagonal().max(), unit[0].diagonal().max())
        try:
            driven = unit[0] + DRIVEN * size * np.eye(plant.n)
            gain = gain_for(plant, driven, unit[1], S)
        except (DesignError, CertificateError):
            break  # what the last gain has found stands
    return found
