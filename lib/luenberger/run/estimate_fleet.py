"""Many records, each with an observer of its own, by `estimate`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..kernels import plain_array, runs_compiled
from ..numeric import Matrix, Vector
from ..observer import Observer
from . import fleet_tasks
from .clock import Clock
from .fleet_records import Records, ended
from .fleet_tasks import Arrays, Where
from .observer_pass import ESTIMATED, OBSERVER, is_at_hand, over_stacks, stacks_of
from .simulate import follow

WIDTH = 64  # records side by side, always: products of one size have the same bits


def estimate_fleet(
    observer: Observer, y: Any, u: Any, time: Any, z: Vector, backend: str, where: Where
) -> Matrix | None:
    """The estimates (M, N, q) of records y (M, N, p), which all begin at z."""
    o, p, m = observer, observer.D.shape[-1], observer.G.shape[-1]
    records = Records.of(y, u, p, m, missing=False)
    rows = records.rows
    require_steps(o, rows)
    Clock(o, time).follow(np.zeros((rows, p)))
    ready = partial(is_at_hand, o)
    fast = runs_compiled(backend, len(records) * rows, ESTIMATED, ready=ready)
    columns = {"estimates": [*o.estimate_names]}
    numbers = p + m + len(o.L)
    task = _Estimate(o, z, fast)
    found: Matrix | None = fleet_tasks.run(
        task, records, where, _only, columns, numbers
    )
    return found


def require_steps(observer: Observer, rows: int) -> None:
    """ValueError if a filter over steps has fewer than these."""
    if observer.steps is not None and rows > observer.steps:
        raise ValueError(
            f"y has {rows} rows, the filter was designed for {observer.steps}; design "
            f"it with steps={rows}, or lb.Filter(plant).run(y) takes any number"
        )


def _only(estimates: Matrix) -> Matrix:
    return estimates


@dataclass(frozen=True)
class _Estimate:
    """The observer of some records, which goes to where they are estimated."""

    observer: Observer
    z: Vector
    compile: bool

    def room(self, M: int, N: int, complete: bool = False) -> Arrays:
        return {"estimates": np.empty((M, N, len(self.observer.L)))}

    def __call__(
        self, first: int, y: Matrix, u: Matrix, out: Arrays, complete: bool = False
    ) -> None:
        u = np.broadcast_to(u, (*y.shape[:2], u.shape[-1]))
        behind = ended(y)
        y = np.where(np.isnan(y), 0.0, y)
        found = out["estimates"]
        if found.size:
            (self.compiled if self.compile else self.plain)(y, u, found)
        found[behind] = np.nan

    def leaves(self, found: Arrays) -> Arrays:
        return found

    def plain(self, y: Matrix, u: Matrix, out: Matrix) -> None:
        """Side by side in NumPy."""
        for k in range(0, len(y), WIDTH):
            some = slice(k, k + WIDTH)
            ys, us = (_columns(X[some]) for X in (y, u))
            _, found = follow(self.observer, ys, us, self.z)
            out[some] = found[:, :, : len(y[some])].transpose(2, 0, 1)

    def compiled(self, y: Matrix, u: Matrix, out: Matrix) -> None:
        """Record by record in a loop that is compiled once."""
        rows = y.shape[1]
        step = over_stacks(OBSERVER, *stacks_of(self.observer), slice(0, rows))
        for ys, us, found in zip(y, u, out):
            ys, us, z = plain_array(ys), plain_array(us), self.z.astype(float)
            step(stop=rows, z=z, y=ys, u=us, w_hats=found)


def _columns(X: Matrix) -> Matrix:
    """Records (k, N, .) as columns (N, ., 64), zeros behind the last."""
    out = np.zeros((*X.shape[1:], WIDTH))
    out[:, :, : len(X)] = X.transpose(1, 2, 0)
    return out
