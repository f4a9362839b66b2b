"""The canonical coordinates of the paper, and the way back.

Rows L that complete the measurement matrix to an invertible Mbar = [C1; C2; L] give
the state q = Mbar x, in which the accurate outputs are the first states and the
other outputs the next.  The inverse is [X1 X2 X3]; that it exists is what "C has
full rank" means, and nothing else about C is used.  Everything designed in q returns
by x = Mbar^-1 q with the certificate unchanged.

Source: Leondes and Novak (1974), section III, (16)-(23).
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

n, p, m1, m, r = sp.symbols("n p m_1 m r", integer=True, nonnegative=True)
sizes = (m1, p - m1, n - p)

A, Sigma = MatrixSymbol("A", n, n), MatrixSymbol("Sigma", n, n)
B = MatrixSymbol("B", n, m)
rows = [MatrixSymbol(k, d, n) for k, d in zip(("C_1", "C_2", "L"), sizes)]
cols = [MatrixSymbol(f"X_{k + 1}", n, d) for k, d in enumerate(sizes)]
x, w, u = (MatrixSymbol(k, d, 1) for k, d in (("x", n), ("w", n), ("u", m)))
v1, v2 = MatrixSymbol("v_1", m1, 1), MatrixSymbol("v_2", p - m1, 1)

Mbar = BlockMatrix([[row] for row in rows])
Mbar_inverse = BlockMatrix([cols])
C, v = BlockMatrix([[rows[0]], [rows[1]]]), BlockMatrix([[v1], [v2]])

INVERSE = Algebra(
    [Sigma],
    [
        *(
            (row * col, Identity(d) if i == j else ZeroMatrix(d, col.shape[1]))
            for i, (row, d) in enumerate(zip(rows, sizes))
            for j, col in enumerate(cols)
        ),
        (cols[2] * rows[2], Identity(n) - cols[0] * rows[0] - cols[1] * rows[1]),
    ],
)


def formulas():
    canonical = BlockMatrix([[row * A * col for col in cols] for row in rows])
    H2 = BlockMatrix([[Identity(p - m1), ZeroMatrix(p - m1, n - p)]])
    q1, q2 = MatrixSymbol("q_1", m1, 1), MatrixSymbol("q_2", n - m1, 1)
    H_2 = MatrixSymbol("H_2", p - m1, n - m1)
    return {
        "(16) y": C * x + v,
        "(19) M": Mbar,
        "(19) M^-1": Mbar_inverse,
        "(17),(20) A in q": canonical,
        "(17),(20) w in q": BlockMatrix([[row * w] for row in rows]),
        "(17),(20) B in q": BlockMatrix([[row * B] for row in rows]),
        "(18) C in q": C * Mbar_inverse,
        "(21) y_1": q1 + v1,
        "(22) y_2": H_2 * q2 + v2,
        "(23) H_2": H2,
    }


def steps():
    first, second, third = sizes
    H = BlockMatrix(
        [
            [Identity(first), ZeroMatrix(first, second), ZeroMatrix(first, third)],
            [ZeroMatrix(second, first), Identity(second), ZeroMatrix(second, third)],
        ]
    )
    q = BlockMatrix([[row * x] for row in rows])
    canonical = Mbar * A * Mbar_inverse
    lower = BlockMatrix([[rows[1] * x], [rows[2] * x]])
    H2 = BlockMatrix([[Identity(second), ZeroMatrix(second, third)]])
    y1_of = BlockMatrix([[Identity(first), ZeroMatrix(first, second)]])
    F = MatrixSymbol("F", r, r)
    T, Tn = (
        BlockMatrix([[MatrixSymbol(f"{k}_{i}", r, d) for i, d in enumerate(sizes)]])
        for k in ("T", "T_+")
    )
    D = BlockMatrix([[MatrixSymbol("D_1", r, first), MatrixSymbol("D_2", r, second)]])
    P = BlockMatrix([[MatrixSymbol(f"P_{i}", d, r)] for i, d in enumerate(sizes)])
    V = BlockMatrix(
        [
            [MatrixSymbol(f"V_{i}{k}", d, e) for k, e in enumerate(sizes[:2])]
            for i, d in enumerate(sizes)
        ]
    )
    in_q = Tn * canonical - F * T - D * H
    in_x = (Tn * Mbar) * A - F * (T * Mbar) - D * C
    return claims(
        INVERSE,
        {
            "(19) M M^-1 = I": (Mbar * Mbar_inverse, Identity(n)),
            "(19) M^-1 M = I": (Mbar_inverse * Mbar, Identity(n)),
            "(18) C M^-1 = [I 0 0; 0 I 0]": (C * Mbar_inverse, H),
            "(17),(20) q_+ = M A M^-1 q + M B u + M w": (
                canonical * q + Mbar * B * u + Mbar * w,
                Mbar * (A * x + B * u + w),
            ),
            "(21) y_1 = q_1 + v_1": (y1_of * (H * q + v), rows[0] * x + v1),
            "(22),(23) y_2 = H_2 q_2 + v_2": (H2 * lower + v2, rows[1] * x + v2),
            "(16) y = [q_1 + v_1; H_2 q_2 + v_2]": (H * q + v, C * x + v),
            "back: x = M^-1 q": (Mbar_inverse * q, x),
            "back: certificate (9) in x is that in q times M": (in_x, in_q * Mbar),
            "back: P, V in x are M^-1 P, M^-1 V: (13) is kept": (
                (Mbar_inverse * P) * (T * Mbar) + (Mbar_inverse * V) * C - Identity(n),
                Mbar_inverse * (P * T + V * H - Identity(n)) * Mbar,
            ),
            "back: tr cov(x) = tr(M^-1 cov(q) M^-1'), weight (M^-1)' M^-1 on q": (
                Trace(Mbar_inverse * (Mbar * Sigma * Mbar.T) * Mbar_inverse.T),
                Trace(Sigma),
            ),
        },
    )


@cache
def derive():
    return Derivation(
        given=(A, B, *rows, *cols),
        formulas=formulas(),
        steps=steps(),
        source="Leondes and Novak (1974), (16)-(23)",
    )
