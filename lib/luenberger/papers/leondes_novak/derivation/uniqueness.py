"""When (32) has one solution only: exactly when M, the innovation covariance, is > 0.

If M > 0 the completed square vanishes at the minimum alone.  If M a = 0 the vector a
is neither seen by the outputs nor moved by their noise, so b a' can be added to the
gain at no cost.  The paper's condition, R22 > 0 and cov(w1) > 0, gives M > 0 when
R12 = 0 and not in general: noises may cancel each other.

Source: our own; Leondes and Novak (1974), after (33), state the condition.
"""

from functools import cache

import sympy as sp
from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Claim,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)

n, p, m1 = sp.symbols("n p m_1", integer=True, nonnegative=True)
nz, p2 = n - m1, p - m1
K, D, N = (MatrixSymbol(k, nz, p) for k in ("K", "Delta", "N"))
M, Mi, L, R = (MatrixSymbol(k, p, p) for k in ("M", "M^-1", "L", "R"))
H, P = MatrixSymbol("H", p, n), MatrixSymbol("P", n, nz)
Omega, G, G_R = (
    MatrixSymbol("Omega", n, n),
    MatrixSymbol("G", n, n),
    MatrixSymbol("G_R", p, p),
)
a, b = MatrixSymbol("a", p, 1), MatrixSymbol("b", nz, 1)


def positive():
    """M = L L' with L invertible: nothing but Delta = 0 is free of cost."""
    algebra = Algebra([M], [(M, L * L.T)])
    return claims(
        algebra,
        {
            "M > 0: tr(Delta M Delta') = |Delta L|^2, M = L L'": (
                Trace(D * M * D.T),
                Trace((D * L) * (D * L).T),
            ),
            "M > 0: Delta = (Delta L) L^-1, so the minimum is unique": (
                (D * L) * L.I,
                D,
            ),
        },
    ) | claims(
        Algebra([M], [(Mi, M.I)]),  # by name: SymPy itself would cancel M.I * M
        {"(33) K = N M^-1 solves K M = N": (N * Mi * M, N)},
    )


def schur():
    """The inverse in (33) by blocks: only a corner of M and its complement."""
    A, S = MatrixSymbol("M_11", m1, m1), MatrixSymbol("S", p2, p2)
    B, I = MatrixSymbol("M_21", p2, m1), Identity
    whole = BlockMatrix([[A, B.T], [B, S + B * A.I * B.T]])
    corner = A.I * B.T * S.I
    inverse = BlockMatrix([[A.I + corner * B * A.I, -corner], [-corner.T, S.I]])
    return claims(
        Algebra([A, S]),
        {
            "(33) M M^-1 = I by blocks, S = M_22 - M_21 M_11^-1 M_12": (
                whole * inverse,
                I(p),
            ),
            "(33) M^-1 M = I by blocks": (inverse * whole, I(p)),
        },
    )


def singular():
    """M a = 0: the gain is not determined along a."""
    factors = [(Omega, G * G.T), (R, G_R * G_R.T)]
    split = Algebra([Omega, R], factors)
    unseen = Algebra(
        [Omega, R],
        [*factors, (G.T * H.T * a, ZeroMatrix(n, 1)), (G_R.T * a, ZeroMatrix(p, 1))],
    )
    full = H * Omega * H.T + R
    seen, noise = G.T * H.T * a, G_R.T * a

    def cost(gain):
        return Trace(gain * full * gain.T) - 2 * Trace(gain * H * Omega * P)

    return claims(
        split,
        {
            "M a = 0: a'M a = |G'H'a|^2 + |G_R'a|^2, Omega = G G', R = G_R G_R'": (
                Trace(a.T * full * a),
                Trace(seen.T * seen) + Trace(noise.T * noise),
            )
        },
    ) | claims(
        unseen,
        {
            "M a = 0: K + b a' solves (32) as well": (
                (K + b * a.T) * full - P.T * Omega * H.T,
                K * full - P.T * Omega * H.T,
            ),
            "M a = 0: K + b a' has the same error trace": (cost(K + b * a.T), cost(K)),
        },
    )


def sufficient():
    """R22 > 0 and cov(w1) > 0: enough when R12 = 0, not enough otherwise."""
    O11, R11, X11, Q11 = (
        MatrixSymbol(k, m1, m1) for k in ("Omega_11", "R_11", "X_11", "Q_11")
    )
    O21, O22 = MatrixSymbol("Omega_21", nz, m1), MatrixSymbol("Omega_22", nz, nz)
    R22, H2 = MatrixSymbol("R_22", p2, p2), MatrixSymbol("H_2", p2, nz)
    a1, a2 = MatrixSymbol("a_1", m1, 1), MatrixSymbol("a_2", p2, 1)
    mixed, at = Algebra([O11, O22, R11, R22]), BlockMatrix([[a1], [a2]])
    alone = Algebra([O11, O22, R11, R22, X11, Q11], [(O11, X11 + Q11)])
    whole = BlockMatrix([[O11, O21.T], [O21, O22]])
    Hb = BlockMatrix([[Identity(m1), ZeroMatrix(m1, nz)], [ZeroMatrix(p2, m1), H2]])
    Rb = BlockMatrix([[R11, ZeroMatrix(m1, p2)], [ZeroMatrix(p2, m1), R22]])
    only = BlockMatrix([[a1], [ZeroMatrix(p2, 1)]])
    full = Hb * whole * Hb.T + Rb
    return claims(
        mixed,
        {
            "R12 = 0: a'M a = (H'a)'Omega(H'a) + a_1'R_11 a_1 + a_2'R_22 a_2, so "
            "R_22 > 0 leaves a_2 = 0": (
                Trace(at.T * full * at),
                Trace((Hb.T * at).T * whole * (Hb.T * at))
                + Trace(a1.T * R11 * a1)
                + Trace(a2.T * R22 * a2),
            )
        },
    ) | claims(
        alone,
        {
            "R12 = 0: then a_1'(X_11 + Q_11 + R_11) a_1 >= a_1'Q_11 a_1 > 0": (
                Trace(only.T * full * only),
                Trace(a1.T * X11 * a1)
                + Trace(a1.T * Q11 * a1)
                + Trace(a1.T * R11 * a1),
            )
        },
    )


def counterexample():
    """A = 0, Q = R = ones, H = I: the condition holds and det M = 0."""
    Q = sp.ones(2, 2)
    R, H, A, Sigma = sp.ones(2, 2), sp.eye(2), sp.zeros(2, 2), sp.eye(2)
    M = H * (A * Sigma * A.T + Q) * H.T + R
    holds = sp.Integer(int(bool(R[1, 1] > 0 and Q[0, 0] > 0)))
    return {
        "counterexample, n = p = 2, m1 = 1, A = 0, Q = R = ones: R22 > 0, Q11 > 0": (
            Claim(holds, sp.Integer(1))
        ),
        "counterexample, n = p = 2, m1 = 1, A = 0, Q = R = ones: det M = 0": (
            Claim(M.det())
        ),
    }


@cache
def derive():
    return Derivation(
        given=(M, N, Omega, R, H),
        formulas={
            "(33) K": N * M.I,
            "M": H * Omega * H.T + R,
            "other solutions if M a = 0": K + b * a.T,
        },
        steps=positive() | schur() | singular() | sufficient() | counterexample(),
        source="our own; Leondes and Novak (1974), after (33)",
    )
