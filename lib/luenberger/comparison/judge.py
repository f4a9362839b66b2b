"""A design, measured: what it costs, and what it leaves of the error on each plant.

Variances of states in unlike units cannot be added.  So each standard deviation is
divided by the one that the Kalman filter leaves of the same state, or by a size that
the user gives.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.disturbance import disturbed
from ..analysis.error_covariance import error_covariance
from ..analysis.error_system import ADVICE, error_system
from ..analysis.lightest import lightest, without_rounding
from ..analysis.optimality import STATIONARY_TOL, Optimality, optimality
from ..analysis.step_cost import StepCost, multiply_adds, step_cost
from ..certificate import Certificate, certify
from ..kernels.kept import CacheWarning
from ..numeric import Matrix, Vector
from ..numeric.linalg import ROUNDING, UNIT_TOL, lyapunov, radius
from ..numeric.validation import vector
from ..observer import Observer
from ..papers.leondes_novak.design import kalman_filter
from ..plant import Plant
from .designs import (
    KALMAN,
    METHODS,
    NOVAK,
    Candidate,
    Question,
    additive,
    noisy,
    title,
)

EXACT_TOL = 1e-9  # of a certificate, as in `Certificate.require`
FORM_TOL = 1e-12  # of the certificate of another form
ITERATED = 1e-10  # of a matrix's largest entry: what an iteration leaves of a zero
LEFT = 0.01  # of a wrong start, when it counts as forgotten
VANISHED = 1e-9  # of a product of matrices, beside its factors
NOMINAL = "nominal"
UNKNOWN = "the known input disturbs the estimate, and nothing is said of it"
ADDITIVE = "Designed for additive noise of the same steady covariance."
DISTURBED = (
    "Best for u = 0: known inputs disturb its estimate, and no error is known without "
    "plant.with_input(U), which says what they are like."
)


@dataclass(frozen=True, eq=False)
class Case:
    """What a design leaves of the error on one plant.

    Attributes
    ----------
    covariance : (q, q) ndarray or None
        The steady second moment of the error of L x.  None where it is not known, or
        grows without bound.
    ratios : (q,) ndarray or None
        Standard deviations, each beside the one that the Kalman filter which knows
        this plant leaves; 1 where both are zero.
    error : float or None
        What designs are judged by: the largest ratio; with a scale the root mean
        square of standard deviations in its units.  Infinite where the error grows;
        None where it is not known.
    refusal : str
        Why it grows or is not known; else empty.
    """

    covariance: np.ndarray | None = None
    ratios: np.ndarray | None = None
    error: float | None = None
    refusal: str = ""

    @property
    def sigma(self) -> Vector | None:
        """Standard deviations of the error of L x, in their own units."""
        if self.covariance is None:
            return None
        return np.sqrt(np.maximum(self.covariance.diagonal(), 0.0))


@dataclass(frozen=True, eq=False)
class Design:
    """An observer with what it costs and what it is worth, or why there is none.

    Attributes
    ----------
    method : str
        "Kalman filter", "Leondes-Novak filter", "fixed-order filter", "reduced-order
        observer", "deadbeat observer" or "functional observer"; or the name of a
        design of one's own.
    label : str
        Which one of them, in a few words.
    order : int or None
        Number of observer states, without those that the estimate never shows.
    accurate : tuple of int
        The outputs treated as exact.
    horizon : "step", "steady" or None
        Of a Leondes-Novak filter: the paper's gain in its steady state, or the best
        constant gain.
    observer : Observer or None
        In the coordinates of `export.lightest`; one of one's own as it was given.
    cost : StepCost or None
        Multiply-adds and operations of a step, bytes of state and constants, in the C
        that `export.to_c` writes for it.  In continuous time only multiply-adds.
    noise_gain : float or None
        Square root of the trace that v alone would leave, with the plant's R, or R = I
        if it has none.  None in continuous time.
    certificate : Certificate or None
    optimality : Optimality or None
        Of a fixed-order filter, whose certificate has residuals: what it gives up.
    note : str
        What to know about the design; may be empty.
    refusal : str
        Why there is no observer; empty when there is one.
    disturbed : bool
        Whether a known input of the plant acts on the error.
    cases : dict of str to Case
        What it is worth on each plant, the one it is for first, as "nominal".
    """

    method: str
    label: str = ""
    order: int | None = None
    accurate: tuple[int, ...] = ()
    horizon: str | None = None
    observer: Observer | None = field(default=None, repr=False)
    cost: StepCost | None = None
    noise_gain: float | None = None
    certificate: Certificate | None = field(default=None, repr=False)
    optimality: Optimality | None = field(default=None, repr=False)
    note: str = ""
    refusal: str = ""
    disturbed: bool = False
    cases: Mapping[str, Case] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """The method, and which design of it where there are several."""
        return title(self.method, self.label)

    @property
    def title(self) -> str:
        """The name with the order."""
        order = f"order {self.order}"
        return self.name if order in self.name else f"{self.name}, {order}"

    @property
    def work(self) -> int | None:
        """Multiply-adds of a step."""
        return None if self.cost is None else self.cost.multiply_adds

    @property
    def bytes(self) -> int | None:
        """Bytes of state and constants; None in continuous time."""
        known = self.cost is not None and self.observer is not None
        return self.cost.bytes if known and self.observer.dt > 0 else None

    @property
    def nominal(self) -> Case:
        """On the plant that it was designed for."""
        return self.cases.get(NOMINAL, Case())

    @property
    def covariance(self) -> Matrix | None:
        """Of the steady error of L x on the nominal plant; None where not known."""
        return self.nominal.covariance

    @property
    def sigma(self) -> Vector | None:
        """Steady standard deviations of L x on the nominal plant; None if not known."""
        return self.nominal.sigma

    @property
    def trace(self) -> float | None:
        """Sum of the steady error variances; it adds variances of all units."""
        X = self.covariance
        return None if X is None else float(np.trace(X))

    @property
    def ratios(self) -> Vector | None:
        """Standard deviations beside the Kalman filter's, on the nominal plant."""
        return self.nominal.ratios

    @property
    def worst_ratio(self) -> float | None:
        """The largest of `ratios`."""
        return None if self.ratios is None else float(self.ratios.max(initial=1.0))

    @property
    def mean_ratio(self) -> float | None:
        """The mean of `ratios`."""
        found = self.ratios
        return None if found is None else float(found.mean()) if len(found) else 1.0

    @property
    def errors(self) -> dict[str, float | None]:
        """What it is judged by on each plant, by name."""
        return {name: one.error for name, one in self.cases.items()}

    @property
    def error(self) -> float | None:
        """The largest of `errors`, by which it is judged; None where one is unknown."""
        known = [one.error for one in self.cases.values() if one.error is not None]
        return max(known) if known and len(known) == len(self.cases) else None

    @property
    def worst_on(self) -> str | None:
        """The first of the plants on which its error is largest."""
        if self.error is None:
            return None
        return next(name for name, x in self.errors.items() if x == self.error)

    @property
    def growing(self) -> list[str]:
        """The plants on which its error grows without bound."""
        return [name for name, x in self.errors.items() if x == np.inf]

    @property
    def worst_pole(self) -> float:
        """Largest magnitude of the poles, 0 if there are none.

        In continuous time the largest real part, -inf if there are none.
        """
        assert self.observer is not None
        poles = self.observer.poles
        if self.observer.dt == 0:
            return float(poles.real.max(initial=-np.inf))
        return float(np.abs(poles).max(initial=0.0))

    @property
    def settling(self) -> float:
        """Seconds until a wrong start has decayed to 1 %; infinite if it does not."""
        assert self.observer is not None
        return settling_time(self.observer)

    @property
    def cond(self) -> float | None:
        """Condition of [T; C]; None where the state is not recovered from z and y."""
        assert self.observer is not None and self.certificate is not None
        L = self.observer.L
        whole = np.array_equal(L, np.eye(L.shape[1]))
        return self.certificate.cond if self.exact and whole else None

    @property
    def exact(self) -> bool:
        """Whether the error does not depend on the state and the known input."""
        return self.certificate is not None and self.certificate.worst <= EXACT_TOL

    @property
    def sound(self) -> bool:
        """Whether the certificate, or the conditions of an optimum, hold."""
        if self.optimality is None:
            return self.exact and self.certificate.stable
        return self.optimality.worst <= STATIONARY_TOL


