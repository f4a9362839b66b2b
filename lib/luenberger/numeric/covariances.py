"""What is a covariance: judged in the units of each row."""

import numpy as np

from . import Matrix
from .validation import freeze, matrix

ASYMMETRY_TOL = 1e-9  # of X at unit diagonal: below it is rounding, above a mistake
INDEFINITE_TOL = 1e-9  # a negative eigenvalue below this (unit diagonal) is rounding


def covariance(name: str, value: object, size: int, steps: bool = False) -> Matrix:
    """Return `value` as a read-only covariance matrix: symmetric, semi-definite.

    Entry (i, j) is judged beside sqrt(d_i d_j), d the diagonal, so the units of the
    rows play no part.  What is rounding there, of an asymmetry or of an eigenvalue
    below zero, is repaired or accepted; more is refused with its size.
    """
    array = np.array(matrix(name, value, size, size, steps))
    unit = _units(name, array)
    with np.errstate(over="ignore"):  # of entries near the largest float
        skew = np.abs(_at_units(array - array.mT, unit))
    wrong = skew > ASYMMETRY_TOL
    if wrong.any():
        *step, i, j = np.argwhere(wrong)[0].tolist()
        one, two, first, second = (
            f"{name}{[*step, *pair]}" for pair in ((i, j), (j, i), (i, i), (j, j))
        )
        raise ValueError(
            f"{name} must be symmetric: {one} is {array[*step, i, j]:.6g} and {two} is "
            f"{array[*step, j, i]:.6g}, which differ by {skew[*step, i, j]:.1e} of "
            f"sqrt({first} {second}). Pass ({name} + {name}') / 2 if that is what is "
            "meant."
        )
    mean = 0.5 * array + 0.5 * array.mT  # their sum could overflow
    array = np.where(array == array.mT, array, mean)
    require_semidefinite(name, array)
    return freeze(array)


def require_semidefinite(name: str, array: Matrix) -> None:
    """Raise unless the symmetric `array` (or each of a stack) has no negative mode.

    The test is made at unit diagonal, so units do not hide a small bad block.
    """
    if array.size == 0:
        return
    scaled = _at_units(array, _units(name, array))
    finite = np.isfinite(scaled).all(axis=(-2, -1))  # entries of covariances are <= 1
    values, vectors = np.linalg.eigh(np.where(finite[..., None, None], scaled, 0))
    least = np.where(finite, values[..., 0], -np.inf)
    if (least < -INDEFINITE_TOL).any():
        step = np.unravel_index(np.argmin(least), least.shape)
        parts = vectors[step][:, 0] if finite[step] else scaled[step].max(axis=-1)
        where = f"{name}{list(map(int, step)) or ''}"
        raise ValueError(
            f"{name} must be positive semi-definite: scaled to unit diagonal it has "
            f"the eigenvalue {least[step]:.3g}, most of it in row "
            f"{np.argmax(np.abs(parts))} of {where}. No noise has this covariance; "
            "check signs and off-diagonal entries."
        )


def _units(name: str, array: Matrix) -> Matrix:
    """The roots of the diagonal, 1 for a zero; ValueError where there can be none.

    Nothing has a negative variance, however small, and what has none varies with
    nothing: there is no unit in which such an entry would be rounding.
    """
    diagonal = np.diagonal(array, axis1=-2, axis2=-1)
    if (diagonal < 0).any():
        *step, i = np.argwhere(diagonal < 0)[0].tolist()
        raise ValueError(
            f"{name} must be positive semi-definite: {name}{[*step, i, i]} on its "
            f"diagonal is {diagonal[*step, i]:.6g}; write 0 there, and in its row and "
            "column, if that is rounding."
        )
    still = (diagonal[..., :, None] == 0) | (diagonal[..., None, :] == 0)
    wrong = still & (array != 0)
    if wrong.any():
        *step, i, j = np.argwhere(wrong)[0].tolist()
        k = i if diagonal[*step, i] == 0 else j
        raise ValueError(
            f"{name} must be positive semi-definite: {name}{[*step, k, k]} is 0, but "
            f"{name}{[*step, i, j]} in its row or column is {array[*step, i, j]:.6g}. "
            "What has no variance varies with nothing; write 0 there."
        )
    return np.sqrt(np.where(diagonal > 0, diagonal, 1.0))


def _at_units(array: Matrix, unit: Matrix) -> Matrix:
    """`array` with row and column i divided by unit i."""
    with np.errstate(over="ignore"):
        return array / unit[..., :, None] / unit[..., None, :]
