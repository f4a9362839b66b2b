"""The filter and its covariance in one pass over a record, with missing values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from .. import kernels
from ..arguments import expect
from ..formats import dataframes
from ..numeric import Given
from ..plant import Plant
from ..recursion.looks import settle_tolerance
from ..recursion.progress import Progress
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from ..recursion.state import start
from . import chunks
from . import filter_chunks as by
from .clock import Clock
from .filter_chunks import Filtered
from .record import Record
from .sampled_pass import SampledPass
from .timed import timed

Outputs = int | Sequence[int | str]  # how many, or which


@overload
def filter_data(
    plant: Plant, y: Iterator[Any], u: Iterator[Any] | int | None = ..., *,
    time: Iterator[Any] | str | None = ..., m1: Outputs = ..., u0: Given = ...,
    weight: Given | str = ..., history: bool = ..., backend: str = ...,
    settle: float | None = ...,
) -> Iterator[Filtered]: ...  # fmt: skip
@overload
def filter_data(
    plant: Plant, y: ArrayLike, u: Given | int = ..., *, time: Any = ...,
    m1: Outputs = ..., u0: Given = ..., weight: Given | str = ...,
    history: bool = ..., backend: str = ..., settle: float | None = ...,
) -> Filtered: ...  # fmt: skip
def filter_data(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    time: Any = None,
    m1: Outputs = 0,
    u0: Given = None,
    weight: Given | str = None,
    history: bool = False,
    backend: str = "auto",
    settle: float | None = 1e-9,
) -> Any:
    """Filter a record in one pass, with its covariance; NaN means not measured.

    At each instant the outputs that arrived form C, and the step is that of
    `reduced_order_filter` for them.  An accurate output that is missing gives no
    exact value, so the order rises by one there: its direction is predicted and
    filtered like the others, and drops out again when the output returns.

    With S, the residual of one instant enters the prediction of the next through J.
    Where R is singular there are many J, and the one taken is J = S R^+ of
    `reduced_order_filter`, whose notes say when that matters.

    Parameters
    ----------
    plant : Plant
        With Q, R and P0.  A continuous one is sampled at the record's instants, with
        inputs held between them, a stretch of rows at a time; where x0 and P0 are of
        the instant before the first row, that is as long before it as the second row
        is after it.
    y : (N, p) array_like or DataFrame, or an iterator of such chunks
        Measurements at instants 1 .. N.  NaN, None, pandas.NA and what a mask covers
        were not measured.  With an iterator the result is an iterator of `Filtered`,
        one for each chunk, and memory stays flat.  The columns of a table are found by
        the plant's names, as in `estimate`.  `Filter` takes many
        records.
    u : (N, m) array_like or DataFrame, or an iterator of chunks like y's, optional
        Known input at the same instants.  By default the columns of the DataFrame y
        that are named as inputs, or zero for an array; 0 if there is no known input.
    time : (N,) array_like or "rows", optional
        When each row was measured: seconds, dates or durations.  Default the index of
        a table (dates, durations, decimal numbers, or called `time` or `t`) or its
        column `time` or `t`.  They must agree with a discrete plant's dt; "rows"
        leaves them out of account.  With an iterator y, an iterator of such chunks.
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
        record of a plant waits a few seconds for the compiler.  "auto" takes it, where
        numba is installed, for 20 000 rows or more in all records together; for fewer,
        if the code of this plant has been loaded in this process; and of one record of
        1000 or more, if it is kept on disk from an earlier one.  Name a backend where a
        later call must give the same bits.
    settle : float or None, default 1e-9
        The gain of a plant that does not change settles.  The recursion of the
        covariance stops where a bound says that no later row is further from it than
        this tolerance: see the notes.  None runs the recursion over every row.

    Returns
    -------
    Filtered, or an iterator of Filtered
        For a DataFrame or Series y, x and std are DataFrames with its index.

    Raises
    ------
    ValueError
        If sizes disagree or a value is infinite; if times contradict dt, do not grow,
        or lack for a continuous plant.
    ImportError
        If numba is asked for and not installed.
    DesignError
        If the plant lacks Q, R or P0, accurate outputs are dependent, or
        noise-free outputs contradict each other or a state known exactly; the
        message names outputs and instant.  If states grow so far in a gap that digits
        are gone; see the notes.

    Notes
    -----
    Where the covariance has all but settled, a ball is computed that no later
    covariance leaves, were the recursion carried on without rounding.  What rounding
    does to the gain, and to rows that have it, is counted.  If the ball is as small as
    `settle`, the rows that follow have one gain, until other outputs arrive.  Behind a
    gap the recursion runs again, until it is in the ball once more.  The bound holds
    there too, but for rounding that every filter has; it grows with these rows and
    their innovations, and is pessimistic where a covariance is badly conditioned.  The
    tolerance is relative to variances, and to standard deviations of estimates whose
    innovations are no longer than one unit.  The result says from which rows on there
    is one gain, and the bound for the innovations that there were.  Compiled code looks
    after 16,000 rows of three states, or 130 of ten, then seldom, and only where
    variances have all but stopped to change.  There is no ball where a covariance is
    singular or slow to settle, and where accurate outputs are hardly better than their
    prediction; such records run in full.  For over nine digits give ``settle=None``.

    While outputs are missing, unstable modes grow.  Where states share such a mode, x
    and P of what does not grow lose digits beside it.  The record is refused at the
    first row of a gap where two states that share a mode have 1e6 times the standard
    deviations that they had in it, or one state has 1e8 times, or 1e7 where R is
    singular.  Up to there x and P are right to a thousandth of standard deviations, if
    readings are not much larger than these.  Rows behind the gap can be a record of
    their own.  Where no output ever shows such a mode, of a plant that does not change,
    the whole record counts as a gap.

    Compiled code leaves to NumPy, some 100 times slower, rows whose covariance is close
    to singular: where outputs have noise that of the estimate, else those of the
    prediction and the innovation, as where no noise drives what exact readings tell.
    Where these tell the whole state of a plant that does not change, in every row anew,
    rows stay compiled, unless rounding of what is known would grow.
    So it does all rows where accurate outputs have noise while others have none.

    References
    ----------
    Leondes and Novak (1974), equations (27)-(36), (41)-(43);
    papers/leondes_novak/derivation/best_coordinates.py;
    papers/leondes_novak/derivation/missing_outputs.py;
    papers/leondes_novak/derivation/one_pass.py;
    papers/leondes_novak/derivation/settling.py, settled_ball.py, settled_estimate.py,
    and settled_ratio.py behind gaps;
    papers/leondes_novak/derivation/predictions.py where outputs have no noise, and
    known_state.py where they tell the state;
    papers/leondes_novak/derivation/square_root.py where a covariance is singular.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> nan = float("nan")
    >>> lb.filter_data(plant, [[2], [nan], [2]]).std[:, 0].round(4)
    array([0.7071, 0.7071, 0.5774])

    A gain that settles:

    >>> heard = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    >>> found = lb.filter_data(heard, [[1.0]] * 50)
    >>> found.settled_at, found.settle_bound < 1e-9
    (array([16]), True)

    A continuous plant, at uneven instants:

    >>> walk = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[0]], P0=[[0]])
    >>> lb.filter_data(walk, [[2], [nan], [nan]], time=[0, 1, 5]).std.T
    array([[0.        , 1.        , 2.23606798]])
    """
    expect(plant=plant)
    kernels.runs_compiled(backend, 0)  # refuse a backend now, not at the first chunk
    u0 = dataframes.entries("u0", u0, plant.input_names)
    u0 = np.zeros(plant.m) if u0 is None else chunks.single("u0", u0, plant.m)
    tolerance = settle_tolerance(settle)
    y, u = dataframes.taken(y=y, u=u)
    if not isinstance(y, Iterator) and Record(y).many:
        raise ValueError(
            "y holds many records: lb.Filter(plant).run(lb.Record(y, u)) filters them"
        )
    if plant.dt == 0:
        sampled = SampledPass(plant, m1, weight, tolerance)
        each = partial(by.sampled_chunk, sampled, history, backend)
        begin = Progress(start(sampled, plant.x0, u0))
        return chunks.found(each, begin, timed(plant, y, time), u)
    run = SettledPass(Settings(plant, m1, weight), tolerance)
    step = partial(by.chunk, run, Clock(plant, time), history, backend)
    return chunks.found(step, Progress(start(run, plant.x0, u0)), y, u)
