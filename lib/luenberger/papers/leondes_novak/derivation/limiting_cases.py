"""What the reduced-order filter becomes at the ends of its range.

All outputs accurate, m1 = p: the minimal-order observer.  None, m1 = 0: the Kalman
filter.  Both are read off the formulas of `canonical_gain` by giving the size m1 its
value.  Accurate outputs without noise: again the Kalman filter, which `brammer`
compares with the literature's form.

Source: Leondes and Novak (1974), section IV, (37)-(53).
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
from . import brammer
from . import canonical_gain as gain

n, p, m1 = gain.n, gain.p, gain.m1
A, Q = MatrixSymbol("A", n, n), MatrixSymbol("Q", n, n)
C, R = MatrixSymbol("C", p, n), MatrixSymbol("R", p, p)
P, V, Vn = (MatrixSymbol(k, n, d) for k, d in (("P", n - m1), ("V", p), ("V_+", p)))
T, Tn, Pn = (
    MatrixSymbol("T", n - m1, n),
    MatrixSymbol("T_+", n - m1, n),
    MatrixSymbol("P_+", n, n - m1),
)
z, y, yn = (MatrixSymbol(k, d, 1) for k, d in (("z", n - m1), ("y", p), ("y_+", p)))
K, Kn = MatrixSymbol("K", n, p), MatrixSymbol("K_+", n, p)
one = Identity(n)


def at(expr, size):
    """An expression of `canonical_gain` with m1 set to `size`."""
    return expr.subs(m1, size)


def known(symbols, size):
    return [at(symbol, size) for symbol in symbols]


def minimal_order():
    """m1 = p: (37), (38)."""
    K1, O11, O21, R11 = known((gain.K1, gain.O11, gain.O21, gain.R11), p)
    algebra = Algebra(known(gain.ALGEBRA.symmetric, p))
    first, _ = gain.gradients_32()
    formulas = {
        "(37) K_+": sp.MatMul(O21, sp.MatAdd(O11, R11).I),
        "(38) T": BlockMatrix([[-K1, Identity(n - p)]]),
        "(38) V": BlockMatrix([[Identity(p)], [K1]]),
        "(38) P": BlockMatrix([[ZeroMatrix(p, n - p)], [Identity(n - p)]]),
    }
    steps = {
        "(37) m1 = p: (32) becomes K (Omega_11 + R) = Omega_21": (
            at(first, p),
            K1 * (O11 + R11) - O21,
        ),
        "(37) m1 = p: M = Omega_11 + R": (at(gain.M, p), O11 + R11),
        "(37) m1 = p: J in K alone": (
            at(gain.trace_30(), p),
            Trace(R11)
            + Trace(K1 * (O11 + R11) * K1.T)
            - 2 * Trace(O21 * K1.T)
            + Trace(at(gain.O22, p)),
        ),
        "(38) m1 = p: T": (at(gain.T, p), formulas["(38) T"]),
        "(38) m1 = p: V": (at(gain.V, p), formulas["(38) V"]),
        "(38) m1 = p: P": (at(gain.P, p), formulas["(38) P"]),
    }
    return formulas, claims(algebra, steps)


def kalman():
    """m1 = 0: (39)-(44)."""
    K2, H2, O22, R22 = known((gain.K2, gain.H2, gain.O22, gain.R22), 0)
    algebra = Algebra(known(gain.ALGEBRA.symmetric, 0))
    _, second = gain.gradients_32()
    x_hat = MatrixSymbol("xhat", n, 1)
    zn = (one - Kn * C) * A * (at(z, 0) + K * y)
    formulas = {
        "(39) K_1": at(gain.K1, 0),
        "(39) K_2": K,
        "(40) V": K,
        "(40) P": one,
        "(40) T": one - K * C,
        "(41) x_hat_+": MatrixSymbol("z_+", n, 1) + Kn * yn,
        "(42) z_+": zn,
        "(43) x_hat_+": A * x_hat + Kn * (yn - C * A * x_hat),
    }
    limits = {
        "(39) m1 = 0: K_1 has no columns, K_2 is n by p": (
            at(gain.K, 0),
            K2,
        ),
        "(40) m1 = 0: V = K": (at(gain.V, 0), K2),
        "(40) m1 = 0: P = I": (at(gain.P, 0), one),
        "(40) m1 = 0: T = I - K H": (at(gain.T, 0), one - K2 * H2),
        "(33) m1 = 0: K (H Omega H' + R) = Omega H', the Kalman gain": (
            at(second, 0),
            K2 * (H2 * O22 * H2.T + R22) - O22 * H2.T,
        ),
    }
    filter_ = Algebra([], [(x_hat, at(z, 0) + K * y)])
    return formulas, claims(algebra, limits) | claims(
        filter_,
        {
            "(41)-(43) the observer is the Kalman filter": (
                zn + Kn * yn,
                formulas["(43) x_hat_+"],
            )
        },
    )


def every_size():
    """(41)-(43) at every m1, and (44): the observer in innovation form."""
    x_hat = P * z + V * y
    F, D = Tn * A * P, Tn * A * V
    X = MatrixSymbol("X", n - m1, n - m1)
    Sigma = P * X * P.T + V * R * V.T
    innovation = Algebra([R, Q, X], [(Pn * Tn, one - Vn * C)])
    formulas = {"(44) Omega": A * MatrixSymbol("Sigma", n, n) * A.T + Q}
    return formulas, claims(
        innovation,
        {
            "(41)-(43) every m1: x_hat_+ = A x_hat + V_+ (y_+ - C A x_hat)": (
                Pn * (F * z + D * y) + Vn * yn,
                A * x_hat + Vn * (yn - C * A * x_hat),
            ),
            "(44) Omega of (28) = A cov(e) A' + Q": (
                A * P * X * P.T * A.T + A * V * R * V.T * A.T + Q,
                A * Sigma * A.T + Q,
            ),
        },
    )


def perfect():
    """v1 = 0: the gain of Kalman has [I 0] on top, so the two filters agree."""
    a, b = m1, p - m1
    top = BlockMatrix([[Identity(a), ZeroMatrix(a, b)]])
    upper = BlockMatrix([[gain.O11, gain.O21.T * gain.H2.T]])
    noise = BlockMatrix([[gain.R11, gain.R21.T]])
    zero = gain.ALGEBRA.with_relations(
        (gain.R11, ZeroMatrix(a, a)), (gain.R21, ZeroMatrix(b, a))
    )
    M, H = gain.M, gain.H
    residual = BlockMatrix(
        [
            [gain.R11, gain.R21.T],
            [ZeroMatrix(n - a, a), ZeroMatrix(n - a, b)],
        ]
    )
    solved = gain.ALGEBRA.with_relations(*gain.solved_relations(gain.K1, gain.K2))
    return (
        claims(
            gain.ALGEBRA,
            {
                "v1: [I 0] M - [I 0] Omega H' = [R11 R12]; Kalman's upper gain is "
                "[I 0] exactly if R11 = 0, R12 = 0": (top * M - upper, noise)
            },
        )
        | claims(
            solved,
            {
                "v1: V of (24) with (33) satisfies V M - Omega H' = [R11 R12; 0 0]": (
                    gain.V * M - gain.Omega * H.T,
                    residual,
                )
            },
        )
        | claims(
            zero,
            {
                "v1 = 0: [I 0] M = [I 0] Omega H'": (top * M, upper),
            },
        )
    )


@cache
def derive():
    parts = (minimal_order(), kalman(), every_size())
    formulas, steps = {}, {}
    for found, proofs in parts:
        formulas |= found
        steps |= proofs
    other = brammer.derive()
    return Derivation(
        given=(A, C, Q, R),
        formulas=formulas | other.formulas,
        steps=steps | perfect() | other.steps,
        source="Leondes and Novak (1974), section IV",
    )
