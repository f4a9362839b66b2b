"""Where no steady filter exists: motions that are neither driven nor seen.

At a point e^{jw} of the unit circle the noise pencil

    [[As - e^{jw} I, sqrt(Qs), 0], [C, 0, sqrt(R)]]

loses rank if a motion there is not driven by noise and not reported by the outputs.
"""

from collections.abc import Callable

import numpy as np
import scipy.linalg

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.factors import factor
from ..numeric.linalg import RANK_TOL, modes
from ..papers.leondes_novak.derivation import root_update
from .settings import Setting

Pencil = Callable[[float], Matrix]  # of the angle
LOST = 1e-9  # singular value of the pencil, relative, that is none


def require_excited(now: Setting, K: Matrix) -> None:
    """Refuse when the filter's slowest pole tends to the unit circle.

    It does where the noise pencil loses rank.  Then the optimal gain leaves the motion
    alone and the filter never forgets how it started.
    """
    poles = np.linalg.eigvals(now.closed(K, "Phi")["Phi"])
    suspects = poles[(np.abs(poles) > 0.98) & (poles.imag >= 0)]  # conjugates once
    if not len(suspects):
        return
    require_noise_enough(now)
    pencil, slope = _pencil(now)
    near = (_loss(pencil, slope, angle) for angle in np.angle(suspects))
    caught = [np.exp(1j * angle) for angle in near if angle is not None]
    if caught:
        raise DesignError(
            f"no steady filter: a motion at {modes(caught)}, on the unit circle, is "
            "neither driven by the process noise nor seen apart from it in the "
            "outputs, so the filter's pole would sit there and its start would never "
            "be forgotten. Add process noise that drives it (Q), give the noise-free "
            "outputs some noise (R), or design over a number of steps."
        )


def _loss(pencil: Pencil, slope: float, angle: float) -> float | None:
    """The angle near this one at which the pencil loses rank, or None.

    A search is a few dozen singular values; where the pencil is so far from losing
    rank that its slope forbids it within reach, there is none.
    """

    from scipy.optimize import minimize_scalar  # slow to import, and seldom needed

    def least(angle: float) -> float:
        return scipy.linalg.svdvals(pencil(angle))[-1]

    for reach in (0.05, 1e-6):  # the search is precise relative to its interval
        if least(angle) > LOST + slope * reach:
            return None
        angle += minimize_scalar(
            lambda turn, start=angle: least(start + turn),
            bounds=(-reach, reach),
            method="bounded",
            options=dict(xatol=1e-9 * reach),
        ).x
    return angle if least(angle) < LOST else None


def require_noise_enough(now: Setting) -> None:
    """Refuse when some outputs are, in the long run, functions of the others.

    Then the pencil loses rank everywhere, not at one mode: the innovation covariance
    is singular, many gains reach the same covariance, and the one of least norm need
    not be stable.  Redundant outputs alone do no harm and do not come here.
    """
    pencil, _ = _pencil(now)
    left, values, _ = np.linalg.svd(pencil(1.2345))  # an angle like any other
    if values[-1] > LOST * values[0]:
        return
    bound = left[:, values <= LOST * values[0]][len(now.As) :]
    which = np.flatnonzero(np.abs(bound).max(axis=1) > 1e-6)
    raise DesignError(
        "no steady filter: more noise-free outputs than noise sources. In the steady "
        f"state outputs {which.tolist()} (counted from 0) obey a relation that no "
        "noise disturbs, so the noise does not determine a stable gain. Give them "
        "noise in R, add process noise (Q), leave some of them out, or take some as "
        "accurate (m1)."
    )


def read_off(now: Setting) -> Matrix | None:
    """K with K C = I from the outputs that carry no noise, or None if they are too few.

    Its error is that of noisy outputs that are taken as accurate, or none, whatever
    drives the state.  So it is optimal at every step, and the recursion, whose M has no
    inverse in the steady state, need not find it.
    """
    seen = now.blind.T @ now.C
    size = np.abs(seen).max(axis=1, keepdims=True, initial=0)  # no square overflows
    unit = 1 / np.where(size > 0, size, 1.0)
    values = np.linalg.svd(unit * seen, compute_uv=False)
    if len(values) < len(now.As) or not values[-1] > RANK_TOL * values[0]:
        return None
    K = np.linalg.pinv(unit * seen) @ (unit * now.blind.T)
    pushed = kernels.compiled(root_update, "K")
    return pushed(C=now.C, Gamma=now.Gamma, Kmv=K)["K"]


def _pencil(now: Setting) -> tuple[Pencil, float]:
    """The noise pencil as a function of the angle, at the scale of As; and its slope.

    No singular value changes by more than the slope times the change of the angle.
    """
    n, p = len(now.As), len(now.C)
    noise, sensor = np.zeros((n, n)), np.zeros((p, p))
    for root, covariance in ((noise, now.Qs), (sensor, now.R)):
        found = factor(covariance)  # a root of rounding would not be small
        root[:, : found.shape[1]] = found
    size = max(float(np.linalg.norm(now.As, 2)), 1.0)
    unit = np.linalg.norm(np.hstack([now.C, sensor]), axis=1, keepdims=True)
    unit = size / np.where(unit > 0, unit, 1)
    strength = np.linalg.norm(noise, 2)
    noise = noise * (size / strength if strength > 0 else 1)
    fixed = np.block(
        [
            [now.As, noise, np.zeros((n, p))],
            [unit * now.C, np.zeros((p, n)), unit * sensor],
        ]
    )
    turning = np.eye(n + p, 2 * n + p)
    turning[n:] = 0
    return lambda angle: (fixed - np.exp(1j * angle) * turning) / size, 1 / size
