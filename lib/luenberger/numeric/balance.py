"""Units in which the numbers of a plant are of like size.

A tolerance, or a norm, that compares numbers of several states or outputs means
nothing when one of them is in light years.  Units are powers of two: a change of them
does not round.
"""

from typing import TypeVar

import numpy as np
from scipy.sparse.csgraph import connected_components

from . import Matrix, Vector

SWEEPS = 50  # at most; a few are enough unless units differ along a long chain
TIE = 1e-9  # what lies so near to halfway between two powers goes to the smaller
EVEN = 2.0  # what moves a state and what it moves, if they differ by less, are even
Size = TypeVar("Size", float, np.ndarray)


def balanced(
    A: Matrix, C: Matrix, noise: Vector | float, sensor: Vector | float
) -> tuple[Vector, Vector]:
    """Units (n,), (p,) of the states and outputs of x+ = A x + w, y = C x + v.

    A state's unit is such that what moves it, other states and noise, is as large as
    what it moves, other states and noisy outputs; an output's unit is its own size.
    This is the balancing of LAPACK's gebal, with noise and outputs taken along.  An
    exact output has no size of its own, and counts where nothing else does.

    Parameters
    ----------
    A, C : (n, n), (p, n) ndarray
    noise, sensor : (n,), (p,) ndarray, or 0
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
    noise = np.sqrt(np.maximum(np.broadcast_to(noise, len(A)), 0))
    sensor = np.sqrt(np.maximum(np.broadcast_to(sensor, len(C)), 0))
    states, noisy = _start(A, C, noise, sensor), sensor > 0
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


def _start(A: Matrix, C: Matrix, noise: Vector, sensor: Vector) -> Vector:
    """Units of the states for which most of the entries are near 1, on a log scale.

    With u, v the logarithms of the units of states and outputs, the sum of
    (log A_ij + u_j - u_i)^2, (log C_ij + u_j - v_i)^2, (log noise_i - u_i)^2 and
    (log sensor_i - v_i)^2 over all that are not zero is least.  (A. R. Curtis and
    J. K. Reid, J. Inst. Math. Appl. 10 (1972) 118-124.)  So units that no balance
    decides, as of parts that only meet in an output, do not come from the user's.
    """
    n, p = len(A), len(C)
    sizes = np.zeros((n + p, n + p + 1))  # last, what a node has by itself
    sizes[:n, :n], sizes[n:, :n], sizes[:, -1] = A, C, np.r_[noise, sensor]
    logs = np.log2(sizes, out=np.zeros_like(sizes), where=sizes > 0)
    links, between = sizes > 0, logs[:, :-1]
    graph = links[:, :-1] + links[:, :-1].T.astype(float)
    degrees = links.sum(axis=1) + links[:, :-1].sum(axis=0)
    pull = logs.sum(axis=1) - between.sum(axis=0)
    found = np.linalg.pinv(np.diag(degrees) - graph, hermitian=True) @ pull
    parts, of = connected_components(graph, directed=False)
    for part in range(parts):
        if not links[of == part, -1].any():  # without a size of its own: as its first
            found[of == part] -= found[of == part][0]
    return 2.0 ** np.round(found[:n] - TIE)


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
    return np.power(2.0, np.round(np.log2(size) - TIE))
