"""Units in which the numbers of a plant are of like size.

A tolerance, or a norm, that compares numbers of several states or outputs means
nothing when one of them is in light years.  Units are powers of two: a change of them
does not round.
"""

from typing import Any, TypeVar

import numpy as np

from . import Matrix, Vector

SWEEPS = 50  # at most; a few are enough unless units differ along a long chain
LEAST = 1e-6  # a rate that explains less of the numbers (1 / n of one) is none
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
    exact output has no size of its own, and decides only what that leaves open.

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
    fit = _Fit(A, C, noise, sensor)
    states = 2.0 ** np.round(fit.units(fit.logs)[: len(A)] - TIE)
    A, C = np.abs(A - np.diag(A.diagonal())), np.abs(C)
    noise = np.broadcast_to(_deviation(noise), len(A))
    sensor = np.broadcast_to(_deviation(sensor), len(C))
    noisy = sensor > 0
    outer = _one_sided(A, noise > 0, (C[noisy] > 0).any(axis=0))
    inner = np.isin(np.arange(len(A)), outer, invert=True)

    def sides(i: Any) -> tuple[Any, Any]:
        """What moves state i (or states), and what it moves, of what is inside."""
        shown = (C[noisy][:, i].T / sizes(C[noisy], sensor[noisy], states)).T
        moved = (A[i] * states)[..., inner].max(axis=-1, initial=0)
        seen = (A[:, i].T / states)[..., inner].max(axis=-1, initial=0)
        return np.maximum(moved, noise[i]), np.maximum(seen, shown.max(0, initial=0))

    def even(i: Any) -> tuple[Any, Any]:
        """Whether they are even, and the unit in which they would be."""
        moved, seen = sides(i)
        found = power_of_two(np.sqrt(moved) / np.sqrt(seen))
        return (1 / EVEN <= found / states[i]) & (found / states[i] <= EVEN), found

    for _ in range(SWEEPS):
        if even(inner)[0].all():
            break
        for i in np.flatnonzero(inner):
            fine, found = even(i)
            if not fine:
                states[i] = found
    for i in reversed(outer):  # as they hang on those inside, or on the first of them
        moved, seen = sides(i)
        if moved or seen:
            both = (
                np.sqrt(moved) / np.sqrt(seen) if moved and seen else moved or 1 / seen
            )
            states[i] = power_of_two(both)
        inner[i] = True
    return states, sizes(C, sensor, states)


def _one_sided(A: Matrix, driven: Vector, shown: Vector) -> list[int]:
    """States that nothing moves, or that move nothing, then those left without, ...

    In no units does what moves them balance what they move, so they have no say in the
    units of others.
    """
    left, found = np.ones(len(A), dtype=bool), list[int]()
    while True:
        moved = driven | (A[:, left] > 0).any(axis=1)
        moves = shown | (A[left] > 0).any(axis=0)
        gone = left & ~(moved & moves)
        if not gone.any():
            return found
        left &= ~gone
        found += np.flatnonzero(gone).tolist()


def evened(M: Matrix) -> tuple[Matrix, Vector, Vector]:
    """M with its rows and columns in even units, and these: M / row[:, None] * column.

    Examples
    --------
    >>> evened(np.array([[2.0**20, -1], [1, 2.0**-20]]))[0]
    array([[ 1., -1.],
           [ 1.,  1.]])
    """
    column, row = balanced(np.zeros((M.shape[1],) * 2), M, 0, 0)
    return M / row[:, None] * column, row, column


def even_rate(
    A: Matrix, C: Matrix, dt: float, fastest: float, noise: Any = 0, sensor: Any = 0
) -> float:
    """The rate in 1/s whose inverse is the unit of time: 1 in discrete time.

    In continuous time the plant's own, or the `fastest` one that it has to meet.
    """
    rate = 0.0 if dt else max(time_unit(A, C, noise, sensor), fastest)
    return float(power_of_two(rate or 1.0))


