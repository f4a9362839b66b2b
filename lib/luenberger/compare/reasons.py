"""Why one design is recommended, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..numeric import Vector
from ..show import number
from .attempts import Attempt, first_least
from .unweighed import left_to_weigh, why_not

if TYPE_CHECKING:
    from .table import Comparison


def reasons(table: Comparison, tolerance: float) -> list[str]:
    """The rule, what the design costs and saves, and what was passed over."""
    if table.yardstick is None:
        return [*why_not(table.plant), *left_to_weigh(table)]
    chosen = table.recommended(tolerance)
    return [
        _rule(table, tolerance),
        *_price(table, chosen),
        *_remark(chosen),
        *_passed_over(table, chosen, tolerance),
        _next_smaller(table, chosen),
    ]


def count(size: int, noun: str) -> str:
    """ "no states", "1 state", "2 states"."""
    return f"{size or 'no'} {noun}{'' if size == 1 else 's'}"


def above(excess: float) -> str:
    """ "3.00 % above", "12 times"."""
    return percent(excess) + (" above" if excess < 10 else "")


def sigma(design: Attempt) -> Vector:
    """Standard deviations of what a design estimates."""
    return np.sqrt(design.variances)


def ranking(table: Comparison) -> str:
    """What designs are ranked by."""
    return "error trace" if table.k is None else "error variance of k x"


def _rule(table: Comparison, tolerance: float) -> str:
    return (
        "The rule: the fewest multiply-adds per step among the designs whose "
        f"{ranking(table)} is at most {number(100 * tolerance)} % above the smallest."
    )


def _price(table: Comparison, chosen: Attempt) -> Iterator[str]:
    best, what = table.yardstick, ranking(table)
    if chosen is best:
        yield (
            f"It is the most accurate design of all, with the {what} "
            f"{number(best.error, 5)}, and no lighter one comes near enough."
        )
        return
    excess = table.excess(chosen)
    if excess == 0:
        yield f"Nothing is lost: its {what} is that of the {best.name}."
    else:
        yield (
            f"Its {what} is {number(chosen.error, 5)}, {above(excess)} the "
            f"{number(best.error, 5)} of the most accurate design ({best.name})."
        )
    yield _saving(chosen, best)
    if excess > 0 and chosen.whole and best.whole:
        k, ratio = worst_state(chosen, best)
        yield (
            f"The state that loses most is {table.plant.state_names[k]}: its standard "
            f"deviation grows by {percent(ratio - 1)}."
        )


def _saving(chosen: Attempt, best: Attempt) -> str:
    saved = 1 - chosen.work / best.work if best.work else 0.0
    less = f"{100 * abs(saved):.0f} % {'less' if saved >= 0 else 'more'}"
    return (
        f"It runs with {count(chosen.order, 'observer state')} instead of {best.order} "
        f"and {chosen.work} multiply-adds a step instead of {best.work}, {less}."
    )


def worst_state(chosen: Attempt, best: Attempt) -> tuple[int, float]:
    """Index of the state whose standard deviation grows most, and the ratio."""
    new, old = sigma(chosen), sigma(best)
    ratio = np.where(old > 1e-12 * old.max(), new / np.where(old > 0, old, 1), 1.0)
    return int(np.argmax(np.round(ratio, 9))), float(ratio.max())


def _remark(chosen: Attempt) -> Iterator[str]:
    if not chosen.exact:
        yield (
            "It is not exact: it lets the state disturb the estimate where that costs "
            "less than noise would. It is the best of its order as long as the plant "
            "and its noise are as the model says."
        )
    if chosen.note:
        yield chosen.note


def _passed_over(table: Comparison, chosen: Attempt, tolerance: float) -> Iterator[str]:
    """Designs that the rule would prefer if a known input did not disturb them."""
    lighter = [
        one
        for one in table.ranked
        if one not in table.eligible
        and table.excess(one) <= tolerance
        and one.work < chosen.work
    ]
    if lighter:
        least = min(lighter, key=lambda one: one.work)
        yield (
            f"Passed over: {least.name}, with {least.work} multiply-adds a step. Its "
            "error is as small only while the known input is zero."
        )


def _next_smaller(table: Comparison, chosen: Attempt) -> str:
    smaller = [one for one in table.ranked if one.order < chosen.order]
    if not smaller:
        return "No design has fewer observer states."
    least = first_least(smaller, "error")
    excess = table.excess(least)
    beside = f"{above(excess)} the smallest"
    if excess == np.inf:
        beside = "and the smallest is 0"
    return (
        f"With fewer observer states the best is {least.title}: its "
        f"{ranking(table)} is {number(least.error, 5)}, {beside}."
    )


def percent(excess: float, digits: int = 4) -> str:
    """A fraction as text; empty where not known."""
    if excess is None:
        return ""
    if not np.isfinite(excess):
        return "unbounded"
    if excess < 10:
        return f"{100 * excess:.2f} %"
    return f"{number(1 + excess, digits)} times"
