"""The theorem's formulas (3.10)-(3.18), as lists of small assignments.

As in `moment_stages`: the letters are those of `augmented`, V1, V12 and V2
are those of the equivalent plant, `stages` are compiled and `steps` are proved.  Qh
and Ph are the hatted matrices of the theorem, which section 4 of the paper writes in
script; its own hats are G'Q2 G and Gam'P2 Gam.

Source: Haddad and Bernstein (1987), (3.8)-(3.18); the innovations plant is our own.
"""

from dataclasses import replace
from functools import cache

from ....symbolic import Derivation, Identity, Solve, Stage, matrices
from . import theorem_claims as prove
from .augmented import (
    P2,
    P12,
    Q1,
    Q2,
    Q12,
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
    l,
    n,
    q,
    r,
)

PAPER = "Haddad and Bernstein (1987)"

Qs, Kq = matrices("Qs Kq", n, l)
(V2s,) = matrices("V2s", l, l)
Q, Qh, Ph, tau, Aq, forgets = matrices("Q Qh Ph tau Aq forgets", n, n)
(Lq,) = matrices("Lq", q, n)
G, Gam = matrices("G Gam", r, n)


@cache
def projection_innovation():
    """Qs = E[x+ innovation'] and V2s = cov(innovation) when y is predicted by C x^.

    Q is the error covariance of x^; the Kalman filter's too.
    """
    stages = (
        Stage(Qs, A * Q * C.T + V12, "section 2"),
        Stage(V2s, C * Q * C.T + V2, "section 2", symmetric=True),
    )
    found = Derivation((A, C, V12, V2, Q), stages, source=PAPER)
    return replace(found, steps=prove.projection_innovation(found))


@cache
def projection_factors():
    """G, Gam, tau and Q from the moments and their duals; GamG should be I."""
    (Gt, Gamt), (GamG,) = matrices("Gt Gamt", n, r), matrices("GamG", r, r)
    stages = (
        Stage(Gt, Solve(Q12, Q2)),
        Stage(Gamt, Solve(-P12, P2)),
        Stage(G, Gt.T),
        Stage(Gam, Gamt.T),
        Stage(GamG, Gamt.T * Gt, "(3.9)"),
        Stage(tau, Gt * Gamt.T, "(3.8)"),
        Stage(Q, Q1 - Gt * Q12.T, symmetric=True),
    )
    found = Derivation((Q1, Q12, Q2, P12, P2), stages, source=PAPER)
    return replace(found, steps=prove.projection_factors(found))


@cache
def feedthrough_gain():
    """The static gain De, of an estimator that has one."""
    stages = (Stage(De, Solve(L * Q * C.T, V2s), "(3.13)"),)
    found = Derivation((C, L, Q, V2s), stages, source=PAPER)
    return replace(found, steps=prove.feedthrough_gain(found))


@cache
def projection_gains():
    """Ae, Be, Ce from the projection; De is 0 for an estimator without feedthrough."""
    stages = (
        Stage(Kq, Solve(Qs, V2s)),
        Stage(Aq, A - Kq * C),
        Stage(Ae, Gam * Aq * G.T, "(3.10)"),
        Stage(Be, Gam * Kq, "(3.11)"),
        Stage(Ce, (L - De * C) * G.T, "(3.12)"),
    )
    given = (A, C, L, Qs, V2s, G, Gam, De)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=prove.projection_gains(found))


@cache
def projection_scripts():
    """Qh and Ph of the theorem from an estimator's Q2, P2, G and Gam."""
    stages = (
        Stage(Kq, Solve(Qs, V2s)),
        Stage(Aq, A - Kq * C),
        Stage(Lq, L - De * C),
        Stage(
            Qh,
            A * G.T * Q2 * G * A.T + Kq * Qs.T,
            "section 4, script Q",
            symmetric=True,
        ),
        Stage(
            Ph,
            Aq.T * Gam.T * P2 * Gam * Aq + Lq.T * R * Lq,
            "section 4, script P",
            symmetric=True,
        ),
    )
    given = (A, C, L, R, De, Qs, V2s, Q2, P2, G, Gam)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=prove.projection_scripts(found))


@cache
def projection_equations():
    """Residuals: right side minus left of (3.14)-(3.16), and what tau must satisfy.

    `aligned_Q` and `aligned_P` vanish when tau is diagonal where Qh and Ph are; that
    is what (3.17) adds to tau^2 = tau, and without it the equations are too weak.
    """
    names = "riccati estimate adjoint idempotent aligned_Q aligned_P"
    riccati, estimate, adjoint, idempotent, aligned_Q, aligned_P = matrices(names, n, n)
    spread = Kq * Qs.T
    stages = (
        Stage(Kq, Solve(Qs, V2s)),
        Stage(Aq, A - Kq * C),
        Stage(Lq, L - De * C),
        Stage(forgets, Identity(n) - tau),
        Stage(
            riccati,
            A * Q * A.T + V1 - spread + forgets * Qh * forgets.T - Q,
            "(3.14)",
            symmetric=True,
        ),
        Stage(
            estimate,
            A * tau * Qh * tau.T * A.T + spread - Qh,
            "(3.15)",
            symmetric=True,
        ),
        Stage(
            adjoint,
            Aq.T * tau.T * Ph * tau * Aq + Lq.T * R * Lq - Ph,
            "(3.16)",
            symmetric=True,
        ),
        Stage(idempotent, -tau * forgets, "(3.6)"),  # tau^2 - tau
        Stage(aligned_Q, tau * Qh - Qh * tau.T, "(3.17)"),
        Stage(aligned_P, Ph * tau - tau.T * Ph, "(3.17)"),
    )
    given = (A, C, L, R, De, V1, Qs, V2s, Q, Qh, Ph, tau)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=prove.projection_equations(found))


@cache
def projection_trace():
    """The least cost as the trace of J; De is 0 without feedthrough."""
    (J,) = matrices("J", q, q)
    stages = (Stage(J, (L * Q * L.T - De * V2s * De.T) * R, "(3.18)"),)
    found = Derivation((L, R, De, Q, V2s), stages, source=PAPER)
    return replace(found, steps=prove.projection_trace(found))


@cache
def innovations_plant():
    """The Kalman predictor as a plant: x^+ = A x^ + Kq i, y = C x^ + i.

    Q, Qs and V2s are the Kalman filter's and De its feedthrough gain, or 0.  An
    estimator (Ae, Be, Ce, De0) of L x costs what the Kalman filter costs, plus what
    (Ae, Be, Ce, De0 - De) costs as an estimator of Lq x^ on this plant, whose noise
    has the covariances V1i, Qs and V2s.  The excess is free of cancellation.
    """
    (V1i,) = matrices("V1i", n, n)
    stages = (
        Stage(Kq, Solve(Qs, V2s)),
        Stage(V1i, Kq * Qs.T, symmetric=True),
        Stage(Lq, L - De * C),
    )
    found = Derivation((C, L, Qs, V2s, De), stages, source="our own")
    return replace(found, steps=prove.innovations_plant(found))
