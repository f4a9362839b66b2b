"""The best estimator is an observer: from vanishing gradients to its four matrices.

Three combinations of the moments define what the estimator tracks, how it is lifted,
and how it errs.  Each gradient, written in them, has one matrix left.

Source: Haddad and Bernstein (1987), sections 2 to 4, (3.10)-(3.13), remark 3.1.
"""

from functools import cache

from matrixproof import Expect, Line, Page, Solve, Stage, ZeroMatrix

from .augmented import is_Qxy, is_Qxy_next, is_Qyy, is_uv, is_vv
from .gradients import is_gradAe, is_gradBe, is_gradCe, is_gradDe
from .letters import *

hardly = Ae - (Gam * A * G.T - Be * C * G.T)
missing = Ce - (L - De * C) * G.T


page = Page(letters=letters, source=SOURCE)

page("""Where the estimator is controllable and observable, `Q_2` and `P_2` have
    inverses. So the mixed moments can be written with a `G` and a `Gamma`. The moment
    of the state is split into that of `xhat = G' x_e` and the rest.""")
is_Q12 = page(let(Q12, G.T * Q2, "section 4"))
is_P12 = page(let(P12, -Gam.T * P2, "section 4"))
is_Qe = page(let(Q_e, G.T * Q2 * G, "section 4"))
is_Q1 = page(let(Q1, Q + Q_e, "section 4"))
is_G = page(let(G, X_G.T))
is_Gam = page(let(Gam, X_Gamma.T))
is_Ie = page(let(I_e, Gam * G.T))
is_tau = page(let(tau, G.T * Gam, "3.8"))

page("""The error `eps` of `xhat` has the covariance `Q` and is uncorrelated with
    `xhat`. So the innovation `C eps + v` has these moments, and its gain is a
    regression.""")
is_eps = page(moment(eps * eps.T, Q))
orthogonal = page(moment(xh * eps.T, ZeroMatrix(n, n)))
page(is_uv, is_vv)
fresh_eps = page(moment(eps * v.T, ZeroMatrix(n, l)))
fresh_xh = page(moment(xh * v.T, ZeroMatrix(n, l)))
past_eps = page(moment(u * eps.T, ZeroMatrix(n, n)))
is_Qs = page(let(Qs, A * Q * C.T + V12, "section 2"))
is_V2s = page(let(V2s, C * Q * C.T + V2, "section 2"))
is_K = page(suppose(Kq * V2s, Qs))
is_Aq = page(let(Aq, A - Kq * C))
innovation_next = page.chain(
    "section 2",
    "next state and innovation",
    (A * xh + A * eps + u) * (C * eps + v).T,
    Expect(
        A * Q * C.T + V12,
        moments=(is_eps, is_uv, orthogonal, fresh_eps, fresh_xh, past_eps),
    ),
    Line(Qs, by=(is_Qs,)),
)
innovation = page.chain(
    "section 2",
    "the innovation with itself",
    (C * eps + v) * (C * eps + v).T,
    Expect(C * Q * C.T + V2, moments=(is_eps, is_vv, fresh_eps)),
    Line(V2s, by=(is_V2s,)),
)

page("The moments of the measurement split in the same way.")
page(is_Qxy, is_Qxy_next, is_Qyy)
next_split = page.chain(
    "",
    "next state and measurement, split",
    Qxy_next,
    Line(A * Q1 * C.T + V12, by=(is_Qxy_next,)),
    Line(A * Q * C.T + A * Q_e * C.T + V12, by=(is_Q1,)),
    Line(Qs + A * Q_e * C.T, by=(is_Qs,)),
)
split = page.chain(
    "",
    "the measurement with itself, split",
    Qyy,
    Line(C * Q1 * C.T + V2, by=(is_Qyy,)),
    Line(C * Q * C.T + C * Q_e * C.T + V2, by=(is_Q1,)),
    Line(V2s + C * Q_e * C.T, by=(is_V2s,)),
)

page("""In these letters the first gradient is a product. Its outer factors have
    inverses, so it vanishes for one `A_e` alone.""")
