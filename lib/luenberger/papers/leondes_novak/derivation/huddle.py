"""Luenberger's conditions, the error equation, and Huddle's solution.

The error z - T x of any system z+ = F z + G u + D y is driven by the state and by
the input exactly through two residuals, so (9) and (10) are necessary and
sufficient.  Huddle's F = T+ A P, D = T+ A V factors the first residual through
I - P T - V C, which unbiasedness (13) makes zero.  Feedthrough E and noises that
are correlated, E[w v'] = S, are carried along; the paper is E = 0, S = 0.

Source: Leondes and Novak (1974), section II, (7)-(15); Aoki and Huddle (1967).
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
from .stages import decorrelation

n, p, m, r = sp.symbols("n p m r", integer=True, nonnegative=True)
A, Q, As = (MatrixSymbol(k, n, n) for k in ("A", "Q", "A_s"))
B, W = MatrixSymbol("B", n, m), MatrixSymbol("W", n, m)
C, E, R = MatrixSymbol("C", p, n), MatrixSymbol("E", p, m), MatrixSymbol("R", p, p)
F, G, D = (MatrixSymbol(k, r, d) for k, d in (("F", r), ("G", m), ("D", p)))
T, Tn = MatrixSymbol("T", r, n), MatrixSymbol("T_+", r, n)
P, V, S, J = (MatrixSymbol(k, n, d) for k, d in zip("PVSJ", (r, p, p, p)))
x, w, v, u, z, eps = (
    MatrixSymbol(k, d, 1)
    for k, d in zip(("x", "w", "v", "u", "z", "varepsilon"), (n, n, p, m, r, r))
)

UNBIASED = Algebra([Q, R], [(P * T, Identity(n) - V * C)])  # (13)
FREE = Algebra([Q, R])


def residuals():
    """What must vanish: dynamics (9), input (10), output (13), feedthrough."""
    return (
        Tn * A - F * T - D * C,
        Tn * B - G - D * E,
        P * T + V * C - Identity(n),
        W + V * E,
    )


def formulas():
    y = MatrixSymbol("y", p, 1)
    dynamics, input_, output, feedthrough = residuals()
    return {
        "(7) z_+": F * z + G * u + D * y,
        "(8) z": T * x + eps,
        "(9) dynamics residual": dynamics,
        "(10) input residual": input_,
        "(11) eps_+": F * eps + D * v - Tn * w,
        "(12) x_hat": P * z + V * y + W * u,
        "(13) output residual": output,
        "feedthrough residual": feedthrough,
        "(14) F": Tn * A * P,
        "(15) D": Tn * A * V,
        "(10) G": Tn * B - D * E,
        "W": -V * E,
        "A_s": A - J * C,
        "Q_s": Q - J * S.T,
        "(14) F, correlated noise": Tn * As * P,
        "(15) D, correlated noise": Tn * (As * V + J),
    }


def error_steps():
    """(9)-(13): the residuals are all that couples the error to x and u."""
    dynamics, input_, output, feedthrough = residuals()
    y, now = C * x + E * u + v, T * x + eps
    error = F * now + G * u + D * y - Tn * (A * x + B * u + w)
    wanted = F * eps + D * v - Tn * w
    estimate = P * now + V * y + W * u - x
    met = Algebra(
        [],
        [
            (Tn * A, F * T + D * C),
            (Tn * B, G + D * E),
            (P * T, Identity(n) - V * C),
            (W, -V * E),
        ],
    )
    a = MatrixSymbol("a", n, 1)
    unseen = Algebra([], [(T * a, ZeroMatrix(r, 1)), (C * a, ZeroMatrix(p, 1))])
    necessary = {
        "(9),(10) necessary: eps_+ = (11) - residual(9) x - residual(10) u, "
        "x and u free": (error, wanted - dynamics * x - input_ * u),
        "(13) necessary: x_hat - x = P eps + V v + residual(13) x + (W + V E) u": (
            estimate,
            P * eps + V * v + output * x + feedthrough * u,
        ),
    }
    sufficient = {
        "(11) under (9),(10): eps_+ = F eps + D v - T_+ w": (error, wanted),
        "(12),(13) unbiased: x_hat - x = P eps + V v": (estimate, P * eps + V * v),
    }
    return (
        claims(FREE, necessary)
        | claims(met, sufficient)
        | claims(
            unseen,
            {
                "(13) T a = 0 and C a = 0 force a = 0: r >= n - p": (
                    (P * T + V * C) * a,
                    ZeroMatrix(n, 1),
                )
            },
        )
    )


def huddle_steps():
    """(14), (15) solve (9); every other solution; when there is none other."""
    F0, D0 = Tn * A * P, Tn * A * V
    residual = Tn * A - F0 * T - D0 * C
    Fs, Ds = Tn * (A - J * C) * P, Tn * ((A - J * C) * V + J)
    Z1, Z2 = MatrixSymbol("Z_1", r, r), MatrixSymbol("Z_2", r, p)
    X1, X2 = MatrixSymbol("X_1", r, r), MatrixSymbol("X_2", r, p)
    more_1 = X1 * (Identity(r) - T * P) - X2 * C * P
    more_2 = X2 * (Identity(p) - C * V) - X1 * T * V
    minimal = UNBIASED.with_relations(
        (T * P, Identity(r)),
        (C * V, Identity(p)),
        (T * V, ZeroMatrix(r, p)),
        (C * P, ZeroMatrix(p, r)),
    )
    mixed = Z1 * T + Z2 * C
    return (
        claims(
            FREE,
            {
                "(14),(15) T_+ A - F T - D C = T_+ A (I - P T - V C)": (
                    residual,
                    Tn * A * (Identity(n) - P * T - V * C),
                ),
                "(9) F + Z1, D + Z2 solve it too exactly if Z1 T + Z2 C = 0": (
                    Tn * A - (F0 + Z1) * T - (D0 + Z2) * C,
                    residual - mixed,
                ),
            },
        )
        | claims(
            UNBIASED,
            {
                "(14),(15) satisfy (9) under (13)": (Tn * A, F0 * T + D0 * C),
                "(14),(15) with correlated noise satisfy (9) under (13)": (
                    Tn * A,
                    Fs * T + Ds * C,
                ),
                "(9) such Z1, Z2: [X1 X2](I - [T; C][P V])": (
                    more_1 * T + more_2 * C,
                    ZeroMatrix(r, n),
                ),
            },
        )
        | claims(
            minimal,
            {
                "(9) r + p = n: [T; C] invertible, Z1 T + Z2 C = 0 gives Z1 = 0": (
                    mixed * P,
                    Z1,
                ),
                "(9) r + p = n: and Z2 = 0": (mixed * V, Z2),
                "(14) r + p = n: J makes no difference to F": (Fs, F0),
                "(15) r + p = n: J makes no difference to D": (Ds, D0),
            },
        )
    )


def noise_steps():
    """S' lies in the range of R, so that J with J R = S exists."""
    a, b = MatrixSymbol("a", p, 1), MatrixSymbol("b", n, 1)
    t = sp.Symbol("t", real=True)
    null = FREE.with_relations((R * a, ZeroMatrix(p, 1)))
    joint = BlockMatrix([[Q, S], [S.T, R]])
    pair = BlockMatrix([[b], [t * a]])
    sides = {
        "R a = 0 forces S a = 0: [b; t a]' cov [b; t a] = b'Q b + 2 t b'S a >= 0 "
        "for all t": (
            sp.Trace(pair.T * joint * pair),
            sp.Trace(b.T * Q * b) + 2 * t * sp.Trace(b.T * S * a),
        )
    }
    correlated = {f"S: {name}": step for name, step in decorrelation().steps.items()}
    return claims(null, sides) | correlated


@cache
def derive():
    return Derivation(
        given=(A, B, C, E, Q, R, S, P, T, Tn, V),
        formulas=formulas(),
        steps=error_steps() | huddle_steps() | noise_steps(),
        source="Leondes and Novak (1974), section II",
    )
