"""Steady states: the fixed point of the recursion, and the best constant gain.

The fixed point is found by Newton's method with the derived differential, started
from the recursion itself; it is accepted only with a residual at rounding level
and stable error dynamics.
"""

import numpy as np
import scipy.linalg
from scipy.sparse.linalg import LinearOperator, gmres

from .. import kernels
from ..errors import CertificateError, DesignError
from ..linalg import (
    ROUNDING,
    UNIT_TOL,
    complete,
    factor,
    lyapunov,
    modes,
    radius,
    require_detectable,
    symmetrise,
)

RESIDUAL_TOL = 1e-12  # of Sigma = f(Sigma), relative
DENSE_LIMIT = 40  # states up to which Newton's equation is solved densely
STATIONARITY_TOL = 1e-9  # of the best constant gain, relative
PATIENCE = 20  # moves without a smaller residual before the search ends
MEMORY = 8  # moves that Anderson mixing looks back on
WARM_UP = 200  # recursion steps between attempts with Newton's method


def steady_gain(now, accurate):
    """Gain of the steady step-wise filter; Sigma = f(Sigma) with f of (29)-(33)."""
    require_detectable(now.As, now.C)
    try:
        with np.errstate(over="raise"):
            return _settled_gain(now, accurate)
    except FloatingPointError:
        raise CertificateError(
            "the covariance overflows on the way to its steady state: modes of the "
            f"plant grow {radius(now.As):.3g} times in a step. Sample faster, or scale "
            "the states."
        ) from None


def _settled_gain(now, accurate):
    Sigma = _start(now)
    for _ in range(10):
        Sigma = _recur(now, Sigma, WARM_UP)
        found, K = _newton(now, Sigma)
        if found is not None and radius(_closed(now, K)) < 1 - UNIT_TOL:
            _require_excited(now, K)
            return K
    _require_excited(now, _step(now, Sigma)["K"])
    _require_noise_enough(now)
    raise CertificateError(
        "the recursion of the reduced-order gain does not settle on a stable filter: "
        f"after {10 * WARM_UP} steps its largest pole is "
        f"{radius(_closed(now, _step(now, Sigma)['K'])):.6g}. Take other outputs as "
        f"accurate than {list(accurate)}, or fewer."
    )


def _step(now, Sigma):
    return now.step(now.As, now.Qs, Sigma)


def _closed(now, K):
    """F of the reduced filter, in the coordinates of Phat: (14)."""
    return now.That @ (np.eye(len(K)) - K @ now.C) @ now.As @ now.Phat


def _start(now):
    """The Kalman filter's covariance where SciPy finds it, else a generous guess."""
    try:
        Omega = scipy.linalg.solve_discrete_are(now.As.T, now.C.T, now.Qs, now.R)
        if np.isfinite(Omega).all() and np.linalg.eigvalsh(Omega)[0] > -1e-8 * abs(
            Omega
        ).max(initial=0):
            return symmetrise(Omega)
    except (np.linalg.LinAlgError, ValueError):
        pass  # a singular pencil, or no strictly stable solution: the recursion tells
    size = np.trace(now.Qs) + np.trace(now.R)
    return (size if size > 0 else 1.0) * np.eye(len(now.As))


def _recur(now, Sigma, steps):
    for _ in range(steps):
        new = _step(now, Sigma)["Sigma_next"]
        moved = np.abs(new - Sigma).max(initial=0)
        Sigma = new
        if moved <= 1e-9 * np.abs(Sigma).max(initial=0):
            break
    return Sigma


def _newton(now, Sigma):
    """Polish Sigma; return it and its gain, or None where Newton does not arrive."""
    back = np.linalg.pinv(now.C)
    # far below what one measurement tells, or one step brings, is zero
    floor = ROUNDING * max(np.abs(back @ now.R @ back.T).max(initial=0), now.Q.max())
    for _ in range(30):
        new = _step(now, Sigma)
        gap = new["Sigma_next"] - Sigma
        # measured against Omega, which does not vanish with perfect measurements
        scale = max(np.abs(new["Omega"]).max(initial=0), floor)
        if np.abs(gap).max(initial=0) <= 0.1 * RESIDUAL_TOL * scale:
            return new["Sigma_next"], new["K"]
        Sigma = Sigma + _newton_step(now, new, gap)
        if not np.isfinite(Sigma).all():
            return None, None
    done = np.abs(gap).max() <= RESIDUAL_TOL * scale
    return (new["Sigma_next"], new["K"]) if done else (None, None)


