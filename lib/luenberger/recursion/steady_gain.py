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
from ..numeric.balance import power_of_two
from ..numeric.detectability import require_detectable
from ..numeric.linalg import ROUNDING, UNIT_TOL, complete, lyapunov, radius, symmetrise
from ..papers.leondes_novak.derivation import steady_gradient, step_differential
from .excitation import overflow, read_off, require_excited, require_noise_enough
from .root_step import Spread
from .units import in_units, natural

RESIDUAL_TOL = 1e-12  # of Sigma = f(Sigma), relative
DENSE_LIMIT = 40  # states up to which Newton's equation is solved densely
STATIONARITY_TOL = 1e-9  # of the best constant gain, relative
PATIENCE = 20  # moves without a smaller residual before the search ends
MEMORY = 8  # moves that Anderson mixing looks back on
WARM_UP = 200  # recursion steps between attempts with Newton's method


def steady_gain(now, accurate):
    """Gain of the steady step-wise filter; Sigma = f(Sigma) with f of (29)-(33)."""
    states, outputs = natural(now)
    now = in_units(now, states, outputs)
    require_detectable(now.As, now.C)
    told = read_off(now)
    try:
        K = _settled_gain(now, accurate)
    except (CertificateError, DesignError):
        if (K := told) is None:  # many gains are as good: take one
            raise
    one = np.eye(len(K))
    if told is not None and _cost(now, K, one)[0] > _cost(now, told, one)[0]:
        K = told  # rounding led to a gain that lets noise in
    return K * states[:, None] / outputs


def _settled_gain(now, accurate):
    try:
        with np.errstate(over="raise"):
            return _fixed_point(now, accurate)
    except FloatingPointError:
        raise overflow(radius(now.As)) from None


def _fixed_point(now, accurate):
    Sigma = _start(now)
    for _ in range(10):
        Sigma = _recur(now, Sigma, WARM_UP)
        found, K = _newton(now, Sigma)
        if found is not None and radius(_closed(now, K)) < 1 - UNIT_TOL:
            require_excited(now, K)
            return K
    require_excited(now, _step(now, Sigma)["K"])
    require_noise_enough(now)
    raise CertificateError(
        "the recursion of the reduced-order gain does not settle on a stable filter: "
        f"after {10 * WARM_UP} steps its largest pole is "
        f"{radius(_closed(now, _step(now, Sigma)['K'])):.6g}. Take other outputs as "
        f"accurate than {list(accurate)}, or fewer."
    )


def _step(now, Sigma):
    """One step from a covariance that need not have come from a step."""
    moved = np.abs(now.As) @ np.sqrt(np.maximum(Sigma.diagonal(), 0))
    size = np.maximum(Sigma.diagonal(), moved**2 + now.Qs.diagonal())
    return now.step(now.move, Spread.of(Sigma, size))[0]


def _closed(now, K):
    """F of the reduced filter, in the coordinates of Phat: (14)."""
    return now.That @ (np.eye(len(K)) - K @ now.C) @ now.As @ now.Phat


def _start(now):
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
    size = np.trace(now.Qs) + np.trace(now.R)
    return (size if size > 0 else 1.0) * np.eye(len(now.As))


def _recur(now, Sigma, steps):
    spread = Spread.of(Sigma)
    for _ in range(steps):
        _, spread, _ = now.step(now.move, spread)
        new = spread.Sigma
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
    differential = kernels.compiled(step_differential, "dSigma", stacks=True)
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
    solution, _ = gmres(
        operator,
        gap.ravel(),
        rtol=1e-10,
        restart=100,
        maxiter=20,
        M=_of_fixed_gain(new["Y"] @ now.As),
    )
    return symmetrise(solution.reshape(n, n))


