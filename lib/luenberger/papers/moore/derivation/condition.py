"""When an observer without feedthrough exists: a condition on beta alone.

(5) and P T = k leave T to be eliminated.  In companion coordinates T is built from
k row by row, and T A - F T = D C fails in one row only, which is k beta(A) less a
combination of the rows of C, CA, ..., CA^(r-1).  Conversely every observer obeys
it, by Cayley and Hamilton.  Both hold in any coordinates and for any number of
outputs; n and p are symbols, the order r is a number in the proofs.

Source: Moore (1973), (5), (10), (12), (13); this form of them is our own.
"""

import sympy as sp
from sympy import MatAdd

from ....certificate import residuals
from ....symbolic import (
    Algebra,
    BlockMatrix,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)

n, p, m, r, q = sp.symbols("n p m r q", integer=True, nonnegative=True)
A, F = MatrixSymbol("A", n, n), MatrixSymbol("F", r, r)
B, C, E = MatrixSymbol("B", n, m), MatrixSymbol("C", p, n), MatrixSymbol("E", p, m)
G, D, T = (MatrixSymbol(s, r, size) for s, size in (("G", m), ("D", p), ("T", n)))
P, k = MatrixSymbol("P", q, r), MatrixSymbol("k", q, n)

FREE = Algebra()
SOLVED = Algebra([], [(T * A, F * T + D * C)])  # (5)
ORDERS = (1, 2, 3, 4, 5)
CHAINS = ((1, 1), (1, 2), (2, 1), (1, 2, 1))  # degrees of the factors of beta


def column(blocks):
    return BlockMatrix([[block] for block in blocks])


# -- from beta to T -----------------------------------------------------------------


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


def row_steps(found):
    """What the rows are for: one companion block, and a chain of several."""
    return companion_steps(found) | chain_steps(found)


def companion_steps(found):
    """T A - F T - D C has the row after the last as its only row that is not zero."""
    steps = {}
    for order in ORDERS:
        beta, D_rows, T_rows, after = companion(found, order)
        row, (F_beta, P_beta) = found.given[3], in_companion_form(beta)
        tracked, none = column(T_rows), [ZeroMatrix(1, n)] * (order - 1)
        dynamics, *_ = residuals(
            A, B, C, E, row, F_beta, ZeroMatrix(order, m), column(D_rows), P_beta,
            ZeroMatrix(1, p), ZeroMatrix(1, m), tracked, tracked,
        )  # fmt: skip
        k_beta = MatAdd(*(b * row * A**j for j, b in enumerate(beta)), row * A**order)
        shown = MatAdd(*(d * C * A**j for d, j in zip(D_rows, downwards(order))))
        name = f"r = {order}"
        steps |= {
            f"(5) all rows of T A - F T - D C vanish but the last, {name}": (
                dynamics,
                column([*none, after]),
            ),
            f"(7) P T = k, {name}": (P_beta * tracked, row),
            f"(13) the last is k beta(A) - sum D_i C A^(r-i), {name}": (
                after,
                k_beta - shown,
            ),
        }
    return claims(FREE, steps)


def chain_steps(found):
    """The same for a chain of companion blocks, one for each factor of beta.

    Each block feeds the one before it, and the stage takes the first row of its own
    block in place of k.  The poles of short blocks stay where they are put.
    """
    (stage,) = found.stages
    t, _, b, row, d, _ = found.given
    steps = {}
    for degrees in CHAINS:
        order, name = sum(degrees), f"factors of degrees {degrees}"
        D_rows = [MatrixSymbol(f"D_{i + 1}", 1, p) for i in range(order)]
        F_rows = sp.eye(order + 1)[1:, :order].tolist()  # ones above the diagonal
        T_rows, after, polynomial, later = [], row, row, [C] * order
        for f, degree in enumerate(degrees):
            first, at_first = after, len(T_rows)
            factor = [*sp.symbols(f"b_{f + 1}_:{degree}"), sp.S.One]
            later[:at_first] = [X * at(A, factor) for X in later[:at_first]]
            for i in range(degree):
                coefficient = factor[degree - 1 - i]
                F_rows[at_first + i][at_first] -= coefficient
                later[at_first + i] = C * A ** (degree - 1 - i)
                new = {t: after, b: coefficient * Identity(1), row: first}
                T_rows.append(after)
                after = stage.formula.xreplace(new | {d: D_rows[at_first + i]})
            polynomial = polynomial * at(A, factor)
        F_blocks = BlockMatrix([[x * Identity(1) for x in line] for line in F_rows])
        none = [ZeroMatrix(1, n)] * (order - 1)
        shown = MatAdd(*(d_i * X for d_i, X in zip(D_rows, later)))
        steps |= {
            f"(5) all rows of T A - F T - D C vanish but the last, {name}": (
                column(T_rows) * A - F_blocks * column(T_rows) - column(D_rows) * C,
                column([*none, after]),
            ),
            f"(13) the last is k beta(A) - sum D_i X_i, {name}": (
                after,
                polynomial - shown,
            ),
        }
    return claims(FREE, steps)


