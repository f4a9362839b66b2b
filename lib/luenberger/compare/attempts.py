"""One design of a comparison, measured, or the reason why there is none."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.error_covariance import error_covariance
from ..analysis.multiply_adds import multiply_adds
from ..analysis.optimality import STATIONARY_TOL, Optimality, optimality
from ..certificate import Certificate, certify
from ..kernels.cache import CacheWarning
from ..numeric import Matrix, Vector
from ..numeric.linalg import ROUNDING, UNIT_TOL, eigenvalues, lyapunov, radius
from ..observer import Observer
from ..plant import Plant
from .cheapest import DESIGNED, cheapest
from .settling import settling_time

if TYPE_CHECKING:
    from .methods import Plan

LEVEL = 1e-9  # errors closer than this, relative, are equal: the rest is rounding


SINGLE = {"Kalman filter", "deadbeat observer", "functional observer"}
EXACT_TOL = 1e-9  # of a certificate, as in `Certificate.require`
FORM_TOL = 1e-12  # of the certificate of another form, beside the design's own
DISTURBED = "Best for u = 0: known inputs disturb its estimate."


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
        Number of observer states; None where that was never settled.
    accurate : tuple of int
        The outputs treated as exact.
    horizon : "step", "steady" or None
        Of a Leondes-Novak filter: the paper's gain in its steady state, or the best
        constant gain.
    observer : Observer or None
        In the form that is the least work.
    form : str
        Which one: "as designed", "modal", "modal, companion blocks" or "companion".
    covariance : (q, q) ndarray or None
        Of the steady error of what the observer estimates; None without noise.
    k : (., n) ndarray or None
        The functional that the comparison is about, if it is about one.
    noise_gain : float or None
        Square root of the trace that v alone would leave in `covariance`, with the
        plant's R, or R = I if it has none.  None in continuous time, where V y passes
        white noise of any strength on.
    work, bytes : int, int or None
        Multiply-adds per step, and state and constants of one observer, in the C that
        `export.to_c` writes in doubles; entries that are rounding count as zero.  In
        continuous time multiply-adds per evaluation, and None.
    certificate : Certificate or None
    optimality : Optimality or None
        Of a fixed-order filter, whose certificate has residuals: what it gives up.
    note : str
        What to know about the design; may be empty.
    refusal : str
        Why there is no observer; empty when there is one.
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
    bytes: int | None = None
    certificate: Certificate | None = None
    optimality: Optimality | None = None
    note: str = ""
    refusal: str = ""

    @property
    def name(self) -> str:
        """The method, and which design of it where there are several."""
        return self.method if self.method in SINGLE else f"{self.method}, {self.label}"

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
    def error(self) -> float | None:
        """What designs are ranked by: `error_of_k` where there is a k, or `trace`."""
        return self.trace if self.k is None else self.error_of_k

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
    def disturbed(self) -> bool:
        """Whether a known input of the plant acts on the error."""
        return self.observer.G.shape[-1] > 0 and not self.exact

    @property
    def sound(self) -> bool:
        """Whether the certificate, or the conditions of an optimum, hold."""
        if self.optimality is None:
            return self.exact and self.certificate.stable
        return self.optimality.worst <= STATIONARY_TOL


@np.errstate(all="ignore")  # a note is a design's warning, not NumPy's of an overflow
def attempt(plan: Plan, plant: Plant, k: Matrix | None) -> Attempt:
    """Carry a plan out, and measure what comes of it."""
    known: Any = dict(accurate=plan.accurate, horizon=plan.horizon, k=k)
    given = (plan.method, plan.label, plan.order)
    try:
        observer, warned = _quietly(plan.design)
        figures: Any = _figures(observer, plant, plan, k)
    except ValueError as error:  # DesignError, CertificateError: listed, not raised
        return Attempt(*given, **known, refusal=str(error))
    given = (plan.method, plan.label, observer.order)
    found = Attempt(*given, **known | figures)
    formed = (
        "" if found.form == DESIGNED else f"Given in other coordinates: {found.form}."
    )
    notes = [plan.note, formed, DISTURBED if found.disturbed else "", *warned]
    return dataclasses.replace(found, note=" ".join(filter(None, notes)))


def _quietly(design: Callable[[], Observer]) -> tuple[Observer, list[str]]:
    """What a design gives, and the texts of its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", CacheWarning)  # no property of the design
        observer = design()
    return observer, [f"{one.message}" for one in caught]


