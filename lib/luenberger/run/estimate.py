"""Run a given observer on recorded data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import expect
from ..certificate import require_real
from ..errors import SAMPLE
from ..formats import dataframes
from ..kernels import (
    Recursion,
    at_hand,
    entries_known,
    may_be_at_hand,
    over_record,
    plain_array,
    runs_compiled,
)
from ..numeric import Given, Matrices, Matrix, Vector
from ..observer import Observer
from ..papers.leondes_novak.derivation import observer_step
from . import chunks
from .chunks import single
from .clock import Clock

ESTIMATED = 1_000_000  # rows that NumPy estimates in the time that compiling takes
OBSERVER = Recursion(
    observer_step,
    carried=(("z_next", "z"),),
    rows=(("y", "y", 0), ("u", "u", 0)),
    written=(("w_hats", "w_hat", "vector"),),
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
    backend: str = ...
) -> Matrix: ...  # fmt: skip
@overload
def estimate(
    observer: Observer, y: Any, u: Any = ..., *,
    time: Any = ..., u0: Given = ..., z0: Given = ..., x0: Given = ...,
    backend: str = ...
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
) -> Any:
    """Run an observer on recorded data.

    Parameters
    ----------
    observer : Observer
        Discrete.
    y : (N, p) array_like or pandas.DataFrame, or an iterator of such chunks
        Measurements; for a time-varying filter row k is instant k + 1.  With an
        iterator the result is an iterator of arrays, one for each chunk, and memory
        stays flat.  The columns of a DataFrame are found by `observer.output_names`,
        in any order and among others; by position where the observer has no names.
        A Series is the one channel of p = 1.
    u : (N, m) array_like or DataFrame, or an iterator of chunks like y's, optional
        Known input at the same instants.  By default the columns of the DataFrame y
        that are named `observer.input_names`, or zero for an array; 0 if there is no
        known input.
    time : (N,) array_like or "rows", optional
        When each row was measured, as in `filter_data`.  It must agree with dt.
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
        rows or more, or if it is at hand, as in `filter_data`.

    Returns
    -------
    (N, q) ndarray, or an iterator of them
        The estimate of L x at each row; it uses y up to and including that row.  For
        a DataFrame or Series y a DataFrame: the index is y's, the columns are
        `observer.estimate_names`.

    Raises
    ------
    ValueError
        If sizes disagree, a value is missing (use `filter_data`), a time-varying
        filter is given more rows than it has, or both z0 and x0 are given.  If a
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
    step = partial(_chunk, observer, Clock(observer, time), backend)
    return chunks.found(step, begun, y, u)