# -- making and measuring ----------------------------------------------------------


@np.errstate(all="ignore")  # a note is a design's warning, not NumPy's of an overflow
def made(candidate: Candidate, asked: Question, dtype: str = "double") -> Design:
    """Design, and measure all but the error; or say why there is no design."""
    plant = asked.plant
    known: dict[str, Any] = {name: getattr(candidate, name) for name in SHARED}
    try:
        observer, warned = _quietly(candidate, asked)
        if observer.L.shape[1] != plant.n:
            raise ValueError(
                f"it is of a plant with {observer.L.shape[1]} states, not {plant.n}"
            )
        ours = candidate.method in METHODS
        designed = observer.order
        observer, certificate, best = _light(candidate, asked, observer, ours, dtype)
        moved = disturbed(observer, plant, certificate)
        cost = _cost(observer, dtype)
        gain = noise_gain(observer, plant, certificate)
    except ValueError as error:  # DesignError, CertificateError: listed, not raised
        return Design(**known, refusal=str(error))
    additive_only = ours and candidate.method in ADDITIVE_ONLY
    notes = [
        ADDITIVE if additive_only and plant.multiplicative and noisy(plant) else "",
        _left_out(designed - observer.order),
        DISTURBED if moved and plant.U is None and best is not None else "",
        *warned,
    ]
    known |= dict(order=observer.order, note=" ".join(filter(None, notes)))
    return Design(
        **known, observer=observer, cost=cost, noise_gain=gain,
        certificate=certificate, optimality=best, disturbed=moved,
    )  # fmt: skip


