"""Whether a record agrees with Q and R: the report's sentences and picture of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..identification.normalised import innovations as normalised
from ..identification.whiteness import Whiteness, whiteness
from ..plant import Plant
from ..run.measurements import Measurements
from ..show import Picture, Prose, number

LEAST = 20  # samples of which an autocorrelation says something


def judged(plant: Plant, data: Measurements | None) -> Whiteness | None:
    """The tests of a record's innovations; None without noises or without a record."""
    if data is None or plant.Q is None or plant.R is None or not plant.dt:
        return None
    if plant.multiplicative or len(data.y) - data.missing / plant.p < LEAST:
        return None
    try:
        return whiteness(normalised(plant, data.y, data.u if plant.m else None))
    except ValueError:  # the record contradicts the plant, or does not tell the state
        return None


def agreement(found: Whiteness | None) -> Prose:
    """What the tests say."""
    if found is None:
        return Prose(
            f"Nothing was tested: this needs Q, R and {LEAST} samples that the plant "
            "can produce."
        )
    good = found.white and found.sized
    verdict = "agrees" if good else "does not agree"
    return Prose(
        *found.sentences,
        f"The record {verdict} with the plant and its Q and R."
        + ("" if good else " One-sigma bounds are only as good as these are."),
    )


def innovations(found: Whiteness | None, axes: Sequence[Any]) -> Prose | Picture:
    """The picture of `plot.innovations`."""
    if found is None:
        return Prose("No figure: there are no innovations to show.")
    first = found.autocorrelation[0].diagonal()
    return Picture(
        axes[0].figure,
        "Autocorrelations of the normalised innovations at "
        f"{len(found.autocorrelation)} lags, a curve for each output; "
        f"{number(first[0], 2)} at the first. The band of white ones is "
        f"{number(found.bound, 2)} to each side of zero.",
    )
