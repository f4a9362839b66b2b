"""Whether states have grown so far in a gap that their digits are lost.

What an unstable mode does while outputs are missing is a part of every state that it
moves.  Where two states are large by it, what is small in some combination of them is
told by few digits of U.  Where no output ever shows an unstable mode, the whole record
is such a gap.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.linalg import modes
from .compiling import Text
from .maps import Settings

# The problems `drawn(seed)` of tests/filtering/test_digits.py that need these: 1727 is
# off by half a deviation where two states that share a mode have grown by 2e6, and 1994
# by 2e-3 where a state has grown by 2e8.  None of 2000 is where neither has.
TOGETHER = 1e6
ALONE = 1e8
ALIKE = 1e-10  # the least eigenvalue of correlations of states that share a mode


class Gap(NamedTuple):
    """The instant at which a gap began, 0 for none, and the least variances in it."""

    instant: int
    least: np.ndarray


@Text
def grown(y, always, variances, since, instant, begun, least):
    """The first row with a variance too far above the least in its gap, or with two.

    Two are looked for from the row `since` on.  Returns -1 if there is no such row, and
    the instant at which the gap there, or that of the last row, began.  A gap is of
    rows in which an output is missing, or `always`; row 0 is that of `instant`.
    """
    for t in range(len(y)):
        missing = always
        for j in range(y.shape[1]):
            missing = missing or y[t, j] != y[t, j]
        if not missing:
            begun = 0
            continue
        if begun == 0:
            begun = instant + t
            least[:] = np.inf
        many, alone = 0, False
        for i in range(len(least)):
            v = variances[t, i]
            if 0 < v < least[i]:
                least[i] = v
            many += v > TOGETHER * TOGETHER * least[i]
            alone = alone or v > ALONE * ALONE * least[i]
        if alone or (many > 1 and t >= since):
            return t, begun
    return -1, begun


@Text
def some_grown(y, always, calm, variances, instant, begun, least, found):
    """`grown` of many records (M, N, p), whose rows go to `found` (M,).

    Where all is `calm`, only the gap at the end of a record is looked at.
    """
    M, N, p = y.shape
    for k in range(M):
        first = N if calm and not always else 0
        while first > 0:
            missing = False
            for j in range(p):
                missing = missing or y[k, first - 1, j] != y[k, first - 1, j]
            if not missing:
                begun[k] = 0
                break
            first -= 1
        given = variances[k, first:], 0, instant + first, begun[k], least[k]
        found[k], begun[k] = grown(y[k, first:], always, *given)


def calm(variances: Matrix, least: Matrix) -> bool:
    """Whether no variance is far above any other one, or above the `least` so far."""
    low = min(variances.min(initial=np.inf), least.min(initial=np.inf))
    return bool(variances.max(initial=0.0) <= TOGETHER * TOGETHER * low)


def followed(
    settings: Settings, gap: Gap, y: Matrix, variances: Matrix, instant: int,
    P: Callable[[int], Matrix],
) -> Gap:  # fmt: skip
    """The gap in which the last row is, of rows from an instant on behind a `gap`.

    `P` finds the covariance of a row.

    Raises
    ------
    DesignError
        At the first row of a gap at which two states that share a mode have TOGETHER
        times the least deviations that they had in it, or one has ALONE times.
    """
    unseen = settings.unseen_growth
    if not (unseen or gap.instant or np.isnan(y).any()):
        return gap
    since, step = 0, 1
    while True:
        least = gap.least.copy()
        given = variances, since, instant, gap.instant, least
        row, begun = grown(y, bool(unseen), *given)
        if row < 0:
            return Gap(begun, least)
        wide = np.sqrt(variances[row] / np.where(least > 0, least, np.inf))
        alone = not wide.max() < ALONE  # nor where a variance is no number any more
        if alone or _alike(P(row)):
            break
        since, step = row + step, 2 * step  # independent states: look seldom
    count = 1 if alone else 2
    most = np.argsort(-wide)[:count]
    names = settings.plant.state_names
    who = " and ".join(repr(names[j]) for j in sorted(most.tolist()))
    why, advice, often = (
        f"outputs are missing from instant {begun} on, and an unstable mode has",
        "Give the rows behind the gap as a record of their own, with a P0 of its own",
        "measure more often",
    )
    if unseen:
        why = f"no output shows the unstable mode at {modes(unseen)}, which has"
        advice, often = "Add a sensor that sees it", "leave it out of the plant"
    raise DesignError(
        f"too few digits are left from instant {instant + row} on: {why} moved "
        f"{who}{' together' * (count > 1)}, to {wide[most[-1]]:.0e} times the standard "
        f"deviations that they had. What is small beside them is rounding. {advice}; "
        f"or choose states in which this mode is one state; or {often}"
    )


def _alike(P: Matrix) -> bool:
    """Whether some combination of errors is all but zero beside its parts."""
    size = P.diagonal()
    some = size > 0
    unit = np.sqrt(size[some])
    X = P[np.ix_(some, some)] / unit / unit[:, None]
    return bool(np.linalg.eigvalsh(X)[0] <= ALIKE)