page(is_gradAe)
in_Ae = page.chain(
    "4.8",
    "the first gradient in these letters",
    gradAe,
    Line(is_gradAe.right, by=(is_gradAe,)),
    Line(2 * P2 * hardly * Q2, by=(is_Q12, is_P12)),
)

page("Suppose that it vanishes.")
with page.scope(suppose(gradAe, ZeroMatrix(r, r), "4.8")) as no_slope_Ae:
    page.chain(
        "3.10'",
        "the estimator's own matrix from its gradient",
        Ae,
        Line(Ae - P2.I * gradAe * Q2.I / 2, by=(no_slope_Ae,)),
        Line(Gam * A * G.T - Be * C * G.T, by=(in_Ae,)),
    )

page("Conversely, with this matrix it vanishes.")
is_Ae = page(let(Ae, Gam * A * G.T - Be * C * G.T, "3.10'"))
zero_Ae = page.chain(
    "3.10'",
    "where the first gradient vanishes",
    gradAe,
    Line(2 * P2 * hardly * Q2, by=(in_Ae,)),
    Line(ZeroMatrix(r, r), by=(is_Ae,)),
)

page("""The second gradient has the first one's factor in it. Where both vanish, one
    `B_e` is left.""")
page(is_gradBe)
in_Be = page.chain(
    "4.9",
    "the second gradient in these letters",
    gradBe,
    Line(is_gradBe.right, by=(is_gradBe,)),
    Line(
        2 * (P12.T * (Qs + A * Q_e * C.T))
        + 2 * P2 * (Be * (V2s + C * Q_e * C.T) + Ae * Q12.T * C.T),
        by=(next_split, split),
    ),
    Line(
        2 * P2 * (Be * V2s - Gam * Qs) + 2 * P2 * hardly * Q2 * G * C.T,
        by=(is_Q12, is_P12, is_Qe),
    ),
)

page("Suppose that this one vanishes, too.")
no_slope_Be = suppose(gradBe, ZeroMatrix(r, l), "4.9")
with page.scope(no_slope_Ae, no_slope_Be):
    page.chain(
        "3.11",
        "the input matrix from the gradients",
        Be,
        Line(
            Be - P2.I * (gradBe - gradAe * G * C.T) * V2s.I / 2,
            by=(no_slope_Ae, no_slope_Be),
        ),
        Line(Gam * Qs * V2s.I, by=(in_Ae, in_Be)),
        Line(Gam * Kq, by=(is_K,)),
    )

page("Conversely, with these two matrices it vanishes.")
is_Be = page(let(Be, Gam * Kq, "3.11"))
zero_Be = page.chain(
    "3.11",
    "where the second gradient vanishes",
    gradBe,
    Line(in_Be.right, by=(in_Be,)),
    Line(2 * P2 * (Be * V2s - Gam * Qs), by=(is_Ae,)),
    Line(2 * P2 * (Be - Gam * Kq) * V2s, by=(is_K,)),
    Line(ZeroMatrix(r, l), by=(is_Be,)),
)

page("With this `B_e` the estimator's own matrix has the paper's form.")
gain_Ae = page.chain(
    "3.10",
    "the estimator's own matrix",
    Ae,
    Line(Gam * A * G.T - Be * C * G.T, by=(is_Ae,)),
    Line(Gam * (A - Kq * C) * G.T, by=(is_Be,)),
    Line(Gam * Aq * G.T, by=(is_Aq,)),
)

page("The gradient in the output matrix is a product, too.")
page(is_gradCe)
in_Ce = page.chain(
    "4.10",
    "the third gradient in these letters",
    gradCe,
    Line(is_gradCe.right, by=(is_gradCe,)),
    Line(2 * R * missing * Q2, by=(is_Q12,)),
)

page("Suppose that it vanishes.")
with page.scope(suppose(gradCe, ZeroMatrix(q, r), "4.10")) as no_slope_Ce:
    page.chain(
        "3.12",
        "the output matrix from its gradient",
        Ce,
        Line(Ce - R.I * gradCe * Q2.I / 2, by=(no_slope_Ce,)),
        Line((L - De * C) * G.T, by=(in_Ce,)),
    )