def downwards(order):
    """r - 1, ..., 1, 0: the powers of A beside D_1, ..., D_r."""
    return reversed(range(order))


# -- from an observer to beta -------------------------------------------------------


def at(matrix, beta):
    """The polynomial with coefficients beta_0, beta_1, ... at a square matrix."""
    return MatAdd(*(b * matrix**j for j, b in enumerate(beta)))


def power_steps():
    """(5) multiplied by powers of A."""
    return claims(
        SOLVED,
        {
            f"(10) T A^{j} = F^{j} T + sum F^({j}-1-i) D C A^i": (
                T * A**j,
                MatAdd(F**j * T, *(F ** (j - 1 - i) * D * C * A**i for i in range(j))),
            )
            for j in range(7)
        },
    )


def hamilton_steps(order):
    """beta(F) = 0: what k beta(A) is, and that companion form is no loss."""
    beta, one = list(sp.symbols(f"beta_:{order}")), sp.S.One
    known = SOLVED.with_relations((F**order, -at(F, beta)))
    M = [P]  # M_1 = P, M_(i+1) = M_i F + beta_(r-i) P
    for b in reversed(beta):
        M.append(M[-1] * F + b * P)
    *M, after = M
    shown = MatAdd(*(X * D * C * A**j for X, j in zip(M, downwards(order))))
    shifted = [*M[1:], ZeroMatrix(q, r)]
    turned = [X - b * P for X, b in zip(shifted, reversed(beta))]
    name = f"r = {order}"
    return claims(
        known,
        {
            f"(12) the row after the last M_i is P beta(F) = 0, {name}": (after, 0),
            f"(12) no loss: the rows M_i turn (F, P) into companion form, {name}": (
                column([X * F for X in M]),
                column(turned),
            ),
            "(10),(13) necessary: k = P T has k beta(A) = sum D_i C A^(r-i), "
            f"D_i = M_i D, {name}": (P * T * at(A, [*beta, one]), shown),
        },
    )


def quotient_step(order):
    """What is left of the condition beside N with C A^j N = 0 for j < r.

    With N a basis of all such columns nothing is lost: a row that N sends to zero
    is a combination of the rows of C, CA, ..., CA^(r-1).
    """
    N, (beta, D_rows) = MatrixSymbol("N", n, q), companion_symbols(order)
    unseen = Algebra([], [(C * A**j * N, ZeroMatrix(p, q)) for j in range(order)])
    k_beta = MatAdd(*(b * k * A**j for j, b in enumerate(beta)))
    shown = MatAdd(*(d * C * A**j for d, j in zip(D_rows, downwards(order))))
    return claims(
        unseen,
        {
            "(13) several outputs: (k beta(A) - sum D_i C A^(r-i)) N = k beta(A) N, "
            f"r = {order}": ((k_beta - shown) * N, k_beta * N)
        },
    )


def companion_symbols(order):
    beta = [*sp.symbols(f"beta_:{order}"), sp.S.One]
    return beta, [MatrixSymbol(f"D_{i + 1}", q, p) for i in range(order)]


def steps():
    """Everything that is claimed of beta for any observer."""
    found = power_steps()
    for order in ORDERS:
        found |= hamilton_steps(order) | quotient_step(order)
    return found
