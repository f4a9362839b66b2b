"""Which coordinates are best when the accurate outputs are not perfect.

An estimate that matches the accurate outputs, C1 x^ = y1, is the minimum-variance
estimate plus Gamma (y1 - C1 x^_mv) with C1 Gamma = I, plus noise that only harms.
The second group of coordinates fixes Gamma, so the choice of rows in (19) chooses
the estimator.  The weighted error trace is least where Gamma' W N = 0, N a basis of
the null space of C1: Gamma = W^-1 C1'(C1 W^-1 C1')^-1.

Psi, the covariance of y1 - C1 x^_mv, is inverted in two of the steps and nowhere in
the recursion; where R11 = 0 it is zero and all choices agree.

Source: our own; the coordinates are those of Leondes and Novak (1974), (19).
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
from .claims import joseph

n, p, m1 = sp.symbols("n p m_1", integer=True, nonnegative=True)
nz = n - m1
C, C1, Select = (
    MatrixSymbol(k, *d) for k, d in (("C", (p, n)), ("C_1", (m1, n)), ("S_1", (m1, p)))
)
R, M = MatrixSymbol("R", p, p), MatrixSymbol("M", p, p)
Omega, W = MatrixSymbol("Omega", n, n), MatrixSymbol("W", n, n)
Psi = MatrixSymbol("Psi", m1, m1)
N, That = MatrixSymbol("N", n, nz), MatrixSymbol("That", nz, n)
Gamma, Gamma_W = MatrixSymbol("Gamma", n, m1), MatrixSymbol("Gamma_W", n, m1)
K, Kmv = MatrixSymbol("K", n, p), MatrixSymbol("K_mv", n, p)
k, Zeta = MatrixSymbol("k", nz, p), MatrixSymbol("Z", nz, m1)
one = Identity(n)

# R is eliminated by M = C Omega C' + R; C1 is written S_1 C, its rows of the identity.
BASE = Algebra(
    [R, M, Omega, W, Psi],
    [
        (R, M - C * Omega * C.T),
        (C1, Select * C),
        (Kmv, Omega * C.T * M.I),
        (Select * C * Gamma, Identity(m1)),
        (Select * C * Gamma_W, Identity(m1)),
        (Select * C * N, ZeroMatrix(m1, nz)),
        (That * Gamma, ZeroMatrix(nz, m1)),
        (That * N, Identity(nz)),
        (N * That, one - Gamma * C1),
        (Gamma_W.T * W * N, ZeroMatrix(m1, nz)),
    ],
)
Z = Select - Select * C * Kmv  # y1 - C1 x^_mv = Z (innovation)
K_star = Kmv + Gamma * Z
Sigma_mv = (one - Kmv * C) * Omega


def formulas():
    return {
        "K_mv": Omega * C.T * M.I,
        "Psi": Select * R * M.I * R * Select.T,
        "Gamma": W.I * C1.T * sp.MatMul(C1, W.I, C1.T).I,
        "Gamma, unweighted": C1.T * sp.MatMul(C1, C1.T).I,
        "K": K_star,
        "Sigma": Sigma_mv + Gamma * Psi * Gamma.T,
        "weight of (19)": C1.T * C1 + That.T * That,
        "q": BlockMatrix([[C1], [N.T]]),
    }


def every_estimate():
    """Every gain that matches the accurate outputs, and what it costs."""
    matching = BASE.with_relations(
        (Select * C * K, Select),
        (
            Select * M * Select.T,
            Psi
            + 2 * Select * C * Omega * C.T * Select.T
            - Select * C * Kmv * C * Omega * C.T * Select.T,
        ),
    )
    away = K - Kmv
    part = away * M * Z.T * Psi.I
    rest = away - part * Z
    L = MatrixSymbol("L_M", p, p)
    sides = {
        "Sigma(K) = Sigma_mv + (K - K_mv) M (K - K_mv)', any gain K": (
            joseph(K, C, Omega, R),
            Sigma_mv + away * M * away.T,
        ),
        "Psi = cov(y1 - C1 x_mv) = S1 R M^-1 R S1'": (
            Z * M * Z.T,
            Select * R * M.I * R * Select.T,
        ),
        "C1 K = S1: Gamma = (K - K_mv) M Z' Psi^-1 has C1 Gamma = I": (
            C1 * part,
            Identity(m1),
        ),
        "C1 K = S1: Sigma(K) = Sigma_mv + Gamma Psi Gamma' + a covariance": (
            joseph(K, C, Omega, R),
            Sigma_mv + part * Psi * part.T + rest * M * rest.T,
        ),
        "C1 K = S1: x is x_mv + Gamma (y1 - C1 x_mv) + something uncorrelated "
        "with y1 - C1 x_mv": (rest * M * Z.T, ZeroMatrix(n, m1)),
        "K = K_mv + Gamma Z matches: C1 K = S1": (C1 * K_star, Select),
        "Sigma(K_mv + Gamma Z) = Sigma_mv + Gamma Psi Gamma'": (
            joseph(K_star, C, Omega, R),
            Sigma_mv + Gamma * (Z * M * Z.T) * Gamma.T,
        ),
    }
    facts = {
        "K M - Omega C' = Gamma S1 R": (K_star * M - Omega * C.T, Gamma * Select * R),
        "y - C x_mv = R M^-1 (y - C x_minus)": (Identity(p) - C * Kmv, R * M.I),
    }
    squares = Algebra([M], [(M, L * L.T)])
    D = MatrixSymbol("D", n, p)
    positive = {
        "tr D M D' = |D L|^2 for M = L L'": (
            Trace(D * M * D.T),
            Trace((D * L) * (D * L).T),
        )
    }
    return claims(matching, sides) | claims(BASE, facts) | claims(squares, positive)


def best_choice():
    """The weighted trace as a function of Gamma: completed square and minimiser."""
    moved = Gamma_W + N * Zeta
    G = MatrixSymbol("G", m1, m1)
    explicit = Algebra([W, G], [(C1 * W.I * C1.T, G), (C1 * N, ZeroMatrix(m1, nz))])
    formula = W.I * C1.T * G.I
    Lw, Lp = MatrixSymbol("L_W", n, n), MatrixSymbol("L_Psi", m1, m1)
    squares = BASE.with_relations((W, Lw * Lw.T), (Psi, Lp * Lp.T))
    spread = Lw.T * N * Zeta * Lp
    return (
        claims(
            BASE,
            {
                "every Gamma with C1 Gamma = I is Gamma_W + N Z": (
                    Gamma,
                    Gamma_W - N * That * Gamma_W,
                ),
                "completed square: tr(W Gamma Psi Gamma') in Gamma = Gamma_W + N Z": (
                    Trace(W * moved * Psi * moved.T),
                    Trace(W * Gamma_W * Psi * Gamma_W.T)
                    + Trace(N.T * W * N * Zeta * Psi * Zeta.T),
                ),
            },
        )
        | claims(
            squares,
            {
                "tr(N'W N Z Psi Z') is a sum of squares": (
                    Trace(N.T * W * N * Zeta * Psi * Zeta.T),
                    Trace(spread * spread.T),
                )
            },
        )
        | claims(
            explicit,
            {
                "C1 Gamma = I for Gamma = W^-1 C1'(C1 W^-1 C1')^-1": (
                    C1 * formula,
                    Identity(m1),
                ),
                "Gamma' W N = 0 for the same Gamma": (
                    formula.T * W * N,
                    ZeroMatrix(m1, nz),
                ),
            },
        )
    )


def paper_choice():
    """(33) in coordinates [C1 x; That x], and the weight it amounts to."""
    weight = C1.T * C1 + That.T * That
    gain = N * k + Gamma * Select
    solved = BASE.with_relations((k, That * Kmv))
    cost = Trace(weight * joseph(gain, C, Omega, R))
    return claims(
        BASE,
        {
            "(19) is the weight W = M'M: Gamma' W N = 0": (
                Gamma.T * weight * N,
                ZeroMatrix(m1, nz),
            ),
            "(32) gradient in coordinates [C1 x; That x]: 2 (k M - That Omega C')": (
                BASE.gradient(cost, k),
                2 * (k * M - That * Omega * C.T),
            ),
            "K = Gamma S1 + N k has C1 K = S1": (C1 * gain, Select),
        },
    ) | claims(
        solved,
        {
            "(33) k = That K_mv in the user's coordinates: K = K_mv + Gamma Z": (
                gain,
                K_star,
            )
        },
    )


def no_choice():
    """When the coordinates do not matter: m1 = 0, or perfect accurate outputs."""
    perfect = BASE.with_relations((Select * C * Omega * C.T, Select * M))
    R11, R12, R22 = (
        MatrixSymbol("R_11", m1, m1),
        MatrixSymbol("R_12", m1, p - m1),
        MatrixSymbol("R_22", p - m1, p - m1),
    )
    a, b = MatrixSymbol("a", m1, 1), MatrixSymbol("b", p - m1, 1)
    t = sp.Symbol("t", real=True)
    ends = Algebra([R11, R22], [(R11, ZeroMatrix(m1, m1))])
    noise, pair = BlockMatrix([[R11, R12], [R12.T, R22]]), BlockMatrix([[t * a], [b]])
    return (
        claims(
            Algebra(),
            {
                "m1 = 0: K = K_mv whatever the coordinates": (
                    (Gamma * Z).subs(m1, 0),
                    ZeroMatrix(n, p),
                )
            },
        )
        | claims(
            perfect,
            {
                "R11 = 0, R12 = 0 (S1 R = 0): K = K_mv whatever Gamma": (K_star, Kmv),
                "R11 = 0, R12 = 0: Psi = 0": (Z * M * Z.T, ZeroMatrix(m1, m1)),
            },
        )
        | claims(
            ends,
            {
                "R11 = 0 forces R12 = 0: [t a; b]'R [t a; b] = 2 t a'R12 b + b'R22 b "
                ">= 0 for all t": (
                    Trace(pair.T * noise * pair),
                    2 * t * Trace(a.T * R12 * b) + Trace(b.T * R22 * b),
                )
            },
        )
    )


def mixed_outputs():
    """(33) with a second group of outputs that depends on q1 as well."""
    p2 = p - m1
    H21, H22 = MatrixSymbol("H_21", p2, m1), MatrixSymbol("H_22", p2, nz)
    K1, K2 = MatrixSymbol("K_1", nz, m1), MatrixSymbol("K_2", nz, p2)
    blocks = {}
    for name, (a, b) in {"O": (m1, nz), "R": (m1, p2)}.items():
        first, last = MatrixSymbol(f"{name}_11", a, a), MatrixSymbol(f"{name}_22", b, b)
        cross = MatrixSymbol(f"{name}_21", b, a)
        blocks[name] = BlockMatrix([[first, cross.T], [cross, last]])
    O, noise = blocks["O"], blocks["R"]
    algebra = Algebra([x[i, i] for x in (O.blocks, noise.blocks) for i in (0, 1)])
    H = BlockMatrix([[Identity(m1), ZeroMatrix(m1, nz)], [H21, H22]])
    P = BlockMatrix([[ZeroMatrix(m1, nz)], [Identity(nz)]])
    V = BlockMatrix([[Identity(m1), ZeroMatrix(m1, p2)], [K1, K2]])
    T = BlockMatrix([[-K1 - K2 * H21, Identity(nz) - K2 * H22]])
    trace = Trace(P * T * O * T.T * P.T + V * noise * V.T)
    innovation = algebra.normal(H * O * H.T + noise)
    lower = algebra.normal(O * H.T)
    steps = {"H21 != 0: (13) P T + V H = I": (P * T + V * H, Identity(n))}
    for j, gain in enumerate((K1, K2)):
        found = (
            algebra.normal(K1) @ innovation[0, j]
            + algebra.normal(K2) @ innovation[1, j]
        )
        steps[
            f"H21 != 0: (32) for {gain.name} is still ([K1 K2] M - [0 I] Omega H') = 0"
        ] = (
            sp.S.Half * algebra.gradient(trace, gain),
            found - lower[1, j],
        )
    return claims(algebra, steps)


@cache
def derive():
    return Derivation(
        given=(C, C1, Select, R, Omega, W, N, That),
        formulas=formulas(),
        steps=every_estimate()
        | best_choice()
        | paper_choice()
        | no_choice()
        | mixed_outputs(),
        source="our own",
    )
