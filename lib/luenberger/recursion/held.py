"""A ball around a covariance that no later one leaves, and what follows from it.

Source: our own; papers/leondes_novak/derivation/settled_ball.py for the covariance and
settled_estimate.py for the estimate, settled_ratio.py for the rows behind.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numeric import Vector
from ..numeric.rounded import Rounded
from .measure import Measure

PATIENCE = 4096  # rows at most, in which a difference may become small


class Behind(NamedTuple):
    """How far a filter is from the full recursion, behind rows with one gain.

    The letters are those of settled_ratio.py: each covariance is at most ``1 + g``
    times the other, and predictions are `drift` apart in units of Omega.
    """

    g: float
    drift: float

    @property
    def bound(self) -> float:
        """How far variances and estimates can be apart."""
        return max(self.g, self.drift)

    def after(self, rows: int, s: float) -> Behind:
        """The same so many rows of the recursion later, with innovations of size s."""
        if not self.g < 0.5:
            return Behind(np.inf, np.inf)
        tau = self.g / (1 - self.g)
        grown = float(np.exp(min(rows * tau, 700.0)))
        return Behind(self.g, (self.drift + rows * tau * s) * grown)


class Ball(NamedTuple):
    """A covariance at which the recursion may stop, and what one step does around it.

    The letters are those of settled_ball.py and settled_estimate.py.  `H` measures in
    units of the states, `unit`.

    Attributes
    ----------
    Omega, Sigma, K, M : ndarray
        Of the first row of the constant gain: covariances of prediction, estimate
        and innovation, and the gain.
    off : float
        How far, in units of H, Omega is from that of the exact recursion, carried on
        from the row before.  All that follows is of this one.
    sure : float
        How far, as a factor, M may be from that of the exact recursion, as a root.
    unit : (n,) ndarray
    H, ahead : Measure
        ``ahead`` measures by Omega, what is carried to the next prediction.
    a, rho, kappa, moved : float
        ``moved`` is the most that a row leaves of a difference of estimates.
    rounds : (n,) ndarray
        How far off variances of Sigma are, relative to them.
    variances : (n,) ndarray
        How far later variances are from these, for tau = 1.
    reach : (n,) ndarray
        How far estimates are apart at most, in their standard deviations, where
        predictions are by one unit of H.
    lacks, whole, furthest : float
        The same of the predictions that follow, in any direction, by Omega.
    gain : (n,) ndarray
        What K lacks adds to an estimate at most, where the innovation is of one unit.
    moves : (n, n) ndarray
        Sizes of what moves an estimate to the next prediction.
    """

    Omega: np.ndarray
    Sigma: np.ndarray
    K: np.ndarray
    M: np.ndarray
    off: float
    sure: float
    unit: np.ndarray
    H: Measure
    ahead: Measure
    a: float
    rho: float
    kappa: float
    moved: float
    rounds: np.ndarray
    variances: np.ndarray
    reach: np.ndarray
    lacks: float
    whole: float
    furthest: float
    gain: np.ndarray
    moves: np.ndarray

    def held(self, t: float = 0.0) -> Held | None:
        """What holds all that follows a difference of size t, if anything does."""
        if not max(self.rho, self.moved) < 1:
            return None
        t = max(t, 2 * self.a / (1 - self.rho))
        if not self.kappa**2 * t < 1:
            return None
        tau = t / (1 - self.kappa**2 * t)
        return Held(self, t, tau) if self.a + self.rho * tau <= t else None

    def fits(self, tolerance: float, t: float = 0.0) -> bool:
        """Whether what follows a difference of size t is as `Held.within` says."""
        held = self.held(t)
        return held is not None and held.within(tolerance)

    def rows_until(self, t: float, tolerance: float) -> tuple[int, float] | None:
        """How many rows make a difference of size t fit a tolerance, and what is left.

        None if it may leave the ball, or if there are too many.
        """
        for row in range(PATIENCE):
            held = self.held(t)
            if held is None:
                return None
            if row and held.within(tolerance):
                return row, t
            t = self.a + self.rho * held.tau
        return None

    def length(self, size: Vector) -> float:
        """The length at most of a vector whose entries have at most these sizes."""
        return self.H.length(size / self.unit)

    def distance(self, Omega: Rounded) -> float:
        """How far at most the covariance of a prediction is from the exact one here."""
        left, scale = Omega - self.Omega, self.unit * self.unit[:, None]
        return self.H.size(Rounded(left.value / scale, left.off / scale)) + self.off


class Held(NamedTuple):
    """The ball of size `t` that no later covariance leaves."""

    ball: Ball
    t: float
    tau: float

    @property
    def push(self) -> float:
        """What an innovation of one unit does through a gain that differs."""
        return self.ball.kappa * self.tau

    @property
    def variances(self) -> Vector:
        """How far later variances can be from those of Sigma, relative to them."""
        return self.ball.rounds + self.tau * self.ball.variances

    @property
    def keeps(self) -> float:
        """The part that a row leaves of a difference of estimates."""
        return self.ball.moved * (1 + self.ball.kappa * self.push)

    def drift(
        self, s: float, rounding: Vector | float = 0.0, lost: float = 0.0
    ) -> float:
        """How far predictions can be apart in the long run, in units of H.

        `s` is the largest innovation in units of M, `rounding` (n,) what rounding adds
        to an estimate in one row beside that in the gain, and `lost` the length of what
        a prediction lacks from the beginning.
        """
        ball = self.ball
        if not self.keeps < 1:
            return np.inf
        added = ball.length(ball.moves @ (ball.gain * s + rounding)) + lost
        return (ball.moved * self.push * s + added) / (1 - self.keeps)

    def apart(self, s: float, D: float, rounding: Vector | float = 0.0) -> Vector:
        """How far estimates can be apart, in standard deviations.

        Predictions are apart by no more than D units of H.
        """
        ball = self.ball
        found = ball.reach * (D + self.push * (s + ball.kappa * D))
        return found + (ball.gain * s + rounding) / np.sqrt(ball.Sigma.diagonal())

    @property
    def reach(self) -> float:
        """The most that an estimate has of predictions one unit of H apart."""
        ball = self.ball
        return float(ball.reach.max(initial=0.0)) * (1 + ball.kappa * self.push)

    def within(self, tolerance: float) -> bool:
        """Whether variances, and estimates at innovations of one unit, are so close."""
        largest = self.variances.max(initial=0.0)
        apart = self.apart(1.0, self.drift(1.0)).max(initial=0.0)
        return bool(max(largest, apart) <= tolerance)

    def ratio(self, rows: int) -> float:
        """By how much predictions behind so many rows differ, as a ratio."""
        ball = self.ball
        part = ball.rho * self.tau / self.t
        t = ball.a / (1 - part) + part ** max(rows - 1, 0) * self.t
        differs = ball.lacks + ball.whole * t / (1 - ball.kappa**2 * t)
        return differs / (1 - differs) if differs < 0.5 else np.inf

    def driven(self, s: float, D: float, rounding: Vector) -> float:
        """How far predictions behind are apart through the gain and rounding.

        The arguments are those of `apart`.
        """
        ball = self.ball
        found = ball.furthest * (D + self.push * (s + ball.kappa * D))
        size = ball.moves @ (ball.gain * s + rounding)
        return found + ball.ahead.length(size / ball.unit)

    def handed_on(self, D: float, rows: int) -> float:
        """What so many rows leave of predictions that were D units of H apart."""
        ball = self.ball
        left = self.keeps ** max(rows - 1, 0) * (1 + ball.kappa * self.push)
        return ball.furthest * left * D
