"""The cost of a fixed-order estimator over (Ae, Be), and the way down to a minimum.

For given (Ae, Be) the best (Ce, De) are a least-squares solution, so the cost is a
function of Ae and Be alone and its gradient is (4.8), (4.9).  Every estimator is
described in coordinates with Ae Ae' + Be Be' = I.  Then the directions D N, where the
rows of N complete those of [Ae Be] to an orthonormal basis, are as many as the filter
has degrees of freedom, and none of them is a mere change of coordinates.  In these
the Hessian is exact and small, and a trust region makes Newton's method safe.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...errors import CertificateError
from ...kernels import run
from ...numeric import Matrix, Vector
from ...numeric.linalg import lyapunov, radius, symmetrise
from ...stage_list import StageList
from . import derivation as stages
from .stein import Schur
from .target import Target

Pair = tuple[Matrix, Matrix]  # Ae, Be, or a change of coordinates and its inverse
NEAR = 1e-9  # gradient, relative to the cost's scale, below which Newton goes alone
CLOSE = 1e-14  # the same for the cost that is left to win, which may be but rounding
CURVED = 1e-9  # relative curvature below zero that is not rounding
FLAT = 1e-7  # least curvature, beside the largest, that isolates a minimum
MOVES = 300  # of the trust region
ROUNDING = 1e-13  # of a cost, relative to its scale


class Point(NamedTuple):
    """An estimator with the best output for its Ae, Be, and all it takes to know."""

    have: dict  # matrices by the derivation's names
    cost: float  # above the Kalman filter's
    dynamics: Schur  # of Ae


def evaluate(target: Target, Ae: Matrix, Be: Matrix) -> Point:
    """The Point of (Ae, Be); Ae must be stable."""
    F, G = Schur(Ae), target.dynamics
    have = target.matrices | dict(Ae=Ae, Be=Be)

    def drive(moments: StageList, name: str) -> Matrix:
        return run(moments, have, name)[name]

    have["Q12"] = G.forward(F, drive(stages.estimator_moments, "N12"))
    have["Q2"] = symmetrise(F.forward(F, drive(stages.estimator_moments, "N2")))
    _take_output(have, target.feedthrough)
    have["P2"] = symmetrise(F.backward(F, drive(stages.adjoint_moments, "M2")))
    have["P12"] = G.backward(F, drive(stages.adjoint_moments, "M12"))
    have |= run(stages.projection_gradient, have, "gradAe", "gradBe")
    cost = float(np.trace(run(stages.projection_cost, have, "J")["J"]))
    return Point(have, cost, F)


def _take_output(have: dict[str, Matrix], feedthrough: bool) -> None:
    """Add the best Ce and De."""
    r, shape = len(have["Ae"]), (len(have["L"]), len(have["C"]))
    if feedthrough:
        have |= run(stages.best_output, have, "Czy", "CeDe")
        have["Ce"], have["De"] = have["CeDe"][:, :r], have["CeDe"][:, r:]
    else:
        have |= run(stages.best_output, have, "Ce")
        have["De"] = np.zeros(shape)


def second_derivatives(
    target: Target, point: Point, dAe: Matrix, dBe: Matrix
) -> tuple[Matrix, ...]:
    """Gradients' moves along k directions (k, r, r), (k, r, p), with best outputs."""
    F, G = point.dynamics, target.dynamics
    have = point.have | dict(dAe=dAe, dBe=dBe)

    def moved(
        *names: str, by: StageList = stages.projection_differential
    ) -> Iterable[Matrix]:
        return run(by, have, *names, stacks=True).values()

    have["dQ12"] = G.forward(F, *moved("dN12"))
    have["dQ2"] = F.forward(F, *moved("dN2"))
    if target.feedthrough:
        (both,) = moved("dCeDe", by=stages.best_output_differential)
        have["dCe"], have["dDe"] = np.split(both, [len(F.upper)], axis=-1)
    else:
        (have["dCe"],) = moved("dCe", by=stages.best_output_differential)
        have["dDe"] = np.zeros((len(dAe), *have["De"].shape))
    have["dP2"] = F.backward(F, *moved("dM2"))
    have["dP12"] = G.backward(F, *moved("dM12"))
    return tuple(moved("dgradAe", "dgradBe"))


def normalised(Ae: Matrix, Be: Matrix) -> Pair:
    """The same estimator with Ae Ae' + Be Be' = I."""
    if not radius(Ae) < 1:
        raise CertificateError("it reaches the limit of stability")
    try:
        half = np.linalg.cholesky(lyapunov(Ae, Be @ Be.T))
    except np.linalg.LinAlgError:
        raise CertificateError("it uses fewer states than its order") from None
    return np.linalg.solve(half, Ae @ half), np.linalg.solve(half, Be)


def balancing(Q2: Matrix, P2: Matrix) -> Pair:
    """S and its inverse, for which S Q2 S' and S^-T P2 S^-1 are equal and diagonal."""
    try:
        half, seen = np.linalg.cholesky(Q2), np.linalg.cholesky(P2)
    except np.linalg.LinAlgError:
        raise CertificateError("it uses fewer states than its order") from None
    left, values, right = np.linalg.svd(seen.T @ half)
    root = np.sqrt(values)
    return (seen @ left / root).T, half @ right.T / root


