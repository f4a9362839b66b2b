"""The table of a comparison: what is best, what is on the front, what to take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.validation import ReadOnly
from ..plant import Plant
from ..show import Table, number
from .choice import (
    ALONG,
    TOLERANCE,
    Budget,
    excess,
    fitting,
    front,
    lightest_near,
    most_accurate,
    next_beyond,
    yardstick,
)
from .judge import NOMINAL, Case, Design
from .words import percent, reasons, refusal, why_not

FIGURES = (
    "error excess worst_ratio mean_ratio worst_on sigma worst_pole settling noise_gain "
    "cond multiply_adds operations bytes residual poles"
).split()


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(ReadOnly):
    """All designs of one plant on all plants, in the order of the table: see `compare`.

    Iterating gives the designs and the refusals.  In a notebook it shows as a table,
    the recommended design in bold, and the refusals below.

    Attributes
    ----------
    plant : Plant
        What the designs are for.
    every : tuple of Design
        Designs, and those that were refused.
    plants : dict of str to Plant
        What they are judged on, the plant itself first, as "nominal".
    rows : (q, n) ndarray or None
        L, the combinations that are estimated, or None for the state.
    estimates : tuple of str
        Names of what is estimated: of the states, or of the rows of L x.
    scale : (q,) ndarray or None
        Typical sizes, if they were given.
    budget : Budget
        What there is to spare; without limits if none were given.
    untried : tuple of str
        What was left out, as it would have taken long.
    searched : tuple of int
        Fixed orders that were tried beyond the first few.
    """

    plant: Plant
    every: tuple[Design, ...]
    plants: Mapping[str, Plant]
    rows: np.ndarray | None = None
    estimates: tuple[str, ...] = ()
    scale: np.ndarray | None = None
    budget: Budget = field(default_factory=Budget)
    untried: tuple[str, ...] = ()
    searched: tuple[int, ...] = ()

    def __iter__(self) -> Iterator[Design]:
        return iter(self.every)

    def __len__(self) -> int:
        return len(self.every)

    @property
    def L(self) -> Matrix | dict[str, Matrix] | None:
        """What is estimated, as functions that design take it; None for the state."""
        return None if self.rows is None else dict(zip(self.estimates, self.rows))

    @property
    def designs(self) -> list[Design]:
        """Those that gave an observer."""
        return [one for one in self.every if not one.refusal]

    @property
    def refused(self) -> list[Design]:
        """Those that were refused."""
        return [one for one in self.every if one.refusal]

    @property
    def ranked(self) -> list[Design]:
        """Designs whose error is known on every plant."""
        return [one for one in self.designs if one.error is not None]

    @property
    def eligible(self) -> list[Design]:
        """Designs that may be recommended.

        Those of which the error is known, where there are any.  It is not known of
        those that a known input disturbs, most fixed-order filters of a plant that
        has one, unless the comparison was told what the input is like.
        """
        calm = [one for one in self.designs if not one.disturbed]
        return self.ranked or calm or self.designs

    @cached_property
    def yardstick(self) -> Design | None:
        """What the others are measured against, the most accurate design.

        On its own plant it is the Kalman filter where there is one; no filter is more
        accurate.  None where no error is known.
        """
        return yardstick(self.ranked)

    def excess(self, design: Design) -> float | None:
        """Error beyond the yardstick's, as a fraction of it; None if not known."""
        least = None if self.yardstick is None else self.yardstick.error
        return excess(design.error, least)

    def find(self, method: str, **known: object) -> Design:
        """The first design of a method with these attributes.

        ``table.find("Leondes-Novak filter", accurate=(0,), horizon="steady")``
        """
        for one in self.every:
            fits = (getattr(one, name) == value for name, value in known.items())
            if method in (one.method, one.name, one.title) and all(fits):
                return one
        raise KeyError(f"no {method!r} with {known} is in the comparison")

    @property
    def judged_by(self) -> str:
        """The figure of a design that decides.

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
        what = "worst state" if self.rows is None else "L x"
        return f"error of {what} / Kalman filter's"

    @property
    def judged(self) -> list[Design]:
        """Designs of which that is known."""
        what = self.judged_by
        return [one for one in self.designs if getattr(one, what) is not None]

    def along(self, by: str | None = None) -> str:
        """`by` of `pareto`, or what it is where it is not given."""
        by = ("settling" if self.yardstick is None else "work") if by is None else by
        if by not in ALONG:
            raise ValueError(f"by must be {' or '.join(map(repr, ALONG))}, got {by!r}")
        return by

    def pareto(self, by: str | None = None) -> list[Design]:
        """Designs that none of the same or less work beats, by rising work.

        Parameters
        ----------
        by : "work", "order" or "settling", optional
            Multiply-adds per step, observer states, or seconds until a wrong start
            has decayed to 1 %.  Default work where errors are known; where none is,
            designs are judged by their noise gain, against settling.
        """
        return front(self.judged, self.along(by), self.judged_by)

    def recommended(self, tolerance: float = TOLERANCE) -> Design:
        """The least work among eligible designs within `tolerance` of the yardstick.

        Among equal work the smaller error wins, then the smaller mean, and among those
        that differ by rounding the first in the table.  On several plants the error of
        a design is that on the worst of them, so that a tolerance of 0 is the minimax
        choice.  Under a budget it is the most accurate design within it, whatever the
        tolerance; of designs whose error and mean are alike to 1e-4 the least work.

        Raises
        ------
        DesignError
            Where no error is known: in continuous time, or without Q or R.  The
            message says how to get them.  Or if no design is within the budget, or
            each fails on some plant; it says on which.  `chosen` is None there.
        """
        if not tolerance >= 0:
            raise ValueError(f"tolerance must not be negative, got {tolerance}")
        if self.yardstick is None:
            raise DesignError(" ".join(why_not(self)))
        if self.yardstick.error == np.inf:
            raise DesignError(
                "no design has a finite error on every plant: "
                + "; ".join(
                    f"{one.name} on {one.worst_on}, {one.cases[one.worst_on].refusal}"
                    for one in self.ranked
                    if one.worst_on is not None
                )
            )
        if not self.budget.limits:
            return lightest_near(self, tolerance)
        fit = fitting(self)
        if not fit:
            raise DesignError(" ".join(refusal(self)))
        return most_accurate(fit)

    @property
    def chosen(self) -> Design | None:
        """The recommended design, or None where nothing is recommended."""
        try:
            return self.recommended()
        except DesignError:
            return None

    def within(self, **limits: float) -> Comparison:
        """The same designs under another budget, or without one.

        No design is made: orders that only the other budget has room for are not
        tried; `compare(plant, budget=...)` tries them.

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
        budget = Budget.read(limits | {"dtype": self.budget.dtype})
        return replace(self, budget=budget)

    def next_beyond(self) -> Design | None:
        """What a little more than the budget buys: a more accurate design, or None.

        It is the one that is over the budget by the smallest part of a limit; where
        nothing is within the budget, of all of them.
        """
        if not self.budget.limits or self.yardstick is None:
            return None
        return next_beyond(self)

    def reasons(self, tolerance: float = TOLERANCE) -> list[str]:
        """Why that design is recommended, or nothing is: plain sentences."""
        return reasons(self, tolerance)

    # -- what is shown

    def to_rows(self) -> list[dict[str, Any]]:
        """One plain dict for each design and each refusal, for JSON or a data frame.

        Numbers are finite, or None where nothing applies; sigma are the standard
        deviations of `estimates`, each in its own unit.
        """
        chosen, on_front = self.chosen, self.pareto()
        return [_row(self, one, chosen, on_front) for one in self.every]

    def to_cases(self) -> list[dict[str, Any]]:
        """One plain dict for each design on each plant."""
        return [
            _case(one, name, case)
            for one in self.designs
            for name, case in one.cases.items()
        ]

    def to_frame(self) -> Any:
        """`to_rows` as a data frame of pandas.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
        >>> frame = lb.compare(plant, {"mine": lb.kalman_filter}).to_frame()
        >>> frame[["method", "order", "recommended"]].values.tolist()
        [['mine', 1, True]]
        """
        try:
            import pandas
        except ImportError:
            raise ImportError(
                "to_frame needs pandas, which is not installed: pip install pandas, "
                "or take to_rows(), a list of plain dicts"
            ) from None
        return pandas.DataFrame(self.to_rows())

    @property
    def table(self) -> Table:
        """A `show.Table` of the designs, the recommended one marked."""
        rows = [_cells(self, one) for one in self.designs]
        marked = [k for k, one in enumerate(self.designs) if one is self.chosen]
        return Table(_header(self), rows, marked=marked)

    @property
    def refusals(self) -> Table:
        """A `show.Table` of what was refused and why, equal reasons together."""
        reasons: dict[tuple[str, str], list[str]] = {}
        for one in self.refused:
            reasons.setdefault((one.method, one.refusal), []).append(one.label)
        rows = [
            [
                method,
                labels[0] + (f", and {len(labels) - 1} more" if labels[1:] else ""),
                reason,
            ]
            for (method, reason), labels in reasons.items()
        ]
        return Table(["method", "which", "why there is none"], rows)

    def __repr__(self) -> str:
        tables = [self.table, self.refusals] if self.refused else [self.table]
        return "\n\n".join(map(repr, tables))

    def _repr_html_(self) -> str:
        tables = [self.table, self.refusals] if self.refused else [self.table]
        return "\n".join(one._repr_html_() for one in tables)


