"""What a comparison was told of the known input, in a sentence."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..numeric import Vector
from ..plant import Plant
from ..show import number

if TYPE_CHECKING:
    from .table import Comparison


def assumed(table: Comparison) -> Iterator[str]:
    """What errors count of the known input, if the comparison was told."""
    plant, U = table.plant, table.plant.U
    if U is None or not plant.m:
        return
    if isinstance(U, Plant):
        states = "1 state" if U.n == 1 else f"{U.n} states"
        yield f"Errors count a known input that a model of {states} drives."
        return
    given = np.asarray(U, dtype=float)
    if not given.any():
        yield "Errors are those for a known input that is always zero."
    elif given.ndim == 1:
        yield (
            "Errors count a known input that is constant for ever from before the "
            f"start, at {_each(plant, given)}: one that switches is not that, and "
            "moves a design that is not exact further."
        )
    else:
        sigma = np.sqrt(given.diagonal())
        yield (
            "Errors count a known input that is white noise, of the standard deviation "
            f"{_each(plant, sigma)}."
        )


def _each(plant: Plant, values: Vector) -> str:
    """Numbers by the names of the inputs."""
    pairs = zip(plant.input_names, values)
    return ", ".join(f"{name} = {number(one, 4)}" for name, one in pairs)
