"""Innovations of a record in units of their covariance."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import kernels
from ..arguments import expect
from ..numeric import Matrix
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.state import start
from . import diffuse
from .likelihood import _record
from .predictions import trail_of


def innovations(
    plant: Plant, y: Any, u: Any = None, *, backend: str = "auto"
) -> Matrix:
    """What each measurement adds to those before it, in units of its covariance.

    If the plant is right, with its Q and R, they are uncorrelated and of variance one:
    `whiteness` tests that.  Those of one instant are whitened in the order of the
    outputs, by the triangle of Cholesky.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q and R; without P0 the start is unknown.
    y, u
        One record, as in `filter_data`.
    backend : "auto", "numpy" or "numba"
        As in `filter_data`.

    Returns
    -------
    (N, p) ndarray
        NaN where nothing was measured, where the readings before determine it, and
        before they determine the state.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[3]])
    >>> lb.innovations(plant, [[2], [float("nan")]])
    array([[ 1.],
           [nan]])
    """
    expect(plant=plant)
    unknown = plant.P0 is None
    settings = Settings(plant, 0)
    y, u, u0 = _record(plant, y, u, None)
    first, state = 0, None if unknown else start(settings, plant.x0, u0)
    if state is None:
        head = diffuse.head(settings, y, u)
        first, state = len(head.trail.free), head.state
    fast = kernels.runs_compiled(backend, len(y))
    trail = trail_of(settings, state, y[first:], u[first:], fast, False)
    found = np.full(y.shape, np.nan)
    triangle = np.linalg.cholesky(trail.M)
    white = np.linalg.solve(triangle, trail.innovations[:, :, None])[:, :, 0]
    found[first:] = np.where(trail.free, white, np.nan)
    return found
