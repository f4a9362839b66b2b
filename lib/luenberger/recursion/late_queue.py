"""A filter whose late readings arrive in order: what it knows of all, and a queue.

A filter that has every reading of a row follows as far as they have arrived.  The rows
after it are a stretch of what was on time.  It is kept as two stretches: of the first
of these rows up to a turn, one that begins at each of them; and of the rows after the
turn one that grows.  So a reading that arrives takes a row off, and costs no more than
a few rows of a filter, whatever the lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..numeric import Vector
from .growth import Gap
from .late_passage import Stretches
from .late_state import Label, LateState
from .state import State


class Block(NamedTuple):
    """Rows of a record: y, due (N, p), u (N, m) and labels (N,); as in `Row`."""

    y: np.ndarray
    u: np.ndarray
    due: np.ndarray
    labels: np.ndarray

    def part(self, rows: slice) -> Block:
        """Some of them."""
        return Block(*(X[rows] for X in self))

    def then(self, other: Block) -> Block:
        """These rows and those of `other`."""
        return Block(*(np.concatenate(two) for two in zip(self, other)))

    def quiet(self) -> int:
        """The first row that has a reading on time, or the number of rows."""
        on_time = (~np.isnan(self.y) & (self.due <= self.labels[:, None])).any(axis=1)
        return int(on_time.argmax()) if on_time.any() else len(on_time)


class Queue(NamedTuple):
    """A filter between two rows, with the rows that await readings.

    Attributes
    ----------
    base : State
        The filter before the first of them, which has every reading.
    rows : Block
    turn : int
        How many of them are before the turn; -1 if there are no stretches yet.
    first : Stretches
        From each of the rows before the turn up to it.
    last : Stretches
        From the turn to the last row: one.
    x, Sigma : (n,), (n, n) ndarray
        The estimate now and the covariance of its error.
    label : number or None
        Of the last row.
    late : LateState or None
        The same filter as it carries the readings beside the state, where it does.
    silent : bool
        Whether no reading has been on time so far.
    gap : Gap or None
        The stretch of rows without all their readings that the last row is in.
    """

    base: State
    rows: Block
    turn: int
    first: Stretches
    last: Stretches
    x: np.ndarray
    Sigma: np.ndarray
    label: Label
    late: LateState | None
    silent: bool
    gap: Gap | None = None

    @property
    def instant(self) -> int:
        """That of the last row."""
        return self.base.instant + len(self.rows.labels)


class Plan(NamedTuple):
    """Which rows have all their readings at each row, and what is on time.

    Attributes
    ----------
    absorbed : (N,) ndarray of int
        How many rows have, of those up to each row.
    y : (N, p) ndarray
        NaN where a reading is late.
    in_order : int
        The first row at which a reading arrives before one of an earlier row, or N.
    """

    absorbed: np.ndarray
    y: np.ndarray
    in_order: int

    @classmethod
    def of(cls, rows: Block) -> Plan:
        N = len(rows.labels)
        taken, own = ~np.isnan(rows.y), np.arange(N)[:, None]
        arrives = np.searchsorted(rows.labels, rows.due.ravel()).reshape(taken.shape)
        arrives = np.where(taken, arrives, own)
        whole = np.maximum.accumulate(arrives.max(axis=1, initial=0))
        absorbed = np.searchsorted(whole, np.arange(N), "right")
        late = arrives > own
        early = late & (arrives != whole[:, None])
        y = np.where(late, np.nan, rows.y)
        return cls(absorbed, y, int(arrives[early].min(initial=N)))

    def part(self, count: int) -> Plan:
        """That of the first rows."""
        return Plan(self.absorbed[:count], self.y[:count], count)


@dataclass(frozen=True, eq=False)
class Turns:
    """From which turn the stretches of each row are counted.

    Attributes
    ----------
    begin : (N,) ndarray of int
        The first row that awaits a reading.
    at : (N,) ndarray of int
        The row after which the turn is, plus one.
    flips : list of int
        Rows at which the turn moves to their end.
    """

    begin: np.ndarray
    at: np.ndarray
    flips: list[int]

    @classmethod
    def of(cls, begin: Vector, old: int, turn: int) -> Turns:
        """For rows from the number `old` on; the turn was before the row `turn`."""
        N = len(begin)
        at, flips, k = np.full(N, turn), [], old
        while (k := max(k, int(np.searchsorted(begin, turn, "right")))) < N:
            flips.append(k)
            turn = k + 1
            at[k:] = turn
            k += 1
        return cls(begin, at, flips)
