"""When it is worth to look whether a filter has settled, and what looks have cost.

A look takes as long as many rows of the recursion.  How variances changed in the last
rows tells nearly always what it would find, and takes next to nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import short
from ..numeric import Matrix
from ..numeric.factors import EPS

SHARE = 0.02  # of the rows, what looks that found nothing may cost but for the first
FREE = 4  # looks in NumPy, which rows are slow enough for; one in compiled code
LOOK = 45_000  # rows of n states, times n, take as long in compiled code as a look
SLOWLY = 16  # rows do in NumPy
QUICK = 16  # times less it takes, where it is quickly told that there is nothing
KEPT = 3  # rows whose variances are kept
STILL = 512 * EPS  # of a variance: a change that may be rounding


class Looks(NamedTuple):
    """The recursion so far: rows, what looks cost in rows, and the last variances.

    Attributes
    ----------
    rows, spent : int
    last : ndarray
        Of at most `KEPT` rows.
    """

    rows: int
    spent: int
    last: np.ndarray

    @classmethod
    def none(cls, n: int) -> Looks:
        """Before the first row."""
        return cls(0, 0, np.empty((0, n)))

    def after(self, variances: Matrix) -> Looks:
        """After more rows."""
        last = variances[-KEPT:].copy()
        if len(last) < KEPT:
            last = np.concatenate([self.last, last])[-KEPT:]
        return Looks(self.rows + len(variances), self.spent, last)

    def failed(self, fast: bool, quick: bool = False) -> Looks:
        """After a look that found nothing, and perhaps said so quickly."""
        cost = self.cost(fast) // (QUICK if quick else 1)
        return self._replace(spent=self.spent + cost)

    def worth(self, tolerance: float, fast: bool) -> bool:
        """Whether variances have settled so far, and a look is not too dear."""
        cost = self.cost(fast)
        most = SHARE * self.rows + (1 if fast else FREE) * cost
        return self.spent + cost <= most and settled(self.last, tolerance)

    def cost(self, fast: bool) -> int:
        """Of a look, in rows."""
        return LOOK // self.last.shape[1] if fast else SLOWLY


def settled(variances: Matrix, tolerance: float) -> bool:
    """Whether the last change and all later ones seem to be within a tolerance.

    Each is taken to be as many times smaller than the one before as the last one was.
    """
    if len(variances) < KEPT or not variances.min() > 0:
        return False
    first, second, last = variances
    before, now = (
        float((np.abs(one - other) / last).max())
        for one, other in ((second, first), (last, second))
    )
    return bool(before <= STILL or now <= tolerance * (1 - now / before))


def settle_tolerance(settle: float | None) -> float | None:
    """The argument `settle`, checked."""
    if settle is None:
        return None
    try:
        tolerance = float(settle)
    except (TypeError, ValueError):
        tolerance = 0.0
    if not 0 < tolerance < 1:
        raise ValueError(
            "settle must be a number between 0 and 1, how far rows with a settled gain "
            f"may be from the full recursion, or None for that; got {short(settle)}"
        )
    return tolerance
