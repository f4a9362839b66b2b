"""Estimates from measurements before and after: a whole record, or a fixed lag."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from operator import index
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import expect
from ..errors import short
from ..formats import dataframes
from ..numeric import Given, Vector
from ..plant import Plant
from ..run import chunks
from ..run.clock import watched
from ..run.filter_data import Outputs
from ..run.fleet_records import Many, many
from ..run.fleet_tasks import Into, Where
from ..run.timed import timed
from .fleet import SmoothedFleet, smooth_fleet
from .record import Smoothed, Smoother


@overload
def smooth(
    plant: Plant, y: Iterator[Any], u: Iterator[Any] | None = ..., *,
    time: Iterator[Any] | str | None = ..., m1: Outputs = ...,
    lag: int | None = ..., u0: Given = ..., weight: Given | str = ...,
    backend: str = ...
) -> Iterator[Smoothed]: ...  # fmt: skip
@overload
def smooth(  # type: ignore[overload-overlap]  # an array is a record, too
    plant: Plant, y: Many, u: Given = ..., *, time: Any = ...,
    m1: Outputs = ..., lag: int | None = ..., u0: Given = ...,
    weight: Given | str = ..., backend: str = ..., executor: Executor | None = ...,
    chunk: int | None = ..., into: None = ...
) -> SmoothedFleet: ...  # fmt: skip
@overload
def smooth(
    plant: Plant, y: ArrayLike, u: Given = ..., *, time: Any = ...,
    m1: Outputs = ..., lag: int | None = ..., u0: Given = ...,
    weight: Given | str = ..., backend: str = ...
) -> Smoothed: ...  # fmt: skip
@overload
def smooth(
    plant: Plant, y: ArrayLike, u: Given = ..., *, time: Any = ...,
    m1: Outputs = ..., lag: int | None = ..., u0: Given = ...,
    weight: Given | str = ..., backend: str = ..., executor: Executor | None = ...,
    chunk: int | None = ..., into: Into
) -> None: ...  # fmt: skip
def smooth(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    time: Any = None,
    m1: Outputs = 0,
    lag: int | None = None,
    u0: Given = None,
    weight: Given | str = None,
    backend: str = "auto",
    executor: Executor | None = None,
    chunk: int | None = None,
    into: Into | None = None,
) -> Any:
    """Estimate the states of a record from all of it; NaN means not measured.

    The filter passes over the record, and what later rows say is carried back: with
    theta what they say of an estimate x of covariance Sigma, and Theta how much,

        x_s = x + Sigma theta,  P = Sigma - Sigma Theta Sigma.

    Of all estimates that are linear in the record, these have the least covariance.
    No covariance and no A is inverted, so both may be singular.

    Parameters
    ----------
    plant : Plant
        With Q, R and P0.  A continuous one is sampled at the record's instants, as in
        `filter_data`.
    y : (N, p) array_like or pandas.DataFrame, or an iterator of such chunks
        Measurements at instants 1 .. N, as in `filter_data`.  With an iterator the
        result is an iterator of `Smoothed`, and memory stays flat; it takes a lag.  An
        array (M, N, p), or a list of records (N, p), are M records of one plant; those
        with the same gaps share their covariances.
    u : (N, m) array_like or DataFrame, or an iterator of chunks like y's, optional
        Known input at the same instants, as in `filter_data`.
    time : (N,) array_like, "rows", or an iterator of chunks like y's, optional
        When each row was measured, as in `filter_data`.
    m1 : int or sequence, default 0
        Accurate outputs, as in `reduced_order_filter`: x is then the best estimate
        that shows exactly what they show at its own row.
    lag : int, optional
        Row k uses measurements up to row k + lag, and near the end as many as there
        are; 0 is the filter.  Default: all rows, before and after.
    u0 : (m,) array_like, optional
        Input from instant 0 to 1, default zero.
    weight : optional
        As in `reduced_order_filter`; without accurate outputs it has no effect.
    backend : "auto", "numpy" or "numba"
        As in `filter_data`.
    executor, chunk, into : optional
        For many records, as in `filter_data`.

    Returns
    -------
    Smoothed, SmoothedFleet of many records, or an iterator of Smoothed
        For a DataFrame or Series y, x, std, w and v are DataFrames with its index.
        From an iterator, each block has the rows whose lag has passed meanwhile, and
        one more at the end has the rest.

    Raises
    ------
    ValueError
        If sizes disagree, a value is infinite, the lag is no whole number that is
        0 or more, or y comes in chunks and there is no lag.
    ImportError
        If numba is asked for and not installed.
    DesignError
        As in `filter_data`; or if states grow together too far in a gap.

    Notes
    -----
    Accurate outputs with noise make `filter_data` forget what the whole record
    still tells: there the push of a row enters the estimates of later ones.  Here
    every row is pushed by itself, so the last row is at least as good as the filter's.

    While outputs are missing, unstable modes grow, and other directions lose digits
    beside them.  P and lag_one keep some nine digits where standard deviations grow
    fortyfold, and three where they grow a millionfold.  Where states grow further in a
    gap, the record is refused, as in `filter_data`.

    References
    ----------
    H. E. Rauch, F. Tung and C. T. Striebel, "Maximum likelihood estimates of linear
    dynamic systems", AIAA Journal 3 (1965) 1445-1450;
    smoothing/derivation/next_state.py.
    A. E. Bryson and M. Frazier, "Smoothing for linear and nonlinear dynamic systems",
    Wright-Patterson AFB, TDR-63-119 (1963); smoothing/derivation/adjoint.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> nan = float("nan")
    >>> found = lb.smooth(plant, [[2], [nan], [2]])
    >>> found.x[:, 0].round(4), found.std[:, 0].round(4)
    (array([1.3333, 1.3333, 1.3333]), array([0.5774, 0.5774, 0.5774]))
    """
    expect(plant=plant)
    u0 = dataframes.entries("u0", u0, plant.input_names)
    u0 = np.zeros(plant.m) if u0 is None else chunks.single("u0", u0, plant.m)
    where = Where(executor, chunk, into)
    y, u = dataframes.taken(y=y, u=u)
    if many(y):
        given = plant, y, u, time, m1, _lag(lag), u0, weight, backend
        return smooth_fleet(*given, where)
    where.require_none()
    y = timed(plant, y, time) if plant.dt == 0 else watched(plant, y, time)
    return smoothed(plant, y, u, _lag(lag), backend, m1, weight, u0)


def smoothed(
    plant: Plant,
    y: Any,
    u: Any,
    lag: int | None,
    backend: str,
    m1: Outputs = 0,
    weight: Any = None,
    u0: Vector | None = None,
) -> Any:
    """The same of rows whose times were read; `Timed` of a continuous plant."""
    one = Smoother(plant, m1, lag, weight, backend)
    one.begin(np.zeros(plant.m) if u0 is None else u0)
    if not isinstance(y, Iterator):
        one.read(y, u)
        return one.rows(last=True)
    if lag is None:
        raise ValueError(
            "y comes in chunks, and without a lag the first estimate needs the last "
            "row. Give lag=, how many rows an estimate may wait for, or y as one array"
        )
    return one.over(chunks.found(one.step, None, y, u))


def _lag(lag: Any) -> int | None:
    """The lag as an int, or None."""
    if lag is None:
        return None
    try:
        rows = -1 if isinstance(lag, (bool, np.bool_)) else index(lag)
    except TypeError:
        rows = -1
    if rows < 0:
        raise ValueError(
            "lag must be a number of rows, 0 or more, or None for the whole record, "
            f"got {short(lag)}"
        )
    return rows
