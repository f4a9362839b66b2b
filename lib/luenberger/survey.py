"""Every constant Leondes-Novak filter of one plant, compared, and one recommended."""

import itertools
from dataclasses import dataclass

import numpy as np

from .analysis import error_covariance, multiply_adds
from .certificate import Certificate, certify
from .designs.trace_minimisation import reduced_order_filter
from .errors import DesignError
from .observer import Observer
from .plant import Plant

EVERY_SUBSET_UP_TO = 4  # outputs; above it only the first 0, 1, ..., p are surveyed
TOLERANCE = 0.05  # a design this close to the smallest error trace is good enough
LEVEL = 1e-9  # traces closer than this, relative, are equal: the rest is rounding


@dataclass(frozen=True, eq=False)
class Design:
    """One filter of a survey, or the reason why there is none.

    Attributes
    ----------
    accurate : tuple of int
        The outputs taken at their word.
    horizon : "step" or "steady"
        The paper's gain in its steady state, or the best constant gain.
    order : int
        n less the number of accurate outputs.
    observer : Observer or None
    covariance : (n, n) ndarray or None
        Of the steady estimation error.
    certificate : Certificate or None
    work : int
        Multiply-adds per step.
    refusal : str
        Why there is no observer; empty when there is one.
    """

    accurate: tuple
    horizon: str
    order: int
    observer: Observer | None = None
    covariance: np.ndarray | None = None
    certificate: Certificate | None = None
    work: int = 0
    refusal: str = ""

    @property
    def trace(self):
        """Sum of the steady error variances of all states."""
        return float(np.trace(self.covariance))

    @property
    def radius(self):
        """The largest magnitude of the observer's poles, 0 if it has none."""
        return float(np.abs(self.observer.poles).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Survey:
    """All designs of one plant, in the order of the table: see `survey`."""

    plant: Plant
    attempts: tuple

    @property
    def designs(self):
        """The attempts that gave an observer."""
        return [one for one in self.attempts if not one.refusal]

    @property
    def refused(self):
        """The attempts that were refused."""
        return [one for one in self.attempts if one.refusal]

    @property
    def yardstick(self):
        """What the others are measured against: the most accurate design.

        It is the Kalman filter where there is one; no filter is more accurate.
        """
        for one in self.designs:
            if not one.accurate:
                return one
        return min(self.designs, key=lambda one: one.trace)

    def excess(self, design):
        """Error trace beyond the yardstick's, as a fraction of it."""
        least = self.yardstick.trace
        if design.trace <= least * (1 + LEVEL):
            return 0.0
        return design.trace / least - 1 if least > 0 else np.inf

    def find(self, accurate, horizon):
        """The attempt with these accurate outputs, or None if it is not in here."""
        for one in self.attempts:
            if (one.accurate, one.horizon) == (tuple(accurate), horizon):
                return one
        return None

    def pareto(self):
        """Designs that none of the same or lower order beats, by rising order."""
        front = []
        for one in sorted(self.designs, key=lambda one: (one.order, one.trace)):
            if not front or (
                one.order > front[-1].order
                and one.trace < front[-1].trace * (1 - LEVEL)
            ):
                front.append(one)
        return front

    def recommended(self, tolerance=TOLERANCE):
        """The least work among designs whose trace exceeds the least by `tolerance`.

        Among equal work the smaller trace wins, and among equal traces the paper's
        own gain.
        """
        near = [one for one in self.designs if self.excess(one) <= tolerance]
        work = min(one.work for one in near)
        light = [one for one in near if one.work == work]
        least = min(one.trace for one in light)
        return next(one for one in light if one.trace <= least * (1 + LEVEL))


def survey(plant):
    """Design every constant filter of a plant, and compare them.

    With up to four outputs every subset of them is tried as the accurate ones;
    with more, the first m1 = 0, 1, ..., p.  Each is tried with the paper's gain in
    its steady state and with the best constant gain.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q and R; P0 is not used.

    Returns
    -------
    Survey
        A design that was refused is listed with its reason.

    Raises
    ------
    DesignError
        If every design is refused.

    Examples
    --------
    >>> import luenberger as lb
    >>> from luenberger.survey import survey
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[1]])
    >>> table = survey(plant)
    >>> [(one.order, round(one.trace, 3)) for one in table.designs]
    [(2, 1.75), (1, 2.094), (1, 2.075)]
    """
    attempts = tuple(
        _attempt(plant, accurate, horizon)
        for accurate in choices(plant.p)
        for horizon in (("step", "steady") if accurate else ("step",))
    )
    if all(one.refusal for one in attempts):
        raise DesignError(f"no exact filter of any order exists: {attempts[0].refusal}")
    return Survey(plant, attempts)


def choices(p):
    """The sets of accurate outputs to try, smallest first."""
    if p > EVERY_SUBSET_UP_TO:
        return [tuple(range(m1)) for m1 in range(p + 1)]
    sizes = range(p + 1)
    return [one for m1 in sizes for one in itertools.combinations(range(p), m1)]


def _attempt(plant, accurate, horizon):
    order = plant.n - len(accurate)
    try:
        observer = reduced_order_filter(plant, accurate, horizon=horizon)
        covariance = error_covariance(observer, plant)
    except ValueError as error:  # DesignError, CertificateError: listed, not raised
        return Design(accurate, horizon, order, refusal=str(error))
    return Design(
        accurate,
        horizon,
        order,
        observer,
        covariance,
        certify(observer, plant),
        multiply_adds(observer),
    )
