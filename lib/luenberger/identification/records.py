"""One record or several, as checked arrays, and what of them can be fitted."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import DesignError, few
from ..plant import Plant
from ..run.fleet import of_record
from ..run.record import Record, Rows

LARGEST = 1e100  # of readings, whose squares and sums are still numbers
ENOUGH = 2  # readings for each unknown, at the least
Records = list[Rows]  # of each run


def read(plant: Plant, record: Any) -> Records:
    """The rows of each run of a record, as arrays.

    Raises
    ------
    ValueError
        As where a filter runs on it; also if readings arrive late, which a fit of all
        of them does not mind.
    """
    record = Record.of(record)
    if record.arrival is not None:
        raise ValueError("a fit uses all readings at once: leave `arrival` out")
    if not record.many:
        return [record.on(plant)]
    found = []
    for k, one in enumerate(record.each()):
        with of_record(k):
            found.append(one.on(plant))
    return found


def require_measured(plant: Plant, records: Records) -> None:
    """Refuse records in which an output was never measured or never changes.

    Raises
    ------
    DesignError
        Naming the output.
    """
    names = plant.output_names
    columns = np.concatenate([rows.y for rows in records])
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
    readings = sum(int((~np.isnan(rows.y)).sum()) for rows in records)
    spent = 0 if plant.P0 is not None else plant.n * len(records)
    if readings - spent < ENOUGH * unknown:
        start = f", less {spent} that the unknown start takes," if spent else ""
        raise DesignError(
            f"the record is too short: {readings} readings{start} for {unknown} "
            f"unknowns, and at least {ENOUGH} for each are needed. Give a longer "
            "record, or a form of Q and R with fewer unknowns"
        )
