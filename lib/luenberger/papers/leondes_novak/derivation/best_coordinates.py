"""The best gain that treats the accurate outputs as exact.

The paper minimises the error trace in coordinates where the accurate outputs are
states.  In the coordinates of the user the same minimum is one completed square: the
gain of the Kalman filter, and a push towards what the accurate outputs show.

Source: Leondes and Novak (1974), section III, (27)-(33); the push is our own.
"""

from sympy import Trace

from matrixproof import Identity, Page, Solve, Stage, ZeroMatrix
from matrixproof.explicit import Construction

from ....theory import observer as observed
from .correlated_noise import is_As, is_D_s, is_F_s, solution
from .huddle import driven, estimate, follows, follows_next, is_e, is_W, moves
from .letters import SOURCE, I, letters, m1, n, p, r
from .letters.accurate import S1, Delta, Gamma, Gamma_1, Phat, That, W_e, Z
from .letters.observer import D, F, G, P, T, T_next, V, W, x_hat
from .letters.plant import A, As, B, C, E, J, Q, R
from .letters.step import K, Kmv, M, Omega, Sigma, Sigma_next
from .quadratic import is_Kmv, is_M, is_N, is_Omega, is_Sigma_next, is_Y, root_M, square
from .stochastic_system import measured, plant

letters = letters.here()
Gamma_0 = letters("Gamma_0", n, m1, "any direction in which they could push")
X_0 = letters("X_0", r, n, "a pseudoinverse of `L_W' Phat`")
G_1 = letters("G_1", m1, m1, "inverse weight seen by accurate outputs", symmetric=True)
L_W = letters("L_W", n, n, "a root of the weight")


page = Page(letters=letters, source=f"{SOURCE}, section III")

page("The gain of least covariance and its letters are those of the quadratic.")
page(is_M, is_N, is_Kmv)

page("""Now the accurate outputs are treated as exact: the estimate must show what they
    show, `S_1 C K = S_1`. Let `Gamma_1` push each accurate output to its value, and let
    `Phat` span what the accurate outputs do not see.""")
push = page.suppose(S1 * C * Gamma_1, Identity(m1), "47")
unseen = page.suppose(S1 * C * Phat, ZeroMatrix(m1, r), "47")
is_Delta = page.let(Delta, S1 - S1 * C * Kmv)
family = Kmv + Gamma_1 * Delta + Phat * Z
page(
    letters.derive("24", "gains that meet the condition", S1 * C * family)
    .use(push, unseen)
    .put(is_Delta)
    .expand()
)

page("""There are no others, because `Gamma_1` and `Phat` together span everything. The
    free part of a gain is `Z = That (K - K_mv)`.""")
exact = page.suppose(S1 * C * K, S1)
whole = page.suppose(Gamma_1 * S1 * C + Phat * That, I, "47")
page(
    letters.derive("24", "every gain that meets it is one of these", K - Kmv)
    .insert((Gamma_1 * S1 * C + Phat * That) * (K - Kmv), whole)
    .expand()
    .use(exact)
    .fold(is_Delta)
    .factor()
)

page("""A choice costs more than the Kalman filter by the trace of the square. If
    `Gamma_1` is orthogonal to `Phat` in the weight, the two parts cost separately, and
    the free part costs least where it is zero.""")
shortest = page.suppose(Gamma_1.T * W_e * Phat, ZeroMatrix(m1, r))
page(root_M)
root_W = page.suppose(W_e, L_W * L_W.T)
change = Gamma_1 * Delta + Phat * Z
cost = Trace(W_e * change * M * change.T)
page(
    letters.derive("30–33", "what a gain costs beyond the Kalman filter", cost)
    .expand()
    .use(shortest)
    .drop(root_W, root_M, of=Z)
)

page("Such a push exists for every weight that is positive definite.")
is_G_1 = page.let(G_1, S1 * C * W_e.I * C.T * S1.T)
page(
    Construction(
        "19",
        "the push of least weight",
        {Gamma_1: W_e.I * C.T * S1.T * G_1.I},
        satisfies=(push, shortest),
        by=(is_G_1, unseen),
        symmetric=letters.symmetric,
    )
)

page("""A weight that is only semidefinite, as that of a few combinations of the state,
    leaves the push free where it weighs nothing. Take any push `Gamma_0`, and let the
    observer take back of it what the weight sees. How much that is, least squares tell:
    `X_0` is the pseudoinverse of `L_W' Phat`, and satisfies its normal equations.""")
any_push = page.suppose(S1 * C * Gamma_0, Identity(m1))
normal = page.suppose(Phat.T * L_W * L_W.T * Phat * X_0, Phat.T * L_W)
page(
    Construction(
        "19",
        "a push of least weight for every weight",
        {Gamma_1: Gamma_0 - Phat * X_0 * L_W.T * Gamma_0},
        satisfies=(push, shortest),
        by=(any_push, unseen, root_W, normal),
        symmetric=letters.symmetric,
    )
)

