"""Matrices as compiled code takes them."""

from ..numeric import Matrix


def entries_known(zero: Matrix, one: Matrix) -> tuple[tuple[float | None, ...], ...]:
    """A table of 0.0, 1.0 and None (read at run time), from two boolean matrices."""
    return tuple(
        tuple(0.0 if z else 1.0 if o else None for z, o in zip(*rows))
        for rows in zip(zero.tolist(), one.tolist())
    )


def plain_array(X: Matrix) -> Matrix:
    """X as compiled code takes it: floats by rows, without gaps, and writable."""
    plain = X.flags.c_contiguous and X.flags.writeable and X.dtype == float
    return X if plain else X.astype(float, order="C")
