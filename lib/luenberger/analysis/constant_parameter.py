"""How strong white noise must be to stand for a parameter that is wrong for good."""

from __future__ import annotations

import numpy as np
import scipy  # its parts load when first used
from numpy.typing import ArrayLike

from .. import kernels
from ..arguments import expect
from ..certificate import require_match, require_real, residuals
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..numeric.linalg import decaying, eigenvalues, lyapunov, modes
from ..numeric.validation import matrix
from ..observer import Observer
from ..papers.haddad_bernstein.derivation import first_drive, second_drive
from ..papers.leondes_novak.derivation import beside_the_state, root_error
from ..plant import Plant
from .error_system import JointSystem

NOTHING = 1e-14  # of the error, that a parameter of the size of A adds: rounding


def white_noise_factor(
    observer: Observer,
    plant: Plant,
    A1: ArrayLike,
    *,
    weight: ArrayLike | None = None,
) -> float:
    r"""By how much white noise understates a parameter that is wrong for good.

    White noise must have 3.8 times the variance of a constant error of this pole:

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9]], None, [[1]], dt=1.0, Q=[[1]], R=[[4]])
    >>> observer = lb.kalman_filter(plant)
    >>> round(white_noise_factor(observer, plant, [[1]]), 2)
    3.84

    A plant x+ = (A + theta A1) x + w with an unknown constant theta of mean 0 and
    variance s^2 adds s^2 X_2 to the second moment of state and error, to second order,
    and white noise of that variance in its place adds s^2 X_w, with

    .. math:: X_2 - X_w = A (X_2 - X_w) A' + A_1 X_1 A' + A X_1 A_1' .

    The factor is the quotient of what both cost, tr(weight P X_2 P') over
    tr(weight P X_w P').  So multiplicative noise ``(sqrt(factor) * s * A1, 0)`` costs
    this observer, for small s, what the constant does.  It depends on the observer and
    on the weight: no one factor makes all entries agree.  What is left over is of
    fourth order in s for a theta of symmetric distribution.

    Parameters
    ----------
    observer : Observer
        Constant and stable.
    plant : Plant
        Discrete, constant and stable, with Q and R, without multiplicative noise.
    A1 : (n, n) array_like
        How A depends on the parameter.
    weight : (q, q) array_like, optional
        Of the error; default the identity.

    Returns
    -------
    float
        Near 1 where state or error forgets in one step, 10 or 100 where both remember
        for long; negative where a constant lessens the error in the mean over its
        signs.

    Raises
    ------
    DesignError
        If state or error has no steady state, or the parameter does not move the error.

    See Also
    --------
    compare : for constant errors, the choice over plants that `vary` makes.

    References
    ----------
    papers/haddad_bernstein/derivation/constant_parameter.py.
    """
    expect(observer=observer, plant=plant)
    require_match(observer, plant)
    require_real("the factor", plant, observer)
    _require(observer, plant)
    direction = matrix("A1", A1, plant.n, plant.n)
    weight = np.eye(len(observer.L)) if weight is None else weight
    weight = covariance("weight", weight, len(observer.L))
    system = JointSystem(observer, plant, None)
    given, _ = system.rooted(0)
    A, P = given["F"], given["P"]
    poles = eigenvalues(A)
    if not decaying(poles, discrete=True).all():
        bad = poles[~decaying(poles, discrete=True)]
        raise DesignError(
            f"the factor is of steady states, and plant or observer has the mode "
            f"{modes(bad)} on or outside the unit circle. lb.compare judges plants "
            "one by one"
        )
    drive = kernels.compiled(root_error)(**given, H=np.zeros((len(A), 0)))["drive"]
    X_0 = lyapunov(A, drive @ drive.T)
    have = dict(A=A, A_1=_direction(observer, direction), X_0=X_0)
    B_1 = kernels.run(first_drive, have)["B_1"]
    have["X_1"] = _solved(A, B_1)
    driven = kernels.run(second_drive, have)
    white, constant = (
        float(np.trace(weight @ P @ _solved(A, driven[name]) @ P.T))
        for name in ("B_w", "B_2")
    )
    size = np.trace(weight @ P @ X_0 @ P.T)
    largest = max(float(np.linalg.norm(plant.A)), NOTHING)
    reach = float(np.linalg.norm(direction)) / largest
    if white <= NOTHING * size * reach**2:
        raise DesignError(
            "the parameter does not move the error, so there is no factor"
        )
    return constant / white


def _direction(observer: Observer, A1: Matrix) -> Matrix:
    """How what moves state and error depends on the parameter; both are linear in A."""
    o = observer
    n, p, m = A1.shape[0], o.D.shape[1], o.G.shape[1]
    B, C, E = np.zeros((n, m)), np.zeros((p, n)), np.zeros((p, m))
    F, G, D, P, V, W, L = (0.0 * getattr(o, name) for name in "FGDPVWL")
    N_1 = residuals(A1, B, C, E, L, F, G, D, P, V, W, o.T, o.T)[0]
    have = dict(A=A1, N_1=N_1, F=F)
    return kernels.run(beside_the_state, have, "F_both")["F_both"]


def _solved(A: Matrix, B: Matrix) -> Matrix:
    """X = A X A' + B, where B need not be a covariance."""
    return scipy.linalg.solve_discrete_lyapunov(A, B)


def _require(observer: Observer, plant: Plant) -> None:
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        raise DesignError(
            "the factor is for discrete time and needs both noise covariances Q and "
            f"R; {FIT if plant.dt else SAMPLE}"
        )
    if observer.steps is not None or plant.steps is not None or plant.multiplicative:
        raise DesignError(
            "the factor is of a constant observer and a constant plant without "
            "multiplicative noise"
        )
