"""The theorem in normal forms, for claims that are evaluated.

Q12 = G'Q2, P12 = -Gam'P2 and Q1 = Q + G'Q2 G define G, Gam and Q; with them each
gradient, freed of invertible factors, is linear in one gain.  The moment equations
at those gains say Gam G' = I, so that tau = G'Gam is a projection, and combine to
(3.14)-(3.16).  Section 4 writes in script what the theorem writes with hats; `Qh`
and `Ph` are the theorem's.  The printed (4.13)-(4.16) take Gam G' = I for granted
and then prove it by 0 = 0; here they are repaired.

Source: Haddad and Bernstein (1987), theorem 3.1, lemma 3.1, remarks and section 4.
"""

from functools import cache

from sympy import Trace

from ....symbolic import Algebra, Derivation, Identity, MatrixSymbol, ZeroMatrix, claims
from .blocks import (
    GAINS,
    P2,
    P12,
    PAIRS,
    Q1,
    Q2,
    Q12,
    SYMMETRIC,
    V1,
    V2,
    V12,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    R,
    adjoint,
    gradients,
    l,
    moment,
    n,
    r,
)
from .letters import G, Gam, Q, Qs, V2s

tau = G.T * Gam
K = Qs * V2s.I  # gain of the innovation y - C x^ on x^_+
Qhat, Phat = G.T * Q2 * G, Gam.T * P2 * Gam  # the hats of section 4
Qh = A * Qhat * A.T + K * Qs.T
Ph = (A - K * C).T * Phat * (A - K * C) + (L - De * C).T * R * (L - De * C)

BEST = {
    Ae: Gam * (A - K * C) * G.T,
    Be: Gam * K,
    Ce: (L - De * C) * G.T,
}


def noise(X, left, right):
    """sum A_i X C_i' and the like; left and right are 0 for A_i, 1 for C_i."""
    rows, cols = (n, l)[left], (n, l)[right]
    terms = (pair[left] * X * pair[right].T for pair in PAIRS)
    return sum(terms, ZeroMatrix(rows, cols))


MEANT = (
    (Q12, G.T * Q2),
    (P12, -Gam.T * P2),
    (Q1, Q + Qhat),
    (V2, V2s - C * Q * C.T - noise(Q + Qhat, 1, 1)),
    (V12, Qs - A * Q * C.T - noise(Q + Qhat, 0, 1)),
)
ALGEBRA = Algebra((*SYMMETRIC, Q, V2s), MEANT)
PROJECTING = ALGEBRA.with_relations((Gam * G.T, Identity(r)))


def theorem(tau, Qh, Ph):
    """Right side minus left of (3.14)-(3.16), with any matrices for tau, Qh, Ph."""
    forgets = Identity(n) - tau
    spread = K * Qs.T
    return {
        "(3.14)": A * Q * A.T
        + noise(Q + tau * Qh * tau.T, 0, 0)
        + V1
        - spread
        + forgets * Qh * forgets.T
        - Q,
        "(3.15)": A * tau * Qh * tau.T * A.T + spread - Qh,
        "(3.16)": (A - K * C).T * tau.T * Ph * tau * (A - K * C)
        + (L - De * C).T * R * (L - De * C)
        - Ph,
    }


def at(value, gains=BEST):
    """A normal form of `augmented` with gains put in."""
    return value.as_expr().xreplace(gains)


def formulas():
    Qh_, Ph_ = MatrixSymbol("Qh", n, n), MatrixSymbol("Ph", n, n)
    of_tau = noise(Q + tau * Qh_ * tau.T, 1, 1), noise(Q + tau * Qh_ * tau.T, 0, 1)
    return theorem(MatrixSymbol("tau", n, n), Qh_, Ph_) | {
        "G": Q2.I * Q12.T,
        "Gam": -P2.I * P12.T,
        "Q": Q1 - Q12 * Q2.I * Q12.T,
        "V2s": V2 + C * Q * C.T + of_tau[0],
        "Qs": A * Q * C.T + V12 + of_tau[1],
        "(3.8) tau": tau,
        "(3.10) Ae": BEST[Ae],
        "(3.10)' Ae": Gam * A * G.T - Be * C * G.T,
        "(3.11) Be": BEST[Be],
        "(3.12) Ce": BEST[Ce],
        "(3.13) De": L * Q * C.T * V2s.I,
        "(3.18) J": Trace((L * Q * L.T - De * V2s * De.T) * R),
        "script Q": Qh,
        "script P": Ph,
        "(4.12)": A * (Q + Qhat) * A.T + noise(Q + Qhat, 0, 0) + V1 - Q - Qhat,
        "(4.13) repaired": Qh * Gam.T - G.T * Q2,
        "(4.14) repaired": Gam * Qh * Gam.T - Q2,
        "(4.15) repaired": Ph * G.T - Gam.T * P2,
        "(4.16) repaired": G * Ph * G.T - P2,
    }


