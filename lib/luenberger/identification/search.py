"""The search for the most likely values: minus the likelihood of records, by SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy  # its parts load when first used

from ..errors import CertificateError, DesignError
from ..filtering import likelihood
from ..filtering.pack import Passage
from ..filtering.unknown import units
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..run.filter import Filter
from ..run.record import Record
from .parameters import Unknowns, changed
from .records import Records

STEP = 1e-5  # of a parameter's scale, for its slope
BEND = 1e-3  # the same, for how the slope changes
SLOPE = 3e-7  # of the objective for each reading, at its end, in units of its curvature
DONE = 1e-13  # of the objective, that a step may gain at its end
REACH = 4.0  # logarithms of a deviation, or sizes of a parameter, in one round
ROUNDS = 12  # of search, each from where the last one ended
ENOUGH = 1e-10  # what a round has gained for each reading, that was the last one
FAR = 1e3  # of the objective, where there is no likelihood
FIRST = 64  # rows that have to tell a start
WIDE = 1e5  # of what they leave of it, as a variance
LEAST = 1e-3  # of an information for each reading: below it there is none to go by

Objective = Callable[[Vector], tuple[float, Vector]]  # value to be least, and slope
NONE = CertificateError, DesignError, np.linalg.LinAlgError  # where there is no value


class Likelihood:
    """The likelihood of records and its slope, at one vector after another.

    A start of which nothing is known is one of large variance here: 1e5 times what the
    first rows leave, about where they put it.  It moves the greatest value by 1e-5 of
    its errors, and the likelihood by a constant; exact ones take a hundred times as
    long for each row of the start.

    Attributes
    ----------
    count : int
        How many numbers were measured.
    """

    def __init__(self, unknowns: Unknowns, data: Records, theta: Vector) -> None:
        self.unknowns = unknowns
        plant = unknowns.parameters.template
        self.rows = data
        self.count = sum(int((~np.isnan(rows.y)).sum()) for rows in data)
        known = unknowns.plant(unknowns.noises(theta), plant)
        self.starts = [_wide(known, rows.y, rows.u) for rows in data]

    def plant(self, noises: Matrices, values: Vector, checked: bool = False) -> Plant:
        """The plant with these Q and R, and these values of parameters."""
        more = self.unknowns.parameters
        made = more.plant(values) if more.names else more.template
        return self.unknowns.plant(noises, made, checked)

    def passed(self, plant: Plant) -> list[tuple[list[Passage], Plant]]:
        """What a filter keeps of each record, and the plant as it starts."""
        plants = [changed(plant, **start) for start in self.starts]
        return [(Filter(one).passed(rows, "settled"), one)
                for rows, one in zip(self.rows, plants)]  # fmt: skip

    def of(self, noises: Matrices, values: Vector) -> float:
        """That of all records together."""
        found = self.passed(self.plant(noises, values))
        return sum(likelihood.value(*one) for one in found)

    def slope(
        self, noises: Matrices, values: Vector, ways: list[Matrices]
    ) -> tuple[float, Vector]:
        """It, and how fast it rises: along noises, and along the parameters' scales.

        For each number of Q and R `ways` has {"Q" or "R": how the covariance moves}.
        """
        found, slope = self.passed(self.plant(noises, values)), np.zeros(len(ways))
        for one in found if ways else ():
            score = likelihood.score(*one, joint=False)
            slope += [score.along(way) for way in ways]
        steps, more = STEP * np.diag(self.unknowns.parameters.scale), list[float]()
        for step in steps:
            up, down = (self.of(noises, values + s) for s in (step, -step))
            more.append((up - down) / (2 * STEP))
        total = sum(likelihood.value(*one) for one in found)
        return total, np.concatenate([slope, more])

    def per_reading(self, theta: Vector) -> tuple[float, Vector]:
        """The objective of a search, and its slope; infinite where there is none."""
        unknowns = self.unknowns
        try:
            with np.errstate(all="ignore"):
                given = unknowns.noises(theta), unknowns.split(theta)[2]
                one, slope = self.slope(*given, unknowns.ways(theta))
        except NONE:
            return np.inf, np.zeros(len(theta))
        if not np.isfinite(one) or not np.isfinite(slope).all():
            return np.inf, np.zeros(len(theta))
        return -one / self.count, -slope / self.count

    def information(self, theta: Vector, of_noises: Matrix) -> Matrix:
        """About how much a reading tells of each number of a vector.

        What it tells of the numbers of Q and R is given; of a parameter it is how the
        likelihood bends.
        """
        found, k = np.eye(len(theta)), len(of_noises)
        found[:k, :k] = of_noises
        noises, values = self.unknowns.noises(theta), self.unknowns.split(theta)[2]
        for j, step in enumerate(BEND * np.diag(self.unknowns.parameters.scale), k):
            try:
                there = [self.of(noises, values + s * step) for s in (-1, 0, 1)]
                bend = (2 * there[1] - there[0] - there[2]) / BEND**2 / self.count
            except NONE:
                bend = 0.0
            found[j, j] = max(bend, 1.0) if np.isfinite(bend) else 1.0
        return found


def _wide(plant: Plant, y: Matrix, u: Matrix) -> dict[str, Any]:
    """A start so wide that the record alone tells it, if its first rows do."""
    if plant.P0 is not None:
        return {}
    unit, rows = units(plant), slice(0, FIRST)
    widest = 1e6 * (np.nanmax(np.abs(y)) * unit) ** 2
    start = dict(at_first=True, x0=np.zeros(plant.n), P0=np.diag(widest))
    try:
        run = Filter(changed(plant, **start))
        found = run.smooth(Record(y[rows], u[rows], "rows"))
    except NONE:
        return {}
    told = found.std[0] ** 2
    if not (told < 1e-3 * widest).all():
        return {}
    told = told + 1e-4 * (told / unit**2).max() * unit**2
    return start | dict(x0=found.x[0], P0=np.diag(WIDE * told))


def least(
    objective: Objective, theta: Vector, information: Matrix,
    report: Callable[[int], object],
) -> Vector:  # fmt: skip
    """Where the objective is least, from a start.

    `information` is about its second derivatives; `report` is told how many times it
    was evaluated.  Where there is no value it is infinite.
    """
    sizes, vectors = np.linalg.eigh(information)
    unit = vectors / np.sqrt(np.maximum(sizes, LEAST))
    calls, best = 0, (np.inf, theta)

    def counted(move: Vector) -> tuple[float, Vector]:
        nonlocal calls, best
        calls += 1
        report(calls)
        at = begin + unit @ move
        value, slope = objective(at)
        if value < best[0]:
            best = value, at
        return value if np.isfinite(value) else best[0] + FAR, unit.T @ slope

    reach = REACH / np.abs(unit).max(axis=0, initial=0)
    options = dict(gtol=SLOPE, ftol=DONE, maxcor=30, maxiter=200)
    for _ in range(ROUNDS if len(theta) else 0):
        before, begin = best
        found = scipy.optimize.minimize(
            counted, np.zeros(len(theta)), jac=True, method="L-BFGS-B",
            bounds=np.transpose([-reach, reach]), options=options,
        )  # fmt: skip
        inside = (np.abs(found.x) < reach).all()
        if before - best[0] <= ENOUGH or (found.success and inside):
            break
    return best[1]
