"""One record or several, as checked arrays, and what of them can be fitted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..errors import DesignError, few, short
from ..formats import dataframes
from ..numeric import Matrix
from ..plant import Plant
from ..run.checked import arrays

LARGEST = 1e100  # of readings, whose squares and sums are still numbers
ENOUGH = 2  # readings for each unknown, at the least
Records = list[tuple[Matrix, Matrix]]  # (y, u) of each


def read(plant: Plant, y: Any, u: Any = None) -> Records:
    """y and u as a list of (y, u), each (N, p) and (N, m).

    Raises
    ------
    ValueError
        If y is no record and no list of records, sizes disagree, or there is not a u
        for each y.
    """
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    y, u = dataframes.taken(y=y, u=u)
    found = [arrays(*pair, outputs, inputs, missing=True)
             for pair in _each(y, u, plant.p)]  # fmt: skip
    return [
        (np.require(y, float, ["C", "W"]), np.require(u, float, ["C", "W"]))
        for y, u in found
    ]


def _each(y: Any, u: Any, p: int) -> list[tuple[Any, Any]]:
    """(y, u) of each record as they were given; u is None where there are no inputs."""
    listed = isinstance(y, list | tuple)
    if isinstance(y, Mapping | Iterator) or (listed and not y):
        raise ValueError(
            f"y must be a record (N, {p}) or a table, or a list of them, not "
            f"{'empty' if listed else 'a ' + type(y).__name__}"
        )
    if listed:
        shapes = [_shape(one) for one in y]
        whole = [len(s) == 2 or (p == 1 == len(s) and s != (1,)) for s in shapes]
        if not all(whole):
            if not any(whole) and all(shape in ((), (p,)) for shape in shapes):
                return [(y, u)]
            k = whole.index(False)
            wanted = f"(N, {p})" + (" or (N,)" if p == 1 else "")
            has = f"the shape {shapes[k]}" if shapes[k] != UNEVEN else "rows of several"
            raise ValueError(
                f"y is a list, and each of its entries must be a record {wanted}; "
                f"entry {k} has {has}{' lengths' * (shapes[k] == UNEVEN)}"
            )
    elif getattr(y, "ndim", 0) != 3:
        return [(y, u)]
    if u is None or (isinstance(u, int | float) and u == 0):
        return [(one, None) for one in y]
    if not listed and np.ndim(u) == 2:
        return [(one, u) for one in y]  # the same for all
    if not isinstance(u, list | tuple | np.ndarray) or len(u) != len(y):
        raise ValueError(
            f"y has {len(y)} records, so u must be a list as long; got {short(u)}"
        )
    return list(zip(y, u))


UNEVEN = (-1, -1, -1)  # the shape of rows of several lengths


def _shape(one: Any) -> tuple[int, ...]:
    """The shape of an array, table or list of numbers; () of anything else."""
    try:
        return tuple(one.shape) if hasattr(one, "shape") else np.shape(one)
    except ValueError:
        return UNEVEN


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
    size = np.nanmax(np.abs(columns), axis=0)
    if (size > LARGEST).any():
        k = int(np.argmax(size))
        raise DesignError(
            f"output {names[k]!r} has readings up to {size[k]:.3g}, and squares of "
            "these have no place in floats; give it in a larger unit"
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
