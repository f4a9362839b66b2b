"""The pair a +- jb as the page writes it, and the counts (22)-(25), (34).

What is true of the doubled system is in `rows`; here are its definitions: the
block (26), the two rows (27), (28), and the order (31) in which the unknowns become
one vector.  The counts are sums of the multiply-adds of each reflector or row.

Source: Van Dooren (1984), (22)-(34).
"""

from functools import cache

import sympy as sp
from sympy.matrices import kronecker_product

from ....symbolic import Claim, Derivation
from .rows import Pattern, counts, interleaved, j, m, n, r, row_symbols

STAIRS = (1, 2, 2)  # the smallest with a row before a pair
a, b = sp.symbols("a b", real=True)
BLOCK = sp.Matrix([[a, -b], [b, a]])


def pair_rows(i=1):
    """T_i, the rows i and i + 1 of T and of F, and d_i', d_(i+1)'."""
    p = Pattern(STAIRS)
    f, t, d = row_symbols(p, i, rows=2)
    tau = t.copy()
    tau[0, 0], tau[1, 0] = sp.Symbol(f"tau_{i}_{i + 1}"), 1  # (28): [0 1 t'] below
    pair = sp.Matrix.hstack(sp.zeros(2, i), sp.Matrix([1, 0]), tau)
    above = p.T_above(i)
    rest = sp.Matrix(p.n - p.r - i - 2, p.n, lambda k, c: sp.Symbol(f"s_{k}_{c}"))
    rows_of_F = sp.Matrix.hstack(f, BLOCK, sp.zeros(2, rest.rows))
    return p, f, pair, d, above, sp.Matrix.vstack(above, pair, rest), rows_of_F


def block_steps():
    """(26)-(29), (31), (33) for stairs (1, 2, 2), rows 1 and 2."""
    p, f, pair, d, above, T, rows_of_F = pair_rows()
    s, name = sp.Symbol("s"), f"stairs {STAIRS}, rows 1 and 2"
    doubled = kronecker_product(p.A - a * sp.eye(p.n), sp.eye(2))
    doubled -= kronecker_product(sp.eye(p.n), sp.Matrix([[0, -b], [b, 0]]))
    swap = sp.Matrix([[0, 1], [1, 0]])
    return {
        "(26) the block has the eigenvalues a +- jb": Claim(
            (s * sp.eye(2) - BLOCK).det().expand(), ((s - a) ** 2 + b**2).expand()
        ),
        f"(27) rows of F times T_U: f T_i + block times the pair, {name}": Claim(
            (rows_of_F * T).expand(), (f * above + BLOCK * pair).expand()
        ),
        f"(28),(29) what is known on the left, the unknown f, d on the right, {name}": (
            Claim(
                (pair * p.A - rows_of_F * T - d * p.C).expand(),
                (pair * p.A - BLOCK * pair - f * above - d * p.C).expand(),
            )
        ),
        f"(31) row i + 1 before row i, column by column: f T_i is xb'Tb, {name}": Claim(
            interleaved(f * above).expand(),
            (interleaved(f) * kronecker_product(above, sp.eye(2))).expand(),
        ),
        f"(33) interleaved, T A - block T is the row times the product, {name}": Claim(
            interleaved((pair * p.A - BLOCK * pair).expand()),
            (interleaved(pair) * doubled).expand(),
        ),
        f"(33) with the rows in the other order b changes its sign, {name}": Claim(
            (swap * BLOCK * swap), BLOCK.subs(b, -b)
        ),
    }


def sums(term, variable, last):
    return sp.summation(term, (variable, 0, last))


def count_steps():
    """(22)-(25), (34): sums, whose leading terms are the page's figures."""
    c, i = counts(), sp.Symbol("i", integer=True, nonnegative=True)
    done = sums(2 * (n - j) ** 2 + 2 * n * (n - j) + 2 * n * (n - j), j, n - 1)
    solved = n * sums(j + 1, j, n - 1)  # n rows, one triangle each
    leading = lambda x, y: sp.limit(x / y, n, sp.oo)  # noqa: E731
    return {
        "(22) n - r rows of r n^2 each": Claim(
            sums(c["(21) one M_i"], i, n - r - 1).expand(),
            c["(22) all rows"].expand(),
        ),
        "(23) reflectors from left and right and on U: 8/3 n^3 to leading order": (
            Claim(leading(done, n**3), leading(c["staircase, as done"], n**3))
        ),
        "(23) the page counts n^3/3 + r n^2 more": Claim(
            (c["(23) staircase"] - c["staircase, as done"]).expand(),
            n**3 / 3 + r * n**2,
        ),
        "(25) U^*B, n x n times n x m, and T_U times it": Claim(
            (n * n * m + (n - r) * n * m).expand(), c["(25) P"].expand()
        ),
        "(25) n rows of [P V], each by one triangle: n^3/2 to leading order": Claim(
            leading(solved, c["(25) [G; H]"]), sp.Integer(1)
        ),
        "(34) (n - r)/2 pairs, a system of twice the rows and columns": Claim(
            ((n - r) / 2 * (2 * r) * (2 * n) ** 2).expand(),
            c["(34) conjugate pairs, doubled real systems"].expand(),
        ),
    }


@cache
def derive():
    p, f, pair, d, _, _, rows_of_F = pair_rows()
    return Derivation(
        formulas={
            "(26) block": BLOCK,
            "(27) rows of F": rows_of_F,
            "(28) rows of T_U": pair,
            "(31) xb'": sp.Matrix.hstack(
                interleaved(f), interleaved(pair[:, 2:]), interleaved(d)
            ),
        },
        steps=block_steps() | count_steps(),
        source="Van Dooren (1984), section 3",
    )
