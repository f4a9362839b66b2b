"""What Haddad and Bernstein's pages print, or the scan leaves, and what holds.

`entries()` gives for every place the printed claim and the correct one; the printed
one is tried like any other and does not vanish, or cannot even be multiplied.  Where
the scan has lost letters and nothing else (blocks of A~ and V~, tau^2 in (3.6)) there
is nothing to try.  That (3.14)-(3.16) need (3.17) in full is in
`counterexamples`.

Source: Haddad and Bernstein (1987), as scanned.
"""

import sympy as sp

from matrixproof import BlockMatrix, Identity, prove
from matrixproof.algebra import Algebra
from matrixproof.explicit import Claim
from matrixproof.proofs import Unproved

from . import augmented, cost, equations, gradients, mean_square, projection
from . import stationarity as best
from .letters import letters, r, sum_i
from .letters.both import P2, P12, Q2, Q12, At, At1, Pt, Qt, Rt
from .letters.estimator import Ae, Be, Ce, De
from .letters.kernels import M2, M12, N2, N12
from .letters.plant import C1, V2, V12, W2, A, C, L, R
from .letters.theorem import (
    Aq,
    G,
    Gam,
    Kq,
    Lq,
    P_e,
    Ph,
    Q,
    Q_e,
    Qh,
    Qs,
    V2s,
    tau,
    tau_perp,
)

NOT_CONFORMABLE = sp.Symbol("not conformable")
ALGEBRA = Algebra(letters.symmetric)
MEANT = (
    *(augmented.is_Qxy, augmented.is_Qxy_next, augmented.is_Qyy),
    *(augmented.is_N12, augmented.is_N2, cost.is_M12, cost.is_M2),
    *(cost.is_Rt, cost.is_Lt, cost.is_Ct1),
    *(best.is_Q12, best.is_P12, best.is_Q1, best.is_Qe, projection.is_Pe),
    *(best.is_Aq, projection.is_Lq, best.is_tau),
    (V12, Qs - A * Q * C.T),
    (V2, V2s - C * Q * C.T),
    (Kq, Qs * V2s.I),
)
BEST = (best.gain_Ae.relation, best.is_Be, best.is_Ce)
HATS = (projection.is_Qh, projection.is_Ph)
# what (4.13) and (4.15) say before the theorem is known
E_13, E_15 = Qh * Gam.T - Q12, Ph * G.T + P12
SPREAD = (Kq * Qs.T, Qh - A * Q_e * A.T)


def put_in(expr, meant):
    """Definitions put in until nothing changes."""
    meant, before = dict(map(tuple, meant)), None
    while expr != before:
        expr, before = expr.xreplace(meant), expr
    return expr


def tried(left, right, relations=()):
    """0 where the claim is proved, or a word for what cannot be multiplied.

    Of what is refuted by explicit matrices, what is left over.
    """
    try:
        proof = prove(left(), right, relations, letters.symmetric)
    except ValueError:  # ShapeError, ours or that of SymPy
        return NOT_CONFORMABLE
    except Unproved as refused:
        assert refused.counterexample, str(refused)
        return refused.left_over
    assert proof.check()
    return sp.Integer(0)


def compared(truth, ours, printed, relations=(), meant=()):
    """The printed claim and ours, after definitions are put in."""
    at = lambda expr: put_in(expr, meant)  # noqa: E731
    right = at(truth)
    relations = [tuple(map(at, relation)) for relation in relations]
    return tuple(
        tried(lambda side=side: at(side()), right, relations)
        for side in (printed, lambda: ours)
    )


def section_2():
    """R~, V2s and Qs, where letters or primes are lost."""
    (first, cross), (across, last) = cost.weight.right.blocks.tolist()
    own = put_in(best.is_V2s.right, (augmented.is_V2, best.is_Q1))
    return {
        "R~: Ce R Ce for Ce'R Ce": compared(
            Rt,
            cost.weight.right,
            lambda: BlockMatrix([[first, cross], [across, Ce * R * Ce]]),
            meant=MEANT,
        ),
        "section 2: tau Qh tau' is lost in V2s and Qs": compared(
            own,
            equations.written_V2s.right,
            lambda: C * Q * C.T + W2 + sum_i * C1 * Q * C1.T,
            [projection.hidden.relation],
        ),
    }


def conditions():
    """(4.7)-(4.11): what is differentiated, and modulo what."""
    at_Ae, at_Be, at_Ce, at_De = (
        slope.right / 2
        for slope in (
            *(gradients.is_gradAe, gradients.is_gradBe),
            *(gradients.is_gradCe, gradients.is_gradDe),
        )
    )
    rest = sum_i * At1.T * Pt * At1 + Rt - Pt
    input_, static = P2 * (Be * V2s - Gam * Qs), R * (De * V2s - L * Q * C.T)
    return {
        "(4.7): A~P~A~ for A~'P~A~": compared(
            ALGEBRA.gradient(gradients.lagrangian, Qt).as_expr(),
            At.T * Pt * At + rest,
            lambda: At * Pt * At + rest,
        ),
        "(4.8): P12 A Q12 for P12'A Q12": compared(
            at_Ae,
            P12.T * A * Q12 + P2 * Be * C * Q12 + P2 * Ae * Q2,
            lambda: P12 * A * Q12 + P2 * Be * C * Q12 + P2 * Ae * Q2,
        ),
        "(4.9): is the gradient in Be only modulo (4.8)": compared(
            input_, at_Be - at_Ae * G * C.T, lambda: at_Be, meant=MEANT
        ),
        "(4.11): is the gradient in De only modulo (4.10), times R^-1": compared(
            static, at_De - at_Ce * G * C.T, lambda: at_De, meant=MEANT
        ),
    }


