"""The paper's derivation in its canonical coordinates, block by block.

With P = [0; I] the unbiased observer is a family in two gains K1, K2, and the error
covariance is a quadratic in them.  Its gradients (32) are [K1 K2] M = N with M the
covariance of the innovation, so (33) needs no inverse but that of M; the completed
square J = J* + tr (K - K*) M (K - K*)' shows that it is the minimum, and the only
one exactly when M > 0.

The paper's sufficient condition, R22 > 0 and cov(w1) > 0, is right when R12 = 0 and
has a counterexample otherwise.

Source: Leondes and Novak (1974), section III, (24)-(36).
"""

from functools import cache

import sympy as sp
from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)

n, p, m1 = sp.symbols("n p m_1", integer=True, nonnegative=True)
nz, p2 = n - m1, p - m1  # order of the observer; number of the other outputs


def pair(name, a, b):
    """Blocks 11, 21, 22 of a symmetric matrix partitioned into sizes a and b."""
    return (
        MatrixSymbol(f"{name}_11", a, a),
        MatrixSymbol(f"{name}_21", b, a),
        MatrixSymbol(f"{name}_22", b, b),
    )


K1, K2, H2 = (
    MatrixSymbol(k, *d)
    for k, d in zip(("K_1", "K_2", "H_2"), ((nz, m1), (nz, p2), (p2, nz)))
)
O11, O21, O22 = pair("Omega", m1, nz)
R11, R21, R22 = pair("R", m1, p2)
X = MatrixSymbol("X", nz, nz)  # cov(eps)

Omega = BlockMatrix([[O11, O21.T], [O21, O22]])
R = BlockMatrix([[R11, R21.T], [R21, R22]])
H = BlockMatrix([[Identity(m1), ZeroMatrix(m1, nz)], [ZeroMatrix(p2, m1), H2]])
P = BlockMatrix([[ZeroMatrix(m1, nz)], [Identity(nz)]])
V = BlockMatrix([[Identity(m1), ZeroMatrix(m1, p2)], [K1, K2]])
T = BlockMatrix([[-K1, Identity(nz) - K2 * H2]])
K = BlockMatrix([[K1, K2]])
M = BlockMatrix(
    [[O11 + R11, R21.T + O21.T * H2.T], [R21 + H2 * O21, R22 + H2 * O22 * H2.T]]
)
N = BlockMatrix([[O21, O22 * H2.T]])

ALGEBRA = Algebra([O11, O22, R11, R22, X])


def trace_30():
    """(30) as it should be printed."""
    return (
        Trace(R11)
        + Trace(K1 * R11 * K1.T)
        + 2 * Trace(K1 * R21.T * K2.T)
        + Trace(K2 * R22 * K2.T)
        + Trace(K1 * O11 * K1.T)
        - 2 * Trace(O21 * K1.T)
        + Trace(O22)
        + Trace(K2 * H2 * O22 * H2.T * K2.T)
        + 2 * Trace(K1 * O21.T * H2.T * K2.T)
        - 2 * Trace(O22 * H2.T * K2.T)
    )


def gradients_32():
    """(32) as it should be printed: both vanish at the minimum."""
    return (
        K1 * (O11 + R11) + K2 * (H2 * O21 + R21) - O21,
        K2 * (H2 * O22 * H2.T + R22) + K1 * (O21.T * H2.T + R21.T) - O22 * H2.T,
    )


def solved_relations(K1, K2):
    """(32) as rewriting rules, for gains that satisfy it."""
    return (
        (K1 * R11, O21 - K1 * O11 - K2 * (H2 * O21 + R21)),
        (K2 * R22, O22 * H2.T - K2 * H2 * O22 * H2.T - K1 * (O21.T * H2.T + R21.T)),
    )


