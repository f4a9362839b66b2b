"""Sampling laws: from the rate of the error to the next period."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...numeric import Vector

T_MIN, T_MAX = 0.02, 0.1  # seconds, the bounds of Table II


@dataclass(frozen=True, eq=False)
class Law:
    """A sampling law, ``T = law(rate)``, clipped to its bounds.

    Attributes
    ----------
    period : callable
        The law without bounds: from ``|e'| >= 0``, which may be infinite, to seconds.
    T_min, T_max : float
        Bounds, in seconds.
    text : str
        How the law is written.
    """

    period: Callable
    T_min: float
    T_max: float
    text: str

    def __call__(self, rate: ArrayLike) -> Any:
        """The period at a rate, in seconds; also of an array of rates."""
        with np.errstate(divide="ignore"):  # law 3 at rest: as long as is allowed
            return np.clip(self.period(np.abs(rate)), self.T_min, self.T_max)

    def __repr__(self) -> str:
        return self.text


def periodic(T: float) -> Law:
    """The same period T, in seconds, whatever the error does.

    Examples
    --------
    >>> from luenberger import sampling
    >>> law = sampling.periodic(0.04)
    >>> law, float(law(3.0))
    (periodic(0.04), 0.04)
    """
    T = _positive("T", T)
    return Law(partial(_constant, T), T, T, f"periodic({T:g})")


def quadratic(alpha: float, *, T_min: float = T_MIN, T_max: float = T_MAX) -> Law:
    r"""Law 1 of Table II, for a squared error,

    .. math:: T = \frac{T_{\max}}{\alpha \dot e^2 + 1} .

    The minimum of (rho T)^2 / 2 + (T_max - T)^2 / (2 alpha), rho = ``|e'|``.

    Parameters
    ----------
    alpha : float
        Positive, in (s / units of e)^2; larger means more samples.
    T_min, T_max : float, optional
        Bounds in seconds, default those of the paper.

    Returns
    -------
    Law

    Raises
    ------
    ValueError
        If alpha is not positive, or the bounds are not 0 < T_min <= T_max.

    References
    ----------
    Hsia (1974), Table II; papers/hsia/derivation/laws.py.

    Examples
    --------
    >>> from luenberger import sampling
    >>> law = sampling.quadratic(1.0)
    >>> [float(law(rate)) for rate in (0, 1, 10)]
    [0.1, 0.05, 0.02]
    """
    return _of_table("quadratic", "alpha", alpha, T_min, T_max)


def absolute(alpha: float, *, T_min: float = T_MIN, T_max: float = T_MAX) -> Law:
    r"""Law 2 of Table II, for the area of the error,

    .. math:: T = \frac{T_{\max}}{\alpha |\dot e| + 1} .

    The minimum of rho T^2 / 2 + (T_max - T)^2 / (2 alpha), rho = ``|e'|``; alpha is
    in s / units of e.  Parameters and refusals are those of `quadratic`.

    References
    ----------
    Hsia (1974), Table II; papers/hsia/derivation/laws.py.

    Examples
    --------
    >>> from luenberger import sampling
    >>> float(sampling.absolute(1.0)(3.0))
    0.025
    """
    return _of_table("absolute", "alpha", alpha, T_min, T_max)


def root(C: float, *, T_min: float = T_MIN, T_max: float = T_MAX) -> Law:
    r"""Law 3 of Table II, for a price on samples per second,

    .. math:: T = C / \sqrt{|\dot e|} .

    The minimum of rho T + C^2 / T, rho = ``|e'|``; C is in sqrt(s units of e), and
    smaller means more samples.  Parameters and refusals are those of `quadratic`.

    References
    ----------
    Hsia (1974), Table II; papers/hsia/derivation/laws.py.

    Examples
    --------
    >>> from luenberger import sampling
    >>> [float(sampling.root(0.08)(rate)) for rate in (0, 4)]
    [0.1, 0.04]
    """
    return _of_table("root", "C", C, T_min, T_max)


def linear(K: float, *, T_min: float = T_MIN, T_max: float = T_MAX) -> Law:
    r"""Law 4 of Table II, for the error reached,

    .. math:: T = T_{\max} - K |\dot e| .

    The minimum of rho T + (T_max - T)^2 / (2 K), rho = ``|e'|``; K is in s^2 / units
    of e.  Parameters and refusals are those of `quadratic`.

    References
    ----------
    Hsia (1974), Table II; papers/hsia/derivation/laws.py.

    Examples
    --------
    >>> from luenberger import sampling
    >>> [round(float(sampling.linear(0.01)(rate)), 3) for rate in (0, 4, 40)]
    [0.1, 0.06, 0.02]
    """
    return _of_table("linear", "K", K, T_min, T_max)


def bounded(period: object, T_min: float, T_max: float) -> Law:
    """A law of your own, any callable from rate to period, clipped to bounds.

    Raises
    ------
    ValueError
        If `period` cannot be called, or the bounds are not 0 < T_min <= T_max.

    Examples
    --------
    >>> from luenberger import sampling
    >>> law = sampling.bounded(lambda rate: 0.1 / (1 + rate) ** 0.5, 0.02, 0.1)
    >>> float(law(3.0))
    0.05
    """
    if not callable(period):
        raise ValueError(f"a law is a callable from rate to period, got {period!r}")
    T_min, T_max = _bounds(T_min, T_max)
    name = getattr(period, "__name__", type(period).__name__)
    return Law(period, T_min, T_max, f"bounded({name}, {T_min:g}, {T_max:g})")


def _of_table(name: str, letter: str, value: float, T_min: float, T_max: float) -> Law:
    """A law of Table II, its formula compiled from the derivation at first use."""
    value = _positive(letter, value)
    T_min, T_max = _bounds(T_min, T_max)
    text = f"{name}({value:g})"
    if (T_min, T_max) != (T_MIN, T_MAX):
        text = f"{name}({value:g}, T_min={T_min:g}, T_max={T_max:g})"
    return Law(partial(_compiled, name, letter, value, T_max), T_min, T_max, text)


# Functions with names, not closures, so that laws can be sent to other processes.


def _constant(T: float, rate: Vector) -> Vector:
    return np.full_like(rate, T, float)


def _compiled(
    name: str, letter: str, value: float, T_max: float, rate: Vector
) -> Vector:
    return formula_of(name, letter)(rho=rate, T_max=T_max, **{letter: value})


@cache
def formula_of(name: str, letter: str) -> Callable[..., Any]:
    """A law without bounds as f(rho, T_max, letter), compiled from its derivation."""
    from ...kernels.scalar import function
    from .derivation.laws import T_s, best

    return function(best(name), T_s, "rho", "T_max", letter)


def _positive(name: str, value: Any) -> float:
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not number or not 0 < value < np.inf:
        raise ValueError(f"{name} must be a positive number, got {value!r}")
    return float(value)


def _bounds(T_min: object, T_max: object) -> tuple[float, float]:
    T_min, T_max = _positive("T_min", T_min), _positive("T_max", T_max)
    if T_min > T_max:
        raise ValueError(
            f"the bounds are out of order: T_min = {T_min:g} s is longer than T_max = "
            f"{T_max:g} s"
        )
    return T_min, T_max
