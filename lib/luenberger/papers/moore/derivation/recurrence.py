"""Moore's own route, (8)-(13): the functional as a sequence with a recurrence.

In observable companion form `T` is a Krylov matrix, so that `S T' = 0` by Cayley and
Hamilton, for every order.  So `k` is a combination of its rows exactly if `S k' = 0`:
the entries of `k` obey the recurrence whose polynomial is `beta`.  In any coordinates
they are `k A^i g`, where `g` is the state that `C`, `C A` and so on, but the last of
`n` rows, do not see.

Source: Moore (1973), (2), (8)-(13); the sequence in other coordinates is our own.
"""

import sympy as sp

from matrixproof import Identity, Page, ZeroMatrix
from matrixproof.explicit import Construction

from .letters import D_1, A, F, P, S, T, beta, c, k, kappa, letters, n, r

letters = letters.here()
alpha = letters("alpha", n, 1, "coefficients of the plant's polynomial, from `alpha_0`")
Z = letters("Z", n, n, "moves entries down by one, and columns to the left")
f = letters("f", r, 1, "`F^n t_1`, which would be the next column of `T`")
f_r = letters("f_r", r, 1, "`F^r t_1`, the column behind `T_1`")
i_1 = letters("i_1", n - r, 1, "picks the first row of `S`")
c_r = letters("c_r", 1, r, "the last row of the identity of the observer's order")
Z_r = letters("Z_r", r, r, "moves entries down by one")
F_c = letters("F_c", r, r, "`F` in companion form")
N_b = letters("N_b", n - r, n - r, "what `S_2` has beside the ones of its diagonal")
X_j = letters("X_j", n - r, n - r, "the first `j` terms of the inverse of `S_2`")
X_jn = letters("X_j_next", n - r, n - r, "one term more")
W_j = letters("W_j", n - r, n - r, "`-N_b` to the power `j`")
W_jn = letters("W_j_next", n - r, n - r, "`-N_b` to the power `j + 1`")
s_i = letters("s_i", n, 1, "row `i` of `S`, as a column")
s_in = letters("s_i_next", n, 1, "row `i + 1` of `S`, as a column")
S_1 = letters("S_1", n - r, r, "the first columns of `S`")
S_2 = letters("S_2", n - r, n - r, "the other columns of `S`")
T_1 = letters("T_1", r, r, "the first columns of `T`, a controllability matrix")
T_2 = letters("T_2", r, n - r, "the other columns of `T`")
k_1 = letters("k_1", 1, r, "the first entries of `k`")
k_2 = letters("k_2", 1, n - r, "the other entries of `k`")
g_i = letters("g_i", n, 1, "`A^i g`; `C` does not see it for `i < n - 1`")
g_in = letters("g_i_next", n, 1, "`A^(i+1) g`")
g_n = letters("g_n", n, 1, "`A^n g`")
c_1 = letters("c_1", 1, n, "the row of `C`, for one output, in any coordinates")
A_o = letters("A_o", n, n, "`A` in observable companion form")
K = letters("K", n, n, "the columns `g`, `A g`, ..., `A^(n-1) g`")
s_T = letters("s_tau", n, 1, "row `i` of `S` in another unit of time, as a column")
s_Tn = letters("s_tau_next", n, 1, "row `i + 1` of it, as a column")
k_T = letters("kappa_tau", n, 1, "the sequence in another unit of time")
tau = letters.scalar("tau", "the unit of time", positive=True)
lam = letters.scalar("lambda", "a power of `1/tau`", positive=True)
Lam = letters("Lambda", n, n, "the powers 0, 1, ... of `1/tau`, on the diagonal", True)


SIZES = ((4, 2), (2, 1), (3, 1), (3, 2), (5, 3), (6, 4))  # (n, r)

# -- explicit patterns ----------------------------------------------------------------


def observable_form(size):
    """A and c of (1), (2): the last column of A is -alpha, c = [0 ... 0 1]."""
    alpha = sp.symbols(f"alpha_:{size}")
    A = sp.Matrix(size, size, lambda i, j: int(i == j + 1))
    A[:, -1] = -sp.Matrix(alpha)
    return A, sp.Matrix(1, size, lambda _, j: int(j == size - 1)), alpha


