"""One design on one plant that there may be, and one design on all of them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..analysis.disturbance import disturbed
from ..analysis.error_covariance import mean_error
from ..analysis.error_system import ADVICE
from ..certificate import certify
from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from .judge import Judge, beside_kalman, own_kalman
from .measure import steady_covariance
from .perturbed import NOMINAL, Perturbed
from .question import Question

QUARTILES = (0.0, 0.25, 0.5, 0.75, 1.0)
UNKNOWN = "the known input disturbs the estimate, and nothing is said of it"


@dataclass(frozen=True, eq=False)
class Case:
    """One design on one plant.

    Attributes
    ----------
    design, plant : str
    values : dict of str to float
        Of what was varied.
    covariance : (q, q) ndarray or None
        The second moment of the error of the states, or of the rows of k x, in the
        steady state.  None where it is not known or not finite.
    bias : (q,) ndarray or None
        The mean of that error, which a level of the known input leaves.
    error : float or None
        What designs are judged by: the largest ratio of a standard deviation to that
        of the plant's own Kalman filter; with a scale the root mean square in its
        units.  Infinite where the error grows; None where the known input disturbs
        the estimate and nothing is known of it.
    refusal : str
        Why the error is infinite or not known; else empty.
    drawn : bool
        Whether it counts in quartiles.
    """

    design: str
    plant: str
    values: Mapping[str, float]
    covariance: np.ndarray | None = None
    bias: np.ndarray | None = None
    error: float | None = None
    refusal: str = ""
    drawn: bool = True

    @property
    def sigma(self) -> Vector | None:
        """Root mean squares of the error, or None."""
        if self.covariance is None:
            return None
        return np.sqrt(np.maximum(self.covariance.diagonal(), 0.0))


@dataclass(frozen=True, eq=False)
class Spread:
    """One design on all plants.

    Attributes
    ----------
    name : str
    observer : Observer
    work : int
        Multiply-adds per step.
    cases : tuple of Case
    """

    name: str
    observer: Observer
    work: int
    cases: tuple[Case, ...]

    @property
    def known(self) -> bool:
        """Whether the error is known on every plant, be it infinite."""
        return all(one.error is not None for one in self.cases)

    @property
    def errors(self) -> Vector:
        """The error on each plant, NaN where it is not known."""
        known = [np.nan if one.error is None else one.error for one in self.cases]
        return np.array(known)

    @property
    def worst(self) -> Case | None:
        """The first of the plants on which the error is largest."""
        return self.cases[int(np.argmax(self.errors))] if self.known else None

    @property
    def quartiles(self) -> Vector | None:
        """Least error, lower quartile, median, upper quartile and largest error.

        Each is the error on one of the plants.  The least and the largest are over all
        plants, the rest over those that were drawn, or over the list that was given.
        """
        if not self.known:
            return None
        drawn = [one.error for one in self.cases if one.drawn] or self.errors
        found = np.quantile(drawn, QUARTILES, method="inverted_cdf")
        found[0], found[-1] = self.errors.min(), self.errors.max()
        return found

    @property
    def nominal(self) -> Case | None:
        """On the nominal plant, where there is one."""
        return next((one for one in self.cases if one.plant == NOMINAL), None)

    @property
    def growing(self) -> tuple[Case, ...]:
        """Where the error grows without bound."""
        return tuple(one for one in self.cases if one.error == np.inf)


def cases(
    observers: Mapping[str, Observer],
    one: Perturbed,
    rows: Matrix,
    scale: Vector | None,
) -> list[Case]:
    """Every design on one plant; the error is that of rows of the state."""
    found = {name: _measured(o, one.plant, rows) for name, o in observers.items()}
    known = [X.diagonal() for X, _, _ in found.values() if X is not None]
    judge = _judge(one.plant, rows, scale, known)
    out = []
    for name, (X, bias, refusal) in found.items():
        error = None if refusal == UNKNOWN else np.inf
        if X is not None and judge is not None:
            error = judge.error(np.maximum(X.diagonal(), 0.0))
        given = (name, one.name, one.values, X, bias, error, refusal, one.drawn)
        out.append(Case(*given))
    return out


def _measured(
    observer: Observer, plant: Plant, rows: Matrix
) -> tuple[Matrix | None, Vector | None, str]:
    """Second moment and mean of an error, or why there is none."""
    if plant.U is None and disturbed(observer, plant, certify(observer, plant)):
        return None, None, UNKNOWN
    try:
        X, bias = steady_covariance(observer, plant), mean_error(observer, plant)
    except ValueError as error:
        return None, None, str(error).removesuffix(ADVICE)
    if not np.array_equal(observer.L, rows):
        X, bias = rows @ X @ rows.T, rows @ bias
    return X, bias, ""


@np.errstate(all="ignore")
def _judge(
    plant: Plant, rows: Matrix, scale: Vector | None, known: list[Vector]
) -> Judge | None:
    """What errors are measured beside: the plant's own Kalman filter, if it has one."""
    asked = Question(plant)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        own = own_kalman(asked, ())
    if own is not None:
        return beside_kalman(asked.additive, own, rows, scale)
    if not known:
        return None
    least = np.maximum(np.min(known, axis=0), 0.0)
    return Judge(least, np.zeros_like(least), "most accurate design", scale)