def _newton_step(now, new, gap):
    """Solve (1 - Df) d = gap for symmetric d, with the derived differential Df."""
    n = len(gap)
    differential = kernels.step_differential("dSigma")
    fixed = dict(
        C=now.C, R=now.R, Gamma=now.Gamma, M=new["M"], Kmv=new["Kmv"], Y=new["Y"]
    )

    def moved(d):
        return d - differential(dOmega=now.As @ d @ now.As.T, **fixed)["dSigma"]

    if n <= DENSE_LIMIT:
        rows, columns = np.triu_indices(n)
        basis = np.zeros((len(rows), n, n))
        basis[np.arange(len(rows)), rows, columns] = 1
        basis = np.maximum(basis, basis.mT)
        matrix = moved(basis)[:, rows, columns].T
        solution = np.linalg.lstsq(matrix, gap[rows, columns], rcond=None)[0]
        return np.tensordot(solution, basis, 1)
    operator = LinearOperator(
        (n * n, n * n), matvec=lambda v: moved(symmetrise(v.reshape(n, n))).ravel()
    )
    solution, _ = gmres(operator, gap.ravel(), rtol=1e-10, restart=100, maxiter=20)
    return symmetrise(solution.reshape(n, n))


def _require_excited(now, K):
    """Refuse when the filter's slowest pole tends to the unit circle.

    At a pole e^{jw} the matrix [[As - e^{jw} I, sqrt(Qs), 0], [C, 0, sqrt(R)]] loses
    rank: a motion that no noise drives and the outputs do not report.  Then the
    optimal gain leaves it alone and the filter never forgets how it started.
    """
    Phi = (np.eye(len(K)) - K @ now.C) @ now.As
    suspects = [z for z in np.linalg.eigvals(Phi) if abs(z) > 0.98]
    if suspects:
        _require_noise_enough(now)
    caught = []
    for pole in suspects:
        angle = np.angle(pole)
        for reach in (0.05, 1e-6):  # the search is precise relative to its interval
            angle += scipy.optimize.minimize_scalar(
                lambda turn, start=angle: _excitation(now, start + turn),
                bounds=(-reach, reach),
                method="bounded",
                options=dict(xatol=1e-9 * reach),
            ).x
        if _excitation(now, angle) < 1e-9:
            caught.append(np.exp(1j * angle))
    if caught:
        raise DesignError(
            f"no steady filter: a motion at {modes(caught)}, on the unit circle, is "
            "neither driven by the process noise nor seen apart from it in the "
            "outputs, so the filter's pole would sit there and its start would never "
            "be forgotten. Add process noise that drives it (Q), give the noise-free "
            "outputs some noise (R), or design over a number of steps."
        )


def _require_noise_enough(now):
    """Refuse when some outputs are, in the long run, functions of the others.

    Then the pencil loses rank everywhere, not at one mode: the innovation covariance
    is singular, many gains reach the same covariance, and the one of least norm need
    not be stable.  Redundant outputs alone do no harm and do not come here.
    """
    left, values, _ = np.linalg.svd(_pencil(now, 1.2345))  # an angle like any other
    if values[-1] > 1e-9 * values[0]:
        return
    bound = left[:, values <= 1e-9 * values[0]][len(now.As) :]
    which = np.flatnonzero(np.abs(bound).max(axis=1) > 1e-6)
    raise DesignError(
        "no steady filter: more noise-free outputs than noise sources. In the steady "
        f"state outputs {which.tolist()} (counted from 0) obey a relation that no "
        "noise disturbs, so the noise does not determine a stable gain. Give them "
        "noise in R, add process noise (Q), leave some of them out, or take some as "
        "accurate (m1)."
    )


def _excitation(now, angle):
    """Least singular value of the noise pencil on the unit circle, relative."""
    return np.linalg.svd(_pencil(now, angle), compute_uv=False)[-1]


