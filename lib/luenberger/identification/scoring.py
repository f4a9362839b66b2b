"""Steps of Fisher's scoring, with which a search begins where there are gaps.

Without stretches that are complete, autocovariances tell little of the noises.  The
expected information of some rows is close to the curvature of the likelihood, and a
step by it, in the variances themselves, leaves a variance that is far too small.
"""

from __future__ import annotations

import numpy as np

from ..errors import CertificateError, DesignError
from ..numeric import Matrix, Vector
from .forms import Along, Form, Full, Of
from .information import information
from .objective import backend_for, readings
from .records import Records
from .search import Objective, upward
from .unknowns import Unknowns

ROWS = 1000  # of all records, whose information stands for that of all
STEPS = 12
HALVES = 4  # of a step, before the search goes on in another way
NEAR = 1e-3  # what one more step would gain, in the logarithm of the likelihood
LOWER, UPPER = 1e-2, 1e8  # of a variance, in one step
LONGEST = 10.0  # deviation of a logarithm; a variance at its bound has a larger one
APART = 1e-9  # of a unit: a floor that moves nothing


def scored(
    unknowns: Unknowns, objective: Objective, theta: Vector, data: Records
) -> tuple[Vector, Matrix | None]:
    """A vector near the most likely one, and the inverse of the curvature there.

    The inverse is None where the information is not to be had.
    """
    count, part = readings(data), first_rows(data)
    value, slope = objective(theta)
    inverse: Matrix | None = None
    bounded = _bounded(unknowns)
    for _ in range(STEPS):
        try:
            H = _curvature(unknowns, theta, part)
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            return theta, None
        inverse = _short(upward(H) / count) * count
        step = _step(H, slope, bounded)
        if not -(slope @ step) * count > NEAR:
            break
        for k in range(HALVES):
            try:
                tried = moved(unknowns, theta, step / 2**k)
            except np.linalg.LinAlgError:  # too far for the digits of a covariance
                continue
            found, its_slope = objective(tried)
            if found < value:
                break
        else:
            break
        theta, value, slope = tried, found, its_slope
    return theta, inverse


def first_rows(data: Records) -> Records:
    """The first rows of each record, `ROWS` of them together at most."""
    each = max(ROWS // len(data), 1)
    return [(y[:each], u[:each]) for y, u in data]


def _curvature(unknowns: Unknowns, theta: Vector, part: Records) -> Matrix:
    """The expected information of each reading."""
    ys, us = [y for y, _ in part], [u for _, u in part]
    ways, plant = unknowns.slopes(theta), unknowns.plant(theta)
    found = information(plant, ys, us, along=ways, backend=backend_for(part))
    return found / readings(part)


def _step(H: Matrix, slope: Vector, bounded: Vector) -> Vector:
    """The step to where a square is least, no variance falling below a part of it."""
    step, free = np.zeros(len(slope)), np.ones(len(slope), dtype=bool)
    for _ in range(len(slope)):
        pull = slope[free] + H[np.ix_(free, ~free)] @ step[~free]
        step[free] = -upward(H[np.ix_(free, free)]) @ pull
        low = free & bounded & (1 + 2 * step < LOWER)
        if not low.any():
            break
        step[low], free = (LOWER - 1) / 2, free & ~low
    return step


def _bounded(unknowns: Unknowns) -> Vector:
    """Which entries are logarithms of variances."""
    found = np.zeros(unknowns.count, dtype=bool)
    q, r = unknowns.Q.count, unknowns.Q.count + unknowns.R.count
    found[:q] = isinstance(unknowns.Q, Along | Of)
    found[q:r] = isinstance(unknowns.R, Along | Of)
    return found


def _short(spread: Matrix) -> Matrix:
    """A covariance without steps to variances of nothing."""
    size = np.sqrt(np.maximum(spread.diagonal(), 0))
    step = 1 / np.maximum(size / LONGEST, 1)
    return spread * step * step[:, None]


def moved(unknowns: Unknowns, theta: Vector, step: Vector) -> Vector:
    """The vector after a step, which is one of variances and parameters themselves."""
    q, r = unknowns.Q.count, unknowns.Q.count + unknowns.R.count
    here = slice(0, q), slice(q, r)
    parts = [
        _moved(form, theta[at], step[at])
        for form, at in zip((unknowns.Q, unknowns.R), here)
    ]
    return np.concatenate([*parts, theta[r:] + step[r:]])


def _moved(form: Form, theta: Vector, step: Vector) -> Vector:
    if isinstance(form, Along | Of):
        return theta + 0.5 * np.log(np.clip(1 + 2 * step, LOWER, UPPER))
    if not isinstance(form, Full):
        return theta + step
    X, unit = form.matrix(theta), form.scale
    half = np.linalg.cholesky(X / unit / unit[:, None])
    more = np.tensordot(step, form.slopes(theta), 1) / unit / unit[:, None]
    share = np.linalg.solve(half, np.linalg.solve(half, more).T)
    values, vectors = np.linalg.eigh(share)
    side = half @ vectors * np.sqrt(np.clip(1 + values, LOWER, UPPER))
    side = unit[:, None] * side
    return form.at(side @ side.T, APART * unit)
