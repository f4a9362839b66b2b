"""Full order: the projection is the identity, and the filter is Kalman's.

The two equations that are left look coupled.  But the sum of their solutions is the
plant's own moment, known beforehand.  So the first is the Riccati equation of the plant
with all its noise.

Source: Haddad and Bernstein (1987), corollary 3.1 and remark 3.6; that the equations
decouple, and the predictor as a plant, are our own.
"""

from functools import cache

from matrixproof import Page, Solve, Stage, ZeroMatrix

from .augmented import is_V1
from .equations import (
    best,
    riccati_equation,
    second,
    written_Qs,
    written_V1,
    written_V2s,
)
from .letters import SOURCE, I, assign, l, letters, listed, n, q, r
from .letters.both import Q1, Q12
from .letters.estimator import Ae, Be, Ce, De
from .letters.kernels import Qxy, Qyy, S_e
from .letters.plant import A1, C1, V1, W1, A, C, L, y
from .letters.theorem import Aq, G, Gam, Kq, Lq, Q, Q_e, Qh, Qs, V2s, tau, tau_perp, xh
from .sensitivity import silent
from .stationarity import (
    gain_Ae,
    is_Aq,
    is_Be,
    is_Ce,
    is_De,
    is_K,
    is_Q1,
    is_Qxy,
    next_split,
    split,
)

letters = letters.here()
De0 = letters("De0", q, l, "static gain of any estimator")
extra = letters("D_x", q, l, "what it has beyond the Kalman filter's")
S_x = letters("S_x", q, q, "second moment of the predictor's output and the estimate")
V1i = letters("V1i", n, n, "noise that moves the predictor", symmetric=True)


def at_n(expr):
    """An expression or a relation with n_e = n."""
    if hasattr(expr, "relation"):
        expr = expr.relation
    if hasattr(expr, "name") and hasattr(expr, "show"):
        return expr.mapped(at_n)
    return expr.subs(r, n)


G_n, Gam_n = at_n(G), at_n(Gam)
Ae_n, Be_n, Ce_n = at_n(Ae), at_n(Be), at_n(Ce)
S_0 = (L - De0 * C) * Q12 * Ce.T


page = Page(letters=letters, source=SOURCE, limits=({r: n},))

page("""With `n_e = n` the product `Gamma G' = I` is that of two square matrices. In a
    basis of one's choice both are the identity, and so is the projection.""")
is_G = page.suppose(G_n, I)
is_Gam = page.suppose(Gam_n, I)
is_tau = page(at_n(letters.let(tau, G.T * Gam, "3.8")))
whole = page(
    letters.derive("3.8", "the projection at full order", is_tau).use(is_G, is_Gam)
)

page("The matrices of the estimator lose their factors.")
page(is_Aq)
full_Be = page(at_n(is_Be))
full_Ce = page(at_n(is_Ce))
page(is_K, is_De)
full_Ae = page(at_n(gain_Ae))
page(
    letters.derive("3.21", "the estimator's own matrix at full order", full_Ae)
    .use(is_G, is_Gam)
    .put(is_Aq)
    .by(A - Qs * V2s.I * C, is_K)
)
page(
    letters.derive("3.22", "its input matrix at full order", full_Be)
    .use(is_Gam)
    .by(Qs * V2s.I, is_K)
)
full_output = page(
    letters.derive("3.23", "its output matrix at full order", full_Ce).use(is_G)
)
page(
    letters.derive("3.24", "its static gain at full order", De).by(
        L * Q * C.T * V2s.I, is_De
    )
)

page("The equations lose the projection.")
is_perp = page.let(tau_perp, I - tau, "section 2")
full_Q = page(
    letters.derive("3.25", "the Riccati equation at full order", riccati_equation)
    .put(is_perp)
    .use(whole)
)
full_Qh = page(
    letters.derive("3.26", "the second equation at full order", second).use(whole)
)
page(
    letters.derive("3.27", "the least error at full order", best).by(
        L * (Q - Q * C.T * V2s.I * C * Q) * L.T, is_De
    )
)

page("So do the noise of the parameters and the moments of the innovation.")
full_Qs = page(
    letters.derive(
        "section 2", "next state and innovation at full order", written_Qs
    ).put(whole)
)
full_V2s = page(
    letters.derive("section 2", "the innovation at full order", written_V2s).use(whole)
)

