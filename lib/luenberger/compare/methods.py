"""What a comparison tries: every method, and within it every choice."""

import dataclasses
import functools
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.known_input import Statistics
from ..analysis.mean_square import equivalent_noise
from ..errors import DesignError
from ..numeric import Vector
from ..numeric.linalg import eigenvalues
from ..numeric.staircase_form import find_in_even_units
from ..observer import Observer
from ..papers.haddad_bernstein.design import fixed_order_filter
from ..papers.kawazoe.deadbeat import deadbeat_observer
from ..papers.leondes_novak.design import kalman_filter, reduced_order_filter
from ..papers.moore.design import functional_observer
from ..papers.van_dooren.design import reduced_order_observer
from ..plant import Plant
from .attempts import noisy

EVERY_SUBSET_UP_TO = 4  # outputs; above it only the first 0, 1, ..., p are tried
EVERY_SIZE_UP_TO = 50  # states; above it only the first 0, 1, 2, 4, ..., p outputs
EVERY_ORDER_UP_TO = 9  # states; above it only fixed-order filters up to FEW_ORDERS
FEW_ORDERS = 3
NO_ORDER_ABOVE = 100  # states; above it no fixed-order filter
PREDICTORS_UP_TO = 5  # states; above it no fixed-order filter with V = 0
STARTS = 12  # of the search for each fixed-order filter
SPEED = 3.0  # of an observer, beside the plant, where no noise says how fast
SPEEDS = (1.0, SPEED, 10.0)  # where nothing is known of the noise


@dataclass(frozen=True)
class Plan:
    """A design to be tried: what it is called, and a function that makes it."""

    method: str
    label: str
    design: Callable
    order: int | None = None
    accurate: tuple = ()
    horizon: str | None = None
    feedthrough: bool | None = None  # of a fixed-order filter
    weight: np.ndarray | None = None  # of what it makes least
    note: str = ""


@dataclass(frozen=True, eq=False)
class Question:
    """What was asked: the plant, and what else was given."""

    plant: Plant
    k: np.ndarray | None = None
    poles: tuple | None = None
    orders: tuple | None = None
    scale: np.ndarray | None = None
    U: Statistics | None = None

    @property
    def weight(self) -> np.ndarray | None:
        """Of the error that filters make least: I, or 1 / scale^2."""
        return None if self.scale is None else np.diag(self.scale**-2.0)

    @functools.cached_property
    def additive(self) -> Plant:
        """The plant with additive noises that trouble an estimate as much as its own.

        It is for filters that know no multiplicative noise: (4.4) of Haddad and
        Bernstein; see `mean_square.equivalent_noise`.
        """
        plant = self.plant
        if not plant.multiplicative or not noisy(plant):
            return plant
        _, Q, S, R = equivalent_noise(plant)
        return dataclasses.replace(plant, Q=Q, R=R, S=S, multiplicative=())

    @functools.cached_property
    def note(self) -> str:
        if not self.plant.multiplicative:
            return ""
        return "Designed for additive noise of the same steady covariance."

    @functools.cached_property
    def speed(self) -> tuple[ArrayLike, str]:
        """Poles for a reduced-order observer, and where they are from."""
        plant = self.plant
        if self.poles is not None:
            return self.poles, "poles as given"
        _, form = find_in_even_units(plant.A, plant.C, plant.dt)
        count = plant.n - form.rank
        try:
            minimal = reduced_order_filter(
                self.additive, plant.p, horizon="steady"
            ).poles
        except ValueError:
            minimal = ()
        if len(minimal) == count:
            return minimal, "poles of the minimal-order filter"
        return butterworth(plant, count), _butterworth(SPEED)

    @property
    def speeds(self) -> Iterator[tuple[ArrayLike, str]]:
        """`speed`; and where nothing is known of the noise, several to choose from."""
        plant = self.plant
        if noisy(plant) or self.poles is not None or not len(np.ravel(self.speed[0])):
            yield self.speed
            return
        for times in SPEEDS:
            poles = butterworth(plant, len(np.ravel(self.speed[0])), times)
            yield poles, _butterworth(times)


def _butterworth(times: float) -> str:
    return f"Butterworth poles, {times:g} times the rates of the plant".replace(
        ", 1 times", " at"
    )


