"""Outputs that become known later than they were measured.

A reading that has not arrived is an unknown number like the state, so it is estimated
beside the state.  When it arrives, its estimate is found to be wrong by a known number,
and all that is correlated with it is corrected.

Source: our own.  Bar-Shalom, Update with out-of-sequence measurements in tracking:
exact solution, IEEE Trans. Aerospace and Electronic Systems 38 (2002), is related.
"""

from functools import cache

from sympy import symbols

from ....symbolic import AtLeast, Derivation, Expect, Line, Solve, Stage, ZeroMatrix
from .correlated_noise import is_As
from .estimate import is_e, is_minus, plant, rho, running, truth, truth_next, x_minus
from .letters import *

q, k, s = symbols("q k s", integer=True, nonnegative=True)
late = running.here(
    y="readings, less what the input does to them",
    N="covariance of that and what is expected of the new readings",
    K="any gain for what has arrived",
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
g = late("g", p, 1, "error of what is expected of the new readings")
N_h = late("N_h", q, p, "covariance of `h` and `g`")
t = late("t", k, 1, "readings that have just arrived")
t_hat = late("t_hat", k, 1, "what was expected of them")
x_r = late("xi", s, 1, "all that is not known yet: the state, readings to come")
x_hat_r = late("xi_hat", s, 1, "what is expected of it")
x_hat_r_next = late("xi_hat_next", s, 1, "the same once readings have arrived")
d_t = late("d_t", k, 1, "error of `t_hat`")
d_r = late("d_r", s, 1, "error of `xi_hat`")
P_rr = late("P_rr", s, s, "covariance of `d_r`", symmetric=True)
P_rt = late("P_rt", s, k, "covariance of `d_r` and `d_t`")
P_tt = late("P_tt", k, k, "covariance of `d_t`", symmetric=True)
P_next = late("P_next", s, s, "the same once readings have arrived", symmetric=True)
K_t = late("K_t", s, k, "gain of least covariance")
K_r = late("K_r", s, k, "any gain")
L_t = late("L_t", k, k, "a root of `P_tt`")

AHEAD = (
    """Of the readings of an instant some have arrived, some will arrive later, some
    never will. Where one has not arrived, `y_hat` has what is expected of it. What the
    estimate leaves of `y_hat` takes the place of the residual in the prediction.""",
    plant,
    is_y := define(y, C * truth + v, "2"),
    is_rho := define(rho, y_hat - C * x),
    is_f := define(f, y_hat - y),
    is_e,
    is_As,
    is_minus,
    before := chain(
        "43",
        "the error of a prediction when readings are awaited",
        x_minus - truth_next,
        Line(A * x + B * u + J * rho - truth_next, by=(is_minus,)),
        Line(A * x + J * (y_hat - C * x) - A * truth - J * v - w, by=(is_rho, plant)),
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
    is_g := define(g, C * e_minus - v_next),
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
        Line(e_minus * (C * e_minus - v_next).T, by=(is_g,)),
        Expect(Omega * C.T, moments=(is_e_minus, fresh)),
        Line(N, by=(is_N,)),
    ),
    is_N_h := define(N_h, X_h.T * C.T),
    chain(
        "",
        "older readings and the new ones",
        h * g.T,
        Line(h * (C * e_minus - v_next).T, by=(is_g,)),
        Expect(X_h.T * C.T, moments=(is_X_h_now, fresh_h)),
        Line(N_h, by=(is_N_h,)),
    ),
    is_M := define(M, C * N + R, "33"),
    chain(
        "33",
        "the new readings among themselves",
        g * g.T,
        Line((C * e_minus - v_next) * (C * e_minus - v_next).T, by=(is_g,)),
        Expect(C * Omega * C.T + R, moments=(is_e_minus, is_R, fresh)),
        Line(C * N + R, by=(is_N,)),
        Line(M, by=(is_M,)),
    ),
)

KNOWN = (
    """Some readings arrive at this instant, of this instant or of earlier ones. What
    was expected of them was wrong by a number that is known now. It corrects the state
    and the readings that are still to come.""",
    is_d_t := define(d_t, t_hat - t),
    is_d_r := define(d_r, x_hat_r - x_r),
    corrects := define(x_hat_r_next, x_hat_r + K_t * (t - t_hat), "43"),
    chain(
        "",
        "the error once readings have arrived",
        x_hat_r_next - x_r,
        Line(x_hat_r + K_t * (t - t_hat) - x_r, by=(corrects,)),
        Line(d_r - K_t * d_t, by=(is_d_r, is_d_t)),
    ),
    is_P_rr := moment(d_r * d_r.T, P_rr),
    is_P_rt := moment(d_r * d_t.T, P_rt),
    is_P_tt := moment(d_t * d_t.T, P_tt),
    is_K_t := define(K_t * P_tt, P_rt),
    square := chain(
        "27",
        "the covariance is a quadratic in the gain of what arrived",
        (d_r - K_r * d_t) * (d_r - K_r * d_t).T,
        Expect(
            P_rr - K_r * P_rt.T - P_rt * K_r.T + K_r * P_tt * K_r.T,
            moments=(is_P_rr, is_P_rt, is_P_tt),
        ),
        Line(P_rr - K_t * P_rt.T + (K_r - K_t) * P_tt * (K_r - K_t).T, by=(is_K_t,)),
    ),
    root := define(P_tt, L_t * L_t.T),
    chain(
        "",
        "no other gain does better with what arrived",
        P_rr - K_t * P_rt.T + (K_r - K_t) * P_tt * (K_r - K_t).T,
        AtLeast(P_rr - K_t * P_rt.T, by=(root,), root=(K_r - K_t) * L_t),
    ),
    is_P_next := define(P_next, P_rr - K_t * P_rt.T, "27"),
    """The filter that is run again from the first reading that arrived uses the same
    numbers. Its error, too, is correlated with none of them. Two such estimates are
    equal, since their difference has no variance.""",
    told := chain(
        "",
        "the error that is left is correlated with nothing that arrived",
        (d_r - K_t * d_t) * d_t.T,
        Expect(P_rt - K_t * P_tt, moments=(is_P_rt, is_P_tt)),
        Line(ZeroMatrix(s, k), by=(is_K_t,)),
    ),
    other := define(K_r * P_tt, P_rt),
    chain(
        "",
        "two estimates of least covariance are one",
        (K_r - K_t) * d_t * d_t.T * (K_r - K_t).T,
        Expect((K_r - K_t) * P_tt * (K_r - K_t).T, moments=(is_P_tt,)),
        Line((P_rt - K_t * P_tt) * (K_r - K_t).T, by=(other,)),
        Line(ZeroMatrix(s, s), by=(is_K_t,)),
    ),
)


@cache
def late_ahead():
    """What is predicted while readings of the last instant and older ones are awaited.

    Columns of X_f and Z_f, and rows of Z_fh, are zero for readings that arrived.
    """
    return Derivation(
        (A, As, B, J, C, Qs, Sigma, X_f, X_h, Z_f, Z_fh, x, u, y_hat),
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
        (C, R, Omega, X_h),
        (
            Stage(N, is_N.right, "(33)", by=(is_N,)),
            Stage(N_h, is_N_h.right, by=(is_N_h,)),
            Stage(M, is_M.right, "(33)", symmetric=True, by=(is_M,)),
        ),
        source="our own",
        letters=late,
        says="new readings beside what is held",
    )


@cache
def late_known():
    """What readings that have just arrived tell of the state and of those to come."""
    return Derivation(
        (P_rr, P_rt, P_tt),
        (
            Stage(K_t, Solve(P_rt, P_tt), by=(is_K_t,)),
            Stage(P_next, is_P_next.right, "(27)", symmetric=True, by=(is_P_next,)),
        ),
        source="our own",
        letters=late,
        says="what has just arrived",
    )


@cache
def late_corrected():
    """The expected values, corrected by readings that have just arrived."""
    return Derivation(
        (K_t, x_hat_r, t, t_hat),
        (Stage(x_hat_r_next, corrects.right, "(43)", by=(corrects,)),),
        source="our own",
        letters=late,
        says="what arrived corrects what was expected",
    )


@cache
def derive():
    """The page."""
    page = (
        *AHEAD,
        late_ahead(),
        *FRESH,
        late_fresh(),
        *KNOWN,
        late_known(),
        late_corrected(),
    )
    return Derivation(page=page, letters=late, source="our own")
