"""A stretch of rows whose readings are all known, from a state that is known.

The estimate at the end of the stretch is linear in the state where it begins, and so is
every innovation on the way.  This page carries on, row by row, what the estimate at the
end is, and what the innovations say of the beginning.

Source: our own.  Särkkä and García-Fernández, Temporal parallelization of Bayesian
smoothers, IEEE Trans. Automatic Control 66 (2021), have elements of this form.
"""

from functools import cache

from sympy import symbols

from ....symbolic import Derivation, Expect, Line, Solve, Stage, ZeroMatrix
from .estimate import corrects, innovation, is_innovation, x_minus
from .late_outputs import (
    errs,
    fresh,
    g,
    is_e_m,
    is_e_minus,
    is_g,
    is_M,
    is_N,
    is_y_minus,
    is_y_new,
    late,
)
from .letters import *
from .one_pass import Z, is_Z
from .one_pass import quick as quick_Sigma
from .quadratic import is_Omega, is_Sigma_next

k = symbols("k", integer=True, nonnegative=True)
stretch = late.here(
    x="estimate at the end of the stretch",
    x_next="estimate one row on",
    y="measurement one row on",
    K="gain of least covariance",
    N="covariance of the predicted error and what is expected",
)
stretch(Z.name, n, n, "what the gain leaves of `Omega`")
chain, define, moment = stretch.chain, stretch.define, stretch.moment
s = stretch("s", n, 1, "state where the stretch begins")
Phi = stretch("Phi", n, n, "what that does to the estimate at the end")
Phi_next = stretch("Phi_next", n, n, "the same one row on")
Psi = stretch("Psi", n, n, "what it does to the prediction")
xi = stretch("xi", n, 1, "the estimate at the end if the beginning is zero")
xi_next = stretch("xi_next", n, 1, "the same one row on")
xi_minus = stretch("xi_minus", n, 1, "the prediction if the beginning is zero")
eta = stretch("eta", p, 1, "the innovation if the beginning is zero")
Shown = stretch("Shown", p, n, "what the innovation shows of the beginning")
zeta = stretch("zeta", k, 1, "noise of what earlier innovations show of it")
W = stretch("W", n, p, "what an innovation says of the beginning")
theta = stretch("theta", n, 1, "what the stretch says of its beginning")
theta_next = stretch("theta_next", n, 1, "the same one row on")
Lambda = stretch("Lambda", n, n, "how much it says of it", symmetric=True)
Lambda_next = stretch("Lambda_next", n, n, "the same one row on", symmetric=True)

ON = (
    """A stretch of rows begins with a known state `s`. The estimate at its end is
    linear in `s`. One more row keeps it so.""",
    is_x := define(x, Phi * s + xi),
    predicts := define(x_minus, A * x + B * u, "43"),
    is_Psi := define(Psi, A * Phi),
    is_xi_minus := define(xi_minus, A * xi + B * u),
    ahead := chain(
        "43",
        "the prediction is linear in the beginning",
        x_minus,
        Line(A * x + B * u, by=(predicts,)),
        Line(A * (Phi * s + xi) + B * u, by=(is_x,)),
        Line(Psi * s + xi_minus, by=(is_Psi, is_xi_minus)),
    ),
    is_innovation,
    is_eta := define(eta, y - E * u_next - C * xi_minus),
    is_Shown := define(Shown, C * Psi),
    seen := chain(
        "43",
        "the innovation is a reading of the beginning",
        innovation,
        Line(y - E * u_next - C * x_minus, by=(is_innovation,)),
        Line(y - E * u_next - C * (Psi * s + xi_minus), by=(ahead,)),
        Line(eta - Shown * s, by=(is_eta, is_Shown)),
    ),
    corrects,
    is_Phi_next := define(Phi_next, Psi - K * Shown),
    is_xi_next := define(xi_next, xi_minus + K * eta),
    chain(
        "43",
        "the estimate one row on is linear in the beginning",
        x_next,
        Line(x_minus + K * innovation, by=(corrects,)),
        Line(Psi * s + xi_minus + K * innovation, by=(ahead,)),
        Line(Psi * s + xi_minus + K * (eta - Shown * s), by=(seen,)),
        Line(Phi_next * s + xi_next, by=(is_Phi_next, is_xi_next)),
    ),
)
APART = (
    """The error at the end and the innovations are those of a filter that starts from a
    known state. The noise of an innovation is correlated with none of the earlier ones,
    and the error that is left with none at all.""",
    is_y_new,
    is_y_minus,
    is_e_m,
    is_g,
    errs,
    old := moment(e_minus * zeta.T, ZeroMatrix(n, k)),
    new := moment(v_next * zeta.T, ZeroMatrix(p, k)),
    chain(
        "",
        "an innovation and earlier ones",
        g * zeta.T,
        Line((C * e_minus - v_next) * zeta.T, by=(errs,)),
        Expect(ZeroMatrix(p, k), moments=(old, new)),
    ),
    chain(
        "",
        "the error that is left and earlier innovations",
        (e_minus - K * g) * zeta.T,
        Line((e_minus - K * C * e_minus + K * v_next) * zeta.T, by=(errs,)),
        Expect(ZeroMatrix(n, k), moments=(old, new)),
    ),
    is_e_minus,
    is_R := moment(v_next * v_next.T, R, "4"),
    fresh,
    is_N,
    is_M,
    is_K := define(K * M, N, "33"),
    chain(
        "",
        "the error that is left and the new innovation",
        (e_minus - K * g) * g.T,
        Line(
            (e_minus - K * C * e_minus + K * v_next) * (C * e_minus - v_next).T,
            by=(errs,),
        ),
        Expect(
            Omega * C.T - K * (C * Omega * C.T + R), moments=(is_e_minus, is_R, fresh)
        ),
        Line(N - K * (C * N + R), by=(is_N,)),
        Line(N - K * M, by=(is_M,)),
        Line(ZeroMatrix(n, p), by=(is_K,)),
    ),
    """So each innovation is a reading of the beginning with noise of its own, and what
    they say adds up.""",
    is_W := define(W * M, Shown.T),
    says := define(theta_next, theta + W * eta),
    much := define(Lambda_next, Lambda + W * Shown),
    "The covariance of the error at the end is that of the page on one pass.",
    is_Omega,
    is_Z,
    is_Sigma_next,
)


