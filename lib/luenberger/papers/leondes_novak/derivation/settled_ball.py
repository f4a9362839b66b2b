"""A ball that no covariance leaves, once a filter has all but settled.

The difference of a later covariance is measured by a matrix `H` that one step of the
recursion makes smaller.  What is not linear in the difference is of second order.

Source: our own.
"""

from functools import cache

from sympy import Rational, sqrt

from ....symbolic import AtLeast, AtMost, Derivation, Line, Substitute
from .letters import *
from .settling import (
    F_0,
    G_0,
    M_i,
    Theta,
    U,
    Xi,
    delta,
    is_M_i,
    is_Theta,
    is_U,
    settling,
)  # fmt: skip

ball = settling.here()
chain, define = ball.chain, ball.define
H = ball("H", n, n, "size of a difference of covariances", symmetric=True)
V = ball("V", n, p, "gain of a reading, were `H` the covariance")
Z = ball("Z", n, n, "a difference in units of `H`")
R_H = ball("R_H", n, n, "a root of `H`")
R_low = ball("R_low", n, n, "a root of `t H + Xi`")
R_up = ball("R_up", n, n, "a root of `t H - Xi`")
R_M = ball("R_M", p, p, "a root of `kappa^2 M - C H C'`")
R_q = ball("R_q", p, p, "a root of `M_i - q C H C'`")
R_i = ball("R_i", p, p, "a root of `M_i`")
R_V = ball("R_V", n, n, "a root of `H - q V C H`")
R_Z = ball("R_Z", n, n, "a root of `t^2 H - Z H Z'`")
R_t = ball("R_t", n, n, "a root of `t^2 H - q Theta M_i Theta'`")
R_a = ball("R_a", n, n, "a root of `a H + delta`")
R_b = ball("R_b", n, n, "a root of `a H - delta`")
R_e = ball("R_e", n, n, "a root of `tau H + Xi_i`")
R_f = ball("R_f", n, n, "a root of `tau H - Xi_i`")
R_rho = ball("R_rho", n, n, "a root of `rho H - F_0 H F_0' - G_0 H G_0'`")
t = ball.scalar("t", "size of `Xi`", positive=True)
tau = ball.scalar("tau", "size of what a reading leaves of it", positive=True)
kappa = ball.scalar("kappa", "size of `C H C'` in units of `M`, a root", positive=True)
q = ball.scalar("q", "the part of `C H C'` that is surely in `M_i`", positive=True)
a = ball.scalar("a", "size of `delta`, and of rounding", positive=True)
rho = ball.scalar("rho", "what one step leaves of `H`", positive=True)

