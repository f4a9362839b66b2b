"""Which outputs of a record arrived."""

from __future__ import annotations

import numpy as np

from ..numeric import Matrix
from ..numeric.linalg import finite


def arrived(y: Matrix) -> Matrix:
    """Which outputs arrived, (N, p) bools; one row for all, where all did."""
    if finite(y):
        return np.broadcast_to(np.ones(y.shape[1], dtype=bool), y.shape)
    seen = np.isnan(y)
    return np.logical_not(seen, out=seen)  # the first touch of new memory costs most


def every(seen: Matrix) -> bool:
    """Whether all outputs `arrived` in all rows."""
    return bool((seen if seen.strides[0] else seen[:1]).all())
