"""Combinations of numbers, as users write them: a row, or several."""

from typing import Any

from . import Matrix
from .validation import as_array, matrix


def combinations(name: str, value: Any, n: int, field: type = float) -> Matrix:
    """Return combinations of n numbers as a matrix, a row for each of them.

    Examples
    --------
    >>> combinations("k", [1, 0, -1], 3)
    array([[ 1.,  0., -1.]])
    """
    try:
        given = as_array(value)
    except ValueError:  # NumPy's, of rows of unlike lengths
        raise ValueError(
            f"{name} must be rows of {n} numbers each; their lengths differ"
        ) from None
    if given.ndim and not len(given):
        raise ValueError(f"{name} has no rows; give at least one combination")
    rows = matrix(name, given[None] if given.ndim == 1 else given, None, n, field=field)
    return rows
