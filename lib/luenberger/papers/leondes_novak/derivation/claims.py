"""What is claimed of the stage lists, and the relations under which it holds.

A stage list is unfolded into its formulas, so a damaged stage makes a claim fail.
The inverse in the gain is harmless because M is kept as a symbol and its definition
is solved for R; no other inverse occurs.

Source: Leondes and Novak (1974); our own where `stages` says so.
"""

import sympy as sp
from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Claim,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)
from ....symbolic.derivation import named


def joseph(K, C, Omega, R):
    """Covariance of (I - K C) e + K v, for any gain."""
    Y = Identity(K.shape[0]) - K * C
    return Y * Omega * Y.T + K * R * K.T


def estimate_step(derivation):
    s, f = named(derivation), derivation.unfolded()
    A, B, C, E, J, K = (s[k] for k in "A B C E J K".split())
    n, p = K.shape
    Kmv, Gamma = MatrixSymbol("Kmv", n, p), MatrixSymbol("Gamma", n, p)
    m1 = sp.Symbol("m1", integer=True, nonnegative=True)
    chosen = MatrixSymbol("Select", m1, p)  # rows of the identity: y1 = Select y
    truth, truth_next, w = (MatrixSymbol(k, n, 1) for k in ("xt", "xt_next", "w"))
    v, v_next = MatrixSymbol("v", p, 1), MatrixSymbol("v_next", p, 1)
    y_now = C * truth + E * s["u"] + v
    algebra = Algebra(
        [],
        [
            (truth_next, A * truth + B * s["u"] + J * v + w),
            (s["y"], C * truth_next + E * s["u_next"] + v_next),
            (s["rho"], y_now - E * s["u"] - C * s["x"]),
        ],
    )
    matched = Algebra(
        [],
        [(K, Kmv + Gamma - Gamma * C * Kmv), (chosen * C * Gamma, chosen)],
    )
    before = A * s["x"] + B * s["u"] + J * s["rho"]
    after = before + K * (s["y"] - E * s["u_next"] - C * before)
    Y = Identity(n) - K * C
    return claims(
        algebra,
        {
            "(43) x_next = x_minus + K (y - E u_next - C x_minus)": (
                f["x_next"],
                after,
            ),
            "(43) x_minus = A x + B u + J rho": (f["x_minus"], before),
            "(43) innovation = y - E u_next - C x_minus": (
                f["innovation"],
                s["y"] - E * s["u_next"] - C * f["x_minus"],
            ),
            "rho_next = y - E u_next - C x_next": (
                f["rho_next"],
                s["y"] - E * s["u_next"] - C * f["x_next"],
            ),
            "error: e+ = (I - K C)((A - J C) e - w) + K v+": (
                f["x_next"] - truth_next,
                Y * ((A - J * C) * (s["x"] - truth) - w) + K * v_next,
            ),
        },
    ) | claims(
        matched,
        {
            "accurate outputs are matched: C1 x_next = y1": (
                chosen * f["rho_next"],
                ZeroMatrix(m1, 1),
            )
        },
    )


def step_differential(derivation, gain):
    s, f, g = named(derivation), derivation.unfolded(keep=("dK",)), named(gain)
    unfolded = gain.unfolded(keep=("Omega", "M"))
    C, R, M, Gamma, dOmega = (s[k] for k in ("C", "R", "M", "Gamma", "dOmega"))
    Omega, dM, one = g["Omega"], MatrixSymbol("dM", *M.shape), Identity(Gamma.shape[0])
    algebra = Algebra(
        [R, M, Omega, dOmega, dM],
        [
            (R, M - C * Omega * C.T),
            (dM, C * dOmega * C.T),
            (s["Kmv"], unfolded["Kmv"]),
            (s["Y"], unfolded["Y"]),
        ],
    )
    step = {Omega: dOmega, M: dM}
    dK = f["dK"]
    return claims(
        algebra,
        {
            "dK is the differential of the gain": (
                dK,
                algebra.differential(unfolded["K"], step),
            ),
            "dK = (I - K C) dOmega C' M^-1": (dK * M, s["Y"] * dOmega * C.T),
            "dSigma is the differential of Sigma_next": (
                f["dSigma"].xreplace({s["dK"]: dK}),
                algebra.differential(unfolded["Sigma_next"], step),
            ),
            "dSigma is symmetric": (
                f["dSigma"],
                f["dSigma"].T,
            ),
            "(I - K C) Omega C' - K R = -Gamma R": (
                s["Y"] * Omega * C.T - unfolded["K"] * R,
                -Gamma * R,
            ),
            "(13) Y = (I - Gamma C)(I - Kmv C)": (
                s["Y"],
                (one - Gamma * C) * (one - s["Kmv"] * C),
            ),
        },
    )


