"""A continuous plant seen at uneven instants: a time-varying discrete plant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import expect
from ..numeric.validation import numbers
from ..plant import Plant, over_periods


def discretise(plant: Plant, periods: ArrayLike) -> Plant:
    r"""The time-varying discrete plant seen at uneven sampling instants.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1], [0, 0]], None, [[1, 0]], Q=[[0, 0], [0, 3]], R=[[1]])
    >>> sampled = lb.sampling.discretise(plant, [1.0, 2.0])
    >>> sampled.A[:2, 0, 1], sampled.Q[:2, 0, 0]
    (array([1., 2.]), array([1., 8.]))

    With u held from each instant to the next, T_i seconds later,

    .. math:: A_i = e^{A T_i}, \quad B_i = \int_0^{T_i} e^{A t} B\,dt, \quad
              Q_i = \int_0^{T_i} e^{A t} Q e^{A' t}\,dt ,

    exactly.  It can be given to `reduced_order_filter`, `Filter` and
    `error_covariance`, with steps up to the number of periods.

    Parameters
    ----------
    plant : Plant
        Continuous.  Q is the intensity of the white noise w, in squared units per
        second; R is the covariance of the noise in **one sample**, in squared units
        (white noise of finite intensity cannot be sampled).  x0 and P0 belong to the
        instant before the first period.
    periods : (N,) array_like
        Seconds from each instant to the next, e.g. those of a `Response`.

    Returns
    -------
    Plant
        With A, B and Q at instants 0 .. N; row N repeats row N - 1 and is not used
        by a filter of N steps.  Its dt is the mean period, for the time axis of
        figures only: instant i is at ``sum(periods[:i])``.
        Equal periods are `Plant.sampled`.

    Raises
    ------
    DesignError
        If the plant is not continuous and constant, has S (cross-covariance with a
        sample's noise) or multiplicative noise, or grows beyond what floats hold
        within a period.
    ValueError
        If a period is not positive.

    References
    ----------
    Van Loan (1978), "Computing integrals involving the matrix exponential", for Q;
    papers/hsia/derivation/noise.py.
    """
    expect(plant=plant)
    T = numbers("periods", periods)
    if T.ndim != 1 or len(T) == 0:
        raise ValueError(f"periods must be a list of seconds, got shape {T.shape}")
    if not (T > 0).all():
        i = int(np.argmin(T > 0))
        raise ValueError(f"periods must be positive, periods[{i}] is {T[i]:g} s")
    fields = over_periods(plant, T)
    held = {k: np.append(X, X[-1:], axis=0) for k, X in fields.items() if k in "ABQ"}
    return replace(plant, **fields | held)  # row N repeats the one before
