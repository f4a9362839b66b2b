"""Rows of a record in which the same outputs arrived."""

from collections.abc import Iterator

import numpy as np

from ..numeric import Matrix, Vector


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
