"""One step of a filter over a record, as one stage list that compiled loops run.

`gain_step` and `estimate_step` in one, with the covariance written for
speed: with Z = Omega - K C Omega the form Y Omega Y' + K R K' is
Z - (Z C' - K R) K', which holds for any gain, so a wrong gain is no more amplified
than before, and costs n^2 p multiplications where the other costs n^3.  Outputs that
did not arrive keep their place: rows of zeros in C, a unit variance in R.

Source: Leondes and Novak (1974), (27), (33), (43); the rest is our own.
"""

from dataclasses import replace
from functools import cache

import sympy as sp

from ....symbolic import (
    Algebra,
    Derivation,
    Identity,
    MatrixSymbol,
    Solve,
    Stage,
    claims,
    matrices,
    named,
)
from .best_coordinates import gain_step
from .estimate import estimate_step
from .letters import SOURCE as PAPER
from .letters import m, n, p, r, squares
from .quadratic import joseph

pa, q = sp.symbols("p_a q", integer=True, nonnegative=True)


@cache
def filter_step():
    """Sigma, x, rho at i and y at i + 1 to the gain, Sigma, x, rho at i + 1.

    As and Q are those after decorrelation; without S, As is A.
    """
    A, As, Q, Sigma, Omega, Sigma_next = squares("A As Q Sigma Omega Sigma_next")
    (C,), (B,), (E,) = matrices("C", p, n), matrices("B", n, m), matrices("E", p, m)
    (Z,) = squares("Z")
    R, M = squares("R M", p)
    J, Gamma, N, Kmv, K = matrices("J Gamma N Kmv K", n, p)
    x, x_minus, x_next = matrices("x x_minus x_next", n, 1)
    u, u_next = matrices("u u_next", m, 1)
    y, rho, known, innovation, rho_next = matrices(
        "y rho known innovation rho_next", p, 1
    )
    stages = (
        Stage(Omega, As * Sigma * As.T + Q, "(44)", symmetric=True),
        Stage(N, Omega * C.T),
        Stage(M, C * N + R, "(33)", symmetric=True),
        Stage(Kmv, Solve(N, M), "(33)"),
        Stage(K, Kmv + Gamma - Gamma * (C * Kmv)),
        Stage(Z, Omega - K * N.T),
        Stage(Sigma_next, Z - (Z * C.T - K * R) * K.T, "(27)", symmetric=True),
        Stage(x_minus, A * x + B * u + J * rho, "(43)"),
        Stage(known, y - E * u_next),
        Stage(innovation, known - C * x_minus, "(43)"),
        Stage(x_next, x_minus + K * innovation, "(43)"),
        Stage(rho_next, known - C * x_next),
    )
    given = (A, As, Q, B, J, C, R, E, Gamma, Sigma, x, rho, u, y, u_next)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=_same_step(found))


def _same_step(derivation):
    """The stages are those of `gain_step` and `estimate_step`, whatever the gain."""
    s = named(derivation)
    algebra = Algebra([s[k] for k in ("Q", "R", "Sigma", "Omega", "M")])
    kept = derivation.unfolded(keep=("Omega", "M", "K"))
    inner = derivation.unfolded(keep=("Omega", "M"))
    paper, whole = gain_step().unfolded(keep=("Omega", "M")), derivation.unfolded()
    estimate = estimate_step().unfolded()
    moved = derivation.unfolded(keep=("K",))
    K, C, R, Omega = (s[k] for k in ("K", "C", "R", "Omega"))
    return claims(
        algebra,
        {
            "(44) Omega is that of gain_step for As": (
                whole["Omega"],
                gain_step().unfolded()["Omega"].xreplace({s["A"]: s["As"]}),
            ),
            "(33) M is that of gain_step": (inner["M"], paper["M"]),
            "(33) Kmv is that of gain_step": (inner["Kmv"], paper["Kmv"]),
            "K is that of gain_step": (inner["K"], paper["K"]),
            "(27) for any K, Sigma_next = Y Omega Y' + K R K'": (
                kept["Sigma_next"],
                joseph(K, C, Omega, R),
            ),
            "(43) x_next is that of estimate_step": (
                moved["x_next"],
                estimate["x_next"],
            ),
            "rho_next is that of estimate_step": (
                moved["rho_next"],
                estimate["rho_next"],
            ),
        },
    )


