"""Units in which the numbers of a plant are of like size.

A tolerance, or a norm, that compares numbers of several states or outputs means
nothing when one of them is in light years.  Units are powers of two: a change of them
does not round.
"""

from typing import TypeVar

import numpy as np

from . import Matrix, Vector

SWEEPS = 50  # at most; a few are enough unless units differ along a long chain
Size = TypeVar("Size", float, np.ndarray)
EVEN = 2.0  # what moves a state and what it moves, if they differ by less, are even


def balanced(
    A: Matrix, C: Matrix, noise: Vector, sensor: Vector
) -> tuple[Vector, Vector]:
    """Units (n,), (p,) of the states and outputs of x+ = A x + w, y = C x + v.

    A state's unit is such that what moves it, other states and noise, is as large as
    what it moves, other states and noisy outputs; an output's unit is its own size.
    This is the balancing of LAPACK's gebal, with noise and outputs taken along.  An
    exact output has no size of its own, and counts where nothing else does.

    Parameters
    ----------
    A, C : (n, n), (p, n) ndarray
    noise, sensor : (n,), (p,) ndarray
        Variances of w and v; what rounding leaves below zero is zero.

    Examples
    --------
    A velocity in units of 2^-20 m/s beside a position in m, and noise on both of 1.

    >>> A, noise = np.array([[1, 2.0**-20], [0, 1]]), np.array([1, 2.0**40])
    >>> states, outputs = balanced(A, np.array([[1, 0]]), noise, np.ones(1))
    >>> np.log2(states), np.log2(outputs)
    (array([ 0., 20.]), array([0.]))
    """
    A, C = np.abs(A - np.diag(A.diagonal())), np.abs(C)
    noise, sensor = (np.sqrt(np.maximum(X, 0)) for X in (noise, sensor))
    states, noisy = np.ones(len(A)), sensor > 0
    for _ in range(SWEEPS):
        even = True
        for i in range(len(A)):
            outputs = _sizes(C, sensor, states)
            moved = max((A[i] * states).max(), noise[i])
            shown = C[:, i] / outputs
            seen = max((A[:, i] / states).max(), shown[noisy].max(initial=0))
            if moved == seen == 0:
                seen = shown.max(initial=0)
            found = _unit(moved, seen)
            if found is not None and not 1 / EVEN <= found / states[i] <= EVEN:
                states[i], even = found, False
        if even:
            break
    return states, _sizes(C, sensor, states)


def _unit(moved: float, seen: float) -> float | None:
    """The unit u for which moved / u = seen * u, or whichever there is, is 1."""
    if moved > 0 and seen > 0:
        return power_of_two(np.sqrt(moved) / np.sqrt(seen))
    if moved > 0 or seen > 0:
        return power_of_two(moved if moved > 0 else 1 / seen)
    return None


def _sizes(C: Matrix, sensor: Vector, states: Vector) -> Vector:
    """Units of the outputs: the size of what they show and of their deviation."""
    size = np.maximum((C * states).max(axis=1), sensor)
    return power_of_two(np.where(size > 0, size, 1.0))


def power_of_two(size: Size) -> Size:
    """The power of two nearest to each of the positive numbers `size`."""
    return np.power(2.0, np.round(np.log2(size)))
