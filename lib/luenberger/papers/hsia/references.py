"""Reference inputs, each the output of a linear system that runs by itself.

A reference is a `Plant` in continuous time without inputs: r = C x, x' = A x from
x0.  Steps, ramps and sines are made here; any other such plant will do as well.
"""

import numpy as np

from ...numeric.validation import numbers
from ...plant import Plant


def step(size: float = 1.0) -> Plant:
    """A step: r(t) = size.

    >>> from luenberger import sampling
    >>> sampling.step(2.0).x0
    array([2.])
    """
    return Plant([[0]], None, [[1]], x0=_numbers(size=size), name="step")


def ramp(slope: float = 1.0) -> Plant:
    """A ramp: r(t) = slope t."""
    x0 = [0, *_numbers(slope=slope)]
    return Plant([[0, 1], [0, 0]], None, [[1, 0]], x0=x0, name="ramp")


def sine(amplitude: float, omega: float, phase: float = 0.0) -> Plant:
    """A sine: r(t) = amplitude sin(omega t + phase), omega in rad/s."""
    size, omega, phase = _numbers(amplitude=amplitude, omega=omega, phase=phase)
    x0 = [size * np.sin(phase), size * np.cos(phase)]
    return Plant([[0, omega], [-omega, 0]], None, [[1, 0]], x0=x0, name="sine")


def _numbers(**values: object) -> list[float]:
    return [float(numbers(name, [value])[0]) for name, value in values.items()]
