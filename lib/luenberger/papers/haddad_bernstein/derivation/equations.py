"""The equations of the theorem, its cost, and what they leave of the moments.

The projection turns the definitions of the two hats into equations, and the moment of
the plant into a Riccati equation.  No matrix of the theorem is negative.

Source: Haddad and Bernstein (1987), theorem 3.1, (3.14)-(3.18), (4.12).
"""

from functools import cache

from sympy import Trace, diag

from matrixproof import (
    AtLeast,
    BlockMatrix,
    Cyclic,
    Line,
    Page,
    Stage,
    Substitute,
    ZeroMatrix,
)

from .augmented import is_Qt, is_V1, is_V2, is_V12, own
from .cost import is_S, shown
from .letters import *
from .projection import (
    FRAME,
    aligned,
    aligned_dual,
    hidden,
    hidden_dual,
    is_Lq,
    is_Pe,
    is_Ph,
    is_Qh,
    seen,
    twice,
)
from .stationarity import (
    is_Aq,
    is_Ce,
    is_De,
    is_K,
    is_Q1,
    is_Q12,
    is_Qe,
    is_Qs,
    is_Qxy,
    is_V2s,
    split,
)

first = C1 * (Q + tau * Qh * tau.T) * C1.T

WITNESS = {root_Qt: diag(1, 0), Kq: 0}


page = Page(letters=letters, source=SOURCE, witness=WITNESS)

page("Recalled are the hats, and what the estimator's matrices are made of.")
page(is_Qh, is_Ph, is_Qe, is_Pe, is_Q1, is_Q12, is_Ce)
page(is_Qs, is_V2s, is_K, is_Aq, is_Lq)

page("""Put into the definitions of the hats, this gives the second and the third
    equation.""")
second = page.chain(
    "3.15",
    "the equation of the first hat",
    Qh,
    Line(A * Q_e * A.T + Kq * Qs.T, by=(is_Qh,)),
    Line(A * tau * Qh * tau.T * A.T + Kq * Qs.T, by=(hidden,)),
)
third = page.chain(
    "3.16",
    "the equation of the second hat",
    Ph,
    Line(Aq.T * P_e * Aq + Lq.T * R * Lq, by=(is_Ph,)),
    Line(Aq.T * tau.T * Ph * tau * Aq + Lq.T * R * Lq, by=(hidden_dual,)),
)

page("The first block of the moment equation is left. It gives the Riccati equation.")
outer = page.chain(
    "4.12",
    "the moment of the state",
    Q + Q_e,
    Line(Q1, by=(is_Q1,)),
    Line(A * Q1 * A.T + V1, by=(own,)),
    Line(A * (Q + Q_e) * A.T + V1, by=(is_Q1,)),
)
is_perp = page(let(tau_perp, I - tau, "section 2"))
left = page.chain(
    "3.14",
    "what the projection leaves of the first hat",
    tau_perp * Qh * tau_perp.T,
    Line((I - tau) * Qh * (I - tau).T, by=(is_perp,)),
    Line(Qh - tau * Qh - Qh * tau.T + tau * Qh * tau.T, why="multiply out"),
    Line(Qh - 2 * Q_e + tau * Qh * tau.T, by=(seen,)),
    Line(Qh - Q_e, by=(hidden,)),
)
riccati_equation = page.chain(
    "3.14",
    "the Riccati equation",
    Q,
    Line(A * Q * A.T + A * Q_e * A.T + V1 - Q_e, by=(outer,)),
    Line(A * Q * A.T + V1 - Kq * Qs.T + Qh - Q_e, by=(is_Qh,)),
    Line(A * Q * A.T + V1 - Kq * Qs.T + tau_perp * Qh * tau_perp.T, by=(left,)),
)

page("""The noise of the parameters is in `V_1`, `V_12` and `V_2`. Written out, the
    terms are those of the paper, with `Q + tau Qh tau'` for the moment of the
    state.""")
page(is_V1, is_V12, is_V2)
written_V1 = page.chain(
    "3.14",
    "the noise that moves the state, written out",
    V1,
    Line(W1 + A1 * Q1 * A1.T, by=(is_V1,)),
    Line(W1 + A1 * (Q + tau * Qh * tau.T) * A1.T, by=(is_Q1, hidden)),
)
written_Qs = page.chain(
    "section 2",
    "next state and innovation, written out",
    Qs,
    Line(A * Q * C.T + V12, by=(is_Qs,)),
    Line(A * Q * C.T + W12 + A1 * Q1 * C1.T, by=(is_V12,)),
    Line(A * Q * C.T + W12 + A1 * (Q + tau * Qh * tau.T) * C1.T, by=(is_Q1, hidden)),
)
written_V2s = page.chain(
    "section 2",
    "the innovation, written out",
    V2s,
    Line(C * Q * C.T + V2, by=(is_V2s,)),
    Line(C * Q * C.T + W2 + C1 * Q1 * C1.T, by=(is_V2,)),
    Line(C * Q * C.T + W2 + first, by=(is_Q1, hidden)),
)

