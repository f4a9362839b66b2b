"""Why one design is recommended, or none is, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..errors import FIT, SAMPLE
from ..numeric import Vector
from ..plant import Plant
from ..show import counted, number
from .choice import COSTS, amount, first_least, fitting, listed, next_beyond
from .designs import KALMAN
from .judge import Design

if TYPE_CHECKING:
    from .table import Comparison

COMMAND = "python -m luenberger fit PLANT.json DATA.csv --out FITTED.json"


def reasons(table: Comparison, tolerance: float) -> list[str]:
    """The rule, what the design costs and saves, and what was passed over."""
    if table.yardstick is None:
        return [*why_not(table), *_left_to_weigh(table)]
    if table.yardstick.error == np.inf:
        none = "Nothing is recommended: no design is safe on every plant."
        return [none, *_growing(table), *_not_weighed(table)]
    if not table.budget.limits:
        chosen = table.recommended(tolerance)
        rule, last = _rule(table, tolerance), _next_smaller(table, chosen)
    elif not fitting(table):
        return [*refusal(table)]
    else:
        chosen = table.recommended()
        rule = (
            f"The rule: the most accurate design in the table within the budget of "
            f"{table.budget}. Designs are judged by their {ranking(table).rstrip(',')}."
            f" It needs {needs(chosen)}."
        )
        last = _beyond(table)
    return [
        *_plants(table),
        rule,
        *_assumed(table),
        *_price(table, chosen),
        *_remark(chosen),
        *_growing(table),
        *_not_weighed(table),
        *_untried(table),
        last,
    ]


def percent(excess: float | None, digits: int = 4) -> str:
    """A fraction as text; empty where not known."""
    if excess is None:
        return ""
    if not np.isfinite(excess):
        return "unbounded"
    if excess < 10:
        return f"{100 * excess:.2f} %"
    return f"{number(1 + excess, digits)} times"


def above(excess: float) -> str:
    """ "3.00 % above", "12 times"."""
    return percent(excess) + (" above" if excess < 10 else "")


def needs(one: Design) -> str:
    """What a design costs, in words."""
    costs = {name: getattr(one, COSTS[name][0]) for name in COSTS}
    return listed(amount(x, name) for name, x in costs.items() if x is not None)


# -- the rule and its price --------------------------------------------------------


def ranking(table: Comparison) -> str:
    """What designs are ranked by."""
    if table.scale is not None:
        return "error in the given scale"
    if table.rows is not None and len(table.rows) == 1:
        return f"standard deviation of {table.estimates[0]}"
    return f"worst {_one(table)}, its standard deviation beside {_beside(table)},"


def by_ratio(table: Comparison) -> bool:
    """Whether each state, or each of several rows of L x, is judged by itself."""
    return table.scale is None and (table.rows is None or len(table.rows) > 1)


def _one(table: Comparison) -> str:
    return "state" if table.rows is None else "row of L x"


def _beside(table: Comparison) -> str:
    """What the standard deviations are measured beside."""
    each = "" if len(table.plants) == 1 else "plant's own "
    return f"that of the {each}Kalman filter"


def _plants(table: Comparison) -> Iterator[str]:
    if len(table.plants) > 1:
        yield (
            f"Each design is judged on {counted(len(table.plants), 'plant')}, the "
            "nominal one among them, and its error is that on the worst of them."
        )


def _rule(table: Comparison, tolerance: float) -> str:
    least, most = table.yardstick, f"{number(100 * tolerance)} % above"
    rule = "The rule: the fewest multiply-adds per step among the designs in the table"
    if by_ratio(table) and least is not None and least.error == 1:
        return (
            f"{rule} in which no {_one(table)} has a standard deviation more than "
            f"{most} {_beside(table)}."
        )
    return f"{rule} whose {ranking(table)} is at most {most} the smallest."


def _price(table: Comparison, chosen: Design) -> Iterator[str]:
    best = table.yardstick
    assert best is not None
    if chosen is best:
        light = ", and no lighter one in the table comes near enough"
        light = "" if table.budget.limits else light
        yield f"It is the most accurate design{_all(table)}{light}."
        return
    excess = table.excess(chosen)
    if excess == 0:
        yield f"Nothing is lost: it is as accurate as the {best.name}."
    elif by_ratio(table):
        yield f"What loses most: the standard deviation of {_worst(table, chosen)}."
        ratios = chosen.ratios
        if len(table.plants) == 1 and ratios is not None and len(ratios) > 1:
            what = "states" if table.rows is None else "rows of L x"
            more = above(max((chosen.mean_ratio or 1.0) - 1, 0.0))
            yield f"The mean over all {len(ratios)} {what} is {more}."
    else:
        yield (
            f"Its {ranking(table)} is {_shown(table, chosen)}, {above(excess)} the "
            f"{_shown(table, best)} of the most accurate design ({best.name})."
        )
    saved = 1 - chosen.work / best.work if best.work else 0.0
    less = f"{100 * abs(saved):.0f} % {'less' if saved >= 0 else 'more'}"
    yield (
        f"It runs with {counted(chosen.order, 'observer state')} instead of "
        f"{best.order} and {chosen.work} multiply-adds a step instead of "
        f"{best.work}, {less}."
    )


def _all(table: Comparison) -> str:
    """Among which designs the yardstick is the most accurate.

    No filter is more accurate than the Kalman filter, in the table or not.
    """
    least = table.yardstick
    kalman = least is not None and least.method == KALMAN and len(table.plants) == 1
    return " of all" if kalman else " in the table"


def _shown(table: Comparison, one: Design) -> str:
    """An error as a standard deviation, in its own unit if there is one."""
    alone = table.scale is None and one.worst_on is not None and one.sigma is not None
    if alone and len(table.estimates) == 1:
        sigma = one.cases[one.worst_on].sigma
        if sigma is not None:
            return number(float(sigma[0]), 4)
    return number(one.error, 4)


def _worst(table: Comparison, one: Design) -> str:
    """Which standard deviation grows most, and how much."""
    assert one.worst_on is not None
    case = one.cases[one.worst_on]
    where = "" if len(table.plants) == 1 else f"on {one.worst_on} "
    if case.ratios is None:
        return f"{table.estimates[0]} grows without bound {where}".rstrip()
    k = int(np.argmax(np.round(case.ratios, 9)))
    name = table.estimates[k]
    if case.ratios[k] == np.inf:
        return f"{name} {where}is not zero, and {_beside(table)} is"
    return f"{name} {where}is {above(max(case.ratios[k] - 1, 0.0))} {_beside(table)}"


def _loses(table: Comparison, one: Design) -> str:
    """By how much a design is less accurate than the best."""
    if one.error == np.inf and one.worst_on is not None:
        if one.cases[one.worst_on].ratios is None:
            return f"its error grows on {one.worst_on}"
    if by_ratio(table):
        return f"the standard deviation of {_worst(table, one)}"
    excess = table.excess(one)
    end = (
        "and the smallest is 0" if excess == np.inf else f"{above(excess)} the smallest"
    )
    return f"its {ranking(table)} is {_shown(table, one)}, {end}"


def _next_smaller(table: Comparison, chosen: Design) -> str:
    smaller = [one for one in table.ranked if one.order < chosen.order]
    if not smaller:
        return "No design in the table has fewer observer states."
    least = first_least(smaller, "error")
    said = f"With fewer observer states the best in the table is {least.title}:"
    return f"{said} {_loses(table, least)}."


def _beyond(table: Comparison) -> str:
    """What a little more than the budget would buy."""
    one, least = next_beyond(table), table.yardstick
    if one is None:
        return (
            "More would buy nothing: no design in the table beyond the budget is more "
            "accurate."
        )
    more = table.budget.over(one).items()
    bought = _loses(table, one)
    if one is least:
        bought = f"it is the most accurate{_all(table)}"
    return (
        f"The next one in the table beyond the budget is the {one.title}: for "
        f"{listed(amount(size, name) for name, size in more)} more, {bought}."
    )


def refusal(table: Comparison) -> Iterator[str]:
    """Why there is nothing within the budget, and what would do."""
    yield f"No design in the table is within the budget of {table.budget}."
    yield from _untried(table)
    one = next_beyond(table)
    if one is not None:
        more = table.budget.over(one).items()
        yield (
            f"What comes nearest is the {one.title}: it needs {needs(one)}, "
            f"{listed(amount(size, name) for name, size in more)} more than there is."
        )


# -- what to know beside it --------------------------------------------------------


def _remark(chosen: Design) -> Iterator[str]:
    if not chosen.exact:
        yield (
            "It is not exact: it lets the state disturb the estimate where that costs "
            "less than noise would. It is the best of its order as long as the plant "
            "and its noise are as the model says."
        )
    if chosen.note:
        yield chosen.note


def _growing(table: Comparison) -> Iterator[str]:
    """Designs that fail on some plant, and why."""
    for one in table.designs:
        if one.growing:
            first = one.growing[0]
            yield (
                f"The error of {one.name} grows on "
                f"{counted(len(one.growing), 'plant')}, such as {first}: "
                f"{one.cases[first].refusal}"
            )


def _not_weighed(table: Comparison) -> Iterator[str]:
    """Designs of which no error is known, as a known input disturbs them."""
    unknown = [one for one in table.designs if one.error is None]
    if unknown and table.plant.m and table.plant.U is None:
        where = "" if len(table.plants) == 1 else " on some plant"
        yield (
            f"Not weighed: {counted(len(unknown), 'design')} whose estimate the known "
            f"input disturbs{where}. They are weighed once plant.with_input(U) says "
            "what it is like."
        )


def _untried(table: Comparison) -> Iterator[str]:
    """What is not in the table, and why it may or may not be better."""
    if table.searched:
        orders = listed(map(str, sorted(table.searched)))
        yield (
            f"Of the fixed orders above the first few, {orders} were tried: the error "
            "falls with the order and work grows, so these tell that no other is the "
            "one to take."
        )
    if table.untried:
        yield (
            f"Not tried, as it takes a while: {listed(table.untried)}. One of them may "
            "be lighter, or more accurate."
        )


def _assumed(table: Comparison) -> Iterator[str]:
    """What errors count of the known input, if the comparison was told."""
    plant, U = table.plant, table.plant.U
    if U is None or not plant.m:
        return
    if isinstance(U, Plant):
        driven = counted(U.n, "state")
        yield f"Errors count a known input that a model of {driven} drives."
        return
    if not U.any():
        yield "Errors are those for a known input that is always zero."
    elif U.ndim == 1:
        yield (
            "Errors count a known input that is constant for ever from before the "
            f"start, at {_each(plant, U)}: one that switches is not that, and "
            "moves a design that is not exact further."
        )
    else:
        sigma = np.sqrt(U.diagonal())
        yield (
            "Errors count a known input that is white noise, of the standard deviation "
            f"{_each(plant, sigma)}."
        )


def _each(plant: Plant, values: Vector) -> str:
    """Numbers by the names of the inputs."""
    pairs = zip(plant.input_names, values)
    return ", ".join(f"{name} = {number(one, 4)}" for name, one in pairs)


# -- where no error is known -------------------------------------------------------


def why_not(table: Comparison) -> Iterator[str]:
    """Why nothing is recommended, and what to do about it."""
    plant = table.plant
    lacking = [name for name in "QR" if getattr(plant, name) is None]
    if not table.designs:
        yield "Nothing is recommended: every design is refused."
        return
    if plant.dt == 0:
        yield (
            "Nothing is recommended in continuous time: the noise of a sensor is that "
            "of its samples, so no error is known."
        )
        yield f"{SAMPLE}; on the command line --sample 0.1 does."
    elif lacking:
        yield (
            "Nothing is recommended: no error can be weighed against the work "
            f"without {' and '.join(lacking)}, the covariances of the plant's noise."
        )
    else:
        where = "" if len(table.plants) == 1 else " on every plant"
        yield (
            f"Nothing is recommended: no error is known{where} of the designs in the "
            "table."
        )
        if plant.m:
            yield (
                "Say what the known input is like, plant.with_input(U), where it "
                "disturbs an estimate."
            )
    if lacking and not plant.is_complex:
        yield f"{FIT}; on the command line `{COMMAND}` does."


def _left_to_weigh(table: Comparison) -> Iterator[str]:
    """The two ends of what can be had without knowing the noise."""
    known = [one for one in table.eligible if one.noise_gain is not None]
    if not known:
        return
    yield (
        "What is left to weigh is how much noise of the sensors an observer lets "
        "through, the noise gain, against how long it takes to forget a wrong start."
    )
    quick, calm = (first_least(known, what) for what in ("settling", "noise_gain"))

    def figures(one: Design) -> tuple[str, str]:
        return number(one.noise_gain, 4), f"{number(one.settling, 4)} s"

    gain, time = figures(quick)
    yield f"The {quick.title} settles the soonest, within {time}; noise gain {gain}."
    if calm is not quick:
        gain, time = figures(calm)
        yield (
            f"The {calm.title} has the least noise gain, {gain}, and settles within "
            f"{time}."
        )