def formulas():
    z, eps = MatrixSymbol("z", nz, 1), MatrixSymbol("varepsilon", nz, 1)
    y, v = (
        BlockMatrix([[MatrixSymbol(f"{k}_1", m1, 1)], [MatrixSymbol(f"{k}_2", p2, 1)]])
        for k in "yv"
    )
    A, Q = MatrixSymbol("A", n, n), MatrixSymbol("Q", n, n)
    Pi, Vi = MatrixSymbol("P", n, nz), MatrixSymbol("V", n, p)
    Ri, Tn = MatrixSymbol("R", p, p), MatrixSymbol("T_+", nz, n)
    bracket = A * Pi * X * Pi.T * A.T + A * Vi * Ri * Vi.T * A.T + Q
    first, second = gradients_32()
    return {
        "(24) P": P,
        "(24) V": V,
        "(24) x_hat": P * z + V * y,
        "(25) T": T,
        "(26) e": P * eps + V * v,
        "(27) cov e": P * X * P.T + V * R * V.T,
        "(28) cov eps_+": Tn * bracket * Tn.T,
        "(28) Omega": bracket,
        "(29) Omega": Omega,
        "(29) cov eps_+": T * Omega * T.T,
        "(30) J": trace_30(),
        "(31) R": R,
        "(32) first": first,
        "(32) second": second,
        "(33) N": N,
        "(33) M": M,
        "(33) [K_1 K_2]": sp.MatMul(N, sp.Inverse(M)),
    }


def structure_steps():
    """(24)-(29): the family of unbiased observers and its error covariance."""
    Ta, Tb = MatrixSymbol("T_1", nz, m1), MatrixSymbol("T_2", nz, nz)
    unknown = BlockMatrix([[Ta, Tb]])
    left = BlockMatrix(
        [
            [ZeroMatrix(m1, m1), ZeroMatrix(m1, nz)],
            [Ta + K1, Tb - Identity(nz) + K2 * H2],
        ]
    )
    x, v = (
        BlockMatrix([[MatrixSymbol(f"{k}_1", m1, 1)], [MatrixSymbol(f"{k}_2", d, 1)]])
        for k, d in (("x", nz), ("v", p2))
    )
    eps = MatrixSymbol("varepsilon", nz, 1)
    A, Q = MatrixSymbol("A", n, n), MatrixSymbol("Q", n, n)
    Pi, Vi = MatrixSymbol("P", n, nz), MatrixSymbol("V", n, p)
    Ri, Tn = MatrixSymbol("R", p, p), MatrixSymbol("T_+", nz, n)
    bracket = A * (Pi * X * Pi.T + Vi * Ri * Vi.T) * A.T + Q
    F, D = Tn * A * Pi, Tn * A * Vi
    return claims(
        ALGEBRA,
        {
            "(13) P T + V H = I": (P * T + V * H, Identity(n)),
            "(25) T is the only solution of (13): T_1 = -K_1, T_2 = I - K_2 H_2": (
                P * unknown + V * H - Identity(n),
                left,
            ),
            "(24),(26) x_hat - x = P eps + V v": (
                P * (T * x + eps) + V * (H * x + v) - x,
                P * eps + V * v,
            ),
            "(27) tr cov e = tr R11 + tr cov(eps + K_1 v_1 + K_2 v_2)": (
                Trace(P * X * P.T + V * R * V.T),
                Trace(R11) + Trace(X + K * R * K.T),
            ),
        },
    ) | claims(
        ALGEBRA.with_relations(symmetric=[Q, Ri]),
        {
            "(28),(29) cov(F eps + D v - T_+ w) = T_+ Omega T_+', "
            "Omega = A cov(e) A' + Q": (
                F * X * F.T + D * Ri * D.T + Tn * Q * Tn.T,
                Tn * bracket * Tn.T,
            ),
            "(29) Omega_21 = Omega_12'": (bracket, bracket.T),
        },
    )


