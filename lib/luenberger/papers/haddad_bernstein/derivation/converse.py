"""Do (3.14)-(3.17) imply stationarity?  Yes, if (3.17) is read as it is printed.

(3.17) aligns the projection with both hats (`one_basis`), and with that every block of
the moment equation, of its dual, and every gradient vanishes.  So the theorem is an
equivalence: stationary points are choices of n_e eigenprojections of the hats' product.
Weaker readings will not do (`counterexamples`).

Source: our own; Haddad and Bernstein (1987), theorem 3.1 and section 4.
"""

from matrixproof import Line, Page

from .equations import second, third
from .letters import *
from .one_basis import aligned_basis_P, aligned_basis_Q, is_P2, is_Q2
from .projection import (
    inner_dual_step,
    inner_step,
    is_Pe,
    is_Ph,
    is_Qh,
    mixed_dual_step,
    mixed_step,
    one,
    twice,
)
from .stationarity import is_P12, is_Q1, is_Q12, is_Qe, is_tau


def stays(which, step, *lines):
    """A block that one step leaves as it is."""
    taken = Line(step.right, by=(step,))
    return chain(step.number, f"{which} stays as it is", step.left, taken, *lines)


page = Page(letters=letters, source="our own")

page("""Suppose (3.14) to (3.16), the alignments and the gains (3.10) to (3.13). Take
    `Q_2` and `P_2` from the hats, and let the moments be what the theorem says.""")
page(is_tau, is_Q2, is_P2, is_Q12, is_P12, is_Qe, is_Pe, is_Q1)
solves_Q = page(
    steady(Q, A * Q * A.T + V1 - Kq * Qs.T + (I - tau) * Qh * (I - tau).T, "3.14")
)
solves_Qh = page(steady(Qh, second.right, "3.15"))
solves_Ph = page(steady(Ph, third.right, "3.16"))
around = page.chain(
    "3.17",
    "the first hat between its projections",
    tau * Qh * tau.T,
    Line(G.T * Gam * Qh * Gam.T * G, by=(is_tau,)),
    Line(G.T * Q2 * G, by=(is_Q2,)),
    Line(Q_e, by=(is_Qe,)),
)
around_dual = page.chain(
    "3.17",
    "the second hat between its projections",
    tau.T * Ph * tau,
    Line(Gam.T * G * Ph * G.T * Gam, by=(is_tau,)),
    Line(Gam.T * P2 * Gam, by=(is_P2,)),
    Line(P_e, by=(is_Pe,)),
)
page.chain(
    "3.15",
    "the first hat is what section 4 defines",
    Qh,
    Line(second.right, by=(solves_Qh,)),
    Line(is_Qh.right, by=(around,)),
)
page.chain(
    "3.16",
    "the second hat is what section 4 defines",
    Ph,
    Line(third.right, by=(solves_Ph,)),
    Line(is_Ph.right, by=(around_dual,)),
)

page("""So one step of the moments is what it was in the section on the projection. The
    alignments make it a step that changes nothing.""")
out_Q = page.chain(
    "3.17",
    "a factor passes through the first hat",
    Qh * Gam.T,
    Line(Qh * tau.T * Gam.T, by=(is_tau, one)),
    Line(tau * Qh * Gam.T, by=(aligned_basis_Q,)),
    Line(G.T * Q2, by=(is_tau, is_Q2)),
)
out_P = page.chain(
    "3.17",
    "a factor passes through the second hat",
    Ph * G.T,
    Line(Ph * tau * G.T, by=(is_tau, one)),
    Line(tau.T * Ph * G.T, by=(aligned_basis_P,)),
    Line(Gam.T * P2, by=(is_tau, is_P2)),
)
page(
    stays(
        "the mixed moment",
        mixed_step,
        Line(G.T * Q2, by=(out_Q,)),
        Line(Q12, by=(is_Q12,)),
    )
)
page(stays("the moment of the estimator", inner_step, Line(Q2, by=(is_Q2,))))
page(
    stays(
        "the mixed dual",
        mixed_dual_step,
        Line(-Gam.T * P2, by=(out_P,)),
        Line(P12, by=(is_P12,)),
    )
)
page(stays("the dual of the estimator", inner_dual_step, Line(P2, by=(is_P2,))))
moving = page.chain(
    "3.17",
    "the projection on the first hat, once more",
    tau * Qh,
    Line(tau * tau * Qh, by=(twice,)),
    Line(tau * Qh * tau.T, by=(aligned_basis_Q,)),
    Line(Q_e, by=(around,)),
)
page.chain(
    "4.12",
    "the moment of the state stays as it is",
    Q1,
    Line(Q + Q_e, by=(is_Q1,)),
    Line(solves_Q.right + Q_e, by=(solves_Q,)),
    Line(A * Q * A.T + V1 - Kq * Qs.T + Qh, by=(moving, around)),
    Line(A * (Q + Q_e) * A.T + V1, by=(solves_Qh, around)),
    Line(A * Q1 * A.T + V1, by=(is_Q1,)),
)

page("""In these letters the gradients vanish at the gains (3.10) to (3.13), as the
    section on the best estimator has it. So every condition (4.6) to (4.11) holds.""")
