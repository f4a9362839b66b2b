"""How a step moves with what it starts from, and the best gain in the long run.

The gain that is best for the next step need not be best for ever, because the errors
that it leaves feed the steps that follow.  The best constant gain is the step-wise one
for another weight: what an error made now will have cost in the end.

Source: our own; the step is that of Leondes and Novak (1974), (27)-(33), (44).
"""

from functools import cache

from sympy import Trace

from matrixproof import (
    Derivation,
    Differential,
    Gradient,
    Line,
    Page,
    Solve,
    Stage,
    ZeroMatrix,
    plus,
)

from .best_coordinates import gain, is_P
from .huddle import is_F
from .letters import *
from .quadratic import is_Kmv, is_M, is_N, is_Omega, is_Y

dOmega = letters("dOmega", n, n, "change of `Omega`", symmetric=True)
dSigma_0 = letters("dSigma_0", n, n, "change of the covariance before", symmetric=True)
dM = letters("dM", p, p, "change of `M`", symmetric=True)
dKmv = letters("dKmv", n, p, "change of the Kalman filter's gain")
dK = letters("dK", n, p, "change of the gain")
dSigma = letters("dSigma", n, n, "change of the next covariance", symmetric=True)
Phi = letters("Phi", n, n, "moves the error from one estimate to the next")
Lambda = letters("Lambda", n, n, "what an error costs in the end", symmetric=True)
Q_c = letters("Q_c", n, n, "covariance of all noise in one step", symmetric=True)
Gradient_K = letters("Gradient", n, p, "gradient of the steady trace in the gain")


page = Page(letters=letters, source="our own")

page("A step starts from a covariance. If that moves, `Omega` moves with the plant.")
is_dOmega = page(let(dOmega, A * dSigma_0 * A.T))
page.chain(
    "44",
    "how the covariance of the prediction moves",
    A * Sigma * A.T + Q,
    Differential(A * dSigma_0 * A.T, of={Sigma: dSigma_0}),
    Line(dOmega, by=(is_dOmega,)),
)

page("""The covariance of the innovation moves with it, and the gain of the Kalman
    filter as follows.""")
page(is_N, is_M, is_Kmv)
is_dM = page(let(dM, C * dOmega * C.T))
is_dKmv = page(let(dKmv, (I - Kmv * C) * dOmega * C.T * M.I))
page.chain(
    "",
    "how the Kalman filter's gain moves",
    Kmv * M - Omega * C.T,
    Differential(
        dKmv * M + Kmv * dM - dOmega * C.T,
        of={Kmv: dKmv, M: dM, Omega: dOmega},
    ),
    Line(dKmv * M - (I - Kmv * C) * dOmega * C.T, by=(is_dM,)),
    Line(ZeroMatrix(n, p), by=(is_dKmv,)),
)

page("""The push leaves its part of that out. So the gain that runs moves by the same,
    less what the accurate outputs see.""")
runs = page(let(K, gain.right, "33"))
is_dK = page(let(dK, (I - Gamma * C) * dKmv))
page.chain(
    "",
    "how the gain moves",
    gain.right,
    Differential(dKmv - Gamma * C * dKmv, of={Kmv: dKmv}, held=(Gamma,)),
    Line(dK, by=(is_dK,)),
)

page("""The push is also all that the gain lacks to solve (32): what is left over is the
    noise of the accurate outputs.""")
page(is_Y)
over = page.chain(
    "32",
    "what is left over of the gradient",
    K * M - N,
    Line(gain.right * M - N, by=(runs,)),
    Line(Gamma * M - Gamma * C * N, by=(is_Kmv,)),
    Line(Gamma * M - Gamma * C * Omega * C.T, by=(is_N,)),
    Line(Gamma * R, by=(is_M,)),
)

page("With that, the next covariance moves as follows.")
is_dSigma = page(let(dSigma, Y * dOmega * Y.T + dK * R * Gamma.T + Gamma * R * dK.T))
page.chain(
    "27",
    "how the next covariance moves",
    (I - K * C) * Omega * (I - K * C).T + K * R * K.T,
    Differential(
        (I - K * C) * dOmega * (I - K * C).T
        + dK * (K * R - (I - K * C) * Omega * C.T).T
        + (K * R - (I - K * C) * Omega * C.T) * dK.T,
        of={Omega: dOmega, K: dK},
    ),
    Line(
        (I - K * C) * dOmega * (I - K * C).T
        + dK * (K * M - Omega * C.T).T
        + (K * M - Omega * C.T) * dK.T,
        by=(is_M,),
    ),
    Line(
        (I - K * C) * dOmega * (I - K * C).T + dK * (K * M - N).T + (K * M - N) * dK.T,
        by=(is_N,),
    ),
    Line(
        (I - K * C) * dOmega * (I - K * C).T + dK * R * Gamma.T + Gamma * R * dK.T,
        by=(over,),
    ),
    Line(Y * dOmega * Y.T + dK * R * Gamma.T + Gamma * R * dK.T, by=(is_Y,)),
    Line(dSigma, by=(is_dSigma,)),
)


