"""The estimate with the gain at which a filter's recursion stops, and its distance.

With one gain for all rows the estimate is one linear map of the estimate before and of
what is measured.  The full recursion makes another estimate; this page says how far the
two can be apart.

Source: our own.
"""

from functools import cache

from sympy import Rational, sqrt, symbols

from ....symbolic import AtMost, Derivation, Line, Stage, Substitute
from .best_coordinates import gain
from .correlated_noise import is_As
from .letters import *
from .settled_ball import H, is_q, is_tau, kappa, q, t, tau
from .settling import Y_0, Kmv_i, M_i, Theta, differs, is_Y_0, settling

settled = settling.here(
    x="estimate of the state",
    x_next="estimate one step on",
    y="measurement",
    d="what the full recursion's prediction has beside `x_minus`",
)
chain, define = settled.chain, settled.define
x_minus = settled("x_minus", n, 1, "prediction")
rho = settled("rho", p, 1, "what the estimate leaves of the measurement")
nu = settled("nu", p, 1, "what the prediction leaves of the next measurement")
Phi = settled("Phi", n, n, "moves the estimate from row to row")
G_y = settled("G_y", n, p, "what a measurement does to the next estimate")
G_u = settled("G_u", n, m, "what an input does to the next estimate")
G_e = settled("G_e", n, m, "what an input does to the estimate of its instant")
N_x = settled("N_x", p, n, "what an estimate takes from the next innovation")
N_y = settled("N_y", p, p, "what a measurement takes from the next innovation")
N_u = settled("N_u", p, m, "what an input takes from the next innovation")
k = symbols("k", integer=True, nonnegative=True)
j = symbols("j", integer=True, nonnegative=True)
z = settled("r", k, 1, "what a row reads: measurements and inputs")
G_r = settled("G_r", n, k, "what that does to the estimate")
W_x = settled("W_x", j, n, "what the estimate does to the innovation, weighed")
W_r = settled("W_r", j, k, "what a row does to the innovation, weighed")
eps_s = settled("epsilon", j, 1, "the innovation, weighed by a root of `M^-1`")
x_f = settled("x_f", n, 1, "estimate of the full recursion")
x_fm = settled("x_f_minus", n, 1, "prediction of the full recursion")
K_i = settled("K_i", n, p, "gain of the full recursion")
K_c = settled("K_c", n, p, "the gain as it is kept, in few digits")
V_K = settled("V_K", n, p, "what that lacks of the gain")
x_c = settled("x_c", n, 1, "the estimate as it is kept")
e_r = settled("e_r", n, 1, "what rounding adds to it in one row")
b_1 = settled("b_1", n, 1, "a vector")
b_2 = settled("b_2", n, 1, "another vector")
R_s = settled("R_s", p, p, "a root of `s^2 M - nu nu'`")
R_c = settled("R_c", p, p, "a root of `M_i - kappa^2 q M`")
R_g = settled("R_g", n, n, "a root of `t^2 H - q Theta M_i Theta'`")
R_m = settled("R_m", p, p, "a root of `kappa^2 M - C H C'`")
R_d = settled("R_d", n, n, "a root of `D^2 H - d d'`")
R_1 = settled("R_1", n, n, "a root of `alpha^2 H - b_1 b_1'`")
R_2 = settled("R_2", n, n, "a root of `beta^2 H - b_2 b_2'`")
s = settled.scalar("s", "size of the innovation in units of `M`", positive=True)
D = settled.scalar("D", "size of `d` in units of `H`", positive=True)
alpha = settled.scalar("alpha", "size of a vector in units of `H`", positive=True)
beta = settled.scalar("beta", "size of another one", positive=True)

