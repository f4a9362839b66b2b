"""Theorem 1, the change of coordinates, and the least norm: for every size.

The letters are those of the library: the paper's P, G, H are G, P, V here.  U^* is
the conjugate transpose of U; only U U^* = U^* U = I is used of it, so the plant may
be complex.  What holds at concrete sizes only, as the triangle of (13), says which.

Source: Van Dooren (1984), (1)-(24).
"""

from functools import cache

import sympy as sp

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
from .rows import Pattern, row_symbols

n, m, r, d = sp.symbols("n m r d", integer=True, positive=True)  # d = n - r
A, B, C = (MatrixSymbol(k, *s) for k, s in zip("ABC", ((n, n), (n, m), (r, n))))
F, D, T = (MatrixSymbol(k, d, s) for k, s in zip("FDT", (d, r, n)))
P, V = MatrixSymbol("P", n, d), MatrixSymbol("V", n, r)
x, z, u = (MatrixSymbol(k, s, 1) for k, s in zip("xzu", (n, d, m)))
U, Us = MatrixSymbol("U", n, n), MatrixSymbol("U^*", n, n)
Tu = MatrixSymbol("T_U", d, n)

FOUR = (T * A, F * T + D * C)  # (4a)
FIVE = (V * C, Identity(n) - P * T)  # (5b)
UNITARY = ((U * Us, Identity(n)), (Us * U, Identity(n)))


def theorem_steps():
    """(1)-(6): what is estimated, and the error of it."""
    theorem = Algebra([], [FOUR, FIVE])
    state, tracked, steps = x, z, {}
    for k in range(1, 5):
        now = MatrixSymbol(f"u_{k - 1}", m, 1)
        tracked = F * tracked + D * (C * state) + (T * B) * now
        state = A * state + B * now
        steps[f"(6) discrete time: after {k} steps x^ - x = P F^{k} (z - T x)"] = (
            P * tracked + V * C * state - state,
            P * F**k * (z - T * x),
        )
    # continuous time: Phi = e^(F t) is known by its derivative F Phi
    Phi, start = MatrixSymbol("Phi", d, d), MatrixSymbol("eps_0", d, 1)
    flow = theorem.with_relations((z, T * x + Phi * start))
    return claims(
        theorem,
        {
            "(1),(2),(4a),(5a) z - T x moves by F alone: F z + D y + T B u - T (..)": (
                F * z + D * (C * x) + (T * B) * u - T * (A * x + B * u),
                F * (z - T * x),
            ),
            "(3),(5b) x^ = P z + V y: x^ - x = P (z - T x)": (
                P * z + V * (C * x) - x,
                P * (z - T * x),
            ),
            **steps,
        },
    ) | claims(
        flow,
        {
            "(6) continuous time: eps = e^(F t) eps_0 has the rate F e^(F t) eps_0": (
                F * z + D * (C * x) + (T * B) * u - T * (A * x + B * u),
                F * Phi * start,
            ),
            "(6) continuous time: x^ - x = P e^(F t) eps_0": (
                P * z + V * (C * x) - x,
                P * Phi * start,
            ),
        },
    )