def theorem_3_1():
    """(3.14)-(3.16) by what (4.12)-(4.16) say; what the scan lost is needed."""
    spread = tau * E_13 * G
    second, third = equations.second.right, equations.third.right
    riccati = equations.riccati_equation.right
    lifted = [projection.hidden.relation, (tau * Q_e, Q_e)]
    lifted_dual = [projection.hidden_dual.relation, (P_e * tau, P_e)]
    return {
        "(3.14): tau_perp Qh tau_perp' is needed": compared(
            equations.outer.right - Q_e,
            riccati,
            lambda: riccati - tau_perp * Qh * tau_perp.T,
            [equations.left.relation, SPREAD],
        ),
        "(3.15): A Qh A' for A tau Qh tau'A'": compared(
            projection.is_Qh.right,
            second,
            lambda: A * Qh * A.T + Kq * Qs.T,
            lifted,
        ),
        "(3.16): Ph for tau'Ph tau": compared(
            projection.is_Ph.right,
            third,
            lambda: Aq.T * Ph * Aq + Lq.T * R * Lq,
            lifted_dual,
        ),
        "(3.15): with the hats of section 4, tau Q tau', it is false": compared(
            projection.is_Qh.right - Qh,
            second - Qh,
            lambda: second.xreplace({Qh: Q_e}) - Q_e,
            lifted,
        ),
        "(3.16): with the hats of section 4, tau'P tau, it is false": compared(
            projection.is_Ph.right - Ph,
            third - Ph,
            lambda: third.xreplace({Ph: P_e}) - P_e,
            lifted_dual,
        ),
        "end of section 4: tau(4.13)G - (4.13)G - ((4.13)G)' gives (3.15)": compared(
            second - Qh,
            A * spread * A.T,
            lambda: spread - E_13 * G - (E_13 * G).T,
            [projection.one.relation, SPREAD],
            (best.is_tau, best.is_Q12, best.is_Qe),
        ),
    }


def section_4():
    """(4.13)-(4.16), which as printed have Gam G' = I in them."""
    printed_13, printed_15 = (Qh - Q_e) * Gam.T, (Ph - P_e) * G.T
    at = (*MEANT, *BEST, *HATS)
    return {
        "(4.13): - Qhat within the bracket": compared(
            A * Q12 * Ae.T + N12 - Q12, E_13, lambda: printed_13, meant=at
        ),
        "(4.14): - Qhat within the bracket": compared(
            Ae * Q2 * Ae.T + N2 - Q2,
            Gam * Qh * Gam.T - Q2,
            lambda: Gam * printed_13,
            meant=at,
        ),
        "(4.15): - Phat within the bracket": compared(
            A.T * P12 * Ae + M12 - P12, -E_15, lambda: -printed_15, meant=at
        ),
        "(4.16): - Phat within the bracket": compared(
            Ae.T * P2 * Ae + M2 - P2,
            G * Ph * G.T - P2,
            lambda: G * printed_15,
            meant=at,
        ),
        "end of section 4: Gam (4.13) - (4.14) is 0 = 0 as printed": compared(
            (Identity(r) - Gam * G.T) * Q2,
            Gam * E_13 - (Gam * Qh * Gam.T - Q2),
            lambda: Gam * printed_13 - Gam * printed_13,
            meant=at,
        ),
    }


def in_numbers():
    """Lemma 4.1 and the remark after (3.20)."""
    (grows,) = mean_square.grows.claims.values()
    seen = sp.Matrix([[1, 1], [0, 0]])  # tau, with null space along (1, -1)
    k, null = sp.Matrix([1, 0]), sp.Matrix([1, -1])
    outside = (seen.T * seen.T.pinv() * k - k).is_zero_matrix
    assert not outside  # k is not in the range of tau'
    return {
        "lemma 4.1, theorem 3.1: A stable for A (x) A + sum A_i (x) A_i stable": (
            Claim(sp.Max(mean_square.GROWTH, 1), sp.Integer(1)),
            grows,
        ),
        "after (3.20): annihilated is N(tau), not all outside R(tau')": (
            Claim(seen * k),
            Claim(seen * null),
        ),
    }


def entries():
    """{place and what is printed: (printed claim, correct claim)}."""
    return section_2() | conditions() | theorem_3_1() | section_4() | in_numbers()
