"""Moore's own route, (8)-(13): the functional as a sequence with a recurrence.

In observable companion form T is a Krylov matrix, [t, F t, ..., F^(n-1) t], so that
S_r T' = 0 by Cayley and Hamilton, and k is a combination of its rows exactly if
S_r k' = 0: the entries of k obey the recurrence whose polynomial is beta.  They are
kappa_i = k A^i g in any coordinates, g the state that C, CA, ..., CA^(n-2) do not see;
they are also the observer's response P F^i T g.

The letters are those of `observer`.  One output; n, and mostly r, are numbers.
Source: Moore (1973), (2), (8)-(13); the sequence in other coordinates is our own.
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
from .condition import at

SIZES = ((2, 1), (3, 1), (3, 2), (4, 2), (5, 3), (6, 4))  # (n, r)
n, p, r = sp.symbols("n p r", integer=True, nonnegative=True)
A, F = MatrixSymbol("A", n, n), MatrixSymbol("F", r, r)
C, D = MatrixSymbol("C", 1, n), MatrixSymbol("D", r, 1)
T, P = MatrixSymbol("T", r, n), MatrixSymbol("P", 1, r)
g, k = MatrixSymbol("g", n, 1), MatrixSymbol("k", 1, n)


# -- (8)-(13) in observable companion form ------------------------------------------


def observable_form(size):
    """A and C of (1), (2): the last column of A is -alpha, C = [0 ... 0 1]."""
    alpha = sp.symbols(f"alpha_:{size}")
    A = sp.Matrix(size, size, lambda i, j: int(i == j + 1))
    A[:, -1] = -sp.Matrix(alpha)
    return A, sp.Matrix(1, size, lambda _, j: int(j == size - 1)), alpha


def observer_pair(order):
    """F and t: a symbol for every entry, or from r = 3 on companion F, t = [1 0 ..]'.

    A controllable (F, t) can be brought to that form, so nothing is lost.
    """
    if order < 3:
        F = sp.Matrix(order, order, lambda i, j: sp.Symbol(f"f_{i + 1}{j + 1}"))
        return F, sp.Matrix(order, 1, lambda i, _: sp.Symbol(f"t_{i + 1}"))
    F = sp.Matrix(order, order, lambda i, j: int(i == j + 1))
    F[:, -1] = -sp.Matrix(sp.symbols(f"beta_:{order}"))
    return F, sp.Matrix(order, 1, lambda i, _: int(i == 0))


def characteristic(F):
    """beta_0, ..., beta_(r-1), 1 of (12)."""
    return F.charpoly(sp.Symbol("s")).all_coeffs()[::-1]


def krylov(F, t, size):
    """[t, F t, ..., F^(size-1) t]."""
    columns = [t]
    for _ in range(size - 1):
        columns.append((F * columns[-1]).expand())
    return sp.Matrix.hstack(*columns)


def S(beta, size):
    """(11): n - r rows, each beta_0, ..., beta_(r-1), 1 one place further on."""
    order = len(beta) - 1
    rows = [[0] * i + [*beta] + [0] * (size - order - 1 - i) for i in range(size)]
    return sp.Matrix(size - order, size, sum(rows[: size - order], []))


def construction_steps(size, order):
    """(8), (9) solve (5), and nothing else does; (10) in both directions."""
    A, C, alpha = observable_form(size)
    F, t = observer_pair(order)
    beta, T = characteristic(F), krylov(F, t, size + 1)
    D = -(T * sp.Matrix([*alpha, 1])).expand()  # (8)
    T, kalman = T[:, :size], T[:, :order]
    shift = S(beta, size)
    free = sp.Matrix(order, size, lambda i, j: sp.Symbol(f"T_{i + 1}{j + 1}"))
    d = sp.Matrix(order, 1, lambda i, _: sp.Symbol(f"d_{i + 1}"))
    ahead = sp.Matrix.hstack(free[:, 1:], -free * sp.Matrix(alpha) - d)
    P = sp.Matrix(1, order, lambda _, j: sp.Symbol(f"P_{j + 1}"))
    kappa = continued(beta, size)
    found = (kappa[:, :order] * kalman.inv()).applyfunc(sp.cancel)
    minor = shift[:, order:]
    first, last = S([*beta[:-1], 0], size), S([0] * order + [1], size)
    name = f"n = {size}, r = {order}"
    return {
        f"(5) by columns: T_(j+1) = F T_j, and the last gives D, {name}": Claim(
            free * A - F * free - d * C, (ahead - F * free).expand()
        ),
        f"(8),(9) solve (5): T A - F T = D C, {name}": Claim(
            (T * A - F * T).expand(), (D * C).expand()
        ),
        f"(10),(11) S_r T' = 0, T as used here, {name}": Claim(
            (first * T.T).expand(), -(last * T.T).expand()
        ),
        f"(10) k = P T gives S_r k' = 0, {name}": Claim(
            (first * (P * T).T).expand(), -(last * (P * T).T).expand()
        ),
        f"(10) S_r k' = 0 gives k = P T, P = [k_0 .. k_(r-1)][t .. F^(r-1) t]^-1, "
        f"{name}": Claim((found * T).applyfunc(sp.cancel), kappa),
        f"(11) S_r has rank n - r: its last columns are triangular, {name}": Claim(
            minor, minor.lower_triangular()
        ),
        f"(11) with beta_r = 1 on the diagonal, {name}": Claim(minor.det(), 1),
    }


def continued(beta, size):
    """k_0, ..., k_(r-1) as symbols, and what the recurrence makes of them."""
    order = len(beta) - 1
    kappa = list(sp.symbols(f"k_:{order}"))
    while len(kappa) < size:
        last = kappa[-order:]
        kappa.append(sp.expand(-sum(b * x for b, x in zip(beta, last))))
    return sp.Matrix([kappa])


def hamilton_step(order):
    """(12) Cayley and Hamilton, for F with a symbol for every entry."""
    F = sp.Matrix(order, order, lambda i, j: sp.Symbol(f"f_{i + 1}{j + 1}"))
    total, power = sp.zeros(order), sp.eye(order)
    for b in characteristic(F)[:-1]:
        total, power = total + b * power, (power * F).expand()
    return {f"(12) beta(F) = 0, r = {order}": Claim(power, -total.expand())}


# -- the same in any coordinates ----------------------------------------------------


def unseen(size):
    """C A^j g = 0 for j < n - 1, and C A^(n-1) g = 1."""
    return [
        (C * A**j * g, ZeroMatrix(1, 1) if j < size - 1 else Identity(1))
        for j in range(size)
    ]


def coordinate_steps(size):
    """X = [g, A g, ..., A^(n-1) g] takes the plant to the form of (1), (2)."""
    alpha = sp.symbols(f"alpha_:{size}")
    # A^n = -alpha_0 - ... - alpha_(n-1) A^(n-1), Cayley and Hamilton
    known = Algebra([], [*unseen(size), (A**size, -at(A, alpha))])
    X = [A**j * g for j in range(size)]
    last = sp.MatAdd(*(-a * x for a, x in zip(alpha, X)))
    moved = BlockMatrix([[A * x for x in X]])
    name = f"n = {size}"
    tall = sp.Matrix(size, size, lambda i, j: hankel_entry(i + j, size))
    return claims(
        known,
        {
            f"(2) A X = X A_o, the last column of A_o is -alpha, {name}": (
                moved,
                BlockMatrix([[*X[1:], last]]),
            ),
            f"(1) C X = [0 .. 0 1], {name}": (
                BlockMatrix([[C * x for x in X]]),
                BlockMatrix([[ZeroMatrix(1, 1)] * (size - 1) + [Identity(1)]]),
            ),
        },
    ) | {
        f"(1) [C; CA; ..] X is triangular from the right with ones, {name}": Claim(
            sp.Abs(tall.det(method="berkowitz")), 1
        )
    }


def hankel_entry(j, size):
    """C A^j g: zero, then one, then a symbol."""
    return sp.Symbol(f"h_{j}") if j >= size else sp.Integer(j == size - 1)


def sequence_steps(size):
    """kappa_i = k A^i g = P F^i T g, and (13) is the condition on k beta(A)."""
    solved = [(T * A, F * T + D * C), *unseen(size)]
    observed = Algebra([], solved)
    steps = claims(
        observed,
        {
            f"(10) kappa_{i} = P T A^{i} g = P F^{i} T g, n = {size}": (
                P * T * A**i * g,
                P * F**i * T * g,
            )
            for i in range(size)
        },
    )
    for order in range(1, size):
        beta = [*sp.symbols(f"beta_:{order}"), sp.S.One]
        rest = [MatrixSymbol(f"D_{i + 1}", 1, 1) for i in range(order)]
        shown = sp.MatAdd(*(d * C * A ** (order - 1 - i) for i, d in enumerate(rest)))
        steps |= claims(
            Algebra([], unseen(size)),
            {
                f"(13) C, .., CA^(r-1) do not see A^{i} g, n = {size}, r = {order}": (
                    shown * A**i * g,
                    0,
                )
                for i in range(size - order)
            }
            | {
                f"(13) row {i} of S_r kappa is k beta(A) A^{i} g, n = {size}, "
                f"r = {order}": (
                    sp.MatAdd(*(k * b * A**j for j, b in enumerate(beta))) * A**i * g,
                    sp.MatAdd(*(b * k * A ** (i + j) * g for j, b in enumerate(beta))),
                )
                for i in range(size - order)
            },
        )
    return steps


def row_space_steps(size, order):
    """In the form of (1), (2): the rows C, .., CA^(r-1) fill the last r entries."""
    A, C, _ = observable_form(size)
    beta = [*sp.symbols(f"beta_:{order}"), 1]
    k = sp.Matrix([sp.symbols(f"k_:{size}")])
    rows, k_beta, power = [], sp.zeros(1, size), k
    for b in beta:
        rows.append(rows[-1] * A if rows else C)
        k_beta, power = k_beta + b * power, power * A
    seen = sp.Matrix.vstack(*rows[:order])
    free = size - order
    name = f"n = {size}, r = {order}"
    return {
        f"(13) the rows C, .., CA^(r-1) are zero in the first n - r, {name}": Claim(
            seen[:, :free]
        ),
        f"(13) and independent in the last r, {name}": Claim(
            seen[:, free:].det() ** 2, 1
        ),
        f"(13) the first n - r of k beta(A) are S_r k', {name}": Claim(
            k_beta[:, :free].T.expand(), (S(beta, size) * k.T).expand()
        ),
    }


def scale_step(size, order):
    """Another unit of time: kappa_i / sigma^i has beta_j / sigma^(r - j)."""
    sigma = sp.Symbol("sigma", positive=True)
    beta = [*sp.symbols(f"beta_:{order}"), sp.S.One]
    kappa = sp.Matrix(sp.symbols(f"k_:{size}"))
    scaled = S([b / sigma ** (order - j) for j, b in enumerate(beta)], size)
    sequence = sp.Matrix([x / sigma**i for i, x in enumerate(kappa)])
    rows = S(beta, size) * kappa
    wanted = sp.Matrix([x / sigma ** (i + order) for i, x in enumerate(rows)])
    return {
        "(13) in another unit of time: row i divided by sigma^(i + r), "
        f"n = {size}, r = {order}": Claim((scaled * sequence).expand(), wanted.expand())
    }


def formulas():
    """The definitions for n = 5, r = 2, for reading."""
    A, C, alpha = observable_form(5)
    s = sp.Symbol("s")
    beta = [*sp.symbols("beta_:2"), sp.S.One]
    kappa = sp.Matrix(sp.symbols("kappa_:5"))
    powers = sp.symbols("t Ft F^2t F^3t F^4t F^5t", commutative=False)
    return {
        "(1) A": A,
        "(1) C": C,
        "(2) det(s I - A)": sum((a * s**i for i, a in enumerate(alpha)), s**5),
        "(8) D": -sp.Add(*(a * x for a, x in zip([*alpha, 1], powers))),
        "(9) T": sp.Matrix([powers[:5]]),
        "(11) S_2": S(beta, 5),
        "(12) det(s I - F)": sum(b * s**j for j, b in enumerate(beta)),
        "(13) S_2 kappa": S(beta, 5) * kappa,
    }


@cache
def derive():
    steps = {}
    for order in (1, 2, 3, 4):
        steps |= hamilton_step(order)
    for size, order in SIZES:
        steps |= construction_steps(size, order) | row_space_steps(size, order)
        steps |= scale_step(size, order)
    for size in (2, 3):  # r = n: S_n has no rows, and every beta will do
        for name, claim in construction_steps(size, size).items():
            if "(11)" not in name and "gives S_r" not in name:
                steps[name] = claim
    for size in (2, 3, 4, 5, 6):
        steps |= coordinate_steps(size) | sequence_steps(size)
    return Derivation(
        formulas=formulas(),
        steps=steps,
        source="Moore (1973), (2), (8)-(13)",
    )