def observer_pair(order):
    """F and t, from r = 2 on companion F and t = [1 0 ..]'.

    A controllable (F, t) can be brought to that form, so nothing is lost.
    """
    if order == 1:
        return sp.Matrix([[sp.Symbol("f")]]), sp.Matrix([sp.Symbol("t")])
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


def recurrence_rows(beta, size):
    """(11): n - r rows, each beta_0, ..., beta_(r-1), 1 one place further on."""
    order = len(beta) - 1
    rows = [[0] * i + [*beta] + [0] * (size - order - 1 - i) for i in range(size)]
    return sp.Matrix(size - order, size, sum(rows[: size - order], []))


def named_beta(order, **assumed):
    return [*sp.symbols(f"beta_:{order}", **assumed), sp.S.One]


def at_sizes(values, sizes=SIZES):
    """{"n = .., r = ..": values(n, r)}."""
    return {f"n = {size}, r = {order}": values(size, order) for size, order in sizes}


# -- the page -------------------------------------------------------------------------

no_entry, no_column, one = ZeroMatrix(1, 1), ZeroMatrix(r, 1), Identity(n - r)


page = Page(letters=letters, source="Moore (1973), (2), (8)-(13)")

page("""In observable companion form the plant moves every entry down by one, and the
    last column has the coefficients of its polynomial. The one output is the last
    entry.""")
is_A = page.suppose(A, Z - alpha * c, "2")

page("""Let `T` have the columns `t_1`, `F t_1`, and so on up to `F^(n-1) t_1`. Its
    columns moved to the left by one are its columns times `F`, except for the last; and
    `D` is minus the plant's polynomial at `F`, times `t_1`.""")
columns = page.suppose(T * Z, F * T - f * c, "9")
is_D = page.let(D_1, -(f + T * alpha), "8")
start = letters.derive("5, 8, 9", "these solve the equation", T * A - F * T)
page(start.put(is_A).expand().use(columns).fold(is_D))

page("Nothing else does, for the equation moves the columns of `T` in the same way.")
solved = page.suppose(T * A, F * T + D_1 * c, "5")
start = letters.derive("5, 9", "nothing else solves it", T * Z)
page(start.insert(T * (A + alpha * c), is_A).expand().use(solved).collect(c))

page("""Let `beta` be the polynomial of `F`. The first row of `S`, `i_1` picks it, gives
    `T S'` the column `beta(F) t_1`, which is zero by Cayley and Hamilton. Every further
    row of `S` is the one before it, moved by one place; the one before it ends with a
    zero.""")
first_row = page.suppose(T * S.T * i_1, T_1 * beta.T + f_r, "11")
cayley = page.suppose(f_r, -T_1 * beta.T, "12")
start = letters.derive("11, 12", "the first row of all", T * S.T * i_1)
first = page(start.use(first_row).put(cayley).expand())
next_row = page.let(s_in, Z * s_i, "11")
ends = page.suppose(c * s_i, no_entry, "11")
with page.scope(letters.suppose(T * s_i, no_column)) as gone:
    start = letters.derive("11, 12", "one row after the other", T * s_in)
    further = page(start.put(next_row).use(columns).use(gone, ends))

page.induction(
    "11, 12",
    "every column of `T S'` is zero",
    gone,
    base=first,
    step=further,
    first={s_i: S.T * i_1},
    then={s_i: s_in},
)

page("""So `T S'` is zero. If `k` is a combination of the rows of `T`, its entries obey
    the recurrence.""")
read = page.suppose(k, P * T, "7")
annihilated = page.suppose(T * S.T, ZeroMatrix(r, n - r), "12")
start = letters.derive("10", "a combination of rows obeys the recurrence", k * S.T)
page(start.put(read).use(annihilated))

page("""A controllable `F`, `t_1` has a companion form. `t_1` to `F^(r-1) t_1`, the
    first columns `T_1` of `T`, are independent, and take `F` to it.""")
shifted = page.suppose(T_1 * Z_r, F * T_1 - f_r * c_r, "2")
is_F_c = page.let(F_c, Z_r - beta.T * c_r, "2")
start = letters.derive("2", "the observer in companion form", T_1 * F_c)
page(start.put(is_F_c).expand().use(shifted).put(cayley).expand())