@cache
def padded():
    """The matrices of the outputs that arrived, each in the place of its output.

    Pick (pa, p) holds rows of the identity, y_seen = Pick y.
    """
    (Pick,) = matrices("Pick", pa, p)
    (C_seen,), (E_seen,) = matrices("C_seen", pa, n), matrices("E_seen", pa, m)
    (R_seen,) = squares("R_seen", pa)
    Gamma_seen, J_seen = matrices("Gamma_seen J_seen", n, pa)
    (C,), (E,), (R,) = matrices("C", p, n), matrices("E", p, m), squares("R", p)
    Gamma, J = matrices("Gamma J", n, p)
    stages = (
        Stage(C, Pick.T * C_seen),
        Stage(E, Pick.T * E_seen),
        Stage(R, Pick.T * R_seen * Pick + Identity(p) - Pick.T * Pick, symmetric=True),
        Stage(Gamma, Gamma_seen * Pick),
        Stage(J, J_seen * Pick),
    )
    given = (Pick, C_seen, E_seen, R_seen, Gamma_seen, J_seen)
    found = Derivation(given, stages, source="our own")
    return replace(found, steps=_same_with_fewer_outputs(found))


def _same_with_fewer_outputs(derivation):
    """`filter_step` of the padded matrices is that of the outputs that arrived."""
    s, f = named(derivation), derivation.unfolded()
    Pick, Ca, Ea, Ra, Ga, Ja = derivation.given
    Omega, Ma = MatrixSymbol("Omega", n, n), MatrixSymbol("M_a", pa, pa)
    x, u = MatrixSymbol("x", n, 1), MatrixSymbol("u", m, 1)
    ya, Ka = MatrixSymbol("y_a", pa, 1), MatrixSymbol("K_a", n, pa)
    algebra = Algebra(
        [s["R_seen"], Omega, Ma],
        [(Pick * Pick.T, Identity(pa)), (Ra, Ma - Ca * Omega * Ca.T)],
    )
    C, R, E = f["C"], f["R"], f["E"]
    M, Kmv = C * Omega * C.T + R, Omega * Ca.T * Ma.I * Pick
    rest = Identity(p) - Pick.T * Pick
    gap = Pick.T * ya - E * u - C * x
    shorter = Omega * Ca.T * Ma.I
    return claims(
        algebra,
        {
            "M is that of the outputs that arrived, and 1": (
                M,
                Pick.T * Ma * Pick + rest,
            ),
            "its inverse": (M * (Pick.T * Ma.I * Pick + rest), Identity(p)),
            "(33) Kmv = Kmv_a Pick: Kmv M = Omega C'": (Kmv * M, Omega * C.T),
            "K = K_a Pick": (
                Kmv + f["Gamma"] - f["Gamma"] * C * Kmv,
                (shorter + Ga - Ga * Ca * shorter) * Pick,
            ),
            "(27) the covariance is the same": (
                joseph(Ka * Pick, C, Omega, R),
                joseph(Ka, Ca, Omega, Ra),
            ),
            "(43) the correction is the same": (
                Ka * Pick * gap,
                Ka * (ya - Ea * u - Ca * x),
            ),
            "J rho is the same": (f["J"] * gap, Ja * (ya - Ea * u - Ca * x)),
        },
    )


@cache
def observer_step():
    """One step of any observer, z+ = F z + G u + D y and w^ = P z + V y + W u."""
    F, G, D = (matrices(k, r, d)[0] for k, d in (("F", r), ("G", m), ("D", p)))
    P, V, W = (matrices(k, q, d)[0] for k, d in (("P", r), ("V", p), ("W", m)))
    z, z_next = matrices("z z_next", r, 1)
    (u,), (y,), (w_hat,) = (
        matrices("u", m, 1),
        matrices("y", p, 1),
        matrices("w_hat", q, 1),
    )
    stages = (
        Stage(w_hat, P * z + V * y + W * u),
        Stage(z_next, F * z + G * u + D * y, "(9)"),
    )
    found = Derivation((F, G, D, P, V, W, z, u, y), stages, source=PAPER)
    return replace(found, steps=_error_is_free(found))


def _error_is_free(derivation):
    """Without noise the observer's error follows F alone, and shows through P."""
    s, f = named(derivation), derivation.unfolded()
    F, G, D, P, V, W, z, u, _ = derivation.given
    A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, m)
    C, E = MatrixSymbol("C", p, n), MatrixSymbol("E", p, m)
    T, T_next, L = (
        MatrixSymbol(k, d, n) for k, d in (("T", r), ("T_next", r), ("L", q))
    )
    x = MatrixSymbol("x", n, 1)
    algebra = Algebra(
        [],
        [
            (s["y"], C * x + E * u),
            (T_next * A, F * T + D * C),
            (T_next * B, G + D * E),
            (P * T, L - V * C),
            (W, -V * E),
        ],
    )
    return claims(
        algebra,
        {
            "(11) z+ - T+ x+ = F (z - T x)": (
                f["z_next"] - T_next * (A * x + B * u),
                F * (z - T * x),
            ),
            "w^ - L x = P (z - T x)": (f["w_hat"] - L * x, P * (z - T * x)),
        },
    )