page("Of the cost, what the estimator tracks cancels, and a regression is left.")
page(is_S, is_Qxy, is_De)
regression = page.chain(
    "3.18",
    "the covariance of the error with any static gain",
    Sigma,
    Line(shown.right, by=(shown,)),
    Line(
        L * Q * L.T - L * Q * C.T * De.T - De * C * Q * L.T + De * V2s * De.T,
        by=(is_S, is_Q1, is_Q12, is_Qe, is_Ce, is_Qxy, split),
    ),
)
best = page.chain(
    "3.18",
    "the covariance of the least error",
    Sigma,
    Line(regression.right, by=(regression,)),
    Line(L * Q * L.T - De * V2s * De.T, by=(is_De,)),
)
is_J = page(let(J, (L * Q * L.T - De * V2s * De.T) * R, "3.18"))
least = page.chain(
    "3.18",
    "the least cost",
    Trace(R * Sigma),
    Line(Trace(R * (L * Q * L.T - De * V2s * De.T)), by=(best,)),
    Cyclic(Trace((L * Q * L.T - De * V2s * De.T) * R)),
    Line(Trace(J), by=(is_J,)),
)

page("""No matrix of the theorem is negative. `Q` is the covariance of `x - xhat`, and
    the hats are sums of squares.""")
page(is_Qt)
is_Te = page(let(T_e, BlockMatrix([[I, -G.T]])))
is_root = page(suppose(Qt, root_Qt * root_Qt.T))
is_root_V = page(suppose(V2s, root_V * root_V.T))
is_root_Q2 = page(suppose(Q2, root_Q2 * root_Q2.T))
is_root_P2 = page(suppose(P2, root_P2 * root_P2.T))
is_root_R = page(suppose(R, root_R * root_R.T))
not_negative_Q = page.chain(
    "theorem 3.1",
    "the solution is a covariance",
    Q,
    Line(Q1 - Q12 * G - G.T * Q12.T + G.T * Q2 * G, by=(is_Q1, is_Qe, is_Q12)),
    Substitute(T_e * Qt * T_e.T, by=(is_Te, is_Qt)),
    AtLeast(ZeroMatrix(n, n), by=(is_root,), root=T_e * root_Qt),
)
not_negative_Qh = page.chain(
    "theorem 3.1",
    "the first hat is not negative",
    Qh,
    Line(A * G.T * Q2 * G * A.T + Kq * Qs.T, by=(is_Qh, is_Qe)),
    Line(A * G.T * Q2 * G * A.T + Kq * V2s * Kq.T, by=(is_K,)),
    AtLeast(A * G.T * Q2 * G * A.T, by=(is_root_V,), root=Kq * root_V),
    AtLeast(ZeroMatrix(n, n), by=(is_root_Q2,), root=A * G.T * root_Q2),
)
not_negative_Ph = page.chain(
    "theorem 3.1",
    "the second hat is not negative",
    Ph,
    Line(Aq.T * Gam.T * P2 * Gam * Aq + Lq.T * R * Lq, by=(is_Ph, is_Pe)),
    AtLeast(Aq.T * Gam.T * P2 * Gam * Aq, by=(is_root_R,), root=Lq.T * root_R),
    AtLeast(ZeroMatrix(n, n), by=(is_root_P2,), root=Aq.T * Gam.T * root_P2),
)

page("The kernels have the residuals of all of these.")
is_riccati = page(
    let(
        riccati,
        A * Q * A.T + V1 - Kq * Qs.T + tau_perp * Qh * tau_perp.T - Q,
        "3.14",
    )
)
is_estimate = page(let(estimate, A * tau * Qh * tau.T * A.T + Kq * Qs.T - Qh, "3.15"))
is_adjoint = page(
    let(adjoint, Aq.T * tau.T * Ph * tau * Aq + Lq.T * R * Lq - Ph, "3.16")
)
is_idempotent = page(let(idempotent, tau * tau - tau, "3.6"))
is_aligned_Q = page(let(aligned_Q, tau * Qh - Qh * tau.T, "3.17"))
is_aligned_P = page(let(aligned_P, Ph * tau - tau.T * Ph, "3.17"))

RESIDUALS = tuple(
    chain(
        number,
        f"the residual of {of} vanishes",
        residual.left,
        Line(residual.right, by=(residual,)),
        Line(ZeroMatrix(n, n), by=(by,)),
    )
    for number, of, residual, by in (
        ("3.14", "the Riccati equation", is_riccati, riccati_equation),
        ("3.15", "the second equation", is_estimate, second),
        ("3.16", "the third equation", is_adjoint, third),
        ("3.6", "the projection", is_idempotent, twice),
        ("3.17", "the first alignment", is_aligned_Q, aligned),
        ("3.17", "the second alignment", is_aligned_P, aligned_dual),
    )
)

page(*RESIDUALS)


@cache
def projection_equations():
    """Residuals: right side minus left of (3.14)-(3.16), and what tau must satisfy.

    `aligned_Q` and `aligned_P` vanish when tau is diagonal where Qh and Ph are; that
    is what (3.17) adds to tau^2 = tau, and without it the equations are too weak.
    """
    stages = (
        *FRAME,
        assign(is_perp),
        assign(is_riccati, "(3.14)"),
        assign(is_estimate, "(3.15)"),
        assign(is_adjoint, "(3.16)"),
        Stage(idempotent, -tau * tau_perp, "(3.6)", by=(is_idempotent, is_perp)),
        assign(is_aligned_Q, "(3.17)"),
        assign(is_aligned_P, "(3.17)"),
    )
    given = (A, C, L, R, De, V1, Qs, V2s, Q, Qh, Ph, tau)
    says = "the residuals of the theorem"
    return listed(given, stages, says, *RESIDUALS)


page(projection_equations())


@cache
def projection_trace():
    """The least cost as the trace of J; De is 0 without feedthrough."""
    stages = (assign(is_J, "(3.18)"),)
    return listed((L, R, De, Q, V2s), stages, "the least cost", least)


page(projection_trace())
