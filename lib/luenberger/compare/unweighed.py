"""What is said of a comparison that recommends nothing, as no error is known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..errors import FIT, SAMPLE
from ..plant import Plant
from ..show import number
from .attempts import Attempt, first_least

if TYPE_CHECKING:
    from .table import Comparison

COMMAND = "luenberger fit PLANT.json DATA.csv --out FITTED.json"


def why_not(plant: Plant) -> Iterator[str]:
    """Why nothing is recommended for a plant, and what to do about it."""
    lacking = [name for name in "QR" if getattr(plant, name) is None]
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
        yield "Nothing is recommended: no error is known of the designs asked for."
        if plant.m:
            yield (
                "Say what the known input is like, plant.with_input(U), where it "
                "disturbs an estimate."
            )
    if lacking and not plant.is_complex:
        yield f"{FIT}; on the command line `{COMMAND}` does."


def left_to_weigh(table: Comparison) -> Iterator[str]:
    """The two ends of what can be had without knowing the noise."""
    known = [one for one in table.eligible if one.noise_gain is not None]
    if not known:
        return
    yield (
        "What is left to weigh is how much noise of the sensors an observer lets "
        "through, the noise gain, against how long it takes to forget a wrong start."
    )
    quick, calm = (first_least(known, what) for what in ("settling", "noise_gain"))
    gain, time = _figures(quick)
    yield f"The {quick.title} settles the soonest, within {time}; noise gain {gain}."
    if calm is not quick:
        gain, time = _figures(calm)
        yield (
            f"The {calm.title} has the least noise gain, {gain}, and settles within "
            f"{time}."
        )


def _figures(one: Attempt) -> tuple[str, str]:
    """Its noise gain and its settling time, in words."""
    return number(one.noise_gain, 4), f"{number(one.settling, 4)} s"
