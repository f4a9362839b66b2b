"""The matrices of a plant at one instant."""

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix


class Instant(NamedTuple):
    """The plant's matrices at one instant, all two-dimensional."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    E: np.ndarray
    Q: np.ndarray | None
    R: np.ndarray | None
    S: np.ndarray | None

    def covariances(self) -> tuple[Matrix, ...]:
        """Q, R and S; zeros for those that are not given."""
        n, p = self.A.shape[0], self.C.shape[0]
        given = (self.Q, (n, n)), (self.R, (p, p)), (self.S, (n, p))
        return tuple(np.zeros(size) if X is None else X for X, size in given)