def _figures(
    observer: Observer, plant: Plant, plan: Plan, k: Matrix | None
) -> dict[str, Any]:
    best, certificate = None, certify(observer, plant)
    if plan.feedthrough is not None:
        best = optimality(observer, plant, feedthrough=plan.feedthrough)

    def sound(form: Observer) -> bool:
        if best is not None:
            worst = optimality(form, plant, feedthrough=plan.feedthrough).worst
            return worst <= max(STATIONARY_TOL, best.worst)
        return certify(form, plant).worst <= max(FORM_TOL, certificate.worst)

    form, name, work, size = observer, DESIGNED, multiply_adds(observer), None
    if not observer.is_complex:
        form, name, (work, size) = cheapest(observer, sound)
    return dict(
        covariance=_covariance(observer, plant) if noisy(plant) else None,
        noise_gain=noise_gain(observer, plant, k),
        work=work,
        bytes=size if plant.dt > 0 else None,
        certificate=certificate if form is observer else certify(form, plant),
        optimality=best,
        observer=form,
        form=name,
    )


def _covariance(observer: Observer, plant: Plant) -> Matrix:
    """The steady error covariance, 0 where nothing moves what is estimated.

    What decays and has no noise is known without measuring, but the gain that an
    iteration leaves for it is not quite 0.  What that lets in of R, beside what a plain
    inverse of C would, is below rounding.
    """
    Sigma, L = error_covariance(observer, plant), observer.L
    if plant.multiplicative and plant.Q.any() or radius(plant.A) >= 1 - UNIT_TOL:
        return Sigma
    still = (L @ lyapunov(plant.A, plant.Q) @ L.T).diagonal() == 0
    let_in = (L @ np.linalg.pinv(plant.C)) ** 2 @ plant.R.diagonal()
    floor = ROUNDING**2 * min(let_in[let_in > 0], default=0.0)
    moved = ~still | (Sigma.diagonal() > floor)
    return Sigma * np.outer(moved, moved)


def noisy(plant: Plant) -> bool:
    """Whether the plant says how noisy it is."""
    return plant.dt > 0 and plant.Q is not None and plant.R is not None


def noise_gain(
    observer: Observer, plant: Plant, k: Matrix | None = None
) -> float | None:
    """Root of the steady error trace that v alone would leave; None if dt = 0.

    Without R, that of white noise of unit variance in every output.  Where the noise
    is not known and the question is k x, that of k x.
    """
    if plant.dt == 0 or plant.is_complex or observer.is_complex:
        return None
    quiet = dataclasses.replace(
        plant,
        Q=np.zeros((plant.n, plant.n)),
        R=np.eye(plant.p) if plant.R is None else plant.R,
        S=None,
        multiplicative=(),
    )
    left = error_covariance(observer, quiet)
    if (
        k is not None
        and not noisy(plant)
        and np.array_equal(observer.L, np.eye(plant.n))
    ):
        left = k @ left @ k.T
    return float(np.sqrt(max(np.trace(left), 0.0)))


def rates(plant: Plant) -> Vector:
    """How fast the plant's modes are, in rad/s; those that never change left out."""
    poles = eigenvalues(plant.A)
    if plant.dt > 0:
        poles = np.log(poles[poles != 0].astype(complex)) / plant.dt
    return np.abs(poles[poles != 0])


def first_least(designs: Iterable[Attempt], what: str) -> Attempt:
    """The first of the least, where what differs by rounding is equal."""
    values = [getattr(one, what) or 0.0 for one in designs]
    least = min(values) * (1 + LEVEL)
    return next(one for one, value in zip(designs, values) if value <= least)
