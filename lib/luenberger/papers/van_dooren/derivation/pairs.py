"""A conjugate pair of poles in a real observer, where the paper is wrong.

Two rows are solved together, by a system of doubled size.  The paper says that it can
always be solved, as the system of one row can.  That is false wherever the local stair
is one wide, so always for one output: one of the ones in (28) is not free.  The repair:
the pair is one complex row, whose imaginary part brings that entry along as an unknown
`tau`.  A stair one wide gives `tau = b/X`; a wider one leaves `tau` free: 1 will do.

Source: Van Dooren (1984), (26)-(33), remark 1; the complex row, `tau = b/X` and that
the form of the stairs matters are our own.
"""

import sympy as sp
from sympy.matrices import kronecker_product

from matrixproof import Explicit, Page, ZeroMatrix
from matrixproof.lines import Equation, Iff

from .letters import A_U, C_U, T_U, M, N, T_i, a_f, i, letters, n, r, w, x_i
from .rows import Pattern, patterns, picks, row_symbols, triangle

letters = letters.here()
Lam = letters("Lambda", 2, 2, "the block of the pair")
Y = letters("Y", 2, 2, "its eigenvectors")
Delta = letters("Delta", 2, 2, "its eigenvalues on the diagonal")
T_p = letters("T_p", 2, n, "the two rows of `T_U`")
F_p = letters("F_p", 2, n - r, "the two rows of `F`")
f_p = letters("f_p", 2, i, "the unknown entries of these rows before the block")
d_p = letters("d_p", 2, r, "the two rows of `D`")
t_b = letters("t_b", 1, 2 * n, "the two rows of `T_U` in the order of (31)")
K_b = letters("K_b", 2 * n, 2 * n, "the Kronecker products of (33)")
rho = letters("rho", 1, 2 * n, "the two rows of the equation in the order of (31)")
x_b = letters("x_b", 1, 2 * (n + r - 1), "the unknowns, `tau` among them")
M_b = letters("M_b", 2 * (n + r - 1), 2 * n, "the system for the pair, `tau` unknown")
a_b = letters("a_b", 1, 2 * n, "what is known of it")
S_b = letters("S_b", 2 * n, 2 * (n + r - 1), "picks rows that lead columns of `M_b`")
X_b = letters("X_b", 2 * n, 2 * n, "their triangle, each stair entry twice on it")
M_c = letters("M_c", 2 * (n + r) - 3, 2 * n, "the printed system, `tau` put in as one")
S_c = letters("S_c", 2 * n, 2 * (n + r) - 3, "picks rows that lead its columns")
v_i = letters("v_i", n, 1, "a column that `M` sends to one entry")
v_b = letters("v_b", 2 * n, 1, "the same column with zeros in between")
e_i = letters("e_i", n + r - 1, 1, "that entry: the place of `t_(i,i+1)`")
tau = letters("tau", 1, 1, "the entry `t_(i+1,i+1)`, which the paper takes for one")
a_0 = letters("a_0", 1, n, "the row `a_f` for `b = 0`")


PAIRS = ((1, 1, 1), (1, 1, 2), (2, 2), (1, 2, 2), (3, 3))
PART = sp.symbols("a b", real=True)

# -- explicit patterns ----------------------------------------------------------------


def block():
    """The block of (26), and what shows its eigenvalues."""
    a, b = PART
    return {
        Lam: sp.Matrix([[a, -b], [b, a]]),
        Y: sp.Matrix([[1, 1], [-sp.I, sp.I]]),
        Delta: sp.diag(a + sp.I * b, a - sp.I * b),
    }


