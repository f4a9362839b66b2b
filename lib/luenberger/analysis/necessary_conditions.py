"""What an estimator leaves of the conditions of least error at its order.

Everything here is by the names of the derivation
(papers/haddad_bernstein/derivation/gradients.py, equations.py).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import kernels
from ..kernels import run
from ..numeric import Matrices, Matrix, Vector
from ..numeric.balance import balanced
from ..numeric.linalg import left_over, lyapunov
from ..observer import Observer
from ..papers.haddad_bernstein import derivation as stages
from ..plant import Plant
from .mean_square import noise_at, second_moment

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
