"""The steady step-wise gain: the fixed point of the recursion.

The fixed point is found by Newton's method with the derived differential, started
from the recursion itself; it is accepted only with a residual at rounding level
and stable error dynamics.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy  # its parts load when first used

from .. import kernels
from ..errors import CertificateError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import Sums
from ..numeric.detectability import require_detectable
from ..numeric.linalg import ROUNDING, UNIT_TOL, lyapunov, radius, symmetrise
from ..papers.leondes_novak.derivation import step_differential
from .excitation import read_off, require_excited, require_noise_enough
from .root_step import Spread
from .settings import Setting
from .units import in_units, natural

RESIDUAL_TOL = 1e-12  # of Sigma = f(Sigma), relative
DENSE_LIMIT = 40  # states up to which Newton's equation is solved densely
WARM_UP = 200  # recursion steps between attempts with Newton's method


def steady_gain(now: Setting, accurate: Sequence[int]) -> Matrix:
    """Gain of the steady step-wise filter; Sigma = f(Sigma) with f of (29)-(33)."""
    states, outputs = natural(now)
    now = in_units(now, states, outputs)
    require_detectable(now.As, now.C)
    K = read_off(now)  # where there is one, M is singular and others are as good
    if K is None:
        try:
            with np.errstate(over="raise"):
                K = _fixed_point(now, accurate)
        except FloatingPointError:
            raise _overflow(radius(now.As)) from None
    return K * states[:, None] / outputs


def _overflow(growth: float) -> CertificateError:
    """The refusal of a plant whose covariance overflows; `growth` in one step."""
    why = "entries too large to compute with. Scale the states and the outputs"
    if growth > 1:
        why = f"modes of the plant grow {growth:.3g} times in a step. Sample "
        why += "faster, or scale the states"
    return CertificateError(
        f"the covariance overflows on the way to its steady state: {why}."
    )


def _fixed_point(now: Setting, accurate: Sequence[int]) -> Matrix:
    Sigma = _start(now)
    for _ in range(10):
        Sigma = _recur(now, Sigma, WARM_UP)
        K = _newton(now, Sigma)
        if K is not None and radius(reduced_dynamics(now, K)) < 1 - UNIT_TOL:
            require_excited(now, K)
            return K
    K = step_from(now, Sigma)["K"]
    require_excited(now, K)
    require_noise_enough(now)
    raise CertificateError(
        "the recursion of the reduced-order gain does not settle on a stable filter: "
        f"after {10 * WARM_UP} steps its largest pole is "
        f"{radius(reduced_dynamics(now, K)):.6g}. Take other outputs "
        f"as accurate than {list(accurate)}, or fewer."
    )


def step_from(now: Setting, Sigma: Matrix) -> Matrices:
    """One step from a covariance that need not have come from a step."""
    moved = np.abs(now.As) @ np.sqrt(np.maximum(Sigma.diagonal(), 0))
    size = np.maximum(Sigma.diagonal(), moved**2 + now.Qs.diagonal())
    return now.step(now.move, Spread.of(Sigma, size))[0]


def reduced_dynamics(now: Setting, K: Matrix) -> Matrix:
    """F of the reduced filter, in the coordinates of Phat: (14)."""
    return now.closed(K, "F")["F"]


def _start(now: Setting) -> Matrix:
    """The Kalman filter's covariance where SciPy finds it, else a generous guess.

    Without any noise it is zero, and stays so.
    """
    if not now.Qs.any() and not now.R.any():
        return np.zeros_like(now.Qs)
    try:
        Omega = scipy.linalg.solve_discrete_are(now.As.T, now.C.T, now.Qs, now.R)
        if np.isfinite(Omega).all() and np.linalg.eigvalsh(Omega)[0] > -1e-8 * abs(
            Omega
        ).max(initial=0):
            return symmetrise(Omega)
    except (np.linalg.LinAlgError, ValueError):
        pass  # a singular pencil, or no strictly stable solution: the recursion tells
    return (np.trace(now.Qs) + np.trace(now.R)) * np.eye(len(now.As))


def _recur(now: Setting, Sigma: Matrix, steps: int) -> Matrix:
    spread = Spread.of(Sigma)
    for _ in range(steps):
        _, spread = now.step(now.move, spread)
        new = spread.Sigma
        moved = np.abs(new - Sigma).max(initial=0)
        Sigma = new
        if moved <= 1e-9 * np.abs(Sigma).max(initial=0):
            break
    return Sigma


def _newton(now: Setting, Sigma: Matrix) -> Matrix | None:
    """The gain of the fixed point near Sigma, or None where Newton does not arrive."""
    back = np.linalg.pinv(now.C)
    # far below what one measurement tells, or one step brings, is zero
    floor = ROUNDING * max(np.abs(back @ now.R @ back.T).max(initial=0), now.Q.max())
    for _ in range(30):
        new = step_from(now, Sigma)
        if not np.isfinite(new["M"]).all():
            raise FloatingPointError  # of which not every BLAS tells
        gap = new["Sigma_next"] - Sigma
        # measured against Omega, which does not vanish with perfect measurements
        scale = max(np.abs(new["Omega"]).max(initial=0), floor)
        if np.abs(gap).max(initial=0) <= 0.1 * RESIDUAL_TOL * scale:
            return new["K"]
        Sigma = Sigma + _newton_step(now, new, gap)
        if not np.isfinite(Sigma).all():
            return None
    done = np.abs(gap).max() <= RESIDUAL_TOL * scale
    return new["K"] if done else None


def _newton_step(now: Setting, new: Matrices, gap: Matrix) -> Matrix:
    """Solve (1 - Df) d = gap for symmetric d, with the derived differential Df."""
    n = len(gap)
    differential = kernels.compiled(step_differential, "dSigma", stacks=True)
    fixed = dict(A=now.As, C=now.C, R=now.R, Gamma=now.Gamma)
    fixed |= {name: new[name] for name in ("M", "Kmv", "Y")}

    def moved(d: Matrix) -> Matrix:
        return d - differential(dSigma_0=d, **fixed)["dSigma"]

    if n <= DENSE_LIMIT:
        rows, columns = np.triu_indices(n)
        basis = np.zeros((len(rows), n, n))
        basis[np.arange(len(rows)), rows, columns] = 1
        basis = np.maximum(basis, basis.mT)
        matrix = moved(basis)[:, rows, columns].T
        solution = np.linalg.lstsq(matrix, gap[rows, columns], rcond=None)[0]
        return np.tensordot(solution, basis, 1)
    operator = scipy.sparse.linalg.LinearOperator(
        (n * n, n * n), matvec=lambda v: moved(symmetrise(v.reshape(n, n))).ravel()
    )
    solution, _ = scipy.sparse.linalg.gmres(
        operator,
        gap.ravel(),
        rtol=1e-10,
        restart=100,
        maxiter=20,
        M=_of_fixed_gain(now.closed(new["K"], "Phi")["Phi"]),
    )
    return symmetrise(solution.reshape(n, n))


def _of_fixed_gain(Phi: Matrix) -> Any:
    """The inverse of 1 - Df as if the gain did not move: d = Phi d Phi' + right side.

    Nearly the inverse of the whole, and for the Kalman filter exactly; None where the
    gain is not stable.
    """
    if not radius(Phi) < 1:
        return None
    sums = Sums(Phi)

    def solved(v: Vector) -> Vector:
        return sums(v.reshape(Phi.shape)).ravel()

    return scipy.sparse.linalg.LinearOperator((Phi.size, Phi.size), matvec=solved)


def steady_cost(
    now: Setting, K: Matrix, weight: Matrix
) -> tuple[float, tuple[Matrix, Matrix]]:
    """tr(weight Sigma) of a constant gain, and (Sigma, Phi); inf when unstable."""
    given = now.closed(K, "Phi", "Q_c")
    Phi = given["Phi"]
    if not radius(Phi) < 1:
        return np.inf, (np.full_like(Phi, np.inf), Phi)
    Sigma = lyapunov(Phi, given["Q_c"])
    return float(np.trace(weight @ Sigma)), (Sigma, Phi)
