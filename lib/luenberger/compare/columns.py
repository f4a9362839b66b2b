"""What a comparison shows of each design: the cells of its table, its plain row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..show import number
from .attempts import Attempt
from .reasons import percent

if TYPE_CHECKING:
    from .table import Comparison


def header(table: Comparison) -> list[str]:
    """The names of the columns, in the order of `cells`."""
    errors = ["settling (s)"]
    if table.yardstick is not None:
        errors = _judged_by(table) + ["error trace"] * (table.k is None)
    return [
        *["method", "which", "order", *errors, "worst pole", "noise gain"],
        *["cond [T; C]", "multiply-adds", _bytes(table), "certificate"],
        *([] if table.budget is None else ["budget"]),
    ]


def _bytes(table: Comparison) -> str:
    return "bytes" if table.dtype == "double" else f"bytes ({table.dtype})"


def _judged_by(table: Comparison) -> list[str]:
    if table.scale is not None:
        return ["error in scale", "above the best"]
    if table.k is not None and len(table.k) == 1:
        name = "k x" if table.called is None else table.called[0]
        return [f"sigma of {name}", "above the best"]
    what = "state" if table.k is None else "row of k x"
    return [f"worst {what}", f"mean {what}"]


def together(labels: Sequence[str]) -> str:
    """Several labels in a few words."""
    return f"{labels[0]}, and {len(labels) - 1} more"


def cells(table: Comparison, one: Attempt) -> list[str]:
    digits = _digits(one)
    if table.yardstick is None:
        judged = [_text(one.settling, 4)]
    else:
        judged = _errors(table, one, digits)
        if table.k is None:
            judged = [*judged, _text(one.trace, digits)]
    return [
        one.method,
        one.label,
        str(one.order),
        *judged,
        _text(one.worst_pole, 3),
        _text(one.noise_gain, min(digits, 3)),
        _text(one.cond, 2),
        str(one.work),
        _text(one.bytes),
        verdict(one),
        *_room(table, one),
    ]


def _room(table: Comparison, one: Attempt) -> list[str]:
    """Whether the budget has room for a design; nothing if there is no budget."""
    if table.budget is None:
        return []
    return ["beyond" if table.budget.over(one) else "within"]


def _errors(table: Comparison, one: Attempt, digits: int) -> list[str]:
    """What a design is judged by; in percent above what it is measured beside."""
    if table.scale is None and (table.k is None or len(table.k) > 1):
        above = (one.worst_ratio, one.mean_ratio)
        return [
            "" if r is None else percent(max(r - 1, 0.0), digits - 1) for r in above
        ]
    error = one.error
    if table.scale is None:  # a deviation in the unit of k x, as the ratio is of these
        error = None if one.error_of_k is None else float(np.sqrt(one.error_of_k))
    return [_text(error, digits), percent(table.excess(one), digits - 1)]


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


FIGURES = (
    "error_trace error_of_k error excess worst_ratio mean_ratio variances worst_pole "
    "settling noise_gain cond multiply_adds operations bytes residual poles"
).split()
CALLED = {"error_trace": "trace", "multiply_adds": "work"}  # by an attempt


def row(
    table: Comparison, one: Attempt, chosen: Attempt | None, front: list[Attempt]
) -> dict[str, Any]:
    found = dict(
        method=one.method,
        label=one.label,
        order=one.order,
        accurate=[table.plant.output_names[k] for k in one.accurate],
        horizon=one.horizon,
        refusal=one.refusal,
        note=one.note,
        form=None if one.refusal else one.form,
        recommended=one is chosen,
        on_front=one in front,
        within_budget=_fits(table, one),
    )
    figures: dict[str, Any] = dict.fromkeys(FIGURES)
    if not one.refusal:
        best, variances = one.optimality, one.variances
        made = dict(
            excess=table.excess(one),
            variances=None if variances is None else variances.tolist(),
            residual=one.certificate.worst if best is None else best.worst,
            poles=[str(complex(pole)).strip("()") for pole in one.observer.poles],
        )
        kept = [name for name in FIGURES if name not in made]
        figures |= made | {name: getattr(one, CALLED.get(name, name)) for name in kept}
    return found | {key: _finite(value) for key, value in figures.items()}


def _fits(table: Comparison, one: Attempt) -> bool | None:
    """None where there is no budget, or no design."""
    unknown = table.budget is None or one.refusal
    return None if unknown else not table.budget.over(one)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value
