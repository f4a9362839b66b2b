"""Whether states have grown so far together in a gap that their digits are lost.

Where no output ever shows an unstable mode, the whole record is such a gap.

What an unstable mode does while outputs are missing is a part of every state that it
moves.  Two such states are then large, and what is small in some combination of states
is rounding.  The next reading leaves little else, and so does a state that the mode
does not move.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.linalg import finite, modes
from .filter_pass import Pass
from .settings import Settings
from .state import State

FAR = 1e6  # times the least deviation in the gap: too far where states are alike
FARTHEST = 1e8  # too far for any state: beside it, one unit is rounding
NOISE_FREE = 1e7  # the same where readings without noise have to be told from it
ALIKE = 1e-10  # the least eigenvalue of a matrix of correlations
ROUNDING = 1e-12  # of a standard deviation in the same gap: no deviation, but rounding
LANES = 256  # rows that are looked at side by side
BLOCK = 1024  # rows that are looked at one by one, where states have grown


class Gap(NamedTuple):
    """A stretch of rows in which an output or a mode is missing, as far as read.

    Attributes
    ----------
    instant : int
        That of its first row.
    least : (n,) ndarray
        The least variances so far; infinite where there was only rounding.
    """

    instant: int
    least: np.ndarray


class Passed(NamedTuple):
    """Rows that a filter has passed.

    Attributes
    ----------
    settings : Settings
    first : int
        The instant of the first one.
    variances : (N, n) ndarray
    y : (N, p) ndarray
        NaN where an output did not arrive.
    Sigma : callable
        The covariances from one row to another, as a stack.
    """

    settings: Settings
    first: int
    variances: np.ndarray
    y: np.ndarray
    Sigma: Callable[[int, int], Matrix]


def passed(
    run: Pass, state: State, y: Matrix, u: Matrix, variances: Matrix, compile: bool,
    P: Matrix | None = None,
) -> Passed:  # fmt: skip
    """The rows of y that a pass took from `state` on; P (N, n, n) if it was kept."""

    def Sigma(first: int, last: int) -> Matrix:
        if P is not None:
            return P[first:last]
        at, _ = run.over(state, y[:first], u[:first], compile)
        rows = slice(first, last)
        return run.over(at, y[rows], u[rows], compile, history=True)[1].P

    return Passed(run.settings, state.instant + 1, variances, y, Sigma)


def may_grow(gap: Gap | None, settings: Settings, whole: bool) -> bool:
    """Whether states may have grown in rows behind `gap`, which may be `whole`."""
    return not (gap is None and whole and not settings.unseen_growth)


def require_digits(gap: Gap | None, rows: Passed) -> Gap | None:
    """The gap in which the last row is; `gap` is the one before the first row.

    Raises
    ------
    DesignError
        At the first row of a gap at which states have grown beyond their digits.
    """
    if not len(rows.y):
        return gap
    if not may_grow(gap, rows.settings, finite(rows.y)):
        return gap
    left = None
    for begin, end in _gaps(rows, gap is not None):
        if begin or gap is None:
            gap = Gap(rows.first + begin, np.full(rows.variances.shape[1], np.inf))
        gap = _followed(gap, rows, begin, end)
        left = gap if end == len(rows.y) else None
    return left


def _gaps(rows: Passed, before: bool) -> list[tuple[int, int]]:
    """The gaps at the first and the last row, and those in which states may grow.

    `before` tells whether the row before the first one is in a gap.
    """
    y, N = rows.y, len(rows.y)
    if rows.settings.unseen_growth:
        return [(0, N)]
    if far(*_extremes(rows.variances)):
        missing = np.concatenate([[before], _missing(y), [False]])
        edges = np.flatnonzero(missing[1:] != missing[:-1])
        edges = np.concatenate([[0], edges]) if before else edges
        begins, ends = edges[::2], edges[1::2]
        some = (begins == 0) | (ends == N)
        inner = np.flatnonzero(~some)
        if len(inner):
            some[inner] = _far_inside(rows.variances, begins[inner], ends[inner])
        return list(zip(begins[some].tolist(), ends[some].tolist()))
    end = _complete(y) if before else 0
    begin = N - _complete(y[::-1])
    if end == N:
        return [(0, N)]
    return [(0, end)] * before + [(begin, N)] * (begin < N)


def _missing(y: Matrix) -> Vector:
    """In which rows something is missing."""
    missing = np.zeros(len(y), dtype=bool)
    for output in y.T:
        missing |= np.isnan(output)
    return missing


def _complete(y: Matrix) -> int:
    """The first row in which nothing is missing, or how many there are."""
    done, size = 0, LANES
    while done < len(y):
        missing = _missing(y[done : done + size])
        if not missing.all():
            return done + int(np.argmin(missing))
        done, size = done + size, 8 * size
    return len(y)


def _far_inside(variances: Matrix, first: Vector, last: Vector) -> Vector:
    """In which gaps, with a row behind each, states may have grown."""
    edges = np.stack([first, last], axis=1).ravel()
    low, top = (f.reduceat(variances, edges)[::2] for f in (np.minimum, np.maximum))
    return far(low, top)


def far(least: Matrix, most: Matrix) -> Vector:
    """Whether two states have grown, or one much further."""
    if most.size and most.max() <= FAR**2 * least.min():
        return np.zeros(most.shape[:-1], dtype=bool)
    two = (most > FAR**2 * least).sum(axis=-1) > 1
    return np.asarray(two | (most > NOISE_FREE**2 * least).any(axis=-1))


def _extremes(variances: Matrix) -> tuple[Vector, Vector]:
    """The least and the largest variances, of many rows side by side."""
    N, n = variances.shape
    whole = N // LANES * LANES
    lanes = variances[:whole].reshape(-1, LANES * n)
    low, top = (
        np.minimum.reduce(lanes, axis=0, initial=np.inf),
        np.maximum.reduce(lanes, axis=0, initial=0.0),
    )
    low = np.concatenate([low.reshape(LANES, n), variances[whole:]])
    top = np.concatenate([top.reshape(LANES, n), variances[whole:]])
    return low.min(axis=0), top.max(axis=0)


def _followed(gap: Gap, rows: Passed, begin: int, end: int) -> Gap:
    """The gap after its rows from `begin` to `end`."""
    at = begin
    while at < end:
        here = rows.variances[at:end]  # all the rest if nothing grows there, or a block
        least, top = _since(gap.least, here)
        while len(here) > BLOCK and far(least, top):
            here = here[: max(len(here) // 8, BLOCK)]
            least, top = _since(gap.least, here)
        if far(least, top) or not (least > ROUNDING**2 * top).all():
            each = _each(gap.least, here)
            _require(gap.instant, rows, at, here / each)
            least = each[-1]
        gap, at = gap._replace(least=least), at + len(here)
    return gap


def _since(least: Vector, variances: Matrix) -> tuple[Vector, Vector]:
    """The least variances after some rows, and the largest in these."""
    low, top = _extremes(variances)
    return np.minimum(least, low), top


def _each(least: Vector, variances: Matrix) -> Matrix:
    """The least variances at each of some rows so far.

    Where a variance is far larger than they are, they are rounding: what was least
    before it counts no more.
    """
    V = np.where(variances > 0, variances, np.inf)
    found = np.minimum.accumulate(np.minimum(V, np.where(least > 0, least, np.inf)))
    while (above := variances * ROUNDING**2 > found).any():
        k = int(np.argmax(above.any(axis=1)))
        found[k:, above[k]] = np.minimum.accumulate(V[k:, above[k]])
    return found


def _require(instant: int, rows: Passed, at: int, grown: Matrix) -> None:
    """Refuse rows from `at` on if variances have `grown` there beyond their digits.

    `instant` is where the gap begins.  States are looked at in rows further and further
    apart.
    """
    many = np.flatnonzero(far(np.ones(grown.shape[1]), grown))
    if not len(many):
        return
    looked = [int(k) for k in 2.0 ** np.arange(60) - 1 if k < len(many)]
    look = many[[*looked, -1]]
    Sigma = rows.Sigma(at + int(look[0]), at + int(look[-1]) + 1)[look - look[0]]
    alike = _alike(Sigma) & ((grown[look] > FAR**2).sum(axis=1) > 1)
    farthest = NOISE_FREE if rows.settings.noise_free else FARTHEST
    lost = alike | (grown[look] > farthest**2).any(axis=1)
    if not lost.any():
        return
    first = int(np.argmax(lost))
    k, count = int(look[first]), 2 if alike[first] else 1
    wide = np.sqrt(grown[k])
    most = np.argsort(-wide)[:count]
    names, unseen = rows.settings.plant.state_names, rows.settings.unseen_growth
    who = " and ".join(repr(names[j]) for j in sorted(most.tolist()))
    why, advice, often = (
        f"outputs are missing from instant {instant} on, and an unstable mode has",
        "Give the rows behind the gap as a record of their own, with a P0 of its own",
        "measure more often",
    )
    if unseen:
        why = f"no output shows the unstable mode at {modes(unseen)}, which has"
        advice, often = "Add a sensor that sees it", "leave it out of the plant"
    raise DesignError(
        f"too few digits are left from instant {rows.first + at + k} on: {why} moved "
        f"{who}{' together' * (count > 1)}, to {wide[most[-1]]:.0e} times the standard "
        f"deviations that they had. What is small beside them is rounding. {advice}; "
        f"or choose states in which this mode is one state; or {often}"
    )


def _alike(Sigma: Matrix) -> Vector:
    """Whether some combination of errors is all but zero beside its parts."""
    size = Sigma.diagonal(axis1=1, axis2=2)
    unit = np.sqrt(np.where(size > 0, size, 1.0))
    X = Sigma / unit[:, :, None] / unit[:, None]
    X = X + np.where(size > 0, 0.0, 1.0)[:, None] * np.eye(Sigma.shape[-1])
    finite = np.isfinite(X).all(axis=(1, 2))
    found = np.zeros(len(X), dtype=bool)
    found[finite] = np.linalg.eigvalsh(X[finite])[:, 0] <= ALIKE
    return found