page("""Conversely let `k` obey the recurrence. Cut `S`, `T` and `k` behind column `r`.
    The cut makes `T_1`, which has an inverse, and `S_2`, a triangle with ones on its
    diagonal. What it has beside them, `N_b`, vanishes after `n - r` steps. So it has an
    inverse, a sum of as many terms: each term more leaves a power more, until nothing
    is left.""")
is_S_2 = page.suppose(S_2, one + N_b, "11")
start = letters.derive("11", "one term leaves one power", S_2 * one)
one_term = page(start.put(is_S_2).by(one - -N_b))
more = page.let(X_jn, one - N_b * X_j)
power = page.let(W_jn, -N_b * W_j)
with page.scope(letters.suppose(S_2 * X_j, one - W_j)) as so_far:
    start = letters.derive("11", "one term more leaves one power more", S_2 * X_jn)
    another = page(start.by(one - W_jn, is_S_2, more, so_far, power))
page.induction(
    "11",
    "the last columns have an inverse",
    so_far,
    base=one_term,
    step=another,
    first={X_j: one, W_j: -N_b},
    then={X_j: X_jn, W_j: W_jn},
)
cut_T = page.suppose(T_2 * S_2.T, -T_1 * S_1.T)
cut_k = page.suppose(k_2 * S_2.T, -k_1 * S_1.T)
start = letters.derive("10", "the recurrence continues both", k_1 * T_1.I * T_2 * S_2.T)
alike = page(start.use(cut_T).fold(cut_k))
start = letters.derive("10", "the recurrence continues both alike", k_1 * T_1.I * T_2)
continued = page(start.insert(k_2 * S_2.T * S_2.T.I, alike).expand())
read_1 = page.suppose(P * T_1, k_1, "7")
read_2 = page.suppose(P * T_2, k_2, "7")
says = "so k is a combination of the rows"
page(
    Construction(
        "10", says, {P: k_1 * T_1.I}, satisfies=(read_1, read_2), by=(continued,)
    )
)

page("""In other coordinates there is a state `g` that `C`, `C A`, up to `C A^(n-2)` do
    not see, while `C A^(n-1) g` is one. The columns `g`, `A g`, and so on take the
    plant to the form above, because `A^n g` is a combination of them by Cayley and
    Hamilton.""")
moved = page.suppose(K * Z, A * K - g_n * c)
hamilton = page.suppose(g_n, -K * alpha, "12")
is_form = page.suppose(A_o, Z - alpha * c, "2")
start = letters.derive("1, 2", "the plant in observable companion form", K * A_o)
page(start.put(is_form).expand().use(moved).put(hamilton).expand())

page("""So Moore's entries of `k` are the numbers `k A^i g`. They are also what the
    observer answers to `T g`, since the output does not see `A^i g` for `i < n -
    1`.""")
next_g = page.let(g_in, A * g_i)
hidden = page.suppose(c_1 * g_i, no_entry)
solved_1 = page.suppose(T * A, F * T + D_1 * c_1, "5")
start = letters.derive("10", "what is tracked moves as the observer does", T * g_in)
page(start.put(next_g).use(solved_1).use(hidden))

page("""The first row of `S` turns these columns into `beta(A) g`, and each further row
    is the one before it moved by one place. So row `i` of the recurrence says that `k
    beta(A) A^i g` is zero: the condition for any number of outputs, beside the states
    that `C`, `C A`, up to `C A^(r-1)` do not see.""")
start = letters.derive("13", "one row of the recurrence after the other", K * s_in)
page(start.put(next_row).use(moved).use(ends))

page("""Time can be measured in any unit. With a unit of `tau` the sequence is divided
    by powers of `tau`, and `Lambda` has them on its diagonal. Row `i` with coefficients
    in this unit is called `s_tau`. By induction from the first row, whose coefficients
    are divided by powers as well, each row is that of before, divided by a number.""")
turns = page.suppose(Lam * Z, Z * Lam / tau)
scaled = page.let(k_T, Lam * kappa)
further = page.let(s_Tn, Z * s_T, "11")
with page.scope(letters.suppose(Lam * s_T, lam * s_i, "13")) as divided:
    says = "another unit of time divides the next row"
    start = letters.derive("13", says, Lam * s_Tn)
    page(start.put(further).use(turns).use(divided).fold(next_row))
    start = letters.derive("13", "another unit of time divides each row", s_T.T * k_T)
    page(start.put(scaled).use(divided))
