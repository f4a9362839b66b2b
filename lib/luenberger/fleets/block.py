"""What is found in a block of records, and where it is written."""

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix, Vector
from ..recursion.settings import Settings
from ..recursion.state import History


class Block(NamedTuple):
    """What was found in a block of records, the record first.

    ``x`` and ``std`` are (M, N, n); ``P`` is (M, n, n) at the last row, or at every row
    (M, N, n, n) with K (M, N, n, p), which is None otherwise.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None

    @classmethod
    def empty(
        cls, settings: Settings, shape: tuple[int, ...], history: bool
    ) -> "Block":
        """Room for what is found in records of the shape (M, N, p)."""
        (M, N, p), n = shape, settings.plant.n
        rows = (N,) if history else ()
        K = np.empty((M, N, n, p)) if history else None
        x, std = np.empty((M, N, n)), np.empty((M, N, n))
        return cls(x, std, np.empty((M, *rows, n, n)), K)

    def put(self, which: Vector | int, found: History, last: Matrix) -> None:
        """Write what does not hang on measurements to one record, or to several."""
        self.std[which] = np.sqrt(np.maximum(found.variances, 0))
        self.P[which] = last if self.K is None else found.P
        if self.K is not None:
            self.K[which] = found.K
