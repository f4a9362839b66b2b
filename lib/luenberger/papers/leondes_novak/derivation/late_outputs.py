"""Outputs that become known later than they were measured.

A reading that has not arrived is an unknown number like the state, so it is estimated
beside the state.  This page predicts both, and takes new readings; `late_arrivals` uses
what has arrived.

Source: our own.  Bar-Shalom, Update with out-of-sequence measurements in tracking:
exact solution, IEEE Trans. Aerospace and Electronic Systems 38 (2002), is related.
"""

from functools import cache

from sympy import symbols

from ....symbolic import Derivation, Expect, Line, Stage, ZeroMatrix
from .correlated_noise import is_As
from .estimate import is_e, is_minus, plant, rho, running, truth, truth_next, x_minus
from .letters import *

q = symbols("q", integer=True, nonnegative=True)
late = running.here(
    y="readings of an instant",
    N="covariance of that and what is expected of the new readings",
)
chain, define, moment = late.chain, late.define, late.moment
y_hat = late("y_hat", p, 1, "the same where they arrived, what is expected elsewhere")
f = late("f", p, 1, "error of `y_hat`, zero where readings arrived")
h = late("h", q, 1, "error of what is expected of older readings")
X_f = late("X_f", n, p, "covariance of `e` and `f`")
X_h = late("X_h", n, q, "covariance of `e` and `h`")
Z_f = late("Z_f", p, p, "covariance of `f`", symmetric=True)
Z_fh = late("Z_fh", p, q, "covariance of `f` and `h`")
L_e = late("L_e", n, n, "covariance of the error of the prediction and `e`")
X_f_next = late("X_f_next", n, p, "covariance of the error of the prediction and `f`")
X_h_next = late("X_h_next", n, q, "covariance of the error of the prediction and `h`")
y_new = late("y_next", p, 1, "the new readings")
y_minus = late("y_minus", p, 1, "what is expected of them")
g = late("g", p, 1, "error of that")
N_h = late("N_h", q, p, "covariance of `h` and `g`")

AHEAD = (
    """Of the readings of an instant some have arrived, some will arrive later, some
    never will. Where one has not arrived, `y_hat` has what is expected of it. What the
    estimate leaves of `y_hat` takes the place of the residual in the prediction.""",
    plant,
    is_y := define(y, C * truth + E * u + v, "2"),
    is_rho := define(rho, y_hat - E * u - C * x),
    is_f := define(f, y_hat - y),
    is_e,
    is_As,
    is_minus,
    before := chain(
        "43",
        "the error of a prediction when readings are awaited",
        x_minus - truth_next,
        Line(A * x + B * u + J * rho - truth_next, by=(is_minus,)),
        Line(
            A * x + J * (y_hat - E * u - C * x) - A * truth - J * v - w,
            by=(is_rho, plant),
        ),
        Line(
            A * x + J * (f + C * truth + v - C * x) - A * truth - J * v - w,
            by=(is_f, is_y),
        ),
        Line((A - J * C) * (x - truth) + J * f - w, why="collect the errors"),
        Line(As * e + J * f - w, by=(is_As, is_e)),
    ),
    """All of these errors are correlated, and the covariances move on with them. The
    noise that is left is independent of what was measured before.""",
    is_Sigma := moment(e * e.T, Sigma, "27"),
    is_X_f := moment(e * f.T, X_f),
    is_X_h := moment(e * h.T, X_h),
    is_Z_f := moment(f * f.T, Z_f),
    is_Z_fh := moment(f * h.T, Z_fh),
    is_Q := moment(w * w.T, Qs, "4"),
    apart := moment(e * w.T, ZeroMatrix(n, n)),
    apart_f := moment(f * w.T, ZeroMatrix(p, n)),
    apart_h := moment(h * w.T, ZeroMatrix(q, n)),
    is_X_f_next := define(X_f_next, As * X_f + J * Z_f),
    chain(
        "",
        "a prediction and the last readings",
        (As * e + J * f - w) * f.T,
        Expect(As * X_f + J * Z_f, moments=(is_X_f, is_Z_f, apart_f)),
        Line(X_f_next, by=(is_X_f_next,)),
    ),
    is_X_h_next := define(X_h_next, As * X_h + J * Z_fh),
    chain(
        "",
        "a prediction and older readings",
        (As * e + J * f - w) * h.T,
        Expect(As * X_h + J * Z_fh, moments=(is_X_h, is_Z_fh, apart_h)),
        Line(X_h_next, by=(is_X_h_next,)),
    ),
    is_L_e := define(L_e, As * Sigma + J * X_f.T),
    is_Omega := define(Omega, L_e * As.T + X_f_next * J.T + Qs, "44"),
    chain(
        "44",
        "the covariance of a prediction when readings are awaited",
        (As * e + J * f - w) * (As * e + J * f - w).T,
        Expect(
            As * Sigma * As.T + As * X_f * J.T + J * X_f.T * As.T + J * Z_f * J.T + Qs,
            moments=(is_Sigma, is_X_f, is_Z_f, is_Q, apart, apart_f),
        ),
        Line(
            (As * Sigma + J * X_f.T) * As.T + (As * X_f + J * Z_f) * J.T + Qs,
            why="factor",
        ),
        Line(L_e * As.T + X_f_next * J.T + Qs, by=(is_L_e, is_X_f_next)),
        Line(Omega, by=(is_Omega,)),
    ),
)

