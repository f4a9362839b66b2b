"""The table of designs on many plants: spread, worst case, and what to take."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.validation import ReadOnly
from ..show import Table, number
from .attempts import LEVEL
from .cases import Case, Spread
from .perturbed import Perturbed
from .reasons import percent
from .reviews import Reviews
from .robust_reasons import reasons

COLUMNS = ("least", "lower quartile", "median", "upper quartile", "worst")


@dataclass(frozen=True, eq=False)
class Robustness(Reviews, ReadOnly):
    """Designs on all plants, in the order in which they were given: see `robustness`.

    Iterating gives the `Spread` of each design.  In a notebook it shows as a table,
    the recommended design in bold.

    Attributes
    ----------
    spreads : tuple of Spread
    plants : tuple of Perturbed
        Their names, the plants, and the values of what was varied.
    scale : (q,) ndarray or None
        Typical sizes, if they were given.
    seed : int or None
        From which plants were drawn.
    estimates : tuple of str
        Names of what is judged: of the states, or of the rows of k x.
    whole : bool
        Whether that is the state, and not k x.
    """

    spreads: tuple[Spread, ...]
    plants: tuple[Perturbed, ...]
    scale: np.ndarray | None = None
    seed: int | None = None
    estimates: tuple[str, ...] = ()
    whole: bool = True

    def __iter__(self) -> Iterator[Spread]:
        return iter(self.spreads)

    def __len__(self) -> int:
        return len(self.spreads)

    def find(self, design: str, plant: str) -> Case:
        """The case of a design on a plant, by their names."""
        for spread in self.spreads:
            for one in spread.cases:
                if (one.design, one.plant) == (design, plant):
                    return one
        raise KeyError(f"no case of {design!r} on {plant!r}")

    @property
    def errors(self) -> Matrix:
        """Errors, (designs, plants), inf where one grows, NaN where it is not known."""
        return np.array([one.errors for one in self.spreads])

    @property
    def worst(self) -> dict[str, Case | None]:
        """For each design the plant that is worst for it; None where not known."""
        return {one.name: one.worst for one in self.spreads}

    @property
    def ranked(self) -> list[Spread]:
        """Designs whose error is known on every plant, the least worst case first.

        Among equal ones the least work comes first, then the first that was given.
        """
        known = [one for one in self.spreads if one.known]
        least = sorted(known, key=lambda one: one.worst.error)
        found: list[Spread] = []
        while least:
            most = least[0].worst.error * (1 + LEVEL)
            level = [one for one in least if one.worst.error <= most]
            found += sorted(level, key=lambda one: one.work)
            least = least[len(level) :]
        return found

    def recommended(self, tolerance: float = 0.0) -> Spread:
        """The minimax choice: the design whose largest error is least.

        With a tolerance, the least work among the designs whose largest error is that
        fraction above the least, or less.

        Raises
        ------
        DesignError
            If no design has a finite error on every plant; it names one on which each
            design fails.  `chosen` is None there.
        """
        if not tolerance >= 0:
            raise ValueError(f"tolerance must not be negative, got {tolerance}")
        finite = [one for one in self.ranked if np.isfinite(one.worst.error)]
        if not finite:
            raise DesignError(
                "no design has a known, finite error on every plant: "
                + "; ".join(_failure(one) for one in self.spreads)
            )
        most = finite[0].worst.error * (1 + tolerance) * (1 + LEVEL)
        near = [one for one in finite if one.worst.error <= most]
        return min(near, key=lambda one: one.work) if tolerance else finite[0]

    @property
    def chosen(self) -> Spread | None:
        """The minimax choice, or None where there is none."""
        try:
            return self.recommended()
        except DesignError:
            return None

    def reasons(self) -> list[str]:
        """Why that design is recommended, or none is: plain sentences."""
        return reasons(self)

    def rows(self) -> list[dict[str, Any]]:
        """One plain dict for each design on each plant, for JSON or a data frame.

        Numbers are finite, or None where none applies.
        """
        return [_row(one) for spread in self.spreads for one in spread.cases]

    def said(self, error: float | None) -> str:
        """An error as the table writes it: a ratio as what it is above 1."""
        if error is None:
            return "not known"
        if not np.isfinite(error):
            return "unbounded"
        if self.scale is not None:
            return number(error, 4)
        return percent(max(error - 1, 0.0))

    @property
    def table(self) -> Table:
        """A `show.Table` of the designs, the recommended one marked."""
        nominal = self.spreads[0].nominal is not None
        rows, chosen = [], self.chosen
        for one in self.spreads:
            figures = one.quartiles
            errors = [None] * len(COLUMNS) if figures is None else list(figures)
            if nominal:
                errors = [one.nominal.error, *errors]
            at = one.worst.plant if one.known else ""
            first = [one.name, str(one.observer.order), str(one.work)]
            rows.append([*first, *map(self.said, errors), at])
        header = ["design", "order", "multiply-adds", *["nominal"] * nominal]
        marked = [k for k, one in enumerate(self.spreads) if one is chosen]
        return Table([*header, *COLUMNS, "worst on"], rows, marked=marked)

    def __repr__(self) -> str:
        return repr(self.table)

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def _failure(spread: Spread) -> str:
    bad = next(one for one in spread.cases if one.refusal)
    return f"{spread.name} on {bad.plant}, {bad.refusal}"


def _row(one: Case) -> dict[str, Any]:
    X, known = one.covariance, one.error is not None and np.isfinite(one.error)
    return dict(
        design=one.design,
        plant=one.plant,
        error=one.error if known else None,
        variances=None if X is None else X.diagonal().tolist(),
        bias=None if one.bias is None else one.bias.tolist(),
        drawn=one.drawn,
        refusal=one.refusal,
        **{name: float(value) for name, value in one.values.items()},
    )
