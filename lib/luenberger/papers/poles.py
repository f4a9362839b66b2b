"""The poles that were asked for, checked and in order."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import DesignError
from ..numeric import Vector
from ..numeric.validation import entries
from ..plant import Plant

CONJUGATE_TOL = 1e-8  # two poles this close to conjugates are taken as a pair


def numbers(poles: ArrayLike) -> Vector:
    """The poles as complex numbers."""
    try:
        poles, _ = entries(poles, complex)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"poles must be a list of numbers: {error}") from None
    if poles.ndim != 1 or not np.isfinite(poles).all():
        raise ValueError(f"poles must be a list of finite numbers, got {poles}")
    return poles


def arranged(poles: ArrayLike, order: int, plant: Plant) -> tuple[Vector, Vector]:
    """The poles as complex numbers, and where a conjugate pair begins."""
    poles = numbers(poles)
    if len(poles) != order:
        raise DesignError(
            f"{len(poles)} poles are given, but the order n - rank C is {order} "
            f"(n = {plant.n}, rank C = {plant.n - order}). Give {order} poles."
        )
    pairs = np.zeros(order, dtype=bool)
    if plant.is_complex:
        return poles, pairs
    left, out = list(poles), []
    while left:
        pole = left.pop(0)
        out.append(pole)
        if pole.imag == 0:
            continue
        gaps = [abs(other - pole.conjugate()) for other in left]
        if not gaps or min(gaps) > CONJUGATE_TOL * abs(pole):
            raise DesignError(
                f"the plant is real, so the pole {pole:.6g} needs its conjugate "
                f"{pole.conjugate():.6g} among the poles; add it in place of another"
            )
        left.pop(int(np.argmin(gaps)))
        pairs[len(out) - 1] = True
        out.append(pole.conjugate())
    return np.array(out, dtype=complex), pairs