class Frame:
    """Gradient and Hessian at a point, in the rp directions that matter.

    With `balanced`, costs and moments are those of balanced coordinates, where a state
    that hardly matters loses fewer digits.
    """

    def __init__(
        self, target: Target, Ae: Matrix, Be: Matrix, balanced: bool = False
    ) -> None:
        self.target, self.pair = target, normalised(Ae, Be)
        self.r, p = Be.shape
        self.to = self.back = np.eye(self.r)
        self.point = evaluate(target, *self.pair)
        if balanced:
            have = self.point.have
            self.to, self.back = balancing(have["Q2"], have["P2"])
            self.point = evaluate(target, *self._there(*self.pair))
        basis = np.linalg.qr(np.hstack(self.pair).T, mode="complete")[0]
        self.N = basis[:, self.r :].T
        have = self.point.have
        self.gradient = self._along(have["gradAe"], have["gradBe"])
        units = np.eye(self.r * p).reshape(-1, self.r, p)
        moves = self._there(*self._direction(units))
        hessian = self._along(*second_derivatives(target, self.point, *moves))
        self.values, self.vectors = np.linalg.eigh(symmetrise(hessian))
        self.slope = self.vectors.T @ self.gradient

    def _there(self, Ae: Matrix, Be: Matrix) -> Pair:
        """Ae, Be of the normalised coordinates in those of the point."""
        return self.to @ Ae @ self.back, self.to @ Be

    def _direction(self, units: Matrix) -> list[Matrix]:
        """(dAe, dBe) of coefficients D, (..., r, p)."""
        return np.split(units @ self.N, [self.r], axis=-1)

    def _along(self, gradAe: Matrix, gradBe: Matrix) -> Matrix:
        both = [gradAe @ self.back.T, gradBe]
        moved = self.to.T @ np.concatenate(both, axis=-1) @ self.N.T
        return moved.reshape(*moved.shape[:-2], -1)

    @property
    def left(self) -> float:
        """What the quadratic model says is left to win, where it curves up."""
        floor = 1e-14 * np.abs(self.values).max()
        return 0.5 * np.sum(self.slope**2 / np.maximum(self.values, floor))

    @property
    def is_flat(self) -> bool:
        """Whether the minimum is one of a continuum."""
        return self.values[0] <= FLAT * np.abs(self.values).max()

    @property
    def is_minimum(self) -> bool:
        """Whether no direction leads down, to second order, but for rounding."""
        scale = self.target.scale
        if self.values[0] < -CURVED * np.abs(self.values).max():
            return False
        gentle = np.linalg.norm(self.slope) < NEAR * scale
        return bool(gentle or self.left < CLOSE * scale)

    def step(self, reach: float) -> Vector:
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

    def model(self, step: Vector) -> float:
        """Fall of the cost that the quadratic model promises."""
        return -(self.slope @ step + 0.5 * step @ (self.values * step))

    def moved(self, step: Vector) -> Pair:
        """(Ae, Be) after a step."""
        dAe, dBe = self._direction((self.vectors @ step).reshape(self.r, -1))
        return self.pair[0] + dAe, self.pair[1] + dBe


def descend(target: Target, Ae: Matrix, Be: Matrix) -> Frame:
    """The Frame at a local minimum reached from (Ae, Be), polished to rounding.

    Raises CertificateError saying why there is none.
    """
    frame, reach = Frame(target, Ae, Be), 0.3
    for _ in range(MOVES):
        if frame.is_minimum:
            return _polished(frame)
        frame, reach = _move(frame, reach)
    raise CertificateError(f"no minimum after {MOVES} moves")


def _move(frame: Frame, reach: float) -> tuple[Frame, float]:
    """The next frame of the trust region, and its new reach."""
    target, start = frame.target, frame.point.cost
    while reach > 1e-12:
        step = frame.step(reach)
        length, promised = float(np.linalg.norm(step)), frame.model(step)
        pair = frame.moved(step)
        stable = radius(pair[0]) < 1
        fall = start - evaluate(target, *pair).cost if stable else -np.inf
        slack = ROUNDING * target.scale
        kept = (fall + slack) / (promised + slack)
        if kept > 0.75 and length > 0.9 * reach:
            reach = min(2 * reach, 2.0)
        elif kept < 0.25:
            reach = 0.25 * min(reach, length)
        if kept > 1e-4:
            return Frame(target, *pair), reach
    raise CertificateError("the cost falls no further, and this is not a minimum")


def _polished(frame: Frame) -> Frame:
    """Newton's method alone, in balanced coordinates, while it halves what is left."""
    frame = Frame(frame.target, *frame.pair, balanced=True)
    for _ in range(10):
        floor = 1e-14 * np.abs(frame.values).max()
        step = -frame.slope / np.maximum(frame.values, floor)
        try:
            better = Frame(frame.target, *frame.moved(step), balanced=True)
        except CertificateError:
            break
        if not better.left < 0.5 * frame.left:
            break
        frame = better
    return frame