page("""The sum of the two equations is the plant's own. So `Q + Qh` is known before the
    filter is, and (3.25) is the Riccati equation of a Kalman filter.""")
page(
    letters.derive("3.25, 3.26", "the sum depends on no filter", Q + Qh)
    .put(full_Q)
    .put(full_Qh)
    .use(written_V1)
    .use(whole)
    .factor()
)

page("Without noise in the parameters it is Kalman's own, and nothing is left of `Qh`.")
page(is_V1)
certain = page.suppose(A1, ZeroMatrix(n, n))
page(
    letters.derive("3.25", "the equation of the Kalman filter", full_Q)
    .put(is_V1)
    .use(certain)
    .by(A * Q * A.T + W1 - Qs * V2s.I * Qs.T, is_K)
)

page("""So it depends on `Qh` no more, and (3.26) is superfluous. The same holds of the
    innovation. Without feedthrough the filter says `L xhat`.""")
certain_C = page.suppose(C1, ZeroMatrix(l, n))
page(
    letters.derive(
        "remark 3.6", "next state and innovation of the Kalman filter", full_Qs
    ).use(certain)
)
page(
    letters.derive("remark 3.6", "the innovation of the Kalman filter", full_V2s).use(
        certain_C
    )
)
page(silent)
page(
    letters.derive("remark 3.6", "the output of the Kalman filter", full_output).use(
        silent
    )
)

page("""The estimator is the predictor of that filter. Its static gain is the
    measurement update.""")
page(
    letters.derive("3.21, 3.22", "the estimator is the predictor", Aq * xh + Kq * y)
    .put(is_Aq)
    .factor()
)
page(
    letters.derive(
        "3.23, 3.24", "the estimate is the update", (L - De * C) * xh + De * y
    )
    .factor()
    .by(L * (xh + Q * C.T * V2s.I * (y - C * xh)), is_De)
)

page("""The predictor is itself a plant, `xhat_next = A xhat + K_q i` and `y = C xhat +
    i` with the innovation `i` for noise. Any estimator has the same moments on it,
    because both sides split alike. Beyond the Kalman filter it costs what it costs
    there, with a static gain of `D_x`. That excess is free of cancellation.""")
is_V1i = page.let(V1i, Kq * Qs.T)
is_Lq = page.let(Lq, L - De * C)
is_extra = page.let(extra, De0 - De)
page(is_Q1, is_Qxy)
is_S0 = page.let(S_e, S_0 + L * Qxy * De0.T)
is_Sx = page.let(S_x, S_0 + Lq * Q_e * C.T * extra.T)
excess = page(
    letters.derive(
        "",
        "what an estimator costs beyond the Kalman filter",
        L * Q1 * L.T - S_e - S_e.T + De0 * Qyy * De0.T - L * Q * L.T + De * V2s * De.T,
    )
    .use(is_Q1, split)
    .by(
        Lq * Q_e * Lq.T - S_x - S_x.T + extra * (V2s + C * Q_e * C.T) * extra.T,
        is_S0,
        is_Sx,
        is_Lq,
        is_extra,
        is_Q1,
        is_Qxy,
        is_De,
    )
)
noise = page(
    letters.derive("3.25", "noise that moves the predictor", V1 - V1i)
    .put(is_V1i)
    .fold(full_Q)
)


@cache
def innovations_plant():
    """The Kalman predictor as a plant: x^+ = A x^ + Kq i, y = C x^ + i.

    Q, Qs and V2s are the Kalman filter's and De its feedthrough gain, or 0.  An
    estimator (Ae, Be, Ce, De0) of L x costs what the Kalman filter costs, plus what
    (Ae, Be, Ce, De0 - De) costs as an estimator of Lq x^ on this plant, whose noise
    has the covariances V1i, Qs and V2s.  The excess is free of cancellation.
    """
    stages = (
        Stage(Kq, Solve(Qs, V2s), by=(is_K,)),
        assign(letters, is_V1i),
        assign(letters, is_Lq),
    )
    proofs = next_split, split, excess, noise
    says = "the predictor as a plant"
    return listed(letters, (C, L, Qs, V2s, De), stages, says, *proofs, source="our own")


page(innovations_plant())
