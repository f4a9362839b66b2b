"""Is an estimator the best of its order?  The necessary conditions, measured.

The moments come from the Lyapunov equations (4.4) and (4.5) of plant and observer
together, multiplicative noise included, and not from the block equations that a
design solves, so a fault of either shows.
"""

from dataclasses import dataclass, field

import numpy as np

from ..arguments import expect
from ..certificate import require_match, require_real
from ..errors import CertificateError, DesignError
from ..kernels import run
from ..numeric.linalg import left_over, lyapunov, modes, symmetrise
from ..numeric.validation import covariance
from ..papers.haddad_bernstein import derivation as stages
from .mean_square import noise_at, require_mean_square_stable, second_moment

STATIONARY_TOL = 1e-8  # of every relative residual of a design that is accepted
SILENT = 1e-14  # of what a number is the sum of: below it is rounding
WEAK = 1e-7  # of a Gramian's largest direction: below, rounding takes over


@dataclass(frozen=True, eq=False)
class Optimality:
    """How far an estimator is from the conditions of least error at its order.

    All residuals are relative, and independent of units: that of a gradient is in
    proportion to the terms that cancel in it, for states and outputs of unit variance.

    Attributes
    ----------
    F, D, P, V : float
        Gradients of the cost in these matrices of the observer: (4.8)-(4.11).  V is
        None when it is held at zero.
    riccati, estimate, adjoint : float
        (3.14), (3.15), (3.16).
    idempotent : float
        tau^2 = tau, (3.6).
    aligned : float
        tau Qh = Qh tau' and Ph tau = tau'Ph, the larger: what (3.17) asks of tau.
    trace : float
        The cost by (3.18) against `cost`; the two agree only at an optimum.
    cost : float
        Steady E[(w^ - L x)' weight (w^ - L x)], for u = 0.
    tau, Q, Qh, Ph : (n, n) ndarray
        The projection, the error covariance of the lifted estimate, and the theorem's
        two hatted matrices.
    G, Gam : (r, n) ndarray
        tau = G'Gam: z tracks Gam x, and G'z is the lifted estimate.
    """

    F: float
    D: float
    P: float
    V: float | None
    riccati: float
    estimate: float
    adjoint: float
    idempotent: float
    aligned: float
    trace: float
    cost: float
    tau: np.ndarray = field(repr=False)
    Q: np.ndarray = field(repr=False)
    Qh: np.ndarray = field(repr=False)
    Ph: np.ndarray = field(repr=False)
    G: np.ndarray = field(repr=False)
    Gam: np.ndarray = field(repr=False)

    @property
    def residuals(self):
        """The relative residuals by name, those that apply."""
        found = ((name, getattr(self, name)) for name in _MEANING)
        return dict(pair for pair in found if pair[1] is not None)

    @property
    def worst(self):
        """The largest relative residual."""
        return max(self.residuals.values())

    def require(self, tol=STATIONARY_TOL):
        """Return self, or raise CertificateError naming the first condition missed."""
        for name, value in self.residuals.items():
            if not value <= tol:  # also catches NaN
                raise CertificateError(
                    f"not optimal at its order: {_MEANING[name]} is missed by "
                    f"{value:.1e}, above {tol:.0e}. If this is a fixed-order filter, "
                    "try more starts, another seed, a lower order, or states and "
                    "outputs scaled to similar sizes."
                )
        return self


_MEANING = {
    "F": "stationarity in F, (4.8),",
    "D": "stationarity in D, (4.9),",
    "P": "stationarity in P, (4.10),",
    "V": "stationarity in V, (4.11),",
    "riccati": "the Riccati equation (3.14)",
    "estimate": "the Lyapunov equation (3.15)",
    "adjoint": "the Lyapunov equation (3.16)",
    "idempotent": "tau^2 = tau, (3.6),",
    "aligned": "the alignment of tau with Qh and Ph, (3.17),",
    "trace": "the cost formula (3.18)",
}