def elimination():
    """(4.8)-(4.11) freed of invertible factors, and solved."""
    g = gradients(PAIRS)
    freed = {
        "(3.10)' P2^-1 (4.8) Q2^-1 = Ae - (Gam A G' - Be C G')": (
            P2.I * g[Ae].as_expr() * Q2.I,
            Ae - Gam * A * G.T + Be * C * G.T,
        ),
        "(3.11) P2^-1 (4.9) = Be V2s - Gam Qs, modulo (4.8)": (
            P2.I * (g[Be].as_expr() - g[Ae].as_expr() * G * C.T),
            Be * V2s - Gam * Qs,
        ),
        "(3.12) R^-1 (4.10) Q2^-1 = Ce - (L - De C) G'": (
            R.I * g[Ce].as_expr() * Q2.I,
            Ce - (L - De * C) * G.T,
        ),
        "(3.13) R^-1 (4.11) = De V2s - L Q C', modulo (4.10)": (
            R.I * (g[De].as_expr() - g[Ce].as_expr() * G * C.T),
            De * V2s - L * Q * C.T,
        ),
    }
    full = BEST | {De: L * Q * C.T * V2s.I}
    full[Ce] = BEST[Ce].xreplace({De: full[De]})
    solved = {
        f"({k}) the gradient in {X.name} vanishes at (3.10)-(3.13)": (at(g[X], full), 0)
        for k, X in zip(("3.10", "3.11", "3.12", "3.13"), GAINS)
    }
    return (
        freed
        | solved
        | {
            "(3.10) is (3.10)' with (3.11)": (
                BEST[Ae],
                Gam * A * G.T - BEST[Be] * C * G.T,
            )
        }
    )


def moments():
    """(4.12)-(4.16), repaired: blocks of (4.6) and (4.7) at the gains (3.10)-(3.12)."""
    ahead, back = moment(PAIRS), adjoint(PAIRS)
    return {
        "(4.12) block 11 of (4.6): A (Q + Qhat) A' + sum + V1 - Q - Qhat": (
            at(ahead[0, 0]) - Q1,
            formulas()["(4.12)"],
        ),
        "(4.13) repaired, block 12 of (4.6): [A Qhat A' + K Qs'] Gam' - Q12": (
            at(ahead[0, 1]) - Q12,
            Qh * Gam.T - Q12,
        ),
        "(4.14) repaired, block 22 of (4.6): Gam [A Qhat A' + K Qs'] Gam' - Q2": (
            at(ahead[1, 1]) - Q2,
            Gam * Qh * Gam.T - Q2,
        ),
        "(4.15) repaired, block 12 of (4.7): -([..] G' + P12)": (
            at(back[0, 1]) - P12,
            -(Ph * G.T + P12),
        ),
        "(4.16) repaired, block 22 of (4.7): G [..] G' - P2": (
            at(back[1, 1]) - P2,
            G * Ph * G.T - P2,
        ),
        "(3.9) Gam (4.13) - (4.14) = (I - Gam G') Q2, so Gam G' = I": (
            Gam * (Qh * Gam.T - Q12) - (Gam * Qh * Gam.T - Q2),
            (Identity(r) - Gam * G.T) * Q2,
        ),
        "(3.9) G (4.15) - (4.16) = (I - G Gam') P2, so again": (
            G * (Ph * G.T + P12) - (G * Ph * G.T - P2),
            (Identity(r) - G * Gam.T) * P2,
        ),
    }


def equations():
    """(3.14)-(3.16): right side minus left, from (4.12)-(4.16)."""
    e12 = formulas()["(4.12)"]
    e13, e15 = Qh * Gam.T - Q12, Ph * G.T + P12
    said, hidden = theorem(tau, Qh, Ph), tau * Qh * tau.T
    return {
        "(3.14) = (4.12) + tau (4.13) G - (4.13) G - ((4.13) G)'": (
            said["(3.14)"] - noise(hidden - Qhat, 0, 0),
            e12 + tau * e13 * G - e13 * G - (e13 * G).T,
        ),
        "(3.15) = A (tau (4.13) G) A': tau Qh tau' = Qhat": (
            said["(3.15)"],
            A * (tau * e13 * G) * A.T,
        ),
        "(3.16) = Aq'(Gam'G (4.15) Gam) Aq: tau'Ph tau = Phat": (
            said["(3.16)"],
            (A - K * C).T * (Gam.T * G * e15 * Gam) * (A - K * C),
        ),
        "V2s of section 2 is that of section 4, as tau Qh tau' = Qhat": (
            C * Q * C.T + V2 + noise(Q + hidden, 1, 1) - V2s,
            noise(G.T * Gam * e13 * G, 1, 1),
        ),
        "Qs of section 2 is that of section 4, as tau Qh tau' = Qhat": (
            A * Q * C.T + V12 + noise(Q + hidden, 0, 1) - Qs,
            noise(G.T * Gam * e13 * G, 0, 1),
        ),
        "(3.17) tau Qh - Qh tau' = G'(4.13)' - (4.13) G": (
            tau * Qh - Qh * tau.T,
            G.T * e13.T - e13 * G,
        ),
        "(3.17) Ph tau - tau'Ph = (4.15) Gam - Gam'(4.15)'": (
            Ph * tau - tau.T * Ph,
            e15 * Gam - Gam.T * e15.T,
        ),
    }


@cache
def derive():
    return Derivation(
        given=(A, C, V1, V12, V2, L, R, Q2, P2, G, Gam),
        formulas=formulas(),
        steps=claims(ALGEBRA, elimination() | moments())
        | claims(PROJECTING, equations()),
        source="Haddad and Bernstein (1987), (3.8)-(3.17), (4.12)-(4.16)",
    )