ONE_GAIN = (
    """With one gain for all rows an estimate is a linear map of the one before, and of
    what was measured and put in at both instants.""",
    is_minus := define(x_minus, A * x + B * u + J * rho, "43"),
    is_rho := define(rho, y - E * u - C * x),
    is_As,
    is_nu := define(nu, y_next - E * u_next - C * x_minus, "43"),
    is_Phi := define(Phi, (I - K * C) * As),
    is_G_y := define(G_y, (I - K * C) * J),
    is_G_u := define(G_u, (I - K * C) * (B - J * E)),
    is_G_e := define(G_e, -K * E),
    predicts := chain(
        "",
        "the prediction, from what was measured",
        x_minus,
        Line(A * x + B * u + J * (y - E * u - C * x), by=(is_minus, is_rho)),
        Line(As * x + (B - J * E) * u + J * y, by=(is_As,)),
    ),
    one_map := chain(
        "",
        "the estimate, with one gain for all rows",
        x_minus + K * nu,
        Line(x_minus + K * (y_next - E * u_next - C * x_minus), by=(is_nu,)),
        Line((I - K * C) * x_minus + K * y_next - K * E * u_next, why="collect"),
        Line(
            (I - K * C) * (As * x + (B - J * E) * u + J * y)
            + K * y_next
            - K * E * u_next,
            by=(predicts,),
        ),
        Line(
            Phi * x + G_y * y + G_u * u + K * y_next + G_e * u_next,
            by=(is_Phi, is_G_y, is_G_u, is_G_e),
        ),
    ),
    is_N_x := define(N_x, C * As),
    is_N_y := define(N_y, C * J),
    is_N_u := define(N_u, C * (B - J * E)),
    chain(
        "",
        "the innovation, from what was measured",
        nu,
        Line(y_next - E * u_next - C * x_minus, by=(is_nu,)),
        Line(
            y_next - E * u_next - C * (As * x + (B - J * E) * u + J * y),
            by=(predicts,),
        ),
        Line(
            y_next - E * u_next - N_x * x - N_y * y - N_u * u,
            by=(is_N_x, is_N_y, is_N_u),
        ),
    ),
    """A row over a record has all that it reads in one vector, `r`.""",
    is_row := define(x_next, Phi * x + G_r * z),
    is_eps := define(eps_s, W_r * z + W_x * x),
)

APART = (
    """The full recursion predicts `x_f_minus` and has the gain `K_i`. The two gains
    differ by what the covariances make of them.""",
    differs,
    is_Y_0,
    runs := define(K, gain.right, "33"),
    runs_i := define(K_i, gain.right.subs(Kmv, Kmv_i), "33"),
    gains := chain(
        "",
        "how the gain that runs differs",
        K_i,
        Line(runs_i.right, by=(runs_i,)),
        Line(gain.right + (I - Gamma * C) * Y_0 * Theta, by=(differs,)),
        Line(K + (I - Gamma * C) * Y_0 * Theta, by=(runs,)),
    ),
    leaves := chain(
        "",
        "what the gain leaves of an error",
        I - K * C,
        Line(I - gain.right * C, by=(runs,)),
        Line((I - Gamma * C) * Y_0, by=(is_Y_0,)),
    ),
    is_d := define(x_fm, x_minus + d),
    full := define(x_f, x_fm + K_i * (y_next - E * u_next - C * x_fm), "43"),
    chain(
        "",
        "how the estimates differ",
        x_f - x_minus - K * nu,
        Line(
            x_fm + K_i * (y_next - E * u_next - C * x_fm) - x_minus - K * nu, by=(full,)
        ),
        Line(d + K_i * (nu - C * d) - K * nu, by=(is_d, is_nu)),
        Line(
            (I - K * C) * d + (I - Gamma * C) * Y_0 * Theta * (nu - C * d), by=(gains,)
        ),
        Line((I - K * C) * (d + Theta * (nu - C * d)), by=(leaves,)),
    ),
    """A computer keeps a gain that lacks `V_K`, and rounds the estimate by `e_r`. The
    step is taken once more with twice the digits, so that `V_K` is known.""",
    kept := define(K, K_c + V_K),
    is_x_c := define(x_c, x_minus + K_c * nu + e_r),
    chain(
        "",
        "what the kept gain and rounding add to the difference",
        x_f - x_c - (x_f - x_minus - K * nu),
        Line(K * nu - K_c * nu - e_r, by=(is_x_c,)),
        Line(V_K * nu - e_r, by=(kept,)),
    ),
    """All of these vectors are measured by `H` as well: `d` has the size `D` if
    `d d' <= D^2 H`. For the innovation let `nu nu' <= s^2 M`.""",
    is_R_c := define(M_i, kappa**2 * q * M + R_c * R_c.T),
    is_R_s := define(s**2 * M - nu * nu.T, R_s * R_s.T),
    chain(
        "",
        "what an innovation does through what the gain lacks",
        V_K * nu * nu.T * V_K.T,
        AtMost(s**2 * V_K * M * V_K.T, by=(is_R_s,), root=V_K * R_s),
    ),
    is_R_g := define(t**2 * H - q * Theta * M_i * Theta.T, R_g * R_g.T),
    is_q,
    is_tau,
    chain(
        "",
        "what an innovation does through the other gain",
        kappa**2 * q**2 * Theta * nu * nu.T * Theta.T,
        AtMost(
            kappa**2 * q**2 * s**2 * Theta * M * Theta.T,
            by=(is_R_s,),
            root=kappa * q * Theta * R_s,
        ),
        AtMost(
            q * s**2 * Theta * M_i * Theta.T,
            by=(is_R_c,),
            root=sqrt(q) * s * Theta * R_c,
        ),
        AtMost(s**2 * t**2 * H, by=(is_R_g,), root=s * R_g),
        Substitute(s**2 * t * kappa**2 * q * tau * H, by=(is_tau, is_q)),
        Substitute((s * kappa**2 * q * tau) ** 2 * H, by=(is_tau, is_q)),
    ),
    is_R_m := define(kappa**2 * M, C * H * C.T + R_m * R_m.T),
    is_R_d := define(D**2 * H, d * d.T + R_d * R_d.T),
    chain(
        "",
        "what a difference does through the other gain",
        q**2 * Theta * C * d * d.T * C.T * Theta.T,
        AtMost(
            q**2 * D**2 * Theta * C * H * C.T * Theta.T,
            by=(is_R_d,),
            root=q * Theta * C * R_d,
        ),
        AtMost(
            q**2 * D**2 * kappa**2 * Theta * M * Theta.T,
            by=(is_R_m,),
            root=q * D * Theta * R_m,
        ),
        AtMost(
            q * D**2 * Theta * M_i * Theta.T,
            by=(is_R_c,),
            root=sqrt(q) * D * Theta * R_c,
        ),
        AtMost(D**2 * t**2 * H, by=(is_R_g,), root=D * R_g),
        Substitute(D**2 * t * kappa**2 * q * tau * H, by=(is_tau, is_q)),
        Substitute((D * kappa**2 * q * tau) ** 2 * H, by=(is_tau, is_q)),
    ),
    """So `Theta nu` has the size `kappa tau s`, and `Theta C d` the size
    `kappa^2 tau D`. Sizes of vectors add up.""",
    is_R_1 := define(alpha**2 * H, b_1 * b_1.T + R_1 * R_1.T),
    is_R_2 := define(beta**2 * H, b_2 * b_2.T + R_2 * R_2.T),
    chain(
        "",
        "the size of a sum",
        alpha * beta * (b_1 + b_2) * (b_1 + b_2).T,
        AtMost(
            alpha * beta * (b_1 + b_2) * (b_1 + b_2).T
            + (beta * b_1 - alpha * b_2) * (beta * b_1 - alpha * b_2).T,
            root=beta * b_1 - alpha * b_2,
        ),
        Line(
            beta * (alpha + beta) * b_1 * b_1.T + alpha * (alpha + beta) * b_2 * b_2.T,
            why="multiply out",
        ),
        AtMost(
            beta * (alpha + beta) * alpha**2 * H + alpha * (alpha + beta) * b_2 * b_2.T,
            by=(is_R_1,),
            root=sqrt(beta * (alpha + beta)) * R_1,
        ),
        AtMost(
            beta * (alpha + beta) * alpha**2 * H + alpha * (alpha + beta) * beta**2 * H,
            by=(is_R_2,),
            root=sqrt(alpha * (alpha + beta)) * R_2,
        ),
        Line(alpha * beta * (alpha + beta) ** 2 * H, why="factor"),
    ),
)


