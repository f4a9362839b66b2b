"""Readings that arrive late: rows are filtered again from the oldest that changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix, Vector
from . import pack
from .maps import Settings
from .pack import End, Passage
from .passes import State


class Versions(NamedTuple):
    """What is known of rows, first and after each arrival.

    Attributes
    ----------
    row, known : (V,) ndarray of int
        Which row, and from which row on the version holds; versions of a row are
        neighbours, in the order in which they hold.
    seen : (V, p) ndarray of bool
        The readings that it has.
    first : (N + 1,) ndarray of int
        The first version of each row.
    """

    row: np.ndarray
    known: np.ndarray
    seen: np.ndarray
    first: np.ndarray


def versions(taken: Matrix, due: Matrix) -> Versions:
    """Those of rows whose readings are `taken` (N, p), and known from rows `due` on."""
    rows = np.arange(len(due))
    later = np.where(taken & (due > rows[:, None]) & (due < len(due)), due, -1)
    known = np.sort(np.column_stack([rows, later]), axis=1)
    new = known >= 0
    new[:, 1:] &= known[:, 1:] != known[:, :-1]
    row, known = np.nonzero(new)[0], known[new]
    first = np.append(0, np.cumsum(new.sum(axis=1)))
    return Versions(row, known, taken[row] & (due[row] <= known[:, None]), first)


def again(
    settings: Settings, end: End, y: Matrix, u: Matrix, due: Matrix, keep: str = ""
) -> tuple[Passage, int, End]:
    """Filter rows behind `end`, each with the readings that had arrived by then.

    Parameters
    ----------
    y : (N, p) ndarray
        NaN where a reading was not taken, or never arrives.
    u : (N, m) ndarray
    due : (N, p) ndarray of int
        The row from which on each reading is known; N or more: behind these rows.
    keep : "" or "all"
        Whether there is a tape of each row, as of that row.

    Returns
    -------
    Passage
    int
        The oldest row of which a reading is still awaited; the last where none is.
    End
        Before that row.
    """
    rows, p, n = *y.shape, settings.plant.n
    taken = ~np.isnan(y)
    found = versions(taken, due)
    packed = pack.packed(settings, end, y, u, (found.row, found.seen))
    since = np.arange(rows)
    np.minimum.at(since, found.known, found.row)
    awaited = np.flatnonzero((taken & (due >= rows)).any(axis=1))
    oldest = int(awaited[0]) if len(awaited) else max(rows - 1, 0)
    span = int(max((np.arange(rows) - since).max(initial=0) + 1, rows - oldest + 1))
    state, before = (State(*(X.copy() for X in end.state)) for _ in range(2))
    N, kept = len(state.z), rows * (keep == "all")
    tape = pack.blank(kept, kept, n, N, p)
    x, variances = np.empty((rows, n)), np.empty((rows, n))
    done = int((np.arange(rows) - since + 1).sum())
    run = pack.text("replay", settings, packed.maps, done)
    readings, drive, at, maps = packed.part()
    t, clash = run(
        readings, drive, at, found.first, found.known, since, span, maps, state, x,
        variances, tape, oldest, before,
    )  # fmt: skip
    if clash >= 0:
        row, j = divmod(int(clash), p)
        seen = taken[row] & (due[row] <= t)
        pack.refuse(settings, end.instant + 1 + row, j, seen)
    own = found.first[:-1]  # on time
    packed = packed._replace(y=packed.y[own], at=packed.at[np.append(0, own + 1)])
    after = _end(end, rows, state, found.seen[own], u)
    seen = taken & (due < rows)
    oldest_end = _end(end, oldest, before, seen[:oldest], u[:oldest])
    return Passage(x, variances, tape, packed, after, []), oldest, oldest_end


def _end(end: End, rows: int, state: State, seen: Matrix, u: Vector) -> End:
    if not rows:
        return end
    return End(end.instant + rows, state, seen[-1], u[rows - 1], end.gap)
