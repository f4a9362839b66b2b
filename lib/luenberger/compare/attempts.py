"""One design of a comparison, measured, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.optimality import STATIONARY_TOL, Optimality
from ..certificate import Certificate
from ..numeric import Vector
from ..observer import Observer
from ..plant import Plant
from .cheapest import DESIGNED
from .settling import settling_time

if TYPE_CHECKING:
    from .judge import Judge

KALMAN = "Kalman filter"
NOT_TRIED = "not tried:"  # how the refusal of a design begins that takes too long
LEVEL = 1e-9  # errors closer than this, relative, are equal: the rest is rounding


SINGLE = {KALMAN, "deadbeat observer", "functional observer"}
EXACT_TOL = 1e-9  # of a certificate, as in `Certificate.require`


@dataclass(frozen=True, eq=False)
class Attempt:
    """One design, or the reason why there is none.

    Attributes
    ----------
    method : str
        "Kalman filter", "Leondes-Novak filter", "fixed-order filter", "reduced-order
        observer", "deadbeat observer" or "functional observer".
    label : str
        Which one of them, in a few words.
    order : int or None
        Number of observer states, without those that the estimate never shows; None
        where that was never settled.
    accurate : tuple of int
        The outputs treated as exact.
    horizon : "step", "steady" or None
        Of a Leondes-Novak filter: the paper's gain in its steady state, or the best
        constant gain.
    observer : Observer or None
        In the form that is the least work.
    form : str
        Which one: "as designed", "without hidden states", "modal", "modal, companion
        blocks" or "companion".
    covariance : (q, q) ndarray or None
        Of the steady error of what the observer estimates; None without noise.
    k : (., n) ndarray or None
        The functional that the comparison is about, if it is about one.
    noise_gain : float or None
        Square root of the trace that v alone would leave in `covariance`, with the
        plant's R, or R = I if it has none.  None in continuous time, where V y passes
        white noise of any strength on.
    work, operations, bytes : int, int or None, int or None
        Of the observer, exactly as it is, in the C that `export.to_c` writes in the
        table's dtype: multiply-adds per step, all operations per step, bytes of state
        and constants.  In continuous time multiply-adds per evaluation, and None.
    certificate : Certificate or None
    optimality : Optimality or None
        Of a fixed-order filter, whose certificate has residuals: what it gives up.
    note : str
        What to know about the design; may be empty.
    refusal : str
        Why there is no observer; empty when there is one.
    disturbed : bool
        Whether a known input of the plant acts on the error.
    judge : Judge or None
        What errors are measured beside, the same for all attempts of a comparison.
    """

    method: str
    label: str
    order: int | None = None
    accurate: tuple = ()
    horizon: str | None = None
    observer: Observer | None = None
    form: str = DESIGNED
    covariance: np.ndarray | None = None
    k: np.ndarray | None = None
    noise_gain: float | None = None
    work: int | None = None
    operations: int | None = None
    bytes: int | None = None
    certificate: Certificate | None = None
    optimality: Optimality | None = None
    note: str = ""
    refusal: str = ""
    disturbed: bool = False
    judge: Judge | None = field(default=None, repr=False)

    @property
    def name(self) -> str:
        """The method, and which design of it where there are several."""
        return self.method if self.method in SINGLE else f"{self.method}, {self.label}"

    @property
    def untried(self) -> bool:
        """Whether it may well exist, and was left out as its search takes a while."""
        return self.refusal.startswith(NOT_TRIED)

    @property
    def title(self) -> str:
        """The name with the order."""
        order = f"order {self.order}"
        return self.name if order in self.name else f"{self.name}, {order}"

    @property
    def whole(self) -> bool:
        """Whether it estimates the whole state, and not k x only."""
        n = self.observer.L.shape[1]
        return np.array_equal(self.observer.L, np.eye(n))

    @property
    def variances(self) -> Vector | None:
        """Steady error variance of each state, or of each row of k x; or None."""
        if self.covariance is None:
            return None
        return np.maximum(self.covariance.diagonal(), 0.0)

    @property
    def trace(self) -> float | None:
        """Sum of the steady error variances of all states; None where not known."""
        if self.covariance is None or not self.whole:
            return None
        return float(np.trace(self.covariance))

    @property
    def error_of_k(self) -> float | None:
        """Steady error variance of k x, its rows added; None where not known."""
        if self.covariance is None or self.k is None:
            return None
        k = self.k if self.whole else np.eye(len(self.covariance))
        return float(np.trace(k @ self.covariance @ k.T))

    @property
    def judged(self) -> Vector | None:
        """Variances that designs are judged by, of all states or of rows of k x."""
        if self.covariance is None or (self.k is None and not self.whole):
            return None
        if self.k is None or not self.whole:
            return self.variances
        return np.maximum((self.k @ self.covariance @ self.k.T).diagonal(), 0.0)

    @property
    def ratios(self) -> Vector | None:
        """Standard deviations of these, each beside that of the Kalman filter."""
        if self.judge is None or self.judged is None:
            return None
        return self.judge.ratios(self.judged)

    @property
    def worst_ratio(self) -> float | None:
        """The largest of `ratios`."""
        return None if self.ratios is None else float(self.ratios.max(initial=1.0))

    @property
    def mean_ratio(self) -> float | None:
        """The mean of `ratios`."""
        found = self.ratios
        return None if found is None else float(found.mean()) if len(found) else 1.0

    @cached_property
    def error(self) -> float | None:
        """What designs are ranked by, the largest of `ratios`.

        With a scale the root mean square of standard deviations in its units.
        """
        if self.judge is None or self.judged is None:
            return None
        return self.judge.error(self.judged)

    @property
    def worst_pole(self) -> float:
        """Largest magnitude of the poles, 0 if there are none.

        In continuous time the largest real part, -inf if there are none.
        """
        poles = self.observer.poles
        if self.observer.dt == 0:
            return float(poles.real.max(initial=-np.inf))
        return float(np.abs(poles).max(initial=0.0))

    @property
    def settling(self) -> float:
        """Seconds until a wrong start has decayed to 1 %; infinite if it does not."""
        return settling_time(self.observer)

    @property
    def cond(self) -> float | None:
        """Condition of [T; C]; None where the state is not recovered from z and y."""
        return self.certificate.cond if self.exact and self.whole else None

    @property
    def exact(self) -> bool:
        """Whether the error does not depend on the state and the known input."""
        return self.certificate.worst <= EXACT_TOL

    @property
    def sound(self) -> bool:
        """Whether the certificate, or the conditions of an optimum, hold."""
        if self.optimality is None:
            return self.exact and self.certificate.stable
        return self.optimality.worst <= STATIONARY_TOL


def noisy(plant: Plant) -> bool:
    """Whether the plant says how noisy it is."""
    return plant.dt > 0 and plant.Q is not None and plant.R is not None


def first_least(designs: Iterable[Attempt], what: str) -> Attempt:
    """The first of the least, where what differs by rounding is equal.

    Among designs of equal error the mean of their ratios decides.
    """
    least = _least(list(designs), what)
    return (_least(least, "mean_ratio") if what == "error" else least)[0]


def _least(designs: list[Attempt], what: str) -> list[Attempt]:
    values = [getattr(one, what) or 0.0 for one in designs]
    most = min(values) * (1 + LEVEL)
    return [one for one, value in zip(designs, values) if value <= most]
