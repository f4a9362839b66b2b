"""Van Dooren's rows of T A - F T = D C, and what is true of a conjugate pair.

Each row of the unknowns solves a linear system whose matrix M_i is in column echelon
form: the rows that lead its columns make a triangle, so M_i has a left inverse.  The
paper says the same of the doubled system (30)-(33) for a conjugate pair a +- jb.
That is false wherever the local stair is one wide, so always for one output: a
vector v with M_i v = e shows that one unit entry, t_{i+1,i+1} = 1, was not free.
The repair: the pair is one complex row with f = a + jb, whose imaginary part brings
tau = t_{i+1,i+1} along as an unknown.  Its matrix is M_i again, so it can always be
solved; a one wide stair gives tau = b / X with X the stair's entry, which is zero
only for b = 0, and a wider one leaves tau free, so 1 will do.

The claims are proved at concrete sizes with symbolic entries.  Rows and columns are
counted from 0 here.

Source: Van Dooren (1984), (7)-(34); the complex row and tau = b / X are our own.
"""

from functools import cache

import sympy as sp
from sympy.matrices import kronecker_product

from ....symbolic import Claim, Derivation

STAIRS = ((1, 1, 1), (1, 2), (2, 2), (1, 1, 2), (1, 2, 3), (2, 3))
PAIRS = ((1, 1, 1), (1, 1, 2), (1, 2, 2), (2, 2), (3, 3))


class Pattern:
    """A_U, C_U of (7) with symbolic entries, for stairs r_1 <= ... <= r_k.

    ``printed=True`` is (8), every block [R; 0]; otherwise a tall block has its
    triangle in its last rows, which needs no transformation of the outputs.
    """

    def __init__(self, stairs, printed=False):
        self.stairs, self.n, self.r = stairs, sum(stairs), stairs[-1]
        n, r = self.n, self.r
        both = sp.zeros(n + r, n)
        self.leads = []
        start = end = 0
        for width, below in zip(stairs, (*stairs[1:], r)):
            start, end = end, end + width
            for c in range(start, end):
                lead = end + (c - start) + (0 if printed else below - width)
                self.leads.append(lead)
                for k in range(lead + 1):
                    both[k, c] = sp.Symbol(f"{'X' if k == lead else 'a'}_{k}_{c}")
        self.A, self.C = both[:n, :], both[n:, :]

    def T_above(self, i):
        """Rows 0 .. i-1 of T: triangular, with any diagonal that is not zero."""
        return sp.Matrix(
            i,
            self.n,
            lambda k, c: 0 if c < k else sp.Symbol(f"t_{k}_{c}", nonzero=c == k),
        )

    def M(self, i, f):
        """M_i of (18), and the right side af_i' of (19)."""
        shifted = self.A - f * sp.eye(self.n)
        M = sp.Matrix.vstack(-self.T_above(i), shifted[i + 1 :, :], -self.C)
        return M, shifted[i, :]

    def leading(self, i):
        """For column c, the row of M_i that leads it."""
        return list(range(i)) + [lead - 1 for lead in self.leads[i:]]

    def one_wide(self, i):
        """Whether column i is led by row i + 1: the local stair is one wide."""
        return self.leads[i] == i + 1


def row_symbols(p, i, rows=1):
    """f_i', t_i', d_i' as symbols, for one row or for the two of a pair."""
    f, t, d = (
        sp.Matrix(rows, size, lambda k, c, name=name: sp.Symbol(f"{name}_{k}_{c}"))
        for name, size in (("f", i), ("tau", p.n - i - 1), ("d", p.r))
    )
    return f, t, d


