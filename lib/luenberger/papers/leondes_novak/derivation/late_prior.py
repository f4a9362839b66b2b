"""What a stretch of rows does to an estimate of the state where it begins.

All innovations of the stretch together are one reading of that state.  It corrects an
estimate from earlier rows, and the stretch leads the corrected estimate to its end.

Source: our own.
"""

from functools import cache

from ....symbolic import Derivation, Expect, Line, Solve, Stage, ZeroMatrix
from .late_stretch import Lambda, Phi, k, s, stretch, theta, xi
from .letters import *

prior = stretch.here(
    Lambda="how much the stretch says of its beginning",
    e="error at the end of the stretch if its beginning is known",
    Sigma="covariance of that",
)
chain, define, moment = prior.chain, prior.define, prior.moment
P = prior("P", n, n, "covariance of `d`", symmetric=True)
d = prior("d", n, 1, "error of an estimate of the beginning from earlier rows")
d_s = prior("d_s", n, 1, "the same once the stretch is known")
x_0 = prior("x_0", n, 1, "estimate of the beginning from earlier rows")
x_s = prior("x_s", n, 1, "the same once the stretch is known")
P_s = prior("P_s", n, n, "covariance of its error", symmetric=True)
t = prior("t", k, 1, "what the innovations read of the beginning")
G_t = prior("G_t", k, n, "how they read it")
zeta = prior("zeta", k, 1, "noise of these readings")
M_t = prior("M_t", k, k, "covariance of that", symmetric=True)
D_t = prior("D_t", k, k, "covariance of what is expected of them", symmetric=True)
W_t = prior("W_t", n, k, "what these readings say of the beginning")
K_t = prior("K_t", n, k, "gain of least covariance")
theta_2 = prior("theta_2", n, 1, "what other readings say of the beginning")
Lambda_2 = prior("Lambda_2", n, n, "how much they say of it", symmetric=True)
x_2 = prior("x_2", n, 1, "estimate of the beginning once both are known")
P_2 = prior("P_2", n, n, "covariance of its error", symmetric=True)
x_end = prior("x_end", n, 1, "estimate at the end of the stretch")
P_end = prior("P_end", n, n, "covariance of its error", symmetric=True)
Both = prior("Both", n, n, "`P`, and what the stretch makes of it", symmetric=True)
Y_s = prior("Y_s", n, n, "moves the estimate of the beginning to the end")
N_s = prior("N_s", n, n, "`P`, moved to the end")

