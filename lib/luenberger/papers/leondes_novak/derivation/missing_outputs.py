"""A step at which some outputs did not arrive: the same theorem for fewer outputs.

Let Z (pa, p) pick the outputs that arrived.  A gain that may use only these is
K = Ka Z, and such a gain costs what Ka costs with Z C and Z R Z' in place of C and R;
so the best one is the step-wise gain of the shorter problem.  An accurate output that
is missing leaves C1 too: the null space of what remains of C1 has one dimension more,
and the direction that the output would have shown is predicted and filtered like the
others.  The same gain is the limit of infinite noise on the missing outputs.

Source: our own; the step is Leondes and Novak's (1974), (27)-(33).
"""

from functools import cache

import sympy as sp
from sympy import Trace

from ....symbolic import Algebra, Derivation, Identity, MatrixSymbol, ZeroMatrix, claims

n, p, pa, m1, pm = sp.symbols("n p p_a m_1 p_m", integer=True, nonnegative=True)
C, R = MatrixSymbol("C", p, n), MatrixSymbol("R", p, p)
Omega, W = MatrixSymbol("Omega", n, n), MatrixSymbol("W", n, n)
Z, Ka = MatrixSymbol("Z", pa, p), MatrixSymbol("K_a", n, pa)
I = Identity(n)


def covariance(K, C, R):
    """Of the error after a step with any gain K: (26), (27)."""
    return (I - K * C) * Omega * (I - K * C).T + K * R * K.T


def shorter_problem():
    """Gains that leave the missing outputs out are gains of the shorter problem."""
    algebra = Algebra([Omega, R, W])
    M = Z * (C * Omega * C.T + R) * Z.T
    gradient = algebra.gradient(Trace(W * covariance(Ka * Z, C, R)), Ka)
    return claims(
        algebra,
        {
            "(27) K = Ka Z costs what Ka costs with Z C and Z R Z'": (
                covariance(Ka * Z, C, R),
                covariance(Ka, Z * C, Z * R * Z.T),
            ),
            "(33) its innovation covariance is Z M Z'": (
                (Z * C) * Omega * (Z * C).T + Z * R * Z.T,
                M,
            ),
            "(32) gradient in Ka: 2 W (Ka Z M Z' - Omega C'Z')": (
                gradient,
                2 * W * (Ka * M - Omega * C.T * Z.T),
            ),
        },
    )


def accurate_output_missing():
    """C1 loses its row c: the direction g that c alone shows is free as well."""
    C1, c = MatrixSymbol("C_1", m1, n), MatrixSymbol("c", 1, n)
    N, g = MatrixSymbol("N", n, n - m1 - 1), MatrixSymbol("g_c", n, 1)
    k, t = MatrixSymbol("k_c", n - m1 - 1, 1), MatrixSymbol("t_c", 1, 1)
    relations = [
        (C1 * N, ZeroMatrix(m1, n - m1 - 1)),
        (c * N, ZeroMatrix(1, n - m1 - 1)),
        (C1 * g, ZeroMatrix(m1, 1)),
        (c * g, Identity(1)),
    ]
    free = N * k + g * t
    return claims(
        Algebra([], relations),
        {
            "order: with C1 N = 0, c N = 0, C1 g = 0, c g = 1: C1 (N k + g t) = 0": (
                C1 * free,
                0,
            ),
            "order: the one free direction more is what c would have shown, t": (
                c * free,
                t,
            ),
        },
    )


def infinite_noise():
    """Noise t on the missing outputs: both block equations, and the limit."""
    Maa, Sm = MatrixSymbol("M_aa", pa, pa), MatrixSymbol("S_m", pm, pm)
    Mma = MatrixSymbol("M_ma", pm, pa)
    Na, Nm = MatrixSymbol("N_a", n, pa), MatrixSymbol("N_m", n, pm)
    rest = Nm - Na * Maa.I * Mma.T
    Km = rest * Sm.I
    Ka_t = (Na - Km * Mma) * Maa.I
    algebra = Algebra([Maa, Sm])
    return claims(
        algebra,
        {
            "infinite noise: K_m = (N_m - N_a M_aa^-1 M_am) S^-1, S = S_0 + t I": (
                Ka_t * Mma.T + Km * (Sm + Mma * Maa.I * Mma.T),
                Nm,
            ),
            "infinite noise: K_a = (N_a - K_m M_ma) M_aa^-1": (
                Ka_t * Maa + Km * Mma,
                Na,
            ),
            "infinite noise: K_m = 0 leaves K_a = N_a M_aa^-1, the gain without them": (
                Ka_t,
                Na * Maa.I - Km * Mma * Maa.I,
            ),
        },
    )


@cache
def derive():
    """The step with missing outputs, proved at symbolic sizes."""
    return Derivation(
        formulas={
            "missing outputs: K": Ka * Z,
            "missing outputs: C": Z * C,
            "missing outputs: R": Z * R * Z.T,
        },
        steps=shorter_problem() | accurate_output_missing() | infinite_noise(),
        source="our own",
    )