def _of_fixed_gain(Phi):
    """The inverse of 1 - Df as if the gain did not move: d = Phi d Phi' + right side.

    Nearly the inverse of the whole, and for the Kalman filter exactly; None where the
    gain is not stable.
    """
    if not radius(Phi) < 1:
        return None
    powers = [Phi]
    while np.linalg.norm(powers[-1]) > ROUNDING:
        powers.append(powers[-1] @ powers[-1])

    def solved(v):
        X = v.reshape(Phi.shape)
        for power in powers:
            X = X + power @ X @ power.T
        return X.ravel()

    return LinearOperator((Phi.size, Phi.size), matvec=solved)


def best_constant_gain(now, accurate):
    """Constant gain of the same structure with the least steady weighted trace.

    The search starts from the step-wise gain, in units in which each state and each
    output matters as much as the others: so the user's units play no part.
    """
    K = steady_gain(now, accurate)
    states, outputs = _units(now, K)
    K = _descended(in_units(now, states, outputs), K / states[:, None] * outputs)
    return K * states[:, None] / outputs


def _units(now, K):
    """Units of states and outputs in which all of them matter to the cost.

    That of an output is its innovation's deviation; that of a state the deviation
    that would cost as much as the filter does, at its weight Lambda in the long run.
    """
    weight = np.eye(len(K)) if now.weight is None else now.weight
    cost, (Sigma, Phi) = _cost(now, K, weight)
    Lambda = lyapunov(Phi.T, weight)
    states = np.sqrt((cost if cost > 0 else 1.0) / Lambda.diagonal())
    innovation = _step(now, Sigma)["M"].diagonal()
    known = (now.C * now.C) @ (states * states)  # what an exact output may be off by
    outputs = np.where(innovation > ROUNDING * known, innovation, known)
    outputs = np.sqrt(np.where(outputs > 0, outputs, 1.0))
    return power_of_two(states), power_of_two(outputs)


def _descended(now, K):
    """From K to the gain of least cost.

    With Lambda = Phi' Lambda Phi + weight, the stationary gain is the step-wise gain
    for the weight Lambda.  Moving toward that gain is a direction of descent; it is
    extrapolated from the last moves (Anderson mixing) where that lowers the trace,
    and shortened where it does not.  The gradient that certifies is the derived one.
    """
    columns = now.Gamma.any(axis=0)
    cost, state = _cost(now, K, now.weight)
    best, memory, idle = (np.inf, K), [], 0
    while idle < PATIENCE:
        residual, toward = _descent(now, K, state, columns)
        idle = 0 if residual < best[0] else idle + 1  # NaN is no progress
        best = min(best, (residual, K), key=lambda pair: pair[0])
        if residual <= 1e-12:
            break
        memory = [*memory[-MEMORY:], (K, toward - K)]
        for trial in _trials(memory):
            lower, reached = _cost(now, trial, now.weight)
            if lower <= cost * (1 + 1e-13):  # equal: at the bottom costs only round
                break
        else:
            break
        K, cost, state = trial, lower, reached
    _require_reached(now, *best)
    return best[1]


def _require_reached(now, residual, K):
    """Raise unless K is stationary, and stable by more than rounding."""
    if radius(_closed(now, K)) >= 1 - UNIT_TOL:
        require_excited(now, K)
        raise CertificateError(
            "the best constant gain leaves a pole on the unit circle, to rounding, so "
            "its start would never be forgotten. Use horizon='step', or other accurate "
            "outputs."
        )
    if residual > STATIONARITY_TOL:
        raise CertificateError(
            "the best constant gain was not reached: the stationarity residual stays "
            f"at {residual:.1e}. Use horizon='step', or other accurate outputs."
        )


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


def _descent(now, K, state, columns):
    """Relative stationarity residual at K, and the step-wise gain to move toward."""
    Sigma, Phi = state
    Lambda = lyapunov(Phi.T, now.weight)
    new = _step(now._replace(Gamma=_regamma(now, Lambda, columns)), Sigma)
    gradient = kernels.compiled(steady_gradient)(
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
