"""Many records of one plant, filtered by `filter_data`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..fleets import filter_block
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.settings import Settings
from . import chunks
from .clock import Clock, of_record, require_instants


@dataclass(frozen=True, eq=False)
class FilteredFleet:
    """What `filter_data` returns of many records (M, N, p), the record first.

    Attributes
    ----------
    x, std : (M, N, n) ndarray
        Estimates of the state and their one-sigma errors, as in `Filtered`.
    P : (M, n, n) or (M, N, n, n) ndarray
        Error covariance at the last row; with ``history=True`` at every row.
    K : (M, N, n, p) ndarray or None
        Gains, with ``history=True``; the columns of missing outputs are zero.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        M, N, n = self.x.shape
        return f"<FilteredFleet: {M} records of {N} rows, {n} states>"


def filter_fleet(
    plant: Plant, y: Any, u: Any, time: Any, m1: Any, u0: Vector, weight: Any,
    history: bool, backend: str,
) -> FilteredFleet:  # fmt: skip
    """Filter records y (M, N, p) of one plant, all with the same instants."""
    values = chunks.real("y", y, "an array of numbers")
    M, N, p = values.shape
    if p != plant.p:
        raise ValueError(f"y must be (M, N, {plant.p}), got {values.shape}")
    rows = chunks.rows("y", values.reshape(M * N, p), p, missing=True)
    if plant.dt == 0:
        plant = of_record(plant, np.zeros((N, p)), time)
    else:
        Clock(plant, time).follow(np.zeros((N, p)))
    require_instants(plant, N)
    fast = kernels.runs_compiled(backend, N)
    settings = Settings(plant, m1, weight)
    inputs = _inputs(u, M, N, plant.m)
    found = filter_block(settings, rows.reshape(M, N, p), inputs, u0, fast, history)
    return FilteredFleet(*found)


def _inputs(u: Any, M: int, N: int, m: int) -> Matrix:
    """Inputs of every record (M, N, m), from (M, N, m), (N, m) for all, or none."""
    if u is None or (isinstance(u, int | float) and u == 0):
        return np.zeros((M, N, m))
    values = chunks.real("u", u, "an array of numbers")
    if values.shape not in ((M, N, m), (N, m)):
        raise ValueError(
            f"u must be ({M}, {N}, {m}), or ({N}, {m}) for all records, got "
            f"{values.shape}"
        )
    chunks.rows("u", values.reshape(-1, m) if m else np.zeros((0, 0)), m)
    return np.broadcast_to(values, (M, N, m))
