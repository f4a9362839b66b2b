"""Whether states have grown so far together in a gap that their digits are lost.

What an unstable mode does while outputs are missing is a part of every state that it
moves.  Two such states are then large, and what is small in some combination of states
is rounding.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from .forward import Kept

FAR = 1e6  # times the standard deviation at the first row of a gap
ALIKE = 1e-10  # the least eigenvalue of a matrix of correlations


def require_digits(
    kept: Kept, seen: Matrix, first: int, names: tuple[str, ...]
) -> None:
    """DesignError where states have grown together in a gap, beyond their digits.

    Parameters
    ----------
    kept : Kept
        The filter's rows.
    seen : (N, p) ndarray of bool
        Which outputs arrived.
    first : int
        The instant of the first row.
    names : tuple of str
        Of the states.
    """
    if seen.all():
        return
    for begin, end in _gaps(np.asarray(~seen.all(axis=1))):
        rows = kept.variances[begin:end]
        grown = rows > FAR**2 * rows[0]
        grown &= rows[0] > 0
        at = int(np.argmax(grown.sum(axis=1)))
        together = np.flatnonzero(grown[at])
        if len(together) < 2 or _apart(kept.Sigma[begin + at]):
            continue
        who = " and ".join(repr(names[j]) for j in together[:2])
        raise DesignError(
            f"while outputs are missing from instant {first + begin} on, an unstable "
            f"mode moves {who} together, to {FAR:.0e} times the standard deviations "
            f"that they had, at instant {first + begin + at}. Too few digits are left "
            "of what is small in both. Smooth the rows before and behind "
            "it by themselves, those behind with a P0 of their own, or choose states "
            "in which this mode is a state of its own"
        )


def _gaps(missing: Vector) -> Iterator[tuple[int, int]]:
    """Stretches of rows in which something is missing, of two rows or more."""
    padded = np.concatenate([[0], missing, [0]])
    edges = np.flatnonzero(np.diff(padded))
    yield from ((i, k) for i, k in edges.reshape(-1, 2).tolist() if k - i > 1)


def _apart(Sigma: Matrix) -> bool:
    """Whether no combination of errors is all but zero beside its parts."""
    Sigma = Sigma[np.ix_(*2 * [Sigma.diagonal() > 0])]
    unit = np.sqrt(Sigma.diagonal())
    return bool(np.linalg.eigvalsh(Sigma / unit[:, None] / unit)[0] > ALIKE)