def steady_gradient(derivation):
    s, f = named(derivation), derivation.unfolded()
    K, M, Omega, C, Lambda = (s[k] for k in ("K", "M", "Omega", "C", "Lambda"))
    n, p = K.shape
    A, Q, Sigma, W = (MatrixSymbol(k, n, n) for k in ("A", "Q", "Sigma", "W"))
    R, Kmv, Gamma = (
        MatrixSymbol(k, *d)
        for k, d in (("R", (p, p)), ("Kmv", (n, p)), ("Gamma", (n, p)))
    )
    g = sp.Symbol("g", integer=True, nonnegative=True)
    N = MatrixSymbol("N", n, g)
    algebra = Algebra([M, Omega, Lambda, Q, Sigma, W, R])
    known = algebra.with_relations((R, M - C * Omega * C.T))
    solved = known.with_relations(
        (Kmv * M, Omega * C.T),
        (K, Kmv + Gamma - Gamma * C * Kmv),
        (N.T * Lambda * Gamma, ZeroMatrix(g, p)),
    )
    closed = joseph(K, C, A * Sigma * A.T + Q, R)
    lagrangian = Trace(W * Sigma) + Trace(Lambda * (closed - Sigma))
    Phi = (Identity(n) - K * C) * A
    names = {
        "adjoint": "d/dSigma of tr(W Sigma) + tr(Lambda (closed loop - Sigma)): "
        "W + Phi' Lambda Phi - Lambda, Phi = (I - K C) A",
        "gradient": "d/dK of the same is Gradient",
        "weight": "N' Gradient = 0 at the step-wise gain with weight Lambda",
    }
    in_K = known.gradient(Trace(Lambda * joseph(K, C, Omega, R)), K)
    return claims(
        algebra,
        {
            names["adjoint"]: (
                algebra.gradient(lagrangian, Sigma),
                W + Phi.T * Lambda * Phi - Lambda,
            )
        },
    ) | {
        names["gradient"]: Claim(f["Gradient"], in_K, known),
        names["weight"]: Claim(N.T * f["Gradient"], ZeroMatrix(g, p), solved),
    }


def observer(derivation):
    s, f = named(derivation), derivation.unfolded()
    As, B, J, C, E = (s[k] for k in ("As", "B", "J", "C", "E"))
    Phat, That, K, T_next = (s[k] for k in ("Phat", "That", "K", "T_next"))
    n, p = K.shape
    Kmv, Gamma = MatrixSymbol("Kmv", n, p), MatrixSymbol("Gamma", n, p)
    algebra = Algebra(
        [],
        [
            (Phat * That, Identity(n) - Gamma * C),
            (Gamma * C * Gamma, Gamma),
            (K, Kmv + Gamma - Gamma * C * Kmv),
        ],
    )
    T, F, D, G, W = (f[k] for k in "TFDGW")
    return claims(
        algebra,
        {
            "(13) P T + V C = I": (Phat * T + K * C, Identity(n)),
            "(9) T+ A = F T + D C": (T_next * (As + J * C), F * T + D * C),
            "(10) T+ B = G + D E": (T_next * B, G + D * E),
            "W + V E = 0": (W, -K * E),
            "(25) T = That (I - K C)": (T, That * (Identity(n) - K * C)),
        },
    )


def decorrelation(derivation):
    s, f = named(derivation), derivation.unfolded()
    A, C, Q, S, J = (s[k] for k in ("A", "C", "Q", "S", "J"))
    n, p = S.shape
    R = MatrixSymbol("R", p, p)
    x, w, v = (MatrixSymbol(k, d, 1) for k, d in (("x", n), ("w", n), ("v", p)))
    algebra = Algebra([Q, R], [(S, J * R)])
    take = BlockMatrix([[Identity(n), -J]])  # w - J v
    joint = BlockMatrix([[Q, S], [S.T, R]])
    show = BlockMatrix([[ZeroMatrix(n, p)], [Identity(p)]])
    return claims(
        algebra,
        {
            "Qs = cov(w - J v)": (f["Qs"], take * joint * take.T),
            "w - J v and v are uncorrelated": (take * joint * show, ZeroMatrix(n, p)),
            "the same plant: A x + w = As x + J (C x + v) + (w - J v)": (
                A * x + w,
                f["As"] * x + J * (C * x + v) + (w - J * v),
            ),
            "Qs is symmetric": (f["Qs"], f["Qs"].T),
        },
    )


def error_recursion(derivation):
    s, f = named(derivation), derivation.unfolded()
    F, D, T_next, P, V = (s[k] for k in ("F", "D", "T_next", "P", "V"))
    Q, R, S, X = (s[k] for k in ("Q", "R", "S", "X"))
    (n, p), r = S.shape, X.shape[0]
    algebra = Algebra([Q, R, X])
    terms = BlockMatrix([[F, D, -T_next]])
    joint = BlockMatrix(
        [
            [X, ZeroMatrix(r, p), ZeroMatrix(r, n)],
            [ZeroMatrix(p, r), R, S.T],
            [ZeroMatrix(n, r), S, Q],
        ]
    )
    error = BlockMatrix([[P, V]])
    apart = BlockMatrix([[X, ZeroMatrix(r, p)], [ZeroMatrix(p, r), R]])
    return claims(
        algebra,
        {
            "(11) X_next = cov(F eps + D v - T+ w)": (
                f["X_next"],
                terms * joint * terms.T,
            ),
            "(26) Sigma = cov(P eps + V v)": (f["Sigma"], error * apart * error.T),
        },
    )