def minimum_steps():
    """(30)-(33): the trace, its gradients, their solution and the minimum."""
    J = Trace(P * (T * Omega * T.T) * P.T + V * R * V.T)
    first, second = gradients_32()
    D1, D2 = MatrixSymbol("Delta_1", nz, m1), MatrixSymbol("Delta_2", nz, p2)
    Delta = BlockMatrix([[D1, D2]])
    step = {K1: D1, K2: D2}
    curve = ALGEBRA.differential(ALGEBRA.differential(J, step), step)
    S1, S2 = MatrixSymbol("K_1*", nz, m1), MatrixSymbol("K_2*", nz, p2)
    best = BlockMatrix([[S1, S2]])
    solved = ALGEBRA.with_relations(*solved_relations(S1, S2))
    least = Trace(R11) + Trace(O22) - Trace(best * M * best.T)
    half = sp.S.Half
    return claims(
        ALGEBRA,
        {
            "(30) J = tr(P T Omega T' P' + V R V')": (trace_30(), J),
            "(32) first = half the gradient in K_1": (
                first,
                half * ALGEBRA.gradient(J, K1),
            ),
            "(32) second = half the gradient in K_2": (
                second,
                half * ALGEBRA.gradient(J, K2),
            ),
            "(32) is [K_1 K_2] M = N": (
                BlockMatrix([[first, second]]),
                K * M - N,
            ),
            "(31),(33) M = H Omega H' + R": (M, H * Omega * H.T + R),
            "(33) N = [0 I] Omega H': the lower rows of the Kalman gain": (
                N,
                P.T * Omega * H.T,
            ),
            "(33) second variation of J: 2 tr(Delta M Delta')": (
                curve,
                2 * Trace(Delta * M * Delta.T),
            ),
        },
    ) | claims(
        solved,
        {
            "(33) minimum: J = J* + tr (K - K*) M (K - K*)'": (
                J,
                least + Trace((K - best) * M * (K - best).T),
            )
        },
    )


def initial_steps():
    """(34)-(36): the first step, from the prior of x_0."""
    m = sp.Symbol("m", integer=True, nonnegative=True)
    A0, S0, Q0 = (MatrixSymbol(k, n, n) for k in ("A_0", "Sigma_00", "Q_0"))
    B0, u0 = MatrixSymbol("B_0", n, m), MatrixSymbol("u_0", m, 1)
    T1 = MatrixSymbol("T_1", nz, n)
    x0, mean, w0 = (MatrixSymbol(k, n, 1) for k in ("x_0", "xbar_0", "w_0"))
    x1, mean1 = A0 * x0 + B0 * u0 + w0, A0 * mean + B0 * u0
    error = A0 * (x0 - mean) + w0
    both = BlockMatrix([[S0, ZeroMatrix(n, n)], [ZeroMatrix(n, n), Q0]])
    map_ = BlockMatrix([[A0, Identity(n)]])
    Omega0 = A0 * S0 * A0.T + Q0
    found = {
        "(34) z_1": T1 * mean1,
        "(35) cov eps_1": T1 * Omega0 * T1.T,
        "(36) Omega_0": Omega0,
    }
    steps = claims(
        Algebra([S0, Q0]),
        {
            "(34) eps_1 = z_1 - T_1 x_1 = -T_1 (A_0 (x_0 - xbar_0) + w_0)": (
                T1 * mean1 - T1 * x1,
                -T1 * error,
            ),
            "(35),(36) cov eps_1 = T_1 Omega_0 T_1', x_0 and w_0 independent": (
                (T1 * map_) * both * (T1 * map_).T,
                T1 * Omega0 * T1.T,
            ),
        },
    )
    return found, steps


@cache
def derive():
    first, initial = initial_steps()
    return Derivation(
        given=(O11, O21, O22, R11, R21, R22, H2),
        formulas=formulas() | first,
        steps=structure_steps() | minimum_steps() | initial,
        source="Leondes and Novak (1974), (24)-(36)",
    )
