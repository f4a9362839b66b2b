"""What Van Dooren's pages print and what holds, each entry tried.

`entries()` gives for every place the printed claim as a residual that does not
vanish, and the correct one as a residual that does.  The rank of the doubled system
is in `pairs`; the paper's order (31) of the unknowns is right, and the other
order fails.

Source: Van Dooren (1984), as scanned; (8) and (34) by complex rows are our own
findings.
"""

import sympy as sp

from .counts import n, r
from .pairs import interleaved, system_of_a_pair, two_rows
from .rows import Pattern, row_symbols

# The example after (20): stairs 2, 2, 3, 3 and i = 4, as printed.
PRINTED_M4 = """
-1 x x x x x x x x x
0 -1 x x x x x x x x
0 0 -1 x x x x x x x
0 0 X x x x x x x x
0 0 0 X x x x x x x
0 0 0 0 x x x x x x
0 0 0 0 0 X x x x x
0 0 0 0 0 0 X x x x
0 0 0 0 0 0 0 X x x
0 0 0 0 0 0 0 0 X x
0 0 0 0 0 0 0 0 0 X
0 0 0 0 0 0 0 0 0 X
"""


def unsafe(rows):
    """Number of columns whose last nonzero entry is not marked as nonzero for sure."""
    table = [row.split() for row in rows.strip().splitlines()]
    last = [
        [row[c] for row in table if row[c] != "0"][-1] for c in range(len(table[0]))
    ]
    return sp.Integer(sum(entry == "x" for entry in last))


def correct_M4():
    """The same example from the stairs: the marks of every entry of M_4."""
    p = Pattern((2, 2, 3, 3), printed=True)
    M, _ = p.M(3, 0)
    pivots = {(k, k) for k in range(3)}
    pivots |= {(lead - 1, c) for c, lead in enumerate(p.leads) if lead > 3}

    def mark(k, c):
        if M[k, c] == 0:
            return "0"
        return "X" if (k, c) in pivots else "x"

    return "\n".join(
        " ".join(mark(k, c) for c in range(p.n)) for k in range(M.shape[0])
    )


def entries():
    """{place and what is printed: (printed residual, correct residual)}."""
    p, f = Pattern((1, 2)), sp.Symbol("f_ii")
    M, af = p.M(0, f)
    x = row_symbols(p, 0)
    t = sp.Matrix.hstack(sp.eye(1), x[1])
    left = t * p.A - f * t - x[2] * p.C - sp.Matrix.hstack(*x) * M
    square = Pattern((2, 2))
    residual, _, _ = two_rows(square, 0)
    x_b, M_b, known, _ = system_of_a_pair(square, 0).values()
    swapped = sp.Matrix.vstack(residual[1, :], residual[0, :])
    pairs = (n - r) / 2 * (2 * r) * (2 * n) ** 2
    # The vector c = C_k A_21 of stairs (1, 2) belongs to the plant: no unitary state
    # transformation changes it but by a phase.  With both blocks as in (8) its last
    # entry would be zero; with the triangle of A_21 in its last rows it is free.
    c, as_in_8 = sp.Matrix(sp.symbols("c_1 c_2")), Pattern((1, 2), printed=True)
    (C_8, A_8), (C_k, _) = ((q.C[:, 1:], q.A[1:, :1]) for q in (as_in_8, p))
    return {
        "(20) x'M_i = af_i' has lost a minus sign": (
            (left + af).expand(),
            (left - af).expand(),
        ),
        "(31) is right as printed: with row i first it fails": (
            (interleaved(swapped) - x_b * M_b - known).expand(),
            (interleaved(residual) - x_b * M_b - known).expand(),
        ),
        "after (20): column 5 of the example has no safe leading entry": (
            unsafe(PRINTED_M4),
            unsafe(correct_M4()),
        ),
        "(34) 4 (n - 4) r n^2 for 4 (n - r) r n^2": (
            sp.expand(4 * (n - 4) * r * n**2 - pairs),
            sp.expand(4 * (n - r) * r * n**2 - pairs),
        ),
        "(8) cannot hold for a tall stair and C_k with CU = [0 C_k]": (
            (C_8 * A_8 - c)[1],
            (C_k * C_k.LUsolve(c) - c).applyfunc(sp.cancel),
        ),
    }
