"""All observers with the same poles: what is free in a row, and slopes in it.

With more than one output a row has more unknowns than equations.  Each solution comes
of its own free entries, so that a search over them goes through all solutions.  Beyond
them only the coordinates of the observer's state are open, which the triangles fix.

Source: ours; the rows are those of Van Dooren (1984), (13)-(20), remark 2(b).
"""

import sympy as sp

from matrixproof import Explicit, Identity, Page, ZeroMatrix
from matrixproof.lines import Equation, Iff

from .letters import A_U, C_U, T_U, D, F, I, L, M, S, X, a_f, both, f_i, letters, x_i

n, r, i, s = sp.symbols("n r i s", integer=True, nonnegative=True)
letters = letters.here()
y_i = letters("y_i", 1, n + r - 1, "any row of the same length")
S_t = letters("S^T", n + r - 1, n, "puts the leading entries in their places")
E_r = letters("E_r", r - 1, n + r - 1, "picks the rows of `M` that lead no column")
E_rt = letters("E_r^T", n + r - 1, r - 1, "puts the free entries in their places")
x_l = letters("x_l", 1, n, "the entries of `x_i` that meet the leading rows")
x_r = letters("x_r", 1, r - 1, "the other entries of `x_i`, which are free")
M_r = letters("M_r", r - 1, n, "the rows of `M` that lead no column")
dM = letters("dM", n + r - 1, n, "how `M` moves when the rows above do")
dT_i = letters("dT_i", i, n, "how the rows above move")
dx_i = letters("dx_i", 1, n + r - 1, "how the solution moves")
dx_l = letters("dx_l", 1, n, "its entries that meet the leading rows")
dx_r = letters("dx_r", 1, r - 1, "its free entries")
dJ = letters("dJ", 1, 1, "how a function of the rows moves")
g_l = letters("g_l", n, 1, "its gradient in the leading entries")
g_r = letters("g_r", r - 1, 1, "its gradient in the free entries, the others held")
z_l = letters("z_l", n, 1, "what `X` turns into `g_l`")
W_1 = letters("W_1", s, s, "the first columns of any solution `T U`")
N_1 = letters("N_1", s, s, "a lower triangle that eliminates")
U_1 = letters("U_1", s, s, "a unit upper triangle")
N_T = letters("N_T", n - r, n - r, "a lower triangle with an inverse")
F_N = letters("F_N", n - r, n - r, "`F` in the coordinates that it makes")
F_1 = letters("F_1", s, s, "a lower triangle with poles on its diagonal")
F_2 = letters("F_2", s, s, "the same in other coordinates")
back = letters("Psi", n, n, "the inverse of `Theta`")
dTheta = letters("dTheta", n, n, "how `Theta` moves")
dback = letters("dPsi", n, n, "how its inverse moves")


SIZES = (2, 3)


def lower(name, size, diagonal=None):
    """A lower triangle of symbols."""
    return sp.Matrix(
        size,
        size,
        lambda k, c: (
            0
            if c > k
            else diagonal[k]
            if diagonal and c == k
            else sp.Symbol(f"{name}_{k}_{c}")
        ),
    )


def eliminated(size):
    """Any square matrix, the triangle that eliminates below its diagonal, and the rest.

    Row k of the elimination divides by the leading minor of size k.
    """
    W = sp.Matrix(size, size, lambda k, c: sp.Symbol(f"w_{k}_{c}"))
    N, rest = sp.eye(size), W
    for k in range(size):
        step = sp.eye(size)
        step[k, k] = 1 / rest[k, k]
        for below in range(k + 1, size):
            step[below, k] = -rest[below, k] / rest[k, k]
        N, rest = (step * N).applyfunc(sp.cancel), (step * rest).applyfunc(sp.cancel)
    return {N_1: N, W_1: W, U_1: rest.upper_triangular(1) + sp.eye(size)}


def turned(size):
    """A lower triangle in coordinates of another, with the diagonal that it had."""
    poles = sp.symbols(f"p_:{size}")
    F, N = lower("f", size, poles), lower("n", size)
    other = (N * F * N.inv()).applyfunc(sp.cancel)
    return {N_1: N, F_1: F, F_2: lower_part(other, poles)}


