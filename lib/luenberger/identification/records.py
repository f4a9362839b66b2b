"""One record or several, as checked arrays, and what of them can be fitted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..errors import DesignError, few, short
from ..formats import dataframes
from ..kernels import plain_array
from ..numeric import Matrix
from ..plant import Plant
from ..run.chunks import arrays

LARGEST = 1e100  # of readings, whose squares and sums are still numbers
ENOUGH = 2  # readings for each unknown, at the least
UNEVEN = (-1, -1, -1)  # the shape of rows of several lengths
Records = list[tuple[Matrix, Matrix]]  # (y, u) of each


def several(y: Any, p: int) -> bool:
    """Whether y is many records: an array (M, N, p), or a list of records.

    These are arrays (N, p) or tables; with p = 1 also (N,).

    Raises
    ------
    ValueError
        If only some of its entries are records, or it is none and no record either.
    """
    if isinstance(y, Mapping | Iterator) or (isinstance(y, list | tuple) and not y):
        raise ValueError(
            f"y must be a record (N, {p}) or a table, or a list of them, not "
            f"{'empty' if isinstance(y, list | tuple) else 'a ' + type(y).__name__}"
        )
    if not isinstance(y, list | tuple):
        return getattr(y, "ndim", 0) == 3
    sizes = [_size(one) for one in y]
    records = [len(s) == 2 or (p == 1 == len(s) and s != (1,)) for s in sizes]
    if all(records):
        return True
    if any(records) or any(size not in ((), (p,)) for size in sizes):
        k = records.index(False) if any(records) else 0
        wanted = f"(N, {p})" + (" or (N,)" if p == 1 else "")
        raise ValueError(
            f"y is a list, and each of its entries must be a record {wanted}; entry "
            f"{k} has "
            + (
                "rows of several lengths"
                if sizes[k] == UNEVEN
                else f"the shape {sizes[k]}"
            )
        )
    return False


def _size(one: Any) -> tuple[int, ...]:
    """The shape of an array, table or list of numbers; () of anything else."""
    if hasattr(one, "shape"):
        return tuple(one.shape)
    try:
        return np.shape(one)
    except ValueError:  # rows of several lengths
        return UNEVEN


def split(y: Any, u: Any, p: int) -> list[tuple[Any, Any]]:
    """(y, u) of each record as they were given; u is None where there are no inputs.

    Raises
    ------
    ValueError
        If y is no list of records and no record, or there is not a u for each y.
    """
    if not several(y, p):
        return [(y, u)]
    if u is None or (isinstance(u, int | float) and u == 0):
        return [(one, None) for one in y]
    if not isinstance(y, list | tuple):
        return list(zip(y, _inputs(y, u)))
    if not isinstance(u, list | tuple) or len(u) != len(y):
        raise ValueError(
            f"y is a list of {len(y)} records, so u must be a list as long; got "
            f"{short(u)}"
        )
    return list(zip(y, u))


def _inputs(y: np.ndarray, u: Any) -> np.ndarray:
    """Inputs of each record of an array, from (M, N, m), or (N, m) for all."""
    u = np.asarray(u)
    if u.shape[:-1] == y.shape[1:2]:
        return np.broadcast_to(u, (len(y), *u.shape))
    if u.shape[:-1] != y.shape[:2]:
        raise ValueError(
            f"y is {y.shape}, so u must be ({len(y)}, {y.shape[1]}, m), or "
            f"({y.shape[1]}, m) for all records, got {u.shape}"
        )
    return u


@contextmanager
def named(k: int, of: int) -> Iterator[None]:
    """What is refused inside gets the number k of the record, if there are several."""
    try:
        yield
    except ValueError as error:
        if of == 1:
            raise
        raise type(error)(f"record {k}: {error}") from error


def read(plant: Plant, y: Any, u: Any = None) -> Records:
    """y and u as a list of (y, u), each (N, p) and (N, m).

    Raises
    ------
    ValueError
        If sizes disagree, or there is not a u for each y.
    """
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    y, u = dataframes.taken(y=y, u=u)
    pairs = split(y, u, plant.p)
    found = [arrays(*pair, outputs, inputs, missing=True) for pair in pairs]
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