def _pencil(now, angle):
    """The noise pencil at a point of the unit circle, at the scale of As."""
    n, p = len(now.As), len(now.C)
    noise, sensor = np.zeros((n, n)), np.zeros((p, p))
    for root, covariance in ((noise, now.Qs), (sensor, now.R)):
        found = factor(covariance, covariance)  # a root of rounding would not be small
        root[:, : found.shape[1]] = found
    size = max(np.linalg.norm(now.As, 2), 1.0)
    unit = np.linalg.norm(np.hstack([now.C, sensor]), axis=1, keepdims=True)
    unit = size / np.where(unit > 0, unit, 1)
    strength = np.linalg.norm(noise, 2)
    noise = noise * (size / strength if strength > 0 else 1)
    return (
        np.block(
            [
                [now.As - np.exp(1j * angle) * np.eye(n), noise, np.zeros((n, p))],
                [unit * now.C, np.zeros((p, n)), unit * sensor],
            ]
        )
        / size
    )


def best_constant_gain(now, accurate):
    """Constant gain of the same structure with the least steady weighted trace.

    With Lambda = Phi' Lambda Phi + weight, the stationary gain is the step-wise gain
    for the weight Lambda.  Moving toward that gain is a direction of descent; it is
    extrapolated from the last moves (Anderson mixing) where that lowers the trace,
    and shortened where it does not.  The gradient that certifies is the derived one.
    """
    weight = np.eye(len(now.As)) if now.weight is None else now.weight
    columns = now.Gamma.any(axis=0)
    K = steady_gain(now, accurate)
    cost, state = _cost(now, K, weight)
    best, memory, idle = (np.inf, K), [], 0
    while idle < PATIENCE:
        residual, toward = _descent(now, K, state, weight, columns)
        idle = idle + 1 if residual >= best[0] else 0
        best = min(best, (residual, K), key=lambda pair: pair[0])
        if residual <= 1e-12:
            break
        memory = [*memory[-MEMORY:], (K, toward - K)]
        for trial in _trials(memory):
            lower, reached = _cost(now, trial, weight)
            if lower <= cost * (1 + 1e-13):  # equal: at the bottom costs only round
                break
        else:
            break
        K, cost, state = trial, lower, reached
    if best[0] > STATIONARITY_TOL:
        raise CertificateError(
            "the best constant gain was not reached: the stationarity residual stays "
            f"at {best[0]:.1e}. Use horizon='step', or other accurate outputs."
        )
    return best[1]


def _trials(memory):
    """Gains to try in turn: extrapolated, then along the descent ever more shortly."""
    K, move = memory[-1]
    if len(memory) > 1:
        moves = np.stack([(move - m).ravel() for _, m in memory[:-1]], axis=1)
        steps = np.stack([(K + move - k - m).ravel() for k, m in memory[:-1]], axis=1)
        mix = np.linalg.lstsq(moves, move.ravel(), rcond=1e-12)[0]
        yield K + move - (steps @ mix).reshape(K.shape)
    for halvings in range(30):
        yield K + move / 2**halvings


def _cost(now, K, weight):
    """tr(weight Sigma) of a constant gain, and (Sigma, Phi); inf when unstable."""
    Y = np.eye(len(K)) - K @ now.C
    Phi = Y @ now.As
    if not radius(Phi) < 1:
        return np.inf, None
    Sigma = lyapunov(Phi, symmetrise(Y @ now.Qs @ Y.T + K @ now.R @ K.T))
    return float(np.trace(weight @ Sigma)), (Sigma, Phi)


def _descent(now, K, state, weight, columns):
    """Relative stationarity residual at K, and the step-wise gain to move toward."""
    Sigma, Phi = state
    Lambda = lyapunov(Phi.T, weight)
    new = _step(now._replace(Gamma=_regamma(now, Lambda, columns)), Sigma)
    gradient = kernels.steady_gradient()(
        K=K, M=new["M"], Omega=new["Omega"], C=now.C, Lambda=Lambda
    )["Gradient"]
    along = now.Phat.T
    size = 2 * np.linalg.norm(along @ Lambda) * np.linalg.norm(new["Omega"] @ now.C.T)
    residual = np.linalg.norm(along @ gradient) / size if size > 0 else 0.0
    return residual, new["K"]


def _regamma(now, weight, columns):
    Gamma = np.zeros_like(now.Gamma)
    Gamma[:, columns] = complete(now.C[columns], weight)[1]
    return Gamma