def lower_part(X, diagonal):
    """X with what it should have above its diagonal and on it."""
    return X.lower_triangular(-1) + sp.diag(*diagonal)


page = Page(letters=letters, source="ours")

page("""Take any row and correct it by the left inverse. What comes out solves the
    system of the row.""")
left = page.suppose(L * M, I, "20")
says = "a solution from any row"
page(letters.derive("20", says, (y_i + (-a_f - y_i * M) * L) * M).expand().use(left))

page("""A row that is a solution already stays as it is. So every solution is reached,
    from itself.""")
solves = page.suppose(x_i * M, -a_f, "20")
start = letters.derive("20", "each solution is reached", x_i + (-a_f - x_i * M) * L)
page(start.use(solves))

page("""The left inverse of back substitution corrects the leading entries alone. The
    others, `r - 1` of them, are free, and the leading ones follow by one triangle.""")
whole = page.suppose(S_t * S + E_rt * E_r, Identity(n + r - 1))
is_X = page.suppose(S * M, X, "20")
is_M_r = page.suppose(E_r * M, M_r)
is_x_l = page.suppose(x_i * S_t, x_l)
is_x_r = page.suppose(x_i * E_rt, x_r)
split = page(
    letters.derive("remark 2(b)", "leading and free entries of a row", x_i * M)
    .insert(x_i * (S_t * S + E_rt * E_r) * M, whole)
    .expand()
    .use(is_x_l, is_x_r, is_X, is_M_r)
)
page.chain(
    "remark 2(b)",
    "the leading entries follow",
    Equation(x_i * M, -a_f),
    Iff(Equation(x_l * X + x_r * M_r, -a_f), by=(split,)),
    Iff(Equation(x_l * X, -a_f - x_r * M_r)),
)

page("""Which coordinates has the state of the observer? A lower triangle keeps a lower
    triangle `F`, with its poles in their order.""")
solved = page.suppose(T_U * A_U, F * T_U + D * C_U, "10")
moved = page.suppose(N_T * F, F_N * N_T)
says = "a solution in coordinates of a triangle"
start = letters.derive("11, 12", says, N_T * T_U * A_U - F_N * N_T * T_U)
page(start.use(solved).use(moved))
values = {f"size {size}": turned(size) for size in SIZES}
page(Explicit("11, 12", "the poles stay where they are", N_1 * F_1, F_2 * N_1, values))

page("""And it makes a unit triangle of the first columns of `T_U`, by elimination,
    where their leading minors are not zero. So the rows of (13), (14) reach all
    observers with these poles but those for which a minor is zero, and these may be
    reached with the poles in another order.""")
values = {f"size {size}": eliminated(size) for size in SIZES}
page(Explicit("13", "elimination makes a unit triangle", N_1 * W_1, U_1, values))

page("""A search wants slopes. When rows above move, `M` moves in the rows that hold
    them, and the solution with it. Its leading entries are found with the same
    triangle.""")
moves = page.suppose(dx_i * M + x_i * dM, ZeroMatrix(1, n))
above = page.suppose(x_i * dM, -f_i * dT_i)
is_dx_l = page.suppose(dx_i * S_t, dx_l)
is_dx_r = page.suppose(dx_i * E_rt, dx_r)
followed = page(
    letters.derive("", "how a solution moves", dx_l * X)
    .insert(dx_i * S_t * S * M, is_dx_l, is_X)
    .use(whole)
    .use(moves, is_dx_r, is_M_r)
    .use(above)
)

page("""So one triangle, solved with the gradient on its right, gives the gradient in
    the free entries, and what the row adds to the gradient in the rows above it.""")
is_dJ = page.let(dJ, dx_l * g_l + dx_r * g_r)
is_z = page.suppose(X * z_l, g_l)
start = letters.derive("", "the slope in the free entries and in the rows above", dJ)
page(start.put(is_dJ).insert(dx_l * X * z_l + dx_r * g_r, is_z).use(followed).factor())

page("The condition of `Theta` depends on its inverse, which moves as follows.")
inverse = page.suppose(both * back, I)
held = page.suppose(dback * both + back * dTheta, ZeroMatrix(n, n))
start = letters.derive("", "how the inverse moves", dback)
page(start.insert(dback * both * back, inverse).use(held))
