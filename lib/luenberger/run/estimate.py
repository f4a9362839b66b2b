"""Run a given observer on recorded data."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, overload

import numpy as np

from ..arguments import expect
from ..at_work import start
from ..certificate import require_real
from ..errors import SAMPLE, short
from ..formats import dataframes
from ..numeric import Given, Matrix, Vector
from ..observer import Observer
from . import chunks
from .clock import Clock, row
from .fleet import of_record, stack_of
from .observer_pass import over_rows
from .record import Record


@overload
def estimate(
    observer: Observer, y: Iterator[Any], u: Iterator[Any] | int | None = ..., *,
    time: str | None = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
) -> Iterator[Matrix]: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, y: Any, u: Any = ..., *,
    time: Any = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
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
        or tables, are M records, each with an observer of its own.
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

    Returns
    -------
    (N, q) ndarray, or an iterator of them
        The estimate of L x at each row; it uses y up to and including that row.  For
        a DataFrame or Series y a DataFrame: the index is y's, the columns are
        `observer.estimate_names`.  Of many records (M, N, q), or a list where they are
        tables or have several lengths; what is found of one hangs on no other.

    Raises
    ------
    ValueError
        If sizes disagree, a value is missing (use `Filter`), an estimate overflows
        (naming its row), a time-varying filter is given
        more rows than it has, or both z0 and x0 are given.  If a
        table lacks a column, holds other things than numbers in one, or y and u
        have different indices.

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
    require_real("estimate", observer)
    if observer.dt == 0:
        raise ValueError(
            "recorded data need a discrete observer; this one has dt = 0. Design it "
            f"for the sampled plant: {SAMPLE}."
        )
    u0 = dataframes.entries("u0", u0, observer.input_names)
    x0 = dataframes.entries("x0", x0, observer.state_names)
    z = start(observer, u0, z0, x0)
    if not isinstance(y, Iterator):
        record = Record(y, u, time)
        if record.many:
            return _of_many(observer, record, z)
        y, u = record.y, record.u
    else:
        y, u = dataframes.taken(y=y, u=u)
    step = partial(_chunk, observer, Clock(observer, time))
    return chunks.found(step, (0, z), y, u)


State = tuple[int, Vector]  # how many rows were done, and z


def estimated(
    observer: Observer, state: State, y: Matrix, u: Matrix
) -> tuple[State, Matrix]:
    """The state behind the next rows, and estimates at them, which may overflow."""
    done, z = state
    here = slice(done, done + len(y))
    _require_steps(observer, here.stop)
    with np.errstate(over="ignore", invalid="ignore"):
        z, found = over_rows(observer, z, y, u, here)
    return (here.stop, z), found


def _of_many(observer: Observer, record: Record, z: Vector) -> Any:
    """The estimates of many records: at once where they are one array."""
    o, found = observer, []
    if isinstance(record.y, list | tuple):
        for k, one in enumerate(record.each()):
            with of_record(k):
                step = partial(_chunk, o, Clock(o, one.time))
                found.append(chunks.found(step, (0, z), one.y, one.u))
        tables = any(map(dataframes.is_table, found))
        return found if tables or len({*map(len, found)}) > 1 else np.stack(found)
    y, u = stack_of(record, o.D.shape[-1], o.G.shape[-1])
    if not (whole := np.isfinite(y)).all():
        k, at, _ = np.argwhere(~whole)[0].tolist()
        raise ValueError(
            f"y in record {k}, row {at} is missing or not finite; Filter accepts NaN "
            "in y as not measured"
        )
    rows = y.shape[1]
    Clock(o, record.time).follow(y[0] if len(y) else np.zeros(y.shape[1:]))
    _require_steps(o, rows)
    with np.errstate(over="ignore", invalid="ignore"):
        w = over_rows(o, z, y, u, slice(0, rows))[1]
    for k in np.flatnonzero(~np.isfinite(w).reshape(len(w), -1).all(axis=1))[:1]:
        with of_record(k):
            _refuse_overflow(o, w[k], 0)
    return w


def _chunk(
    observer: Observer, watch: Clock, before: State, y: Any, u: Any
) -> tuple[State, Any]:
    """The same of a chunk as it was given, whose estimates are finite."""
    o, table = observer, y
    watch.follow(y)
    outputs, inputs = (o.D.shape[-1], o.output_names), (o.G.shape[-1], o.input_names)
    y, u = chunks.arrays(y, u, outputs, inputs)
    after, found = estimated(o, before, y, u)
    if not np.isfinite(found).all():
        _refuse_overflow(o, found, before[0])
    return after, dataframes.like(table, found, o.estimate_names)


def _require_steps(observer: Observer, rows: int) -> None:
    """ValueError if a filter over steps has fewer than these."""
    if observer.steps is not None and rows > observer.steps:
        raise ValueError(
            f"y has {rows} rows, the filter was designed for {observer.steps}; design "
            f"it with steps={rows}, or Filter(plant).run(y) takes any number"
        )


def _refuse_overflow(observer: Observer, found: Matrix, done: int) -> None:
    k, j = np.argwhere(~np.isfinite(found))[0].tolist()
    raise ValueError(
        f"{row(done + k)}: the estimate of {short(observer.estimate_names[j])} "
        "overflows; the measurements are too large, or the observer is not stable"
    )
