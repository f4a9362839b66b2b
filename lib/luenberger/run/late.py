"""A record whose readings arrive late, window by window."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..filtering import digits
from ..filtering.late import again
from ..filtering.maps import Settings
from ..filtering.pack import End, Passage, begin
from ..filtering.passes import Tape
from ..numeric import Matrix
from .record import Rows


class Awaited(NamedTuple):
    """The last rows of a part of a record, since the oldest that awaits a reading.

    Attributes
    ----------
    before : End
        The filter before them.
    rows : Rows
        One at least.
    """

    before: End
    rows: Rows

    @property
    def some(self) -> bool:
        """Whether a reading is awaited."""
        y, due, labels = self.rows.y, self.rows.due, self.rows.labels
        assert due is not None and labels is not None
        return bool((~np.isnan(y) & (due > labels[-1])).any())


def windows(
    at: Callable[[Rows, slice, int], Settings],
    rows: Rows,
    start: End | None,
    size: int,
    keep: str = "",
) -> Iterator[Passage]:
    """Passage by passage over the rows, `size` of them and those that are awaited.

    `at` gives the settings of some rows behind an instant.
    """
    for k in range(0, max(len(rows.y), 1), size):
        some, held, last = rows.part(slice(k, k + size)), 0, start
        if start is not None and start.awaited is not None:
            start, older = start.awaited
            some, held = older.then(some), len(older.y)
        settings = at(some, slice(None), 0 if start is None else start.instant)
        if start is None:
            start = last = begin(settings, rows.u0)
        due = _due(some, held)
        one, oldest, before = again(settings, start, some.y, some.u, due, keep)
        find = partial(_covariance, settings, start, some, due, held)
        own = np.where(due <= np.arange(len(due))[:, None], some.y, np.nan)[held:]
        whole = one.packed
        one = one._replace(
            x=one.x[held:],
            variances=one.variances[held:],
            tape=Tape(*(X[held:] for X in one.tape)),
            packed=whole._replace(
                y=whole.y[held:], drive=whole.drive[held:], at=whole.at[held:]
            ),
            settled=[],
        )
        gap = digits.followed(
            settings, last.gap, own, one.variances, last.instant + 1, find
        )
        awaited = last.awaited
        if len(due):
            awaited = Awaited(before, some.part(slice(oldest, None)))
        start = one.end._replace(gap=gap, awaited=awaited)
        yield one._replace(end=start)


def _covariance(
    settings: Settings, start: End, rows: Rows, due: Matrix, held: int, row: int
) -> Matrix:
    """That of a row behind those that are held, found again."""
    part, n = slice(0, held + row + 1), settings.plant.n
    tape = again(settings, start, rows.y[part], rows.u[part], due[part], "all")[0].tape
    V = tape.V[-1, :, :n]
    return (V.T * tape.D[-1]) @ V


def _due(rows: Rows, held: int) -> Matrix:
    """The row from which on each reading is known; `held` rows were done before."""
    assert rows.due is not None and rows.labels is not None
    found = np.searchsorted(rows.labels, rows.due.ravel()).reshape(rows.due.shape)
    own = np.arange(len(found))[:, None]
    return np.where(found < held, own, np.maximum(found, own))


def require_none_awaited(start: Any) -> None:
    """Raise where a part goes on without arrivals, and earlier readings have some."""
    if start is not None and start.awaited is not None and start.awaited.some:
        raise ValueError(
            "readings of the part before are still awaited, and this part says of no "
            "reading when it arrives. Give its arrival= as well."
        )
