"""What a comparison tries: every method, and within it every choice."""

import functools
import itertools
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import CertificateError, DesignError
from ..observer import Observer
from ..papers.haddad_bernstein.design import fixed_order_filter
from ..papers.kawazoe.deadbeat import deadbeat_observer
from ..papers.leondes_novak.design import kalman_filter, reduced_order_filter
from ..papers.moore.design import functional_observer
from ..papers.van_dooren.design import reduced_order_observer
from ..plant import Plant
from .attempts import NOT_TRIED
from .question import Question

EVERY_SUBSET_UP_TO = 4  # outputs; above it only the first 0, 1, ..., p are tried
EVERY_SIZE_UP_TO = 50  # states; above it only the first 0, 1, 2, 4, ..., p outputs
EVERY_ORDER_UP_TO = 9  # states; above it only fixed-order filters up to FEW_ORDERS
FEW_ORDERS = 3
NO_ORDER_ABOVE = 100  # states; above it no fixed-order filter
PREDICTORS_UP_TO = 5  # states; above it no fixed-order filter with V = 0
STARTS = 12  # of the search for each fixed-order filter


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
        lambda: kalman_filter(asked.additive, L=asked.L),
        asked.plant.n,
        horizon="step",
        note=asked.note,
    )


def leondes_novak(asked: Question) -> Iterator[Plan]:
    plant = asked.plant
    gains = {"step": "step-wise gain", "steady": "best constant gain"}
    tried = choices(plant.n, plant.p)
    for accurate in tried[1:]:
        names = ", ".join(plant.output_names[k] for k in accurate)
        for horizon, gain in gains.items():
            yield Plan(
                "Leondes-Novak filter",
                f"{names} taken as accurate, {gain}",
                functools.partial(_leondes_novak, asked, accurate, horizon),
                plant.n - len(accurate),
                accurate,
                horizon,
                note=asked.note,
            )
    if len(tried) < 2**plant.p:
        label = "other outputs taken as accurate"
        design = functools.partial(_too_many, plant)
        yield Plan("Leondes-Novak filter", label, design)


def _leondes_novak(
    asked: Question, accurate: tuple[int, ...], horizon: str
) -> Observer:
    """Of k x, if that is asked for, with the gain that is best for it.

    The step-wise gain weighs the whole state then, and so does the best constant one
    where there is none for k x.
    """
    k, weight = asked.k, asked.weight
    if k is not None and weight is not None:
        weight = k.T @ weight @ k if horizon == "steady" else None
    design = functools.partial(
        reduced_order_filter, asked.additive, accurate, L=asked.L, horizon=horizon
    )
    try:
        return design(weight=weight)
    except CertificateError:
        if k is None or horizon == "step":
            raise
        found = design(weight=np.eye(asked.plant.n))
        warnings.warn("Its gain is the best one for the whole state.", stacklevel=2)
        return found


def _too_many(plant: Plant) -> str:
    raise DesignError(
        f"{NOT_TRIED} every set of p = {plant.p} outputs, with n = {plant.n} states, "
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
            L=asked.L,
            weight=asked.weight,
            feedthrough=feedthrough,
            starts=STARTS,
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
        f"{NOT_TRIED} with n = {n} states the search for {what} takes a while. "
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
            return reduced_order_observer(asked.plant, given, L=asked.L)

        yield Plan("reduced-order observer", label, design)


def deadbeat(asked: Question) -> Iterator[Plan]:
    def design() -> Observer:
        return deadbeat_observer(asked.plant, L=asked.L)

    yield Plan("deadbeat observer", "all poles zero", design)


def functional(asked: Question) -> Iterator[Plan]:
    def design() -> Observer:
        if asked.k is None:
            raise DesignError(
                "it needs k, the combination k x of the states that it is to estimate"
            )
        return functional_observer(asked.plant, asked.L)

    yield Plan("functional observer", "k x from the fewest states", design)


METHODS = {
    "Kalman filter": kalman,
    "Leondes-Novak filter": leondes_novak,
    "fixed-order filter": fixed_order,
    "reduced-order observer": reduced_order,
    "deadbeat observer": deadbeat,
    "functional observer": functional,
}
