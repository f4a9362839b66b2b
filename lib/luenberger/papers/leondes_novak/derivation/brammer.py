"""Brammer's filter for outputs without noise, and that Fig. 2 is Fig. 1.

Brammer keeps the projected estimate T^ x of the Kalman filter and reads the rest off
the perfect outputs.  With z = z^ - L y, L = T^ K^, his filter is the observer of
Leondes and Novak, so (48) and Fig. 1 are one system drawn twice.

Source: Leondes and Novak (1974), section IV.C, (45)-(53); Brammer (1968).
"""

from functools import cache

import sympy as sp

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)
from . import canonical_gain as gain
from .claims import joseph

n, p, m1 = gain.n, gain.p, gain.m1
nz, p2 = n - m1, p - m1
A, Q, Pred = (MatrixSymbol(k, n, n) for k in ("A", "Q", "Sigma_p"))
C, C1, C2 = (MatrixSymbol(k, d, n) for k, d in (("C", p), ("C_1", m1), ("C_2", p2)))
Select = MatrixSymbol("S_1", m1, p)  # y1 = S_1 y
R, M = MatrixSymbol("R", p, p), MatrixSymbol("M", p, p)
That, Phat = MatrixSymbol("That", nz, n), MatrixSymbol("Phat", n, nz)
Vhat1 = MatrixSymbol("Vhat_1", n, m1)
K, Kn = MatrixSymbol("Khat", n, p), MatrixSymbol("Khat_+", n, p)
L, S = MatrixSymbol("Lhat", nz, p), MatrixSymbol("S", nz, nz)
zhat, x, y, yn = (
    MatrixSymbol(k, d, 1) for k, d in (("zhat", nz), ("x", n), ("y", p), ("y_+", p))
)

# (47) two-sided; C1 = S1 C; noise-free outputs give C1 K^ = S1, see `limiting_cases`
BASE = Algebra(
    [Q, R, M, Pred, S],
    [
        (Select * C, C1),
        (C1 * Phat, ZeroMatrix(m1, nz)),
        (C1 * Vhat1, Identity(m1)),
        (That * Phat, Identity(nz)),
        (That * Vhat1, ZeroMatrix(nz, m1)),
        (Phat * That, Identity(n) - Vhat1 * C1),
    ],
)


def formulas():
    xhat = MatrixSymbol("xhat", n, 1)
    v2 = MatrixSymbol("v_2", p2, 1)
    first, last = Identity(m1), Identity(nz)
    return {
        "(45) y": BlockMatrix([[C1], [C2]]) * x
        + BlockMatrix([[ZeroMatrix(m1, 1)], [v2]]),
        "(46) x_hat": Phat * zhat + Vhat1 * (Select * y),
        "(47) [P_hat V_hat_1]": sp.Inverse(BlockMatrix([[That], [C1]])),
        "(48) z_hat_+": That * (A * xhat + Kn * (yn - C * A * xhat)),
        "(49) K_hat": Pred * C.T * sp.MatAdd(C * Pred * C.T, R).I,
        "(50) Sigma_p": A * Phat * S * Phat.T * A.T + Q,
        "(51) S_+": That * (Identity(n) - K * C) * Pred * That.T,
        "(52) C_1": BlockMatrix([[first, ZeroMatrix(m1, nz)]]),
        "(52) T_hat": BlockMatrix([[ZeroMatrix(nz, m1), last]]),
        "(53) P_hat": BlockMatrix([[ZeroMatrix(m1, nz)], [last]]),
        "(53) V_hat": BlockMatrix(
            [[first, ZeroMatrix(m1, p2)], [ZeroMatrix(nz, m1), ZeroMatrix(nz, p2)]]
        ),
    }