def _left_out(hidden: int) -> str:
    plural = "" if hidden == 1 else "s"
    said = f"Left out: {hidden} state{plural} that the estimate never shows."
    return said if hidden else ""


ADDITIVE_ONLY = {KALMAN, NOVAK}
SHARED = ("method", "label", "order", "accurate", "horizon")  # candidate and design


def _quietly(candidate: Candidate, asked: Question) -> tuple[Observer, list[str]]:
    """What a candidate gives, and the texts of its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", CacheWarning)  # no property of the design
        observer = candidate.make(asked)
    return observer, [f"{one.message}" for one in caught]


def _light(
    candidate: Candidate, asked: Question, observer: Observer, ours: bool, dtype: str
) -> tuple[Observer, Certificate, Optimality | None]:
    """A design of ours in its lightest form, if it is as good there; what it keeps."""
    plant, best = asked.plant, None
    forms = [observer]
    if ours and not observer.is_complex:
        light = lightest(observer, dtype=dtype)
        forms = [without_rounding(light, ITERATED), light, observer]
    for form in forms:
        certificate = certify(form, plant)
        if candidate.feedthrough is not None:
            given: Any = dict(weight=asked.weight, feedthrough=candidate.feedthrough)
            best = optimality(form, plant, **given)
            good = best.worst <= STATIONARY_TOL
        else:
            good = certificate.worst <= FORM_TOL
        if good:
            break
    return form, certificate, best


def _cost(observer: Observer, dtype: str) -> StepCost:
    if observer.is_complex:
        return StepCost(multiply_adds(observer), 0, 0)
    return step_cost(observer, dtype)


def noise_gain(
    observer: Observer, plant: Plant, certificate: Certificate
) -> float | None:
    """Root of the steady error trace that v alone would leave; None if dt = 0.

    Without R, that of white noise of unit variance in every output.
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
    left = error_system(observer, quiet, None, certificate).steady()
    return float(np.sqrt(max(np.trace(left), 0.0)))


