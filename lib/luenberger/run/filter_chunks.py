"""Chunk by chunk over a record: the filter's state after each, and what it found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .. import kernels
from ..formats import dataframes
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.progress import Progress
from ..recursion.settled_pass import SettledPass
from ..recursion.state import History
from . import chunks
from .clock import Clock, require_instants
from .sampled_pass import SampledPass
from .timed import Timed
from .when_asked import Ending, when_asked

NEVER = np.empty(0, dtype=np.int64)  # rows at which a gain settled


@when_asked("std")
@dataclass(frozen=True, eq=False)
class Filtered:
    """What `filter_data` returns; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray or pandas.DataFrame
        Estimates of the state, each using y up to and including its row.
    std : (N, n) ndarray or pandas.DataFrame
        Their one-sigma errors, square roots of the diagonal of P.  An array is written
        when it is first asked for, behind the row at which the gain settled.
    P : (n, n) or (N, n, n) ndarray
        Error covariance at the last row; with ``history=True`` at every row.
    K : (N, n, p) ndarray or None
        Gains, with ``history=True``; the columns of missing outputs are zero.
    orders : (N,) ndarray of int
        States the reduced-order filter needs at each row: n minus the number of
        accurate outputs that arrived.
    settled_at : (k,) ndarray of int
        The rows from which on the gain is that of the row before: the covariance has
        settled.  It stays so until other outputs arrive.  0 if it had settled in an
        earlier chunk, empty if it never did.
    settle_bound : float
        How far these rows, with all their rounding, can be from the full recursion,
        carried on without rounding from the first of them: variances relative to
        theirs, covariances to the standard deviations of both, estimates to their
        standard deviations.  Rows behind them, after a gap, are counted, but for the
        rounding of their own recursion.  0 if none has settled.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None
    orders: np.ndarray
    settled_at: np.ndarray
    settle_bound: float


def chunk(
    run: SettledPass,
    watch: Clock,
    history: bool,
    backend: str,
    state: Progress,
    y: Any,
    u: Any,
) -> tuple[Progress, Filtered]:
    """Filter the next rows of a pass: the state after them, and their `Filtered`."""
    watch.follow(y)
    values, u, fast = _read(run, state, y, u, backend)
    state, out = run.over(state, values, u, fast, history)
    return state, _found(run, state, y, values, out, history)


def sampled_chunk(
    run: SampledPass,
    history: bool,
    backend: str,
    state: Progress,
    block: Timed,
    u: Any,
) -> tuple[Progress, Filtered]:
    """The same of a continuous plant, sampled at the rows."""
    values, u, fast = _read(run, state, block.y, u, backend)
    state, out = run.over(state, values, u, block.periods, fast, history)
    return state, _found(run, state, block.y, values, out, history)


def _read(
    run: SettledPass | SampledPass, state: Progress, y: Any, u: Any, backend: str
) -> tuple[Matrix, Matrix, bool]:
    """The rows as arrays, and whether compiled code is to filter them."""
    plant = run.plant
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    y, u = chunks.arrays(y, u, outputs, inputs, missing=True)
    ready = partial(run.at_hand, state.state, y)
    return y, u, kernels.runs_compiled(backend, _last(plant, state, y), ready=ready)


def _found(
    run: SettledPass | SampledPass,
    state: Progress,
    table: Any,
    y: Matrix,
    out: History,
    history: bool,
) -> Filtered:
    """The `Filtered` of rows after which `state` is reached."""
    P, K = (out.P, out.K) if history else (state.Sigma, None)
    matrices = P, K, _orders(run.plant, run.accurate, y)
    settled = np.array(state.settled, dtype=np.int64), state.bound
    rows = out.x, out.variances
    still = None if state.still is None else (state.still, state.Sigma)
    return _filtered(run.plant, table, *rows, *matrices, *settled, still)


def _filtered(
    plant: Plant,
    table: Any,
    x: Matrix,
    variances: Matrix,
    P: Matrix,
    K: Matrix | None,
    orders: Vector,
    settled_at: Vector = NEVER,
    settle_bound: float = 0.0,
    still: tuple[int, Matrix] | None = None,
) -> Filtered:
    """`Filtered`, as tables where y is one; `variances` become standard deviations.

    From the first row of `still` on they are those of its covariance, and not written.
    """
    early = variances if still is None else variances[: still[0]]
    np.sqrt(np.maximum(early, 0, out=early), out=early)
    std: Any = variances
    if still is not None:
        std = Ending(early, np.sqrt(still[1].diagonal()), len(x))
    if dataframes.is_table(table):
        std = std if still is None else std.written()
        x, std = (dataframes.like(table, X, plant.state_names) for X in (x, std))
        said = dict(settled_at=settled_at.tolist(), settle_bound=settle_bound)
        for one in (x, std):
            dataframes.note(one, **said)
    return Filtered(x, std, P, K, orders, settled_at, settle_bound)


def _last(plant: Plant, state: Any, y: Matrix) -> int:
    """The instant of the last row of y, or ValueError if the plant ends before it."""
    last: int = state.instant + len(y)
    require_instants(plant, last)
    return last


def _orders(plant: Plant, accurate: Sequence[int], y: Matrix) -> Vector:
    """n minus the number of accurate outputs in each row."""
    if not len(accurate):
        return np.broadcast_to(plant.n, len(y))  # takes no memory for a long record
    return plant.n - (~np.isnan(y[:, list(accurate)])).sum(axis=1)
