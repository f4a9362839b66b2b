"""The push of a gain towards accurate outputs, at many instants of a plant at once."""

from __future__ import annotations

import numpy as np

from ..numeric import Matrix, Vector
from ..numeric.right_inverses import right_inverses
from .settings import Settings
from .weight import canonical_weight


def change(settings: Settings) -> bool:
    """Whether pushes change with the instant where the same outputs arrive."""
    return len(settings.accurate) > 0 and settings.plant.C.ndim == 3


def pushes(settings: Settings, C: Matrix, seen: Vector, instants: Vector) -> Matrix:
    """The pushes (N, n, p_seen) at instants at which the outputs `seen` arrive.

    C (N, p_seen, n) has the rows of what arrived.  Accurate outputs that may depend on
    each other are left to `Settings.at`, which refuses those that do.
    """
    accurate = np.isin(np.flatnonzero(seen), settings.accurate)
    weight = settings.weight
    if isinstance(weight, str):
        weight = np.array([canonical_weight(one) for one in C])
    found = np.zeros(C.mT.shape)
    found[:, :, accurate], clear = right_inverses(C[:, accurate], weight)
    for k in np.flatnonzero(~clear):
        now = settings.at(int(instants[k]), None if seen.all() else seen)
        found[k] = now.Gamma
    return found