# -- on plants ---------------------------------------------------------------------


def on_plant(
    designs: Sequence[Design],
    asked: Question,
    rows: Matrix,
    plant: Plant,
    known: Design | None = None,
) -> list[Case]:
    """Every design on one plant; `known` is the design whose certificate is for it."""
    own = plant is asked.plant
    found = [_moments(one, rows, plant, own) for one in designs]
    covariances = [X for X, _ in found if X is not None]
    beside = _beside(plant, rows, asked.scale, covariances, known)
    return [_case(X, refusal, beside) for X, refusal in found]


def _case(X: Matrix | None, refusal: str, beside: Beside | None) -> Case:
    if X is None:
        return Case(error=None if refusal == UNKNOWN else np.inf, refusal=refusal)
    assert beside is not None  # where there is an X there is a least one
    variances = np.maximum(X.diagonal(), 0.0)
    return Case(X, beside.ratios(variances), beside.error(variances))


def _moments(
    one: Design, rows: Matrix, plant: Plant, own: bool
) -> tuple[Matrix | None, str]:
    """The steady second moment of the error of L x, or why there is none."""
    observer = one.observer
    assert observer is not None and one.certificate is not None
    certificate = one.certificate if own else certify(observer, plant)
    moved = one.disturbed if own else disturbed(observer, plant, certificate)
    if moved and plant.U is None:
        return None, UNKNOWN
    try:
        X = steady_covariance(observer, plant, certificate, moved)
    except ValueError as error:
        return None, str(error).removesuffix(ADVICE)
    return (X if np.array_equal(observer.L, rows) else rows @ X @ rows.T), ""


def steady_covariance(
    observer: Observer,
    plant: Plant,
    certificate: Certificate,
    moved: bool = False,
) -> Matrix:
    """The steady error covariance, 0 where nothing moves what is estimated.

    What decays and has no noise is known without measuring, but the gain that an
    iteration leaves for it is not quite 0.  What that lets in of R, beside what a plain
    inverse of C would, is below rounding.
    """
    if plant.U is not None and (moved or plant.multiplicative):
        return error_covariance(observer, plant)
    Sigma, L = error_system(observer, plant, None, certificate).steady(), observer.L
    if plant.multiplicative and plant.Q.any() or radius(plant.A) >= 1 - UNIT_TOL:
        return Sigma
    still = (L @ lyapunov(plant.A, plant.Q) @ L.T).diagonal() == 0
    let_in = np.linalg.pinv(plant.C) ** 2 @ plant.R.diagonal()
    floor = ROUNDING**2 * min(let_in[let_in > 0], default=0.0) * (L * L).sum(axis=1)
    driven = ~still | (Sigma.diagonal() > floor)
    return Sigma * np.outer(driven, driven)


@dataclass(frozen=True, eq=False)
class Beside:
    """What the error of each row of L x is measured beside.

    Attributes
    ----------
    least : (q,) ndarray
        Variances that the plant's own Kalman filter leaves, or the least of the
        designs where there is no Kalman filter.
    floor : (q,) ndarray
        Variances below are rounding, and count as zero: 1e-14 of what may not be known
        before a measurement, of which the Kalman filter takes the difference.
    scale : (q,) ndarray or None
        Typical sizes, if the user gave them.
    """

    least: np.ndarray
    floor: np.ndarray
    scale: np.ndarray | None = None

    def ratios(self, variances: Vector) -> Vector:
        """Standard deviations over the least; 1 where both are zero.

        Examples
        --------
        >>> beside = Beside(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1e-9, 1e-9]))
        >>> beside.ratios(np.array([4.0, 1e-12, 1.0]))
        array([ 2.,  1., inf])
        """
        left, least = (np.where(v > self.floor, v, 0) for v in (variances, self.least))
        found = np.where(left > 0, np.inf, 1.0)
        return np.sqrt(np.divide(left, least, out=found, where=least > 0))

    def error(self, variances: Vector) -> float:
        """The largest of `ratios`; with a scale the root mean square in its units."""
        if self.scale is None:
            return float(self.ratios(variances).max(initial=1.0))
        parts = np.sqrt(variances) / self.scale
        return float(np.linalg.norm(parts) / np.sqrt(max(len(parts), 1)))


