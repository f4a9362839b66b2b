"""Full order: the projection is the identity, and the filter is Kalman's.

The two equations that are left look coupled.  But the sum of their solutions is the
plant's own moment, known beforehand.  So the first is the Riccati equation of the plant
with all its noise.

Source: Haddad and Bernstein (1987), corollary 3.1 and remark 3.6; that the equations
decouple, and the predictor as a plant, are our own.
"""

from functools import cache

from matrixproof import Line, Page, Solve, Stage, ZeroMatrix

from .augmented import is_V1
from .equations import (
    best,
    riccati_equation,
    second,
    written_Qs,
    written_V1,
    written_V2s,
)
from .letters import *
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
is_G = page(suppose(G_n, I))
is_Gam = page(suppose(Gam_n, I))
is_tau = page(at_n(let(tau, G.T * Gam, "3.8")))
whole = page.chain(
    "3.8",
    "the projection at full order",
    tau,
    Line(G_n.T * Gam_n, by=(is_tau,)),
    Line(I, by=(is_G, is_Gam)),
)

page("The matrices of the estimator lose their factors.")
page(is_Aq)
full_Be = page(at_n(is_Be))
full_Ce = page(at_n(is_Ce))
page(is_K, is_De)
full_Ae = page(at_n(gain_Ae))
page.chain(
    "3.21",
    "the estimator's own matrix at full order",
    Ae_n,
    Line(Gam_n * Aq * G_n.T, by=(full_Ae,)),
    Line(Aq, by=(is_G, is_Gam)),
    Line(A - Kq * C, by=(is_Aq,)),
    Line(A - Qs * V2s.I * C, by=(is_K,)),
)
page.chain(
    "3.22",
    "its input matrix at full order",
    Be_n,
    Line(Gam_n * Kq, by=(full_Be,)),
    Line(Kq, by=(is_Gam,)),
    Line(Qs * V2s.I, by=(is_K,)),
)
full_output = page.chain(
    "3.23",
    "its output matrix at full order",
    Ce_n,
    Line((L - De * C) * G_n.T, by=(full_Ce,)),
    Line(L - De * C, by=(is_G,)),
)
page.chain(
    "3.24",
    "its static gain at full order",
    De,
    Line(L * Q * C.T * V2s.I, by=(is_De,)),
)

page("The equations lose the projection.")
is_perp = page(let(tau_perp, I - tau, "section 2"))
full_Q = page.chain(
    "3.25",
    "the Riccati equation at full order",
    Q,
    Line(riccati_equation.right, by=(riccati_equation,)),
    Line(
        A * Q * A.T + V1 - Kq * Qs.T + (I - tau) * Qh * (I - tau).T,
        by=(is_perp,),
    ),
    Line(A * Q * A.T + V1 - Kq * Qs.T, by=(whole,)),
)
full_Qh = page.chain(
    "3.26",
    "the second equation at full order",
    Qh,
    Line(A * tau * Qh * tau.T * A.T + Kq * Qs.T, by=(second,)),
    Line(A * Qh * A.T + Kq * Qs.T, by=(whole,)),
)
page.chain(
    "3.27",
    "the least error at full order",
    Sigma,
    Line(L * Q * L.T - De * V2s * De.T, by=(best,)),
    Line(L * (Q - Q * C.T * V2s.I * C * Q) * L.T, by=(is_De,)),
)

page("So do the noise of the parameters and the moments of the innovation.")
full_Qs = page.chain(
    "section 2",
    "next state and innovation at full order",
    Qs,
    Line(written_Qs.right, by=(written_Qs,)),
    Line(A * Q * C.T + W12 + A1 * (Q + Qh) * C1.T, by=(whole,)),
)
full_V2s = page.chain(
    "section 2",
    "the innovation at full order",
    V2s,
    Line(written_V2s.right, by=(written_V2s,)),
    Line(C * Q * C.T + W2 + C1 * (Q + Qh) * C1.T, by=(whole,)),
)

page("""The sum of the two equations is the plant's own. So `Q + Qh` is known before the
    filter is, and (3.25) is the Riccati equation of a Kalman filter.""")
page.chain(
    "3.25, 3.26",
    "the sum depends on no filter",
    Q + Qh,
    Line(A * Q * A.T + V1 - Kq * Qs.T + Qh, by=(full_Q,)),
    Line(A * (Q + Qh) * A.T + V1, by=(full_Qh,)),
    Line(
        A * (Q + Qh) * A.T + W1 + A1 * (Q + tau * Qh * tau.T) * A1.T,
        by=(written_V1,),
    ),
    Line(A * (Q + Qh) * A.T + W1 + A1 * (Q + Qh) * A1.T, by=(whole,)),
)

