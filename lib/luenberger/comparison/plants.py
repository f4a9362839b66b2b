"""The plants that there may be: within ranges about a nominal one, or a list."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..analysis.known_input import known_input
from ..arguments import expect
from ..errors import FIT, SAMPLE, DesignError, few, short
from ..identification.parameters import ENTRY, Parameters, parameters_of
from ..numeric import Vector
from ..numeric.validation import whole
from ..plant import Plant
from ..show import number
from .designs import noisy
from .judge import NOMINAL

CORNERS_UP_TO = 4  # parameters; of more, the corners of the box are not tried
PERCENT = re.compile(r"(?:±|\+-|\+/-)?\s*(\d+(?:\.\d*)?|\.\d+)\s*%")
Range = tuple[float, float] | str
Made = tuple[Callable[[Vector], Plant], Mapping[str, Range]]
WANTED = (
    "ranges must be {'A[1,1]': (low, high)}, entries of A, B, C or E counted from 0 "
    "with their bounds, or {'A[1,1]': '30 %'} of the nominal entry to either side; or "
    "(function, {'name': (low, high)}) with a function of their vector that returns a "
    "Plant"
)


def vary(
    plant: Plant,
    ranges: Mapping[str, Range] | Made,
    samples: int = 100,
    seed: int = 0,
) -> dict[str, Plant]:
    """Plants within ranges about a nominal one: every corner, and random ones.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
    >>> [*lb.vary(plant, {"A[0,0]": "20 %"}, samples=1)]
    ['A[0,0] = 0.4', 'A[0,0] = 0.6', 'A[0,0] = 0.5273923375']

    `compare(plant, plants=vary(...))` judges designs for the nominal plant on all of
    them.  A continuous plant stays continuous; `compare` samples it.

    Parameters
    ----------
    plant : Plant
        The nominal plant.
    ranges : dict or (callable, dict)
        Entries of the plant, counted from 0, with their bounds:
        ``{"A[1,1]": (-0.65, -0.35)}``, or ``{"A[1,1]": "30 %"}`` of the nominal entry
        to either side; or a function of a vector of parameters that returns the plant,
        with their names and bounds: ``(made, {"damping": (0.35, 0.65)})``.
    samples : int, default 100
        How many plants are drawn evenly from within, beside the corners of up to 4
        ranges.
    seed : int, default 0
        From which random stream.

    Returns
    -------
    dict of str to Plant
        Their names say the values: "A[1,1] = -0.65, C[0,0] = 1.02".

    Raises
    ------
    ValueError
        If an entry is not there, or a range does not rise.
    """
    expect(plant=plant)
    samples, seed = whole("samples", samples), whole("seed", seed)
    parameters, (low, high) = _box(plant, ranges)
    drawn = np.random.default_rng(seed).uniform(low, high, (samples, len(low)))
    corners = itertools.product(*zip(low, high)) if len(low) <= CORNERS_UP_TO else ()
    found: dict[str, Plant] = {}
    for values in [*map(np.array, corners), *drawn]:
        pairs = zip(parameters.names, values)
        name = ", ".join(f"{key} = {number(float(v), 10)}" for key, v in pairs)
        try:
            found[name] = parameters.plant(values)
        except ValueError as error:
            raise type(error)(f"plant {name!r}: {error}") from None
    return found


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
    unknown = [
        name
        for name in given
        if not isinstance(name, str) or not (function or ENTRY.fullmatch(name))
    ]
    if unknown:
        raise ValueError(f"{few(unknown)} cannot be varied; {WANTED}")
    begin = dict.fromkeys(given, 0.0)
    found = parameters_of(nominal, (*function, begin) if function else begin)
    own = {
        name: float(getattr(nominal, letter)[i, j])
        for name, (letter, i, j) in zip(found.names, getattr(found, "places", ()))
    }
    pairs = [_bounds(name, value, own) for name, value in given.items()]
    return found, np.array(pairs).T


def _bounds(name: str, value: Any, own: Mapping[str, float]) -> tuple[float, float]:
    """The least and the greatest value of one parameter."""
    wanted = (
        f"the range of {name!r} must be (low, high), both finite and rising, or "
        f"'30 %' of the nominal entry to either side; got {short(value)}"
    )
    if not isinstance(value, str):
        try:
            low, high = (float(one) for one in value)
        except (TypeError, ValueError):
            raise ValueError(wanted) from None
        if not (np.isfinite([low, high]).all() and low < high):
            raise ValueError(wanted)
        return low, high
    share = PERCENT.fullmatch(value.strip())
    if not share or float(share[1]) == 0:
        raise ValueError(wanted)
    if name not in own:
        raise ValueError(
            f"the range of {name!r} is {value!r}, but a parameter of a function has no "
            "nominal value; give (low, high)"
        )
    if own[name] == 0:
        raise ValueError(
            f"{name} is 0 in the nominal plant, and {value} of it too; give (low, high)"
        )
    apart = abs(own[name]) * float(share[1]) / 100
    return own[name] - apart, own[name] + apart


def judged_on(plant: Plant, plants: Any) -> dict[str, Plant]:
    """The plants that designs for `plant` are judged on, itself first, by name.

    A continuous one is sampled as the nominal plant is, and has its known input where
    it says nothing of its own.
    """
    if plants is None:
        return {NOMINAL: plant}
    if not isinstance(plants, Mapping):
        raise ValueError(
            "plants must be a dict of plants by name, as lb.vary(plant, ranges) makes, "
            f"got {short(plants)}"
        )
    found = {NOMINAL: plant}
    if not noisy(plant):
        raise DesignError(
            "designs are judged on other plants by their errors, so the nominal plant "
            "must have a dt > 0 and both noise covariances Q and R; "
            f"{FIT if plant.dt > 0 else SAMPLE}"
        )
    for name, one in plants.items():
        if name == NOMINAL:
            raise ValueError(
                f"a plant cannot be called {NOMINAL!r}, as the one that designs are for"
            )
        if not isinstance(one, Plant):
            raise ValueError(f"plants[{name!r}] must be a Plant, got {short(one)}")
        try:
            if one.dt == 0:
                one = one.sampled(plant.dt)
            _require_like(one, plant)
            if one.U is None:
                one = one.with_input(plant.U)
            if one.U is not None:
                known_input(one)
        except ValueError as error:
            raise type(error)(f"plant {name!r}: {error}") from None
        found[str(name)] = one
    return found


def _require_like(one: Plant, nominal: Plant) -> None:
    """Refuse plants that no error of the designs is of."""
    if one.steps is not None or one.is_complex:
        raise DesignError("plants must be constant and real")
    if not noisy(one):
        raise DesignError(f"it needs both noise covariances Q and R; {FIT}")
    mine, own = ((x.n, x.m, x.p, x.dt) for x in (one, nominal))
    if mine != own:
        size = "{} states, {} inputs and {} outputs, dt = {:g} s"
        raise DesignError(
            f"it has {size.format(*mine)}, and the nominal one {size.format(*own)}"
        )
