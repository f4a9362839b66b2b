"""Moore's observer of a functional k x without feedthrough: the case V = 0.

For the plant x+ = A x + B u, y = C x + E u an observer z+ = F z + G u + D y with
w^ = P z tracks k x exactly when T A - F T = D C, G = T B - D E, P T = k (x+ is the
next state or the derivative).  In companion coordinates T is built row by row from
k, and the only condition left is on the characteristic polynomial beta of F:
k beta(A) must be a combination of the rows of C, CA, ..., CA^(r-1).  That holds in
any coordinates and for any number of outputs.

    letter of the paper   F  g  h'  k'  A  b  d  l'  T'  p
    letter here           A  B  C   k   F  D  G  P   T   r

Sizes are symbols except where a step's name gives r or a power.

Source: Moore (1973), (1)-(7), (10), (13); feedthrough E, several functionals, the
graph in the necessity proof and the companion rows are our own.
"""

from dataclasses import replace
from functools import cache

import sympy as sp
from sympy import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix

from ..certificate import residuals
from . import Derivation, Stage
from .algebra import Algebra, claims

n, p, m, r, q = sp.symbols("n p m r q", integer=True, nonnegative=True)
A, F = MatrixSymbol("A", n, n), MatrixSymbol("F", r, r)
B, C, E = MatrixSymbol("B", n, m), MatrixSymbol("C", p, n), MatrixSymbol("E", p, m)
G, D, T = (MatrixSymbol(s, r, size) for s, size in (("G", m), ("D", p), ("T", n)))
P, k = MatrixSymbol("P", q, r), MatrixSymbol("k", q, n)
V, W = ZeroMatrix(q, p), ZeroMatrix(q, m)
x, z, u, eps = (
    MatrixSymbol(name, size, 1)
    for name, size in (("x", n), ("z", r), ("u", m), ("varepsilon", r))
)

FREE = Algebra()
PAPER = "Moore (1973)"
ORDERS = (1, 2, 3, 4, 5)  # concrete r of the companion rows
MET = Algebra([], [(T * A, F * T + D * C), (G, T * B - D * E), (P * T, k)])


# -- stage lists --------------------------------------------------------------------


@cache
def companion_row():
    """One row of T from the row above it, for (F, P) in observer companion form.

    t_1 = k; then t_next of row i with b = beta_(r-i) and d = D_i is row i + 1, and
    the row that would follow the last, r + 1, must come out as zero.
    """
    t, t_next, row = (MatrixSymbol(s, 1, n) for s in ("t", "t_next", "k"))
    b, d = MatrixSymbol("b", 1, 1), MatrixSymbol("d", 1, p)
    stages = (Stage(t_next, t * A + b * row - d * C, "(5)"),)
    found = Derivation((t, A, b, row, d, C), stages, source=PAPER)
    return replace(found, steps=prove_companion_row(found))


@cache
def observer():
    """G of (6), given T and D."""
    stages = (Stage(G, T * B - D * E, "(6)"),)
    found = Derivation((T, B, D, E), stages, source=PAPER)
    return replace(found, steps=prove_observer(found))


def prove_observer(found):
    """The error is not driven by the input."""
    gain = found.unfolded()["G"]
    _, input_, _, _ = residuals(A, B, C, E, k, F, gain, D, P, V, W, T, T)
    y = C * x + E * u
    driven = Algebra([], [(T * A, F * T + D * C)])
    error = F * (T * x + eps) + gain * u + D * y - T * (A * x + B * u)
    return claims(FREE, {"(6) input residual T B - G - D E = 0": (input_, 0)}) | claims(
        driven, {"(6) with this G eps_+ = F eps": (error, F * eps)}
    )


def prove_companion_row(found):
    """T A - F T - D C has the row after the last as its only row that is not zero."""
    steps = {}
    for order in ORDERS:
        beta, D_rows, T_rows, after = companion(found, order)
        row = found.given[3]
        companion_F, companion_P = in_companion_form(beta)
        dynamics, _, output, _ = residuals(
            A, B, C, E, row, companion_F, G, column(D_rows), companion_P,
            ZeroMatrix(1, p), ZeroMatrix(1, m), column(T_rows), column(T_rows),
        )  # fmt: skip
        wanted = column([ZeroMatrix(1, n)] * (order - 1) + [after])
        # after = k beta(A) - D_1 C A^(r-1) - ... - D_r C
        polynomial = sum((b * row * A**j for j, b in enumerate(beta)), row * A**order)
        shown = sum(
            (d * C * A ** (order - 1 - i) for i, d in enumerate(D_rows[1:], 1)),
            D_rows[0] * C * A ** (order - 1),
        )
        steps |= claims(
            FREE,
            {
                f"(5) T A - F T - D C: all rows vanish but the last, r = {order}": (
                    dynamics,
                    wanted,
                ),
                f"(10) P T = k, r = {order}": (output, 0),
                f"(13) the last is k beta(A) - sum D_i C A^(r-i), r = {order}": (
                    after,
                    polynomial - shown,
                ),
            },
        )
    return steps


def companion(found, order):
    """beta_0 .. beta_(r-1), the rows of D, those of T, and the row after the last."""
    (stage,) = found.stages
    t, _, b, row, d, _ = found.given
    beta = [MatrixSymbol(f"beta_{j}", 1, 1) for j in range(order)]
    D_rows = [MatrixSymbol(f"D_{i + 1}", 1, p) for i in range(order)]
    T_rows = [row]
    for b_i, d_i in zip(reversed(beta), D_rows):
        T_rows.append(stage.formula.xreplace({t: T_rows[-1], b: b_i, d: d_i}))
    *T_rows, after = T_rows
    return beta, D_rows, T_rows, after


def in_companion_form(beta):
    """F and P with characteristic polynomial beta: P is the first unit row."""
    order, one, none = len(beta), Identity(1), ZeroMatrix(1, 1)
    rows = [
        [-b] + [one if j == i + 1 else none for j in range(1, order)]
        for i, b in enumerate(reversed(beta))
    ]
    return BlockMatrix(rows), BlockMatrix([[one] + [none] * (order - 1)])


def column(blocks):
    return BlockMatrix([[block] for block in blocks])
