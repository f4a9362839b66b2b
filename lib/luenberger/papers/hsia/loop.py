"""The sampled loop: a continuous plant, a hold, and a law for the next sample.

What happens between two samples is in `system`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arguments import expect
from ...errors import DesignError
from ...numeric import Vector
from ...numeric.validation import numbers
from ...plant import Plant
from .references import step
from .system import Loop

SAMPLES = 1_000_000  # more than these is a mistake in the law
END_TOL = 1e-9  # an instant this close to the end, relative to the duration, is the end
READINGS = ("before", "after", "difference")


@dataclass(frozen=True, eq=False)
class Response:
    """One run of the sampled loop.  Row i belongs to the i-th sample.

    Attributes
    ----------
    t : (N,) ndarray
        Instants of the samples, in seconds: 0 <= t < duration.
    y, u : (N,) ndarray
        The output at each sample and the input held from there on.
    periods : (N,) ndarray
        Periods the law chose; the last one may reach beyond the duration.
    rates : (N,) ndarray
        ``|e'|`` as the law was told.
    E : float
        The response error (17), int ``|y* - y|`` dt from 0 to the duration.
    duration : float
        Seconds.
    """

    t: np.ndarray
    y: np.ndarray
    u: np.ndarray
    periods: np.ndarray
    rates: np.ndarray
    E: float
    duration: float
    _loop: Loop = field(repr=False)
    _states: np.ndarray = field(repr=False)  # just after each sample

    @property
    def samples(self) -> int:
        """Number of samples, at instants t with 0 <= t < duration."""
        return len(self.t)

    def at(self, times: ArrayLike) -> tuple[Vector, Vector, Vector]:
        """The reference r, the output y and the continuous loop's y* at any times.

        Parameters
        ----------
        times : (M,) array_like
            Seconds, from 0 to the duration.

        Returns
        -------
        r, y, y_star : (M,) ndarray

        Raises
        ------
        ValueError
            If a time lies outside the run.
        """
        times = numbers("times", times)
        if times.ndim != 1:
            raise ValueError(f"times must be a list of seconds, got {times!r}")
        if not ((times >= 0) & (times <= self.duration)).all():
            raise ValueError(f"times must lie between 0 and {self.duration:g} s")
        i = np.searchsorted(self.t, times, side="right") - 1
        s = self._loop.ahead(self._states[i], times - self.t[i])
        return tuple((s @ np.array(self._loop.outputs).T).T)


def simulate(
    law: Callable[[float], float],
    plant: Plant,
    duration: float,
    *,
    reference: Plant | None = None,
    x0: ArrayLike | None = None,
    rate: str = "before",
    first_rate: float = np.inf,
) -> Response:
    r"""Run a unity-feedback loop with zero-order hold, sampled as a law decides.

    >>> from luenberger import Plant, sampling
    >>> plant = Plant([[0, 1], [0, 0]], [[0], [1]], [[100, 10]])
    >>> run = sampling.simulate(sampling.root(0.08), plant, 1.2)
    >>> run.samples, round(run.E, 4)
    (20, 0.0552)

    .. math:: u(t) = r(t_i) - y(t_i), \quad t_i \le t < t_{i+1}, \qquad
              t_{i+1} = t_i + T(|\dot e(t_i)|), \quad e = r - y,

    and compare it with the continuous loop, u = r - y* at every moment,

    .. math:: E = \int_0^{duration} |y^*(t) - y(t)|\, dt . \tag{17}

    Either loop may be unstable, as long as its numbers stay finite.

    Parameters
    ----------
    law : callable
        From the rate ``|e'|`` to the next period in seconds: one of this package's,
        or any function.
    plant : Plant
        Continuous, one input, one output, no feedthrough.  Its noise is not used.
    duration : float
        Seconds.
    reference : Plant, optional
        `step`, `ramp`, `sine`, or any continuous plant without inputs, run from its
        x0; default the unit step.
    x0 : (n,) array_like, optional
        Start of the plant in both loops, default ``plant.x0``.
    rate : "before", "after" or "difference"
        What the law is told.  The slope of y may jump when u does, so it has a value
        just before the sample, as in the paper's results, and one just after;
        "difference" is that of the last two errors over the period between them.
    first_rate : float, default infinity
        The rate at t = 0: a step of the reference has an infinite one, which gives
        the shortest period.

    Returns
    -------
    Response

    Raises
    ------
    DesignError
        If the plant is not of that kind, the law returns no positive finite period
        or one so short that a million would not do, or the sampled loop diverges.
    ValueError
        If sizes or options are wrong.

    References
    ----------
    Hsia (1974), Table II and (17); papers/hsia/derivation/loop.py.
    """
    expect(law=law, plant=plant)
    _require_options(law, duration, rate, first_rate)
    loop = Loop(plant, step() if reference is None else reference, duration)
    s, t, E = loop.start(x0), 0.0, 0.0
    rows: list[tuple[Any, ...]] = []
    while duration - t > END_TOL * duration:
        e = loop.error @ s
        told = first_rate
        if rows and rate == "difference":
            told = (e - rows[-1][2]) / rows[-1][3]
        elif rows and rate == "before":
            told = loop.error @ loop.M @ s
        y = loop.outputs[1] @ s
        s = loop.hold(s, e)
        if rows and rate == "after":
            told = loop.error @ loop.M @ s
        T = _period(law, abs(told), t, duration)
        rows.append((t, y, e, T, abs(told), s))
        left = duration - t
        s, more = loop.run(s, left if T > left - END_TOL * duration else T)
        t, E = t + T, E + more
        if not np.isfinite(s).all():
            raise DesignError(
                f"the sampled loop diverges: beyond t = {t:.6g} s its state is not "
                "finite. Sample more often, or for a shorter duration."
            )
    t, y, u, periods, rates, states = (np.array(column) for column in zip(*rows))
    return Response(t, y, u, periods, rates, float(E), float(duration), loop, states)


def _period(
    law: Callable[[float], float], rate: float, t: float, duration: float
) -> float:
    """What the law says, if it is a period."""
    said, name = law(rate), getattr(law, "__name__", repr(law))
    if isinstance(said, np.ndarray) and said.ndim == 0:
        said = said[()]
    number = isinstance(said, Real) and not isinstance(said, bool | np.bool_)
    T = float(said) if number else np.nan
    if not 0 < T < np.inf:
        raise DesignError(
            f"the law {name} asks for the period {said} at t = {t:.6g} s, rate "
            f"{rate:.6g}: a period is a positive, finite number of seconds. Clip the "
            "law with `sampling.bounded`, or give another first_rate."
        )
    if T * SAMPLES < duration:
        raise DesignError(
            f"the law {name} asks for a period of {T:.3g} s at t = {t:.6g} s, rate "
            f"{rate:.6g}; at that pace {duration:g} s take more than {SAMPLES} "
            "samples. Give it a longer shortest period."
        )
    return T


def _require_options(law: object, duration: Any, rate: object, first_rate: Any) -> None:
    if not callable(law):
        raise ValueError(f"a law is a callable from rate to period, got {law!r}")
    if isinstance(duration, bool) or not isinstance(duration, Real):
        raise ValueError(f"duration must be a number of seconds, got {duration!r}")
    if not 0 < float(duration) < np.inf:
        raise ValueError(f"duration must be positive and finite, got {duration!r}")
    if rate not in READINGS:
        raise ValueError(f"rate must be one of {READINGS}, got {rate!r}")
    if not isinstance(first_rate, Real) or np.isnan(float(first_rate)):
        raise ValueError(f"first_rate must be a number or infinity, got {first_rate!r}")
