"""The bound on rounding of a plant's filter: found, and in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...numeric import Matrix
from ...papers.leondes_novak.derivation import complete_sample
from ...plant import Plant
from ...recursion.settings import Settings, require_start
from .admitted import settings_of
from .filter_bound import Search
from .filter_plant import matrices, narrowed, sample_program, start, tested
from .filter_step import Pair, Unproved
from .ranges import missing, ranges
from .rounding_bound import RoundingBound, Words, by_name, by_signal, wrapped
from .source_and_header import Signals

FILTER = Words(
    "luenberger/export/derivation/filter_rounding.py",
    "the same equations without rounding, with the plant in double",
    "every output arrives at every sample from the first on",
)


def signals_of(plant: Plant) -> Signals:
    """What the caller of a plant's filter passes."""
    return Signals(plant.input_names, plant.output_names, plant.state_names)


def pair(plant: Plant, m1: Any, real: str) -> Pair:
    """The filter of a plant, and what a device makes of it.

    Raises
    ------
    Unproved
        If nothing is proved of such filters.
    """
    device, exact = settings_of(plant, m1, None, real), Settings(plant, m1)
    if device.accurate:
        raise Unproved("outputs that are treated as exact are not covered")
    if tested(device):
        raise Unproved(
            "a mode that does not decay has no noise to drive it, so the filter "
            "forgets ever more slowly"
        )
    first = plant.at_first_sample()
    x, Omega = start(device.plant, real)
    full = narrowed(matrices(device), real)
    given = dict(x=first.x0, Omega=np.asarray(require_start(first)))
    return Pair(
        sample_program(device, complete_sample, full),
        matrices(exact) | given,
        full | dict(x=x, Omega=Omega),
        real,
    )


def filter_error(plant: Plant, m1: Any, real: str) -> Matrix:
    """Errors of the estimates, for each signal of size one alone, and for none.

    Raises
    ------
    Unproved
        If no bound was found.
    """
    return Search(pair(plant, m1, real)).error()


def filter_bound(
    plant: Plant, real: str, given: Mapping[str, float] | None
) -> tuple[RoundingBound | str, Matrix]:
    """The bound, or why there is none; and the ranges, NaN where one is not known."""
    named = signals_of(plant)
    sizes, source = ranges(named, plant, given)
    if missing(sizes, named):
        return "", sizes
    try:
        largest = filter_error(plant, 0, real) @ np.append(sizes, 1.0)
    except Unproved as why:
        return str(why), sizes
    by = by_name(named, sizes)
    return RoundingBound(real, largest, named.what, by, source, FILTER), sizes


def filter_notes(
    plant: Plant, m1: Any, real: str, update: str, given: Mapping[str, float] | None
) -> list[str]:
    """Lines of the header of a filter."""
    named = signals_of(plant)
    sizes, source = ranges(named, plant, given)
    try:
        if update != "joseph":
            raise Unproved("of many steps in the short form nothing is proved")
        error = filter_error(plant, m1, real)
    except Unproved as why:
        return ["", *wrapped(f"No bound on rounding was proved: {why}.")]
    if missing(sizes, named):
        return by_signal(error, named, FILTER)
    largest, by = error @ np.append(sizes, 1.0), by_name(named, sizes)
    return RoundingBound(real, largest, named.what, by, source, FILTER).notes()
