"""An observer on recorded data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

import numpy as np

from ..arguments import expect
from ..at_work import start
from ..certificate import require_real
from ..errors import SAMPLE, short
from ..filtering.pack import by_rows
from ..formats import dataframes
from ..numeric import Given, Matrix, Vector
from ..observer import Observer
from . import checked
from .clock import Clock, Place, row
from .fleet import of_record, stack_of
from .record import Record
from .simulate import along, each


@overload
def estimate(
    observer: Observer, record: np.ndarray | Sequence[Sequence[float]], *,
    z0: Given = ..., x0: Given = ...,
) -> Matrix: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, record: Any, *, z0: Given = ..., x0: Given = ...
) -> Any: ...
def estimate(
    observer: Observer, record: Any, *, z0: Given = None, x0: Given = None
) -> Any:
    """Run an observer on a record.

    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> lb.estimate(observer, [[1], [1], [1]])
    array([[1.],
           [3.],
           [4.]])

    Parameters
    ----------
    observer : Observer
        Discrete.
    record : Record, or what one is made of
        Complete: an observer of constant gains needs every reading.  The columns of a
        table are found by the observer's names, or by position where it has none.  For
        a time-varying filter row k is instant k + 1.  Each of many records has an
        observer of its own.
    z0 : (r,) array_like, optional
        State of the observer at the first row, default as designed.
    x0 : (n,) array_like, optional
        Instead of z0: a guess of the plant state, at the first row for a constant
        observer, at instant 0 (the mean of x[0]) for a time-varying filter.

    Returns
    -------
    (N, q) ndarray or DataFrame
        The estimate of L x at each row; it uses y up to and including that row.  For
        a table a DataFrame: the index is the table's, the columns are
        `observer.estimate_names`.  Of many records (M, N, q), or a list where they are
        tables or have several lengths; what is found of one hangs on no other.

    Raises
    ------
    ValueError
        If sizes disagree, a reading is missing or comes late (use `Filter`), times
        contradict dt, an estimate overflows
        (naming its row), a time-varying filter is given more rows than it has, or both
        z0 and x0 are given.  If a table lacks a column, holds other things than numbers
        in one, or y and u have different indices.

    See Also
    --------
    Observer.live : the same, of readings that come one after the other.
    """
    expect(observer=observer)
    require_real("estimate", observer)
    require_samples(observer)
    record = Record.of(record)
    if record.arrival is not None:
        raise ValueError(
            "an observer of constant gains cannot wait: leave `arrival` out, or run "
            "Filter(plant), which takes readings that arrive late"
        )
    u0 = dataframes.entries("u0", record.u0, observer.input_names)
    x0 = dataframes.entries("x0", x0, observer.state_names)
    z = start(observer, u0, z0, x0)
    found = _of_many if record.many else _of_one
    return found(observer, record, z)


def require_samples(observer: Observer) -> None:
    """Raise unless the observer is discrete."""
    if observer.dt == 0:
        raise ValueError(
            "recorded data need a discrete observer; this one has dt = 0. Design it "
            f"for the sampled plant: {SAMPLE}."
        )


def _of_one(o: Observer, record: Record, z: Vector) -> Any:
    """The estimates of one record, which are finite."""
    Clock(o).follow(record.y, record.time)
    outputs, inputs = (o.D.shape[-1], o.output_names), (o.G.shape[-1], o.input_names)
    y, u = checked.arrays(record.y, record.u, outputs, inputs)
    found = estimated(o, (0, z), y, u)[1]
    require_finite(found, o.estimate_names, row)
    return dataframes.like(record.y, found, o.estimate_names)


State = tuple[int, Vector]  # how many rows were done, and z


def estimated(
    observer: Observer, state: State, y: Matrix, u: Matrix
) -> tuple[State, Matrix]:
    """The state behind the next rows, and estimates at them, which may overflow.

    y is (N, p) and u (N, m); or y is (M, N, p), of many records, and u (M, N, m) or
    (1, N, m).
    """
    (done, z), N = state, y.shape[-2]
    if observer.steps is not None and done + N > observer.steps:
        raise ValueError(
            f"y has {done + N} rows, the filter was designed for {observer.steps}; "
            f"design it with steps={done + N}, or Filter(plant).run(y) takes any number"
        )
    one = y.ndim == 2
    y, u = (X[None] if X.ndim == 2 else X for X in (y, u))
    with np.errstate(over="ignore", invalid="ignore"):
        o = observer
        drive = by_rows(o.D, done, y) + by_rows(o.G, done, u)
        states = np.empty((N + 1, o.order, len(y)))
        states[0] = z[:, None]
        along(each(o.F)[done * (o.F.ndim > 2) :], drive.transpose(1, 2, 0), states)
        states, z = states[:-1].transpose(2, 0, 1), states[-1, :, 0]
        found = by_rows(o.P, done, states) + by_rows(o.V, done, y)
        found += by_rows(o.W, done, u)
    return (done + N, z), found[0] if one else found


def _of_many(observer: Observer, record: Record, z: Vector) -> Any:
    """The estimates of many records: at once where they are one array."""
    o, found = observer, []
    if isinstance(record.y, list | tuple):
        for k, one in enumerate(record.each()):
            with of_record(k):
                found.append(_of_one(o, one, z))
        tables = any(map(dataframes.is_table, found))
        return found if tables or len({*map(len, found)}) > 1 else np.stack(found)
    y, u = stack_of(record, o.D.shape[-1], o.G.shape[-1])
    for k, at, _ in np.argwhere(~np.isfinite(y))[:1]:
        raise ValueError(
            f"y in record {k}, row {at} is missing or not finite; Filter accepts NaN "
            "in y as not measured"
        )
    Clock(o).follow(y[0] if len(y) else np.zeros(y.shape[1:]), record.time)
    w = estimated(o, (0, z), y, u)[1]
    for k in np.flatnonzero(~np.isfinite(w).reshape(len(w), -1).all(axis=1))[:1]:
        with of_record(k):
            require_finite(w[k], o.estimate_names, row)
    return w


def require_finite(x: Matrix, names: Sequence[str], at: Place) -> None:
    """Raise unless every estimate is finite; `at(k)` says where row k is."""
    if np.isfinite(x).all():
        return
    k, j = np.argwhere(~np.isfinite(x))[0].tolist()
    raise ValueError(
        f"{at(k)}: the estimate of {short(names[j])} overflows; the measurements are "
        "too large, or the observer is not stable"
    )
