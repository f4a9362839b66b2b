"""The optimal projection: what the moments of the best estimator say.

With the best gains the block equations of the moment and of its dual make the product
of the two factors a projection, aligned with two matrices.  The paper's section 4
writes in script what the theorem writes with hats; the hats here are the theorem's.
Its (4.13)-(4.16) have a term too many.  It takes for granted that the factors are
biorthogonal, and then that is proved by 0 = 0.  Here they are repaired.

Source: Haddad and Bernstein (1987), section 4, (3.6)-(3.9), (3.17), (4.13)-(4.16).
"""

from functools import cache

from matrixproof import Page, Solve, Stage

from .augmented import is_N2, is_N12, moments
from .cost import duals, is_Lq, is_M2, is_M12
from .letters import SOURCE, assign, letters, listed, n, r
from .letters.both import P2, P12, Q2, Q12
from .letters.estimator import Ae, De
from .letters.kernels import M2, M12, N2, N12
from .letters.plant import A, C, L, R
from .letters.theorem import Aq, G, Gam, Kq, Lq, P_e, Ph, Q_e, Qh, Qs, V2s, tau
from .stationarity import (
    gain_Ae,
    is_Aq,
    is_Be,
    is_Ce,
    is_K,
    is_P12,
    is_Q12,
    is_Qe,
    is_tau,
    next_split,
    split,
)

letters = letters.here()
Q2_plus = letters("Q2_plus", r, r, "an inverse of `Q_2` on its range", symmetric=True)
P2_plus = letters("P2_plus", r, r, "an inverse of `P_2` on its range", symmetric=True)
G_0 = letters("G_0", r, n, "`G` where `Q_2` leaves it open")
Gam_0 = letters("Gam_0", r, n, "`Gamma` where `P_2` leaves it open")
G_open = letters("G_open", r, n, "a `G` for any `Q_2`")
Gam_open = letters("Gam_open", r, n, "a `Gamma` for any `P_2`")


page = Page(letters=letters, source=SOURCE)

page("Recalled are the factors of the moments and the gains of the best estimator.")
page(is_Q12, is_P12, is_Qe)
is_Pe = page.let(P_e, Gam.T * P2 * Gam, "section 4")
page(is_K, is_Aq, is_Lq, is_Be, is_Ce)

page("""Where `Q_2` or `P_2` is singular it leaves `G` or `Gamma` open. Any choice there
    gives the same mixed moments.""")
inverse_Q2 = page.suppose(Q2 * Q2_plus * Q2, Q2)
inverse_P2 = page.suppose(P2 * P2_plus * P2, P2)
is_G_open = page.let(G_open, G_0 + Q2_plus * (Q12.T - Q2 * G_0))
is_Gam_open = page.let(Gam_open, Gam_0 - P2_plus * (P12.T + P2 * Gam_0))
open_G = page(
    letters.derive("section 4", "any such factor lifts the moments", Q2 * G_open)
    .put(is_G_open)
    .put(is_Q12)
    .use(inverse_Q2)
    .fold(is_Q12)
)
open_Gam = page(
    letters.derive("section 4", "any such factor tracks the duals", P2 * Gam_open)
    .put(is_Gam_open)
    .put(is_P12)
    .use(inverse_P2)
    .fold(is_P12)
)

page("""The theorem is about two matrices with hats. The block equations of the moment
    turn into equations for the first hat, those of the dual into equations for the
    second.""")
is_Qh = page.let(Qh, A * Q_e * A.T + Kq * Qs.T, "section 4")
is_Ph = page.let(Ph, Aq.T * P_e * Aq + Lq.T * R * Lq, "section 4")
page(is_N12, is_N2, is_M12, is_M2)
mixed_step = page(
    letters.derive(
        "4.13", "one step of the moment of state and estimator", A * Q12 * Ae.T + N12
    )
    .put(is_N12)
    .put(is_Q12, gain_Ae, is_Be, next_split)
    .fold(is_Qe)
    .use(is_Aq)
    .fold(is_Qh)
)
inner_step = page(
    letters.derive(
        "4.14", "one step of the moment of the estimator", Ae * Q2 * Ae.T + N2
    )
    .put(is_N2)
    .put(gain_Ae, is_Be, is_Q12)
    .fold(is_Qe)
    .use(split)
    .use(is_Aq)
    .use(is_K)
    .fold(is_Qh)
)
mixed_dual_step = page(
    letters.derive(
        "4.15", "one step of the dual of state and estimator", A.T * P12 * Ae + M12
    )
    .put(is_M12)
    .fold(is_Lq)
    .by(
        -(A - Kq * C).T * P_e * Aq * G.T - Lq.T * R * Lq * G.T,
        is_P12,
        is_Pe,
        gain_Ae,
        is_Be,
        is_Ce,
        is_Lq,
    )
    .fold(is_Aq, is_Ph)
)
inner_dual_step = page(
    letters.derive("4.16", "one step of the dual of the estimator", Ae.T * P2 * Ae + M2)
    .put(is_M2)
    .put(gain_Ae, is_Ce)
    .fold(is_Pe, is_Lq)
    .fold(is_Ph)
)

