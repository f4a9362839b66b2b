"""The table of a comparison: what is best, what is on the front, what to take."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import DesignError
from ..numeric.validation import ReadOnly
from ..plant import Plant
from ..plant.estimates import Combinations
from ..show import Table
from .attempts import KALMAN, LEVEL, Attempt, first_least
from .budget import Budget, fitting, most_accurate, next_beyond
from .columns import cells, header, row, together
from .reasons import reasons
from .reviews import Reviews
from .unweighed import why_not

TOLERANCE = 0.1  # standard deviations this close to the least are good enough
COSTS = ("work", "order", "settling")  # what `pareto` weighs against


def row_names(count: int) -> tuple[str, ...]:
    """What rows of k x are called that have no names."""
    return tuple(f"row {k + 1} of k x" for k in range(count))


@dataclass(frozen=True, eq=False)
class Comparison(Reviews, ReadOnly):
    """All designs of one plant, in the order of the table: see `compare`.

    Iterating gives the attempts.  In a notebook it shows as a table, the recommended
    design in bold, and the refusals below.
    """

    plant: Plant
    attempts: tuple[Attempt, ...]
    k: np.ndarray | None = None
    budget: Budget | None = None
    dtype: str = "double"
    called: tuple[str, ...] | None = None

    @property
    def estimates(self) -> tuple[str, ...]:
        """Names of what is estimated, states or rows of k x."""
        if self.k is None:
            return self.plant.state_names
        return row_names(len(self.k)) if self.called is None else self.called

    @property
    def asked(self) -> Combinations | None:
        """The rows k as they were asked for, with their names where they have them."""
        named = self.k is not None and self.called is not None
        return dict(zip(self.called, self.k)) if named else self.k

    def __iter__(self) -> Iterator[Attempt]:
        return iter(self.attempts)

    def __len__(self) -> int:
        return len(self.attempts)

    @property
    def designs(self) -> list[Attempt]:
        """The attempts that gave an observer."""
        return [one for one in self.attempts if not one.refusal]

    @property
    def refused(self) -> list[Attempt]:
        """The attempts that were refused."""
        return [one for one in self.attempts if one.refusal]

    @property
    def ranked(self) -> list[Attempt]:
        """Designs with a known error, which can be told from each other by it."""
        return [one for one in self.designs if one.error is not None]

    @property
    def eligible(self) -> list[Attempt]:
        """Designs that may be recommended.

        Those of which the error is known, where there are any.  It is not known of
        those that a known input disturbs, most fixed-order filters of a plant that
        has one, unless the comparison was told what the input is like.
        """
        calm = [one for one in self.designs if not one.disturbed]
        return self.ranked or calm or self.designs

    @cached_property
    def yardstick(self) -> Attempt | None:
        """What the others are measured against, the most accurate design.

        It is the Kalman filter where there is one; no filter is more accurate.
        Without noise covariances there is none: None.
        """
        ranked = [one for one in self.eligible if one.error is not None]
        for one in ranked:
            if one.method == KALMAN:
                return one
        return first_least(ranked, "error") if ranked else None

    def excess(self, design: Attempt) -> float | None:
        """Error beyond the yardstick's, as a fraction of it; None if not known."""
        if self.yardstick is None or design.error is None:
            return None
        least = self.yardstick.error
        if design.error <= least * (1 + LEVEL):
            return 0.0
        return design.error / least - 1 if least > 0 else np.inf

    def find(self, method: str, **known: object) -> Attempt:
        """The first attempt of a method with these attributes.

        ``table.find("Leondes-Novak filter", accurate=(0,), horizon="steady")``
        """
        for one in self.attempts:
            fits = (getattr(one, name) == value for name, value in known.items())
            if one.method == method and all(fits):
                return one
        raise KeyError(f"no {method!r} with {known} is in the comparison")

    @property
    def scale(self) -> np.ndarray | None:
        """The typical sizes that were given, or None."""
        judge = self.attempts[0].judge
        return None if judge is None else judge.scale

    @property
    def judged_by(self) -> str:
        """The figure that designs are judged by.

        "error", or "noise_gain" where no error is known.
        """
        return "noise_gain" if self.yardstick is None else "error"

    @property
    def judged_as(self) -> str:
        """The same in words, for an axis."""
        if self.yardstick is None:
            return "noise gain"
        if self.scale is not None:
            return "error in the given scale"
        what = "worst state" if self.k is None else "k x"
        return f"error of {what} / {self.yardstick.judge.beside}'s"

    @property
    def judged(self) -> list[Attempt]:
        """Designs of which that is known."""
        what = self.judged_by
        return [one for one in self.designs if getattr(one, what) is not None]

    def along(self, by: str | None = None) -> str:
        """`by` of `pareto`, or what it is where it is not given."""
        by = ("settling" if self.yardstick is None else "work") if by is None else by
        if by not in COSTS:
            raise ValueError(f"by must be {' or '.join(map(repr, COSTS))}, got {by!r}")
        return by

    def pareto(self, by: str | None = None) -> list[Attempt]:
        """Designs that none of the same or less work beats, by rising work.

        Parameters
        ----------
        by : "work", "order" or "settling", optional
            Multiply-adds per step, observer states, or seconds until a wrong start
            has decayed to 1 %.  Default work where errors are known; where none is,
            designs are judged by their noise gain, against settling.
        """
        front: list[Attempt] = []
        groups: dict[float, list[Attempt]] = {}
        by, what = self.along(by), self.judged_by
        for one in self.judged:
            groups.setdefault(getattr(one, by), []).append(one)
        for cost in sorted(filter(np.isfinite, groups)):
            one = first_least(groups[cost], what)
            if not front or getattr(one, what) < getattr(front[-1], what) * (1 - LEVEL):
                front.append(one)
        return front

    def recommended(self, tolerance: float = TOLERANCE) -> Attempt:
        """The least work among eligible designs within `tolerance` of the yardstick.

        What was not tried is not weighed; `reasons` says so.  Among equal work the
        smaller error wins, then the smaller mean, and among those that differ by LEVEL
        or less the first in the table.  With a budget it is the most accurate design
        within it, whatever the tolerance: the smallest error, then the smallest mean;
        of designs whose error and mean are alike to 1e-4 the least work.

        Raises
        ------
        DesignError
            Where no error is known: in continuous time, or without Q or R.  The
            message says how to get them.  Or if no design is within the budget; it
            names the one that is nearest and what that needs.  `chosen` is None there.
        """
        if not tolerance >= 0:
            raise ValueError(f"tolerance must not be negative, got {tolerance}")
        if self.yardstick is None:
            raise DesignError(" ".join(why_not(self.plant)))
        if self.budget is not None:
            return most_accurate(self)
        near = [one for one in self.eligible if self.excess(one) <= tolerance]
        work = min(one.work for one in near)
        light = [one for one in near if one.work == work]
        return first_least(light, "error")

    @property
    def chosen(self) -> Attempt | None:
        """The recommended design, or None where nothing is recommended."""
        if self.yardstick is None or (self.budget is not None and not fitting(self)):
            return None
        return self.recommended()

    def within(self, **limits: float) -> "Comparison":
        """The same designs under another budget, or without one.

        Parameters
        ----------
        multiply_adds, states, bytes : float, optional
            As `budget` of `compare`.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
        ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])
        >>> table = lb.compare(plant)
        >>> [table.within(multiply_adds=most).recommended().work for most in (3, 4)]
        [3, 4]
        """
        return replace(self, budget=Budget.read(limits) if limits else None)

    def next_beyond(self) -> Attempt | None:
        """What a little more than the budget buys: a more accurate design, or None.

        Only designs that were tried are known.  Of them it is the one that is over the
        budget by the smallest part of a limit; where nothing is within the budget, of
        all of them.
        """
        if self.budget is None or self.yardstick is None:
            return None
        return next_beyond(self)

    def reasons(self, tolerance: float = TOLERANCE) -> list[str]:
        """Why that design is recommended, or nothing is: plain sentences."""
        return reasons(self, tolerance)

    def rows(self) -> list[dict[str, Any]]:
        """One plain dict for each attempt, for JSON or a data frame.

        Numbers are finite, or None where nothing applies.
        """
        chosen, front = self.chosen, self.pareto()
        return [row(self, one, chosen, front) for one in self.attempts]

    @property
    def table(self) -> Table:
        """A `show.Table` of the designs, the recommended one marked."""
        rows = [cells(self, one) for one in self.designs]
        marked = [k for k, one in enumerate(self.designs) if one is self.chosen]
        return Table(header(self), rows, marked=marked)

    @property
    def refusals(self) -> Table:
        """A `show.Table` of what was refused and why, equal reasons together."""
        reasons: dict[tuple[str, str], list[str]] = {}
        for one in self.refused:
            reasons.setdefault((one.method, one.refusal), []).append(one.label)
        rows = [
            [method, labels[0] if len(labels) == 1 else together(labels), reason]
            for (method, reason), labels in reasons.items()
        ]
        return Table(["method", "which", "why there is none"], rows)

    def __repr__(self) -> str:
        tables = [self.table, self.refusals] if self.refused else [self.table]
        return "\n\n".join(map(repr, tables))

    def _repr_html_(self) -> str:
        tables = [self.table, self.refusals] if self.refused else [self.table]
        return "\n".join(one._repr_html_() for one in tables)
