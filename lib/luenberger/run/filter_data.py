"""The filter and its covariance in one pass over a record, with missing values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from .. import kernels
from ..arguments import expect
from ..formats import dataframes
from ..numeric import Given, Matrix, Vector
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.settings import Settings
from ..recursion.state import State, start
from . import chunks


@dataclass(frozen=True, eq=False)
class Filtered:
    """What `filter_data` returns; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray or pandas.DataFrame
        Estimates of the state, each using y up to and including its row.
    std : (N, n) ndarray or pandas.DataFrame
        Their one-sigma errors, square roots of the diagonal of P.
    P : (n, n) or (N, n, n) ndarray
        Error covariance at the last row; with ``history=True`` at every row.
    K : (N, n, p) ndarray or None
        Gains, with ``history=True``; the columns of missing outputs are zero.
    orders : (N,) ndarray of int
        States the reduced-order filter needs at each row: n minus the number of
        accurate outputs that arrived.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None
    orders: np.ndarray


Outputs = int | Sequence[int | str]  # how many, or which


@overload
def filter_data(
    plant: Plant, y: Iterator[Any], u: Iterator[Any] | None = ..., *, m1: Outputs = ...,
    u0: Given = ..., weight: Given | str = ..., history: bool = ..., backend: str = ...
) -> Iterator[Filtered]: ...  # fmt: skip
@overload
def filter_data(
    plant: Plant, y: ArrayLike, u: Given = ..., *, m1: Outputs = ...,
    u0: Given = ..., weight: Given | str = ..., history: bool = ..., backend: str = ...
) -> Filtered: ...  # fmt: skip
def filter_data(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    m1: Outputs = 0,
    u0: Given = None,
    weight: Given | str = None,
    history: bool = False,
    backend: str = "auto",
) -> Any:
    """Filter a record in one pass, with its covariance; NaN means not measured.

    At each instant the outputs that arrived form C, and the step is that of
    `reduced_order_filter` for them.  An accurate output that is missing cannot be
    taken at its word, so the order rises by one there: its direction is predicted
    and filtered like the others, and drops out again when the output returns.

    With S, the residual of one instant enters the prediction of the next through J.
    Where R is singular there are many J, and the one taken is J = S R^+ of
    `reduced_order_filter`, whose notes say when that matters.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q, R and P0.
    y : (N, p) array_like or pandas.DataFrame, or an iterator of such chunks
        Measurements at instants 1 .. N.  NaN, None, pandas.NA and what a mask covers
        were not measured.  With an iterator the result is an iterator of `Filtered`,
        one for each chunk, and memory stays flat.  The columns of a DataFrame are
        found by the plant's names, as in `estimate`.
    u : (N, m) array_like or DataFrame, or an iterator of chunks like y's, optional
        Known input at the same instants, default zero, or the columns of the
        DataFrame y that are named as inputs.
    m1 : int or sequence, default 0
        Accurate outputs, as in `reduced_order_filter`; 0 is the Kalman filter.
    u0 : (m,) array_like, optional
        Input from instant 0 to 1, default zero.
    weight : optional
        As in `reduced_order_filter`.
    history : bool, default False
        Keep the covariance and gain of every row.
    backend : "auto", "numpy" or "numba"
        "numba" runs code compiled for this plant (`pip install luenberger[fast]`),
        hundreds of times faster than "numpy" and the same to rounding; the first
        record of a plant waits a few seconds for the compiler.  "auto" takes it
        for records of 20 000 rows or more, where numba is installed.

    Returns
    -------
    Filtered, or an iterator of Filtered
        For a DataFrame or Series y, x and std are DataFrames with its index.

    Raises
    ------
    ValueError
        If sizes disagree or a value is infinite.
    ImportError
        If numba is asked for and not installed.
    DesignError
        If the plant lacks Q, R or P0, accurate outputs are dependent, or
        noise-free outputs contradict each other or a state known exactly; the
        message names outputs and instant.

    References
    ----------
    Leondes and Novak (1974), equations (27)-(36), (41)-(43);
    papers/leondes_novak/derivation/best_coordinates.py;
    papers/leondes_novak/derivation/missing_outputs.py;
    papers/leondes_novak/derivation/one_pass.py;
    papers/leondes_novak/derivation/square_root.py where a covariance is singular.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> nan = float("nan")
    >>> lb.filter_data(plant, [[2], [nan], [2]]).std[:, 0].round(4)
    array([0.7071, 0.7071, 0.5774])
    """
    expect(plant=plant)
    settings = Settings(plant, m1, weight)
    u0 = dataframes.entries("u0", u0, plant.input_names)
    u0 = np.zeros(plant.m) if u0 is None else chunks.single("u0", u0, plant.m)
    kernels.runs_compiled(backend, 0)  # refuse a backend now, not at the first chunk
    step = partial(_chunk, Pass(settings), history, backend)
    return chunks.found(step, start(settings, plant.x0, u0), y, u)


def _chunk(
    run: Pass, history: bool, backend: str, state: State, y: Any, u: Any
) -> tuple[State, Filtered]:
    """Filter the next rows of a pass: the state after them, and their `Filtered`."""
    plant, table = run.settings.plant, y
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    y, u = chunks.arrays(y, u, outputs, inputs, missing=True)
    last = state.instant + len(y)
    if plant.steps is not None and last >= plant.steps:
        raise ValueError(
            f"the plant has rows for instants 0 .. {plant.steps - 1}, the data "
            f"reach instant {last}"
        )
    fast = kernels.runs_compiled(backend, last)
    state, (x, variances, P, K) = run.over(state, y, u, fast, history)
    std = np.sqrt(np.maximum(variances, 0, out=variances), out=variances)
    x, std = (dataframes.like(table, X, plant.state_names) for X in (x, std))
    P, K = (P, K) if history else (state.Sigma, None)
    return state, Filtered(x, std, P, K, _orders(plant, run.settings.accurate, y))


def _orders(plant: Plant, accurate: Sequence[int], y: Matrix) -> Vector:
    """n minus the number of accurate outputs in each row."""
    if not len(accurate):
        return np.broadcast_to(plant.n, len(y))  # takes no memory for a long record
    return plant.n - (~np.isnan(y[:, list(accurate)])).sum(axis=1)
