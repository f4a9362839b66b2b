"""Is an estimator the best of its order?  The necessary conditions, measured.

The moments come from the Lyapunov equations (4.4) and (4.5) of plant and observer
together, multiplicative noise included, and not from the block equations that a
design solves, so a fault of either shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import kernels
from ..arguments import expect
from ..certificate import certify, require_match, require_real
from ..errors import FIT, SAMPLE, CertificateError, DesignError
from ..kernels import run
from ..numeric import Matrices, Matrix, Vector
from ..numeric.balance import balanced
from ..numeric.covariances import covariance
from ..numeric.linalg import left_over, lyapunov, modes
from ..observer import Observer
from ..papers.haddad_bernstein import derivation as stages
from ..plant import Plant
from .disturbance import NO_INPUT, disturbed
from .error_covariance import mean_error
from .known_input import KnownInput, driven, known_input, no_tones, seen
from .mean_square import noise_at, require_mean_square_stable, second_moment

SILENT = 1e-14  # of what a number is the sum of: below it is rounding
WEAK = 1e-7  # of a Gramian's largest direction: below, rounding takes over


def conditions(
    observer: Observer, plant: Plant, weight: Matrix, feedthrough: bool
) -> dict[str, Any]:
    """The entries of `Optimality`, by name."""
    have, (x, z, _) = _moments(observer, plant, weight)
    gradients = _gradients(have, feedthrough)
    cost = float(np.trace(run(stages.projection_cost, have, "J")["J"]))
    have |= _projection(have, observer.T * x / z[:, None])
    have |= run(stages.projection_innovation, have)
    have |= run(stages.projection_scripts, have, "Qh", "Ph")
    gap = float(np.trace(run(stages.projection_trace, have, "J")["J"])) - cost
    power = np.trace(have["R"] @ have["L"] @ have["Q1"] @ have["L"].T)  # of L x
    return dict(
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


def _moments(
    observer: Observer, plant: Plant, weight: Matrix
) -> tuple[Matrices, tuple[Vector, Vector, Vector]]:
    """The moments (4.4), (4.5) in blocks, and the matrices that they belong to.

    Their names are the derivation's.  All signals are divided by their standard
    deviations, which are returned too, or by what they could be where those are zero.
    """
    o, n, now = observer, plant.n, plant.at(0)
    Q, R, S = now.covariances()
    have = dict(A=now.A, C=now.C, Ae=o.F, Be=o.D, W_1=Q, W_12=S, W_2=R)
    A, V = run(stages.both_systems, have, "A_tilde", "W_tilde").values()
    more = kernels.compiled(stages.both_systems, "A_tilde_1")
    pairs = [more(A1=A1, C1=C1, Be=o.D) for A1, C1 in plant.multiplicative]
    second = second_moment(A, [(one["A_tilde_1"], 0) for one in pairs], V)
    V1, V12, V2 = noise_at(plant, 0, second[:n, :n])
    Q1 = second[:n, :n]
    x = _unit(Q1, balanced(now.A, now.C, Q.diagonal(), R.diagonal())[0])
    seen = run(stages.output_moments, dict(C=now.C, Q1=Q1, V2=V2), "Qyy")["Qyy"]
    y = _unit(seen, np.abs(now.C) @ x)
    z = _unit(second[n:, n:], np.abs(o.T) @ x, SILENT)
    w = _unit(o.L @ Q1 @ o.L.T, np.abs(o.L) @ x)[:, None]
    whole = np.concatenate([x, z])
    P = np.where(np.abs(o.P * z) > SILENT * (np.abs(o.L) @ x)[:, None], o.P * z, 0.0)
    weight = weight * w * w.T
    shown = dict(Lq=left_over(o.L, o.V, now.C, x) / w, Ce=P / w, R=weight)
    (drive,) = run(stages.weight_of_both, shown, "R_tilde_0").values()
    A, second = A * whole / whole[:, None], second / whole / whole[:, None]
    dual = lyapunov(A.T, drive)  # the pairs act on P1 alone
    have = dict(A=A[:n, :n], C=now.C * x / y[:, None], L=o.L * x / w, R=weight)
    have |= dict(V1=V1 / x / x[:, None], V12=V12 / y / x[:, None])
    have |= dict(V2=V2 / y / y[:, None], Ae=A[n:, n:], Be=o.D * y / z[:, None])
    have |= dict(Ce=o.P * z / w, De=o.V * y / w, Q1=second[:n, :n], P12=dual[:n, n:])
    have |= dict(Q12=second[:n, n:], Q2=second[n:, n:], P2=dual[n:, n:])
    return have | run(stages.output_moments, have), (x, z, y)


def _unit(X: Matrix, other: Vector, rounding: float = 0.0) -> Vector:
    """Square roots of the variances in X; `other` where they are zero or rounding."""
    size = np.sqrt(np.maximum(X.diagonal(), 0))
    return np.where(size > rounding * other, size, np.where(other > 0, other, 1.0))


def _gradients(have: Matrices, feedthrough: bool) -> dict[str, float | None]:
    """Relative sizes of the four gradients, each against the terms it is a sum of.

    A term is what is left when the matrices that the others contain are zero.
    """
    names = dict(F="gradAe", D="gradBe", P="gradCe", V="gradDe")
    absent: dict[str, list[tuple[str, ...]]] = {
        **dict.fromkeys("FD", [("P2",), ("P12", "Ae"), ("P12", "Be")]),
        **dict.fromkeys("PV", [("Ce", "De"), ("L", "De"), ("L", "Ce")]),
    }

    def size(name: str, zero: tuple[str, ...] = ()) -> float:
        less = have | {one: np.zeros_like(have[one]) for one in zero}
        (one,) = run(stages.projection_gradient, less, names[name]).values()
        return _norm(one)

    free = names if feedthrough else "FDP"
    found = {k: _ratio(size(k), sum(size(k, one) for one in absent[k])) for k in free}
    return {"V": None} | found


def _projection(have: Matrices, T: Matrix) -> Matrices:
    """G, Gam, tau and Q of (3.8), (3.9) from the moments.

    Where z has states of next to no variance, or that no estimate uses, Q2 or P2
    leaves G or Gam open; there Gam is T, and G such that Gam G' = I.
    """
    found = run(stages.projection_factors, have, "G", "Gam")
    used, moved = _settled(have["P2"]), _settled(have["Q2"])
    if used is not None:
        given = have | dict(P2_plus=used, Gam_0=T)
        (found["Gam"],) = run(stages.open_factors, given, "Gam_open").values()
    if moved is not None:
        given = have | dict(Q2_plus=moved, G_0=np.linalg.pinv(found["Gam"]).T)
        (found["G"],) = run(stages.open_factors, given, "G_open").values()
    return found | run(stages.projection_product, have | found, "tau", "Q")


def _settled(M: Matrix) -> Matrix | None:
    """Inverse of a Gramian in its strong directions; None when all of them are."""
    values, vectors = np.linalg.eigh(M)
    strong = values > WEAK * values.max(initial=0.0)
    if strong.all():
        return None
    half = vectors[:, strong] / np.sqrt(values[strong])
    return half @ half.T


def _equations(have: Matrices) -> dict[str, float]:
    """Relative residuals of (3.14)-(3.17)."""
    found = run(stages.projection_equations, have)
    against = dict(riccati="Q1", estimate="Qh", adjoint="Ph", idempotent="tau")
    against |= dict(aligned_Q="Qh", aligned_P="Ph")
    out = {k: _ratio(_norm(found[k]), _norm(have[X])) for k, X in against.items()}
    return out | dict(aligned=max(out.pop("aligned_Q"), out.pop("aligned_P")))


def _norm(X: Matrix) -> float:
    return float(np.linalg.norm(X))


def _ratio(residual: float, size: float) -> float:
    return float(abs(residual) / size) if size > 0 else float(abs(residual))


STATIONARY_TOL = 1e-8  # of every relative residual of a design that is accepted


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
    mean : float or None
        The part of the cost that is a mean error, where the input is at a level.
    cost : float
        Steady E[(w^ - L x)' weight (w^ - L x)]; for u = 0 unless the plant has U.
    tau, Q, Qh, Ph : (n, n) ndarray
        The projection, the error covariance of the lifted estimate, and the theorem's
        two hatted matrices.
    G, Gam : (r, n) ndarray
        tau = G'Gam: z tracks Gam x, and G'z is the lifted estimate.
    note : str
        Says so where the known input disturbs the estimate and the plant has no U, so
        that the cost is that of u = 0; else empty.
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
    mean: float | None = None
    note: str = ""

    @property
    def residuals(self) -> dict[str, float]:
        """The relative residuals by name, those that apply."""
        found = ((name, getattr(self, name)) for name in _MEANING)
        return dict(pair for pair in found if pair[1] is not None)

    @property
    def worst(self) -> float:
        """The largest relative residual."""
        return max(self.residuals.values())

    def require(self, tol: float = STATIONARY_TOL) -> Optimality:
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
    "mean": "the absence of a mean error at the level of the known input",
}


def optimality(
    observer: Observer,
    plant: Plant,
    *,
    weight: ArrayLike | None = None,
    feedthrough: bool | None = None,
) -> Optimality:
    r"""Measure how far an estimator is from the least error of its order.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9, 0.1], [0.2, 0.7]], None, [[0, 1]], dt=1.0,
    ...                  Q=[[0.1, 0], [0, 0]], R=[[1]])
    >>> lb.optimality(lb.kalman_filter(plant), plant).worst < 1e-12
    True

    The cost is that of (3.5), E[(w^ - L x)' weight (w^ - L x)] in the steady state,
    of the plant without its known input unless its U says what that is like.  The
    necessary conditions are that its four gradients vanish and,
    equivalently, the optimal projection equations (3.14)-(3.17).

    Parameters
    ----------
    observer : Observer
        Constant and stable; of any method.
    plant : Plant
        Discrete, constant and mean-square stable, with Q and R; U, if it is given, a
        level, or a model that decays.
    weight : (q, q) array_like, optional
        Positive semi-definite; default the identity.
    feedthrough : bool, optional
        Whether V (and with U W) is free; default whether it is not zero.

    Returns
    -------
    Optimality
        With a varying U its matrices are those of model and plant together.

    Raises
    ------
    DesignError
        If the plant or the observer is not stable, or has no such cost.

    References
    ----------
    Haddad and Bernstein (1987), equations (3.14)-(3.18), (4.4)-(4.11);
    papers/haddad_bernstein/derivation/gradients.py, equations.py.
    """
    expect(observer=observer, plant=plant)
    weight = np.eye(len(observer.L)) if weight is None else weight
    weight = covariance("weight", weight, len(observer.L))
    given = None if plant.U is None or not plant.m else known_input(plant)
    require_match(observer, plant)
    if given is not None and not given.still and not given.tones:
        model = given.varying
        observer, plant = seen(observer, model), driven(plant, model)
    feedthrough = bool(observer.V.any()) if feedthrough is None else feedthrough
    _require(observer, plant, feedthrough)
    found: dict[str, Any] = conditions(observer, plant, weight, feedthrough)
    if plant.U is None and disturbed(observer, plant, certify(observer, plant)):
        found["note"] = NO_INPUT
    if given is not None and (given.still or given.tones):
        mean = _mean_cost(observer, plant, weight, given)
        found["cost"] += mean
        found["mean"] = mean / found["cost"] if mean else 0.0
    return Optimality(**found)


def _mean_cost(
    observer: Observer, plant: Plant, weight: Matrix, given: KnownInput
) -> float:
    """What the mean error at the level of the known input costs."""
    if not given.still:
        raise no_tones(given)
    e = mean_error(observer, plant)
    return float(e @ weight @ e)


def _require(observer: Observer, plant: Plant, feedthrough: bool) -> None:
    require_match(observer, plant)
    require_real("optimality", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        raise DesignError(
            "optimality is for discrete time and needs both noise covariances Q and "
            f"R; {FIT if plant.dt else SAMPLE}"
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
