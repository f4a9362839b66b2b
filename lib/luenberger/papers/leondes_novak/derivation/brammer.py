"""Brammer's filter for outputs without noise is the same system, drawn differently.

Brammer keeps what the Kalman filter estimates of the states that the perfect outputs do
not show, and reads the others off.  A change of variable turns his filter into the
observer of Leondes and Novak.

Source: Leondes and Novak (1974), section IV.C, (45)-(53); Brammer (1968).
"""

from matrixproof import (
    AtLeast,
    BlockMatrix,
    Expect,
    Line,
    Page,
    Substitute,
    ZeroMatrix,
)

from .best_coordinates import exact, is_Delta, nothing_left, push, unseen, whole
from .canonical_gain import is_V
from .coordinates import is_H
from .letters import *
from .quadratic import is_Kmv, is_N, root_M, square

z_hat = letters("z_hat", r, 1, "Brammer's estimate of `That x`")
z_hat_next = letters("z_hat_next", r, 1, "the same one step on")


page = Page(letters=letters, source=f"{SOURCE}, (45)-(53); Brammer (1968)")

page("""The accurate outputs have no noise, `y_1 = C_1 x`. The estimate puts them in
    their place and takes the rest from `z_hat`. The equations (47) say what `Gamma_1`
    and `Phat` are.""")
page(push, unseen, whole)
other_rows = page(suppose(That * Gamma_1, ZeroMatrix(r, m1), "47"))
inverse = page(suppose(That * Phat, Identity(r), "47"))
shows = page(let(x_hat, Phat * z_hat + Gamma_1 * S1 * y, "46"))
page.chain(
    "46",
    "the estimate shows what was estimated",
    That * x_hat,
    Line(That * Phat * z_hat + That * Gamma_1 * S1 * y, by=(shows,)),
    Line(z_hat, by=(inverse, other_rows)),
)
page.chain(
    "46",
    "the estimate shows the accurate outputs",
    S1 * C * x_hat,
    Line(S1 * C * Phat * z_hat + S1 * C * Gamma_1 * S1 * y, by=(shows,)),
    Line(S1 * y, by=(unseen, push)),
)
perfect = page(suppose(S1 * y, S1 * C * x, "45"))
is_eps = page(let(eps, z_hat - That * x))
error = page.chain(
    "45, 46",
    "the error is that of the rest",
    x_hat - x,
    Line(Phat * z_hat + Gamma_1 * S1 * y - x, by=(shows,)),
    Line(Phat * z_hat + Gamma_1 * S1 * C * x - x, by=(perfect,)),
    Line(Phat * z_hat - Phat * That * x, by=(whole,)),
    Line(Phat * eps, by=(is_eps,)),
)


page("""The rest is corrected as the Kalman filter would, and its gain meets the perfect
    outputs by itself: that is (49) with no noise in them.""")
page(is_Delta, is_N, is_Kmv)
page.chain(
    "49",
    "the Kalman gain shows perfect outputs as they are",
    S1 * C * Kmv,
    Line(S1 - Delta, by=(is_Delta,)),
    Line(S1, by=(nothing_left,)),
)
page.chain(
    "49",
    "the gain",
    Kmv,
    Line(Kmv * M * M.I, why="insert the inverse"),
    Line(N * M.I, by=(is_Kmv,)),
    Line(Omega * C.T * M.I, by=(is_N,)),
)
page(exact)
moves = page(let(z_hat_next, That * (A * x_hat + K * (y_next - C * A * x_hat)), "48"))
shows_next = page(let(x_hat_next, Phat * z_hat_next + Gamma_1 * S1 * y_next, "46"))
page.chain(
    "46, 48",
    "the filter is that of Kalman",
    x_hat_next,
    Line(Phat * z_hat_next + Gamma_1 * S1 * y_next, by=(shows_next,)),
    Line(
        Phat * That * (A * x_hat + K * (y_next - C * A * x_hat))
        + Gamma_1 * S1 * y_next,
        by=(moves,),
    ),
    Line(
        (I - Gamma_1 * S1 * C) * (A * x_hat + K * (y_next - C * A * x_hat))
        + Gamma_1 * S1 * y_next,
        by=(whole,),
    ),
    Line(A * x_hat + K * (y_next - C * A * x_hat), by=(exact,)),
)


page("""Let `z = z_hat - That K y`. The estimate is then that of the observer with `P`
    the basis and `V` the gain.""")
is_z = page(let(z, z_hat - That * K * y))
parted = page.chain(
    "24",
    "the gain is a push and a rest",
    K,
    Line((Gamma_1 * S1 * C + Phat * That) * K, by=(whole,)),
    Line(Gamma_1 * S1 + Phat * That * K, by=(exact,)),
)
page.chain(
    "12, 46",
    "the estimate in the new variable",
    x_hat,
    Line(Phat * z_hat + Gamma_1 * S1 * y, by=(shows,)),
    Line(Phat * z + Phat * That * K * y + Gamma_1 * S1 * y, by=(is_z,)),
    Line(Phat * z + K * y, by=(parted,)),
)

