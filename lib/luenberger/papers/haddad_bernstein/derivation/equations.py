"""The equations of the theorem, its cost, and what they leave of the moments.

The projection turns the definitions of the two hats into equations, and the moment of
the plant into a Riccati equation.  No matrix of the theorem is negative.

Source: Haddad and Bernstein (1987), theorem 3.1, (3.14)-(3.18), (4.12).
"""

from functools import cache

from sympy import Trace, diag

from matrixproof import (
    BlockMatrix,
    Page,
    Stage,
    ZeroMatrix,
)

from .augmented import is_Qt, is_V1, is_V2, is_V12, own
from .cost import is_S, shown
from .letters import SOURCE, I, assign, letters, listed, n, r, sum_i
from .letters.both import P2, Q2, Qt, both
from .letters.equations import riccati, root_Qt, root_R, root_V
from .letters.estimator import De, J, Sigma
from .letters.plant import C1, V1, A, C, L, R
from .letters.theorem import Aq, G, Kq, Lq, Ph, Q, Q_e, Qh, Qs, V2s, tau, tau_perp
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

letters = letters.here()
T_e = letters("T_e", n, both, "what shows `x - xhat` of both")
root_Q2 = letters("H_Q", r, r, "a root of `Q_2`")
root_P2 = letters("H_P", r, r, "a root of `P_2`")
estimate = letters("estimate", n, n, "residual of (3.15)", symmetric=True)
adjoint = letters("adjoint", n, n, "residual of (3.16)", symmetric=True)
idempotent = letters("idempotent", n, n, "residual of (3.6)")
aligned_Q = letters("aligned_Q", n, n, "residual of (3.17) in `Qh`")
aligned_P = letters("aligned_P", n, n, "residual of (3.17) in `Ph`")


first = sum_i * C1 * (Q + tau * Qh * tau.T) * C1.T

WITNESS = {root_Qt: diag(1, 0), Kq: 0}


page = Page(letters=letters, source=SOURCE, witness=WITNESS)

page("Recalled are the hats, and what the estimator's matrices are made of.")
page(is_Qh, is_Ph, is_Qe, is_Pe, is_Q1, is_Q12, is_Ce)
page(is_Qs, is_V2s, is_K, is_Aq, is_Lq)

page("""Put into the definitions of the hats, this gives the second and the third
    equation.""")
second = page(
    letters.derive("3.15", "the equation of the first hat", is_Qh).fold(hidden)
)
third = page(
    letters.derive("3.16", "the equation of the second hat", is_Ph).fold(hidden_dual)
)

page("The first block of the moment equation is left. It gives the Riccati equation.")
outer = page(
    letters.derive("4.12", "the moment of the state", Q + Q_e)
    .fold(is_Q1)
    .put(own)
    .put(is_Q1)
)
is_perp = page.let(tau_perp, I - tau, "section 2")
left = page(
    letters.derive(
        "3.14",
        "what the projection leaves of the first hat",
        tau_perp * Qh * tau_perp.T,
    )
    .put(is_perp)
    .expand()
    .use(hidden)
    .use(seen)
)
riccati_equation = page(
    letters.derive("3.14", "the Riccati equation", Q)
    .fold(is_Q1)
    .put(own)
    .put(is_Q1)
    .expand()
    .fold(is_Qh)
    .fold(left)
)

page("""The noise of the parameters is in `V_1`, `V_12` and `V_2`. Written out, the
    terms are those of the paper, with `Q + tau Qh tau'` for the moment of the
    state.""")
page(is_V1, is_V12, is_V2)
written_V1 = page(
    letters.derive("3.14", "the noise that moves the state, written out", is_V1)
    .put(is_Q1)
    .fold(hidden)
)
written_Qs = page(
    letters.derive("section 2", "next state and innovation, written out", is_Qs)
    .put(is_V12)
    .put(is_Q1)
    .fold(hidden)
)
written_V2s = page(
    letters.derive("section 2", "the innovation, written out", is_V2s)
    .put(is_V2)
    .put(is_Q1)
    .fold(hidden)
)

