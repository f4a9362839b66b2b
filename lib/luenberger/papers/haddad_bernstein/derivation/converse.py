"""Do (3.14)-(3.17) imply stationarity?  Yes, if (3.17) is read as it is printed.

(3.17) aligns the projection with both hats (`one_basis`), and with that every block of
the moment equation, of its dual, and every gradient vanishes.  So the theorem is an
equivalence: stationary points are choices of n_e eigenprojections of the hats' product.
Weaker readings will not do (`counterexamples`).

Source: our own; Haddad and Bernstein (1987), theorem 3.1 and section 4.
"""

from matrixproof import Page

from .equations import second, third
from .letters import I, letters
from .letters.plant import V1, A
from .letters.theorem import G, Gam, Kq, Ph, Q, Qh, Qs, tau
from .one_basis import aligned_basis_P, aligned_basis_Q, is_P2, is_Q2
from .projection import (
    inner_dual_step,
    inner_step,
    is_Pe,
    mixed_dual_step,
    mixed_step,
    one,
    twice,
)
from .stationarity import is_P12, is_Q1, is_Q12, is_Qe, is_tau


def stays(which, step):
    """A block that one step leaves as it is, to begin with."""
    return letters.derive(step.number, f"{which} stays as it is", step)


page = Page(letters=letters, source="our own")

page("""Suppose (3.14) to (3.16), the alignments and the gains (3.10) to (3.13). Take
    `Q_2` and `P_2` from the hats, and let the moments be what the theorem says.""")
page(is_tau, is_Q2, is_P2, is_Q12, is_P12, is_Qe, is_Pe, is_Q1)
solves_Q = page.steady(
    Q, A * Q * A.T + V1 - Kq * Qs.T + (I - tau) * Qh * (I - tau).T, "3.14"
)
solves_Qh = page.steady(Qh, second.right, "3.15")
solves_Ph = page.steady(Ph, third.right, "3.16")
around = page(
    letters.derive("3.17", "the first hat between its projections", tau * Qh * tau.T)
    .use(is_tau)
    .fold(is_Q2)
    .fold(is_Qe)
)
around_dual = page(
    letters.derive("3.17", "the second hat between its projections", tau.T * Ph * tau)
    .use(is_tau)
    .fold(is_P2)
    .fold(is_Pe)
)
page(
    letters.derive("3.15", "the first hat is what section 4 defines", solves_Qh).use(
        around
    )
)
page(
    letters.derive("3.16", "the second hat is what section 4 defines", solves_Ph).use(
        around_dual
    )
)

page("""So one step of the moments is what it was in the section on the projection. The
    alignments make it a step that changes nothing.""")
out_Q = page(
    letters.derive("3.17", "a factor passes through the first hat", Qh * Gam.T)
    .insert(Qh * tau.T * Gam.T, is_tau, one)
    .use(aligned_basis_Q)
    .put(is_tau)
    .fold(is_Q2)
)
out_P = page(
    letters.derive("3.17", "a factor passes through the second hat", Ph * G.T)
    .insert(Ph * tau * G.T, is_tau, one)
    .fold(aligned_basis_P)
    .put(is_tau)
    .fold(is_P2)
)
page(stays("the mixed moment", mixed_step).use(out_Q).fold(is_Q12))
page(stays("the moment of the estimator", inner_step).fold(is_Q2))
page(stays("the mixed dual", mixed_dual_step).use(out_P).fold(is_P12))
page(stays("the dual of the estimator", inner_dual_step).fold(is_P2))
moving = page(
    letters.derive("3.17", "the projection on the first hat, once more", tau * Qh)
    .insert(tau * tau * Qh, twice)
    .by(tau * Qh * tau.T, aligned_basis_Q)
    .use(around)
)
page(
    letters.derive("4.12", "the moment of the state stays as it is", is_Q1)
    .put(solves_Q)
    .use(around, moving)
    .put(solves_Qh)
    .use(around)
    .fold(is_Q1)
)

page("""In these letters the gradients vanish at the gains (3.10) to (3.13), as the
    section on the best estimator has it. So every condition (4.6) to (4.11) holds.""")
