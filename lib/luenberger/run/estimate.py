"""Run a given observer on recorded data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Any, overload

import numpy as np

from ..arguments import expect
from ..at_work import start
from ..certificate import require_real
from ..errors import SAMPLE, short
from ..formats import dataframes
from ..kernels import runs_compiled
from ..numeric import Given, Matrix, Vector
from ..observer import Observer
from . import chunks
from .clock import Clock, row
from .estimate_fleet import estimate_fleet, require_steps
from .fleet_records import many
from .fleet_tasks import Into, Where
from .observer_pass import (
    ESTIMATED,
    is_at_hand,
    over_rows,
    over_rows_compiled,
)


@overload
def estimate(
    observer: Observer, y: Iterator[Any], u: Iterator[Any] | int | None = ..., *,
    time: str | None = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
    backend: str = ...
) -> Iterator[Matrix]: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, y: np.ndarray | Sequence[Any], u: Given | int = ..., *,
    time: Any = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
    backend: str = ..., executor: Executor | None = ..., chunk: int | None = ...,
    into: None = ...
) -> Matrix: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, y: np.ndarray | Sequence[Any], u: Given | int = ..., *,
    time: Any = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
    backend: str = ..., executor: Executor | None = ..., chunk: int | None = ...,
    into: Into
) -> None: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, y: Any, u: Any = ..., *,
    time: Any = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
    backend: str = ..., executor: Executor | None = ..., chunk: int | None = ...,
    into: Into | None = ...
) -> Any: ...  # fmt: skip
def estimate(
    observer: Observer,
    y: Any,
    u: Any = None,
    *,
    time: Any = None,
    u0: Given = None,
    z0: Given = None,
    x0: Given = None,
    backend: str = "auto",
    executor: Executor | None = None,
    chunk: int | None = None,
    into: Into | None = None,
) -> Any:
    """Run an observer on recorded data.

    Parameters
    ----------
    observer : Observer
        Discrete.
    y : (N, p) array_like or DataFrame, or an iterator of such chunks
        Measurements; for a time-varying filter row k is instant k + 1.  With an
        iterator the result is an iterator of arrays, one for each chunk, and memory
        stays flat.  The columns of a DataFrame of pandas or Polars, or of a DataArray
        or Dataset of xarray, are found by `observer.output_names`, in any order and
        among others; by position where the observer has no names.
        A Series is the one channel of p = 1.  An array (M, N, p), or a list of records
        (N, p), are M records, each with an observer of its own; one that ends earlier
        has NaN from there on.
    u : (N, m) array_like or DataFrame, or an iterator of chunks like y's, optional
        Known input at the same instants.  By default the columns of the DataFrame y
        that are named `observer.input_names`, or zero for an array; 0 if there is no
        known input.
    time : (N,) array_like or "rows", optional
        When each row was measured, as in `Record`.  It must agree with dt.
    u0 : (m,) array_like, optional
        For a time-varying filter, the input that acted from instant 0 to 1.
    z0 : (r,) array_like, optional
        State of the observer at the first row, default as designed.
    x0 : (n,) array_like, optional
        Instead of z0: a guess of the plant state, at the first row for a constant
        observer, at instant 0 (the mean of x[0]) for a time-varying filter.
    backend : "auto", "numpy" or "numba"
        "numba" runs code compiled for this observer (`pip install luenberger[fast]`),
        the same to rounding; "auto" takes it, where numba is installed, for a million
        rows or more, or if it is at hand.
    executor, chunk, into : optional
        Of many records: a pool of threads or processes, how many a task of it takes,
        and a file ``.npz`` or ``.parquet``, or a function, that gets part by part.

    Returns
    -------
    (N, q) ndarray, or an iterator of them
        The estimate of L x at each row; it uses y up to and including that row.  For
        a DataFrame or Series y a DataFrame: the index is y's, the columns are
        `observer.estimate_names`.  Of many records (M, N, q), NaN behind the end of
        each; None with `into`, whose arrays and parts are such ``estimates``.

    Raises
    ------
    ValueError
        If sizes disagree, a value is missing (use `Filter`), an estimate
        overflows (naming its row; not of many records), a time-varying filter is given
        more rows than it has, or both z0 and x0 are given.  If a
        table lacks a column, holds other things than numbers in one, or y and u
        have different indices.
    ImportError
        If numba is asked for and not installed.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> lb.estimate(observer, [[1], [1], [1]])
    array([[1.],
           [3.],
           [4.]])
    """
    expect(observer=observer)
    runs_compiled(backend, 0)
    require_real("estimate", observer)
    if observer.dt == 0:
        raise ValueError(
            "recorded data need a discrete observer; this one has dt = 0. Design it "
            f"for the sampled plant: {SAMPLE}."
        )
    u0 = dataframes.entries("u0", u0, observer.input_names)
    x0 = dataframes.entries("x0", x0, observer.state_names)
    begun = 0, start(observer, u0, z0, x0)
    where = Where(executor, chunk, into)
    y, u = dataframes.taken(y=y, u=u)
    if many(y):
        return estimate_fleet(observer, y, u, time, begun[1], backend, where)
    where.require_none()
    step = partial(_chunk, observer, Clock(observer, time), backend, True)
    return chunks.found(step, begun, y, u)


def estimated(observer: Observer, y: Any, u: Any, x0: Given, backend: str) -> Any:
    """The same of a caller that says itself which estimates overflow."""
    step = partial(_chunk, observer, Clock(observer), backend, False)
    return chunks.found(step, (0, start(observer, x0=x0)), y, u)


def _chunk(
    observer: Observer,
    watch: Clock,
    backend: str,
    finite: bool,
    before: tuple[int, Vector],
    y: Any,
    u: Any,
) -> tuple[tuple[int, Vector], Any]:
    """The estimates of the next rows; the state is how many rows were done, and z."""
    o, table, (done, z) = observer, y, before
    watch.follow(y)
    outputs, inputs = (o.D.shape[-1], o.output_names), (o.G.shape[-1], o.input_names)
    y, u = chunks.arrays(y, u, outputs, inputs)
    here = slice(done, done + len(y))
    require_steps(o, here.stop)
    fast = runs_compiled(backend, here.stop, ESTIMATED, ready=partial(is_at_hand, o))
    with np.errstate(over="ignore", invalid="ignore"):
        z, found = (over_rows_compiled if fast else over_rows)(o, z, y, u, here)
    if finite and not np.isfinite(found).all():
        k, j = np.argwhere(~np.isfinite(found))[0].tolist()
        raise ValueError(
            f"{row(done + k)}: the estimate of {short(o.estimate_names[j])} overflows; "
            "the measurements are too large, or the observer is not stable"
        )
    return (here.stop, z), dataframes.like(table, found, o.estimate_names)
