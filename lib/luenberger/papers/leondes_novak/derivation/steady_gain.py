"""How a step moves with what it starts from, and the best gain in the long run.

The gain that is best for the next step need not be best for ever, because the errors
that it leaves feed the steps that follow.  The best constant gain is the step-wise one
for another weight: what an error made now will have cost in the end.

Source: our own; the step is that of Leondes and Novak (1974), (27)-(33), (44).
"""

from sympy import Trace

from matrixproof import Page, Solve, Stage, ZeroMatrix
from matrixproof.symbols import plus

from .best_coordinates import gain, is_P
from .huddle import is_F
from .letters import I, letters, n, p, r
from .letters.accurate import Gamma, Phat, That, W_e
from .letters.observer import F, T_next
from .letters.plant import A, C, Q, R
from .letters.step import K, Kmv, M, N, Omega, Sigma, Y
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
is_dOmega = page.let(dOmega, A * dSigma_0 * A.T)
page(
    letters.derive(
        "44", "how the covariance of the prediction moves", A * Sigma * A.T + Q
    )
    .differential({Sigma: dSigma_0})
    .fold(is_dOmega)
)

page("""The covariance of the innovation moves with it, and the gain of the Kalman
    filter as follows.""")
page(is_N, is_M, is_Kmv)
is_dM = page.let(dM, C * dOmega * C.T)
is_dKmv = page.let(dKmv, (I - Kmv * C) * dOmega * C.T * M.I)
page(
    letters.derive("", "how the Kalman filter's gain moves", Kmv * M - Omega * C.T)
    .differential({Kmv: dKmv, M: dM, Omega: dOmega})
    .put(is_dM)
    .use(is_dKmv)
)

page("""The push leaves its part of that out. So the gain that runs moves by the same,
    less what the accurate outputs see.""")
runs = page.let(K, gain.right, "33")
is_dK = page.let(dK, (I - Gamma * C) * dKmv)
page(
    letters.derive("", "how the gain moves", gain.right)
    .differential({Kmv: dKmv}, held=(Gamma,))
    .fold(is_dK)
)

page("""The push is also all that the gain lacks to solve (32): what is left over is the
    noise of the accurate outputs.""")
page(is_Y)
over = page(
    letters.derive("32", "what is left over of the gradient", K * M - N)
    .put(runs)
    .use(is_Kmv)
    .put(is_N)
    .use(is_M)
)

page("With that, the next covariance moves as follows.")
is_dSigma = page.let(dSigma, Y * dOmega * Y.T + dK * R * Gamma.T + Gamma * R * dK.T)
says = "how the next covariance moves"
page(
    letters.derive("27", says, (I - K * C) * Omega * (I - K * C).T + K * R * K.T)
    .differential({Omega: dOmega, K: dK})
    .fold(is_M, is_N)
    .use(over)
    .fold(is_Y, is_dSigma)
)

step_differential = page.program(
    "how a step moves with what it starts from",
    (A, C, R, Gamma, M, Kmv, Y, dSigma_0),
    Stage(dOmega, A * dSigma_0 * A.T, by=(is_dOmega,)),
    Stage(
        dK,
        Solve((I - Gamma * C) * (I - Kmv * C) * dOmega * C.T, M),
        by=(is_dK, is_dKmv),
    ),
    is_dSigma,
)


page("""With a constant gain the error moves by `Phi`, and its covariance settles where
    one step repeats it.""")
is_Phi = page.let(Phi, (I - K * C) * A)
is_Q_c = page.let(Q_c, (I - K * C) * Q * (I - K * C).T + K * R * K.T)
page(is_Omega)
says = "one step with a constant gain"
closed = page(
    letters.derive("27, 44", says, (I - K * C) * Omega * (I - K * C).T + K * R * K.T)
    .put(is_Omega)
    .fold(is_Phi, is_Q_c)
)

page("The observer itself moves by less: by what it follows of that.")
page(is_P)
follows = page.let(T_next, That * (I - K * C), "25")
page(is_F)
moves = page(
    letters.derive("14, 25", "how the observer moves", F)
    .put(is_F, follows, is_P)
    .fold(is_Phi)
)

page("""The steady trace is to be least under that equation, so it gets a multiplier,
    `Lambda`. The Lagrangian must not change with `Sigma`; this says what an error costs
    from now on, each step weighing it anew.""")
is_Lambda = page.suppose(Phi.T * Lambda * Phi + W_e, Lambda)
page(
    letters.derive(
        "",
        "what an error costs in the end",
        plus(Trace(W_e * Sigma), Trace(Lambda * (Phi * Sigma * Phi.T + Q_c - Sigma))),
    )
    .gradient(Sigma, held=(W_e, Lambda, Phi, Q_c))
    .use(is_Lambda)
)

page("""Nor must it change with the gain. Its gradient is that of a single step with
    `Lambda` for the weight.""")
is_Gradient = page.let(Gradient_K, 2 * Lambda * (K * M - N))
page(
    letters.derive(
        "32",
        "the gradient of the steady trace",
        Trace(Lambda * (Omega - K * N.T - N * K.T + K * M * K.T)),
    )
    .gradient(K, held=(Lambda, M, N))
    .fold(is_Gradient)
)

page("""So the best constant gain is the step-wise one with `Lambda` for the weight: its
    gradient vanishes in every direction that the accurate outputs leave free.""")
orthogonal = page.suppose(Phat.T * Lambda * Gamma, ZeroMatrix(r, p))
page(
    letters.derive("32", "no free direction is left", Phat.T * Gradient_K)
    .put(is_Gradient)
    .use(over, orthogonal)
)

closed_loop = page.program(
    "what a constant gain makes of errors and noises",
    (A, Q, C, R, K, Phat, That),
    Stage(Y, I - K * C, "(13)", by=(is_Y,)),
    Stage(Phi, Y * A, by=(is_Phi, is_Y)),
    Stage(Q_c, Y * Q * Y.T + K * R * K.T, symmetric=True, by=(is_Q_c, is_Y)),
    Stage(F, That * Phi * Phat, "(14)", by=(moves,)),
)

steady_gradient = page.program(
    "the gradient of the steady trace in a constant gain",
    (K, M, Omega, C, Lambda),
    Stage(Gradient_K, 2 * Lambda * (K * M - Omega * C.T), by=(is_Gradient, is_N)),
)
