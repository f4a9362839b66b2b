"""The best estimator is an observer: from vanishing gradients to its four matrices.

Three combinations of the moments define what the estimator tracks, how it is lifted,
and how it errs.  Each gradient, written in them, has one matrix left.

Source: Haddad and Bernstein (1987), sections 2 to 4, (3.10)-(3.13), remark 3.1.
"""

from functools import cache

from matrixproof import Page, Solve, Stage, ZeroMatrix

from .augmented import is_Qxy, is_Qxy_next, is_Qyy, is_uv, is_vv
from .gradients import is_gradAe, is_gradBe, is_gradCe, is_gradDe
from .letters import SOURCE, assign, l, letters, listed, n, q, r
from .letters.both import P2, P12, Q1, Q2, Q12
from .letters.estimator import Ae, Be, Ce, De
from .letters.kernels import gradAe, gradBe, gradCe, gradDe, u, v
from .letters.plant import V2, V12, A, C, L
from .letters.theorem import Aq, G, Gam, Kq, Q, Q_e, Qs, V2s, tau, xh

letters = letters.here()
eps = letters("eps", n, 1, "its error")
X_G = letters("X_G", n, r, "the transpose of `G`")
X_Gamma = letters("X_Gamma", n, r, "the transpose of `Gamma`")
I_e = letters("I_e", r, r, "`Gamma G'`, which should be the identity")


page = Page(letters=letters, source=SOURCE)

page("""Where the estimator is controllable and observable, `Q_2` and `P_2` have
    inverses. So the mixed moments can be written with a `G` and a `Gamma`. The moment
    of the state is split into that of `xhat = G' x_e` and the rest.""")
is_Q12 = page.let(Q12, G.T * Q2, "section 4")
is_P12 = page.let(P12, -Gam.T * P2, "section 4")
is_Qe = page.let(Q_e, G.T * Q2 * G, "section 4")
is_Q1 = page.let(Q1, Q + Q_e, "section 4")
is_G = page.let(G, X_G.T)
is_Gam = page.let(Gam, X_Gamma.T)
is_Ie = page.let(I_e, Gam * G.T)
is_tau = page.let(tau, G.T * Gam, "3.8")

page("""The error `eps` of `xhat` has the covariance `Q` and is uncorrelated with
    `xhat`. So the innovation `C eps + v` has these moments, and its gain is a
    regression.""")
is_eps = page.moment(eps * eps.T, Q)
orthogonal = page.moment(xh * eps.T, ZeroMatrix(n, n))
page(is_uv, is_vv)
fresh_eps = page.moment(eps * v.T, ZeroMatrix(n, l))
fresh_xh = page.moment(xh * v.T, ZeroMatrix(n, l))
past_eps = page.moment(u * eps.T, ZeroMatrix(n, n))
is_Qs = page.let(Qs, A * Q * C.T + V12, "section 2")
is_V2s = page.let(V2s, C * Q * C.T + V2, "section 2")
is_K = page.suppose(Kq * V2s, Qs)
is_Aq = page.let(Aq, A - Kq * C)
innovation_next = page(
    letters.derive(
        "section 2",
        "next state and innovation",
        (A * xh + A * eps + u) * (C * eps + v).T,
    )
    .expect(is_eps, is_uv, orthogonal, fresh_eps, fresh_xh, past_eps)
    .fold(is_Qs)
)
innovation = page(
    letters.derive(
        "section 2", "the innovation with itself", (C * eps + v) * (C * eps + v).T
    )
    .expect(is_eps, is_vv, fresh_eps)
    .fold(is_V2s)
)

page("The moments of the measurement split in the same way.")
page(is_Qxy, is_Qxy_next, is_Qyy)
next_split = page(
    letters.derive("", "next state and measurement, split", is_Qxy_next)
    .put(is_Q1)
    .expand()
    .fold(is_Qs)
)
split = page(
    letters.derive("", "the measurement with itself, split", is_Qyy)
    .put(is_Q1)
    .expand()
    .fold(is_V2s)
)

page("""In these letters the first gradient is a product. Its outer factors have
    inverses. The second has terms of the first in it.""")
page(is_gradAe, is_gradBe)
in_Ae = page(
    letters.derive("4.8", "the first gradient in these letters", is_gradAe)
    .put(is_Q12, is_P12)
    .factor()
)
in_Be = page(
    letters.derive("4.9", "the second gradient in these letters", is_gradBe)
    .put(next_split, split)
    .put(is_Q12, is_P12, is_Qe)
    .factor()
)

page("Suppose that the first vanishes. Then it is solved for `A_e`.")
with page.scope(letters.suppose(gradAe, ZeroMatrix(r, r), "4.8")) as no_slope_Ae:
    says = "the estimator's own matrix from its gradient"
    from_Ae = page(in_Ae.solved(Ae, no_slope_Ae, "3.10'", says))

    page("Suppose that the second vanishes, too. One `B_e` is left.")
    with page.scope(letters.suppose(gradBe, ZeroMatrix(r, l), "4.9")) as no_slope_Be:
        left_Be = page(
            letters.derive("4.9", "the second gradient where the first vanishes", in_Be)
            .use(from_Ae)
            .fold(is_K)
            .factor()
        )
        says = "the input matrix from the gradients"
        from_Be = page(left_Be.solved(Be, no_slope_Be, "3.11", says))

