"""What is given as numbers, as arrays that were checked."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import short
from ..formats import dataframes
from ..numeric import Matrix, Vector
from ..numeric.linalg import finite
from ..numeric.validation import entries

Columns = tuple[int, Sequence[str] | None]  # how many, and their names


def arrays(
    y: Any, u: Any, outputs: Columns, inputs: Columns, missing: bool = False
) -> tuple[Matrix, Matrix]:
    """y (N, p) and u (N, m) of the same rows; u is zero where it is None.

    `outputs` and `inputs` are a count and the names, or None, of the columns.
    """
    (p, output_names), (m, input_names) = outputs, inputs
    if isinstance(u, (int, float)) and u == 0:
        u = np.zeros((len(y), m)) if m else None
    y, u = dataframes.arrays(y, u, output_names, input_names)
    y = rows("y", y, p, missing)
    u = np.zeros((len(y), m)) if u is None else rows("u", u, m)
    if len(u) != len(y):
        raise ValueError(f"y has {len(y)} rows but u has {len(u)}")
    return y, u


def rows(name: str, value: object, width: int, missing: bool = False) -> Matrix:
    """Return `value` as (N, width) floats, all finite; NaN only where `missing`."""
    array = real(name, value, "an array of numbers")
    if array.ndim == 1 and width == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{name} must be (N, {width}), got {array.shape}")
    if finite(array):
        return array
    if missing:
        infinite = np.isinf(array)
        if infinite.any():
            raise ValueError(
                f"{name} is infinite in row {int(np.argwhere(infinite)[0, 0])}"
            )
    elif not np.isfinite(array).all():
        raise ValueError(
            f"{name} has values that are missing or not finite, first in row "
            f"{int(np.argwhere(~np.isfinite(array))[0, 0])}; a Filter takes NaN in "
            "y as not measured"
        )
    return array


def single(name: str, value: object, size: int) -> Vector:
    """Return `value` as (size,) floats, all finite."""
    array = real(name, value, f"{size} finite numbers")
    if array.shape != (size,) or not np.isfinite(array).all():
        got = short(array.tolist())
        raise ValueError(f"{name} must be {size} finite numbers, got {got}")
    return array


def real(name: str, value: object, wanted: str) -> np.ndarray:
    """`value` as floats, NaN where it is missing."""
    if type(value) is np.ndarray and value.dtype == float:
        return value
    try:
        return entries(value, truth=True)[0]
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name} must be {wanted}: {error}") from None
