"""Innovations, and whether they are white and as large as they should be."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy  # its parts load when first used

from ..numeric import Matrix, Vector
from ..numeric.validation import whole

LAGS = 20
PART = 5  # lags take at most this part of a record
LEVEL = 0.05  # what is less probable is not believed
LEAST = 20  # rows, from which the probabilities hold
DRAWN = 500  # rows of the longest records that are drawn
WORK = 2e7  # numbers that are drawn, times the outputs
DRAWS = (200, 40_000)  # records, at least and at most
AT_ONCE = 1_000_000  # numbers of drawn records in memory
SEED = 20  # of these records: the same record always has the same p_value


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
        The sum of squares of all entries, each divided by its variance.
    dof : int
        What it is on average: the number of entries, less that of what was fitted.
    p_value : float
        How probable so large a sum is.
    variance, variance_error : (p,) ndarray
        Mean square of each output's innovations, and two standard errors of it.
    fitted : int
        Numbers fitted to the record, by which `dof` is less.
    """

    autocorrelation: np.ndarray
    bound: float
    statistic: float
    dof: int
    p_value: float
    variance: np.ndarray
    variance_error: np.ndarray
    fitted: int = 0

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
        Innovations in units of their covariance.  Their mean is known, zero.
    fitted : int
        Numbers fitted to this record beyond the covariance of the innovation.
    lags : int, optional
        Less than N; default 20, or a fifth of the rows.

    Warns
    -----
    UserWarning
        If there are fewer than 20 rows with a reading: the probabilities do not hold.

    Notes
    -----
    The variance of each autocorrelation of white noise is exact, also with gaps: of n
    readings of which m pairs are a lag apart it is m / (n (n + 2)), and
    m / (n_1 n_2) of two outputs.  Of a long record the sum then has a chi-square
    distribution.  Of a short one its large values are more frequent, because its
    terms are not independent.  How it is distributed depends on nothing but the
    number of rows, the gaps and the lags.  So its variance and skewness are
    those of white noise that is drawn with the record's gaps, always the same one,
    and `p_value` is of the gamma distribution with these three moments.  Above 500
    rows the excess over chi-square is that of 500 rows, reduced in proportion.

    Of white noise of 20 to 2000 rows, of 1 to 3 outputs, with and without gaps,
    p < 0.05 comes in 4.2 to 5.5 %, p < 0.01 in 0.8 to 1.2 % and p < 0.001 in 0.05 to
    0.25 %.  This is of given Q and R; if they were fitted, `dof` is less by
    `fitted`, which is right of long records.

    References
    ----------
    Ljung and Box (1978), "On a measure of lack of fit in time series models", has the
    exact variance; Hosking (1980), "The multivariate portmanteau statistic", with
    sample correlations; Mehra (1970) tests filters so.
    """
    e = np.asarray(normalised, dtype=float)
    there = ~np.isnan(e)
    rows = len(e)
    if lags is None:
        lags = max(min(LAGS, rows // PART), 1)
    elif not whole("lags", lags, 1) < rows:
        raise ValueError(f"lags must be less than the {rows} rows, got {lags}")
    if (read := int(there.any(axis=1).sum())) < LEAST:
        warnings.warn(
            f"whiteness of {read} rows with a reading: the probability is right from "
            f"{LEAST} on",
            stacklevel=2,
        )
    filled = np.where(there, e, 0.0)
    count = there.sum(axis=0)
    variance = (filled**2).sum(axis=0) / np.maximum(count, 1)
    unit = np.sqrt(np.where(variance > 0, variance, 1.0))
    pairs = _lagged(there.astype(float), lags)
    auto = _lagged(filled / unit, lags) / np.maximum(pairs, 1)
    statistic = float((auto**2 * _precision(count, pairs)).sum())
    entries = int((pairs > 0).sum())
    dof = max(entries - fitted, 1)
    spread, lean = _shape(there, lags, pairs)
    return Whiteness(
        auto, float(2 / np.sqrt(max(pairs[0].diagonal().min(), 1))), statistic, dof,
        _probability(statistic, dof, spread, lean), variance,
        2 * np.sqrt(2 / np.maximum(count, 1)), fitted,
    )  # fmt: skip


def _lagged(rows: np.ndarray, lags: int) -> np.ndarray:
    """Sums of products: entry [..., k - 1, i, j] of output i with j, k rows before."""
    after = range(1, lags + 1)
    return np.stack([rows[..., k:, :].mT @ rows[..., :-k, :] for k in after], axis=-3)


def _precision(count: Vector, pairs: np.ndarray) -> np.ndarray:
    """One over the variances of the autocorrelations of normal white noise."""
    return pairs * (1 + np.diag(2 / np.maximum(count, 1)))


def _shape(there: Matrix, lags: int, pairs: np.ndarray) -> tuple[float, float]:
    """Variance and skewness of the sum, beside those of chi-square."""
    rows = len(there)
    if rows <= DRAWN:
        return _drawn(there.tobytes(), there.shape, lags)
    short = np.ones((DRAWN, there.shape[1]), dtype=bool)
    found = np.array(_drawn(short.tobytes(), short.shape, min(lags, DRAWN - 1)))
    share = DRAWN / max(pairs[pairs > 0].mean(), DRAWN)
    spread, lean = 1 + share * (found - 1)
    return float(spread), float(lean)


@lru_cache(maxsize=64)
def _drawn(seen: bytes, shape: tuple[int, int], lags: int) -> tuple[float, float]:
    """`_shape` of white noise that is drawn with given gaps."""
    there = np.frombuffer(seen, dtype=bool).reshape(shape)
    count, pairs = there.sum(axis=0), _lagged(there.astype(float), lags)
    weight = _precision(count, pairs) / np.maximum(pairs, 1) ** 2
    draws = int(np.clip(WORK / max(there.size * shape[1], 1), *DRAWS))
    rng, sums = np.random.default_rng(SEED), list[Vector]()
    step = max(AT_ONCE // max(there.size, 1), 1)
    for k in range(0, draws, step):
        e = rng.normal(size=(min(step, draws - k), *shape)) * there
        size = np.sqrt((e**2).sum(axis=1, keepdims=True) / np.maximum(count, 1))
        e /= np.where(size > 0, size, 1.0)
        sums.append((_lagged(e, lags) ** 2 * weight).sum(axis=(1, 2, 3)))
    entries = max(int((pairs > 0).sum()), 1)
    away = np.concatenate(sums) - entries
    spread = (away**2).mean()
    lean = (away**3).mean() / spread**1.5 if spread > 0 else 0.0
    return float(spread / (2 * entries)), float(lean / np.sqrt(8 / entries))


def _probability(statistic: float, dof: int, spread: float, lean: float) -> float:
    """Of a larger sum: by the gamma distribution with its three moments.

    With `spread` and `lean` of one it is chi-square with `dof`.
    """
    shape = dof / (2 * max(lean, 1e-3) ** 2)
    away = (statistic - dof) / np.sqrt(2 * dof * max(spread, 1e-3))
    at = max(shape + away * np.sqrt(shape), 0.0)
    return float(scipy.special.gammaincc(shape, at))
