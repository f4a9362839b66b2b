"""A continuous plant seen at uneven instants: a time-varying discrete plant."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from .. import kernels
from ..arguments import expect
from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.balance import balanced, power_of_two
from ..numeric.validation import numbers
from ..papers.hsia.derivation import noise_block, noise_doubled, noise_of_a_period
from ..plant import Plant
from .simulate import hold


def discretise(plant: Plant, periods: ArrayLike) -> Plant:
    r"""The time-varying discrete plant seen at uneven sampling instants.

    With u held from each instant to the next, T_i seconds later,

    .. math:: A_i = e^{A T_i}, \quad B_i = \int_0^{T_i} e^{A t} B\,dt, \quad
              Q_i = \int_0^{T_i} e^{A t} Q e^{A' t}\,dt ,

    exactly.  It can be given to `reduced_order_filter`, `filter_data` and
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

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1], [0, 0]], None, [[1, 0]], Q=[[0, 0], [0, 3]], R=[[1]])
    >>> sampled = lb.sampling.discretise(plant, [1.0, 2.0])
    >>> sampled.A[:2, 0, 1], sampled.Q[:2, 0, 0]
    (array([1., 2.]), array([1., 8.]))
    """
    expect(plant=plant)
    _require(plant)
    periods = _periods(periods)
    unique, where = np.unique(periods, return_inverse=True)
    where = np.append(where, where[-1])  # instant N
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        each = [_over_one(plant, T) for T in unique]
    for T, parts in zip(unique, each):
        if not all(np.isfinite(X).all() for X in parts):
            raise DesignError(
                f"within a period of {T:g} s the plant grows beyond what floats hold. "
                "Take shorter periods."
            )
    names = ("A", "B", "Q")[: len(each[0])]
    found: Any = {k: np.array(parts)[where] for k, parts in zip(names, zip(*each))}
    return replace(plant, **found, S=None, dt=float(periods.mean()))


def _over_one(plant: Plant, T: float) -> tuple[Matrix, ...]:
    """A, B and, if there is noise, Q of one period.

    In units in which no entry drowns another: the exponential rounds beside a norm.
    """
    n, Q = plant.n, np.zeros((plant.n, plant.n)) if plant.Q is None else plant.Q
    none = np.zeros((0, n)), np.zeros(0)  # no outputs
    states, _ = balanced(plant.A * T, none[0], Q.diagonal() * T, none[1])
    x, both = states[:, None], np.outer(states, states)
    A, B, Q = plant.A / x * states, plant.B / x, Q / both
    inputs, noise = _size(B, axis=0), _size(Q)
    A_i, B_i = hold(A, B / inputs, T)
    held = A_i * x / states, B_i * x * inputs
    return held if plant.Q is None else (*held, _noise(A, Q / noise, T) * noise * both)


def _size(X: Matrix, axis: int | None = None) -> np.ndarray | np.floating:
    """The power of two nearest to the largest entry, 1 where all are zero."""
    top = np.abs(X).max(axis=axis, initial=0.0)
    return power_of_two(np.where(top > 0, top, 1.0))


def _noise(A: Matrix, Q: Matrix, T: float) -> Matrix:
    """Covariance of the noise of one period: Van Loan's exponential, then doubling.

    The exponential holds e^(-A t), which overflows for a stable plant and a long
    period; over a short one it does not, and doubling keeps Q semi-definite.
    """
    n = len(A)
    doublings = max(0, int(np.ceil(np.log2(max(float(np.linalg.norm(A, 1)) * T, 1.0)))))
    block = kernels.compiled(noise_block)(A=A, Q=Q)["Block"]
    E = scipy.linalg.expm(block * (T / 2**doublings))
    Phi = E[n:, n:].T
    Q = kernels.compiled(noise_of_a_period)(Phi=Phi, X=E[:n, n:])["P"]
    for _ in range(doublings):
        Q = kernels.compiled(noise_doubled)(Phi=Phi, P=Q)["P_2"]
        Phi = Phi @ Phi
    return Q


def _periods(periods: ArrayLike) -> Vector:
    periods = numbers("periods", periods)
    if periods.ndim != 1 or len(periods) == 0:
        raise ValueError(
            f"periods must be a list of seconds, got shape {periods.shape}"
        )
    if not (periods > 0).all():
        i = int(np.argmin(periods > 0))
        raise ValueError(f"periods must be positive, periods[{i}] is {periods[i]:g} s")
    return periods


def _require(plant: Plant) -> None:
    if plant.dt != 0:
        raise DesignError(
            f"the plant has dt = {plant.dt:g}, it is discrete already; give the "
            "continuous plant (dt = 0)"
        )
    if plant.steps is not None or plant.is_complex:
        raise DesignError(
            "only constant, real plants can be discretised. Give one A, B, C and E, "
            "and real and imaginary parts as states of their own."
        )
    if plant.S is not None and plant.S.any():
        raise DesignError(
            "the plant has S, but continuous noise w has no covariance with the noise "
            "of a sample. Leave S out."
        )
    if plant.multiplicative:
        raise DesignError(
            "multiplicative noise is not discretised. Leave it out knowingly, with "
            "Plant(..., multiplicative=()), or give the pairs to the discrete plant."
        )
