"""Directions in which a plant is moved, as stacks of changes of its matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import short
from ..numeric import Matrices, Matrix
from ..plant import Plant

OVER_TIME = ("A", "B", "C", "E", "Q", "R", "S")
SYMMETRIC = ("Q", "R", "P0")


@dataclass(frozen=True, eq=False)
class Ways:
    """The changes of every matrix in each of several directions.

    Attributes
    ----------
    changes : dict of str to ndarray
        "A", "B", "C", "E", "Q", "R", "S": (1, count, ., .), or with a row for each
        instant in place of the 1.
    dx0 : (count, n, 1) ndarray
    dP0 : (count, n, n) ndarray
    """

    changes: Matrices
    dx0: np.ndarray
    dP0: np.ndarray

    @property
    def count(self) -> int:
        """How many directions there are."""
        return len(self.dx0)

    @property
    def constant(self) -> bool:
        """Whether every change is the same at all instants."""
        return all(len(X) == 1 for X in self.changes.values())

    @property
    def moving(self) -> bool:
        """Whether A or C moves."""
        return bool(self.changes["A"].any() or self.changes["C"].any())

    @property
    def shifting(self) -> bool:
        """Whether the mean of a record moves."""
        inputs = self.changes["B"].any() or self.changes["E"].any()
        return self.moving or bool(inputs or self.dx0.any())

    def rows(self, first: int, count: int) -> Matrices:
        """The changes "dA", ... at some instants; one row where they are constant."""
        here = slice(first, first + count)
        return {
            f"d{name}": X if len(X) == 1 else X[here]
            for name, X in self.changes.items()
        }


def ways_of(plant: Plant, along: Sequence[Mapping[str, Any]]) -> Ways:
    """The directions that a caller names, checked.

    Raises
    ------
    ValueError
        If one is no dict of matrices of the plant, of their sizes, or a change of a
        covariance is not symmetric.
    """
    n, m, p = plant.n, plant.m, plant.p
    sizes = dict(A=(n, n), B=(n, m), C=(p, n), E=(p, m), Q=(n, n), R=(p, p), S=(n, p))
    vectors: dict[str, tuple[int, ...]] = dict(x0=(n,), P0=(n, n))
    read = [_checked(plant, k, way, sizes | vectors) for k, way in enumerate(along)]
    changes = {name: _stack(name, read, sizes[name]) for name in OVER_TIME}
    dx0 = np.array([way.get("x0", np.zeros(n)) for way in read]).reshape(-1, n, 1)
    dP0 = np.array([way.get("P0", np.zeros((n, n))) for way in read])
    return Ways(changes, dx0, dP0.reshape(-1, n, n))


def _checked(plant: Plant, k: int, way: Any, sizes: dict[str, Any]) -> Matrices:
    """One direction, as arrays."""
    if not isinstance(way, Mapping) or set(way) - set(sizes):
        raise ValueError(
            "each direction in `along` must be a dict of changes of the plant's "
            f"{', '.join(sizes)}, such as {{'Q': [[1.0]]}}; number {k} is {short(way)}"
        )
    read = {}
    for name, X in way.items():
        X = np.array(X, dtype=float)
        whole = (len(getattr(plant, name)),) if _varies(plant, name) else ()
        if X.shape not in (sizes[name], (*whole, *sizes[name])):
            raise ValueError(
                f"the change of {name} in direction {k} of `along` has shape {X.shape},"
                f" and {name} has {(*whole, *sizes[name])}"
            )
        if name == "P0" and plant.P0 is None:
            raise ValueError(
                f"direction {k} of `along` moves P0, and the plant has no P0: its "
                "start is not known"
            )
        if not np.isfinite(X).all():
            raise ValueError(f"the change of {name} in direction {k} is not finite")
        if name in SYMMETRIC and not np.array_equal(X, X.mT):
            raise ValueError(
                f"the change of {name} in direction {k} of `along` is not symmetric, "
                f"and {name} is; move an entry together with its mirror image"
            )
        read[name] = X
    return read


def _varies(plant: Plant, name: str) -> bool:
    """Whether a matrix of the plant has a row for each instant."""
    return name in OVER_TIME and np.ndim(getattr(plant, name)) == 3


def _stack(name: str, read: list[Matrices], size: tuple[int, int]) -> Matrix:
    """The changes of one matrix in all directions."""
    given = [way.get(name, np.zeros(size)) for way in read]
    long = max((len(X) for X in given if X.ndim == 3), default=1)
    found = np.zeros((long, len(read), *size))
    for k, X in enumerate(given):
        found[:, k] = X
    return found
