"""Why one design is the safest over many plants, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .cases import Spread
from .reasons import count

if TYPE_CHECKING:
    from .robust_table import Robustness


def reasons(table: Robustness) -> list[str]:
    """The rule, what the choice gives and costs, and what fails where."""
    chosen = table.chosen
    said = [_plants(table)]
    if chosen is None:
        said.append("Nothing is recommended: no design is safe on every plant.")
    else:
        said += [_rule(table, chosen), *_price(table, chosen)]
    return [*said, *_growing(table), *_unknown(table)]


def _plants(table: Robustness) -> str:
    total = count(len(table.plants), "plant")
    if table.seed is None:
        return f"Each design is judged on {total}."
    drawn = sum(one.drawn for one in table.plants)
    corners = len(table.plants) - drawn - 1
    return (
        f"Each design is judged on {total}: the nominal one, "
        f"{count(corners, 'corner')} of the ranges, and {drawn} drawn from within them "
        f"with seed {table.seed}."
    )


def _rule(table: Robustness, chosen: Spread) -> str:
    return (
        f"The worst case of {chosen.name} is the least: on {chosen.worst.plant} "
        f"{_error(table, chosen.worst.error)}."
    )


def _error(table: Robustness, error: float) -> str:
    if table.scale is not None:
        return f"its error in the given scale is {table.said(error)}"
    what = "state" if table.whole else "estimate"
    if not np.isfinite(error):
        return "its error grows without bound"
    more = "" if error >= 11 else " above"
    if len(table.estimates) == 1:
        return (
            f"the standard deviation of {table.estimates[0]} is {table.said(error)}"
            f"{more} that of the plant's own Kalman filter"
        )
    return (
        f"no {what} has a standard deviation more than {table.said(error)}{more} that "
        "of the plant's own Kalman filter"
    )


def _price(table: Robustness, chosen: Spread) -> Iterator[str]:
    """What is given away where the plant is as the model says."""
    if chosen.nominal is None:
        return
    known = [one for one in table.spreads if one.nominal.error is not None]
    best = min(known, key=lambda one: one.nominal.error)
    if best is chosen:
        yield "It is the most accurate on the nominal plant as well."
        return
    yield (
        f"On the nominal plant {best.name} is the most accurate: "
        f"{table.said(best.nominal.error)}, and {table.said(chosen.nominal.error)} of "
        f"{chosen.name}."
    )
    if best.known:
        yield (
            f"The worst case of {best.name} is {table.said(best.worst.error)}, on "
            f"{best.worst.plant}."
        )


def _growing(table: Robustness) -> Iterator[str]:
    """Designs that fail on some plant, and why."""
    for one in table.spreads:
        if one.growing:
            where = count(len(one.growing), "plant")
            first = one.growing[0]
            yield (
                f"The error of {one.name} grows on {where}, such as {first.plant}: "
                f"{first.refusal}"
            )


def _unknown(table: Robustness) -> Iterator[str]:
    unknown = [one.name for one in table.spreads if not one.known]
    if unknown:
        yield (
            f"Not weighed: {', '.join(unknown)}, whose estimate the known input "
            "disturbs on some plant. plant.with_input(U) says what it is like."
        )
