"""The plants that there may be: a list of them, or ranges about a nominal one."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arguments import expect_as
from ..errors import few, short
from ..identification.parameters import ENTRY, Parameters, parameters_of
from ..numeric import Vector
from ..numeric.validation import whole
from ..plant import Plant
from ..show import number

CORNERS_UP_TO = 4  # parameters; of more, the corners of the box are not tried
NOMINAL = "nominal"
PERCENT = re.compile(r"(?:±|\+-|\+/-)?\s*(\d+(?:\.\d*)?|\.\d+)\s*%")
Range = tuple[float, float] | str
Made = tuple[Callable[[Vector], Plant], Mapping[str, Range]]
WANTED = (
    "ranges must be {'A[1,1]': (low, high)}, entries of A, B, C or E counted from 0 "
    "with their bounds, or {'A[1,1]': '30 %'} of the nominal entry to either side; or "
    "(function, {'name': (low, high)}) with a function of their vector that returns a "
    "Plant"
)


@dataclass(frozen=True, eq=False)
class Perturbed:
    """One plant that there may be.

    Attributes
    ----------
    name : str
    plant : Plant
        Discrete.
    values : dict of str to float
        Of what was varied; empty for a plant of a list.
    drawn : bool
        Whether it counts in quartiles: not the nominal plant nor a corner of ranges
        from which others were drawn.
    """

    name: str
    plant: Plant
    values: Mapping[str, float] = field(default_factory=dict)
    drawn: bool = True


def perturbed(
    plants: Any, ranges: Any, samples: int, seed: int, dt: float
) -> tuple[Perturbed, ...]:
    """All plants, by name; a continuous one is sampled every `dt` seconds."""
    samples, seed = whole("samples", samples), whole("seed", seed)
    if ranges is None:
        found = list(_listed(plants))
    else:
        found = list(_in_ranges(plants, ranges, samples, seed))
    return tuple(_sampled(one, dt) for one in found)


def _sampled(one: Perturbed, dt: float) -> Perturbed:
    if one.plant.dt > 0 or dt == 0:
        return one
    try:
        plant = one.plant.sampled(dt)
    except ValueError as error:
        raise type(error)(f"plant {one.name!r}: {error}") from None
    return Perturbed(one.name, plant, one.values, one.drawn)


def _listed(plants: Any) -> Iterator[Perturbed]:
    """The plants of a dict or a list, by name."""
    if isinstance(plants, Plant):
        raise ValueError(
            "one plant alone is no choice: give a list or a dict of plants, or ranges= "
            "within which entries of this one lie"
        )
    if isinstance(plants, Mapping):
        named = dict(plants)
    elif np.iterable(plants) and not isinstance(plants, str):
        given = list(plants)
        named = {
            getattr(one, "name", None) or f"plant {k + 1}": one
            for k, one in enumerate(given)
        }
        if len(named) < len(given):
            raise ValueError("two plants have one name; give a dict of plants, by name")
    else:
        raise ValueError(f"plants must be a dict or a list, got {short(plants)}")
    if not named:
        raise ValueError("plants is empty; give at least one")
    for name, plant in named.items():
        expect_as(f"plants[{name!r}]", "plant", plant)
        yield Perturbed(str(name), plant)


def _in_ranges(
    nominal: Any, ranges: Any, samples: int, seed: int
) -> Iterator[Perturbed]:
    """The nominal plant, the corners of its ranges, and plants drawn from within."""
    expect_as("plants, the nominal one of the ranges,", "plant", nominal)
    parameters, box = _box(nominal, ranges)
    names, (low, high) = parameters.names, box

    def at(values: Vector, name: str, drawn: bool) -> Perturbed:
        said = dict(zip(names, map(float, values)))
        if not name:
            name = ", ".join(f"{key} = {number(v, 4)}" for key, v in said.items())
        try:
            return Perturbed(name, parameters.plant(values), said, drawn)
        except ValueError as error:
            raise type(error)(f"plant {name!r}: {error}") from None

    yield Perturbed(NOMINAL, nominal, _own(nominal, parameters), drawn=False)
    if len(names) <= CORNERS_UP_TO:
        for corner in itertools.product((False, True), repeat=len(names)):
            yield at(np.where(corner, high, low), "", drawn=False)
    for values in np.random.default_rng(seed).uniform(low, high, (samples, len(names))):
        yield at(values, "", drawn=True)


def _own(nominal: Plant, parameters: Parameters) -> dict[str, float]:
    """What the nominal plant has of the entries; nothing is known of a function's."""
    places = getattr(parameters, "places", ())
    return {
        name: float(getattr(nominal, letter)[i, j])
        for name, (letter, i, j) in zip(parameters.names, places)
    }


def _box(nominal: Plant, ranges: Any) -> tuple[Parameters, np.ndarray]:
    """What is varied, and its bounds (2, k)."""
    if nominal.steps is not None:
        raise ValueError("ranges are of entries of a constant plant, not one over time")
    function: tuple[Any, ...] = ()
    given = ranges
    if isinstance(ranges, tuple) and len(ranges) == 2 and callable(ranges[0]):
        function, given = ranges[:1], ranges[1]
    if not isinstance(given, Mapping) or not given:
        raise ValueError(f"{WANTED}; got {short(ranges)}")
    unknown = [name for name in given if not isinstance(name, str)]
    if not function:
        unknown = [x for x in given if x in unknown or not ENTRY.fullmatch(x)]
    if unknown:
        raise ValueError(f"{few(unknown)} cannot be varied; {WANTED}")
    begin = dict.fromkeys(given, 0.0)
    found = parameters_of(nominal, (*function, begin) if function else begin)
    own = {} if function else _own(nominal, found)
    pairs = [_bounds(name, value, own) for name, value in given.items()]
    return found, np.array(pairs).T


def _bounds(name: str, value: Any, own: Mapping[str, float]) -> tuple[float, float]:
    """The least and the greatest value of one parameter."""
    if isinstance(value, str):
        return _about(name, value, own)
    try:
        low, high = (float(one) for one in value)
    except (TypeError, ValueError):
        raise ValueError(
            f"the range of {name!r} must be (low, high), or '30 %' of the nominal "
            f"entry to either side; got {short(value)}"
        ) from None
    if not (np.isfinite([low, high]).all() and low < high):
        raise ValueError(
            f"the range of {name!r} must rise from low to high, both finite; got "
            f"{short(value)}"
        )
    return low, high


def _about(name: str, text: str, own: Mapping[str, float]) -> tuple[float, float]:
    """A percentage of the nominal entry, to either side."""
    found = PERCENT.fullmatch(text.strip())
    if not found or float(found[1]) == 0:
        raise ValueError(
            f"the range of {name!r} must be (low, high), or '30 %' of the nominal "
            f"entry to either side; got {text!r}"
        )
    if name not in own:
        raise ValueError(
            f"the range of {name!r} is {text!r}, but a parameter of a function has no "
            "nominal value; give (low, high)"
        )
    if own[name] == 0:
        raise ValueError(
            f"{name} is 0 in the nominal plant, and {text} of it too; give (low, high)"
        )
    apart = abs(own[name]) * float(found[1]) / 100
    return own[name] - apart, own[name] + apart
