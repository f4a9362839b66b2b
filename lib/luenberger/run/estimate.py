"""Run a given observer on recorded data."""

from collections.abc import Iterator

import numpy as np

from ..arguments import expect
from ..certificate import require_real
from ..errors import short
from ..formats import dataframes
from ..kernels import entries_known, over_record, plain_array, runs_compiled
from ..numeric.validation import entries

ESTIMATED = 1_000_000  # rows that NumPy estimates in the time that compiling takes


def estimate(observer, y, u=None, *, u0=None, z0=None, x0=None, backend="auto"):
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
        Known input at the same instants, default zero.  If y is a DataFrame with
        columns named `observer.input_names`, the default is these.
    u0 : (m,) array_like, optional
        For a time-varying filter, the input that acted from instant 0 to 1.
    z0 : (r,) array_like, optional
        State of the observer at the first row, default as designed.
    x0 : (n,) array_like, optional
        Instead of z0: a guess of the plant state, at the first row for a constant
        observer, at instant 0 (the mean of x[0]) for a time-varying filter.
    backend : "auto", "numpy" or "numba"
        "numba" runs code compiled for this observer (`pip install luenberger[fast]`),
        the same to rounding; "auto" takes it for records of a million rows or more,
        where numba is installed.

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
        raise ValueError("recorded data need a discrete observer; this one has dt = 0")
    u0 = dataframes.entries("u0", u0, observer.input_names)
    x0 = dataframes.entries("x0", x0, observer.state_names)
    run = _Run(observer, start(observer, u0, z0, x0), backend)
    if not isinstance(y, Iterator):
        return run.chunk(y, u)
    if u is not None and not isinstance(u, Iterator):
        raise ValueError("y is an iterator of chunks, so u must be one too")
    return (run.chunk(*part) for part in pairs(y, u))


class _Run:
    """An observer on its way over a record: its state and how many rows are done."""

    def __init__(self, observer, z, backend):
        self.observer, self.z, self.backend, self.k = observer, z, backend, 0

    def chunk(self, y, u):
        """The estimates of the next rows."""
        o, table = self.observer, y
        y, u = dataframes.arrays(y, u, o.output_names, o.input_names)
        y = rows("y", y, o.D.shape[-1])
        m = o.G.shape[-1]
        u = rows("u", np.zeros((len(y), m)) if u is None else u, m)
        if len(u) != len(y):
            raise ValueError(f"y has {len(y)} rows but u has {len(u)}")
        here = slice(self.k, self.k + len(y))
        if o.steps is not None and here.stop > o.steps:
            raise ValueError(
                f"y has {here.stop} rows, the filter was designed for {o.steps}"
            )
        self.k = here.stop
        fast = runs_compiled(self.backend, here.stop, ESTIMATED)
        found = (self.compiled if fast else self.plain)(y, u, here)
        return dataframes.like(table, found, o.estimate_names)

    def plain(self, y, u, here):
        matrices = (getattr(self.observer, name) for name in "FGDPVW")
        F, G, D, P, V, W = (X if X.ndim == 2 else X[here] for X in matrices)
        drive = _apply(G, u) + _apply(D, y)
        z = np.empty((len(y), self.observer.order))
        state = self.z
        for k in range(len(y)):
            z[k] = state
            state = (F if F.ndim == 2 else F[k]) @ state + drive[k]
        self.z = state
        return _apply(P, z) + _apply(V, y) + _apply(W, u)

    def compiled(self, y, u, here):
        o, N = self.observer, len(y)
        varying = o.steps is not None
        given = {name: getattr(o, name) for name in "FGDPVW"}
        stacks = {k: X if varying else X[None] for k, X in given.items()}
        q, r = o.P.shape[-2:]
        sizes = dict(m=u.shape[1], p=y.shape[1], q=q, r=r)
        step, given = over_stacks("observer_recursion", sizes, stacks, here)
        index = np.arange(N) if varying else np.zeros(1, dtype=np.int64)
        z, w_hats = np.array(self.z, dtype=float), np.empty((N, q))
        step(
            **given, start=0, stop=N, now=index, before=index, keep=False, z=z,
            good=np.ones(N if varying else 1, dtype=bool), y=plain_array(y),
            u=plain_array(u), w_hats=w_hats,
        )  # fmt: skip
        self.z = z
        return w_hats


def over_stacks(recursion, sizes, stacks, here=slice(None)):
    """A compiled loop over a record, and the matrices of the rows `here` as it asks.

    A stack (S, rows, cols) of one matrix is the same in every row.  Entries that are
    0, or 1, in all of a stack are known to the compiler; see `kernels.over_record`.
    """
    changing = frozenset(name for name, X in stacks.items() if len(X) > 1)
    known = tuple(
        (name, entries_known((X == 0).all(axis=0), (X == 1).all(axis=0)))
        for name, X in stacks.items()
    )
    step, given = over_record(recursion, tuple(sizes.items()), known, changing), {}
    for name, X in stacks.items():
        part = X[here] if name in changing else X
        flat = part.reshape(len(part), X.shape[1] * X.shape[2])
        given[name] = np.array(flat, order="C")
    return step, given


def pairs(y, u):
    """The chunks of y with those of u, or with None; both are iterators."""
    for part in y:
        inputs = None if u is None else next(u, ())
        if inputs is not None and len(inputs) == 0 < len(part):
            raise ValueError("u has fewer chunks, or emptier ones, than y")
        yield part, inputs


def _apply(matrix, signal):
    """matrix @ signal row by row; the matrix may change from row to row."""
    if matrix.ndim == 2:
        return signal @ matrix.T
    return (matrix @ signal[..., None])[..., 0]


def start(observer, u0=None, z0=None, x0=None):
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


def rows(name, value, width, missing=False):
    """Return `value` as (N, width) floats, all finite; NaN only where `missing`."""
    array = real(name, value, "an array of numbers")
    if array.ndim == 1 and width == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{name} must be (N, {width}), got {array.shape}")
    if missing:
        infinite = np.isinf(array)
        if infinite.any():
            raise ValueError(
                f"{name} is infinite in row {int(np.argwhere(infinite)[0, 0])}"
            )
    elif not np.isfinite(array).all():
        raise ValueError(
            f"{name} has values that are missing or not finite, first in row "
            f"{int(np.argwhere(~np.isfinite(array))[0, 0])}; filter_data accepts NaN "
            "in y as not measured"
        )
    return array


def single(name, value, size):
    array = real(name, value, f"{size} finite numbers")
    if array.shape != (size,) or not np.isfinite(array).all():
        got = short(array.tolist())
        raise ValueError(f"{name} must be {size} finite numbers, got {got}")
    return array


def real(name, value, wanted):
    """`value` as floats, NaN where it is missing."""
    try:
        return entries(value, truth=True)[0]
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name} must be {wanted}: {error}") from None
