"""Matrices as compiled code takes them."""

import numpy as np

from ..numeric import Matrix
from .recursion import Loop

START = ("start", "stop", "now", "before", "good", "keep")


def entries_known(zero: Matrix, one: Matrix) -> tuple[tuple[float | None, ...], ...]:
    """A table of 0.0, 1.0 and None (read at run time), from two boolean matrices."""
    table = np.full(zero.shape, None)
    table[one], table[zero] = 1.0, 0.0
    return tuple(map(tuple, table.tolist()))


def plain_array(X: Matrix) -> Matrix:
    """X as compiled code takes it: floats by rows, without gaps, and writable."""
    plain = X.flags.c_contiguous and X.flags.writeable and X.dtype == float
    return X if plain else X.astype(float, order="C")


def arguments(loop: Loop) -> dict[str, str]:
    """Names of the arguments of `run`, in order, and the numba type of each."""
    types = dict(zip(START, ("i8", "i8", "i8[::1]", "i8[::1]", "b1[::1]", "b1")))
    if loop.recursion.backward:
        types = {"last": "i8", "start": "i8", "stop": "i8", "keep": "b1"}
    if loop.recursion.fresh:
        types["fresh"] = "b1[::1]"
    for array, _ in loop.rows.values():
        types[array] = "f8[:,::1]"
    for name in loop.matrices:
        types[name] = "f8[:,::1]"
    for name in loop.carried.values():
        types[name] = "f8[::1]"
    for array, *_ in loop.recursion.written:
        types[array] = "f8[:,::1]"
    return types
