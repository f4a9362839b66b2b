"""The stationarity conditions: gradients of the Lagrangian.

The moment equation is a constraint on the cost.  Its multiplier is the dual, and four
gradients in the estimator's matrices remain.

Source: Haddad and Bernstein (1987), section 4, (4.6)-(4.11).
"""

from functools import cache

from sympy import Trace

from matrixproof import Identity, Page, Stage

from .augmented import is_N2, is_N12, is_Qt_next, own, step
from .cost import is_Pt, is_S, shown
from .letters import SOURCE, letters, listed, sum_i
from .letters.both import P1, P2, P12, Q1, Q2, Q12, At, At1, Pt, Qt, Rt, Vt, Wt, both
from .letters.estimator import Ae, Be, Ce, De, Sigma
from .letters.kernels import Qxy, Qxy_next, Qyy, gradAe, gradBe, gradCe, gradDe
from .letters.plant import W2, A, C, L, R

letters = letters.here()
p_tilde = letters("p", both**2, 1, "the entries of `P_tilde`, in a column")
Phi_p = letters("Phi_p", both**2, both**2, "the map of (4.5) on them, without weight")
N_p = letters("N_p", both**2, both**2, "inverse of `I - Phi_p`")


lagrangian = (
    Trace(Qt * Rt)
    + Trace(De * W2 * De.T * R)
    + Trace(Pt * (At * Qt * At.T + sum_i * At1 * Qt * At1.T + Wt - Qt))
)

page = Page(letters=letters, source=SOURCE)

page("""To minimise the cost with (4.4) as a constraint, add the constraint times a
    multiplier. The gradients in the multiplier and in the moment are the two equations
    again.""")
says = "the gradient in the multiplier is the moment equation"
page(letters.derive("4.6", says, lagrangian).gradient(Pt))
says = "the gradient in the moment is the dual equation"
page(letters.derive("4.7", says, lagrangian).gradient(Qt, held=(At, At1, Wt)))

page("""Might the multiplier of the cost be zero instead? Then the dual equation has no
    weight, `p = Phi_p p` for the entries `p` of `P_tilde`. Where both systems are
    stable in mean square, `I - Phi_p` has an inverse, and no multiplier is left.""")
unweighted = page.suppose(Phi_p * p_tilde, p_tilde)
solvable = page.suppose(N_p * (Identity(both**2) - Phi_p), Identity(both**2))
page(
    letters.derive("after 4.5", "the multiplier of the cost is not zero", p_tilde)
    .insert(N_p * (Identity(both**2) - Phi_p) * p_tilde, solvable)
    .use(unweighted)
)
page(is_Pt, is_Qt_next, is_N12, is_N2)

page("""What is left are the gradients in the four matrices of the estimator. The first
    two stand in the constraint alone, the others in the cost alone. The paper states
    half of each. The noise of the parameters is in `V_1`, `V_12` and `V_2`, which no
    matrix of the estimator changes.""")
constraint = page(
    letters.derive("4.6", "the constraint by blocks", Trace(Pt * (At * Qt * At.T + Vt)))
    .use(step)
    .multiply(is_Pt, is_Qt_next)
    .fold(own)
    .by(
        Trace(P1 * Q1)
        + 2 * Trace(P12.T * (A * Q12 * Ae.T + Qxy_next * Be.T))
        + Trace(P2 * (Ae * Q2 * Ae.T + 2 * Be * C * Q12 * Ae.T + Be * Qyy * Be.T)),
        *(is_N12, is_N2),
    )
)
page(is_S)
output = page(
    letters.derive("3.5", "the cost by blocks", Trace(R * Sigma))
    .put(shown)
    .expand()
    .cyclic(R)
    .put(is_S)
)


def slope(number, says, of, gain, letter):
    """The gradient of a trace in one gain, as the machine finds it, and its letter."""
    found = letters.derive(number, says, of).gradient(gain)
    named = page.let(letter, found.right, number)
    return page(found.fold(named)), named


says = "the gradient in the estimator's own matrix"
slope_Ae, is_gradAe = slope("4.8", says, constraint, Ae, gradAe)
says = "the gradient in its input matrix"
slope_Be, is_gradBe = slope("4.9", says, constraint, Be, gradBe)
says = "the gradient in its output matrix"
slope_Ce, is_gradCe = slope("4.10", says, output, Ce, gradCe)
says = "the gradient in its static gain"
slope_De, is_gradDe = slope("4.11", says, output, De, gradDe)
SLOPES = (slope_Ae, slope_Be, slope_Ce, slope_De)


@cache
def projection_gradient():
    """Gradients of the cost in the four gains: the whole, not half of it."""
    computed = (
        2 * (P12.T * A * Q12 + P2 * (Be * C * Q12 + Ae * Q2)),
        2 * (P12.T * Qxy_next + P2 * (Be * Qyy + Ae * Q12.T * C.T)),
        2 * (R * (Ce * Q2 + De * C * Q12 - L * Q12)),
        2 * (R * (De * Qyy + Ce * Q12.T * C.T - L * Qxy)),
    )
    slopes = (is_gradAe, is_gradBe, is_gradCe, is_gradDe)
    stages = [
        Stage(slope.left, right, f"(4.{k})", by=(slope,))
        for k, (slope, right) in enumerate(zip(slopes, computed), 8)
    ]
    moments = (Qxy, Qxy_next, Qyy, Q12, Q2, P12, P2)
    given = (A, C, L, R, Ae, Be, Ce, De, *moments)
    return listed(letters, given, stages, "the gradient of the cost", *SLOPES)


page(projection_gradient())
