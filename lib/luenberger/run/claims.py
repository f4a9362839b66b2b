"""What an error covariance claims of simulated errors: a pseudo-inverse."""

from typing import NamedTuple

import numpy as np

from ..analysis.error_system import error_system
from ..numeric import Matrix
from ..observer import Observer
from ..plant import Plant

SMALL = 1e-6  # of the numbers that meet in an error: the least unit of its deviation
TOL = 1e-12  # a variance in these units that counts as none: errors below are rounding
RULED_OUT = 8  # times as large as that: more than rounding


class Claim(NamedTuple):
    """An error covariance X at each instant, ready for e' X^+ e = |root e|^2."""

    root: np.ndarray  # (steps + 1, q, q), rows of zeros for directions without variance
    null: np.ndarray | None  # the same with rows N, |N e| <= 1 if e is rounding
    rank: np.ndarray  # (steps + 1,)


def claim(
    observer: Observer, plant: Plant, steps: int, X: Matrix | None = None
) -> Claim:
    """That of (steps + 1, q, q) covariances X; by default of the true ones.

    Each error is counted in its claimed deviation, or in `SMALL` of the deviation of
    its part of the state about zero, if that is more.  A combination of errors whose
    variance is then at most `TOL` is claimed to be rounding.
    """
    system = error_system(observer, plant, steps)
    X = system.over(steps) if X is None else X
    states = np.array([np.sqrt(M.diagonal()) for M in system.of_state(steps)])
    size = states[:, : plant.n] @ np.abs(observer.L).T
    deviations = np.sqrt(np.maximum(np.diagonal(X, axis1=1, axis2=2), 0))
    unit = np.maximum(deviations, SMALL * size)
    unit[unit == 0] = 1.0
    values, axes = np.linalg.eigh(X / unit[:, :, None] / unit[:, None])
    kept = values > TOL
    rows = axes.mT / unit[:, None] / np.sqrt(np.maximum(values, TOL))[..., None]
    null = np.where(kept[..., None], 0.0, rows)
    return Claim(rows - null, null if null.any() else None, kept.sum(axis=1))
