"""What rounding does to an observer's estimates, found without a compiler.

A record passes through the observer twice, once with constants, readings and states
rounded to fewer bits.  What differs is rounding: for float that of its 24 bits, for
double that of 36 bits, which is still small, scaled to 53.  `export.rounding_error`
measures the compiled C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from ..run.estimate import plain
from ..run.simulate import simulate

Record = tuple[Matrix, Matrix]  # y and u

BITS = {"float": (24, 24), "double": (36, 53)}  # that are kept, and that a device has
ROWS = 500
SEED = 8


def records(observer: Observer, plant: Plant) -> list[Record]:
    """Simulated records of a plant: one that noise makes, and one that inputs make.

    A plant without noise gives white readings, as nothing is known of them.
    """
    rng = np.random.default_rng(SEED)
    u = rng.standard_normal((ROWS, plant.m))
    found: list[Record] = []
    if plant.Q is not None and plant.R is not None and (plant.Q.any() or plant.R.any()):
        run = simulate(plant, observer, ROWS - 1, seed=SEED)
        found.append((run.y, run.u))
    else:
        found.append((rng.standard_normal((ROWS, plant.p)), 0 * u))
    if plant.m:
        quiet = replace(plant, Q=None, R=None, S=None, P0=None, multiplicative=())
        run = simulate(quiet, observer, ROWS - 1, u=u)
        found.append((run.y, run.u))
    return found


@np.errstate(all="ignore")  # what grows with fewer bits has lost them all
def rounding(observer: Observer, known: Sequence[Record], dtype: str) -> Vector:
    """How far rounding moves each estimate, beside its size: root mean squares.

    The larger over the records.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.7]], [[]], [[0.3]], [[1]], [[0]], [[1]], [[1]], dt=1)
    >>> y = np.ones((9, 1))
    >>> bool(1e-9 < rounding(observer, [(y, np.zeros((9, 0)))], "float")[0] < 1e-6)
    True
    """
    found, (bits, device) = [np.zeros(len(observer.P))], BITS[dtype]

    def short(X: Matrix) -> Matrix:
        """X to so many bits (Veltkamp)."""
        scaled = X * (2.0 ** (53 - bits) + 1)
        return scaled - (scaled - X)

    constants: Any = {name: short(getattr(observer, name)) for name in "FGDPVW"}
    rounded = replace(observer, **constants)
    for y, u in known:
        exact = plain(observer, y, u)
        gap = _size(plain(rounded, short(y), short(u), short) - exact)
        part = np.divide(gap, _size(exact), out=np.zeros_like(gap), where=gap != 0)
        found.append(np.where(np.isfinite(part), part, np.inf))
    return 2.0 ** (bits - device) * np.max(found, axis=0)


def _size(X: Matrix) -> Vector:
    return np.sqrt((X**2).mean(axis=0))
