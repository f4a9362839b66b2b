"""The half plane of w and the disc of zeta = (1 + w) / (1 - w): polynomials in both.

In continuous time s = w, in discrete time z = zeta.  Coefficients are in ascending
order, one polynomial to a column.
"""

from math import comb

import numpy as np

from . import Matrix, Vector

ROUNDING = 1e-13  # a coefficient this small beside the largest is zero, in floats


def to_half_plane(basis: Matrix, discrete: bool) -> Matrix:
    """Coefficients in w of polynomials in s = w, or z = (1 + w) / (1 - w); exact."""
    if not discrete:
        return basis
    r = len(basis) - 1
    M = np.array([_product(r - j, j) for j in range(r + 1)], dtype=object).T
    return (M if basis.dtype == object else M.astype(float)) @ basis


def _product(minus: int, plus: int) -> Vector:
    """Coefficients of (1 - w)^minus (1 + w)^plus, as integers."""
    left = [(-1) ** i * comb(minus, i) for i in range(minus + 1)]
    return np.convolve(
        np.array(left, dtype=object),
        np.array([comb(plus, i) for i in range(plus + 1)], dtype=object),
    )


def to_disc(basis: Matrix, discrete: bool) -> Matrix:
    """Coefficients in zeta, up to a common factor."""
    r = len(basis) - 1
    if discrete:
        return basis
    # w = (zeta - 1) / (zeta + 1)
    M = [(-1) ** j * _product(j, r - j) for j in range(r + 1)]
    return np.array(M).astype(float).T @ basis


def radius(roots: Vector, discrete: bool) -> float:
    """Largest |zeta| of roots in s or z; infinite when s = 1 is one of them."""
    if discrete:
        return float(np.abs(roots).max(initial=0))
    with np.errstate(divide="ignore"):
        return float((np.abs(1 + roots) / np.abs(1 - roots)).max(initial=0))


def is_stable(beta: Vector, discrete: bool) -> bool:
    """Routh's test: exact for Fractions; in floats what is rounding is not stable."""
    h = to_half_plane(beta[:, None], discrete)[:, 0][::-1]
    h = h if h[0] > 0 else -h
    least = 0 if h.dtype == object else ROUNDING * np.abs(h).max()
    if not (h > least).all():
        return False
    while len(h) > 1:
        if not h[1] > 0:
            return False
        rest = h[1:].copy()
        rest[1:-1:2] -= h[0] / h[1] * h[3::2]
        h = rest
    return True