@cache
def late_row():
    """A stretch, one row longer."""
    return Derivation(
        (A, B, Q, C, E, R, Phi, xi, Sigma, theta, Lambda, u, y, u_next),
        (
            Stage(Omega, is_Omega.right, "(44)", symmetric=True, by=(is_Omega,)),
            Stage(N, is_N.right, "(33)", by=(is_N,)),
            Stage(M, is_M.right, "(33)", symmetric=True, by=(is_M,)),
            Stage(K, Solve(N, M), "(33)", by=(is_K,)),
            Stage(Z, is_Z.right, by=(is_Z,)),
            Stage(
                Sigma_next,
                quick_Sigma.right,
                "(27)",
                symmetric=True,
                by=(is_Sigma_next, quick_Sigma),
            ),
            Stage(Psi, is_Psi.right, by=(is_Psi,)),
            Stage(Shown, is_Shown.right, by=(is_Shown,)),
            Stage(Phi_next, is_Phi_next.right, by=(is_Phi_next,)),
            Stage(W, Solve(Shown.T, M), by=(is_W,)),
            Stage(Lambda_next, much.right, symmetric=True, by=(much,)),
            Stage(xi_minus, is_xi_minus.right, "(43)", by=(is_xi_minus,)),
            Stage(eta, is_eta.right, "(43)", by=(is_eta,)),
            Stage(xi_next, is_xi_next.right, "(43)", by=(is_xi_next,)),
            Stage(theta_next, says.right, by=(says,)),
        ),
        source="our own",
        letters=stretch,
        says="a stretch, one row longer",
    )


@cache
def late_single():
    """What one row by itself says, given what its matrices make of it."""
    return Derivation(
        (B, C, E, K, W, u, y, u_next),
        (
            Stage(xi_minus, B * u, "(43)", by=(alone,)),
            Stage(eta, is_eta.right, "(43)", by=(is_eta,)),
            Stage(xi_next, is_xi_next.right, "(43)", by=(is_xi_next,)),
            Stage(theta_next, W * eta, by=(first,)),
        ),
        source="our own",
        letters=stretch,
        says="one row by itself",
    )


SINGLE = (
    """A row by itself is a stretch of no rows and this row. A stretch of no rows says
    nothing, and its end is its beginning.""",
    nothing := define(xi, ZeroMatrix(n, 1)),
    silent := define(theta, ZeroMatrix(n, 1)),
    alone := chain(
        "",
        "the prediction of a row by itself",
        xi_minus,
        Line(A * xi + B * u, by=(is_xi_minus,)),
        Line(B * u, by=(nothing,)),
    ),
    first := chain(
        "",
        "what a row says by itself",
        theta_next,
        Line(theta + W * eta, by=(says,)),
        Line(W * eta, by=(silent,)),
    ),
)


@cache
def derive():
    """The page."""
    page = (*ON, *APART, late_row(), *SINGLE, late_single())
    return Derivation(page=page, letters=stretch, source="our own")
