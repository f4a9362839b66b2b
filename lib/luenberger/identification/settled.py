"""The filter that a plant without change settles to, and a start beside it.

Of a plant that does not change and a record without gaps only the start is not settled.
With the settled gain a row is one small linear map, and what the start adds is put
right once; see derivation/settled.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy  # its parts load when first used

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.linalg import UNIT_TOL, radius, symmetrise
from ..plant import Plant
from ..plant.instant import Instant
from .derivation import (
    error_noise,
    settled_row,
    settled_start,
)

STEPS = 30  # of Newton's method, from gain to gain
CLOSE = 1e-12  # of a covariance, that the last step may move it by
ROUNDING = 1e-15  # of a covariance, below which a step is rounding
FIRM = 1e-7  # the least eigenvalue, at unit diagonal, of what is to be inverted
FADED = 1e-16  # of a start, that is nothing
FELT = 1e-9  # of a start, that may be left at the end: its square is left out


class Settled(NamedTuple):
    """What all rows share; the letters are those of derivation/settled.py.

    ``fades`` is the number of rows after which nothing is left of a start, ``least``
    how long a record must be, and ``log_det`` the logarithm of the determinant of M.
    """

    Omega: np.ndarray
    W: np.ndarray
    G: np.ndarray
    F: np.ndarray
    V: np.ndarray
    Pi: np.ndarray
    forward: Sums
    back: Sums
    fades: int
    least: int
    log_det: float


class Start(NamedTuple):
    """The mean of the first prediction, the weight of the start, and a constant.

    Where ``told`` is the gradient in the mean, the best value of the start is
    ``weight told`` away from it, and ``held told`` is the gradient there.  ``free`` is
    how many readings an unknown start takes, and ``constant`` what the start adds to
    log det and exponent.
    """

    mean: np.ndarray
    weight: np.ndarray
    held: np.ndarray
    constant: float
    free: int


def settle(now: Instant, gain: Matrix | None = None) -> Settled | None:
    """What the filter settles to, by Newton's method from a stable gain.

    None where it does not settle on a stable filter whose innovations have a clearly
    definite covariance.
    """
    Q, R, S = now.covariances()
    if gain is None:
        gain = _riccati(now, Q, R, S)
    if gain is None:
        return None
    error, row = kernels.compiled(error_noise), kernels.compiled(settled_row)
    if not _stable(now.A - gain @ now.C):
        return None
    before, moved = None, np.inf
    for _ in range(STEPS):  # from a stable gain every next one is stable
        F = now.A - gain @ now.C
        Omega = Sums(F)(error(Q=Q, R=R, S=S, L=gain)["W"])
        found = row(A=now.A, C=now.C, R=R, S=S, Omega=Omega)
        gain, last = found["G"], moved
        if not np.isfinite(gain).all():
            return None
        if before is not None:
            unit = np.sqrt(np.where(Omega.diagonal() > 0, Omega.diagonal(), 1.0))
            moved = float((np.abs(Omega - before) / unit / unit[:, None]).max())
            if moved <= ROUNDING or (moved <= CLOSE and moved >= last / 2):
                good = _stable(found["F"]) and firm(found["M"])
                return _shared(found, Omega, now) if good else None
        before = Omega
    return None


def _stable(F: Matrix) -> bool:
    return bool(np.isfinite(F).all()) and radius(F) < 1 - UNIT_TOL


def _riccati(now: Instant, Q: Matrix, R: Matrix, S: Matrix) -> Matrix | None:
    """The gain of the settled predictor, as SciPy finds it."""
    try:
        with np.errstate(all="ignore"):  # its balancing may overflow
            Omega = scipy.linalg.solve_discrete_are(now.A.T, now.C.T, Q, R, s=S)
    except (np.linalg.LinAlgError, ValueError):
        return None
    if not np.isfinite(Omega).all():
        return None
    found = kernels.compiled(settled_row, "G", "M")(
        A=now.A, C=now.C, R=R, S=S, Omega=Omega
    )
    return found["G"] if firm(found["M"]) else None


def firm(X: Matrix) -> bool:
    """Whether a covariance is so far from singular that its inverse has digits."""
    size = X.diagonal()
    if not (size > 0).all() or not np.isfinite(X).all():
        return False
    unit = np.sqrt(size)
    return bool(np.linalg.eigvalsh(X / unit / unit[:, None]).min(initial=1.0) > FIRM)


def _shared(found: Matrices, Omega: Matrix, now: Instant) -> Settled:
    F, V = found["F"], found["V"]
    forward, back = Sums(F), Sums(F.T)
    Pi = back(now.C.T @ V)
    unit = np.sqrt(np.where(Pi.diagonal() > 0, Pi.diagonal(), 1.0))
    fades, least = (forward.fades(unit, part) for part in (FADED, FELT))
    log_det = 2 * float(np.log(np.linalg.cholesky(found["M"]).diagonal()).sum())
    return Settled(
        Omega, found["W"], found["G"], F, V, Pi, forward, back, fades, least, log_det
    )


def unknown_start(one: Settled) -> Start | None:
    """A start that nothing is known of; None where the record does not show it well."""
    n = len(one.Pi)
    if not firm(one.Pi):
        return None
    half = np.linalg.cholesky(one.Pi)
    log_det = 2 * float(np.log(half.diagonal()).sum())
    weight = symmetrise(scipy.linalg.cho_solve((half, True), np.eye(n)))
    return Start(np.zeros(n), weight, np.zeros((n, n)), log_det, n)


def known_start(plant: Plant, one: Settled, u0: Vector) -> Start | None:
    """That of a plant with P0; None where little is left of Omega."""
    assert plant.P0 is not None
    A, B, Q = plant.first_step()
    found = kernels.compiled(settled_start)(
        A=A, B=B, Q=Q, P0=plant.P0, x_0=plant.x0[:, None], u_0=u0[:, None],
        Omega=one.Omega, Pi=one.Pi,
    )  # fmt: skip
    left = np.linalg.eigvals(found["Y_1"]).real  # of what is similar to a covariance
    if not left.min() > FIRM:
        return None
    log_det = np.log(left).sum()
    inverse = np.linalg.inv(found["Y_1"])
    weight = symmetrise(inverse @ found["Delta"])
    return Start(found["x_1"][:, 0], weight, inverse.T, float(log_det), 0)