def row_steps(p, name):
    """(15)-(20): row i of T A - F T = D C is x' M_i = -af_i', and M_i is echelon."""
    f = sp.Symbol("f_ii")
    steps = {}
    for i in range(p.n - p.r):
        M, af = p.M(i, f)
        x = row_symbols(p, i)
        t = sp.Matrix.hstack(sp.zeros(1, i), sp.eye(1), x[1])
        residual = t * p.A - f * t - x[0] * p.T_above(i) - x[2] * p.C
        system = sp.Matrix.hstack(*x) * M + af
        where = f"stairs {name}, row {i}"
        steps[f"(16),(18) the row is x'M_i + af_i' = 0, {where}"] = Claim(
            residual.expand(), system.expand()
        )
        lead = M.extract(p.leading(i), list(range(p.n)))
        steps[f"(18) M_i has {p.n + p.r - 1} x {p.n} entries, {where}"] = Claim(
            sp.Matrix(M.shape), sp.Matrix([p.n + p.r - 1, p.n])
        )
        steps[f"(20) the leading rows of M_i make a triangle, {where}"] = Claim(
            lead, lead.upper_triangular()
        )
        entries = [-p.T_above(i)[k, k] for k in range(i)]
        entries += [
            (p.A if lead < p.n else -p.C)[lead % p.n, c]
            for c, lead in enumerate(p.leads)
            if c >= i
        ]
        steps[f"(20) with the stair's entries on its diagonal, {where}"] = Claim(
            sp.Matrix(entries), lead.diagonal().T
        )
    return steps


