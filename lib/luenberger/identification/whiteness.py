"""Innovations, and whether they are white and as large as they should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # its parts load when first used

from ..numeric import Matrix

LAGS = 20
PART = 5  # lags take at most this part of a record
LEVEL = 0.05  # what is less probable is not believed


@dataclass(frozen=True, eq=False)
class Whiteness:
    """Two tests of normalised innovations: that they are white, and of variance one.

    Attributes
    ----------
    autocorrelation : (lags, p, p) ndarray
        Entry [k - 1, i, j] is that of output i with output j, k instants before.
    bound : float
        Two standard errors of such an entry, if the innovations are white.
    statistic : float
        The sum of squares of all entries, times the number of rows.
    dof : int
        What it is on average; it has a chi-square distribution.
    p_value : float
        How probable so large a sum is.
    variance, variance_error : (p,) ndarray
        Mean square of each output's innovations, and two standard errors of it.
    """

    autocorrelation: np.ndarray
    bound: float
    statistic: float
    dof: int
    p_value: float
    variance: np.ndarray
    variance_error: np.ndarray

    @property
    def white(self) -> bool:
        """Whether the autocorrelations are believable."""
        return self.p_value >= LEVEL

    @property
    def sized(self) -> bool:
        """Whether the variances are believable."""
        return bool((np.abs(self.variance - 1) <= self.variance_error).all())

    @property
    def sentences(self) -> list[str]:
        """What the tests say."""
        first = self.autocorrelation[0].diagonal()
        which = int(np.abs(first).argmax())
        said = "are white" if self.white else "are not white"
        out = [
            f"The normalised innovations {said}: the sum of squares of "
            f"{len(self.autocorrelation)} autocorrelations is {self.statistic:.3g} "
            f"where {self.dof} is expected (p = {self.p_value:.2g}); the first is "
            f"{first[which]:.2g}, and two standard errors are {self.bound:.2g}."
        ]
        worst = int(np.abs(self.variance - 1).argmax())
        size = np.sqrt(self.variance[worst])
        said = "as it should be" if self.sized else "and should be 1"
        out.append(
            f"Their standard deviation is {size:.3g}, {said} within "
            f"{self.variance_error[worst] / 2:.2g}."
        )
        return out


def whiteness(
    normalised: Matrix, fitted: int = 0, lags: int | None = None
) -> Whiteness:
    """Test normalised innovations (N, p), NaN where there are none.

    Parameters
    ----------
    normalised : (N, p) array_like
        Innovations in units of their covariance.
    fitted : int
        Numbers fitted to this record beyond the covariance of the innovation.
    lags : int, optional
        Default 20, or a fifth of the rows.

    References
    ----------
    Hosking (1980), "The multivariate portmanteau statistic", with sample
    correlations; Mehra (1970) tests filters so.
    """
    e = np.asarray(normalised, dtype=float)
    there = ~np.isnan(e)
    rows = len(e)
    lags = max(min(LAGS, rows // PART), 1) if lags is None else lags
    filled = np.where(there, e, 0.0)
    count = there.sum(axis=0)
    variance = (filled**2).sum(axis=0) / np.maximum(count, 1)
    unit = np.sqrt(np.where(variance > 0, variance, 1.0))
    filled, seen = filled / unit, there.astype(float)
    found, pairs = [], []
    for k in range(1, lags + 1):
        both = seen[k:].T @ seen[:-k]
        found.append(filled[k:].T @ filled[:-k] / np.maximum(both, 1))
        pairs.append(both)
    auto, weight = np.array(found), np.array(pairs)
    statistic = float((weight * auto**2).sum())
    dof = max(int((weight > 0).sum()) - fitted, 1)
    return Whiteness(
        auto, float(2 / np.sqrt(max(weight[0].diagonal().min(), 1))), statistic, dof,
        float(scipy.special.chdtrc(dof, statistic)), variance,
        2 * np.sqrt(2 / np.maximum(count, 1)),
    )  # fmt: skip
