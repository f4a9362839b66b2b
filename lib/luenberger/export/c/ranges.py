"""How large the signals of a device get: as its user says, or as the plant's noises do.

What is said of rounding holds while no signal leaves its range.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...numeric import Matrix, Vector
from ...numeric.linalg import lyapunov, radius
from ...numeric.power_sums import power_sums
from ...plant import Plant
from .source_and_header import Signals

DEVIATIONS = 6  # of a reading, standard ones: it is beyond once in 500 million samples


def ranges(
    signals: Signals,
    plant: Plant | None,
    given: Mapping[str, float] | None,
) -> tuple[Vector, str]:
    """The largest size of each input and measurement, NaN where it is not known.

    With the sentence that says where what was not given comes from.

    Raises
    ------
    ValueError
        If a name is of no signal, or a size is not a positive number.
    """
    known = (*signals.u, *signals.y)
    found = np.full(len(known), np.nan)
    for name, size in (given or {}).items():
        where = [k for k, one in enumerate(known) if one == name]
        if not where:
            raise ValueError(
                f"ranges names {name!r}, which is no input or measurement; there are "
                f"{', '.join(map(repr, known))}"
            )
        if len(where) > 1:
            raise ValueError(
                f"ranges names {name!r}, an input and a measurement; name them apart"
            )
        if isinstance(size, bool) or not np.isreal(size) or not 0 < size < np.inf:
            raise ValueError(
                f"the range of {name!r} must be a positive number, the largest size of "
                f"the signal, got {size!r}"
            )
        found[where[0]] = size
    m = len(signals.u)
    open_ = np.isnan(found[m:])
    if plant is None or not open_.any() or np.isnan(found[:m]).any():
        return found, ""
    sizes = readings(plant, found[:m])
    if sizes is None:
        return found, ""
    found[m:] = np.where(open_, sizes, found[m:])
    which = ", ".join(repr(signals.y[k]) for k in np.flatnonzero(open_))
    return found, (
        f"The range of {which} is {DEVIATIONS} standard deviations of the plant at "
        "rest in its noises, and what the inputs add."
    )


def readings(plant: Plant, u: Vector) -> Vector | None:
    """Sizes of the measurements of a stable plant with these inputs, or None."""
    if plant.steps is not None or plant.dt == 0 or plant.Q is None or plant.R is None:
        return None
    if plant.is_complex or plant.multiplicative or not radius(plant.A) < 1:
        return None
    driven = power_sums(plant.A, plant.C, plant.B, np.zeros((plant.n, 0)))
    if driven is None:
        return None
    spread = plant.C @ lyapunov(plant.A, plant.Q) @ plant.C.T
    noise = np.sqrt(np.maximum(spread.diagonal() + plant.R.diagonal(), 0))
    sizes: Vector = DEVIATIONS * noise + _each(driven.seen, u) + _each(plant.E, u)
    return np.where(sizes > 0, sizes, np.nan)


def _each(X: Matrix, u: Vector) -> Vector:
    """What inputs of these sizes make at most, through sizes of X."""
    return np.asarray(np.abs(X) @ u)


def missing(found: Vector, signals: Signals) -> list[str]:
    """Names of the signals without a range."""
    known = (*signals.u, *signals.y)
    return [known[k] for k in np.flatnonzero(np.isnan(found))]


def require_all(found: Vector, signals: Signals, plant: Plant | None) -> None:
    """Raise ValueError if the range of a signal is not known."""
    if not (left := missing(found, signals)):
        return
    listed = ", ".join(map(repr, left))
    raise ValueError(
        f"the range of {listed} is not known: give ranges={{{left[0]!r}: the largest "
        "size, ...}. "
        + (
            "Of measurements the plant's noises tell: give the plant as well"
            if plant is None
            else "Of measurements a plant tells that is stable and has Q and R, where "
            "all ranges of inputs are given"
        )
    )
