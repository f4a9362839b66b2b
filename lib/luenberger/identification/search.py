"""The search for the most likely values: minus the likelihood of records, by SciPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy  # its parts load when first used

from ..errors import CertificateError, DesignError
from ..filtering import likelihood
from ..numeric import Matrices, Vector
from ..plant import Plant
from ..run.filter import Filter
from ..run.record import Record
from .records import Records
from .unknowns import Unknowns

STEP = 1e-5  # of a parameter's scale, for its slope
SLOPE = 1e-7  # of the objective for each reading, at its end
DONE = 1e-13  # of the objective, that a step may gain at its end
REACH = 2.0  # logarithms of a deviation, or sizes of a parameter, in one round
ROUNDS = 12  # of search, each from where the last one ended
ENOUGH = 1e-10  # what a round has gained for each reading, that was the last one
FAR = 1e3  # of the objective, where there is no likelihood

Objective = Callable[[Vector], tuple[float, Vector]]  # value to be least, and slope


class Likelihood:
    """The likelihood of records and its slope, at one vector after another.

    Attributes
    ----------
    count : int
        How many numbers were measured.
    """

    def __init__(self, unknowns: Unknowns, data: Records) -> None:
        self.unknowns = unknowns
        plant = unknowns.parameters.template
        self.rows = [Record(y, u, "rows").on(plant) for y, u in data]
        self.count = sum(int((~np.isnan(y)).sum()) for y, _ in data)

    def of(self, plant: Plant) -> float:
        """That of all records together, under a plant."""
        run = Filter(plant)
        each = (likelihood.value(run.passed(one, "values"), plant) for one in self.rows)
        return float(sum(each))

    def slope(
        self, plant: Plant, ways: list[Matrices], values: Vector
    ) -> tuple[float, Vector]:
        """The likelihood and how fast it rises: along noises, and parameters' scales.

        Parameters
        ----------
        plant : Plant
        ways : list of dict
            For each number of Q and R, {"Q" or "R": how the covariance moves}.
        values : (k,) ndarray
            Of the parameters, which this plant has.
        """
        run, value, slope = Filter(plant), 0.0, np.zeros(len(ways))
        for one in self.rows:
            passed = run.passed(one, "readings")
            value += likelihood.value(passed, plant)
            if ways:
                found = likelihood.score(passed, plant, joint=False)
                slope += [found.along(way) for way in ways]
        return value, np.concatenate([slope, self._moved(plant, values)])

    def _moved(self, plant: Plant, values: Vector) -> Vector:
        """How fast the likelihood rises along each parameter, by differences."""
        unknowns, found = self.unknowns, []
        Q, R, _ = plant.at(0).covariances()
        for step in np.diag(unknowns.parameters.scale * STEP):
            up, down = (
                self.of(unknowns.with_noise(Q, R, values + s)) for s in (step, -step)
            )
            found.append((up - down) / (2 * STEP))
        return np.array(found)

    def per_reading(self, theta: Vector) -> tuple[float, Vector]:
        """The objective of a search, and its slope; infinite where there is none."""
        unknowns = self.unknowns
        try:
            with np.errstate(all="ignore"):
                plant, (*_, values) = unknowns.plant(theta), unknowns.split(theta)
                one, slope = self.slope(plant, unknowns.slopes(theta), values)
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            return np.inf, np.zeros(len(theta))
        if not np.isfinite(one) or not np.isfinite(slope).all():
            return np.inf, np.zeros(len(theta))
        return -one / self.count, -slope / self.count


def least(
    objective: Objective, theta: Vector, report: Callable[[int], object]
) -> Vector:
    """Where the objective is least, from a start.

    Parameters
    ----------
    objective : callable
        The value, infinite where there is none, and the slope.
    theta : (k,) ndarray
    report : callable
        Is told how many evaluations were made.
    """
    calls, best = 0, (np.inf, theta)

    def counted(theta: Vector) -> tuple[float, Vector]:
        nonlocal calls, best
        calls += 1
        report(calls)
        found = objective(theta)
        if found[0] < best[0]:
            best = found[0], theta.copy()
        return found if np.isfinite(found[0]) else (best[0] + FAR, found[1])

    options = dict(gtol=SLOPE, ftol=DONE, maxcor=30, maxiter=200)
    for _ in range(ROUNDS if len(theta) else 0):
        before, begin = best[0], best[1]
        box = np.transpose([begin - REACH, begin + REACH])
        found = scipy.optimize.minimize(
            counted, begin, jac=True, method="L-BFGS-B", bounds=box, options=options
        )
        inside = np.abs(best[1] - begin).max() < REACH
        if before - best[0] <= ENOUGH or (found.success and inside):
            break
    return best[1]
