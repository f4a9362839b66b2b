"""Many records of one plant, filtered by `filter_data`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..fleets import filter_block
from ..fleets.block import Block
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.settings import Settings
from . import fleet_tasks
from .clock import Clock, of_record, require_instants
from .fleet_records import Records
from .fleet_tasks import BLOCK, Arrays, Where


@dataclass(frozen=True, eq=False)
class FilteredFleet:
    """What `filter_data` returns of many records (M, N, p), the record first.

    Records are numbered from 0 and have the same instants.  Each has a start of its
    own, ``x0`` and ``P0`` of the plant.  One that ends earlier has NaN from there on,
    as lists of records (N, p) with several lengths get it, and predictions without
    readings; that is also what a record without any reading has.  An array on disk, as
    ``numpy.load(path, mmap_mode="r")`` opens it, is read part by part.

    All records run in full, whatever `settle` is.  Those with the same gaps may share
    one covariance.  The bits of a record do not depend on the records beside it, nor
    on the executor, its workers and what a task takes; they do depend on the backend,
    and "auto" counts the rows of all records.

    A record that is refused ends the call with its number, and nothing is written to a
    file.  To find all that are: filter them one by one, ``filter_data(plant, y[k])``.

    Attributes
    ----------
    x, std : (M, N, n) ndarray
        Estimates of the state and their one-sigma errors, as in `Filtered`.
    P : (M, n, n) or (M, N, n, n) ndarray
        Error covariance at the last row; with ``history=True`` at every row.
    K : (M, N, n, p) ndarray or None
        Gains, with ``history=True``; the columns of missing outputs are zero.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> found = lb.filter_data(plant, [[[2], [2]], [[4]]])  # the second ends earlier
    >>> found
    <FilteredFleet: 2 records of 2 rows, n = 1>
    >>> found.x[:, :, 0].round(4)
    array([[1.    , 1.3333],
           [2.    , 2.    ]])
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        M, N, n = self.x.shape
        return f"<FilteredFleet: {M} records of {N} rows, n = {n}>"


@dataclass(frozen=True)
class _Filter:
    """The filter of some records, which goes to where they are filtered."""

    plant: Plant
    m1: Any
    weight: Any
    u0: Vector
    compile: bool
    history: bool

    def room(self, M: int, N: int) -> Arrays:
        settings = Settings(self.plant, self.m1, self.weight)
        shape = M, N, self.plant.p
        return _given(Block.empty(settings, shape, self.history))

    def __call__(self, first: int, y: Matrix, u: Matrix, out: Arrays) -> None:
        settings = Settings(self.plant, self.m1, self.weight)
        u = np.broadcast_to(u, (*y.shape[:2], self.plant.m))
        given = self.u0, self.compile, self.history, first
        filter_block(settings, y, u, *given, out=Block(**{"K": None, **out}))


def _given(block: Block) -> Arrays:
    return {name: X for name, X in block._asdict().items() if X is not None}


def filter_fleet(
    plant: Plant, y: Any, u: Any, time: Any, m1: Any, u0: Vector, weight: Any,
    history: bool, backend: str, where: Where, arrival: Any = None,
) -> FilteredFleet | None:  # fmt: skip
    """Filter records y (M, N, p) of one plant, all with the same instants."""
    if arrival is not None:
        raise ValueError(
            "arrival is for one record, and y holds many, (M, N, p): filter the "
            "records that have late readings one by one"
        )
    records = Records.of(y, u, plant.p, plant.m)
    plant = at_rows(plant, records.rows, time)
    settings = Settings(plant, m1, weight)
    fast = runs_compiled(backend, settings, records)
    task = _Filter(plant, m1, weight, u0, fast, history)
    n, p = plant.n, plant.p
    numbers = plant.m + p + 2 * n + (n * (n + p) if history else 0)
    kind, columns = FilteredFleet, tables(plant)
    found: FilteredFleet | None = fleet_tasks.run(
        task, records, where, kind, columns, numbers
    )
    return found


def tables(plant: Plant) -> dict[str, list[str]]:
    """The columns of x and std in a table."""
    names = plant.state_names
    return {"x": [*names], "std": [f"{name}_sigma" for name in names]}


def at_rows(plant: Plant, rows: int, time: Any) -> Plant:
    """The discrete plant at so many rows; `time` as in `filter_data`."""
    nothing = np.zeros((rows, plant.p))
    if plant.dt == 0:
        plant = of_record(plant, nothing, time)
    else:
        Clock(plant, time).follow(nothing)
    require_instants(plant, rows)
    return plant


def runs_compiled(backend: str, settings: Settings, records: Records) -> bool:
    """Whether compiled code is to filter the records: all their rows count.

    For fewer than pay for compiling, if records of such a plant were filtered so.
    """
    rows = len(records) * records.rows
    stacks = None if backend == "numpy" else Pass(settings).stacks
    if stacks is None:
        return kernels.runs_compiled(backend, rows)
    y, _ = records.block(0, BLOCK)
    gaps = bool(np.isnan(y).any())
    changing = stacks.changing(not gaps)
    asked = "records", gaps, stacks.sizes, stacks.entries(changing), changing
    fast = kernels.runs_compiled(backend, rows, ready=lambda _: asked in kernels.LOADED)
    if fast:
        kernels.LOADED.add(asked)
    return fast