page("Of the cost, what the estimator tracks cancels, and a regression is left.")
page(is_S, is_Qxy, is_De)
regression = page(
    letters.derive(
        "3.18", "the covariance of the error with any static gain", shown
    ).by(
        L * Q * L.T - L * Q * C.T * De.T - De * C * Q * L.T + De * V2s * De.T,
        is_S,
        is_Q1,
        is_Q12,
        is_Qe,
        is_Ce,
        is_Qxy,
        split,
    )
)
best = page(
    letters.derive("3.18", "the covariance of the least error", regression).fold(is_De)
)
is_J = page.let(J, (L * Q * L.T - De * V2s * De.T) * R, "3.18")
least = page(
    letters.derive("3.18", "the least cost", Trace(R * Sigma)).put(best).fold(is_J)
)

page("""No matrix of the theorem is negative. `Q` is the covariance of `x - xhat`, and
    the hats are sums of squares.""")
page(is_Qt)
is_Te = page.let(T_e, BlockMatrix([[I, -G.T]]))
is_root = page.suppose(Qt, root_Qt * root_Qt.T)
is_root_V = page.suppose(V2s, root_V * root_V.T)
is_root_Q2 = page.suppose(Q2, root_Q2 * root_Q2.T)
is_root_P2 = page.suppose(P2, root_P2 * root_P2.T)
is_root_R = page.suppose(R, root_R * root_R.T)
not_negative_Q = page(
    letters.derive("theorem 3.1", "the solution is a covariance", Q)
    .fold(is_Q1)
    .by(T_e * Qt * T_e.T, is_Te, is_Qt, is_Qe, is_Q12)
    .drop(is_root)
)
not_negative_Qh = page(
    letters.derive("theorem 3.1", "the first hat is not negative", is_Qh)
    .put(is_Qe)
    .fold(is_K)
    .expand()
    .drop(is_root_V)
    .drop(is_root_Q2)
)
not_negative_Ph = page(
    letters.derive("theorem 3.1", "the second hat is not negative", Ph)
    .put(is_Ph, is_Pe)
    .drop(is_root_R)
    .drop(is_root_P2)
)

page("The kernels have the residuals of all of these.")
is_riccati = page.let(
    riccati,
    A * Q * A.T + V1 - Kq * Qs.T + tau_perp * Qh * tau_perp.T - Q,
    "3.14",
)
is_estimate = page.let(estimate, A * tau * Qh * tau.T * A.T + Kq * Qs.T - Qh, "3.15")
is_adjoint = page.let(
    adjoint, Aq.T * tau.T * Ph * tau * Aq + Lq.T * R * Lq - Ph, "3.16"
)
is_idempotent = page.let(idempotent, tau * tau - tau, "3.6")
is_aligned_Q = page.let(aligned_Q, tau * Qh - Qh * tau.T, "3.17")
is_aligned_P = page.let(aligned_P, Ph * tau - tau.T * Ph, "3.17")

RESIDUALS = tuple(
    letters.derive(number, f"the residual of {of} vanishes", residual).by(
        ZeroMatrix(n, n), by
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
        assign(letters, is_perp),
        assign(letters, is_riccati, "(3.14)"),
        assign(letters, is_estimate, "(3.15)"),
        assign(letters, is_adjoint, "(3.16)"),
        Stage(idempotent, -tau * tau_perp, "(3.6)", by=(is_idempotent, is_perp)),
        assign(letters, is_aligned_Q, "(3.17)"),
        assign(letters, is_aligned_P, "(3.17)"),
    )
    given = (A, C, L, R, De, V1, Qs, V2s, Q, Qh, Ph, tau)
    says = "the residuals of the theorem"
    return listed(letters, given, stages, says, *RESIDUALS)


page(projection_equations())


@cache
def projection_trace():
    """The least cost as the trace of J; De is 0 without feedthrough."""
    stages = (assign(letters, is_J, "(3.18)"),)
    return listed(letters, (L, R, De, Q, V2s), stages, "the least cost", least)


page(projection_trace())