def time_unit(
    A: Matrix, C: Matrix, noise: Vector | float = 0, sensor: Vector | float = 0
) -> float:
    """The rate in 1/s, a power of two, of x' = A x + w, y = C x + v; 0 if it has none.

    That for which most entries of A / rate and C, and noise and sensor, are near 1 in
    some units of states and outputs; see `_Fit`.  A chain of integrators has no rate:
    another unit of time is another unit of its states.

    Examples
    --------
    >>> time_unit(2.0**30 * np.array([[-1, 1], [0, -2]]), np.array([[1, 0]])) / 2**30
    1.0
    >>> time_unit(np.array([[0, 1e9], [0, 0]]), np.array([[1, 0]]))
    0.0
    """
    fit, n = _Fit(A, C, noise, sensor), len(A)
    powers = np.zeros_like(fit.logs)  # of the rate, in each number
    powers[:n, :n], powers[:n, -1], powers[n:, -1] = 1, 0.5, -0.5
    powers *= fit.links
    absorbed = fit.units(powers)
    free = (powers**2).sum() - fit.pull(powers) @ absorbed
    if free < LEAST:
        return 0.0
    log = ((powers * fit.logs).sum() - fit.pull(fit.logs) @ absorbed) / free
    return float(2.0 ** np.round(log - TIE))


class _Fit:
    """Units for which most of the numbers of a plant are near 1, on a log scale.

    With u, v the logarithms of the units of states and outputs, the sum of
    (log A_ij + u_j - u_i)^2, (log C_ij + u_j - v_i)^2, (log noise_i - u_i)^2 and
    (log sensor_i - v_i)^2 over all that are not zero is least.  (A. R. Curtis and
    J. K. Reid, J. Inst. Math. Appl. 10 (1972) 118-124.)  So units that no balance
    decides, as of parts that only meet in an output, do not come from the user's.
    """

    def __init__(
        self, A: Matrix, C: Matrix, noise: Vector | float, sensor: Vector | float
    ) -> None:
        n, p = len(A), len(C)
        found = np.zeros((n + p, n + p + 1))  # last, what a node has by itself
        found[:n, :n], found[n:, :n] = np.abs(A), np.abs(C)
        found[:n, -1], found[n:, -1] = _deviation(noise), _deviation(sensor)
        self.links = found > 0
        self.logs = np.log2(found, out=np.zeros_like(found), where=self.links)
        graph = self.links[:, :-1] + self.links[:, :-1].T.astype(float)
        degrees = self.links.sum(axis=1) + self.links[:, :-1].sum(axis=0)
        self.normal = np.diag(degrees) - graph
        self.anchor = np.full(n + p, -1)
        of = _first_of_part(graph)
        for first in np.unique(of):
            part = of == first
            if not self.links[part, -1].any():  # nothing has a size of its own
                self.anchor[part] = first
                self.normal += np.outer(part, part)

    def pull(self, logs: Matrix) -> Vector:
        """The right side of the normal equations."""
        return logs.sum(axis=1) - logs[:, :-1].sum(axis=0)

    def units(self, logs: Matrix) -> Vector:
        """Logarithms of the units; in a part without a size, beside its first."""
        found = np.linalg.solve(self.normal, self.pull(logs))
        return found - np.where(self.anchor < 0, 0.0, found[self.anchor])


def _first_of_part(graph: Matrix) -> Vector:
    """For each node, the first one that paths of the symmetric `graph` lead to."""
    reached, count = np.eye(len(graph)) + graph > 0, 0
    while (now := np.count_nonzero(reached)) > count:
        count, near = now, reached.astype(float)
        reached = near @ near > 0
    return np.asarray(reached.argmax(axis=1))


def _deviation(variance: Vector | float) -> Vector:
    return np.sqrt(np.maximum(variance, 0))


def sizes(C: Matrix, sensor: Vector | float, states: Vector | float) -> Vector:
    """Units of the outputs: the size of what |C| shows and of their deviation."""
    size = np.maximum((C * states).max(axis=1, initial=0), sensor)
    return power_of_two(np.where(size > 0, size, 1.0))


def power_of_two(size: Size) -> Size:
    """The power of two nearest to each of the positive numbers `size`."""
    return np.power(2.0, np.round(np.log2(size) - TIE))
