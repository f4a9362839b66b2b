"""What a search makes least: minus the likelihood of records, for each reading."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from ..errors import CertificateError, DesignError
from ..numeric import Matrix, Vector
from ..plant import Plant
from .likelihood import log_likelihood
from .records import Records
from .search import curvature
from .unknowns import Unknowns, along

ROWS = 500  # of all records, for which a search of many passes pays for compiling


def backend_for(data: Records) -> str:
    """Compiled code where there is some and the passes of a search pay for it."""
    enough = sum(len(y) for y, _ in data) >= ROWS and find_spec("numba") is not None
    return "numba" if enough else "numpy"


def of_records(plant: Plant, data: Records) -> float:
    """The logarithm of the likelihood of all records."""
    ys, us = [y for y, _ in data], [u for _, u in data]
    return float(log_likelihood(plant, ys, us, backend=backend_for(data)))


def readings(data: Records) -> int:
    """How many numbers were measured."""
    return sum(int((~np.isnan(y)).sum()) for y, _ in data)


def per_reading(
    unknowns: Unknowns, data: Records
) -> Callable[[Vector], tuple[float, Vector]]:
    """The objective of a search, and its slope; infinite where there is none."""
    ys, us = [y for y, _ in data], [u for _, u in data]
    count, backend = readings(data), backend_for(data)

    def value(theta: Vector) -> tuple[float, Vector]:
        try:
            with np.errstate(all="ignore"):
                one, slope = log_likelihood(
                    unknowns.plant(theta),
                    ys,
                    us,
                    gradient=True,
                    backend=backend,
                )
                slopes = [along(slope, X) for X in unknowns.slopes(theta)]
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            return np.inf, np.zeros(len(theta))
        if not np.isfinite(one) or not np.isfinite(slopes).all():
            return np.inf, np.zeros(len(theta))
        return -one / count, -np.array(slopes) / count

    return value


def information(unknowns: Unknowns, theta: Vector, data: Records) -> Matrix:
    """The information of the records on the vector: the curvature at the best."""
    return curvature(per_reading(unknowns, data), theta) * readings(data)
