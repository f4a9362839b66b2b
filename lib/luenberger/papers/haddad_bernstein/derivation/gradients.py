"""The stationarity conditions: gradients of the Lagrangian.

The moment equation is a constraint on the cost.  Its multiplier is the dual, and four
gradients in the estimator's matrices remain.

Source: Haddad and Bernstein (1987), section 4, (4.6)-(4.11).
"""

from functools import cache

from sympy import Trace

from matrixproof import (
    Gradient,
    Identity,
    Line,
    Page,
    Substitute,
    ZeroMatrix,
)

from .augmented import is_N2, is_N12, is_Qt_next, own, step
from .cost import is_Pt, is_S, shown
from .letters import *

lagrangian = (
    Trace(Qt * Rt)
    + Trace(De * W2 * De.T * R)
    + Trace(Pt * (At * Qt * At.T + At1 * Qt * At1.T + Wt - Qt))
)


def slope(number, says, of, gradient, gain):
    """The gradient of a trace, worked out by blocks, in one gain."""
    line = Gradient(gradient.left, of=gain, by=(gradient,))
    return chain(number, says, of.left, Line(of.right, by=(of,)), line)


page = Page(letters=letters, source=SOURCE)

page("""To minimise the cost with (4.4) as a constraint, add the constraint times a
    multiplier. The gradients in the multiplier and in the moment are the two equations
    again.""")
page.chain(
    "4.6",
    "the gradient in the multiplier is the moment equation",
    lagrangian,
    Gradient(At * Qt * At.T + At1 * Qt * At1.T + Wt - Qt, of=Pt),
)
page.chain(
    "4.7",
    "the gradient in the moment is the dual equation",
    lagrangian,
    Gradient(At.T * Pt * At + At1.T * Pt * At1 + Rt - Pt, of=Qt, held=(At, At1, Wt)),
)

page("""Might the multiplier of the cost be zero instead? Then the dual equation has no
    weight, `p = Phi_p p` for the entries `p` of `P_tilde`. Where both systems are
    stable in mean square, `I - Phi_p` has an inverse, and no multiplier is left.""")
unweighted = page(suppose(Phi_p * p_tilde, p_tilde))
solvable = page(suppose(N_p * (Identity(both**2) - Phi_p), Identity(both**2)))
page.chain(
    "after 4.5",
    "the multiplier of the cost is not zero",
    p_tilde,
    Line(N_p * (Identity(both**2) - Phi_p) * p_tilde, by=(solvable,)),
    Line(ZeroMatrix(both**2, 1), by=(unweighted,)),
)
page(is_Pt, is_Qt_next, is_N12, is_N2)

page("""What is left are the gradients in the four matrices of the estimator. The first
    two stand in the constraint alone, the others in the cost alone. The paper states
    half of each. The noise of the parameters is in `V_1`, `V_12` and `V_2`, which no
    matrix of the estimator changes.""")
constraint = page.chain(
    "4.6",
    "the constraint by blocks",
    Trace(Pt * (At * Qt * At.T + Vt)),
    Line(Trace(Pt * Qt_next), by=(step,)),
    Substitute(
        Trace(P1 * (A * Q1 * A.T + V1))
        + 2 * Trace(P12.T * (A * Q12 * Ae.T + N12))
        + Trace(P2 * (Ae * Q2 * Ae.T + N2)),
        by=(is_Pt, is_Qt_next),
    ),
    Line(
        Trace(P1 * Q1)
        + 2 * Trace(P12.T * (A * Q12 * Ae.T + N12))
        + Trace(P2 * (Ae * Q2 * Ae.T + N2)),
        by=(own,),
    ),
    Line(
        Trace(P1 * Q1)
        + 2 * Trace(P12.T * (A * Q12 * Ae.T + Qxy_next * Be.T))
        + Trace(P2 * (Ae * Q2 * Ae.T + 2 * Be * C * Q12 * Ae.T + Be * Qyy * Be.T)),
        by=(is_N12, is_N2),
    ),
)
page(is_S)
output = page.chain(
    "3.5",
    "the cost by blocks",
    Trace(R * Sigma),
    Line(
        Trace(R * (L * Q1 * L.T + Ce * Q2 * Ce.T + De * Qyy * De.T - 2 * S_e)),
        by=(shown,),
    ),
    Line(
        Trace(R * (L * Q1 * L.T + Ce * Q2 * Ce.T + De * Qyy * De.T))
        - 2 * Trace(R * ((L * Q12 - De * C * Q12) * Ce.T + L * Qxy * De.T)),
        by=(is_S,),
    ),
)
is_gradAe = page(
    let(gradAe, 2 * (P12.T * A * Q12 + P2 * (Be * C * Q12 + Ae * Q2)), "4.8")
)
is_gradBe = page(
    let(gradBe, 2 * (P12.T * Qxy_next + P2 * (Be * Qyy + Ae * Q12.T * C.T)), "4.9")
)
is_gradCe = page(let(gradCe, 2 * (R * (Ce * Q2 + De * C * Q12 - L * Q12)), "4.10"))
is_gradDe = page(let(gradDe, 2 * (R * (De * Qyy + Ce * Q12.T * C.T - L * Qxy)), "4.11"))
slope_Ae = page(
    slope(
        "4.8", "the gradient in the estimator's own matrix", constraint, is_gradAe, Ae
    )
)
slope_Be = page(
    slope("4.9", "the gradient in its input matrix", constraint, is_gradBe, Be)
)
slope_Ce = page(
    slope("4.10", "the gradient in its output matrix", output, is_gradCe, Ce)
)
slope_De = page(slope("4.11", "the gradient in its static gain", output, is_gradDe, De))

SLOPES = (slope_Ae, slope_Be, slope_Ce, slope_De)


@cache
def projection_gradient():
    """Gradients of the cost in the four gains: the whole, not half of it."""
    slopes = (is_gradAe, is_gradBe, is_gradCe, is_gradDe)
    stages = [assign(slope, f"(4.{k})") for k, slope in enumerate(slopes, 8)]
    moments = (Qxy, Qxy_next, Qyy, Q12, Q2, P12, P2)
    given = (A, C, L, R, Ae, Be, Ce, De, *moments)
    return listed(given, stages, "the gradient of the cost", *SLOPES)


page(projection_gradient())
