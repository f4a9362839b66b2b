"""One record or several, as checked arrays, and what of them can be fitted."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import DesignError, few
from ..kernels import plain_array
from ..numeric import Matrix
from ..plant import Plant
from ..run.chunks import arrays

ENOUGH = 2  # readings for each unknown, at the least
Records = list[tuple[Matrix, Matrix]]  # (y, u) of each


def several(y: Any) -> bool:
    """Whether y is a list of records: arrays (N, p) or tables."""
    return isinstance(y, list | tuple) and all(np.ndim(one) == 2 for one in y)


def read(plant: Plant, y: Any, u: Any = None) -> Records:
    """y and u as a list of (y, u), each (N, p) and (N, m).

    Raises
    ------
    ValueError
        If sizes disagree, or there is not a u for each y.
    """
    ys, us = ([y], [u])
    if several(y):
        ys, us = list(y), [None] * len(y) if u is None else list(u)
    if len(ys) != len(us):
        raise ValueError(f"y holds {len(ys)} records and u {len(us)}")
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    found = [arrays(*one, outputs, inputs, missing=True) for one in zip(ys, us)]
    return [(plain_array(y), plain_array(u)) for y, u in found]


def require_measured(plant: Plant, records: Records) -> None:
    """Refuse records in which an output was never measured or never changes.

    Raises
    ------
    DesignError
        Naming the output.
    """
    names = plant.output_names
    columns = np.concatenate([y for y, _ in records])
    empty = [names[j] for j in np.flatnonzero(np.isnan(columns).all(axis=0))]
    if empty:
        raise DesignError(
            f"outputs {few(empty)} have no measurement in the record; leave them out "
            "of the plant"
        )
    still = np.nanmax(columns, axis=0) == np.nanmin(columns, axis=0)
    if still.any():
        j = int(np.flatnonzero(still)[0])
        raise DesignError(
            f"output {names[j]!r} is constant in the record, at "
            f"{np.nanmin(columns[:, j]):.6g}, so it says nothing of noise. Leave it "
            "out, or give a record in which it moves"
        )


def require_enough(plant: Plant, records: Records, unknown: int) -> None:
    """Refuse records that are too short for so many unknowns.

    Raises
    ------
    DesignError
        With the number of readings, and how many the unknown start takes.
    """
    readings = sum(int((~np.isnan(y)).sum()) for y, _ in records)
    spent = 0 if plant.P0 is not None else plant.n * len(records)
    if readings - spent < ENOUGH * unknown:
        start = f", less {spent} that the unknown start takes," if spent else ""
        raise DesignError(
            f"the record is too short: {readings} readings{start} for {unknown} "
            f"unknowns, and at least {ENOUGH} for each are needed. Give a longer "
            "record, or a form of Q and R with fewer unknowns"
        )


def complete_stretches(records: Records, least: int) -> Records:
    """The stretches of at least so many rows in which every output was measured."""
    found = []
    for y, u in records:
        gaps = np.flatnonzero(np.isnan(y).any(axis=1))
        edges = np.concatenate([[-1], gaps, [len(y)]])
        for a, b in zip(edges, edges[1:]):
            if b - a - 1 >= least:
                found.append((y[a + 1 : b], u[a + 1 : b]))
    return found
