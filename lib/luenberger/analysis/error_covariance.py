"""How accurate any observer is on a plant with noise: the covariance of its error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arguments import expect
from ..certificate import certify, require_match, require_real
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrix, Vector
from ..numeric.validation import whole
from ..observer import Observer
from ..plant import Plant
from .disturbance import disturbed, require_undisturbed
from .error_system import error_system
from .known_input import (
    KnownInput,
    driven,
    known_input,
    seen,
    start_of_input,
)
from .mean_square import noise_at


def error_covariance(
    observer: Observer,
    plant: Plant,
    *,
    steps: int | None = None,
) -> Matrix:
    r"""Second moment E[e e'] of the error e = w^ - L x of any observer on a plant.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[1]])
    >>> lb.error_covariance(lb.kalman_filter(plant), plant).round(12)
    array([[0.75, 0.5 ],
           [0.5 , 1.  ]])

    For an observer that satisfies (9), (13) the error obeys (11), (26),

    .. math:: \varepsilon_{i+1} = F_i\varepsilon_i + D_i v_i - T_{i+1} w_i,
              \qquad e_i = P_i\varepsilon_i + V_i v_i ,

    whatever the known input.  Where it does not (a filter of fixed order, or another
    plant than it was designed for), state and input drive the error too, the input as
    ``plant.U`` says; a mean error counts with its square.  Multiplicative noise counts,
    too, with an input of zero where nothing is said of it.

    Parameters
    ----------
    observer : Observer
        With any gains, optimal or not, designed for this plant or for another one.
    plant : Plant
        Discrete, with Q and R; with P0 when `steps` is given.  What is known of its
        input, U, counts where that disturbs the estimate; of an input with tones the
        steady value is the mean over time.
    steps : int, optional
        Number of steps; default the steady state of a constant observer.

    Returns
    -------
    (q, q) or (steps + 1, q, q) ndarray
        Steady value, or rows i = 0 .. steps.  For a time-varying filter row 0 is the
        initial L P0 L'; for a constant observer row 0 is its first sample, the state
        having the mean x0 and covariance P0 there.

    Raises
    ------
    DesignError
        Without noise covariances or P0, when there is no steady state (the modes at
        fault are named, or how much multiplicative noise the plant would stand), or
        when the known input disturbs the estimate and the plant has no U.

    See Also
    --------
    Plant.with_input : what is known of the input.

    References
    ----------
    Leondes and Novak (1974), equations (11), (26), (28);
    papers/leondes_novak/derivation/huddle.py, any_observer.py, known_input.py. Haddad
    and Bernstein (1987), (4.3), (4.4); papers/haddad_bernstein/derivation/augmented.py.
    """
    expect(observer=observer, plant=plant)
    require_match(observer, plant)
    require_real("the error covariance", plant, observer)
    steps = None if steps is None else whole("steps", steps)
    _require_noise(plant, steps)
    if observer.steps is not None and steps is None:
        raise ValueError("give steps: a time-varying observer has no steady state")
    certificate = certify(observer, plant)
    if plant.U is None:
        require_undisturbed(observer, plant, certificate)
    elif disturbed(observer, plant, certificate) or plant.multiplicative:
        return _driven(observer, plant, steps, known_input(plant))
    system = error_system(observer, plant, steps, certificate)
    return system.steady() if steps is None else system.over(steps)


def mean_error(observer: Observer, plant: Plant) -> Vector:
    """The mean E[e] of the error of a constant observer in the steady state.

    It is what the level of the known input leaves, (I - F) eps = -N u and e = P eps +
    (W + V E) u with the residuals N of (10), and zero where the input does not disturb
    the estimate.
    """
    certificate, none = certify(observer, plant), np.zeros(len(observer.L))
    if plant.U is None:
        require_undisturbed(observer, plant, certificate)
    if plant.U is None or not disturbed(observer, plant, certificate):
        return none
    level = known_input(plant).level
    system = error_system(observer, plant, None, certificate)
    return system.of_tone(1.0, level[:, None])[:, 0].real if level.any() else none


def _driven(
    observer: Observer, plant: Plant, steps: int | None, given: KnownInput
) -> Matrix:
    """E[e e'] of plant and input together, and of the tones of the input."""
    if steps is not None:
        known = start_of_input(observer, plant)
        both = driven(plant, given.model)
        one = seen(observer, given.model)
        return error_system(one, both, steps, known=known).over(steps)
    alone = error_system(observer, replace(plant, multiplicative=()), None)
    errors = [alone.of_tone(mode, u) for mode, u in given.tones]
    Sigma = sum(
        ((e @ e.conj().T).real for e in errors), np.zeros((len(observer.L),) * 2)
    )
    if plant.multiplicative and given.tones:
        plant = _moved_by_tones(plant, given)
    both, one = driven(plant, given.varying), seen(observer, given.varying)
    return Sigma + error_system(one, both, None).steady()


def _moved_by_tones(plant: Plant, given: KnownInput) -> Plant:
    """The plant with the noise that tones of the input cause by multiplying."""
    states = [
        np.linalg.solve(mode * np.eye(plant.n) - plant.A, plant.B @ u)
        for mode, u in given.tones
    ]
    none = np.zeros((plant.n, plant.n))
    X = sum(((x @ x.conj().T).real for x in states), none)
    Q, S, R = noise_at(plant, 0, X)
    return replace(plant, Q=Q, S=S, R=R)


def _require_noise(plant: Plant, steps: int | None) -> None:
    if plant.dt == 0:
        raise DesignError(
            f"error covariances are for discrete time, the plant has dt=0; {SAMPLE}"
        )
    if plant.Q is None or plant.R is None:
        raise DesignError(f"the plant needs both noise covariances Q and R; {FIT}")
    if steps is not None and plant.P0 is None:
        raise DesignError(
            "the plant needs P0, the covariance of its initial state; "
            "dataclasses.replace(plant, P0=...) gives it one"
        )
