"""The cost of a fixed-order estimator over (Ae, Be), and the way down to a minimum.

For given (Ae, Be) the best (Ce, De) are a least-squares solution, so the cost is a
function of Ae and Be alone and its gradient is (4.8), (4.9).  Every estimator is
described in coordinates with Ae Ae' + Be Be' = I.  Then the directions D N, where the
rows of N complete those of [Ae Be] to an orthonormal basis, are as many as the filter
has degrees of freedom, and none of them is a mere change of coordinates.  In these
the Hessian is exact and small, and a trust region makes Newton's method safe.
"""

from typing import NamedTuple

import numpy as np

from .. import kernels
from ..errors import CertificateError
from ..linalg import lyapunov
from .projection_setting import run
from .stein import Schur

NEAR = 1e-9  # gradient, relative to the cost's scale, below which Newton goes alone
CLOSE = 1e-14  # the same for the cost that is left to win, which may be but rounding
CURVED = 1e-9  # relative curvature below zero that is not rounding
MOVES = 300  # of the trust region
ROUNDING = 1e-13  # of a cost, relative to its scale


class Point(NamedTuple):
    """An estimator with the best output for its Ae, Be, and all it takes to know."""

    have: dict  # matrices by the derivation's names
    cost: float  # above the Kalman filter's
    dynamics: Schur  # of Ae


def evaluate(target, Ae, Be):
    """The Point of (Ae, Be), or None when Ae is not stable."""
    F, G = Schur(Ae), target.dynamics
    if not F.radius < 1:
        return None
    have = target.matrices | dict(Ae=Ae, Be=Be)
    have["Q12"] = G.forward(F, run(kernels.estimator_moments("N12"), have)["N12"])
    have["Q2"] = _even(F.forward(F, run(kernels.estimator_moments("N2"), have)["N2"]))
    _take_output(have, target.feedthrough)
    have["P2"] = _even(F.backward(F, run(kernels.adjoint_moments("M2"), have)["M2"]))
    have["P12"] = G.backward(F, run(kernels.adjoint_moments("M12"), have)["M12"])
    have |= run(kernels.projection_gradient("gradAe", "gradBe"), have)
    cost = float(np.trace(run(kernels.projection_cost("J"), have)["J"]))
    return Point(have, cost, F)


def _even(X):
    return 0.5 * (X + X.T)


def _take_output(have, feedthrough):
    """Add the best Ce and De."""
    r, shape = len(have["Ae"]), (len(have["L"]), len(have["C"]))
    if feedthrough:
        have |= run(kernels.best_output("Czy", "CeDe"), have)
        have["Ce"], have["De"] = have["CeDe"][:, :r], have["CeDe"][:, r:]
    else:
        have |= run(kernels.best_output("Ce"), have)
        have["De"] = np.zeros(shape)


def second_derivatives(target, point, dAe, dBe):
    """Gradients' moves along k directions (k, r, r), (k, r, p), with best outputs."""
    F, G = point.dynamics, target.dynamics
    have = point.have | dict(dAe=dAe, dBe=dBe)
    move = kernels.projection_differential
    have["dQ12"] = G.forward(F, run(move("dN12"), have)["dN12"])
    have["dQ2"] = F.forward(F, run(move("dN2"), have)["dN2"])
    if target.feedthrough:
        both = run(kernels.best_output_differential("dCeDe"), have)["dCeDe"]
        have["dCe"], have["dDe"] = np.split(both, [len(F.upper)], axis=-1)
    else:
        have |= run(kernels.best_output_differential("dCe"), have)
        have["dDe"] = np.zeros((len(dAe), *have["De"].shape))
    have["dP2"] = F.backward(F, run(move("dM2"), have)["dM2"])
    have["dP12"] = G.backward(F, run(move("dM12"), have)["dM12"])
    moved = run(move("dgradAe", "dgradBe"), have)
    return moved["dgradAe"], moved["dgradBe"]


def normalised(Ae, Be):
    """The same estimator with Ae Ae' + Be Be' = I."""
    try:
        half = np.linalg.cholesky(lyapunov(Ae, Be @ Be.T))
    except np.linalg.LinAlgError:
        raise CertificateError("it uses fewer states than its order") from None
    return np.linalg.solve(half, Ae @ half), np.linalg.solve(half, Be)


