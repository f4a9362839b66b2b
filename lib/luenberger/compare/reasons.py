"""Why one design is recommended, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..numeric import Vector
from ..show import number
from .assumed import assumed
from .attempts import KALMAN, Attempt, first_least
from .budget import amount, listed, needs, refusal
from .untried import among, untried
from .unweighed import left_to_weigh, why_not

if TYPE_CHECKING:
    from .table import Comparison


def reasons(table: Comparison, tolerance: float) -> list[str]:
    """The rule, what the design costs and saves, and what was passed over."""
    if table.yardstick is None:
        return [*why_not(table.plant), *left_to_weigh(table)]
    if table.budget is not None:
        return [*_within_budget(table)]
    chosen = table.recommended(tolerance)
    return [
        _rule(table, tolerance),
        *assumed(table),
        *_price(table, chosen),
        *_remark(chosen),
        *_passed_over(table),
        *untried(table),
        _next_smaller(table, chosen),
    ]


def _within_budget(table: Comparison) -> Iterator[str]:
    """The same with a budget, and what a little more would buy."""
    chosen, beyond = table.chosen, table.next_beyond()
    if chosen is None:
        yield from refusal(table)
        return
    tried = among(table, " of those tried")
    rule = f"the most accurate design{tried} within the budget of {table.budget}"
    yield f"The rule: {rule}."
    yield f"Designs are judged by their {ranking(table).rstrip(',')}."
    yield from assumed(table)
    yield f"It needs {needs(chosen)}."
    yield from _price(table, chosen)
    yield from _remark(chosen)
    yield from _passed_over(table)
    yield from untried(table)
    if beyond is None:
        yield (
            f"More would buy nothing: no design{tried} beyond the budget is more "
            "accurate."
        )
        return
    more, least = table.budget.over(beyond).items(), beyond is table.yardstick
    bought = f"it is the most accurate{_all(table)}" if least else _loses(table, beyond)
    yield (
        f"The next one{tried} beyond the budget is the {beyond.title}: for "
        f"{listed(amount(size, name) for name, size in more)} more, "
        f"{bought}."
    )


def count(size: int, noun: str) -> str:
    """ "no states", "1 state", "2 states"."""
    return f"{size or 'no'} {noun}{'' if size == 1 else 's'}"


def above(excess: float) -> str:
    """ "3.00 % above", "12 times"."""
    return percent(excess) + (" above" if excess < 10 else "")


def sigma(design: Attempt) -> Vector:
    """Standard deviations of what a design estimates."""
    return np.sqrt(design.variances)


def by_ratio(table: Comparison) -> bool:
    """Whether each state, or each of several rows of k x, is judged by itself."""
    return table.scale is None and (table.k is None or len(table.k) > 1)


def _one(table: Comparison) -> str:
    return "state" if table.k is None else "row of k x"


def _beside(table: Comparison) -> str:
    """What the standard deviations are measured beside."""
    return f"that of the {table.yardstick.judge.beside}"


def ranking(table: Comparison) -> str:
    """What designs are ranked by."""
    if table.scale is not None:
        return "error in the given scale"
    if table.k is not None and len(table.k) == 1:
        return "standard deviation of k x"
    return f"worst {_one(table)}, its standard deviation beside {_beside(table)},"


def _rule(table: Comparison, tolerance: float) -> str:
    least, most = table.yardstick, f"{number(100 * tolerance)} % above"
    tried = among(table, " tried")
    rule = f"The rule: the fewest multiply-adds per step among the designs{tried}"
    if by_ratio(table) and least.method == least.judge.beside:
        return (
            f"{rule} in which no {_one(table)} has a standard deviation more than "
            f"{most} {_beside(table)}."
        )
    return f"{rule} whose {ranking(table)} is at most {most} the smallest."


def _price(table: Comparison, chosen: Attempt) -> Iterator[str]:
    best = table.yardstick
    if chosen is best:
        tried = among(table, " that was tried")
        light = f", and no lighter one{tried} comes near enough"
        light = light if table.budget is None else ""
        yield f"It is the most accurate design{_all(table)}{light}."
        return
    excess = table.excess(chosen)
    if excess == 0:
        yield f"Nothing is lost: it is as accurate as the {best.name}."
    elif by_ratio(table):
        yield from _states(table, chosen)
    else:
        yield (
            f"Its {ranking(table)} is {number(_shown(chosen), 4)}, {above(excess)} the "
            f"{number(_shown(best), 4)} of the most accurate design ({best.name})."
        )
    if table.k is None and table.scale is None:
        yield (
            f"Its error trace is {number(chosen.trace, 5)}, and that of the "
            f"{best.name} {number(best.trace, 5)}. The trace adds variances of all "
            "units, so it does not decide."
        )
    yield _saving(chosen, best)


def _all(table: Comparison) -> str:
    """Among which designs the yardstick is the most accurate.

    No filter is more accurate than the Kalman filter, tried or not.
    """
    least = table.yardstick.method == KALMAN
    return " of all" if least else among(table, " of those tried") or " of all"


def _shown(one: Attempt) -> float:
    """An error as a standard deviation, in its own unit if there is one."""
    alone = one.judge.scale is None and len(one.judged) == 1
    return float(np.sqrt(one.judged[0])) if alone else one.error


def _states(table: Comparison, chosen: Attempt) -> Iterator[str]:
    """The state, or row of k x, that loses most, and the mean over all."""
    yield f"What loses most: the standard deviation of {_worst(table, chosen)}."
    if (count := len(chosen.ratios)) > 1:
        more = above(max(chosen.mean_ratio - 1, 0.0))
        what = "states" if table.k is None else "rows of k x"
        yield f"The mean over all {count} {what} is {more}."


def _worst(table: Comparison, one: Attempt) -> str:
    """Which standard deviation grows most, and how much."""
    k = int(np.argmax(np.round(one.ratios, 9)))
    name = table.estimates[k]
    if one.worst_ratio == np.inf:
        return f"{name} is not zero, and {_beside(table)} is"
    return f"{name} is {above(max(one.worst_ratio - 1, 0.0))} {_beside(table)}"


def _saving(chosen: Attempt, best: Attempt) -> str:
    saved = 1 - chosen.work / best.work if best.work else 0.0
    less = f"{100 * abs(saved):.0f} % {'less' if saved >= 0 else 'more'}"
    return (
        f"It runs with {count(chosen.order, 'observer state')} instead of {best.order} "
        f"and {chosen.work} multiply-adds a step instead of {best.work}, {less}."
    )


def _remark(chosen: Attempt) -> Iterator[str]:
    if not chosen.exact:
        yield (
            "It is not exact: it lets the state disturb the estimate where that costs "
            "less than noise would. It is the best of its order as long as the plant "
            "and its noise are as the model says."
        )
    if chosen.note:
        yield chosen.note


def _passed_over(table: Comparison) -> Iterator[str]:
    """Designs of which no error is known, as a known input disturbs them."""
    unknown = [one for one in table.designs if one.disturbed and one.error is None]
    if unknown:
        yield (
            f"Not weighed: {count(len(unknown), 'design')} whose estimate the known "
            "input disturbs. They are weighed once plant.with_input(U) says what it "
            "is like."
        )


def _next_smaller(table: Comparison, chosen: Attempt) -> str:
    smaller = [one for one in table.ranked if one.order < chosen.order]
    if not smaller:
        return f"No design{among(table, ' that was tried')} has fewer observer states."
    least = first_least(smaller, "error")
    tried = among(table, " of those tried")
    said = f"With fewer observer states the best{tried} is {least.title}:"
    return f"{said} {_loses(table, least)}."


def _loses(table: Comparison, one: Attempt) -> str:
    """By how much a design is less accurate than the best."""
    if by_ratio(table):
        return f"the standard deviation of {_worst(table, one)}"
    excess = table.excess(one)
    end = f"{above(excess)} the smallest"
    if excess == np.inf:
        end = "and the smallest is 0"
    return f"its {ranking(table)} is {number(_shown(one), 4)}, {end}"


def percent(excess: float, digits: int = 4) -> str:
    """A fraction as text; empty where not known."""
    if excess is None:
        return ""
    if not np.isfinite(excess):
        return "unbounded"
    if excess < 10:
        return f"{100 * excess:.2f} %"
    return f"{number(1 + excess, digits)} times"
