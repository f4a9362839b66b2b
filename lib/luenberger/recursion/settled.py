"""Where the covariance of a filter may stop: how far any later row can be from it.

Source: our own; papers/leondes_novak/derivation/settled_ball.py for the covariance and
settled_estimate.py for the estimate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.factors import EPS
from ..numeric.linalg import UNIT_TOL, radius
from ..papers.leondes_novak.derivation import settled_step
from .root_step import Spread
from .settings import Setting

FLOOR = 0.1  # of a variance, that a difference in any direction counts as
ROUNDS = 8  # of sums, with what accurate outputs see of them


class Ball(NamedTuple):
    """A covariance at which the recursion may stop, and the ball that holds the rest.

    Lengths are in units of the states, `unit`; the letters are those of
    settled_ball.py and settled_estimate.py, with H = root root'.

    Attributes
    ----------
    Omega, Sigma, K, M : ndarray
        Of the first row of the constant gain: covariances of prediction, estimate
        and innovation, and the gain.
    unit : (n,) ndarray
    inverse : (n, n) ndarray
        That of `root`.
    t, tau, kappa, moved : float
        ``moved`` is the most that a row leaves of a difference of estimates.
    variances : (n,) ndarray
        How far later variances can be from those of Sigma, relative to them.
    reach : (n,) ndarray
        How far estimates are apart at most, in their standard deviations, where
        predictions are by one unit of H.
    gain : (n,) ndarray
        What rounding in the gain adds to an estimate at most, where the innovation is
        of one unit.
    ahead : (n, n) ndarray
        Sizes of what moves an estimate to the next prediction.
    """

    Omega: np.ndarray
    Sigma: np.ndarray
    K: np.ndarray
    M: np.ndarray
    unit: np.ndarray
    inverse: np.ndarray
    t: float
    tau: float
    kappa: float
    moved: float
    variances: np.ndarray
    reach: np.ndarray
    gain: np.ndarray
    ahead: np.ndarray

    @property
    def push(self) -> float:
        """What an innovation of one unit does through a gain that differs."""
        return self.kappa * self.tau

    def apart(
        self, s: float, rounding: Vector | float = 0.0, lost: float = 0.0
    ) -> Vector:
        """How far estimates can be apart, in standard deviations.

        `s` is the largest innovation in units of M, `rounding` (n,) what rounding adds
        to an estimate in one row beside that in the gain, and `lost` the length of what
        a prediction lacks from the beginning.
        """
        size = self.gain * s + rounding
        added = self.length(self.ahead @ size) + lost
        stays = 1 - self.moved * (1 + self.kappa * self.push)
        if not stays > 0:
            return np.full(len(self.unit), np.inf)
        D = (self.moved * self.push * s + added) / stays
        apart = self.reach * (D + self.push * (s + self.kappa * D))
        return apart + size / np.sqrt(self.Sigma.diagonal())

    def length(self, size: Vector) -> float:
        """The length at most of a vector whose entries have at most these sizes."""
        return float(np.linalg.norm(np.abs(self.inverse) @ (size / self.unit)))

    def holds(self, Omega: Matrix) -> bool:
        """Whether the covariance of a prediction is in the ball."""
        off = (Omega - self.Omega) / self.unit / self.unit[:, None]
        return size_of(off, self.inverse) <= self.t

    def within(self, tolerance: float) -> bool:
        """Whether variances, and estimates at innovations of one unit, are so close."""
        largest = self.variances.max(initial=0.0)
        return bool(max(largest, self.apart(1.0).max(initial=0.0)) <= tolerance)


def size_of(X: Matrix, inverse: Matrix) -> float:
    """The least t with -t H <= X <= t H."""
    values = np.linalg.eigvalsh(inverse @ X @ inverse.T)
    return float(np.abs(values).max(initial=0.0))


def ball(now: Setting, spread: Spread, tolerance: float) -> tuple[Ball | None, bool]:
    """The ball around the covariance one step on from `spread`, if it is small enough.

    There is none where a covariance is singular, where one step does not make
    differences smaller, or where rounding, or the difference of one more step, is not
    small beside `tolerance`.  Then the other result tells whether to look again.
    """
    new, after, _ = now.step(now.move, spread)
    unit, seen = np.sqrt(new["Omega"].diagonal()), np.sqrt(new["M"].diagonal())
    if after.half is not None or not ((unit > 0).all() and (seen > 0).all()):
        return None, True
    found = kernels.compiled(settled_step)(
        As=now.As, Qs=now.Qs, C=now.C, Gamma=now.Gamma, Kmv=new["Kmv"],
        Omega=new["Omega"], Sigma_next=new["Sigma_next"],
    )  # fmt: skip
    if np.abs(found["delta"] / unit / unit[:, None]).max() > tolerance:
        return None, True
    here = _Scaled(now, new, found, unit, seen)
    H = here.summed()
    if H is None:
        return None, True
    try:
        root, seen_root = np.linalg.cholesky(H), np.linalg.cholesky(here.M)
    except np.linalg.LinAlgError:
        return None, True
    inverse = solve_triangular(root, np.eye(len(root)), lower=True)
    delta, rounding = size_of(here.delta, inverse), here.rounding(inverse)
    made = _ball(here, new, root, inverse, seen_root, delta + 2 * rounding)
    if made is not None and made.within(tolerance):
        return made, True
    return None, delta > rounding  # else it has settled as far as it ever will


def _ball(
    here: _Scaled, new: Matrices, root: Matrix, inverse: Matrix, seen_root: Matrix,
    a: float,
) -> Ball | None:  # fmt: skip
    """The ball, from roots of H and M and from what one step adds."""
    slack = 8 * len(root) * EPS * np.linalg.norm(inverse) * np.linalg.norm(root)
    both = inverse @ np.concatenate([here.F @ root, here.G @ root], axis=1)
    rho = _norm(both) ** 2 + slack * np.linalg.norm(both)
    ahead = inverse @ (here.F - here.G) @ root
    moved = _norm(ahead) + slack * np.linalg.norm(ahead)
    kappa = (1 + slack) * _norm(solve_triangular(seen_root, here.C @ root, lower=True))
    if not max(rho, moved) < 1:
        return None
    t = 2 * a / (1 - rho)
    if not kappa**2 * t < 1:
        return None
    tau = t / (1 - kappa**2 * t)
    if not rho * (tau - t) <= a:
        return None
    left, pushed = here.Y @ root, here.GCY @ root
    variance = here.Sigma.diagonal()
    size = tau * ((left**2).sum(axis=1) + (pushed**2).sum(axis=1))
    size += 2 * here.rounds.diagonal()
    reach = np.sqrt(((left - pushed) ** 2).sum(axis=1) / variance)
    return Ball(
        new["Omega"], new["Sigma_next"], new["K"], new["M"], here.unit, inverse,
        t, tau, kappa, moved, size / variance, reach,
        here.unit * here.rounding_of_gain(), here.sizes,
    )  # fmt: skip


def _norm(X: Matrix) -> float:
    return float(np.linalg.norm(X, 2)) if X.size else 0.0


class _Scaled:
    """The matrices of a step in units in which Omega and M have unit diagonals."""

    def __init__(
        self, now: Setting, new: Matrices, found: Matrices, unit: Vector, seen: Vector
    ) -> None:
        self.unit, down, out = unit, 1 / unit[:, None], 1 / seen[:, None]
        self.F, self.G, self.Y = (
            down * found[name] * unit for name in ("F_0", "G_0", "Y_0")
        )
        self.delta, self.Omega, self.Sigma = (
            down * X / unit for X in (found["delta"], new["Omega"], new["Sigma_next"])
        )
        self.M, self.R = out * new["M"] / seen, out * now.R / seen
        self.C = out * now.C * unit
        self.K, self.Kmv, self.Gamma = (
            down * X * seen for X in (new["K"], new["Kmv"], now.Gamma)
        )
        self.A, self.ahead = down * now.As * unit, down * now.move.size * unit
        self.Qs, self.sizes = down * now.Qs / unit, now.move.size
        self.GCY = self.Gamma @ self.C @ self.Y
        self.rounds = self.rounding_of_estimate()

    def summed(self) -> Matrix | None:
        """H: differences of the size of Omega, summed as far as they last."""
        if not np.isfinite(self.F).all() or not radius(self.F) < 1 - UNIT_TOL:
            return None
        sums = Sums(self.F)
        first = self.Omega + FLOOR * np.eye(len(self.F))
        H = sums(first)
        for _ in range(ROUNDS if self.G.any() else 0):
            H = sums(first + self.G @ H @ self.G.T)
        return H if np.isfinite(H).all() else None

    def rounding_of_estimate(self) -> Matrix:
        """Entry by entry, what rounding does to Sigma at most.

        A product of sums is as far off as the sizes of what is added up allow.  What is
        off before the gain is applied passes it, and becomes smaller.
        """
        n, p = self.K.shape
        K, C, Y = np.abs(self.K), np.abs(self.C), np.abs(np.eye(n) - self.K @ self.C)
        N, Omega = self.Omega @ self.C.T, np.abs(self.Omega)
        Z = np.abs(self.Omega - self.K @ N.T)
        before = 2 * Omega + (p + 2) * K @ np.abs(N).T + n * (K @ C + Y) @ Omega
        after = (n + 2) * Z @ C.T + (p + 2) * K @ np.abs(self.R)
        off = EPS * (before @ Y.T + after @ K.T + (p + 2) * Z)
        return np.maximum(off, off.T)

    def rounding_of_gain(self) -> Vector:
        """What rounding in the gain does to an estimate, for an innovation of one unit.

        The gain solves `Kmv M = N`.  Sums make both sides inexact, and so does an
        elimination: by no more than sizes of M, whose diagonal is one.  What is off
        meets `M^-1 nu`, whose entry j is at most the root of that of `M^-1`.
        """
        n, p = self.K.shape
        if not p:
            return np.zeros(n)
        Kmv, C, Gamma = np.abs(self.Kmv), np.abs(self.C), np.abs(self.Gamma)
        N = (n + 2) * np.abs(self.Omega) @ C.T
        M = C @ N + (3 * p + 4) * np.ones((p, p))
        off = (N + Kmv @ M) @ np.sqrt(np.linalg.inv(self.M).diagonal())
        sums = (n + p + 4) * (Kmv + Gamma @ (np.eye(p) + C @ Kmv)).sum(axis=1)
        turn = np.abs(np.eye(n) - self.Gamma @ self.C)
        return np.asarray(EPS * (turn @ off + sums))

    def rounding(self, inverse: Matrix) -> float:
        """The size, in units of H, of what rounding does to Omega one step on."""
        (n, p), size = self.K.shape, np.abs(inverse)
        off = self.rounds + 2 * n * EPS * np.abs(self.Sigma)
        off = self.ahead @ off @ self.ahead.T + 2 * EPS * np.abs(self.Qs)
        sums = float(np.linalg.norm(size @ off @ size.T))
        if not p:
            return sums
        # what is off in the gain of minimum variance counts where another one runs
        gain = EPS * p**2 * np.linalg.norm(self.Kmv) * np.linalg.cond(self.M)
        turn = gain * _norm(inverse @ self.A @ (np.eye(n) - self.Gamma @ self.C))
        cost = _norm(inverse @ self.A @ self.Gamma @ self.R)
        return float(sums + 2 * cost * turn + p * turn**2)
