"""Sums of the sizes of all powers of a matrix, with a certificate and no limit.

Powers are computed one after the other until one of them is small.  What rounding did
to them, and all that follow, is in a bound that refers to itself and is proved by
trying: export/derivation/rounding.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import matrix_balance

from . import Matrix
from .factors import EPS

SMALL = 1e-6  # of the last power, in even units
SLACK = 1e-8  # more than all roundings of sums without a minus sign
DOUBLINGS = 40  # of how often a bound refers to itself
MOST = 50_000  # powers that are computed


class PowerSums(NamedTuple):
    """Bounds entry by entry; k = 0, 1, 2 and so on without an end.

    Attributes
    ----------
    sums : (r, c) ndarray
        At least the sum of ``|F^k B|``.
    seen : (q, c) ndarray
        At least the sum of ``|P F^k B|``.
    peaks, seen_peaks : (r, d), (q, d) ndarray
        At least the largest ``|F^k X|`` and ``|P F^k X|``.
    """

    sums: np.ndarray
    seen: np.ndarray
    peaks: np.ndarray
    seen_peaks: np.ndarray


def power_sums(F: Matrix, P: Matrix, B: Matrix, X: Matrix) -> PowerSums | None:
    """Bounds for every power of F at once; None where none was proved.

    Parameters
    ----------
    F : (r, r) ndarray
    P : (q, r) ndarray
    B : (r, c) ndarray
    X : (r, d) ndarray
    """
    r, c = len(F), B.shape[1]
    left, right = np.vstack([np.eye(r), P]), np.hstack([B, X])
    with np.errstate(over="ignore", invalid="ignore"):
        found = _computed(F, left, right, c)
        if found is None:
            return None
        whole, power, rounds = found
        T = (np.abs(left @ power) + np.abs(left) @ rounds) * (1 + SLACK)
        inner = proved(T[:r], whole[:r])
    if inner is None:
        return None
    outer = (whole[r:] + T[r:] @ inner) * (1 + SLACK)
    return PowerSums(inner[:, :c], outer[:, :c], inner[:, c:], outer[:, c:])


def _computed(
    F: Matrix, left: Matrix, right: Matrix, c: int
) -> tuple[Matrix, Matrix, Matrix] | None:
    """Of the powers that are computed: sizes; the last one; sizes of all roundings.

    Sizes are added up in the first `c` columns, in the others the largest is kept.
    """
    even = matrix_balance(F, permute=False, separate=True)[1][0] if len(F) else F[0:0]
    power, sizes = np.eye(len(F)), np.zeros_like(F)
    whole = np.zeros((len(left), right.shape[1]))
    for k in range(MOST):
        size = np.abs(power)
        if k and (size / even[:, None] * even).sum(axis=1).max(initial=0) <= SMALL:
            break
        now = np.abs(left @ power @ right)
        whole[:, :c] += now[:, :c]
        whole[:, c:] = np.maximum(whole[:, c:], now[:, c:])
        sizes += size
        power = power @ F
        if not np.isfinite(power).all():
            return None
    part = 2 * (len(F) + 2) * EPS
    off = part * np.abs(left) @ sizes @ np.abs(right)
    return whole + off, power, part * (sizes @ np.abs(F) + np.abs(power))


def proved(T: Matrix, b: Matrix) -> Matrix | None:
    """An x that is at least b + T x, entry by entry, or None where none was found.

    No entry of T and b is negative.  x adds up what powers of T make of b, a little
    more, and is tried.
    """
    x, power = b, T
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(DOUBLINGS):
            x, power = x + power @ x, power @ power
            if not np.isfinite(x).all():
                return None
        x = x * (1 + SLACK)
        return x if (x >= (b + T @ x) * (1 + SLACK / 16)).all() else None
