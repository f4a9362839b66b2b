"""An observer fitted into whole numbers of so many bits, or why it does not fit."""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import DesignError
from ...numeric import Vector
from ...observer import Observer
from ...plant import Plant
from .formats import SUM, Formats, Unfit, formats
from .limits import Exact
from .ranges import ranges, require_all
from .rounding_bound import RoundingBound, by_name
from .source_and_header import Signals


def fitted(
    observer: Observer,
    bits: int | None,
    signals: Signals,
    plant: Plant | None,
    given: Mapping[str, float] | None,
) -> tuple[Formats, RoundingBound]:
    """Places for all signals, and the bound on rounding that goes with them.

    Raises
    ------
    ValueError
        If the bits are not 16 or 32, or a range is not known.
    DesignError
        If so many bits do not suffice.
    """
    if bits not in SUM or isinstance(bits, bool):
        raise ValueError(f"bits must be 16 or 32 with dtype='fixed', got {bits!r}")
    sizes, source = ranges(signals, plant, given)
    require_all(sizes, signals, plant)
    exact = Exact(observer)
    try:
        made = _formats(exact, sizes, bits, signals)
    except Unfit as why:
        raise DesignError(
            f"{bits} bits do not suffice: {why}. "
            + _otherwise(exact, sizes, bits, signals)
        ) from None
    return made, RoundingBound(
        f"whole numbers of {bits} bits",
        made.limits.error[:, 0],
        signals.what,
        by_name(signals, sizes),
        source,
    )


def _formats(exact: Exact, sizes: Vector, bits: int, names: Signals) -> Formats:
    states = [f"z[{i}]" for i in range(exact.observer.order)]
    return formats(exact, sizes, bits, states, list(names.what))


def _otherwise(exact: Exact, sizes: Vector, bits: int, names: Signals) -> str:
    """What to do where it does not fit."""
    for more in (one for one in SUM if one > bits):
        try:
            _formats(exact, sizes, more, names)
        except Unfit:
            continue
        return f"{more} bits would do: give bits={more}"
    return (
        f"{max(SUM)} do not do either: export dtype='float', or change the coordinates "
        "of the observer, e.g. to observer.balanced()"
    )