# -- columns -----------------------------------------------------------------------


def _header(table: Comparison) -> list[str]:
    """The names of the columns, in the order of `_cells`."""
    names = ["method", *(["which"] if _labelled(table) else []), "order"]
    bytes_of = table.budget.dtype
    return [
        *names,
        *_judged_by(table),
        *(["worst pole", "noise gain", "cond [T; C]"] if _alone(table) else []),
        "multiply-adds",
        *(["bytes" if bytes_of == "double" else f"bytes ({bytes_of})"]),
        *(["certificate"] if _alone(table) else []),
        *(["budget"] if table.budget.limits else []),
    ]


def _labelled(table: Comparison) -> bool:
    return any(one.label for one in table.every)


def _alone(table: Comparison) -> bool:
    return len(table.plants) == 1


def _judged_by(table: Comparison) -> list[str]:
    if table.yardstick is None:
        return ["settling (s)"]
    if not _alone(table):
        return [NOMINAL, "median", "worst", "worst on"]
    if table.scale is not None:
        return ["error in scale", "above the best"]
    if table.rows is not None and len(table.rows) == 1:
        return [f"sigma of {table.estimates[0]}", "above the best"]
    what = "state" if table.rows is None else "row of L x"
    return [f"worst {what}", f"mean {what}"]