def optimality(observer, plant, *, weight=None, feedthrough=None):
    r"""Measure how far an estimator is from the least error of its order.

    The cost is that of (3.5), E[(w^ - L x)' weight (w^ - L x)] in the steady state
    with u = 0.  The necessary conditions are that its four gradients vanish and,
    equivalently, the optimal projection equations (3.14)-(3.17).

    Parameters
    ----------
    observer : Observer
        Constant and stable; of any method.
    plant : Plant
        Discrete, constant and mean-square stable, with Q and R.
    weight : (q, q) array_like, optional
        Positive semi-definite; default the identity.
    feedthrough : bool, optional
        Whether V is free; default whether it is not zero.

    Returns
    -------
    Optimality

    Raises
    ------
    DesignError
        If the plant or the observer is not stable, or has no such cost.

    References
    ----------
    Haddad and Bernstein (1987), equations (3.14)-(3.18), (4.4)-(4.11);
    papers/haddad_bernstein/derivation/moment_stages.py, theorem_stages.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9, 0.1], [0.2, 0.7]], None, [[0, 1]], dt=1.0,
    ...                  Q=[[0.1, 0], [0, 0]], R=[[1]])
    >>> lb.optimality(lb.kalman_filter(plant), plant).worst < 1e-12
    True
    """
    expect(observer=observer, plant=plant)
    weight = np.eye(len(observer.L)) if weight is None else weight
    weight = covariance("weight", weight, len(observer.L))
    feedthrough = bool(observer.V.any()) if feedthrough is None else feedthrough
    _require(observer, plant, feedthrough)
    have, (x, z, _) = _moments(observer, plant, weight)
    gradients = _gradients(have, feedthrough)
    cost = float(np.trace(run(stages.projection_cost, have, "J")["J"]))
    have |= _projection(have, observer.T * x / z[:, None])
    have |= run(stages.projection_innovation, have)
    have |= run(stages.projection_scripts, have, "Qh", "Ph")
    gap = float(np.trace(run(stages.projection_trace, have, "J")["J"])) - cost
    power = np.trace(weight @ have["L"] @ have["Q1"] @ have["L"].T)  # of L x
    return Optimality(
        **gradients,
        **_equations(have),
        trace=_ratio(gap, cost) if abs(gap) > SILENT * power else 0.0,
        cost=cost,
        tau=have["tau"] * x[:, None] / x,
        Q=have["Q"] * x[:, None] * x,
        Qh=have["Qh"] * x[:, None] * x,
        Ph=have["Ph"] / x[:, None] / x,
        G=have["G"] / z[:, None] * x,
        Gam=have["Gam"] * z[:, None] / x,
    )