page("Without noise in the parameters it is Kalman's own, and nothing is left of `Qh`.")
page(is_V1)
certain = page(suppose(A1, ZeroMatrix(n, n)))
page.chain(
    "3.25",
    "the equation of the Kalman filter",
    Q,
    Line(A * Q * A.T + V1 - Kq * Qs.T, by=(full_Q,)),
    Line(A * Q * A.T + W1 + A1 * Q1 * A1.T - Kq * Qs.T, by=(is_V1,)),
    Line(A * Q * A.T + W1 - Kq * Qs.T, by=(certain,)),
    Line(A * Q * A.T + W1 - Qs * V2s.I * Qs.T, by=(is_K,)),
)

page("""So it depends on `Qh` no more, and (3.26) is superfluous. The same holds of the
    innovation. Without feedthrough the filter says `L xhat`.""")
certain_C = page(suppose(C1, ZeroMatrix(l, n)))
page.chain(
    "remark 3.6",
    "next state and innovation of the Kalman filter",
    Qs,
    Line(full_Qs.right, by=(full_Qs,)),
    Line(A * Q * C.T + W12, by=(certain,)),
)
page.chain(
    "remark 3.6",
    "the innovation of the Kalman filter",
    V2s,
    Line(full_V2s.right, by=(full_V2s,)),
    Line(C * Q * C.T + W2, by=(certain_C,)),
)
page(silent)
page.chain(
    "remark 3.6",
    "the output of the Kalman filter",
    Ce_n,
    Line(L - De * C, by=(full_output,)),
    Line(L, by=(silent,)),
)

page("""The estimator is the predictor of that filter. Its static gain is the
    measurement update.""")
page.chain(
    "3.21, 3.22",
    "the estimator is the predictor",
    Aq * xh + Kq * y,
    Line((A - Kq * C) * xh + Kq * y, by=(is_Aq,)),
    Line(A * xh + Kq * (y - C * xh), why="collect"),
)
page.chain(
    "3.23, 3.24",
    "the estimate is the update",
    (L - De * C) * xh + De * y,
    Line(L * xh + De * (y - C * xh), why="collect"),
    Line(L * (xh + Q * C.T * V2s.I * (y - C * xh)), by=(is_De,)),
)

page("""The predictor is itself a plant, `xhat_next = A xhat + K_q i` and `y = C xhat +
    i` with the innovation `i` for noise. Any estimator has the same moments on it,
    because both sides split alike. Beyond the Kalman filter it costs what it costs
    there, with a static gain of `D_x`. That excess is free of cancellation.""")
is_V1i = page(let(V1i, Kq * Qs.T))
is_Lq = page(let(Lq, L - De * C))
is_extra = page(let(extra, De0 - De))
page(is_Q1, is_Qxy)
is_S0 = page(let(S_e, S_0 + L * Qxy * De0.T))
is_Sx = page(let(S_x, S_0 + Lq * Q_e * C.T * extra.T))
excess = page.chain(
    "",
    "what an estimator costs beyond the Kalman filter",
    L * Q1 * L.T - S_e - S_e.T + De0 * Qyy * De0.T - L * Q * L.T + De * V2s * De.T,
    Line(
        L * Q_e * L.T
        - S_e
        - S_e.T
        + De0 * (V2s + C * Q_e * C.T) * De0.T
        + De * V2s * De.T,
        by=(is_Q1, split),
    ),
    Line(
        Lq * Q_e * Lq.T - S_x - S_x.T + extra * (V2s + C * Q_e * C.T) * extra.T,
        by=(is_S0, is_Sx, is_Lq, is_extra, is_Q1, is_Qxy, is_De),
    ),
)
noise = page.chain(
    "3.25",
    "noise that moves the predictor",
    V1 - V1i,
    Line(V1 - Kq * Qs.T, by=(is_V1i,)),
    Line(Q - A * Q * A.T, by=(full_Q,)),
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
        assign(is_V1i),
        assign(is_Lq),
    )
    proofs = next_split, split, excess, noise
    says = "the predictor as a plant"
    return listed((C, L, Qs, V2s, De), stages, says, *proofs, source="our own")


page(innovations_plant())