def _chunk(
    observer: Observer,
    watch: Clock,
    backend: str,
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
    if o.steps is not None and here.stop > o.steps:
        raise ValueError(
            f"y has {here.stop} rows, the filter was designed for {o.steps}; design it "
            f"with steps={here.stop}, or filter_data(plant, y) takes any number"
        )
    fast = runs_compiled(backend, here.stop, ESTIMATED, ready=partial(_at_hand, o))
    z, found = (_compiled if fast else _plain)(o, z, y, u, here)
    return (here.stop, z), dataframes.like(table, found, o.estimate_names)


def plain(
    observer: Observer,
    y: Matrix,
    u: Matrix,
    kept: Callable[[Vector], Vector] = np.positive,
) -> Matrix:
    """Estimates of a constant observer from z0 on; of each state it keeps kept(z)."""
    return _plain(observer, kept(observer.z0), y, u, slice(0, len(y)), kept)[1]


def _plain(
    observer: Observer,
    z: Vector,
    y: Matrix,
    u: Matrix,
    here: slice,
    kept: Callable[[Vector], Vector] = np.positive,
) -> tuple[Vector, Matrix]:
    """The state after the rows `here`, and their estimates, in NumPy."""
    matrices = (getattr(observer, name) for name in "FGDPVW")
    F, G, D, P, V, W = (X if X.ndim == 2 else X[here] for X in matrices)
    drive = _apply(G, u) + _apply(D, y)
    states = np.empty((len(y), observer.order))
    for k in range(len(y)):
        states[k] = z
        z = kept((F if F.ndim == 2 else F[k]) @ z + drive[k])
    return z, _apply(P, states) + _apply(V, y) + _apply(W, u)


def _compiled(
    observer: Observer, z: Vector, y: Matrix, u: Matrix, here: slice
) -> tuple[Vector, Matrix]:
    """The same in compiled code."""
    step = over_stacks(OBSERVER, *_stacks(observer), here)
    z, w_hats = np.array(z, dtype=float), np.empty((len(y), len(observer.L)))
    step(stop=len(y), z=z, y=plain_array(y), u=plain_array(u), w_hats=w_hats)
    return z, w_hats


def _stacks(o: Observer) -> tuple[dict[str, int], Matrices]:
    """The sizes of an observer, and stacks of its matrices."""
    given = {name: getattr(o, name) for name in "FGDPVW"}
    sizes = dict(m=o.G.shape[-1], p=o.D.shape[-1], q=len(o.L), r=o.order)
    return sizes, {k: X if o.steps is not None else X[None] for k, X in given.items()}


def _at_hand(observer: Observer, rows: int) -> bool:
    """Whether the code for this observer has been compiled before."""
    if not may_be_at_hand(rows):
        return False
    return at_hand(rows, *_question(OBSERVER, *_stacks(observer)))


def _question(
    recursion: Recursion, sizes: dict[str, int], stacks: Matrices
) -> tuple[Recursion, tuple, tuple, frozenset[str]]:
    """What `kernels.over_record` is asked for."""
    changing = frozenset(name for name, X in stacks.items() if len(X) > 1)
    known = tuple(
        (name, entries_known((X == 0).all(axis=0), (X == 1).all(axis=0)))
        for name, X in stacks.items()
    )
    return recursion, tuple(sizes.items()), known, changing


def over_stacks(
    recursion: Recursion,
    sizes: dict[str, int],
    stacks: Matrices,
    here: slice = slice(None),
) -> partial:
    """A compiled loop over a record, which has the matrices of the rows `here`.

    It still asks for ``stop``, the number of rows, and for what is not a matrix.  A
    stack (S, rows, cols) of one matrix is the same in every row.  Entries that are 0,
    or 1, in all of a stack are known to the compiler; see `kernels.over_record`.
    """
    asked = _question(recursion, sizes, stacks)
    step, changing, given = over_record(*asked), asked[-1], {}
    for name, X in stacks.items():
        part = X[here] if name in changing else X
        flat = part.reshape(len(part), X.shape[1] * X.shape[2])
        given[name] = np.array(flat, order="C")
    index = np.arange(max(map(len, given.values())))
    given |= dict(now=index, before=index, good=np.ones(len(index), dtype=bool))
    return partial(step, **given, start=0, keep=False)


def _apply(matrix: Matrix, signal: Matrix) -> Matrix:
    """matrix @ signal row by row; the matrix may change from row to row."""
    if matrix.ndim == 2:
        return signal @ matrix.T
    return (matrix @ signal[..., None])[..., 0]


def start(
    observer: Observer,
    u0: ArrayLike | None = None,
    z0: ArrayLike | None = None,
    x0: ArrayLike | None = None,
) -> Vector:
    """The observer's state at its first row."""
    o = observer
    if z0 is not None and x0 is not None:
        raise ValueError("give z0 (the observer's state) or x0 (the plant's), not both")
    if u0 is not None and o.G0 is None:
        raise ValueError(
            "u0 is the input before the first row of a filter designed over steps; a "
            "constant observer starts from z0 or x0"
        )
    if z0 is not None:
        return single("z0", z0, o.order)
    state = o.z0 if x0 is None else o.T0 @ single("x0", x0, o.L.shape[1])
    return state if u0 is None else state + o.G0 @ single("u0", u0, o.G.shape[-1])