class Frame:
    """Gradient and Hessian at a point, in the rp directions that matter."""

    def __init__(self, target, Ae, Be):
        self.target, self.point = target, evaluate(target, *normalised(Ae, Be))
        if self.point is None:
            raise CertificateError("it reaches the limit of stability")
        have = self.point.have
        self.r, p = have["Be"].shape
        pair = np.hstack([have["Ae"], have["Be"]])
        self.N = np.linalg.qr(pair.T, mode="complete")[0][:, self.r :].T
        self.gradient = self._along(have["gradAe"], have["gradBe"])
        units = np.eye(self.r * p).reshape(-1, self.r, p)
        hessian = self._along(
            *second_derivatives(target, self.point, *self.direction(units))
        )
        self.values, self.vectors = np.linalg.eigh(_even(hessian))
        self.slope = self.vectors.T @ self.gradient
        self.steepness = np.linalg.norm(self.gradient) / target.scale

    def _along(self, gradAe, gradBe):
        moved = np.concatenate([gradAe, gradBe], axis=-1) @ self.N.T
        return moved.reshape(*moved.shape[:-2], -1)

    def direction(self, units):
        """(dAe, dBe) of coefficients D, (..., r, p)."""
        return np.split(units @ self.N, [self.r], axis=-1)

    @property
    def is_minimum(self):
        """Whether no direction leads down, to second order, but for rounding."""
        most = np.abs(self.values).max()
        if self.values[0] < -CURVED * most:
            return False
        left = np.sum(self.slope**2 / np.maximum(self.values, 1e-14 * most)) / 2
        return self.steepness < NEAR or left < CLOSE * self.target.scale

    def step(self, reach):
        """The step of length <= reach that is best for the quadratic model."""
        least = max(0.0, -self.values[0]) + 1e-14 * np.abs(self.values).max()
        low = least if self.values[0] <= least else 0.0
        length = np.linalg.norm(self.slope / (self.values + low))
        if length <= reach:  # a full step; to the edge where the model curves down
            found = -self.slope / (self.values + low)
            if self.values[0] < -CURVED * np.abs(self.values).max():
                found[0] += np.copysign(np.sqrt(reach**2 - length**2), found[0])
            return found
        high = low + np.linalg.norm(self.slope) / reach
        for _ in range(60):
            middle = 0.5 * (low + high)
            longer = np.linalg.norm(self.slope / (self.values + middle)) > reach
            low, high = (middle, high) if longer else (low, middle)
        return -self.slope / (self.values + high)

    def model(self, step):
        """Fall of the cost that the quadratic model promises."""
        return -(self.slope @ step + 0.5 * step @ (self.values * step))

    def moved(self, step):
        """(Ae, Be) after a step."""
        units = (self.vectors @ step).reshape(self.r, -1)
        dAe, dBe = self.direction(units)
        return self.point.have["Ae"] + dAe, self.point.have["Be"] + dBe


def descend(target, Ae, Be):
    """The Frame at a local minimum reached from (Ae, Be), polished to rounding.

    Raises CertificateError saying why there is none.
    """
    frame, reach = Frame(target, Ae, Be), 0.3
    for _ in range(MOVES):
        if frame.is_minimum:
            return _polished(frame)
        frame, reach = _move(frame, reach)
    raise CertificateError(f"no minimum after {MOVES} moves")


def _move(frame, reach):
    """The next frame of the trust region, and its new reach."""
    target, start = frame.target, frame.point.cost
    while reach > 1e-12:
        step = frame.step(reach)
        length, promised = np.linalg.norm(step), frame.model(step)
        pair = frame.moved(step)
        there = evaluate(target, *pair)
        fall = -np.inf if there is None else start - there.cost
        slack = ROUNDING * target.scale
        kept = (fall + slack) / (promised + slack)
        if kept > 0.75 and length > 0.9 * reach:
            reach = min(2 * reach, 2.0)
        elif kept < 0.25:
            reach = 0.25 * min(reach, length)
        if kept > 1e-4:
            return Frame(target, *pair), reach
    raise CertificateError("the cost falls no further, and this is not a minimum")


def _polished(frame):
    """Newton's method alone, as long as it halves the gradient."""
    for _ in range(10):
        floor = 1e-14 * np.abs(frame.values).max()
        step = -frame.slope / np.maximum(frame.values, floor)
        try:
            better = Frame(frame.target, *frame.moved(step))
        except CertificateError:
            break
        if not better.steepness < 0.5 * frame.steepness:
            break
        frame = better
    return frame
