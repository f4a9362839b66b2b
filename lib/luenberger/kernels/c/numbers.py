"""Numbers as the types of C hold them: how long they are, and what their range is."""

import numpy as np
from numpy.typing import ArrayLike

BYTES = {"double": 8, "float": 4}


def require_c_type(name: str) -> None:
    """Raise ValueError unless this is the name of a type that C is written in."""
    if name not in BYTES:
        raise ValueError(f"dtype must be 'double' or 'float', got {name!r}")


def representable(name: str, array: ArrayLike, real: str) -> np.ndarray:
    """The array as numbers of the C type, or an error if they leave its range.

    An entry of a matrix may vanish only if it is rounding beside its row.
    """
    array = np.asarray(array, dtype=float)
    if real == "double":
        return array
    with np.errstate(over="ignore"):
        narrow = array.astype(np.float32).astype(float)
    if not np.isfinite(narrow).all():
        where = np.argwhere(~np.isfinite(narrow))[0].tolist()
        raise ValueError(
            f"{name}{where} is {array[tuple(where)]:.3g}, beyond the range of float; "
            "scale the units, or export double"
        )
    if array.ndim == 2:
        size, unit = np.abs(array), np.finfo(np.float32).eps / 2
        felt = size > unit * size.max(axis=1, initial=0, keepdims=True)
        lost = felt & (size < np.finfo(np.float32).tiny) & (size > 0)
        for where in np.argwhere(lost).tolist():
            raise ValueError(
                f"{name}{where} is {array[tuple(where)]:.3g}, too small for float, "
                "which has no digits for it; scale the units, or export double"
            )
        narrow = np.where(size < np.finfo(np.float32).tiny, 0.0, narrow)
    return narrow
