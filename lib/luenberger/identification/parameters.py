"""Unknown parameters of a plant: named entries of its matrices, or a function."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import expect_as
from ..errors import few, short
from ..numeric import Vector
from ..plant import Plant

ENTRY = re.compile(r"([ABCE])\[(\d+),\s*(\d+)\]")
WANTED = (
    "parameters must be {'B[1,0]': start, ...}, entries of A, B, C or E counted from "
    "0 with where to begin, or (function, {'name': start, ...}) with a function of "
    "their vector that returns a Plant"
)


@dataclass(frozen=True, eq=False)
class Parameters:
    """Numbers that a plant depends on; as they stand, none.

    Attributes
    ----------
    template : Plant
        What they are put into.
    names : tuple of str
    begin : (k,) ndarray
        Where the search begins.
    """

    template: Plant
    names: tuple[str, ...] = ()
    begin: Any = ()

    @property
    def scale(self) -> Vector:
        """A step of the search, which is the size of what it begins with, or 1."""
        begin = np.abs(np.array(self.begin, dtype=float))
        return np.where(begin > 0, begin, 1.0)

    def plant(self, values: Vector) -> Plant:
        """The plant at these values."""
        return self.template


@dataclass(frozen=True, eq=False)
class Entries(Parameters):
    """Entries of A, B, C and E, such as B[1,0]."""

    @property
    def places(self) -> list[tuple[str, int, int]]:
        return [place_of(name) for name in self.names]

    def plant(self, values: Vector) -> Plant:
        changed: dict[str, Any] = {}
        for (letter, i, j), value in zip(self.places, values):
            if letter not in changed:
                changed[letter] = getattr(self.template, letter).copy()
            changed[letter][..., i, j] = value
        return dataclasses.replace(self.template, **changed)


@dataclass(frozen=True, eq=False)
class Made(Parameters):
    """What a function makes of the parameters."""

    function: Callable[[Vector], Plant] = Plant

    def plant(self, values: Vector) -> Plant:
        found = self.function(np.array(values, dtype=float))
        expect_as("what the function of the parameters returns", "plant", found)
        sizes, wanted = ((one.n, one.m, one.p) for one in (found, self.template))
        if sizes != wanted:
            raise ValueError(
                "the function of the parameters must return a plant with n, m, p = "
                f"{wanted}, as the plant that is fitted; it returned {sizes}"
            )
        return found


def place_of(name: str) -> tuple[str, int, int]:
    """Letter, row and column of an entry by name."""
    found = ENTRY.fullmatch(name)
    assert found
    return found[1], int(found[2]), int(found[3])


def parameters_of(plant: Plant, wanted: Any) -> Parameters:
    """The parameters that a caller names."""
    if wanted is None:
        return Parameters(plant)
    function = None
    if isinstance(wanted, tuple) and len(wanted) == 2 and callable(wanted[0]):
        function, wanted = wanted
    if not isinstance(wanted, Mapping) or not wanted:
        raise ValueError(f"{WANTED}; got {short(wanted)}")
    names, begin = tuple(wanted), np.array([_number(*one) for one in wanted.items()])
    if function is not None:
        return Made(plant, names, begin, function)
    _require_entries(plant, names)
    return Entries(plant, names, begin)


def _number(name: Any, value: Any) -> float:
    if not isinstance(name, str):
        raise ValueError(f"{WANTED}; {short(name)} is no name")
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = np.nan
    if not np.isfinite(found):
        raise ValueError(f"the start of parameter {name!r} is no number: {value!r}")
    return found


def _require_entries(plant: Plant, names: tuple[str, ...]) -> None:
    unknown = [name for name in names if not ENTRY.fullmatch(name)]
    if unknown:
        raise ValueError(f"{few(unknown)} are no entries of the plant; {WANTED}")
    places = [place_of(name) for name in names]
    for name, (letter, i, j) in zip(names, places):
        rows, columns = getattr(plant, letter).shape[-2:]
        if i >= rows or j >= columns:
            raise ValueError(f"there is no {name}: {letter} is {rows} x {columns}")
    if len(set(places)) < len(places):
        raise ValueError(f"parameters {few(names)} name one entry twice")