@cache
def closed_loop():
    """What a constant gain makes of errors and noises (A and Q after decorrelation)."""
    return Derivation(
        (A, Q, C, R, K, Phat, That),
        (
            Stage(Y, I - K * C, "(13)", by=(is_Y,)),
            Stage(Phi, Y * A, by=(is_Phi, is_Y)),
            Stage(Q_c, Y * Q * Y.T + K * R * K.T, symmetric=True, by=(is_Q_c, is_Y)),
            Stage(F, That * Phi * Phat, "(14)", by=(moves,)),
        ),
        source="our own",
        letters=letters,
        says="what a constant gain makes of errors and noises",
    )


@cache
def step_differential():
    """How the gain and Sigma_next of `gain_step` move with Sigma, by dSigma_0."""
    moved = (I - Gamma * C) * (I - Kmv * C) * dOmega * C.T
    change = Y * dOmega * Y.T + dK * R * Gamma.T + Gamma * R * dK.T
    return Derivation(
        (A, C, R, Gamma, M, Kmv, Y, dSigma_0),
        (
            Stage(dOmega, A * dSigma_0 * A.T, by=(is_dOmega,)),
            Stage(dK, Solve(moved, M), by=(is_dK, is_dKmv)),
            Stage(dSigma, change, symmetric=True, by=(is_dSigma,)),
        ),
        source="our own",
        letters=letters,
        says="how a step moves with what it starts from",
    )


page(step_differential())


page("""With a constant gain the error moves by `Phi`, and its covariance settles where
    one step repeats it.""")
is_Phi = page(let(Phi, (I - K * C) * A))
is_Q_c = page(let(Q_c, (I - K * C) * Q * (I - K * C).T + K * R * K.T))
page(is_Omega)
closed = page.chain(
    "27, 44",
    "one step with a constant gain",
    (I - K * C) * Omega * (I - K * C).T + K * R * K.T,
    Line(
        (I - K * C) * (A * Sigma * A.T + Q) * (I - K * C).T + K * R * K.T,
        by=(is_Omega,),
    ),
    Line(
        (I - K * C) * A * Sigma * A.T * (I - K * C).T
        + (I - K * C) * Q * (I - K * C).T
        + K * R * K.T,
        why="multiply out",
    ),
    Line(Phi * Sigma * Phi.T + Q_c, by=(is_Phi, is_Q_c)),
)

page("The observer itself moves by less: by what it follows of that.")
page(is_P)
follows = page(let(T_next, That * (I - K * C), "25"))
page(is_F)
moves = page.chain(
    "14, 25",
    "how the observer moves",
    F,
    Line(T_next * A * P, by=(is_F,)),
    Line(That * (I - K * C) * A * Phat, by=(follows, is_P)),
    Line(That * Phi * Phat, by=(is_Phi,)),
)

page("""The steady trace is to be least under that equation, so it gets a multiplier,
    `Lambda`. The Lagrangian must not change with `Sigma`; this says what an error costs
    from now on, each step weighing it anew.""")
is_Lambda = page(suppose(Phi.T * Lambda * Phi + W_e, Lambda))
page.chain(
    "",
    "what an error costs in the end",
    plus(Trace(W_e * Sigma), Trace(Lambda * (Phi * Sigma * Phi.T + Q_c - Sigma))),
    Gradient(
        W_e + Phi.T * Lambda * Phi - Lambda,
        of=Sigma,
        held=(W_e, Lambda, Phi, Q_c),
    ),
    Line(ZeroMatrix(n, n), by=(is_Lambda,)),
)

page("""Nor must it change with the gain. Its gradient is that of a single step with
    `Lambda` for the weight.""")
is_Gradient = page(let(Gradient_K, 2 * Lambda * (K * M - N)))
page.chain(
    "32",
    "the gradient of the steady trace",
    Trace(Lambda * (Omega - K * N.T - N * K.T + K * M * K.T)),
    Gradient(2 * Lambda * (K * M - N), of=K, held=(Lambda, M, N)),
    Line(Gradient_K, by=(is_Gradient,)),
)

page("""So the best constant gain is the step-wise one with `Lambda` for the weight: its
    gradient vanishes in every direction that the accurate outputs leave free.""")
orthogonal = page(suppose(Phat.T * Lambda * Gamma, ZeroMatrix(r, p)))
page.chain(
    "32",
    "no free direction is left",
    Phat.T * Gradient_K,
    Line(2 * Phat.T * Lambda * (K * M - N), by=(is_Gradient,)),
    Line(2 * Phat.T * Lambda * Gamma * R, by=(over,)),
    Line(ZeroMatrix(r, p), by=(orthogonal,)),
)


page(closed_loop())


@cache
def steady_gradient():
    """Gradient of the steady weighted trace with respect to a constant gain K."""
    slope = 2 * Lambda * (K * M - Omega * C.T)
    return Derivation(
        (K, M, Omega, C, Lambda),
        (Stage(Gradient_K, slope, by=(is_Gradient, is_N)),),
        source="our own",
        letters=letters,
        says="the gradient of the steady trace in a constant gain",
    )


page(steady_gradient())