page("Conversely, with these two matrices both vanish.")
is_Ae = page.let(Ae, from_Ae.right, "3.10'")
is_Be = page.let(Be, from_Be.right, "3.11")
zero_Ae = page(
    letters.derive("3.10'", "where the first gradient vanishes", in_Ae).use(is_Ae)
)
zero_Be = page(
    letters.derive("3.11", "where the second gradient vanishes", in_Be)
    .use(is_Ae)
    .fold(is_K)
    .use(is_Be)
)

page("With this `B_e` the estimator's own matrix has the paper's form.")
gain_Ae = page(
    letters.derive("3.10", "the estimator's own matrix", is_Ae)
    .put(is_Be)
    .factor()
    .fold(is_Aq)
)

page("""The gradient in the output matrix is a product, too, and the last one has terms
    of it.""")
page(is_gradCe, is_gradDe)
in_Ce = page(
    letters.derive("4.10", "the third gradient in these letters", is_gradCe)
    .put(is_Q12)
    .factor()
)
in_De = page(
    letters.derive("4.11", "the last gradient in these letters", is_gradDe)
    .put(split, is_Qxy, is_Q1)
    .put(is_Q12, is_Qe)
    .factor()
)

page("Suppose that the third vanishes. Then it is solved for `C_e`.")
with page.scope(letters.suppose(gradCe, ZeroMatrix(q, r), "4.10")) as no_slope_Ce:
    says = "the output matrix from its gradient"
    from_Ce = page(in_Ce.solved(Ce, no_slope_Ce, "3.12", says))

    page("""Suppose that the last vanishes, too. Then the static gain is a regression
        of `L eps` on the innovation.""")
    with page.scope(letters.suppose(gradDe, ZeroMatrix(q, l), "4.11")) as no_slope_De:
        left_De = page(
            letters.derive("4.11", "the last gradient where the third vanishes", in_De)
            .use(from_Ce)
            .factor()
        )
        says = "the equation of the static gain"
        from_De = page(left_De.solved(De, no_slope_De, "3.13", says))
        says = "the static gain from the gradients"
        page(letters.derive("3.13", says, De).by(L * Q * C.T * V2s.I, from_De))

page("Conversely, with these two matrices both vanish.")
is_Ce = page.let(Ce, (L - De * C) * G.T, "3.12")
is_De = page.suppose(from_De.left, from_De.right, "3.13")
zero_Ce = page(
    letters.derive("3.12", "where the third gradient vanishes", in_Ce).use(is_Ce)
)
zero_De = page(
    letters.derive("3.13", "where the last gradient vanishes", in_De)
    .use(is_Ce)
    .use(is_De)
)


@cache
def projection_innovation():
    """Qs = E[x+ innovation'] and V2s = cov(innovation) when y is predicted by C x^.

    Q is the error covariance of x^; the Kalman filter's too.
    """
    stages = (assign(letters, is_Qs, "section 2"), assign(letters, is_V2s, "section 2"))
    proofs = innovation_next, innovation
    return listed(letters, (A, C, V12, V2, Q), stages, "the innovation", *proofs)


page(projection_innovation())


@cache
def projection_factors():
    """G and Gam from the moments and their duals."""
    stages = (
        Stage(X_G, Solve(Q12, Q2), by=(is_Q12, is_G)),
        Stage(X_Gamma, Solve(-P12, P2), by=(is_P12, is_Gam)),
        assign(letters, is_G),
        assign(letters, is_Gam),
    )
    given = (Q12, Q2, P12, P2)
    return listed(letters, given, stages, "the factors of the projection", zero_Ae)


page(projection_factors())


@cache
def projection_product():
    """tau and Q from the factors; I_e should be I."""
    stages = (
        assign(letters, is_Ie, "(3.9)"),
        assign(letters, is_tau, "(3.8)"),
        Stage(Q, Q1 - G.T * Q12.T, symmetric=True, by=(is_Q1, is_Qe, is_Q12)),
    )
    return listed(letters, (Q1, Q12, G, Gam), stages, "the projection", zero_Ae)


page(projection_product())


@cache
def feedthrough_gain():
    """The static gain De, of an estimator that has one."""
    stages = (Stage(De, Solve(L * Q * C.T, V2s), "(3.13)", by=(is_De,)),)
    return listed(letters, (C, L, Q, V2s), stages, "the static gain", zero_De)


@cache
def projection_gains():
    """Ae, Be, Ce from the projection; De is 0 for an estimator without feedthrough."""
    stages = (
        Stage(Kq, Solve(Qs, V2s), by=(is_K,)),
        assign(letters, is_Aq),
        Stage(Ae, Gam * Aq * G.T, "(3.10)", by=(gain_Ae,)),
        assign(letters, is_Be, "(3.11)"),
        assign(letters, is_Ce, "(3.12)"),
    )
    given = (A, C, L, Qs, V2s, G, Gam, De)
    says = "the matrices of the best estimator"
    return listed(letters, given, stages, says, zero_Ae, zero_Be, zero_Ce)


page(projection_gains())


page(feedthrough_gain())
