"""Leondes and Novak's reduced-order filter, with the Kalman filter as m1 = 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...arguments import expect
from ...errors import DesignError
from ...filtering.maps import Settings
from ...filtering.pack import over_steps
from ...numeric import Matrix
from ...numeric.combinations import combinations
from ...numeric.covariances import covariance
from ...numeric.linalg import UNIT_TOL
from ...numeric.validation import whole
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ...recursion.best_constant_gain import best_constant_gain
from ...recursion.settings import Setting, require_start, setting
from ...recursion.steady_gain import steady_gain
from ...recursion.weight import definite
from ..certified import certified, of_what_is_needed
from .as_observer import with_gain, with_gains


def kalman_filter(
    plant: Plant,
    *,
    L: Combinations | None = None,
    steps: int | None = None,
) -> Observer:
    r"""Kalman filter: every output is filtered, the order is n.

    Constant-velocity radar track at tracking index 1 (Kalata 1984): alpha = 3/4,
    beta = 1/2.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[1]])
    >>> lb.kalman_filter(plant).V.round(12)
    array([[0.75],
           [0.5 ]])

    The case m1 = 0 of `reduced_order_filter`, which see,

    .. math:: \hat x_{i+1} = A\hat x_i + B u_i
              + K_{i+1} (y_{i+1} - C (A\hat x_i + B u_i)).

    Parameters
    ----------
    plant : Plant
        Discrete (``dt > 0``), with Q and R; with P0 when `steps` is given.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x; default x.  Rows may have names, and names of states and of
        `plant.estimates` stand for rows.  The gain is the same, as it makes the error
        of every combination least.
    steps : int, optional
        Number N of instants i = 1 .. N; default the steady state.

    Returns
    -------
    Observer
        In filter form: the estimate at i uses y up to and including i.  Its V is the
        filter gain K (not A K, the predictor gain).

    Raises
    ------
    DesignError, CertificateError
        As `reduced_order_filter`.

    References
    ----------
    Leondes and Novak (1974), equations (39)-(44);
    papers/leondes_novak/derivation/limiting_cases.py.
    """
    return reduced_order_filter(plant, 0, L=L, steps=steps)


def reduced_order_filter(
    plant: Plant,
    m1: int | Sequence[int | str],
    *,
    L: Combinations | None = None,
    steps: int | None = None,
    weight: ArrayLike | str | None = None,
    horizon: str = "step",
) -> Observer:
    r"""Reduced-order filter of least error trace (Leondes and Novak 1974).

    Exact position of a double integrator: one state, pole sqrt(3) - 2.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[1/3, 1/2], [1/2, 1]], R=[[0]])
    >>> observer = lb.reduced_order_filter(plant, m1=1)
    >>> observer.order, observer.poles.real.round(12)
    (1, array([-0.26794919]))

    The m1 accurate outputs y1 are treated as exact, C1 x^ = y1, and only the
    remaining n - m1 directions are filtered, with the gain V of (33): at each step the
    least tr(weight Sigma) among the estimates with C1 x^ = y1.

    Parameters
    ----------
    plant : Plant
        Discrete (``dt > 0``), with Q and R; S, feedthrough, singular noise and
        singular A are allowed.  With P0 when `steps` is given.
    m1 : int or sequence
        Number of accurate outputs, the first m1 rows of C, or their indices or
        names.  0 is the Kalman filter, p the minimal order n - p.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x; default x.  Rows may have names, and names of states and of
        `plant.estimates` stand for rows.
    steps : int, optional
        Number N of instants of a time-varying filter; default the steady state.
    weight : (n, n) array_like or "canonical", optional
        Of the error of x, positive definite.  Default the identity; with L and
        ``horizon="steady"`` L'L.  "canonical" is the paper's choice (19).
    horizon : "step" or "steady", default "step"
        "steady": the constant gain of the same structure with the least steady
        trace, which the step-wise gain need not have.  `steps` must be None.

    Returns
    -------
    Observer
        Of order n - m1 with P = Phat, V = K; the certificate holds to rounding.  A
        steady filter starts from z0 = T x0; pass `estimate` your own start.

    Raises
    ------
    DesignError
        dt = 0, no Q, R or P0; accurate outputs that are linearly dependent; a mode
        that is undetectable or has no steady state.
    CertificateError
        If rounding spoils the design.

    See Also
    --------
    Filter : the same filter over a record, with missing values.

    References
    ----------
    Leondes and Novak (1974), equations (14), (15), (24)-(36);
    papers/leondes_novak/derivation/best_coordinates.py.
    """
    expect(plant=plant)
    if horizon not in ("step", "steady"):
        raise ValueError(f"horizon must be 'step' or 'steady', got {horizon!r}")
    L, called = by_name(L, plant)
    if L is not None:
        L = combinations("L", L, plant.n)
    if steps is not None:
        if horizon == "steady":
            raise DesignError("horizon='steady' is a constant gain; leave out steps")
        made = _over(Settings(plant, m1, weight), steps)
        return certified(made, plant, settling=False, L=L, called=called)
    if plant.steps is not None:
        raise DesignError(
            "a time-varying plant has no steady state; give the number of steps"
        )
    now, K = _steady(plant, m1, L, weight, horizon)
    return certified(with_gain(plant, now, K), plant, L=L, called=called)


def _steady(
    plant: Plant,
    m1: int | Sequence[int | str],
    L: Matrix | None,
    weight: ArrayLike | str | None,
    horizon: str,
) -> tuple[Setting, Matrix]:
    """The setting and the constant gain, after `weight` or, by default, L'L."""
    given, of_cost = weight, None
    if horizon == "steady" and not isinstance(weight, str):
        if weight is not None:
            of_cost = covariance("weight", weight, plant.n)
        elif L is not None:
            of_cost = L.T @ L
        if of_cost is None or not definite(of_cost):
            given = None  # of the step-wise gain that the search starts from
    settings = Settings(plant, m1, given)
    accurate = settings.accurate
    now = setting(plant, accurate, settings.weight)
    with of_what_is_needed(plant, L, 1 - UNIT_TOL):
        if horizon == "step":
            return now, steady_gain(now, accurate)
        return now, best_constant_gain(now, accurate, of_cost)


def _over(settings: Settings, steps: int) -> Observer:
    """The time-varying filter of instants 1 .. steps as an Observer."""
    plant = settings.plant
    require_start(plant)
    steps = covered(whole("steps", steps, 1), plant)
    given = plant, settings.accurate, settings.weight
    last = 1 if plant.steps is None else steps
    rows = [setting(*given, i) for i in range(1, last + 1)]
    names = "As", "B", "J", "C", "E", "Gamma", "Phat", "That"
    have = {name: np.stack([getattr(now, name) for now in rows]) for name in names}
    have["K"] = over_steps(settings, steps)[1]
    have = {k: np.broadcast_to(X, (steps, *X.shape[1:])) for k, X in have.items()}
    return with_gains(plant, have)


def covered(steps: int, plant: Plant) -> int:
    """Return `steps`, or DesignError unless the plant's rows cover so many."""
    if plant.steps is not None and steps >= plant.steps:
        raise DesignError(
            f"steps = {steps} needs the plant at instants 0 .. {steps}, it has rows "
            f"0 .. {plant.steps - 1}; take steps <= {plant.steps - 1}"
        )
    return steps
