"""Whether noise-free readings agree with what is known: beside what both are made of.

Two numbers that should be equal differ by the rounding of what they were made of, and
by what rounding of earlier instants has become since.  The latter obeys the recursion
of the error: an unstable mode that no noise disturbs makes it grow.  Its covariance
is carried along, so that a difference can be told from a contradiction.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import CLEAR, EPS, rounded

CONFLICT_TOL = 1e-6  # readings may be rounded by this, beside what they are met with


class Met(NamedTuple):
    """What an innovation is made of, and the rounding that is in it.

    ``size`` (p,) holds the magnitudes that it is a sum of, ``rounding`` (p, p) is the
    covariance of what came with the estimate.
    """

    size: np.ndarray
    rounding: np.ndarray


def rounding_of(x: Matrix) -> Matrix:
    """The covariance of the rounding in an estimate that was just given."""
    return np.diag((EPS * x.ravel()) ** 2)


def followed(
    rounding: Matrix, A: Matrix, C: Matrix, new: Matrices, made_of: Vector, read: Vector
) -> tuple[Matrix, Met]:
    """The covariance of the rounding after a step, and what the step `Met`.

    Parameters
    ----------
    rounding : (n, n) ndarray
        That of the estimate before the step.
    A, C : (n, n), (p, n) ndarray
        Of the step; A is that of the error.
    new : dict
        K and Y of the step; with noise-free outputs also K_size, whose rounding is
        that of Kmv.
    made_of : (n,) ndarray
        The magnitudes that x_minus is a sum of.
    read : (p,) ndarray
        Those of y - E u.
    """
    rounding = rounded(A @ rounding @ A.T, made_of)
    size = read + np.abs(C) @ made_of
    moved = made_of + (new.get("K_size", 0) + np.abs(new["K"])) @ size
    met = Met(size, rounded(C @ rounding @ C.T, size))
    return rounded(new["Y"] @ rounding @ new["Y"].T, moved), met


def require_agreement(
    known: Matrix | None,
    innovation: Vector,
    met: Met,
    unit: Vector,
    names: Sequence[str],
    instant: int,
) -> None:
    """Raise unless the combinations `known` of the innovation are rounding.

    `unit` (p,) is the rounding of the outputs that the gain was found with.
    """
    if known is None or not known.size:
        return
    left = np.abs(known.T @ innovation)
    size = CONFLICT_TOL * (np.abs(known).T @ met.size)
    grown = np.einsum("ji,jk,ki->i", known, met.rounding, known)
    grown = np.sqrt(np.maximum(grown, 0))  # rounding may have made it less
    some = unit > 0
    mixed = EPS * np.hypot.reduce(met.size[some] / unit[some])  # no square overflows
    # a variance left out as rounding may be real: 5 sigmas of it are no conflict
    size += CLEAR * (grown + (mixed + 5) * known[some].any(axis=0))
    bad = left > size
    if bad.any():
        # `known` is in units of one over each output's, so that these are not
        part = np.abs(known[:, bad]) * np.where(some, unit, 1.0)[:, None]
        told = (part > 1e-6 * part.max(axis=0)).any(axis=1)
        which = [names[j] for j in np.flatnonzero(told).tolist()]
        scale = np.abs(known[:, bad]).max(axis=0)
        raise DesignError(
            f"at instant {instant} the noise-free outputs {which} contradict each "
            "other, or a state that is believed known exactly, by "
            f"{(left[bad] / scale).max():.3g}. Give them noise in R, or raise Q or P0."
        )
