"""The rows of the observer, one after the other: each solves a linear system.

`T_U` is a unit triangle, so half of (10) is true before one begins.  A row of the other
half contains no row of `T_U` below it.  With the rows above it known, it is linear in
what is left.  Its matrix can be solved for every pole, because the rows that lead its
columns make a triangle.  So an observer with any spectrum exists: it is constructed.

Source: Van Dooren (1984), (13)-(21), remark 2(b).
"""

import sympy as sp

from matrixproof import BlockMatrix, Explicit, Page, ZeroMatrix
from matrixproof.explicit import Construction
from matrixproof.lines import Equation, Iff

from .letters import (
    A_U,
    C_U,
    T_U,
    I,
    L,
    M,
    S,
    T_i,
    X,
    a_f,
    both,
    d,
    f,
    f_i,
    letters,
    t,
    x_i,
)

n, r, i = sp.symbols("n r i", integer=True, nonnegative=True)
letters = letters.here()
t_i = letters("t_i", 1, n - i - 1, "the unknown entries of that row")
e = letters("e", 1, n, "picks the row")
E = letters("E", n - i - 1, n, "picks the rows below it")
L_f = letters("L_f", n, n, "the identity times the pole `f_ii`")
A_f = letters("A_f", n - i - 1, n, "the rows of `A_U - f_ii I` below it")
R = letters("R", n, n, "the triangle of the factorisation, which has an inverse")
Q = letters("Q", n + r - 1, n, "orthonormal columns, which span those of `M`")
Qs = letters("Q^*", n, n + r - 1, "its conjugate transpose")
Rs = letters("R^*", n, n, "the conjugate transpose of `R`")
a_star = letters("a_f^*", n, 1, "the conjugate transpose of `a_f`")
h = letters("h", 1, n + r - 1, "what can be added to a solution")
h_star = letters("h^*", n + r - 1, 1, "its conjugate transpose")
C_k = letters("C_k", r, r, "the columns of `C_U` that are not zero")


STAIRS = ((1, 2), (1, 1, 1), (2, 2), (1, 1, 2), (1, 2, 3), (2, 3))

# -- explicit patterns ----------------------------------------------------------------


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

    def stair_entries(self, i):
        """What leads the columns of M_i."""
        entries = [-self.T_above(i)[k, k] for k in range(i)]
        lead = zip(range(i, self.n), self.leads[i:])
        sides = ((self.A if k < self.n else -self.C)[k % self.n, c] for c, k in lead)
        return [*entries, *sides]

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


def patterns(stairs=STAIRS):
    """{name: Pattern} of each list of stairs, in the library's form and as in (8)."""
    found = {f"stairs {widths}": Pattern(widths) for widths in stairs}
    tall = [widths for widths in stairs if len(set(widths)) > 1]
    as_in_8 = {f"stairs {w} as in (8)": Pattern(w, printed=True) for w in tall}
    return found | as_in_8


def picks(rows, total):
    """The rows of the identity that pick the given rows of a matrix."""
    return sp.Matrix(len(rows), total, lambda k, c: int(c == rows[k]))


def triangle(M, rows, diagonal):
    """The given rows of M above the diagonal, on it what must stand there."""
    upper = M.extract(rows, list(range(len(rows)))).upper_triangular(1)
    return upper + sp.diag(*diagonal)


def leading_rows():
    """M, what picks its leading rows, and their triangle, for each row of a pattern."""
    found, pole = {}, sp.Symbol("f")
    for name, p in patterns().items():
        for k in range(p.n - p.r):
            M_, _ = p.M(k, pole)
            lead = p.leading(k)
            X_ = triangle(M_, lead, p.stair_entries(k))
            found[f"{name}, row {k + 1}"] = {S: picks(lead, M_.rows), M: M_, X: X_}
    first = "stairs (1, 1, 2), row 2"  # the smallest with a row above and one to spare
    return {first: found[first]} | found