def interleaved(X):
    """The order of (31): column by column, row i + 1 before row i."""
    return sp.Matrix(1, 2 * X.shape[1], lambda _, k: X[1 - k % 2, k // 2])


def kronecker(p):
    """The Kronecker products of (33)."""
    a, b = PART
    turn = kronecker_product(sp.eye(p.n), sp.Matrix([[0, -b], [b, 0]]))
    return kronecker_product(p.A - a * sp.eye(p.n), sp.eye(2)) - turn


def doubled(p, i):
    """(32), (33) with every row below the first unit entry: tau is an unknown."""
    K, twice = kronecker(p), sp.eye(2)
    above = kronecker_product(p.T_above(i), twice) if i else sp.zeros(0, 2 * p.n)
    rest = kronecker_product(p.C, twice)
    return sp.Matrix.vstack(-above, K[2 * i + 2 :, :], -rest), K[2 * i + 1, :]


def two_rows(p, i):
    """The two rows of the equation, their unknowns, and the rows of T_U."""
    f, t, d = row_symbols(p, i, rows=2)
    T_two = sp.Matrix.hstack(sp.zeros(2, i), sp.Matrix([1, 0]), t)
    residual = T_two * p.A - block()[Lam] * T_two - f * p.T_above(i) - d * p.C
    return residual.expand(), (f, t, d), T_two


def system_of_a_pair(p, i):
    M, known = doubled(p, i)
    residual, unknown, _ = two_rows(p, i)
    x = sp.Matrix.hstack(*map(interleaved, unknown))
    return {x_b: x, M_b: M, a_b: known, rho: interleaved(residual)}


def order_of_a_pair(p, i):
    _, _, T_two = two_rows(p, i)
    turned = (T_two * p.A - block()[Lam] * T_two).expand()
    return {t_b: interleaved(T_two), K_b: kronecker(p), rho: interleaved(turned)}


def both_sides(rows):
    return [2 * k + side for k in rows for side in (0, 1)]


def repaired(p, i):
    """With tau unknown the leading rows make a triangle, whatever the stairs are."""
    M, _ = doubled(p, i)
    lead = both_sides(p.leading(i))
    X = triangle(M, lead, [x for x in p.stair_entries(i) for _ in (0, 1)])
    return {S_b: picks(lead, M.rows), M_b: M, X_b: X}


def as_printed(p, i):
    """The system without the row of tau, which the paper puts in as one."""
    M, _ = doubled(p, i)
    return M.extract([k for k in range(M.rows) if k != 2 * i], list(range(M.cols)))


def printed_and_sound(p, i):
    """A wider stair: the row of tau leads no column, so that it may be left out."""
    lead = [k - (k > 2 * i) for k in both_sides(p.leading(i))]
    M = as_printed(p, i)
    X = triangle(M, lead, [x for x in p.stair_entries(i) for _ in (0, 1)])
    return {S_c: picks(lead, M.rows), M_c: M, X_b: X}


def unseen(p, i):
    """A column that M_i sends to the place of t_(i,i+1), and to nothing else."""
    T_above = p.T_above(i)
    column = sp.zeros(p.n, 1)
    column[i] = 1 / p.A[i + 1, i]
    for k in reversed(range(i)):  # T_i v = 0, from the last row up
        column[k] = -(T_above[k, k + 1 :] * column[k + 1 :, :])[0] / T_above[k, k]
    return column


def entry_that_is_met(p, i):
    M_, a = p.M(i, PART[0])
    place = sp.Matrix(M_.rows, 1, lambda k, _: int(k == i))
    return {M: M_, v_i: unseen(p, i), e_i: place}


def printed_and_singular(p, i):
    column = kronecker_product(unseen(p, i), sp.Matrix([1, 0]))
    return {M_c: as_printed(p, i), v_b: column}


def forced(p, i):
    a, b = PART
    (_, known), (_, real) = p.M(i, a + sp.I * b), p.M(i, a)
    ratio = sp.Matrix([[b / p.A[i + 1, i]]])
    return {a_0: real, a_f: known, v_i: unseen(p, i), tau: ratio}


def over_patterns(values, wanted=lambda p, i: True):
    """{which rows of which stairs: values}, the smallest first."""
    return {
        f"{name}, rows {i + 1}, {i + 2}": values(p, i)
        for name, p in patterns(PAIRS).items()
        for i in range(p.n - p.r - 1)
        if wanted(p, i)
    }


# -- the page -------------------------------------------------------------------------


page = Page(letters=letters, source="Van Dooren (1984), (26)-(33)")

page("""A real plant should have a real observer. For a pair of poles there is a block
    of `F` that is real.""")
says = "the eigenvalues of the block"
page(Explicit("26, remark 1", says, Lam * Y, Y * Delta, {"": block()}))

page("""The rows `i` and `i + 1` of the equation are solved together: what is known on
    the left, unknown `f_p` and `d_p` on the right.""")
is_F = page.suppose(F_p * T_U, f_p * T_i + Lam * T_p, "27")
says = "the two rows of the equation"
start = letters.derive("28, 29", says, T_p * A_U - F_p * T_U - d_p * C_U)
known_left = page(start.use(is_F))
page.chain(
    "28, 29",
    "what is known stands on the left",
    Equation(T_p * A_U - F_p * T_U - d_p * C_U, ZeroMatrix(2, n)),
    Iff(
        Equation(T_p * A_U - Lam * T_p, f_p * T_i + d_p * C_U),
        by=(known_left,),
    ),
)

page("""The page makes one vector of them, row `i + 1` before row `i` in every column,
    and one matrix of Kronecker products.""")
says = "two rows as one, times the Kronecker products"
page(Explicit("31, 33", says, t_b * K_b, rho, over_patterns(order_of_a_pair)))

page("""The rows of that matrix below the known entry, with `T_i` above and `C_U` below
    them, make the system for the pair. Here `tau`, the entry of row `i + 1` above which
    row `i` begins its unknowns, is one of the unknowns.""")
values = over_patterns(system_of_a_pair)
page(Explicit("30, 31, 32", "the system of doubled size", x_b * M_b + a_b, rho, values))

page("It can always be solved: its leading rows make a triangle, as for one row.")
says = "with tau unknown the leading rows make a triangle"
page(Explicit("32", says, S_b * M_b, X_b, over_patterns(repaired)))

page("""The page puts `tau = 1`, as (28) has it, and leaves its row out. That is
    sound where this row leads no column, which is so where the local stair is wider
    than one.""")
says = "where a stair is wide enough the printed rows do as well"
values = over_patterns(printed_and_sound, lambda p, i: not p.one_wide(i))
page(Explicit("32", says, S_c * M_c, X_b, values))

page("""Elsewhere it is wrong. Whether a stair is wide enough depends on its form: the
    stairs (1, 2, 2) pass with the triangle in the last rows of the tall stair, and fail
    with (8) as printed.""")
says = "a column that leads only to the entry beside the one"
values = over_patterns(entry_that_is_met, Pattern.one_wide)
page(Explicit("32", says, M * v_i, e_i, values))
says = "the printed system has no left inverse"
values = over_patterns(printed_and_singular, Pattern.one_wide)
page(Explicit("32", says, M_c * v_b, ZeroMatrix(2 * (n + r) - 3, 1), values))

page("""The pair is one complex row as well: the row `w` turns the block into the pole
    `a + j b`, and the two rows into the system of one row. So no doubled system is
    needed.""")
eigenrow = page.suppose(w * Lam, N * w)
says = "the pair is one complex row"
start = letters.derive("29", says, w * (T_p * A_U - Lam * T_p - f_p * T_i - d_p * C_U))
page(start.expand().use(eigenrow))

page("""Its imaginary part has `tau`. Times that column the system gives the entry
    beside the one, of which `tau` is the imaginary part: `b` over the entry of the
    stair, which is zero only if `b` is. Where the stair is wider `tau` stays free.""")
solved = page.suppose(x_i * M, -a_f, "18")
met = page.suppose(M * v_i, e_i)
start = letters.derive("32", "what the entry beside the one must be", x_i * e_i)
page(start.fold(met).use(solved))
says = "its imaginary part is b over the entry of the stair"
values = over_patterns(forced, Pattern.one_wide)
page(Explicit("32", says, (a_0 - a_f) * v_i, sp.I * tau, values))
