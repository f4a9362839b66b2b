"""What a device has to spare: the most accurate design within it, and the next one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from ..errors import DesignError
from ..show import number
from .attempts import Attempt, first_least
from .untried import among, untried

if TYPE_CHECKING:
    from .table import Comparison

ALIKE = 1e-4  # standard deviations this close, relative, are worth no work
COSTS = {  # of an attempt, and as nouns
    "multiply_adds": ("work", "multiply-add", "multiply-adds"),
    "states": ("order", "observer state", "observer states"),
    "bytes": ("bytes", "byte", "bytes"),
}


@dataclass(frozen=True)
class Budget:
    """The most that a design may cost; None where that does not matter.

    Attributes
    ----------
    multiply_adds : float or None
        Of a step, as in the table.
    states : float or None
        Of the observer.
    bytes : float or None
        Of state and constants, in numbers of the table's `dtype`.

    Examples
    --------
    >>> budget = Budget.read(dict(multiply_adds=30, states=2))
    >>> budget
    Budget(multiply_adds=30, states=2, bytes=None)
    >>> str(budget)
    '30 multiply-adds and 2 observer states'
    """

    multiply_adds: float | None = None
    states: float | None = None
    bytes: float | None = None

    @classmethod
    def read(cls, given: Mapping[str, float] | Budget) -> Budget:
        """A budget from a dict; ValueError for an unknown key or no number."""
        if isinstance(given, Budget):
            return given
        wanted = f"a budget is a dict with one or more of {', '.join(COSTS)}"
        if not isinstance(given, Mapping) or not given:
            raise ValueError(f"{wanted}, as dict(multiply_adds=30); got {given!r}")
        for name, most in given.items():
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
        """The limit of an attribute of an attempt, "work", "order" or "bytes"."""
        limits = {COSTS[name][0]: most for name, most in self.limits.items()}
        return limits.get(cost)

    def over(self, one: Attempt) -> dict[str, float]:
        """What a design needs more than there is, by name; empty if it fits."""
        needs = {name: getattr(one, COSTS[name][0]) for name in self.limits}
        return {
            name: need - most
            for name, most in self.limits.items()
            if (need := needs[name]) is not None and need > most
        }

    def excess(self, one: Attempt) -> float:
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


def needs(one: Attempt) -> str:
    """What a design costs, in words."""
    costs = {name: getattr(one, COSTS[name][0]) for name in COSTS}
    return listed(amount(x, name) for name, x in costs.items() if x is not None)


def fitting(table: Comparison) -> list[Attempt]:
    """Eligible designs that the table's budget has room for."""
    return [one for one in table.eligible if not table.budget.over(one)]


def most_accurate(table: Comparison) -> Attempt:
    """The most accurate design within the budget; of those alike that of least work."""
    fit = fitting(table)
    if not fit:
        raise DesignError(" ".join(refusal(table)))
    best = first_least(fit, "error")
    equal = [
        one
        for one in fit
        if one.error <= best.error * (1 + ALIKE)
        and one.mean_ratio <= best.mean_ratio * (1 + ALIKE)
    ]
    return min(equal, key=lambda one: one.work)


def next_beyond(table: Comparison) -> Attempt | None:
    """The design that is more accurate for the least more than the budget; or None."""
    fit = fitting(table)
    limit = most_accurate(table).error * (1 - ALIKE) if fit else np.inf
    beyond = [one for one in table.eligible if table.budget.over(one)]
    better = [one for one in beyond if one.error < limit or not fit]
    if not better:
        return None
    least = min(map(table.budget.excess, better))
    near = [one for one in better if table.budget.excess(one) <= least]
    return first_least(near, "error")


def refusal(table: Comparison) -> Iterator[str]:
    """Why there is nothing within the budget, and what would do."""
    tried = among(table, " that was tried")
    yield f"No design{tried} is within the budget of {table.budget}."
    yield from untried(table)
    one = next_beyond(table)
    if one is not None:
        more = table.budget.over(one).items()
        yield (
            f"What comes nearest{among(table, ' of those tried')} is the {one.title}: "
            f"it needs {needs(one)}, "
            f"{listed(amount(size, name) for name, size in more)} more than there is."
        )
