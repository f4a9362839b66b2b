"""Which design to take: by the rule or within a budget, and what lies on the front."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from ..kernels.c.numbers import require_c_type
from ..show import number
from .designs import FEW_ORDERS, FIXED, KALMAN, NO_ORDER_ABOVE
from .judge import Design

if TYPE_CHECKING:
    from collections.abc import Callable

    from .table import Comparison

TOLERANCE = 0.1  # standard deviations this close to the least are good enough
LEVEL = 1e-9  # errors closer than this, relative, are equal: the rest is rounding
ALIKE = 1e-4  # standard deviations this close, relative, are worth no work
COSTS = {  # of a design, and as nouns
    "multiply_adds": ("work", "multiply-add", "multiply-adds"),
    "states": ("order", "observer state", "observer states"),
    "bytes": ("bytes", "byte", "bytes"),
}
ALONG = ("work", "order", "settling")  # what `pareto` weighs against


@dataclass(frozen=True)
class Budget:
    """The most that a design may cost on a device; None where that does not matter.

    Attributes
    ----------
    multiply_adds : float or None
        Of a step, as in the table.
    states : float or None
        Of the observer.
    bytes : float or None
        Of state and constants.
    dtype : "double" or "float"
        What the device computes in.

    Examples
    --------
    >>> budget = Budget.read(dict(multiply_adds=30, states=2))
    >>> str(budget)
    '30 multiply-adds and 2 observer states'
    >>> Budget.read(dict(dtype="float")).limits
    {}
    """

    multiply_adds: float | None = None
    states: float | None = None
    bytes: float | None = None
    dtype: str = "double"

    @classmethod
    def read(cls, given: Mapping[str, Any] | Budget | None) -> Budget:
        """A budget from a dict; ValueError for an unknown key or no number."""
        if given is None or isinstance(given, Budget):
            return given or cls()
        wanted = f"a budget is a dict with one or more of {', '.join(COSTS)}, dtype"
        if not isinstance(given, Mapping) or not given:
            raise ValueError(f"{wanted}, as dict(multiply_adds=30); got {given!r}")
        for name, most in given.items():
            if name == "dtype":
                require_c_type(most)
                continue
            if name not in COSTS:
                raise ValueError(f"a budget has no {name!r}; {wanted}")
            real = isinstance(most, Real) and not isinstance(most, bool | np.bool_)
            if not real or not 0 <= float(most) < np.inf:
                raise ValueError(
                    f"the budget's {name} must be a number that is not negative, got "
                    f"{most!r}; leave out what does not matter"
                )
        return cls(**given)

    @property
    def limits(self) -> dict[str, float]:
        """What is limited, by name."""
        given = {name: getattr(self, name) for name in COSTS}
        return {name: most for name, most in given.items() if most is not None}

    def along(self, cost: str) -> float | None:
        """The limit of an attribute of a design, "work", "order" or "bytes"."""
        limits = {COSTS[name][0]: most for name, most in self.limits.items()}
        return limits.get(cost)

    def over(self, one: Design) -> dict[str, float]:
        """What a design needs more than there is, by name; empty if it fits."""
        needs = {name: getattr(one, COSTS[name][0]) for name in self.limits}
        return {
            name: need - most
            for name, most in self.limits.items()
            if (need := needs[name]) is not None and need > most
        }

    def excess(self, one: Design) -> float:
        """The largest part of a limit by which a design is over it."""
        limits = self.limits
        return max(
            (more / max(limits[name], 1) for name, more in self.over(one).items()),
            default=0.0,
        )

    def __str__(self) -> str:
        return listed(amount(most, name) for name, most in self.limits.items())


def amount(size: float, name: str) -> str:
    """ "no bytes", "1 observer state", "30 multiply-adds"."""
    _, one, many = COSTS[name]
    return f"{number(size, 12) if size else 'no'} {one if size == 1 else many}"


def listed(parts: Iterable[str]) -> str:
    """ "a, b and c"."""
    *most, last = parts
    return f"{', '.join(most)} and {last}" if most else last


# -- the choice --------------------------------------------------------------------


def first_least(designs: Iterable[Design], what: str) -> Design:
    """The first of the least, where what differs by rounding is equal.

    Among designs of equal error the mean of their ratios decides.
    """
    least = _least(list(designs), what)
    return (_least(least, "mean_ratio") if what == "error" else least)[0]


def _least(designs: list[Design], what: str) -> list[Design]:
    values = [getattr(one, what) or 0.0 for one in designs]
    most = min(values) * (1 + LEVEL)
    return [one for one, value in zip(designs, values) if value <= most]


def yardstick(ranked: list[Design]) -> Design | None:
    """The most accurate design; the Kalman filter where none is more accurate."""
    if not ranked:
        return None
    least = first_least(ranked, "error")
    for one in ranked:
        if one.method == KALMAN and one.error <= least.error * (1 + LEVEL):
            return one
    return least


def excess(error: float | None, least: float | None) -> float | None:
    """Error beyond the least, as a fraction of it; None if either is not known."""
    if error is None or least is None:
        return None
    if error <= least * (1 + LEVEL):
        return 0.0
    return error / least - 1 if 0 < least < np.inf else np.inf


def lightest_near(table: Comparison, tolerance: float) -> Design:
    """The least work among designs whose error is near the least."""
    near = [one for one in table.eligible if table.excess(one) <= tolerance]
    work = min(one.work for one in near)
    return first_least([one for one in near if one.work == work], "error")


def fitting(table: Comparison) -> list[Design]:
    """Eligible designs that the table's budget has room for."""
    return [one for one in table.eligible if not table.budget.over(one)]


