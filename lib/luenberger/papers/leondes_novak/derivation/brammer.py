"""Brammer's filter for outputs without noise is the same system, drawn differently.

Brammer keeps what the Kalman filter estimates of the states that the perfect outputs do
not show, and reads the others off.  A change of variable turns his filter into the
observer of Leondes and Novak.

Source: Leondes and Novak (1974), section IV.C, (45)-(53); Brammer (1968).
"""

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix

from .best_coordinates import exact, is_Delta, nothing_left, push, unseen, whole
from .canonical_gain import is_V
from .coordinates import is_H
from .letters import SOURCE, I, letters, m1, n, p2, r
from .letters.accurate import S1, Delta, Gamma_1, Phat, That
from .letters.canonical import C_1, K_1, K_2, H, K_low
from .letters.observer import T_next, V, X, eps, x_hat, x_hat_next, z, z_next
from .letters.plant import A, C, Q, w, x, y, y_next
from .letters.step import K, Kmv, M, N, Omega, Sigma_next
from .quadratic import is_Kmv, is_N, root_M, square

z_hat = letters("z_hat", r, 1, "Brammer's estimate of `That x`")
z_hat_next = letters("z_hat_next", r, 1, "the same one step on")


page = Page(letters=letters, source=f"{SOURCE}, (45)-(53); Brammer (1968)")

page("""The accurate outputs have no noise, `y_1 = C_1 x`. The estimate puts them in
    their place and takes the rest from `z_hat`. The equations (47) say what `Gamma_1`
    and `Phat` are.""")
page(push, unseen, whole)
other_rows = page.suppose(That * Gamma_1, ZeroMatrix(r, m1), "47")
inverse = page.suppose(That * Phat, Identity(r), "47")
shows = page.let(x_hat, Phat * z_hat + Gamma_1 * S1 * y, "46")
page(
    letters.derive("46", "the estimate shows what was estimated", That * x_hat)
    .put(shows)
    .expand()
    .use(inverse, other_rows)
)
page(
    letters.derive("46", "the estimate shows the accurate outputs", S1 * C * x_hat)
    .put(shows)
    .expand()
    .use(unseen, push)
)
perfect = page.suppose(S1 * y, S1 * C * x, "45")
is_eps = page.let(eps, z_hat - That * x)
error = page(
    letters.derive("45, 46", "the error is that of the rest", x_hat - x)
    .put(shows)
    .use(perfect)
    .use(whole)
    .by(Phat * eps, is_eps)
)

page("""The rest is corrected as the Kalman filter would, and its gain meets the perfect
    outputs by itself: that is (49) with no noise in them.""")
page(is_Delta, is_N, is_Kmv)
says = "the Kalman gain shows perfect outputs as they are"
page(
    letters.derive("49", says, S1 * C * Kmv).by(S1 - Delta, is_Delta).use(nothing_left)
)
page(letters.derive("49", "the gain", Kmv).by(Omega * C.T * M.I, is_Kmv, is_N))
page(exact)
moves = page.let(z_hat_next, That * (A * x_hat + K * (y_next - C * A * x_hat)), "48")
shows_next = page.let(x_hat_next, Phat * z_hat_next + Gamma_1 * S1 * y_next, "46")
page(
    letters.derive("46, 48", "the filter is that of Kalman", x_hat_next)
    .put(shows_next)
    .put(moves)
    .by(A * x_hat + K * (y_next - C * A * x_hat), whole, exact)
)

page("""Let `z = z_hat - That K y`. The estimate is then that of the observer with `P`
    the basis and `V` the gain.""")
is_z = page.let(z, z_hat - That * K * y)
parted = page(
    letters.derive("24", "the gain is a push and a rest", K)
    .insert((Gamma_1 * S1 * C + Phat * That) * K, whole)
    .use(exact)
)
page(
    letters.derive("12, 46", "the estimate in the new variable", x_hat)
    .put(shows)
    .by(Phat * z + K * y, is_z, parted)
)

page("It moves as the observer does: Fig. 2 is Fig. 1.")
is_z_next = page.let(z_next, z_hat_next - That * K * y_next)
is_T = page.let(T_next, That * (I - K * C), "25")
page(
    letters.derive("42, 48", "one system drawn twice", z_next)
    .put(is_z_next)
    .put(moves)
    .by(T_next * A * x_hat, is_T)
)


page("Its covariances are those of the observer, seen through the basis.")
is_X = page.moment(eps * eps.T, X, "51")
is_Q = page.moment(w * w.T, Q, "4")
apart = page.moment(eps * w.T, ZeroMatrix(r, n))
predicted = A * Phat * eps - w
page(
    letters.derive("50", "the predicted covariance", predicted * predicted.T).expect(
        is_X, is_Q, apart
    )
)
kalman = page.suppose(K, Kmv, "49")
page(
    letters.derive("51", "the covariance of the rest", That * Sigma_next * That.T)
    .put(square)
    .put(kalman)
    .by(That * (I - Kmv * C) * Omega * That.T, is_Kmv, is_N)
)

page("""In the coordinates of (20) to (23) the basis is the lower part of the identity,
    and (24), (25) come back.""")
upper, rest, zero = Identity(m1), Identity(r), ZeroMatrix
is_That = page.suppose(That, BlockMatrix([[zero(r, m1), rest]]), "52")
is_Phat = page.suppose(Phat, BlockMatrix([[zero(m1, r)], [rest]]), "53")
is_Gamma_1 = page.suppose(Gamma_1, BlockMatrix([[upper], [zero(r, m1)]]), "53")
is_C_1 = page.let(C_1, BlockMatrix([[upper, zero(m1, r)]]), "52")
says = "the basis and the push are columns of the inverse"
page(
    letters.derive("47, 52, 53", says, Phat * That + Gamma_1 * C_1).by(
        I, is_Phat, is_That, is_Gamma_1, is_C_1
    )
)
page(is_H, is_V)
page(
    letters.derive("25, 52", "what the observer follows", That - That * V * H).multiply(
        is_That, is_V, is_H
    )
)
is_S_1 = page.suppose(S1, BlockMatrix([[upper, zero(m1, p2)]]), "16")
is_K_low = page.let(K_low, BlockMatrix([[K_1, K_2]]), "33")
weight = page(
    letters.derive("24, 53", "the weight of the measurement", V).by(
        Gamma_1 * S1 + Phat * K_low, is_Gamma_1, is_S_1, is_Phat, is_K_low, is_V
    )
)

page("""The gains (33) of Leondes and Novak solve the lower rows of the equation for the
    Kalman gain. If the accurate outputs are perfect, the upper rows agree as well.""")
lower = page.suppose(K_low * M, That * N, "33")
solved = page.suppose(K * M, N, "33")
says = "the gains are the lower rows of the Kalman gain"
rows = page(
    letters.derive("33, 52", says, K_low)
    .insert(K_low * M * M.I, why="insert the inverse")
    .by(That * K, lower, solved)
)
says = "for perfect outputs the weight is the Kalman gain"
page(letters.derive("after 44", says, V).put(weight).by(K, rows, parted))

page("""No other weight of the measurement errs less. So this is one of the observers
    that Tse and Athans, and Yoshikawa and Kobayashi, ask for: those of least error.""")
page(root_M)
page(
    letters.derive("after 53", "no observer does better", Sigma_next)
    .put(square)
    .drop(root_M)
)
page(
    letters.derive("after 53", "the least error is reached", Sigma_next)
    .put(square)
    .use(kalman)
)