def interleaved(X):
    """The order of (31): column by column, row i + 1 before row i."""
    return sp.Matrix(1, 2 * X.shape[1], lambda _, k: X[1 - k % 2, k // 2])


def doubled(p, i, a, b):
    """(32), (33) with every row below the first unit entry: tau is an unknown."""
    turn = sp.Matrix([[0, -b], [b, 0]])
    K = kronecker_product(p.A - a * sp.eye(p.n), sp.eye(2)) - kronecker_product(
        sp.eye(p.n), turn
    )
    C = kronecker_product(p.C, sp.eye(2))
    T = kronecker_product(p.T_above(i), sp.eye(2)) if i else sp.zeros(0, 2 * p.n)
    return sp.Matrix.vstack(-T, K[2 * i + 2 :, :], -C), K[2 * i + 1, :]


def pair_steps(p, name):
    """(26)-(33): the doubled system, where it fails, and its repair."""
    a, b = sp.symbols("a b", real=True)
    block = sp.Matrix([[a, -b], [b, a]])
    steps = {}
    for i in range(p.n - p.r - 1):
        where = f"stairs {name}, rows {i} and {i + 1}"
        f, t, d = row_symbols(p, i, rows=2)
        T = sp.Matrix.hstack(sp.zeros(2, i), sp.Matrix([1, 0]), t)
        residual = T * p.A - block * T - f * p.T_above(i) - d * p.C
        Mb, first = doubled(p, i, a, b)
        system = sp.Matrix.hstack(*map(interleaved, (f, t, d))) * Mb + first
        steps[f"(29),(30) the pair is xb' Mb = -ab', tau unknown, {where}"] = Claim(
            interleaved(residual).expand(), system.expand()
        )
        M, af = p.M(i, a + sp.I * b)
        x = sp.Matrix.hstack(f, t, d)
        complex_row = (x[0, :] + sp.I * x[1, :]) * M + af
        steps[f"(29) it is one complex row of (18) with f = a + jb, {where}"] = Claim(
            complex_row.expand(), (residual[0, :] + sp.I * residual[1, :]).expand()
        )
        lead = [2 * k + side for k in p.leading(i) for side in (0, 1)]
        square = Mb.extract(lead, list(range(2 * p.n)))
        entries = p.M(i, 0)[0].extract(p.leading(i), list(range(p.n))).diagonal()
        diagonal = sp.diag(*[x for x in entries for _ in (0, 1)])
        steps[f"(32) repaired: leading rows make a triangle, entries X, {where}"] = (
            Claim(square.lower_triangular(), diagonal)
        )
        steps |= (
            one_wide(p, i, Mb, af, b, where) if p.one_wide(i) else wide(p, i, where)
        )
    return steps


def one_wide(p, i, Mb, af, b, where):
    """A vector that the printed Mb sends to zero, and the tau that is forced."""
    M, _ = p.M(i, 0)
    X = p.A[i + 1, i]
    T = p.T_above(i)
    v = sp.zeros(p.n, 1)
    v[i] = 1 / X
    for k in reversed(range(i)):  # T_i v = 0, from the last row up
        v[k] = -(T[k, k + 1 :] * v[k + 1 :, :])[0] / T[k, k]
    e = sp.zeros(M.shape[0], 1)
    e[i] = 1
    there = sp.zeros(Mb.shape[0], 1)
    there[2 * i] = 1  # the row of tau, which the paper takes as known and leaves out
    t = -(af * v)[0] * X  # X times the entry t_(i,i+1) + j tau of the complex row
    half = kronecker_product(v, sp.Matrix([1, 0]))
    return {
        f"(32) one wide: M_i v = e at the row of t_(i,i+1), {where}": Claim(
            (M * v).applyfunc(sp.cancel), e
        ),
        f"(32) one wide: the printed Mb has rank below 2n, Mb v = 0, {where}": Claim(
            (Mb * half).applyfunc(sp.cancel), there
        ),
        f"(32) one wide: tau X = b, so tau is zero only if b is, {where}": (
            sp.expand(t - t.subs(b, 0) - sp.I * b)
        ),
    }


def wide(p, i, where):
    """Row i + 1 leads no column: it may be left out, that is, tau may be chosen."""
    return {
        f"(32) wider stair: the row of tau leads no column, so tau = 1, {where}": (
            sp.Integer(p.leading(i).count(i))
        )
    }


n, r, m, j, i = sp.symbols("n r m j i", positive=True, integer=True)


def counts():
    """Multiply-adds: the paper's, and those of what is done here."""
    reflector = 2 * r * (n - j)  # r entries, applied to the columns that follow
    narrow = sp.summation(2 * r * (n - i - j), (j, 0, n - i - 1))
    return {
        "(21) one M_i": r * n**2,
        "(21) reflectors of r entries": sp.summation(reflector, (j, 0, n - 1)),
        "(22) all rows": (n - r) * r * n**2,
        "all rows, on the columns that are not yet triangular": sp.summation(
            narrow, (i, 0, n - r - 1)
        ),
        "(23) staircase": (3 * n + r) * n**2,
        "staircase, as done": sp.Rational(8, 3) * n**3,
        "(25) P": n**2 * m + (n - r) * n * m,
        "(25) [G; H]": n**3 / 2,
        "(34) conjugate pairs, doubled real systems": 4 * (n - r) * r * n**2,
        "conjugate pairs, complex rows": 2 * (n - r) * r * n**2,
    }


def count_steps():
    """The leading terms agree, and what is saved."""
    c = counts()
    share = c["all rows, on the columns that are not yet triangular"]
    leading = lambda x, y: sp.limit(x / y, n, sp.oo)  # noqa: E731
    return {
        "(21) reflectors of r entries cost r n^2 to leading order": Claim(
            leading(c["(21) reflectors of r entries"], c["(21) one M_i"]), sp.Integer(1)
        ),
        "(22) without the triangular columns: a third of it": Claim(
            leading(share, c["(22) all rows"]), sp.Rational(1, 3)
        ),
        "(34) a complex row instead of the doubled system: half of it": Claim(
            2 * c["conjugate pairs, complex rows"],
            c["(34) conjugate pairs, doubled real systems"],
        ),
    }


def formulas():
    """The definitions of one small case, stairs (1, 2), for reading."""
    p = Pattern((1, 2))
    M, af = p.M(0, sp.Symbol("f_ii"))
    return {"(7) A_U": p.A, "(7) C_U": p.C, "(17) M_1": M, "(19) af_1'": af} | counts()


@cache
def derive():
    steps = count_steps()
    for stairs in STAIRS:
        steps |= row_steps(Pattern(stairs), f"{stairs}")
        steps |= row_steps(Pattern(stairs, printed=True), f"{stairs} as in (8)")
    for stairs in PAIRS:
        steps |= pair_steps(Pattern(stairs), f"{stairs}")
    return Derivation(
        formulas=formulas(), steps=steps, source="Van Dooren (1984), section 3"
    )
