"""Many records of one plant, filtered by `filter_data`."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from threading import Lock, get_ident
from typing import Any

import numpy as np

from .. import kernels
from ..fleets import filter_block
from ..fleets.block import Block, deviations
from ..fleets.fleet import Fleet
from ..numeric import Matrix, Vector
from ..numeric.linalg import finite
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from . import fleet_tasks
from .clock import Clock, of_record, require_instants
from .fleet_records import Records
from .fleet_tasks import BLOCK, Arrays, Where

_ONE_AT_A_TIME = Lock()
MADE = ("variances", "back")  # what deviations are made of


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
    x : (M, N, n) ndarray
        Estimates of the state.
    std : (M, N, n) ndarray
        Their one-sigma errors, as in `Filtered`.  They are worked out when they are
        first asked for.  Where all records have the same, memory is for one of them,
        and the array cannot be written to: copy it first.
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
    P: np.ndarray
    K: np.ndarray | None = None
    _found: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    @property
    def std(self) -> np.ndarray:
        """One-sigma errors of the estimates, worked out when first asked for."""
        with _ONE_AT_A_TIME:  # variances give their place away
            if "std" not in self._found:
                made = deviations(*(self._found.pop(name) for name in MADE))
                self._found["std"] = made
        return self._found["std"]

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        M, N, n = self.x.shape
        return f"<FilteredFleet: {M} records of {N} rows, n = {n}>"


@dataclass(frozen=True)
class _Filter:
    """The filter of some records, which goes to where they are filtered."""

    fleet: Fleet
    history: bool

    def room(self, M: int, N: int, complete: bool = False) -> Arrays:
        settings = self.fleet.settings
        shape, complete = (M, N, settings.plant.p), complete and not settings.noise_free
        block = Block.empty(settings, shape, self.history, complete)
        return {name: X for name, X in block._asdict().items() if X is not None}

    def __call__(
        self, first: int, y: Matrix, u: Matrix, out: Arrays, complete: bool = False
    ) -> None:
        u = np.broadcast_to(u, (*y.shape[:2], self.fleet.settings.plant.m))
        block = Block(**{"K": None, **out})
        filter_block(self.fleet, y, u, self.history, first, block, complete)

    def leaves(self, found: Arrays) -> Arrays:
        """What goes elsewhere: deviations instead of what they are made of."""
        kept = {name: X for name, X in found.items() if name not in MADE}
        x, std = kept.pop("x"), deviations(*(found[name] for name in MADE))
        return {"x": x, "std": std, **kept}


def _fleet(
    x: Matrix, P: Matrix, K: Matrix | None = None, **found: Matrix
) -> FilteredFleet:
    """The result; `found` are deviations, or what they are made of."""
    return FilteredFleet(x, P, K, found)


def filter_fleet(
    plant: Plant, y: Any, u: Any, time: Any, m1: Any, u0: Vector, weight: Any,
    history: bool, backend: str, where: Where,
) -> FilteredFleet | None:  # fmt: skip
    """Filter records y (M, N, p) of one plant, all with the same instants."""
    records = Records.of(y, u, plant.p, plant.m)
    plant = at_rows(plant, records.rows, time)
    way = way_of(plant, m1, weight)
    fast = runs_compiled(backend, way, records)
    n, p = plant.n, plant.p
    numbers = plant.m + p + 2 * n + (n * (n + p) if history else 0)
    task = _Filter(Fleet(way, u0, records.rows, fast), history)
    found: FilteredFleet | None = fleet_tasks.run(
        task, records, where, _fleet, tables(plant), numbers
    )
    return found


def way_of(plant: Plant, m1: Any, weight: Any) -> SettledPass:
    """The way of a filter over a record, in full; kept for a few plants.

    Calls in several threads each have their own: a way is not for two at once.
    """
    if plant.steps is None and type(m1) is int and weight is None:
        return _kept(plant, m1, get_ident())
    return SettledPass(Settings(plant, m1, weight), None)


@lru_cache(maxsize=8)
def _kept(plant: Plant, m1: int, thread: int) -> SettledPass:
    return SettledPass(Settings(plant, m1), None)


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


def runs_compiled(backend: str, way: SettledPass, records: Records) -> bool:
    """Whether compiled code is to filter the records: all their rows count.

    For fewer than pay for compiling, if records of such a plant were filtered so.
    """
    rows = len(records) * records.rows
    stacks = None if backend == "numpy" else way.run.stacks
    if stacks is None:
        return kernels.runs_compiled(backend, rows)
    y, _ = records.part(0, BLOCK)
    gaps = not finite(y)
    changing = stacks.changing(not gaps)
    asked = "records", gaps, stacks.sizes, stacks.entries(changing), changing
    fast = kernels.runs_compiled(backend, rows, ready=lambda _: asked in kernels.LOADED)
    if fast:
        kernels.LOADED.add(asked)
    return fast
