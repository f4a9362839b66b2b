"""Plant and estimator as one system: its moments, the Lagrangian and its gradients.

The paper's letters, with those of the library behind them (the rest agree):

    V1, V2, V12   covariances of w1, w2 and E[w1 w2']       Q, R, S of the plant
    Ae, Be        x_e+ = Ae x_e + Be y                      F, D of the observer
    Ce, De        y_e = Ce x_e + De y                       P, V
    Gam, G'       x_e tracks Gam x; G' lifts x_e to R^n     T, and no letter
    R             weight on the error of L x                `weight`

G is never the library's input gain here, and R and P never the plant's R and the
observer's P.  Each pair (A_i, C_i) is multiplied by a white noise of unit variance,
independent of all others; two pairs stand for any number, because the Lagrangian is
proved to be additive over pairs.

Source: Haddad and Bernstein (1987), sections 2 and 4, (3.1)-(3.5), (4.1)-(4.11).
"""

from functools import cache

import sympy as sp
from sympy import BlockMatrix, MatrixSymbol, Trace, ZeroMatrix

from .algebra import Algebra

n, l, r, q = sp.symbols("n l n_e q", integer=True, nonnegative=True)

A, V1, Q1, P1 = (MatrixSymbol(k, n, n) for k in ("A", "V1", "Q1", "P1"))
C, V12, V2 = (
    MatrixSymbol("C", l, n),
    MatrixSymbol("V12", n, l),
    MatrixSymbol("V2", l, l),
)
L, R = MatrixSymbol("L", q, n), MatrixSymbol("R", q, q)
Ae, Be = MatrixSymbol("Ae", r, r), MatrixSymbol("Be", r, l)
Ce, De = MatrixSymbol("Ce", q, r), MatrixSymbol("De", q, l)
Q12, P12 = MatrixSymbol("Q12", n, r), MatrixSymbol("P12", n, r)
Q2, P2 = MatrixSymbol("Q2", r, r), MatrixSymbol("P2", r, r)
PAIRS = tuple(
    (MatrixSymbol(f"A_{i}", n, n), MatrixSymbol(f"C_{i}", l, n)) for i in (1, 2)
)
GAINS = (Ae, Be, Ce, De)

Qt = BlockMatrix([[Q1, Q12], [Q12.T, Q2]])
Pt = BlockMatrix([[P1, P12], [P12.T, P2]])
At = BlockMatrix([[A, ZeroMatrix(n, r)], [Be * C, Ae]])
Vt = BlockMatrix([[V1, V12 * Be.T], [Be * V12.T, Be * V2 * Be.T]])
error = BlockMatrix([[L - De * C, -Ce]])  # L x - y_e without what is noise

SYMMETRIC = (V1, V2, R, Q1, Q2, P1, P2)
ALGEBRA = Algebra(SYMMETRIC)


def noisy(pair):
    """A~_i: what a pair's noise does to the augmented state."""
    Ai, Ci = pair
    return BlockMatrix([[Ai, ZeroMatrix(n, r)], [Be * Ci, ZeroMatrix(r, r)]])


def weight(pairs=()):
    """R~: the cost in the augmented state."""
    corner = sum((Ci.T * De.T * R * De * Ci for _, Ci in pairs), ZeroMatrix(n, n))
    cross = -(L - De * C).T * R * Ce
    return BlockMatrix(
        [
            [(L - De * C).T * R * (L - De * C) + corner, cross],
            [cross.T, Ce.T * R * Ce],
        ]
    )


def moment(pairs=()):
    """The right side of (4.4): the next second moment."""
    found = ALGEBRA.normal(At * Qt * At.T + Vt)
    for pair in pairs:
        found = found + noisy(pair) * Qt * noisy(pair).T
    return found


def adjoint(pairs=()):
    """The right side of (4.5)."""
    found = ALGEBRA.normal(At.T * Pt * At + weight(pairs))
    for pair in pairs:
        found = found + noisy(pair).T * Pt * noisy(pair)
    return found


def cost(pairs=()):
    """J in terms of Q~: tr Q~ R~ + tr De V2 De' R."""
    return ALGEBRA.normal(Trace(Qt * weight(pairs))) + Trace(De * V2 * De.T * R)


@cache
def lagrangian(pairs=()):
    """J + tr P~ (right side of (4.4) - Q~)."""
    return cost(pairs) + ((moment(pairs) - Qt) @ ALGEBRA.normal(Pt)).trace()


@cache
def gradients(pairs=()):
    """{gain: half the gradient of the Lagrangian}, which is half that of J."""
    return {X: sp.S.Half * ALGEBRA.gradient(lagrangian(pairs), X) for X in (*GAINS,)}
