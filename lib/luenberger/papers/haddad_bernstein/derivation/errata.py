"""What Haddad and Bernstein's pages print, or the scan leaves, and what holds.

`entries()` gives for every place the printed claim and the correct one; the printed
one is tried like any other and does not vanish, or cannot even be multiplied.  Where
the scan has lost letters and nothing else (blocks of A~ and V~, tau^2 in (3.6)) there
is nothing to try.  That (3.14)-(3.16) need (3.17) in full is in
`counterexamples`.

Source: Haddad and Bernstein (1987), as scanned.
"""

import sympy as sp

from ....symbolic import BlockMatrix, Claim, Identity
from . import mean_square, projecting
from .blocks import (
    ALGEBRA,
    P2,
    P12,
    PAIRS,
    Q2,
    Q12,
    A,
    Ae,
    At,
    Be,
    C,
    Ce,
    De,
    L,
    Pt,
    R,
    adjoint,
    gradients,
    moment,
    noisy,
    r,
    weight,
)
from .projecting import (
    G,
    Gam,
    K,
    Ph,
    Phat,
    Q,
    Qh,
    Qhat,
    Qs,
    V2s,
    at,
    noise,
    tau,
    theorem,
)

NOT_CONFORMABLE = sp.Symbol("not conformable")
STRAIGHT, REDUCED = projecting.ALGEBRA, projecting.PROJECTING


def section_2():
    """R~, V2s and Qs, and (4.7), (4.8), where letters or primes are lost."""
    corner, cross = weight(PAIRS).blocks[0, 0], weight(PAIRS).blocks[0, 1]
    slopes = gradients(PAIRS)
    modulo = slopes[Be].as_expr() - slopes[Ae].as_expr() * G * C.T
    no_noise = {V2s: V2s - noise(Qhat, 1, 1), Qs: Qs - noise(Qhat, 0, 1)}
    said = P2 * (Be * V2s - Gam * Qs)
    dual = adjoint(PAIRS)
    quiet = sum((noisy(p).T * Pt * noisy(p) for p in PAIRS[1:]), weight(PAIRS))
    quiet = quiet + noisy(PAIRS[0]).T * Pt * noisy(PAIRS[0])
    return {
        "R~: Ce R Ce for Ce'R Ce": (
            ALGEBRA,
            lambda: BlockMatrix([[corner, cross], [cross.T, Ce * R * Ce]]),
            BlockMatrix([[corner, cross], [cross.T, Ce.T * R * Ce]]),
            weight(PAIRS),
        ),
        "section 2: tau Qh tau' is lost in V2s and Qs": (
            STRAIGHT,
            lambda: said.xreplace(no_noise),
            said,
            modulo,
        ),
        "(4.7): A~P~A~ for A~'P~A~": (
            ALGEBRA,
            lambda: At * Pt * At + quiet,
            At.T * Pt * At + quiet,
            dual,
        ),
        "(4.8): P12 A Q12 for P12'A Q12": (
            ALGEBRA,
            lambda: P12 * A * Q12 + P2 * Be * C * Q12 + P2 * Ae * Q2,
            P12.T * A * Q12 + P2 * Be * C * Q12 + P2 * Ae * Q2,
            slopes[Ae],
        ),
        "(4.9): is the gradient in Be only modulo (4.8)": (
            STRAIGHT,
            lambda: slopes[Be].as_expr(),
            modulo,
            said,
        ),
        "(4.11): is the gradient in De only modulo (4.10), times R^-1": (
            STRAIGHT,
            lambda: slopes[De].as_expr(),
            slopes[De].as_expr() - slopes[Ce].as_expr() * G * C.T,
            R * (De * V2s - L * Q * C.T),
        ),
    }