def coordinate_steps():
    """(7), (9)-(12), (24): U and V turn the problem, and turn it back."""
    Vu, Vs = MatrixSymbol("V_F", d, d), MatrixSymbol("V_F^*", d, d)
    X1, X2 = MatrixSymbol("X_1", n, d), MatrixSymbol("X_2", n, r)
    Au, Cu, one = Us * A * U, C * U, Identity(r)
    there = Algebra([], [*UNITARY, FOUR])
    back = Algebra([], [*UNITARY, (Tu * Us * A, F * Tu * Us + D * C)])
    inverse = Algebra([], [*UNITARY, (X1 * Tu, Identity(n) - X2 * C * U)])
    turned = Algebra(
        [], [*UNITARY, (Tu * Us * A, F * Tu * Us + D * C), (Vu * Vs, Identity(d))]
    )
    left = (Vs * Tu) * Au - (Vs * F * Vu) * (Vs * Tu)
    return (
        claims(
            there,
            {
                "(7),(9a) T U (U^* A U) - F T U = D C U": (
                    (T * U) * Au - F * (T * U),
                    D * Cu,
                ),
                "(24) T_U U^* B with T_U = T U is T B": ((T * U) * Us * B, T * B),
            },
        )
        | claims(
            back,
            {"(10a) T_U A_U - F T_U = D C_U": (Tu * Au - F * Tu, D * Cu)},
        )
        | claims(
            Algebra([], UNITARY),
            {
                "(9b),(10b) [T; C] U = [T_U; C_U], so both are invertible or none": (
                    BlockMatrix([[Tu * Us], [C]]) * U,
                    BlockMatrix([[Tu], [Cu]]),
                )
            },
        )
        | claims(
            inverse,
            {
                "(24) [P V] = U [T_U; C_U]^-1 is the inverse of [T; C]": (
                    U * X1 * (Tu * Us) + U * X2 * C,
                    Identity(n),
                )
            },
        )
        | claims(
            turned,
            {"(11a),(12) V^* T_U A_U - F_V V^* T_U = V^* D C_U": (left, (Vs * D) * Cu)},
        )
        | claims(
            turned,
            {
                "(11b),(12) diag(V, I) [V^* T_U; C_U] = [T_U; C_U]": (
                    BlockMatrix([[Vu, ZeroMatrix(d, r)], [ZeroMatrix(r, d), one]])
                    * BlockMatrix([[Vs * Tu], [Cu]]),
                    BlockMatrix([[Tu], [Cu]]),
                )
            },
        )
    )


def norm_steps():
    """(20), (21): the solution of least norm, from M = Q R with Q^*Q = I."""
    a, h = MatrixSymbol("af", 1, n), MatrixSymbol("h", 1, n + r - 1)
    ah, hh = MatrixSymbol("af^*", n, 1), MatrixSymbol("h^*", n + r - 1, 1)
    Q, Qs = MatrixSymbol("Q", n + r - 1, n), MatrixSymbol("Q^*", n, n + r - 1)
    R, Ri, Rh = (MatrixSymbol(k, n, n) for k in ("R", "R^-1", "R^-*"))
    factors = Algebra([], [(Qs * Q, Identity(n)), (Ri * R, Identity(n))])
    unseen = factors.with_relations((h * Q, 0 * a), (Qs * hh, 0 * ah))
    best, its = -a * Ri * Qs, -Q * Rh * ah
    return claims(
        factors,
        {
            "(20),(21) x' = -af' R^-1 Q^* solves x'M = -af'": (
                best * (Q * R),
                -a,
            )
        },
    ) | claims(
        unseen,
        {
            "(21) of all solutions x' + h', h'M = 0, it has the least norm": (
                (best + h) * (its + hh),
                best * its + h * hh,
            )
        },
    )


def triangle_steps(stairs):
    """(10b), (13): [T_U; C_U] is triangular, and its determinant is that of C_k."""
    p, name = Pattern(stairs, printed=True), f"stairs {stairs}"
    rows = []
    for i in range(p.n - p.r):
        entries = row_symbols(p, i)[1]
        rows.append(sp.Matrix.hstack(sp.zeros(1, i), sp.eye(1), entries))
    both = sp.Matrix.vstack(*rows, p.C)
    corner = p.C[:, p.n - p.r :]
    return {
        f"(10b),(13) [T_U; C_U] is upper triangular, {name}": Claim(
            both, both.upper_triangular()
        ),
        f"(10b),(13) its determinant is the product of C_k's pivots, {name}": Claim(
            both.det(), sp.prod(corner.diagonal())
        ),
    }


@cache
def derive():
    steps = theorem_steps() | coordinate_steps() | norm_steps()
    for stairs in ((1, 2), (2, 2), (1, 1, 2)):
        steps |= triangle_steps(stairs)
    return Derivation(
        given=(A, B, C),
        formulas={
            "(2) z_+": F * z + D * C * x + T * B * u,
            "(3) x^": P * z + V * C * x,
            "(4) residual": T * A - F * T - D * C,
            "(5) G": T * B,
            "(7) A_U": Us * A * U,
            "(7) C_U": C * U,
            "(12) F_V": MatrixSymbol("V_F^*", d, d) * F * MatrixSymbol("V_F", d, d),
        },
        steps=steps,
        source="Van Dooren (1984), sections 1 and 2",
    )
