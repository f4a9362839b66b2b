"""Which outputs of a record arrived, and rows in which they are the same."""

from collections.abc import Iterator

import numpy as np

from ..numeric import Matrix, Vector
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


def patterns(seen: Matrix) -> tuple[Vector, Vector]:
    """Of rows (N, p) of bools: the first of each kind, and the kind of each row."""
    bits = np.packbits(seen, axis=1)
    bits = bits.view(f"S{bits.shape[1]}")[:, 0]
    _, first, now = np.unique(bits, return_index=True, return_inverse=True)
    return first, now


def alike(seen: Matrix) -> Iterator[Vector]:
    """The numbers of the rows (N, p) of each kind, the first one first."""
    first, now = patterns(seen)
    order = np.argsort(now, kind="stable")
    yield from np.split(order, np.cumsum(np.bincount(now, minlength=len(first)))[:-1])
