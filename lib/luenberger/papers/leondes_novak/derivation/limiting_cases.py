"""What the reduced-order filter becomes at the ends of its range.

If all outputs are accurate, it is the observer of least order; if none is, it is the
Kalman filter.  In between, every observer of this form is a filter that predicts and
corrects.

Source: Leondes and Novak (1974), section IV, (37)-(44).
"""

from matrixproof import BlockMatrix, Identity, Page, Relation, ZeroMatrix

from .correlated_noise import is_Sigma
from .huddle import is_D, is_F
from .letters import SOURCE, I, letters, n, p, r
from .letters.canonical import K_1, R_11, H, N_low, Omega_11, Omega_21
from .letters.observer import D, F, P, T, T_next, V, X, x_hat, x_hat_next, z, z_next
from .letters.plant import A, C, Q, R, y, y_next
from .letters.step import K, M, N
from .quadratic import is_N, is_Omega

P_next = letters("P_next", n, r, "`P` one step on")
V_next = letters("V_next", n, p, "`V` one step on")


def at(order):
    """What stands for every order, at one: an expression or a relation."""

    def put(what):
        if isinstance(what, Relation):
            return what.mapped(put)
        return what.subs(r, order)

    return put


least, whole = at(n - p), at(n)


page = Page(
    letters=letters, source=f"{SOURCE}, section IV", limits=({r: n - p}, {r: n})
)

page("""If all outputs are accurate, `m_1 = p`, the second gain has no columns. The
    matrices of (24) and (25) lose theirs, and what is left satisfies (13) as it
    stands.""")
least_P = page.let(
    least(P), BlockMatrix([[ZeroMatrix(p, n - p)], [Identity(n - p)]]), "38"
)
least_V = page.let(V, BlockMatrix([[Identity(p)], [least(K_1)]]), "38")
least_T = page.let(least(T), BlockMatrix([[-least(K_1), Identity(n - p)]]), "38")
least_H = page.let(H, BlockMatrix([[Identity(p), ZeroMatrix(p, n - p)]]), "18")
page(
    letters.derive(
        "38", "the observer of least order is unbiased", least(P) * least(T) + V * H
    ).multiply(least_P, least_T, least_V, least_H)
)

page("""Of the equation for the gains one block is left. It gives the gain of the
    earlier paper.""")
one_block = page.let(M, least(Omega_11) + least(R_11), "33")
one_column = page.let(least(N_low), least(Omega_21), "33")
only_gain = page.suppose(least(K_1) * M, least(N_low), "33")
page(
    letters.derive("37", "the gain of least order", least(K_1))
    .by(least(N_low) * M.I, only_gain)
    .put(one_block, one_column)
)


page("""If none is accurate, `m_1 = 0`, the first gain has no columns and the other is
    `n` by `p`.""")
whole_P = page.let(whole(P), I, "40")
whole_V = page.suppose(V, K, "39")
whole_T = page.let(whole(T), I - K * C, "40")
page(
    letters.derive(
        "40", "the observer of full order is unbiased", whole(P) * whole(T) + V * C
    )
    .put(whole_P)
    .use(whole_V)
    .put(whole_T)
    .expand()
)

page("""Its gain solves (33) with all rows of `N` instead of the lower ones: it is the
    gain of the Kalman filter.""")
page(is_N)
all_rows = page.suppose(K * M, whole(P).T * N, "33")
page(
    letters.derive("33, 39", "the gain is that of the Kalman filter", K)
    .by(whole(P).T * N * M.I, all_rows)
    .use(whole_P)
    .put(is_N)
)


page("""The observer can be written so that it predicts and corrects. This holds for
    every order, not only for the Kalman filter, where `P = I` and `V = K`.""")
moves_alone = page.let(z_next, F * z + D * y, "7")
page(is_F, is_D)
shows = page.let(x_hat, P * z + V * y, "12")
next_shows = page.let(x_hat_next, P_next * z_next + V_next * y_next, "41")
predicted = page(
    letters.derive("42", "the observer predicts", z_next)
    .put(moves_alone, is_F, is_D)
    .fold(shows)
)
still_unbiased = page.suppose(P_next * T_next + V_next * C, I, "13")
page(
    letters.derive("41–43", "the estimate corrects what is predicted", x_hat_next)
    .put(next_shows, predicted)
    .use(still_unbiased)
    .factor()
)

page("The covariance of the predicted error is the one that the Kalman filter uses.")
page(is_Sigma, is_Omega)
says = "the predicted covariance"
page(
    letters.derive("44", says, A * P * X * P.T * A.T + A * V * R * V.T * A.T + Q).fold(
        is_Sigma, is_Omega
    )
)