def filter_steps():
    """(45)-(48): estimate, error, and the change of variable to Fig. 1."""
    xhat = Phat * zhat + Vhat1 * (Select * y)
    updated = That * (A * xhat + Kn * (yn - C * A * xhat))
    before = A * xhat
    matched = BASE.with_relations((C1 * Kn, Select))
    perfect = BASE.with_relations((Select * y, C1 * x))
    z = zhat - That * K * y
    Tn = That - That * Kn * C
    V = Vhat1 * Select + Phat * That * K
    return (
        claims(
            BASE,
            {
                "(46) T^ x_hat = z^": (That * xhat, zhat),
                "(46) C1 x_hat = y1": (C1 * xhat, Select * y),
                "(48) with z = z^ - L y, L = T^ K^: z_+ = T_+ A (P z + V y), Fig. 1": (
                    updated - That * Kn * yn,
                    Tn * A * (Phat * z + V * y),
                ),
                "(46) with z = z^ - L y: x_hat = P z + V y": (xhat, Phat * z + V * y),
                "(13) P T + V C = I for T = T^ - L C, V = V^ + P^ L": (
                    Phat * (That - That * K * C) + V * C,
                    Identity(n),
                ),
            },
        )
        | claims(
            perfect,
            {
                "(46) v1 = 0: x_hat - x = P^ (z^ - T^ x)": (
                    xhat - x,
                    Phat * (zhat - That * x),
                )
            },
        )
        | claims(
            matched,
            {
                "(46),(48) v1 = 0: x_hat_+ is the Kalman filter's": (
                    Phat * updated + Vhat1 * (Select * yn),
                    before + Kn * (yn - C * before),
                )
            },
        )
    )


def covariance_steps():
    """(49)-(51), with M = C Sigma_p C' + R solved for R."""
    gain_known = BASE.with_relations((R, M - C * Pred * C.T), (K, Pred * C.T * M.I))
    truth = Algebra([Q, S])
    both = BlockMatrix([[S, ZeroMatrix(nz, n)], [ZeroMatrix(n, nz), Q]])
    map_ = BlockMatrix([[A * Phat, Identity(n)]])
    perfect = Algebra(
        [R, M, Pred],
        [
            (Select * C, C1),
            (R, M - C * Pred * C.T),
            (C1 * Pred * C.T, Select * M),  # S1 R = 0
        ],
    )
    return (
        claims(
            gain_known,
            {
                "(49) K^ (C Sigma_p C' + R) = Sigma_p C'": (
                    K * (C * Pred * C.T + R),
                    Pred * C.T,
                ),
                "(51) S_+ = cov(T^ (x_hat_+ - x_+))": (
                    That * (Identity(n) - K * C) * Pred * That.T,
                    That * joseph(K, C, Pred, R) * That.T,
                ),
            },
        )
        | claims(
            truth,
            {
                "(50) Sigma_p = cov(A P^ (z^ - T^ x) - w)": (
                    map_ * both * map_.T,
                    A * Phat * S * Phat.T * A.T + Q,
                )
            },
        )
        | claims(
            perfect,
            {
                "(49) v1 = 0: C1 K^ = [I 0]": (C1 * Pred * C.T * M.I, Select),
            },
        )
    )


def canonical_steps():
    """(52), (53): in canonical coordinates (24) and (25) come back."""
    f = formulas()
    T, P, V = (f[k] for k in ("(52) T_hat", "(53) P_hat", "(53) V_hat"))
    stack = BlockMatrix(
        [[ZeroMatrix(nz, m1), Identity(nz)], [Identity(m1), ZeroMatrix(m1, nz)]]
    )
    inverse = BlockMatrix(
        [[ZeroMatrix(m1, nz), Identity(m1)], [Identity(nz), ZeroMatrix(nz, m1)]]
    )
    zn, Tk, Pk, Kk = (s.subs(m1, 0) for s in (zhat, That, Phat, Kn))
    whole = Algebra([], [(Tk, Identity(n)), (Pk, Identity(n))])
    return claims(
        gain.ALGEBRA,
        {
            "(47),(52),(53) [T^; C1]^-1 = [P^ V^_1]": (stack * inverse, Identity(n)),
            "(52),(25) T^ - L C = T, L = [K_1 K_2]": (T - gain.K * gain.H, gain.T),
            "(53),(24) V^ + P^ L = V": (V + P * gain.K, gain.V),
            "(53),(24) P^ = P": (P, gain.P),
        },
    ) | claims(
        whole,
        {
            "(48) T^ = P^ = I, V^_1 = 0: Kalman's filter": (
                Tk * (A * (Pk * zn) + Kk * (yn - C * A * (Pk * zn))),
                A * zn + Kk * (yn - C * A * zn),
            )
        },
    )


@cache
def derive():
    return Derivation(
        given=(A, C, C1, Q, R, That, Phat, Vhat1),
        formulas=formulas(),
        steps=filter_steps() | covariance_steps() | canonical_steps(),
        source="Leondes and Novak (1974), (45)-(53); Brammer (1968)",
    )