def most_accurate(fit: list[Design]) -> Design:
    """The most accurate design; of those alike that of least work."""
    best = first_least(fit, "error")

    def near(one: Design, what: str) -> bool:
        value, least = getattr(one, what), getattr(best, what)
        return value is least or value <= least * (1 + ALIKE)

    alike = [one for one in fit if near(one, "error") and near(one, "mean_ratio")]
    return min(alike, key=lambda one: one.work)


def next_beyond(table: Comparison) -> Design | None:
    """The design that is more accurate for the least more than the budget; or None."""
    fit = fitting(table)
    limit = most_accurate(fit).error * (1 - ALIKE) if fit else np.inf
    beyond = [one for one in table.eligible if table.budget.over(one)]
    better = [one for one in beyond if one.error < limit or not fit]
    if not better:
        return None
    least = min(map(table.budget.excess, better))
    near = [one for one in better if table.budget.excess(one) <= least]
    return first_least(near, "error")


def front(designs: list[Design], by: str, what: str) -> list[Design]:
    """Designs that none of the same or less cost beats, by rising cost."""
    found: list[Design] = []
    groups: dict[float, list[Design]] = {}
    for one in designs:
        groups.setdefault(getattr(one, by), []).append(one)
    for cost in sorted(filter(np.isfinite, groups)):
        one = first_least(groups[cost], what)
        if not found or getattr(one, what) < getattr(found[-1], what) * (1 - LEVEL):
            found.append(one)
    return found


# -- fixed orders that could win ---------------------------------------------------


def more_orders(table: Comparison, tried: Callable[[int], Design]) -> Iterator[Design]:
    """Fixed orders above those that were tried, up to the rule or the budget.

    A fixed-order filter loses less the more states it has, and each costs work.  So by
    the rule the first order that is near enough is the lightest, and bisection finds
    it; within a budget the last one that fits is the most accurate.
    """
    first = [one for one in table.ranked if one.method == FIXED]
    n = table.plant.n
    if not FEW_ORDERS < n - 1 or n > NO_ORDER_ABOVE or table.yardstick is None:
        return
    if not any(one.order == FEW_ORDERS for one in first):
        return  # refused or disturbed, as others would be
    if table.budget.limits:
        yield from _up_to_the_budget(table, tried)
    else:
        yield from _up_to_the_rule(table, tried)


def _work(table: Comparison, order: int) -> int:
    """What a filter of an order costs whose poles are real: F has an entry a state."""
    p, m, q = table.plant.p, table.plant.m, len(table.estimates)
    direct = q * p + q * m * bool(table.plant.E.any())
    return order * (1 + p + m + q) + direct


def _up_to_the_rule(
    table: Comparison, tried: Callable[[int], Design]
) -> Iterator[Design]:
    near = [one for one in table.ranked if table.excess(one) <= TOLERANCE]
    light = min(one.work for one in near)
    if any(one.method == FIXED for one in near):
        return  # the first few orders are near enough, and any other is more work
    orders = range(FEW_ORDERS + 1, table.plant.n)
    last = max((r for r in orders if _work(table, r) < light), default=0)
    yield from _sought(last, tried, lambda one: table.excess(one) <= TOLERANCE)


def _up_to_the_budget(
    table: Comparison, tried: Callable[[int], Design]
) -> Iterator[Design]:
    limits, fit = table.budget.limits, fitting(table)
    least = table.yardstick.error * (1 + ALIKE)
    if any(one.error <= least for one in fit):
        return  # nothing is more accurate
    orders = range(FEW_ORDERS + 1, table.plant.n)
    room = limits.get("multiply_adds", np.inf), limits.get("states", np.inf)
    last = max(
        (r for r in orders if _work(table, r) <= room[0] and r <= room[1]), default=0
    )

    def beyond(one: Design) -> bool | None:
        if table.budget.over(one):  # a pair of poles, or bytes, cost more than foreseen
            return True
        return None if one.error <= least else False

    yield from _sought(last, tried, beyond)


def _sought(
    last: int,
    tried: Callable[[int], Design],
    beyond: Callable[[Design], bool | None],
) -> Iterator[Design]:
    """Orders up to `last`, twice as large each time, then by bisection.

    The order that is sought lies below one of which `beyond` is true; None ends it.
    """
    low, high, order = FEW_ORDERS, last + 1, min(2 * FEW_ORDERS, last)
    while low < order < high:
        one = tried(order)
        yield one
        told = None if one.error is None else beyond(one)
        if told is None:
            return
        low, high = (low, order) if told else (order, high)
        order = (low + high) // 2 if high <= last else min(2 * low, last)