BALL = (
    """`H` measures differences: `Xi` has the size `t` if `-t H <= Xi <= t H`. Then its
    square in units of `H` is at most `t^2 H`.""",
    is_M_i,
    is_Theta,
    is_U,
    is_Z := define(Z * H, Xi),
    is_low := define(t * H + Xi, R_low * R_low.T),
    is_up := define(t * H - Xi, R_up * R_up.T),
    chain(
        "",
        "the square of a difference",
        2 * t * Z * H * Z.T,
        AtMost(
            2 * t * Z * H * Z.T + (t * I + Z) * (t * H - Xi) * (t * I + Z).T,
            by=(is_up,),
            root=(t * I + Z) * R_up,
        ),
        AtMost(
            2 * t * Z * H * Z.T
            + (t * I + Z) * (t * H - Xi) * (t * I + Z).T
            + (t * I - Z) * (t * H + Xi) * (t * I - Z).T,
            by=(is_low,),
            root=(t * I - Z) * R_low,
        ),
        Line(2 * t**3 * H, by=(is_Z,)),
    ),
    """Let `C H C'` be at most `kappa^2 M`. Then a part of it is in `M_i` as well, as
    long as `kappa^2 t` is less than one.""",
    is_kappa := define(kappa**2 * M, C * H * C.T + R_M * R_M.T),
    is_q := define(q, 1 / kappa**2 - t),
    chain(
        "",
        "the innovation of the later row",
        kappa**2 * M_i,
        Line(kappa**2 * M + kappa**2 * C * Xi * C.T, by=(is_M_i,)),
        AtLeast(
            kappa**2 * M - kappa**2 * t * C * H * C.T,
            by=(is_low,),
            root=kappa * C * R_low,
        ),
        AtLeast((1 - kappa**2 * t) * C * H * C.T, by=(is_kappa,), root=R_M),
        Substitute(q * kappa**2 * C * H * C.T, by=(is_q,)),
    ),
    chain(
        "",
        "the same, beside that of the earlier row",
        M_i,
        Line(M + C * Xi * C.T, by=(is_M_i,)),
        AtLeast(M - t * C * H * C.T, by=(is_low,), root=C * R_low),
        AtLeast(M - t * kappa**2 * M, by=(is_kappa,), root=sqrt(t) * R_M),
        Substitute(kappa**2 * q * M, by=(is_q,)),
    ),
    is_R_q := define(M_i, q * C * H * C.T + R_q * R_q.T),
    is_V := define(V * M_i, H * C.T),
    is_R_H := define(H, R_H * R_H.T),
    chain(
        "",
        "what it could take from `H`",
        q * V * C * H,
        AtMost(
            q * V * C * H + q * V * (M_i - q * C * H * C.T) * V.T,
            by=(is_R_q,),
            root=sqrt(q) * V * R_q,
        ),
        AtMost(
            q * V * C * H
            + q * V * (M_i - q * C * H * C.T) * V.T
            + (I - q * V * C) * H * (I - q * V * C).T,
            by=(is_R_H,),
            root=(I - q * V * C) * R_H,
        ),
        Line(H, by=(is_V,)),
    ),
    """So what it takes from `Xi` is of second order.""",
    is_R_V := define(H - q * V * C * H, R_V * R_V.T),
    is_R_Z := define(t**2 * H - Z * H * Z.T, R_Z * R_Z.T),
    told := define(Theta, Z * V),
    chain(
        "",
        "what a reading takes from a difference",
        q * Theta * M_i * Theta.T,
        Line(q * Z * H * C.T * V.T * Z.T, by=(told, is_V)),
        AtMost(Z * H * Z.T, by=(is_R_V,), root=Z * R_V),
        AtMost(t**2 * H, by=(is_R_Z,), root=R_Z),
    ),
    """What is left of `Xi` is therefore at most `tau` in size.""",
    is_R_i := define(M_i, R_i * R_i.T),
    chain(
        "",
        "what a reading leaves, from above",
        U,
        Line(Xi - Theta * C * Xi, by=(is_U,)),
        Line(Xi - Theta * M_i * Theta.T, by=(is_Theta,)),
        AtMost(Xi, by=(is_R_i,), root=Theta * R_i),
        AtMost(t * H, by=(is_up,), root=R_up),
    ),
    is_R_t := define(t**2 * H - q * Theta * M_i * Theta.T, R_t * R_t.T),
    is_tau := define(tau, t + t**2 / q),
    chain(
        "",
        "what a reading leaves, from below",
        q * U,
        Line(q * Xi - q * Theta * C * Xi, by=(is_U,)),
        Line(q * Xi - q * Theta * M_i * Theta.T, by=(is_Theta,)),
        AtLeast(q * Xi - t**2 * H, by=(is_R_t,), root=R_t),
        AtLeast(-q * t * H - t**2 * H, by=(is_low,), root=sqrt(q) * R_low),
        Substitute(-q * tau * H, by=(is_tau,)),
    ),
    chain(
        "",
        "the size of what is left",
        (1 - kappa**2 * t) * tau,
        Substitute(t, by=(is_q, is_tau)),
    ),
    is_R_a := define(a * H + delta, R_a * R_a.T),
    is_R_e := define(tau * H + U, R_e * R_e.T),
    is_R_f := define(tau * H - U, R_f * R_f.T),
    is_rho := define(rho * H, F_0 * H * F_0.T + G_0 * H * G_0.T + R_rho * R_rho.T),
    chain(
        "",
        "the difference one step on, from below",
        delta + F_0 * U * F_0.T - G_0 * U * G_0.T,
        AtLeast(-a * H + F_0 * U * F_0.T - G_0 * U * G_0.T, by=(is_R_a,), root=R_a),
        AtLeast(
            -a * H - tau * F_0 * H * F_0.T - G_0 * U * G_0.T,
            by=(is_R_e,),
            root=F_0 * R_e,
        ),
        AtLeast(
            -a * H - tau * (F_0 * H * F_0.T + G_0 * H * G_0.T),
            by=(is_R_f,),
            root=G_0 * R_f,
        ),
        AtLeast(-(a + rho * tau) * H, by=(is_rho,), root=sqrt(tau) * R_rho),
    ),
    is_R_b := define(a * H - delta, R_b * R_b.T),
    chain(
        "",
        "the difference one step on, from above",
        delta + F_0 * U * F_0.T - G_0 * U * G_0.T,
        AtMost(a * H + F_0 * U * F_0.T - G_0 * U * G_0.T, by=(is_R_b,), root=R_b),
        AtMost(
            a * H + tau * F_0 * H * F_0.T - G_0 * U * G_0.T,
            by=(is_R_f,),
            root=F_0 * R_f,
        ),
        AtMost(
            a * H + tau * (F_0 * H * F_0.T + G_0 * H * G_0.T),
            by=(is_R_e,),
            root=G_0 * R_e,
        ),
        AtMost((a + rho * tau) * H, by=(is_rho,), root=sqrt(tau) * R_rho),
    ),
    """So a difference of the size `t` has one step on at most the size `a + rho tau`.
    Where that is no more than `t`, no later row leaves the ball. With
    `t = 2 a/(1 - rho)` it is so if `rho (tau - t) <= a`.""",
    is_t := define(t, 2 * a / (1 - rho)),
    chain(
        "",
        "how much room the ball has",
        t - (a + rho * tau),
        Line((1 - rho) * t - a - rho * (tau - t), why="collect"),
        Substitute(a - rho * (tau - t), by=(is_t,)),
    ),
)


WITNESS = {
    t: 1,
    kappa: Rational(4, 5),
    q: Rational(9, 16),
    a: Rational(1, 4),
    rho: Rational(1, 2),
    H: 1,
    Z: 0,
    C: 0,
    M: 1,
    delta: 0,
    F_0: Rational(1, 2),
    G_0: 0,
}


@cache
def derive():
    """The page."""
    return Derivation(page=BALL, letters=ball, source="our own", witness=WITNESS)
