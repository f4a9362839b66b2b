"""What a search makes least: minus the likelihood of records, for each reading."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from ..errors import CertificateError, DesignError
from ..numeric import Matrices, Vector
from ..plant import Plant
from ..plant.instant import Instant
from .likelihood import _records, log_likelihood
from .likelihood_parts import row_by_row
from .records import Records
from .settled_record import Evaluator
from .unknowns import Unknowns, along

ROWS = 500  # of all records, for which a search of many passes pays for compiling


def backend_for(data: Records) -> str:
    """Compiled code where there is some and the passes of a search pay for it."""
    enough = sum(len(y) for y, _ in data) >= ROWS and find_spec("numba") is not None
    return "numba" if enough else "numpy"


def of_records(plant: Plant, data: Records) -> float:
    """The logarithm of the likelihood of all records."""
    backend, nothing = backend_for(data), np.zeros(plant.m)
    if plant.steps is None:
        settled = Evaluator([(y, u, nothing) for y, u in data], backend == "numba")
        found = settled(plant.at(0), None if plant.P0 is None else plant)
        if found is not None:
            return found[0]
    ys, us = [y for y, _ in data], [u for _, u in data]
    return float(log_likelihood(plant, ys, us, backend=backend))


def readings(data: Records) -> int:
    """How many numbers were measured."""
    return sum(int((~np.isnan(y)).sum()) for y, _ in data)


def per_reading(
    unknowns: Unknowns, data: Records
) -> Callable[[Vector], tuple[float, Vector]]:
    """The objective of a search, and its slope; infinite where there is none."""
    count, likelihood = readings(data), _Likelihood(unknowns, data)
    last: list[tuple[Vector, tuple[float, Vector]]] = []

    def again(theta: Vector) -> tuple[float, Vector]:
        if not last or not np.array_equal(last[0][0], theta):
            last[:] = [(theta.copy(), value(theta))]
        found, slope = last[0][1]
        return found, slope.copy()

    def value(theta: Vector) -> tuple[float, Vector]:
        try:
            with np.errstate(all="ignore"):
                one, slope = likelihood(theta)
                slopes = [along(slope, X) for X in unknowns.slopes(theta)]
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            return np.inf, np.zeros(len(theta))
        if not np.isfinite(one) or not np.isfinite(slopes).all():
            return np.inf, np.zeros(len(theta))
        return -one / count, -np.array(slopes) / count

    return again


class _Likelihood:
    """The likelihood of records and its gradients, at one vector after another."""

    def __init__(self, unknowns: Unknowns, data: Records) -> None:
        self.unknowns = unknowns
        ys, us = [y for y, _ in data], [u for _, u in data]
        self.records = [*_records(unknowns.parameters.template, ys, us, None)]
        self.fast = backend_for(data) == "numba"
        self.settled = Evaluator(self.records, self.fast)

    def __call__(self, theta: Vector) -> tuple[float, Matrices]:
        """From a settled filter where there is one, else row by row."""
        now, plant = self.unknowns.instant(theta), self.unknowns.parameters.template
        if now is None:
            plant = self.unknowns.plant(theta)
            now = plant.at(0)
        elif plant.P0 is not None:
            plant = self.unknowns.plant(theta)
        start = None if plant.P0 is None else plant
        there = () if start is None else ("x0", "P0")
        wanted = tuple(k for k in self.unknowns.moved if self._has(now, k, there))
        found = None
        if plant.steps is None:
            found = self.settled(now, start, wanted)
        if found is not None:
            return found
        plant = self.unknowns.plant(theta)
        return row_by_row(plant, self.records, self.fast, wanted)

    @staticmethod
    def _has(now: Instant, name: str, there: tuple[str, ...]) -> bool:
        return name in there or getattr(now, name, None) is not None