page("""The paper's own choice of rows in (19) amounts to a weight as well: the one in
    which the accurate outputs and the chosen rows are coordinates of length one.""")
other_rows = page.suppose(That * Gamma_1, ZeroMatrix(r, m1), "47")
weight = C.T * S1.T * S1 * C + That.T * That
says = "the weight that belongs to the paper's coordinates"
page(letters.derive("19", says, Gamma_1.T * weight * Phat).use(unseen).use(other_rows))

page("""So the best gain that treats the accurate outputs as exact is the following. In
    the last line the push has columns for all outputs, zero for those that are not
    accurate: then `Gamma = 0` is the Kalman filter, and one recursion serves all.""")
is_K = page.suppose(K, Kmv + Gamma_1 * Delta, "33")
is_Gamma = page.let(Gamma, Gamma_1 * S1)
gain = page(
    letters.derive("33", "the gain that runs", K)
    .put(is_K)
    .put(is_Delta)
    .expand()
    .fold(is_Gamma)
)

page("""Its price is the noise of the accurate outputs, as far as the Kalman filter
    would have removed it.""")
noise = page(
    letters.derive("", "what is left of the accurate outputs is their noise", Delta * M)
    .put(is_Delta)
    .use(is_Kmv)
    .put(is_N, is_M)
    .expand()
)
page(
    letters.derive("", "the price of treating noise as signal", Sigma_next)
    .put(square)
    .put(is_K)
    .expand()
    .use(noise)
)

page("""Where the accurate outputs have no noise there is nothing to pay and nothing to
    choose: the gain is the Kalman filter's.""")
perfect = page.suppose(S1 * R, ZeroMatrix(m1, p))
nothing_left = page(
    letters.derive("", "perfect outputs leave nothing", Delta)
    .insert(Delta * M * M.I, why="the innovation covariance has an inverse")
    .by(S1 * R * M.I, noise)
    .use(perfect)
)
as_kalman = page(
    letters.derive("", "with perfect outputs the gain is the Kalman filter's", K)
    .put(is_K)
    .use(nothing_left)
)


gain_stage = Stage(K, gain.right, "(33)", by=(gain,))

page("""One step of the recursion goes from the covariance of an error to the gain, and
    to the covariance of the next.""")
page(is_Omega, is_Y, is_Sigma_next)
gain_step = page.program(
    "from one error covariance to the next gain and the next covariance",
    (A, Q, C, R, Gamma, Sigma),
    (is_Omega, "(44)"),
    (is_M, "(33)"),
    Stage(Kmv, Solve(Omega * C.T, M), "(33)", by=(is_Kmv, is_N)),
    gain_stage,
    (is_Y, "(13)"),
    (is_Sigma_next, "(27)"),
)

page("""Written as an observer, a gain that meets the condition is the weight of the
    measurement, and `Phat` the weight of the observer. What it follows is the part of
    the state that the gain leaves, seen through `That`.""")
met = page(
    letters.derive("24", "the accurate outputs are met", Gamma * C * K)
    .put(is_Gamma)
    .use(exact)
    .fold(is_Gamma)
)
is_P = page.let(P, Phat, "24")
is_V = page.let(V, K, "24")
is_T = page.let(T, That * (I - K * C), "25")
page(
    letters.derive("13", "its estimate is unbiased", P * T + V * C)
    .put(is_P, is_V, is_T)
    .use(whole)
    .fold(is_Gamma)
    .use(met)
)

page("""The accurate outputs are met to the last digit by a gain that is put together
    from its two parts.""")
parts = page(
    letters.derive("24", "the two parts of a gain", K)
    .insert((Gamma_1 * S1 * C + Phat * That) * K, whole)
    .use(exact)
    .fold(is_Gamma)
)
exact_gain = page.program(
    "a gain from its two parts",
    (Gamma, Phat, That, K),
    Stage(V, parts.right, "(24)", by=(is_V, parts)),
)

page("""Its other matrices are Huddle's, for the plant with independent noises; the
    input takes the feedthrough along. Neither error then holds state or input.""")
page(is_F_s, is_D_s, is_As, driven, is_W)
page.at("9", "it satisfies the condition on the dynamics", solution)
page(plant, measured, moves, follows, follows_next, estimate, is_e)
page.at("11", "its error is driven by the noises alone", observed.free)
of_state = dict(L=I, w_hat=x_hat)
page.at("13, 26", "and so is that of its estimate", observed.error, **of_state)
observer = page.program(
    "from a gain to the observer that has it",
    (As, B, J, C, E, Phat, That, K, T_next),
    Stage(T, That - That * K * C, "(25)", by=(is_T,)),
    Stage(F, T_next * As * Phat, "(14)", by=(is_F_s, is_P)),
    Stage(D, T_next * As * K + T_next * J, "(15)", by=(is_D_s, is_V)),
    Stage(G, T_next * B - D * E, "(10)", by=(driven,)),
    Stage(W, -K * E, by=(is_W, is_V)),
)