def _cells(table: Comparison, one: Design) -> list[str]:
    digits = _digits(one)
    shown = [one.method, *([one.label] if _labelled(table) else []), str(one.order)]
    if table.yardstick is None:
        shown += [_text(one.settling, 4)]
    elif _alone(table):
        shown += _errors(table, one, digits)
    else:
        shown += _spread(table, one)
    if _alone(table):
        shown += [
            _text(one.worst_pole, 3),
            _text(one.noise_gain, min(digits, 3)),
            _text(one.cond, 2),
        ]
    shown += [str(one.work), _text(one.bytes)]
    if _alone(table):
        kind = "exact" if one.optimality is None else "optimal"
        shown += [kind if one.sound else "fails"]
    if table.budget.limits:
        shown += ["beyond" if table.budget.over(one) else "within"]
    return shown


def _errors(table: Comparison, one: Design, digits: int) -> list[str]:
    """What a design is judged by; in percent above what it is measured beside."""
    if table.scale is None and (table.rows is None or len(table.rows) > 1):
        above = (one.worst_ratio, one.mean_ratio)
        return [
            "" if r is None else percent(max(r - 1, 0.0), digits - 1) for r in above
        ]
    error = one.error
    if table.scale is None:  # a deviation in the unit of L x, as the ratio is of these
        error = None if one.sigma is None else float(one.sigma[0])
    return [_text(error, digits), percent(table.excess(one), digits - 1)]


def _spread(table: Comparison, one: Design) -> list[str]:
    errors = [np.nan if x is None else x for x in one.errors.values()]
    median = float(np.quantile(errors, 0.5, method="inverted_cdf"))
    known = [one.nominal.error, None if np.isnan(median) else median, one.error]
    return [*(said(table, x) for x in known), one.worst_on or ""]


def said(table: Comparison, error: float | None) -> str:
    """An error as the table writes it: a ratio as what it is above 1."""
    if error is None:
        return "not known"
    if table.scale is not None and np.isfinite(error):
        return number(error, 4)
    return percent(max(error - 1, 0.0))


def _digits(one: Design) -> int:
    """Digits of an error that rounding leaves, at most 5."""
    return 5 if one.cond is None else int(np.clip(15 - np.log10(one.cond), 2, 5))


def _text(value: float | None, digits: int = 6) -> str:
    return "" if value is None or value == -np.inf else number(value, digits)


# -- plain dicts -------------------------------------------------------------------


def _row(
    table: Comparison, one: Design, chosen: Design | None, on_front: list[Design]
) -> dict[str, Any]:
    found: dict[str, Any] = dict(
        method=one.method,
        label=one.label,
        order=one.order,
        accurate=[table.plant.output_names[k] for k in one.accurate],
        horizon=one.horizon,
        refusal=one.refusal,
        note=one.note,
        recommended=one is chosen,
        on_front=one in on_front,
        within_budget=(
            not table.budget.over(one)
            if table.budget.limits and not one.refusal
            else None
        ),
    )
    figures: dict[str, Any] = dict.fromkeys(FIGURES)
    if one.observer is not None and one.certificate is not None and not one.refusal:
        best = one.optimality
        timed = one.cost is not None and one.observer.dt > 0
        made = dict(
            excess=table.excess(one),
            sigma=None if one.sigma is None else one.sigma.tolist(),
            multiply_adds=one.work,
            operations=one.cost.operations if timed and one.cost else None,
            residual=one.certificate.worst if best is None else best.worst,
            poles=[str(complex(pole)).strip("()") for pole in one.observer.poles],
        )
        kept = [name for name in FIGURES if name not in made]
        figures |= made | {name: getattr(one, name) for name in kept}
    return found | {key: _finite(value) for key, value in figures.items()}


def _case(one: Design, plant: str, case: Case) -> dict[str, Any]:
    return dict(
        design=one.title,
        plant=plant,
        error=_finite(case.error),
        sigma=None if case.sigma is None else case.sigma.tolist(),
        refusal=case.refusal,
    )


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value