READ = (
    """The innovations of a stretch read its beginning, each with noise of its own. An
    estimate of the beginning from earlier rows errs independently of that noise.""",
    is_t := define(t, G_t * s + zeta),
    is_d := define(d, x_0 - s),
    is_P := moment(d * d.T, P),
    is_M_t := moment(zeta * zeta.T, M_t),
    apart := moment(d * zeta.T, ZeroMatrix(n, k)),
    is_D_t := define(D_t, G_t * P * G_t.T + M_t),
    chain(
        "33",
        "what is expected of the readings errs",
        (G_t * x_0 - t) * (G_t * x_0 - t).T,
        Line((G_t * x_0 - G_t * s - zeta) * (G_t * x_0 - G_t * s - zeta).T, (is_t,)),
        Line((G_t * d - zeta) * (G_t * d - zeta).T, by=(is_d,)),
        Expect(G_t * P * G_t.T + M_t, moments=(is_P, is_M_t, apart)),
        Line(D_t, by=(is_D_t,)),
    ),
    is_K_t := define(K_t * D_t, P * G_t.T, "33"),
    corrects := define(x_s, x_0 + K_t * (t - G_t * x_0), "43"),
    is_P_s := define(P_s, P - K_t * G_t * P, "27"),
    """What the readings say is short: a vector and a matrix of the size of the state,
    however many readings there are.""",
    is_W_t := define(W_t * M_t, G_t.T),
    is_theta := define(theta, W_t * t),
    is_Lambda := define(Lambda, W_t * G_t),
    gain := chain(
        "",
        "the gain through what the readings say",
        (I + P * Lambda) * K_t,
        Line((I + P * Lambda) * K_t * D_t * D_t.I, why="the covariance has an inverse"),
        Line((I + P * Lambda) * P * G_t.T * D_t.I, by=(is_K_t,)),
        Line((P * G_t.T + P * W_t * G_t * P * G_t.T) * D_t.I, by=(is_Lambda,)),
        Line(P * W_t * (M_t + G_t * P * G_t.T) * D_t.I, by=(is_W_t,)),
        Line(P * W_t * D_t * D_t.I, by=(is_D_t,)),
        Line(P * W_t, why="cancel"),
    ),
    mean := chain(
        "43",
        "the stretch corrects the estimate of its beginning",
        (I + P * Lambda) * x_s,
        Line((I + P * Lambda) * (x_0 + K_t * (t - G_t * x_0)), by=(corrects,)),
        Line((I + P * Lambda) * x_0 + P * W_t * (t - G_t * x_0), by=(gain,)),
        Line(x_0 + P * W_t * t, by=(is_Lambda,)),
        Line(x_0 + P * theta, by=(is_theta,)),
    ),
    spread := chain(
        "27",
        "and lessens its covariance",
        (I + P * Lambda) * P_s,
        Line((I + P * Lambda) * (P - K_t * G_t * P), by=(is_P_s,)),
        Line((I + P * Lambda) * P - P * W_t * G_t * P, by=(gain,)),
        Line(P, by=(is_Lambda,)),
    ),
    """Readings with independent noise say what each says, added up. Suppose that others
    correct the corrected estimate in the same way.""",
    mean_2 := define((I + P_s * Lambda_2) * x_2, x_s + P_s * theta_2),
    spread_2 := define((I + P_s * Lambda_2) * P_2, P_s),
    both := chain(
        "",
        "what is left of two kinds of readings",
        (I + P * Lambda) * (I + P_s * Lambda_2),
        Line(I + P * Lambda + (I + P * Lambda) * P_s * Lambda_2, why="multiply out"),
        Line(I + P * (Lambda + Lambda_2), by=(spread,)),
    ),
    chain(
        "",
        "what two kinds of readings say adds up",
        (I + P * (Lambda + Lambda_2)) * x_2,
        Line((I + P * Lambda) * (I + P_s * Lambda_2) * x_2, by=(both,)),
        Line((I + P * Lambda) * (x_s + P_s * theta_2), by=(mean_2,)),
        Line(x_0 + P * theta + (I + P * Lambda) * P_s * theta_2, by=(mean,)),
        Line(x_0 + P * (theta + theta_2), by=(spread,)),
    ),
    chain(
        "",
        "how much they say adds up",
        (I + P * (Lambda + Lambda_2)) * P_2,
        Line((I + P * Lambda) * (I + P_s * Lambda_2) * P_2, by=(both,)),
        Line((I + P * Lambda) * P_s, by=(spread_2,)),
        Line(P, by=(spread,)),
    ),
)
END = (
    """The stretch leads the corrected estimate to its end. Its own error there, if the
    beginning is known, is correlated with none of the readings.""",
    is_x_end := define(x_end, Phi * x_s + xi),
    is_P_s_too := moment(d_s * d_s.T, P_s),
    is_Sigma := moment(e * e.T, Sigma),
    apart_s := moment(d_s * e.T, ZeroMatrix(n, n)),
    is_P_end := define(P_end, Phi * P_s * Phi.T + Sigma),
    chain(
        "",
        "the covariance at the end",
        (Phi * d_s + e) * (Phi * d_s + e).T,
        Expect(Phi * P_s * Phi.T + Sigma, moments=(is_P_s_too, is_Sigma, apart_s)),
        Line(P_end, by=(is_P_end,)),
    ),
    """One symmetric solve finds both where the estimate from earlier rows is uncertain
    in every direction. What the stretch says beyond that estimate is multiplied by `P`
    first, so that rounding in the solve is not amplified.""",
    is_Both := define(Both, P + P * Lambda * P),
    is_N_s := define(N_s, Phi * P),
    is_Y_s := define(Y_s * Both, N_s),
    moves := chain(
        "",
        "what moves the estimate",
        Y_s * (I + P * Lambda),
        Line(Y_s * (P + P * Lambda * P) * P.I, why="the covariance has an inverse"),
        Line(Y_s * Both * P.I, by=(is_Both,)),
        Line(Phi * P * P.I, by=(is_Y_s, is_N_s)),
        Line(Phi, why="cancel"),
    ),
    x_end_by := chain(
        "",
        "the estimate at the end",
        x_end,
        Line(Phi * x_s + xi, by=(is_x_end,)),
        Line(Y_s * (I + P * Lambda) * x_s + xi, by=(moves,)),
        Line(Y_s * (x_0 + P * theta) + xi, by=(mean,)),
        Line(
            Y_s * (I + P * Lambda) * x_0 + Y_s * P * (theta - Lambda * x_0) + xi,
            why="add and subtract",
        ),
        Line(Phi * x_0 + Y_s * P * (theta - Lambda * x_0) + xi, by=(moves,)),
    ),
    P_end_by := chain(
        "",
        "the covariance at the end, by the same solve",
        P_end,
        Line(Phi * P_s * Phi.T + Sigma, by=(is_P_end,)),
        Line(Y_s * (I + P * Lambda) * P_s * Phi.T + Sigma, by=(moves,)),
        Line(Y_s * P * Phi.T + Sigma, by=(spread,)),
        Line(Y_s * N_s.T + Sigma, by=(is_N_s,)),
    ),
)


@cache
def late_end():
    """An estimate of the beginning of a stretch, led to its end."""
    return Derivation(
        (Phi, xi, Sigma, theta, Lambda, x_0, P),
        (
            Stage(Both, is_Both.right, symmetric=True, by=(is_Both,)),
            Stage(N_s, is_N_s.right, by=(is_N_s,)),
            Stage(Y_s, Solve(N_s, Both), by=(is_Y_s,)),
            Stage(P_end, P_end_by.right, symmetric=True, by=(P_end_by,)),
            Stage(x_end, x_end_by.right, by=(x_end_by,)),
        ),
        source="our own",
        letters=prior,
        says="an estimate, led through a stretch",
    )


@cache
def derive():
    """The page."""
    page = (*READ, *END, late_end())
    return Derivation(page=page, letters=prior, source="our own")