def compound(stairs):
    """T_U above C_U, and the columns of C_U that are not zero."""
    p = Pattern(stairs, printed=True)
    rows = []
    for k in range(p.n - p.r):
        entries = row_symbols(p, k)[1]
        rows.append(sp.Matrix.hstack(sp.zeros(1, k), sp.eye(1), entries))
    return {both: sp.Matrix.vstack(*rows, p.C), C_k: p.C[:, p.n - p.r :]}


# -- the page -------------------------------------------------------------------------

unknowns = BlockMatrix([[f_i, t_i, d]])
system = BlockMatrix([[-T_i], [A_f], [-C_U]])


page = Page(letters=letters, source="Van Dooren (1984), section 3, to (21)")

page("""Look for `T_U` as a triangle with ones on its diagonal. Whatever its other
    entries are, `T_U` above `C_U` is then invertible, because `C_k` is.""")
says = "the determinant is that of the outputs"
values = {f"stairs {stairs}": compound(stairs) for stairs in STAIRS[:3]}
page(Explicit("10, 13", says, sp.Determinant(both), sp.Determinant(C_k), values))

page("""Row `i` of `F` has unknown entries, the pole `f_ii`, and zeros. Row `i` of `T_U`
    has zeros, a one, and unknown entries. So no row of `T_U` below it takes part.""")
is_f = page.suppose(f * T_U, f_i * T_i + t * L_f, "14")
is_t = page.suppose(t, e + t_i * E, "14")
is_a = page.suppose(e * (A_U - L_f), a_f, "19")
is_A_f = page.suppose(E * (A_U - L_f), A_f, "19")
says = "a row of the equation is linear in what is left"
start = letters.derive("15, 16, 18", says, t * A_U - f * T_U - d * C_U)
row = page(
    start.use(is_f)
    .put(is_t)
    .expand()
    .use(is_a, is_A_f)
    .insert(a_f + unknowns * system, why="collect the unknowns")
)

page("""In the first row there is no `f_i` and no `T_i`. With a letter for the unknowns
    and one for the matrix, it is one linear system for each row. The paper has lost a
    minus sign here.""")
is_x = page.suppose(unknowns * system, x_i * M, "18")
page.chain(
    "17, 20",
    "the system of one row",
    Equation(t * A_U - f * T_U - d * C_U, ZeroMatrix(1, n)),
    Iff(Equation(a_f + x_i * M, ZeroMatrix(1, n)), by=(row, is_x)),
    Iff(Equation(x_i * M, -a_f)),
)

page("""In every column of `M` the last entry that is not zero is `-1` or an entry of a
    stair, each in a row of its own. These rows make a triangle whose diagonal does not
    contain the pole.""")
says = "the rows that lead the columns make a triangle"
page(Explicit("18, 20", says, S * M, X, leading_rows()))

page("So the system can be solved, whatever the pole is.")
picked = page.suppose(S * M, X, "20")
left = page.suppose(L * M, I, "20")
says = "a left inverse"
page(Construction("20", says, {L: X.I * S}, satisfies=(left,), by=(picked,)))

page("""That is back substitution: it costs less than anything else, uses the rows of
    the stairs alone, and may give a sensitive solution.""")
says = "a solution by back substitution"
page(letters.derive("remark 2(b)", says, -a_f * X.I * S * M).use(picked))

page("The solution of least norm uses all rows. It comes from a factorisation.")
factors = page.suppose(M, Q * R, "21")
orthonormal = page.suppose(Qs * Q, I, "21")
start = letters.derive("21", "a solution from the factors", -a_f * R.I * Qs * M)
page(start.put(factors).use(orthonormal))

page("""Every other solution differs by an `h` with `h M = 0`, so that `h Q = 0`. It is
    longer by `h h^*`.""")
no_part = page.suppose(h * Q, ZeroMatrix(1, n))
no_part_too = page.suppose(Qs * h_star, ZeroMatrix(n, 1))
says = "no solution is shorter"
start = letters.derive("21", says, (h - a_f * R.I * Qs) * (h_star - Q * Rs.I * a_star))
page(start.expand().use(no_part, no_part_too, orthonormal))
