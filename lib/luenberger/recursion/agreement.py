"""Whether noise-free readings agree with what is known: beside what both are made of.

Two numbers that should be equal differ by the rounding of what they were made of, and
by what rounding of earlier instants has become since.  The latter obeys the recursion
of the error: an unstable mode that no noise disturbs makes it grow.  Its covariance
is carried along, so that a difference can be told from a contradiction.
"""

import numpy as np

from ..errors import DesignError
from ..numeric.factors import CLEAR, EPS, rounded

CONFLICT_TOL = 1e-6  # readings may be rounded by this, beside what they are met with


class Agreement:
    """The covariance of the rounding in an estimate, and what it met last."""

    def __init__(self, x):
        self.rounding = np.diag((EPS * x.ravel()) ** 2)

    def step(self, A, C, new, made_of, read):
        """Follow a step of the estimate.

        Parameters
        ----------
        A, C : (n, n), (p, n) ndarray
            Of the step; A is that of the error.
        new : dict
            K and Y of the step; unit (p,), the rounding of the outputs that its gain
            was found with, and K_size, whose rounding is that of Kmv.
        made_of : (n,) ndarray
            The magnitudes that x_minus is a sum of.
        read : (p,) ndarray
            Those of y - E u.
        """
        rounding = rounded(A @ self.rounding @ A.T, made_of)
        self.size = read + np.abs(C) @ made_of  # what the innovation is a sum of
        self.before = rounded(C @ rounding @ C.T, self.size)
        size = made_of + (new["K_size"] + np.abs(new["K"])) @ self.size
        self.some = new["unit"] > 0
        self.mixed = EPS * np.linalg.norm(self.size[self.some] / new["unit"][self.some])
        self.rounding = rounded(new["Y"] @ rounding @ new["Y"].T, size)

    def require(self, known, innovation, names, instant):
        """Raise unless the combinations `known` of the innovation are rounding."""
        if not known.size:
            return
        left = np.abs(known.T @ innovation)
        size = CONFLICT_TOL * (np.abs(known).T @ self.size)
        grown = np.sqrt(np.einsum("ji,jk,ki->i", known, self.before, known))
        # a variance left out as rounding may be real: 5 sigmas of it are no conflict
        size += CLEAR * (grown + (self.mixed + 5) * known[self.some].any(axis=0))
        bad = left > size
        if bad.any():
            part = np.abs(known[:, bad]).max(axis=1)
            which = [names[j] for j in np.flatnonzero(part > 1e-6 * part.max())]
            scale = np.abs(known[:, bad]).max(axis=0)
            raise DesignError(
                f"at instant {instant} the noise-free outputs {which} contradict each "
                "other, or a state that is believed known exactly, by "
                f"{(left[bad] / scale).max():.3g}. Give them noise in R, or raise Q or "
                "P0."
            )
