"""The table of a comparison: what is best, what is on the front, what to take."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..numeric.validation import ReadOnly
from ..plant import Plant
from ..show import Table, number
from .attempts import LEVEL, Attempt, first_least
from .reasons import percent, reasons

TOLERANCE = 0.05  # a design this close to the smallest error is good enough


@dataclass(frozen=True, eq=False)
class Comparison(ReadOnly):
    """All designs of one plant, in the order of the table: see `compare`.

    Iterating gives the attempts.  In a notebook it shows as a table, the recommended
    design in bold, and the refusals below.
    """

    plant: Plant
    attempts: tuple[Attempt, ...]
    k: np.ndarray | None = None

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

        Those that know the error, where there are any; without those that a known
        input would disturb: most fixed-order filters of a plant that has one.
        """
        known = self.ranked or self.designs
        calm = [one for one in known if not one.disturbed]
        return calm or known

    @property
    def yardstick(self) -> Attempt | None:
        """What the others are measured against, the most accurate design.

        It is the Kalman filter where there is one; no filter is more accurate.
        Without noise covariances there is none: None.
        """
        ranked = [one for one in self.eligible if one.error is not None]
        for one in ranked:
            if one.method == "Kalman filter":
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

    def pareto(self, by: str = "work") -> list[Attempt]:
        """Designs that none of the same or less work beats, by rising work.

        Parameters
        ----------
        by : "work" or "order"
            Multiply-adds per step, or observer states.
        """
        if by not in ("work", "order"):
            raise ValueError(f"by must be 'work' or 'order', got {by!r}")
        front: list[Attempt] = []
        groups: dict[float, list[Attempt]] = {}
        for one in self.ranked:
            groups.setdefault(getattr(one, by), []).append(one)
        for cost in sorted(groups):
            one = first_least(groups[cost], "error")
            if not front or one.error < front[-1].error * (1 - LEVEL):
                front.append(one)
        return front

    def recommended(self, tolerance: float = TOLERANCE) -> Attempt:
        """The least work among eligible designs within `tolerance` of the yardstick.

        Among equal work the smaller error wins, and among errors that differ by LEVEL
        or less the first in the table.  Where there is no error to weigh, the least
        work of all, and among equal work the smaller noise gain.
        """
        if not tolerance >= 0:
            raise ValueError(f"tolerance must not be negative, got {tolerance}")
        near, weighed = self.eligible, "noise_gain"
        if self.yardstick is not None:
            near = [one for one in near if self.excess(one) <= tolerance]
            weighed = "error"
        work = min(one.work for one in near)
        light = [one for one in near if one.work == work]
        return first_least(light, weighed)

    def reasons(self, tolerance: float = TOLERANCE) -> list[str]:
        """Why that design is recommended: plain sentences."""
        return reasons(self, tolerance)

    def rows(self) -> list[dict[str, Any]]:
        """One plain dict for each attempt, for JSON or a data frame.

        Numbers are finite, or None where nothing applies.
        """
        chosen, front = self.recommended(), self.pareto()
        return [_row(self, one, chosen, front) for one in self.attempts]

    @property
    def table(self) -> Table:
        """A `show.Table` of the designs, the recommended one marked."""
        header = ["method", "which", "order"]
        header += ["error trace"] if self.k is None else ["error of k x", "error trace"]
        header += ["above the best", "worst pole", "noise gain", "cond [T; C]"]
        header += ["multiply-adds", "bytes", "certificate"]
        rows = [_cells(self, one) for one in self.designs]
        return Table(header, rows, marked=[self.designs.index(self.recommended())])

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


def together(labels: Sequence[str]) -> str:
    """Several labels in a few words."""
    return f"{labels[0]}, and {len(labels) - 1} more"


def _cells(table: Comparison, one: Attempt) -> list[str]:
    errors = [one.error] if table.k is None else [one.error, one.trace]
    digits = _digits(one)
    return [
        one.method,
        one.label,
        str(one.order),
        *(_text(value, digits) for value in errors),
        percent(table.excess(one), digits - 1),
        _text(one.worst_pole, 3),
        _text(one.noise_gain, min(digits, 3)),
        _text(one.cond, 2),
        str(one.work),
        _text(one.bytes),
        verdict(one),
    ]


def _digits(one: Attempt) -> int:
    """Digits of an error that rounding leaves, at most 5."""
    return 5 if one.cond is None else int(np.clip(15 - np.log10(one.cond), 2, 5))


def _text(value: float | None, digits: int = 6) -> str:
    return "" if value is None or value == -np.inf else number(value, digits)


def verdict(one: Attempt) -> str:
    """What its certificate, or the conditions of an optimum, say."""
    if not one.sound:
        return "fails"
    return "exact" if one.optimality is None else "optimal"


def _row(
    table: Comparison, one: Attempt, chosen: Attempt, front: list[Attempt]
) -> dict[str, Any]:
    row = dict(
        method=one.method,
        label=one.label,
        order=one.order,
        accurate=[table.plant.output_names[k] for k in one.accurate],
        horizon=one.horizon,
        refusal=one.refusal,
        note=one.note,
        recommended=one is chosen,
        on_front=one in front,
    )
    figures = "error_trace error_of_k excess variances worst_pole noise_gain cond"
    figures = dict.fromkeys(f"{figures} multiply_adds bytes residual poles".split())
    if not one.refusal:
        best = one.optimality
        variances = one.variances
        figures = dict(
            error_trace=one.trace,
            error_of_k=one.error_of_k,
            excess=table.excess(one),
            variances=None if variances is None else variances.tolist(),
            worst_pole=one.worst_pole,
            noise_gain=one.noise_gain,
            cond=one.cond,
            multiply_adds=one.work,
            bytes=one.bytes,
            residual=one.certificate.worst if best is None else best.worst,
            poles=[str(complex(pole)).strip("()") for pole in one.observer.poles],
        )
    return row | {key: _finite(value) for key, value in figures.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value