@cache
def settled_gain():
    """What one gain for all rows makes of estimates, measurements and inputs."""
    return Derivation(
        (B, C, E, J, As, K),
        (
            Stage(Phi, is_Phi.right, by=(is_Phi,)),
            Stage(G_y, is_G_y.right, by=(is_G_y,)),
            Stage(G_u, is_G_u.right, by=(is_G_u,)),
            Stage(G_e, is_G_e.right, by=(is_G_e,)),
            Stage(N_x, is_N_x.right, by=(is_N_x,)),
            Stage(N_y, is_N_y.right, by=(is_N_y,)),
            Stage(N_u, is_N_u.right, by=(is_N_u,)),
        ),
        source="our own",
        letters=settled,
        says="what one gain for all rows makes of a record",
    )


@cache
def settled_row():
    """One row of a record with one gain, and its innovation, weighed."""
    return Derivation(
        (Phi, G_r, W_x, W_r, x, z),
        (
            Stage(x_next, is_row.right, by=(is_row,)),
            Stage(eps_s, is_eps.right, by=(is_eps,)),
        ),
        source="our own",
        letters=settled,
        says="one row with one gain",
    )


WITNESS = {
    t: 1,
    kappa: Rational(4, 5),
    q: Rational(9, 16),
    H: 1,
    M: 1,
    M_i: 1,
    C: 0,
    Theta: 0,
    nu: 0,
    d: 0,
    s: 1,
    D: 1,
    alpha: 1,
    beta: 1,
}


@cache
def derive():
    """The page."""
    page = (*ONE_GAIN, settled_gain(), settled_row(), *APART)
    return Derivation(page=page, letters=settled, source="our own", witness=WITNESS)