def theorem_3_1():
    """(3.14)-(3.16) by what (4.12)-(4.16) say; what the scan lost is needed."""
    ours, e13 = theorem(tau, Qh, Ph), Qh * Gam.T - G.T * Q2
    e15 = Ph * G.T - Gam.T * P2
    e12 = projecting.formulas()["(4.12)"]
    Aq, Lq = A - K * C, L - De * C
    quiet = noise(tau * e13 * G, 0, 0)
    riccati = e12 + tau * e13 * G - e13 * G - (e13 * G).T + quiet
    perp = (Identity(tau.shape[0]) - tau) * Qh * (Identity(tau.shape[0]) - tau).T
    hats = theorem(tau, Qhat, Phat)
    spread = tau * e13 * G
    return {
        "(3.14): tau_perp Qh tau_perp' is needed": (
            REDUCED,
            lambda: ours["(3.14)"] - perp,
            ours["(3.14)"],
            riccati,
        ),
        "(3.15): A Qh A' for A tau Qh tau'A'": (
            REDUCED,
            lambda: A * Qh * A.T + K * Qs.T - Qh,
            ours["(3.15)"],
            A * spread * A.T,
        ),
        "(3.16): Ph for tau'Ph tau": (
            REDUCED,
            lambda: Aq.T * Ph * Aq + Lq.T * R * Lq - Ph,
            ours["(3.16)"],
            Aq.T * (Gam.T * G * e15 * Gam) * Aq,
        ),
        "(3.15): with the hats of section 4, tau Q tau', it is false": (
            REDUCED,
            lambda: hats["(3.15)"],
            ours["(3.15)"],
            A * spread * A.T,
        ),
        "(3.16): with the hats of section 4, tau'P tau, it is false": (
            REDUCED,
            lambda: hats["(3.16)"],
            ours["(3.16)"],
            Aq.T * (Gam.T * G * e15 * Gam) * Aq,
        ),
        "end of section 4: tau(4.13)G - (4.13)G - ((4.13)G)' gives (3.15)": (
            REDUCED,
            lambda: spread - e13 * G - (e13 * G).T,
            A * spread * A.T,
            ours["(3.15)"],
        ),
    }


def section_4():
    """(4.13)-(4.16), which as printed have Gam G' = I in them."""
    ahead, back = moment(PAIRS), adjoint(PAIRS)
    e13 = lambda hat: (Qh - hat) * Gam.T  # noqa: E731
    e14 = lambda hat: Gam * (Qh - hat) * Gam.T  # noqa: E731
    gap = (Identity(r) - Gam * G.T) * Q2
    return {
        "(4.13): - Qhat within the bracket": (
            STRAIGHT,
            lambda: e13(Qhat),
            Qh * Gam.T - Q12,
            at(ahead[0, 1]) - Q12,
        ),
        "(4.14): - Qhat within the bracket": (
            STRAIGHT,
            lambda: e14(Qhat),
            Gam * Qh * Gam.T - Q2,
            at(ahead[1, 1]) - Q2,
        ),
        "(4.15): - Phat within the bracket": (
            STRAIGHT,
            lambda: -(Ph - Phat) * G.T,
            -Ph * G.T - P12,
            at(back[0, 1]) - P12,
        ),
        "(4.16): - Phat within the bracket": (
            STRAIGHT,
            lambda: G * (Ph - Phat) * G.T,
            G * Ph * G.T - P2,
            at(back[1, 1]) - P2,
        ),
        "end of section 4: Gam (4.13) - (4.14) is 0 = 0 as printed": (
            STRAIGHT,
            lambda: Gam * e13(Qhat) - e14(Qhat),
            Gam * (Qh * Gam.T - Q12) - (Gam * Qh * Gam.T - Q2),
            gap,
        ),
    }


def in_numbers():
    """Lemma 4.1 and the remark after (3.20)."""
    radius = sp.Rational(169, 100)
    found = mean_square.derive().steps
    (lemma,) = (c for k, c in found.items() if "det(z" in k)
    seen = sp.Matrix([[1, 1], [0, 0]])  # tau, with null space along (1, -1)
    k, null = sp.Matrix([1, 0]), sp.Matrix([1, -1])
    outside = (seen.T * seen.T.pinv() * k - k).is_zero_matrix
    assert not outside  # k is not in the range of tau'
    return {
        "lemma 4.1, theorem 3.1: A stable for A (x) A + sum A_i (x) A_i stable": (
            Claim(sp.Max(radius, 1), sp.Integer(1)),
            lemma,
        ),
        "after (3.20): annihilated is N(tau), not all outside R(tau')": (
            Claim(seen * k),
            Claim(seen * null),
        ),
    }


def tried(algebra, expression, truth):
    """The claim, or a word for what cannot be multiplied."""
    try:
        found = Claim(expression(), truth, algebra)
        return found if found.residual is not None else NOT_CONFORMABLE
    except ValueError:  # ShapeError, ours or that of SymPy
        return NOT_CONFORMABLE


def entries():
    """{place and what is printed: (printed claim, correct claim)}."""
    found = {
        place: (
            tried(algebra, printed, truth),
            tried(algebra, lambda ours=ours: ours, truth),
        )
        for place, (algebra, printed, ours, truth) in (
            section_2() | theorem_3_1() | section_4()
        ).items()
    }
    return found | in_numbers()
