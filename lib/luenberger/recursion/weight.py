"""The weights of a trace: what is given, and what the coordinates of (19) imply."""

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..numeric.linalg import RANK_TOL

DEFINITE = 1e-14  # least eigenvalue of a weight at unit diagonal


def positive_weight(weight: ArrayLike, n: int) -> Matrix:
    """The weight, if positive definite: at unit diagonal, whatever the units."""
    weight = covariance("weight", weight, n)
    least = _least(weight)
    if not least > DEFINITE:
        raise DesignError(
            "weight must be positive definite: scaled to unit diagonal its least "
            f"eigenvalue is {least:.3g}"
        )
    return weight


def definite(weight: Matrix) -> bool:
    """Whether `positive_weight` takes it."""
    return _least(weight) > DEFINITE


def _least(weight: Matrix) -> float:
    """The least eigenvalue at unit diagonal, 0 with a zero on the diagonal."""
    unit = np.sqrt(weight.diagonal())
    if not min(unit, default=0.0) > 0:
        return 0.0
    return float(np.linalg.eigvalsh(weight / unit[:, None] / unit)[0])


def canonical_weight(C: Matrix) -> Matrix:
    """The weight that the paper's transformation (19) implies: M'M, M = [C; rows].

    The rows that complete M are rows of the identity chosen by pivoted QR.
    """
    p, n = C.shape
    _, upper, pivots = scipy.linalg.qr(C, mode="economic", pivoting=True)
    diagonal = np.abs(np.diagonal(upper))
    if p > n or (p and diagonal[-1] <= RANK_TOL * diagonal[0]):
        raise DesignError(
            "weight='canonical' needs outputs that are linearly independent, as (19) "
            "does. Leave out the redundant ones, or use the default weight."
        )
    M = np.vstack([C, np.eye(n)[np.sort(pivots[p:])]])
    return M.T @ M