page("It moves as the observer does: Fig. 2 is Fig. 1.")
is_z_next = page(let(z_next, z_hat_next - That * K * y_next))
is_T = page(let(T_next, That * (I - K * C), "25"))
page.chain(
    "42, 48",
    "one system drawn twice",
    z_next,
    Line(z_hat_next - That * K * y_next, by=(is_z_next,)),
    Line(
        That * (A * x_hat + K * (y_next - C * A * x_hat)) - That * K * y_next,
        by=(moves,),
    ),
    Line(That * (I - K * C) * A * x_hat, why="collect"),
    Line(T_next * A * x_hat, by=(is_T,)),
)


page("Its covariances are those of the observer, seen through the basis.")
is_X = page(moment(eps * eps.T, X, "51"))
is_Q = page(moment(w * w.T, Q, "4"))
apart = page(moment(eps * w.T, ZeroMatrix(r, n)))
page.chain(
    "50",
    "the predicted covariance",
    (A * Phat * eps - w) * (A * Phat * eps - w).T,
    Expect(A * Phat * X * Phat.T * A.T + Q, moments=(is_X, is_Q, apart)),
)
kalman = page(suppose(K, Kmv, "49"))
page.chain(
    "51",
    "the covariance of the rest",
    That * Sigma_next * That.T,
    Line(
        That * (Omega - N * Kmv.T + (K - Kmv) * M * (K - Kmv).T) * That.T,
        by=(square,),
    ),
    Line(That * (Omega - N * Kmv.T) * That.T, by=(kalman,)),
    Line(That * (Omega - Kmv * N.T) * That.T, by=(is_Kmv,)),
    Line(That * (I - Kmv * C) * Omega * That.T, by=(is_N,)),
)


page("""In the coordinates of (20) to (23) the basis is the lower part of the identity,
    and (24), (25) come back.""")
is_That = page(suppose(That, BlockMatrix([[ZeroMatrix(r, m1), Identity(r)]]), "52"))
is_Phat = page(suppose(Phat, BlockMatrix([[ZeroMatrix(m1, r)], [Identity(r)]]), "53"))
is_Gamma_1 = page(
    suppose(Gamma_1, BlockMatrix([[Identity(m1)], [ZeroMatrix(r, m1)]]), "53")
)
is_C_1 = page(let(C_1, BlockMatrix([[Identity(m1), ZeroMatrix(m1, r)]]), "52"))
page.chain(
    "47, 52, 53",
    "the basis and the push are columns of the inverse",
    Phat * That + Gamma_1 * C_1,
    Substitute(I, by=(is_Phat, is_That, is_Gamma_1, is_C_1)),
)
page(is_H, is_V)
page.chain(
    "25, 52",
    "what the observer follows",
    That - That * V * H,
    Substitute(
        BlockMatrix([[-K_1, Identity(r) - K_2 * H_2]]), by=(is_That, is_V, is_H)
    ),
)
is_S_1 = page(suppose(S1, BlockMatrix([[Identity(m1), ZeroMatrix(m1, p2)]]), "16"))
is_K_low = page(let(K_low, BlockMatrix([[K_1, K_2]]), "33"))
weight = page.chain(
    "24, 53",
    "the weight of the measurement",
    Gamma_1 * S1 + Phat * K_low,
    Substitute(V, by=(is_Gamma_1, is_S_1, is_Phat, is_K_low, is_V)),
)


page("""The gains (33) of Leondes and Novak solve the lower rows of the equation for the
    Kalman gain. If the accurate outputs are perfect, the upper rows agree as well.""")
lower = page(suppose(K_low * M, That * N, "33"))
solved = page(suppose(K * M, N, "33"))
rows = page.chain(
    "33, 52",
    "the gains are the lower rows of the Kalman gain",
    K_low,
    Line(K_low * M * M.I, why="insert the inverse"),
    Line(That * N * M.I, by=(lower,)),
    Line(That * K * M * M.I, by=(solved,)),
    Line(That * K, why="cancel"),
)
page.chain(
    "after 44",
    "for perfect outputs the weight is the Kalman gain",
    V,
    Line(Gamma_1 * S1 + Phat * K_low, by=(weight,)),
    Line(Gamma_1 * S1 + Phat * That * K, by=(rows,)),
    Line(K, by=(parted,)),
)

page("""No other weight of the measurement errs less. So this is one of the observers
    that Tse and Athans, and Yoshikawa and Kobayashi, ask for: those of least error.""")
page(root_M)
page.chain(
    "after 53",
    "no observer does better",
    Sigma_next,
    Line(Omega - N * Kmv.T + (K - Kmv) * M * (K - Kmv).T, by=(square,)),
    AtLeast(Omega - N * Kmv.T, by=(root_M,), root=(K - Kmv) * L_M),
)
page.chain(
    "after 53",
    "the least error is reached",
    Sigma_next,
    Line(Omega - N * Kmv.T + (K - Kmv) * M * (K - Kmv).T, by=(square,)),
    Line(Omega - N * Kmv.T, by=(kalman,)),
)