@np.errstate(all="ignore")
def _beside(
    plant: Plant,
    rows: Matrix,
    scale: Vector | None,
    found: Iterable[Matrix],
    known: Design | None,
) -> Beside | None:
    kalman = _own_kalman(plant, known)
    if kalman is None:
        variances = [X.diagonal() for X in found]
        if not variances:
            return None
        least = np.maximum(np.min(variances, axis=0), 0.0)
        return Beside(least, np.zeros_like(least), scale)
    left = np.sqrt(np.maximum(kalman.diagonal(), 0))
    before = np.hypot(np.abs(plant.A) @ left, np.sqrt(additive(plant).Q.diagonal()))
    size = (np.abs(rows) @ before) ** 2  # at most, however they are correlated
    least = np.maximum((rows @ kalman @ rows.T).diagonal(), 0)
    return Beside(least, ROUNDING * size, scale)


def _own_kalman(plant: Plant, known: Design | None) -> Matrix | None:
    """The covariance of the whole state that a plant's own Kalman filter leaves."""
    try:
        if known is not None and known.cond is not None:
            observer, certificate = known.observer, known.certificate
        else:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                observer = kalman_filter(additive(plant))
            certificate = certify(observer, plant)
        assert observer is not None and certificate is not None
        return steady_covariance(observer, plant, certificate)
    except ValueError:  # there is none
        return None


def sizes(scale: ArrayLike | None, count: int) -> Vector | None:
    """`scale` as positive numbers, one for each row of L x.

    Examples
    --------
    >>> sizes(2.0, 3)
    array([2., 2., 2.])
    """
    if scale is None:
        return None
    given = np.broadcast_to(scale, count) if np.ndim(scale) == 0 else scale
    found = vector("scale", given, count)
    if not (found > 0).all():
        raise ValueError(
            f"scale has typical sizes of the {count} numbers that are judged, so all "
            f"are positive, got {found.tolist()}"
        )
    return found


# -- settling ----------------------------------------------------------------------


def settling_time(observer: Observer) -> float:
    """Seconds until a wrong start has decayed to 1 % at the rate of the slowest pole.

    In discrete time whole samples.  Where every pole is next to zero it is the power
    of F that vanishes which counts.  Infinite if the observer is not stable.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=0.5)
    >>> settling_time(lb.reduced_order_observer(plant, [0.1]))  # 0.1^2 = 1 %
    1.0
    >>> settling_time(lb.deadbeat_observer(plant))
    0.5
    """
    poles = observer.poles
    if not poles.size:
        return 0.0
    if observer.dt == 0:
        rate = float(poles.real.max())
        return np.log(LEFT) / rate if rate < 0 else np.inf
    size = float(np.abs(poles).max())
    if size >= 1:
        return np.inf
    if size <= LEFT:
        return observer.dt * _vanishing(observer.F)
    return observer.dt * float(np.ceil(np.log(LEFT) / np.log(size) * (1 - 1e-12)))


def _vanishing(F: Matrix) -> int:
    """The least power of F that is rounding beside its factors, or 1 if none is."""
    size = float(np.linalg.norm(F))
    power = F = F / size if size > 0 else F
    for k in range(1, len(F) + 1):
        if np.linalg.norm(power) <= VANISHED:
            return k
        power = power @ F
    return 1
