"""Run a given observer on recorded data."""

import numpy as np

from .certificate import require_real
from .kernels import require_backend


def estimate(observer, y, u=None, *, u0=None, z0=None, x0=None, backend="auto"):
    """Run an observer on recorded data.

    Parameters
    ----------
    observer : Observer
        Discrete.
    y : (N, p) array_like
        Measurements; for a time-varying filter row k is instant k + 1.
    u : (N, m) array_like, optional
        Known input at the same instants, default zero.
    u0 : (m,) array_like, optional
        For a time-varying filter, the input that acted from instant 0 to 1.
    z0 : (r,) array_like, optional
        State of the observer at the first row, default as designed.
    x0 : (n,) array_like, optional
        Instead of z0: a guess of the plant state, at the first row for a constant
        observer, at instant 0 (the mean of x[0]) for a time-varying filter.
    backend : "auto" or "numpy"

    Returns
    -------
    (N, q) ndarray
        The estimate of L x at each row; it uses y up to and including that row.

    Raises
    ------
    ValueError
        If sizes disagree, a value is missing (use `filter_data`), a time-varying
        filter is given more rows than it has, or both z0 and x0 are given.

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
    require_backend(backend)
    require_real("estimate", observer)
    o = observer
    if o.dt == 0:
        raise ValueError("recorded data need a discrete observer; this one has dt = 0")
    y = rows("y", y, o.D.shape[-1])
    u = rows("u", np.zeros((len(y), o.G.shape[-1])) if u is None else u, o.G.shape[-1])
    if len(u) != len(y):
        raise ValueError(f"y has {len(y)} rows but u has {len(u)}")
    if o.steps is not None and len(y) > o.steps:
        raise ValueError(f"y has {len(y)} rows, the filter was designed for {o.steps}")
    F, G, D, P, V, W = (
        X if o.steps is None else X[: len(y)] for X in (o.F, o.G, o.D, o.P, o.V, o.W)
    )
    drive = _apply(G, u) + _apply(D, y)
    z = np.empty((len(y), o.order))
    state = start(o, u0, z0, x0)
    for k in range(len(y)):
        z[k] = state
        state = (F if o.steps is None else F[k]) @ state + drive[k]
    return _apply(P, z) + _apply(V, y) + _apply(W, u)


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
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be an array of numbers: {error}") from None
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
    array = np.asarray(value, dtype=float)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be {size} finite numbers, got {value!r}")
    return array
