"""What an error is measured beside: what a Kalman filter leaves of it, or a scale.

Variances of states in unlike units cannot be added.  So each standard deviation is
divided by the one that the Kalman filter leaves of the same state, or by a size that
the user gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..numeric import Matrix, Vector
from ..numeric.linalg import ROUNDING
from ..numeric.validation import vector
from ..papers.leondes_novak.design import kalman_filter
from ..plant import Plant
from .attempts import KALMAN, Attempt, noisy
from .measure import steady_covariance

if TYPE_CHECKING:
    from .question import Question


@dataclass(frozen=True, eq=False)
class Judge:
    """What the error of each state, or of each row of k x, is measured beside.

    Attributes
    ----------
    least : (q,) ndarray
        Variances that the Kalman filter leaves, or the least of the designs where
        there is no Kalman filter.
    floor : (q,) ndarray
        Variances below are rounding, and count as zero: 1e-14 of what may not be known
        before a measurement, of which the Kalman filter takes the difference.
    beside : str
        Whose variances `least` are.
    scale : (q,) ndarray or None
        Typical sizes of the states, if the user gave them.
    """

    least: np.ndarray
    floor: np.ndarray
    beside: str = KALMAN
    scale: np.ndarray | None = None

    def ratios(self, variances: Vector) -> Vector:
        """Standard deviations over the least; 1 where both are zero.

        Examples
        --------
        >>> judge = Judge(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1e-9, 1e-9]))
        >>> judge.ratios(np.array([4.0, 1e-12, 1.0]))
        array([ 2.,  1., inf])
        """
        left, least = (np.where(v > self.floor, v, 0) for v in (variances, self.least))
        found = np.where(left > 0, np.inf, 1.0)
        return np.sqrt(np.divide(left, least, out=found, where=least > 0))

    def error(self, variances: Vector) -> float:
        """The largest of `ratios`; with a scale the root mean square in its units."""
        if self.scale is None:
            return float(self.ratios(variances).max(initial=1.0))
        parts = np.sqrt(variances) / self.scale
        return float(np.linalg.norm(parts) / np.sqrt(max(len(parts), 1)))


def judged(
    asked: Question, attempts: Sequence[Attempt], scale: Vector | None
) -> tuple[Attempt, ...]:
    """The attempts, each with what its error is measured beside."""
    known = [one.judged for one in attempts if one.judged is not None]
    if not known:
        return tuple(attempts)
    kalman, k = own_kalman(asked, attempts), asked.k
    if kalman is None:
        least = np.min(known, axis=0)
        judge = Judge(least, np.zeros_like(least), "most accurate design", scale)
    else:
        rows = np.eye(asked.plant.n) if k is None else k
        judge = beside_kalman(asked.additive, kalman, rows, scale)
    return tuple(replace(one, judge=judge) for one in attempts)


def beside_kalman(
    plant: Plant, kalman: Matrix, rows: Matrix, scale: Vector | None
) -> Judge:
    """The judge of rows of the state, of a plant whose Kalman filter leaves `kalman`.

    The plant's noises are additive.
    """
    known = np.sqrt(np.maximum(kalman.diagonal(), 0))
    before = np.hypot(np.abs(plant.A) @ known, np.sqrt(plant.Q.diagonal()))
    size = (np.abs(rows) @ before) ** 2  # at most, however they are correlated
    least = np.maximum(_diagonal(rows, kalman), 0)
    return Judge(least, ROUNDING * size, scale=scale)


def _diagonal(rows: Matrix, X: Matrix) -> Vector:
    return (rows @ X @ rows.T).diagonal()


def own_kalman(asked: Question, attempts: Sequence[Attempt]) -> Matrix | None:
    """The Kalman filter's covariance, of the table or designed for it."""
    for one in attempts:
        if one.method == KALMAN and one.covariance is not None and one.whole:
            return one.covariance
    if not noisy(asked.plant):
        return None
    try:
        return steady_covariance(kalman_filter(asked.additive), asked.plant)
    except ValueError:  # there is none
        return None


def sizes(scale: ArrayLike | None, count: int) -> Vector | None:
    """`scale` as positive numbers, one for each state or row of k x.

    Examples
    --------
    >>> sizes(2.0, 3)
    array([2., 2., 2.])
    """
    if scale is None:
        return None
    given = np.broadcast_to(scale, count) if np.ndim(scale) == 0 else scale
    found = vector("scale", given, count)
    if not (found > 0).all():
        raise ValueError(
            f"scale has typical sizes of the {count} numbers that are judged, so all "
            f"are positive, got {found.tolist()}"
        )
    return found