def butterworth(plant: Plant, count: int, times: float = SPEED) -> tuple[complex, ...]:
    """Poles on a circle in the left half plane, `times` as far out as the plant's.

    The plant's distance is the geometric mean of its modes' rates, |s|.  In discrete
    time the poles are exp(s dt).
    """
    known = rates(plant)
    unit = 1 / plant.dt if plant.dt > 0 else 1.0
    distance = times * (np.exp(np.log(known).mean()) if len(known) else unit / SPEED)
    angle = np.pi * (2 * np.arange(count // 2) + count + 1) / (2 * max(count, 1))
    upper = distance * np.exp(1j * angle)
    s = np.concatenate([upper, upper.conj(), [-distance] * (count % 2)])
    return tuple(np.exp(s * plant.dt) if plant.dt > 0 else s)


def rates(plant: Plant) -> Vector:
    """How fast the plant's modes are, in rad/s; those that never change left out."""
    poles = eigenvalues(plant.A)
    if plant.dt > 0:
        poles = np.log(poles[poles != 0].astype(complex)) / plant.dt
    return np.abs(poles[poles != 0])


def choices(n: int, p: int) -> list[tuple[int, ...]]:
    """The sets of accurate outputs to try, smallest first."""
    sizes = range(p + 1)
    if n > EVERY_SIZE_UP_TO:
        sizes = sorted({0, *(2**k for k in range(p.bit_length())), p})
    elif p <= EVERY_SUBSET_UP_TO:
        return [one for m1 in sizes for one in itertools.combinations(range(p), m1)]
    return [tuple(range(m1)) for m1 in sizes]


def kalman(asked: Question) -> Iterator[Plan]:
    yield Plan(
        "Kalman filter",
        "every output filtered",
        lambda: kalman_filter(asked.additive),
        asked.plant.n,
        horizon="step",
        note=asked.note,
    )


def leondes_novak(asked: Question) -> Iterator[Plan]:
    plant = asked.plant
    gains = {"step": "step-wise gain", "steady": "best constant gain"}
    tried = choices(plant.n, plant.p)
    weight = asked.weight if asked.k is None else None  # that is of rows of k x
    for accurate in tried[1:]:
        names = ", ".join(plant.output_names[k] for k in accurate)
        for horizon, gain in gains.items():
            yield Plan(
                "Leondes-Novak filter",
                f"{names} taken as accurate, {gain}",
                lambda accurate=accurate, horizon=horizon: reduced_order_filter(
                    asked.additive, accurate, horizon=horizon, weight=weight
                ),
                plant.n - len(accurate),
                accurate,
                horizon,
                note=asked.note,
            )
    if len(tried) < 2**plant.p:
        label = "other outputs taken as accurate"
        design = functools.partial(_too_many, plant)
        yield Plan("Leondes-Novak filter", label, design)


def _too_many(plant: Plant) -> str:
    raise DesignError(
        f"not tried: every set of p = {plant.p} outputs, with n = {plant.n} states, "
        "takes a while. reduced_order_filter(plant, m1) makes it for any of them."
    )


def fixed_order(asked: Question) -> Iterator[Plan]:
    plant, of = asked.plant, "" if asked.k is None else " for k x"
    most = np.inf
    if plant.n > EVERY_ORDER_UP_TO and asked.orders is None:
        most = FEW_ORDERS if plant.n <= NO_ORDER_ABOVE else 0
    for order, feedthrough in itertools.product(range(1, plant.n), (True, False)):
        design = functools.partial(
            fixed_order_filter,
            plant,
            order,
            L=asked.k,
            weight=asked.weight,
            feedthrough=feedthrough,
            starts=STARTS,
            U=asked.U,
        )
        if order > most:
            design = functools.partial(_not_tried, plant.n)
        if feedthrough or plant.n <= PREDICTORS_UP_TO:
            label = f"order {order}{of}{'' if feedthrough else ', V = 0'}"
            given: Any = dict(order=order, feedthrough=feedthrough, weight=asked.weight)
            yield Plan("fixed-order filter", label, design, **given)
    if plant.n > PREDICTORS_UP_TO:
        design = functools.partial(_not_tried, plant.n, "V = 0")
        yield Plan("fixed-order filter", f"every order{of}, V = 0", design)


def _not_tried(n: int, what: str = "this order") -> str:
    remedy = ", feedthrough=False" if what == "V = 0" else ""
    raise DesignError(
        f"not tried: with n = {n} states the search for {what} takes a while. "
        f"fixed_order_filter(plant, order{remedy}) makes it."
    )


def reduced_order(asked: Question) -> Iterator[Plan]:
    try:
        speeds = list(asked.speeds)
    except ValueError:
        speeds = [(None, "chosen poles")]
    for poles, label in speeds:

        def design(poles: ArrayLike | None = poles) -> Observer:
            given = asked.speed[0] if poles is None else poles  # or its refusal
            return reduced_order_observer(asked.plant, given)

        yield Plan("reduced-order observer", label, design)


def deadbeat(asked: Question) -> Iterator[Plan]:
    def design() -> Observer:
        return deadbeat_observer(asked.plant)

    yield Plan("deadbeat observer", "all poles zero", design)


def functional(asked: Question) -> Iterator[Plan]:
    def design() -> Observer:
        if asked.k is None:
            raise DesignError(
                "it needs k, the combination k x of the states that it is to estimate"
            )
        return functional_observer(asked.plant, asked.k)

    yield Plan("functional observer", "k x from the fewest states", design)


METHODS = {
    "Kalman filter": kalman,
    "Leondes-Novak filter": leondes_novak,
    "fixed-order filter": fixed_order,
    "reduced-order observer": reduced_order,
    "deadbeat observer": deadbeat,
    "functional observer": functional,
}