page("Conversely, with this matrix it vanishes.")
is_Ce = page(let(Ce, (L - De * C) * G.T, "3.12"))
zero_Ce = page.chain(
    "3.12",
    "where the third gradient vanishes",
    gradCe,
    Line(2 * R * missing * Q2, by=(in_Ce,)),
    Line(ZeroMatrix(q, r), by=(is_Ce,)),
)

page("""The last gradient has that product in it. Where both vanish, the static gain is
    a regression of `L eps` on the innovation.""")
page(is_gradDe)
in_De = page.chain(
    "4.11",
    "the last gradient in these letters",
    gradDe,
    Line(is_gradDe.right, by=(is_gradDe,)),
    Line(
        2 * R * (De * (V2s + C * Q_e * C.T) + Ce * Q12.T * C.T - L * Q1 * C.T),
        by=(split, is_Qxy),
    ),
    Line(
        2 * R * (De * V2s - L * Q * C.T) + 2 * R * missing * Q2 * G * C.T,
        by=(is_Q12, is_Qe, is_Q1),
    ),
)

page("Suppose that this one vanishes, too.")
no_slope_De = suppose(gradDe, ZeroMatrix(q, l), "4.11")
with page.scope(no_slope_Ce, no_slope_De):
    page.chain(
        "3.13",
        "the static gain from the gradients",
        De,
        Line(
            De - R.I * (gradDe - gradCe * G * C.T) * V2s.I / 2,
            by=(no_slope_Ce, no_slope_De),
        ),
        Line(L * Q * C.T * V2s.I, by=(in_Ce, in_De)),
    )

page("Conversely, with these two matrices it vanishes.")
is_De = page(suppose(De * V2s, L * Q * C.T, "3.13"))
zero_De = page.chain(
    "3.13",
    "where the last gradient vanishes",
    gradDe,
    Line(in_De.right, by=(in_De,)),
    Line(2 * R * (De * V2s - L * Q * C.T), by=(is_Ce,)),
    Line(ZeroMatrix(q, l), by=(is_De,)),
)


@cache
def projection_innovation():
    """Qs = E[x+ innovation'] and V2s = cov(innovation) when y is predicted by C x^.

    Q is the error covariance of x^; the Kalman filter's too.
    """
    stages = (assign(is_Qs, "section 2"), assign(is_V2s, "section 2"))
    proofs = innovation_next, innovation
    return listed((A, C, V12, V2, Q), stages, "the innovation", *proofs)


page(projection_innovation())


@cache
def projection_factors():
    """G and Gam from the moments and their duals."""
    stages = (
        Stage(X_G, Solve(Q12, Q2), by=(is_Q12, is_G)),
        Stage(X_Gamma, Solve(-P12, P2), by=(is_P12, is_Gam)),
        assign(is_G),
        assign(is_Gam),
    )
    given = (Q12, Q2, P12, P2)
    return listed(given, stages, "the factors of the projection", zero_Ae)


page(projection_factors())


@cache
def projection_product():
    """tau and Q from the factors; I_e should be I."""
    stages = (
        assign(is_Ie, "(3.9)"),
        assign(is_tau, "(3.8)"),
        Stage(Q, Q1 - G.T * Q12.T, symmetric=True, by=(is_Q1, is_Qe, is_Q12)),
    )
    return listed((Q1, Q12, G, Gam), stages, "the projection", zero_Ae)


page(projection_product())


@cache
def feedthrough_gain():
    """The static gain De, of an estimator that has one."""
    stages = (Stage(De, Solve(L * Q * C.T, V2s), "(3.13)", by=(is_De,)),)
    return listed((C, L, Q, V2s), stages, "the static gain", zero_De)


@cache
def projection_gains():
    """Ae, Be, Ce from the projection; De is 0 for an estimator without feedthrough."""
    stages = (
        Stage(Kq, Solve(Qs, V2s), by=(is_K,)),
        assign(is_Aq),
        Stage(Ae, Gam * Aq * G.T, "(3.10)", by=(gain_Ae,)),
        assign(is_Be, "(3.11)"),
        assign(is_Ce, "(3.12)"),
    )
    given = (A, C, L, Qs, V2s, G, Gam, De)
    says = "the matrices of the best estimator"
    return listed(given, stages, says, zero_Ae, zero_Be, zero_Ce)


page(projection_gains())


page(feedthrough_gain())
