"""Where the covariance of a filter may stop: how far any later row can be from it.

The step at which it stops is taken again on numbers that bound their own rounding, with
twice the digits if floats do not suffice.  So the distances are those of the exact
recursion, carried on from the row before; what K and Sigma lack of it is known.

Source: our own; papers/leondes_novak/derivation/settled_ball.py for the covariance and
settled_estimate.py for the estimate.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.factors import EPS, lengths
from ..numeric.linalg import UNIT_TOL, radius
from ..numeric.more_digits import Wide
from ..numeric.rounded import Rounded, joined
from ..papers.leondes_novak.derivation import gain_step, predict, settled_step
from .held import Ball
from .looks import STILL
from .measure import Measure
from .root_step import Spread
from .settings import Setting
from .state import State

Bounds = dict[str, Rounded]

FLOOR = 0.1  # of a variance, that a difference in any direction counts as
ROUNDS = 8  # of sums, with what accurate outputs see of them
NOISE = 16  # roundings of an entry, that a step surely changes where it has settled


def near(now: Setting, spread: Spread, tolerance: float) -> tuple[Near | None, bool]:
    """One step on from `spread`, if a ball may be found there.

    None where it is quickly told that there is no ball: where a covariance is singular,
    where one more step changes it by more than `tolerance`, or where errors do not die
    out.  Then the other result tells whether to look again.
    """
    new, after, _ = now.step(now.move, spread)
    unit, seen = np.sqrt(new["Omega"].diagonal()), np.sqrt(new["M"].diagonal())
    if after.half is not None or not ((unit > 0).all() and (seen > 0).all()):
        return None, True
    step = kernels.compiled(settled_step)(
        As=now.As, Qs=now.Qs, C=now.C, Gamma=now.Gamma, Kmv=new["Kmv"],
        Omega=new["Omega"], Sigma_next=new["Sigma_next"],
    )  # fmt: skip
    more = float(np.abs(step["delta"] / unit / unit[:, None]).max())
    if not more <= tolerance:
        return None, True
    F = step["F_0"]
    if not np.isfinite(F).all() or not radius(F) < 1 - UNIT_TOL:
        return None, bool(more > STILL)
    return Near(now, spread.Sigma, new, step, _power(unit), _power(seen)), True


def ball(at: Near, tolerance: float) -> tuple[Ball | None, bool]:
    """The ball around the covariance of a step, if it is small enough.

    There is none where one step does not make differences smaller, or where rounding,
    or the difference of one more step, is not small beside `tolerance`.  Then the other
    result tells whether to look again.
    """
    H = at.measure()
    if H is None:
        return None, True
    size = H.size(Rounded.of(at.delta))
    made = at.ball(H) if at.shrinks(H) else None
    if made is not None and made._replace(a=size).fits(tolerance):  # but for rounding
        for exact in at.told(made, tolerance):
            found = at.known(made, exact)
            if found is not None and found.fits(tolerance):
                return found, True
    noise = NOISE * EPS * np.sqrt(len(at.delta)) * np.linalg.norm(H.inverse, 2) ** 2
    return None, bool(size > noise)


def distance(state: State, ball: Ball, tolerance: float) -> float:
    """How far the covariance that follows `state` is at most from that of a ball.

    Infinite if it is too far.  It is found with floats, and with twice the digits where
    only rounding is too large.
    """
    assert state.setting is not None
    given = dict(As=state.setting.move.A, Q=state.setting.move.Q, Sigma=state.Sigma)
    step = kernels.compiled(predict, "Omega_next")
    rough = ball.distance(Rounded.of(step(**given)["Omega_next"]))
    if not ball.fits(tolerance, rough):
        return np.inf
    for digits in (Rounded, Wide):
        exact = kernels.bounded(predict, "Omega_next")(
            **{name: digits.of(X) for name, X in given.items()}
        )
        found = ball.distance(exact["Omega_next"])
        if ball.fits(tolerance, found):
            return found
    return np.inf


def _power(X: Vector) -> Vector:
    """The powers of two that are nearest: scaling by these rounds nothing."""
    return np.exp2(np.round(np.log2(X)))


class Near:
    """A step in units in which Omega and M have diagonals between 1/2 and 2.

    `F` and `G` move differences of covariances, and `delta` is what one more step adds.
    """

    def __init__(
        self, now: Setting, Sigma: Matrix, new: Matrices, step: Matrices, unit: Vector,
        seen: Vector,
    ) -> None:  # fmt: skip
        self.now, self.new, self.unit = now, new, unit
        self.down, out = 1 / unit[:, None], 1 / seen[:, None]
        self.given = dict(
            A=self.down * now.As * unit, Q=self.down * now.Qs / unit,
            C=out * now.C * unit, R=out * now.R / seen,
            Gamma=self.down * now.Gamma * seen, Sigma=self.down * Sigma / unit,
        )  # fmt: skip
        self.Omega, self.Sigma = (
            self.down * new[name] / unit for name in ("Omega", "Sigma_next")
        )
        self.K = self.down * new["K"] * seen
        self.F, self.G = (self.down * step[name] * unit for name in ("F_0", "G_0"))
        self.delta = self.down * step["delta"] / unit

    @cached_property
    def floats(self) -> Bounds:
        """The step again on floats that bound their rounding."""
        return self.again(Rounded)

    def shrinks(self, H: Measure) -> bool:
        """Whether a step makes differences smaller, but for rounding."""
        X = H.inverse @ np.concatenate([self.F @ H.root, self.G @ H.root], axis=1)
        return bool(np.linalg.eigvalsh(X @ X.T)[-1] < 1)

    def measure(self) -> Measure | None:
        """H: differences of the size of Omega, summed as far as they last."""
        F, G = self.F, self.G
        sums = Sums(F)
        first = self.Omega + FLOOR * np.eye(len(F))
        H = sums(first)
        for _ in range(ROUNDS if G.any() else 0):
            H = sums(first + G @ H @ G.T)
        try:
            return Measure(np.linalg.cholesky(H)) if np.isfinite(H).all() else None
        except np.linalg.LinAlgError:
            return None

    def told(self, ball: Ball, tolerance: float) -> Iterator[Bounds]:
        """The step again: on floats if their rounding may do, and in twice the digits.

        `ball` lacks nothing yet.
        """
        a = ball.H.size(self.floats["delta"].short())
        if ball._replace(a=a).fits(tolerance):
            yield self.floats
        yield self.again(Wide, "delta")

    def ball(self, H: Measure) -> Ball | None:
        """The ball but for what the step lacks and for kappa, which hangs on that."""
        ahead, _ = _measure(Rounded.of(self.Omega))
        if ahead is None:
            return None
        floats, root = self.floats, Rounded.of(H.root)
        F, G, left, stays = (floats[k].dot(root) for k in ("F_0", "G_0", "Y_0", "Y"))
        variance, pushed = self.Sigma.diagonal(), left - stays
        none = np.zeros(len(variance))
        return Ball(
            Omega=self.new["Omega"],
            Sigma=self.new["Sigma_next"],
            K=self.new["K"],
            M=self.new["M"],
            off=0.0,
            sure=1.0,
            unit=self.unit,
            H=H,
            ahead=ahead,
            a=0.0,
            rho=H.norm(joined(F, G)) ** 2,
            kappa=0.0,
            moved=H.norm(F - G),
            rounds=none,
            variances=(_rows(left) ** 2 + _rows(pushed) ** 2) / variance,
            reach=_rows(stays) / np.sqrt(variance),
            lacks=0.0,
            whole=ahead.norm(joined(F, G)) ** 2,
            furthest=ahead.norm(F - G),
            gain=none,
            moves=self.now.move.size,
        )

    def known(self, ball: Ball, exact: Bounds) -> Ball | None:
        """The same ball, with what the step lacks as it is known from `exact`."""
        M, sure = _measure(exact["M"].short())
        if M is None:
            return None
        A, C = (Rounded.of(self.given[name]) for name in ("A", "C"))
        Sigma = exact["Sigma_next"].beside(self.Sigma)
        lacks = exact["K"].beside(self.K).dot(Rounded.of(M.root))
        return ball._replace(
            off=ball.H.size(exact["Omega"].beside(self.Omega)),
            sure=sure,
            a=ball.H.size(exact["delta"].short()),
            kappa=M.norm(C.dot(Rounded.of(ball.H.root))) * sure,
            rounds=(np.abs(Sigma.value) + Sigma.off).diagonal() / self.Sigma.diagonal(),
            lacks=ball.ahead.size(A.dot(Sigma).dot(A.T)),
            gain=self.unit * _rows(lacks) * sure,
        )

    def again(self, digits: type[Rounded], *wanted: str) -> Bounds:
        """The step, and how differences move, on numbers that bound their rounding."""
        given = {name: digits.of(X) for name, X in self.given.items()}
        have = given | kernels.bounded(gain_step)(**given)
        have |= dict(As=given["A"], Qs=given["Q"])
        moved = kernels.bounded(settled_step, *wanted)
        return have | moved(**{name: have[name] for name in moved.given})


def _measure(X: Rounded) -> tuple[Measure | None, float]:
    """A measure by X, and the root of a factor by which X may be less than it."""
    try:
        H = Measure(np.linalg.cholesky(X.value))
    except np.linalg.LinAlgError:
        return None, np.inf
    off = H.size(X - Rounded.of(H.root).dot(Rounded.of(H.root.T)))
    return (H, 1 / np.sqrt(1 - off)) if off < 0.5 else (None, np.inf)


def _rows(X: Rounded) -> Vector:
    """The lengths of the rows at most."""
    return lengths(np.abs(X.value) + X.off)