FRESH = (
    """Now the new readings are taken, whether they arrive or not. What is expected of
    them errs by `g`, which is correlated with all the rest. What is held by now is
    `h`.""",
    is_y_new := define(y_new, C * truth_next + E * u_next + v_next, "2"),
    is_y_minus := define(y_minus, C * x_minus + E * u_next),
    is_e_m := define(e_minus, x_minus - truth_next),
    is_g := define(g, y_minus - y_new),
    errs := chain(
        "43",
        "the error of what is expected of new readings",
        g,
        Line(y_minus - y_new, by=(is_g,)),
        Line(C * (x_minus - truth_next) - v_next, by=(is_y_minus, is_y_new)),
        Line(C * e_minus - v_next, by=(is_e_m,)),
    ),
    is_e_minus := moment(e_minus * e_minus.T, Omega),
    is_X_h_now := moment(e_minus * h.T, X_h),
    is_R := moment(v_next * v_next.T, R, "4"),
    fresh := moment(e_minus * v_next.T, ZeroMatrix(n, p)),
    fresh_h := moment(h * v_next.T, ZeroMatrix(q, p)),
    is_N := define(N, Omega * C.T, "33"),
    chain(
        "33",
        "a prediction and the new readings",
        e_minus * g.T,
        Line(e_minus * (C * e_minus - v_next).T, by=(errs,)),
        Expect(Omega * C.T, moments=(is_e_minus, fresh)),
        Line(N, by=(is_N,)),
    ),
    is_N_h := define(N_h, X_h.T * C.T),
    chain(
        "",
        "older readings and the new ones",
        h * g.T,
        Line(h * (C * e_minus - v_next).T, by=(errs,)),
        Expect(X_h.T * C.T, moments=(is_X_h_now, fresh_h)),
        Line(N_h, by=(is_N_h,)),
    ),
    is_M := define(M, C * N + R, "33"),
    chain(
        "33",
        "the new readings among themselves",
        g * g.T,
        Line((C * e_minus - v_next) * (C * e_minus - v_next).T, by=(errs,)),
        Expect(C * Omega * C.T + R, moments=(is_e_minus, is_R, fresh)),
        Line(C * N + R, by=(is_N,)),
        Line(M, by=(is_M,)),
    ),
)


@cache
def late_ahead():
    """What is predicted while readings of the last instant and older ones are awaited.

    Columns of X_f and Z_f, and rows of Z_fh, are zero for readings that arrived.
    """
    return Derivation(
        (A, As, B, J, C, E, Qs, Sigma, X_f, X_h, Z_f, Z_fh, x, u, y_hat),
        (
            Stage(L_e, is_L_e.right, by=(is_L_e,)),
            Stage(X_f_next, is_X_f_next.right, by=(is_X_f_next,)),
            Stage(X_h_next, is_X_h_next.right, by=(is_X_h_next,)),
            Stage(Omega, is_Omega.right, "(44)", symmetric=True, by=(is_Omega,)),
            Stage(rho, is_rho.right, by=(is_rho,)),
            Stage(x_minus, is_minus.right, "(43)", by=(is_minus,)),
        ),
        source="our own",
        letters=late,
        says="what is predicted while readings are awaited",
    )


@cache
def late_fresh():
    """What the new readings have to do with the prediction and with what is held."""
    return Derivation(
        (C, E, R, Omega, X_h, x_minus, u_next),
        (
            Stage(y_minus, is_y_minus.right, by=(is_y_minus,)),
            Stage(N, is_N.right, "(33)", by=(is_N,)),
            Stage(N_h, is_N_h.right, by=(is_N_h,)),
            Stage(M, is_M.right, "(33)", symmetric=True, by=(is_M,)),
        ),
        source="our own",
        letters=late,
        says="new readings beside what is held",
    )


@cache
def derive():
    """The page."""
    page = (*AHEAD, late_ahead(), *FRESH, late_fresh())
    return Derivation(page=page, letters=late, source="our own")
