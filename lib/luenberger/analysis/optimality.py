"""Is an estimator the best of its order?  The necessary conditions, measured.

The moments come from the Lyapunov equations (4.4) and (4.5) of plant and observer
together, multiplicative noise included, and not from the block equations that a
design solves, so a fault of either shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import expect
from ..certificate import certify, require_match, require_real
from ..errors import FIT, SAMPLE, CertificateError, DesignError
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..numeric.linalg import modes
from ..observer import Observer
from ..plant import Plant
from .disturbance import NO_INPUT, disturbed
from .error_covariance import mean_error
from .known_input import KnownInput, driven, known_input, no_tones, seen
from .mean_square import require_mean_square_stable
from .necessary_conditions import conditions

STATIONARY_TOL = 1e-8  # of every relative residual of a design that is accepted


@dataclass(frozen=True, eq=False)
class Optimality:
    """How far an estimator is from the conditions of least error at its order.

    All residuals are relative, and independent of units: that of a gradient is in
    proportion to the terms that cancel in it, for states and outputs of unit variance.

    Attributes
    ----------
    F, D, P, V : float
        Gradients of the cost in these matrices of the observer: (4.8)-(4.11).  V is
        None when it is held at zero.
    riccati, estimate, adjoint : float
        (3.14), (3.15), (3.16).
    idempotent : float
        tau^2 = tau, (3.6).
    aligned : float
        tau Qh = Qh tau' and Ph tau = tau'Ph, the larger: what (3.17) asks of tau.
    trace : float
        The cost by (3.18) against `cost`; the two agree only at an optimum.
    mean : float or None
        The part of the cost that is a mean error, where the input is at a level.
    cost : float
        Steady E[(w^ - L x)' weight (w^ - L x)]; for u = 0 unless the plant has U.
    tau, Q, Qh, Ph : (n, n) ndarray
        The projection, the error covariance of the lifted estimate, and the theorem's
        two hatted matrices.
    G, Gam : (r, n) ndarray
        tau = G'Gam: z tracks Gam x, and G'z is the lifted estimate.
    note : str
        Says so where the known input disturbs the estimate and the plant has no U, so
        that the cost is that of u = 0; else empty.
    """

    F: float
    D: float
    P: float
    V: float | None
    riccati: float
    estimate: float
    adjoint: float
    idempotent: float
    aligned: float
    trace: float
    cost: float
    tau: np.ndarray = field(repr=False)
    Q: np.ndarray = field(repr=False)
    Qh: np.ndarray = field(repr=False)
    Ph: np.ndarray = field(repr=False)
    G: np.ndarray = field(repr=False)
    Gam: np.ndarray = field(repr=False)
    mean: float | None = None
    note: str = ""

    @property
    def residuals(self) -> dict[str, float]:
        """The relative residuals by name, those that apply."""
        found = ((name, getattr(self, name)) for name in _MEANING)
        return dict(pair for pair in found if pair[1] is not None)

    @property
    def worst(self) -> float:
        """The largest relative residual."""
        return max(self.residuals.values())

    def require(self, tol: float = STATIONARY_TOL) -> Optimality:
        """Return self, or raise CertificateError naming the first condition missed."""
        for name, value in self.residuals.items():
            if not value <= tol:  # also catches NaN
                raise CertificateError(
                    f"not optimal at its order: {_MEANING[name]} is missed by "
                    f"{value:.1e}, above {tol:.0e}. If this is a fixed-order filter, "
                    "try more starts, another seed, a lower order, or states and "
                    "outputs scaled to similar sizes."
                )
        return self


_MEANING = {
    "F": "stationarity in F, (4.8),",
    "D": "stationarity in D, (4.9),",
    "P": "stationarity in P, (4.10),",
    "V": "stationarity in V, (4.11),",
    "riccati": "the Riccati equation (3.14)",
    "estimate": "the Lyapunov equation (3.15)",
    "adjoint": "the Lyapunov equation (3.16)",
    "idempotent": "tau^2 = tau, (3.6),",
    "aligned": "the alignment of tau with Qh and Ph, (3.17),",
    "trace": "the cost formula (3.18)",
    "mean": "the absence of a mean error at the level of the known input",
}


def optimality(
    observer: Observer,
    plant: Plant,
    *,
    weight: ArrayLike | None = None,
    feedthrough: bool | None = None,
) -> Optimality:
    r"""Measure how far an estimator is from the least error of its order.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9, 0.1], [0.2, 0.7]], None, [[0, 1]], dt=1.0,
    ...                  Q=[[0.1, 0], [0, 0]], R=[[1]])
    >>> lb.optimality(lb.kalman_filter(plant), plant).worst < 1e-12
    True

    The cost is that of (3.5), E[(w^ - L x)' weight (w^ - L x)] in the steady state,
    of the plant without its known input unless its U says what that is like.  The
    necessary conditions are that its four gradients vanish and,
    equivalently, the optimal projection equations (3.14)-(3.17).

    Parameters
    ----------
    observer : Observer
        Constant and stable; of any method.
    plant : Plant
        Discrete, constant and mean-square stable, with Q and R; U, if it is given, a
        level, or a model that decays.
    weight : (q, q) array_like, optional
        Positive semi-definite; default the identity.
    feedthrough : bool, optional
        Whether V (and with U W) is free; default whether it is not zero.

    Returns
    -------
    Optimality
        With a varying U its matrices are those of model and plant together.

    Raises
    ------
    DesignError
        If the plant or the observer is not stable, or has no such cost.

    References
    ----------
    Haddad and Bernstein (1987), equations (3.14)-(3.18), (4.4)-(4.11);
    papers/haddad_bernstein/derivation/gradients.py, equations.py.
    """
    expect(observer=observer, plant=plant)
    weight = np.eye(len(observer.L)) if weight is None else weight
    weight = covariance("weight", weight, len(observer.L))
    given = None if plant.U is None or not plant.m else known_input(plant)
    require_match(observer, plant)
    if given is not None and not given.still and not given.tones:
        model = given.varying
        observer, plant = seen(observer, model), driven(plant, model)
    feedthrough = bool(observer.V.any()) if feedthrough is None else feedthrough
    _require(observer, plant, feedthrough)
    found: dict[str, Any] = conditions(observer, plant, weight, feedthrough)
    if plant.U is None and disturbed(observer, plant, certify(observer, plant)):
        found["note"] = NO_INPUT
    if given is not None and (given.still or given.tones):
        mean = _mean_cost(observer, plant, weight, given)
        found["cost"] += mean
        found["mean"] = mean / found["cost"] if mean else 0.0
    return Optimality(**found)


def _mean_cost(
    observer: Observer, plant: Plant, weight: Matrix, given: KnownInput
) -> float:
    """What the mean error at the level of the known input costs."""
    if not given.still:
        raise no_tones(given)
    e = mean_error(observer, plant)
    return float(e @ weight @ e)


def _require(observer: Observer, plant: Plant, feedthrough: bool) -> None:
    require_match(observer, plant)
    require_real("optimality", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        raise DesignError(
            "optimality is for discrete time and needs both noise covariances Q and "
            f"R; {FIT if plant.dt else SAMPLE}"
        )
    if observer.steps is not None:
        raise DesignError("optimality is of a constant observer, not of one over steps")
    require_mean_square_stable(plant)
    poles = np.linalg.eigvals(observer.F)
    if (np.abs(poles) >= 1).any():
        raise DesignError(
            f"the observer has the mode {modes(poles[np.abs(poles) >= 1])} on or "
            "outside the unit circle, so its error has no steady state"
        )
    if not isinstance(feedthrough, bool | np.bool_):
        raise ValueError(f"feedthrough must be True, False or None, got {feedthrough}")
    if not feedthrough and observer.V.any():
        raise ValueError("feedthrough=False, but the observer's V is not zero")
