"""A ball around a covariance that no later one leaves, and what follows from it.

Source: our own; papers/leondes_novak/derivation/settled_ball.py for the covariance and
settled_estimate.py for the estimate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numeric import Vector
from ..numeric.rounded import Rounded
from .measure import Measure


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
    H : Measure
    a, rho, kappa, moved : float
        ``moved`` is the most that a row leaves of a difference of estimates.
    rounds : (n,) ndarray
        How far off variances of Sigma are, relative to them.
    variances : (n,) ndarray
        How far later variances are from these, for tau = 1.
    reach : (n,) ndarray
        How far estimates are apart at most, in their standard deviations, where
        predictions are by one unit of H.
    gain : (n,) ndarray
        What K lacks adds to an estimate at most, where the innovation is of one unit.
    ahead : (n, n) ndarray
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
    a: float
    rho: float
    kappa: float
    moved: float
    rounds: np.ndarray
    variances: np.ndarray
    reach: np.ndarray
    gain: np.ndarray
    ahead: np.ndarray

    def held(self, t: float = 0.0) -> Held | None:
        """What holds all that follows a difference of size t, if anything does."""
        if not max(self.rho, self.moved) < 1:
            return None
        t = max(t, 2 * self.a / (1 - self.rho))
        if not self.kappa**2 * t < 1:
            return None
        tau = t / (1 - self.kappa**2 * t)
        return Held(self, t, tau) if self.a + self.rho * tau <= t else None

    def fits(self, tolerance: float) -> bool:
        """Whether all that follows is within a tolerance; see `Held.within`."""
        held = self.held()
        return held is not None and held.within(tolerance)

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

    def apart(
        self, s: float, rounding: Vector | float = 0.0, lost: float = 0.0
    ) -> Vector:
        """How far estimates can be apart, in standard deviations.

        `s` is the largest innovation in units of M, `rounding` (n,) what rounding adds
        to an estimate in one row beside that in the gain, and `lost` the length of what
        a prediction lacks from the beginning.
        """
        ball = self.ball
        size = ball.gain * s + rounding
        added = ball.length(ball.ahead @ size) + lost
        stays = 1 - ball.moved * (1 + ball.kappa * self.push)
        if not stays > 0:
            return np.full(len(ball.unit), np.inf)
        D = (ball.moved * self.push * s + added) / stays
        apart = ball.reach * (D + self.push * (s + ball.kappa * D))
        return apart + size / np.sqrt(ball.Sigma.diagonal())

    def within(self, tolerance: float) -> bool:
        """Whether variances, and estimates at innovations of one unit, are so close."""
        largest = self.variances.max(initial=0.0)
        return bool(max(largest, self.apart(1.0).max(initial=0.0)) <= tolerance)