def _require(observer, plant, feedthrough):
    require_match(observer, plant)
    require_real("optimality", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        raise DesignError(
            "optimality is for discrete time and needs both noise covariances Q and R"
        )
    if observer.steps is not None:
        raise DesignError("optimality is of a constant observer, not of one over steps")
    require_mean_square_stable(plant)
    poles = np.linalg.eigvals(observer.F)
    if (np.abs(poles) >= 1).any():
        raise DesignError(
            f"the observer has the mode {modes(poles[np.abs(poles) >= 1])} on or "
            "outside the unit circle, so its error has no steady state"
        )
    if not isinstance(feedthrough, bool | np.bool_):
        raise ValueError(f"feedthrough must be True, False or None, got {feedthrough}")
    if not feedthrough and observer.V.any():
        raise ValueError("feedthrough=False, but the observer's V is not zero")


def _moments(observer, plant, weight):
    """The moments (4.4), (4.5) in blocks, and the matrices that they belong to.

    Their names are the derivation's.  All signals are divided by their standard
    deviations, which are returned too.
    """
    o, n, r, now = observer, plant.n, observer.order, plant.at(0)
    S = np.zeros((n, plant.p)) if now.S is None else now.S

    def joint(A, C, F):
        return np.block([[A, np.zeros((n, r))], [o.D @ C, F]])

    A = joint(now.A, now.C, o.F)
    pairs = [(joint(A1, C1, 0 * o.F), 0) for A1, C1 in plant.multiplicative]
    half = np.block([[np.eye(n), np.zeros(S.shape)], [np.zeros((r, n)), o.D]])
    noise = np.block([[now.Q, S], [S.T, now.R]])
    second = second_moment(A, pairs, half @ noise @ half.T)
    _, V1, V12, V2 = noise_at(plant, 0, second[:n, :n])
    x, y = _unit(second[:n, :n]), _unit(now.C @ second[:n, :n] @ now.C.T + V2)
    z = _unit(second[n:, n:], SILENT * np.abs(o.T) @ x)
    whole = np.concatenate([x, z])
    P = np.where(np.abs(o.P * z) > SILENT * (np.abs(o.L) @ x)[:, None], o.P * z, 0.0)
    error = np.hstack([left_over(o.L, o.V, now.C, x), -P])
    A, second = A * whole / whole[:, None], second / whole / whole[:, None]
    dual = lyapunov(A.T, error.T @ weight @ error)  # the pairs act on P1 alone
    have = dict(A=A[:n, :n], C=now.C * x / y[:, None], L=o.L * x, R=weight)
    have |= dict(V1=V1 / x / x[:, None], V12=V12 / y / x[:, None])
    have |= dict(V2=V2 / y / y[:, None], Ae=A[n:, n:], Be=o.D * y / z[:, None])
    have |= dict(Ce=o.P * z, De=o.V * y, Q1=second[:n, :n], P12=dual[:n, n:])
    have |= dict(Q12=second[:n, n:], Q2=second[n:, n:], P2=dual[n:, n:])
    return have | run(stages.output_moments, have), (x, z, y)


def _unit(X, rounding=0.0):
    """Square roots of the variances in X, 1 for those that are zero or rounding."""
    return np.where((size := np.sqrt(X.diagonal())) > rounding, size, 1.0)


def _gradients(have, feedthrough):
    """Relative sizes of the four gradients, each against the terms it is a sum of.

    A term is what is left when the matrices that the others contain are zero.
    """
    names = dict(F="gradAe", D="gradBe", P="gradCe", V="gradDe")
    absent = {
        **dict.fromkeys("FD", [("P2",), ("P12", "Ae"), ("P12", "Be")]),
        **dict.fromkeys("PV", [("Ce", "De"), ("L", "De"), ("L", "Ce")]),
    }

    def size(name, zero=()):
        less = have | {one: np.zeros_like(have[one]) for one in zero}
        (one,) = run(stages.projection_gradient, less, names[name]).values()
        return np.linalg.norm(one)

    found = {k: _ratio(size(k), sum(size(k, one) for one in absent[k])) for k in names}
    return found if feedthrough else found | dict(V=None)


def _projection(have, T):
    """G, Gam, tau and Q of (3.8), (3.9) from the moments.

    Where z has states of next to no variance, or that no estimate uses, Q2 or P2
    leaves G or Gam open; there Gam is T, and G such that Gam G' = I.
    """
    found = run(stages.projection_factors, have, "G", "Gam", "tau", "Q")
    used, moved = _settled(have["P2"]), _settled(have["Q2"])
    if used is not None:
        found["Gam"] = T - used @ (have["P12"].T + have["P2"] @ T)
    if moved is not None:
        right = np.linalg.pinv(found["Gam"]).T
        found["G"] = right + moved @ (have["Q12"].T - have["Q2"] @ right)
    if used is not None or moved is not None:
        found["tau"] = found["G"].T @ found["Gam"]
        found["Q"] = symmetrise(have["Q1"] - found["G"].T @ have["Q12"].T)
    return found


def _settled(M):
    """Inverse of a Gramian in its strong directions; None when all of them are."""
    values, vectors = np.linalg.eigh(M)
    strong = values > WEAK * values.max(initial=0.0)
    if strong.all():
        return None
    half = vectors[:, strong] / np.sqrt(values[strong])
    return half @ half.T


def _equations(have):
    """Relative residuals of (3.14)-(3.17)."""
    found = run(stages.projection_equations, have)
    Qh, Ph = np.linalg.norm(have["Qh"]), np.linalg.norm(have["Ph"])
    sizes = dict(riccati=np.linalg.norm(have["Q1"]), estimate=Qh, adjoint=Ph)
    sizes["idempotent"] = np.linalg.norm(have["tau"])
    out = {k: _ratio(np.linalg.norm(found[k]), size) for k, size in sizes.items()}
    aligned = [np.linalg.norm(found[f"aligned_{name}"]) for name in "QP"]
    return out | dict(aligned=max(_ratio(aligned[0], Qh), _ratio(aligned[1], Ph)))


def _ratio(residual, size):
    return float(abs(residual) / size) if size > 0 else float(abs(residual))