page("In the steady state a step changes nothing.")
mixed, inner, mixed_dual, inner_dual = page(
    *(
        letters.derive(step.number, f"the {which}", block).put(equation).use(step)
        for which, block, equation, step in (
            ("moment of state and estimator", Q12, moments, mixed_step),
            ("moment of the estimator", Q2, moments, inner_step),
            ("dual of state and estimator", P12, duals, mixed_dual_step),
            ("dual of the estimator", P2, duals, inner_dual_step),
        )
    )
)

page("""The first two say that `G` and `Gamma` are biorthogonal, which the paper takes
    for granted where it proves it.""")
one = page(
    letters.derive("3.9", "the factors are biorthogonal", Gam * G.T)
    .by(Gam * Q12 * Q2.I, is_Q12)
    .put(mixed)
    .fold(inner)
)

page("""So `tau = G' Gamma` is a projection. Its rank is `n_e`: between `Gamma` and `G'`
    it is the identity of that size.""")
page(is_tau)
twice = page(
    letters.derive("3.6", "applied twice it does no more", tau * tau)
    .put(is_tau)
    .use(one)
    .fold(is_tau)
)
rank = page(
    letters.derive("3.7", "the rank of the projection", Gam * tau * G.T)
    .put(is_tau)
    .use(one)
)

page("""It takes the hats of the theorem to those of section 4, from one side and from
    both.""")
seen = page(
    letters.derive("3.17", "the projection on the first hat", tau * Qh)
    .put(is_tau)
    .fold(mixed)
    .use(is_Q12)
    .fold(is_Qe)
)
seen_dual = page(
    letters.derive("3.17", "the projection on the second hat", Ph * tau)
    .put(is_tau)
    .fold(mixed_dual)
    .put(is_P12)
    .fold(is_Pe)
)
hidden = page(
    letters.derive("3.15", "the first hat between two projections", tau * Qh * tau.T)
    .use(is_tau)
    .fold(inner)
    .fold(is_Qe)
)
hidden_dual = page(
    letters.derive("3.16", "the second hat between two projections", tau.T * Ph * tau)
    .use(is_tau)
    .fold(inner_dual)
    .fold(is_Pe)
)

page("""What comes out is symmetric, so the projection is aligned with both hats. That
    is what one basis in which both are diagonal amounts to.""")
aligned = page(
    letters.derive("3.17", "the projection is aligned with the first hat", seen).by(
        Qh * tau.T, seen
    )
)
aligned_dual = page(
    letters.derive(
        "3.17", "the projection is aligned with the second hat", seen_dual
    ).by(tau.T * Ph, seen_dual)
)

FRAME = (
    Stage(Kq, Solve(Qs, V2s), by=(is_K,)),
    assign(letters, is_Aq),
    assign(letters, is_Lq),
)


@cache
def open_factors():
    """The same where Q2 or P2 is singular: G_0 and Gam_0 where it leaves them open."""
    stages = assign(letters, is_G_open), assign(letters, is_Gam_open)
    given = (Q12, Q2, P12, P2, Q2_plus, P2_plus, G_0, Gam_0)
    says = "factors where a moment is singular"
    return listed(letters, given, stages, says, open_G, open_Gam)


page(open_factors())


@cache
def projection_scripts():
    """Qh and Ph of the theorem from an estimator's Q2, P2, G and Gam."""
    stages = (
        *FRAME,
        Stage(
            Qh,
            A * G.T * Q2 * G * A.T + Kq * Qs.T,
            "section 4, script Q",
            symmetric=True,
            by=(is_Qh, is_Qe),
        ),
        Stage(
            Ph,
            Aq.T * Gam.T * P2 * Gam * Aq + Lq.T * R * Lq,
            "section 4, script P",
            symmetric=True,
            by=(is_Ph, is_Pe),
        ),
    )
    given = (A, C, L, R, De, Qs, V2s, Q2, P2, G, Gam)
    proofs = mixed, inner, mixed_dual, inner_dual
    return listed(letters, given, stages, "the hats of the theorem", *proofs)


page(projection_scripts())
