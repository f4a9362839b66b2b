"""Moore's own route, (8)-(13): the functional as a sequence with a recurrence.

In observable companion form `T` is a Krylov matrix, so that `S T' = 0` by Cayley and
Hamilton.  So `k` is a combination of its rows exactly if `S k' = 0`: the entries of `k`
obey the recurrence whose polynomial is `beta`.  In any coordinates they are `k A^i g`,
where `g` is the state that `C`, `C A` and so on, but the last of `n` rows, do not see.

Source: Moore (1973), (2), (8)-(13); the sequence in other coordinates is our own.
"""

import sympy as sp

from matrixproof import Construction, Explicit, Line, Page

from .letters import *

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


def pattern(size, order):
    """S and T of (9), (11) with the coefficients of the observer's own polynomial."""
    F_, t_ = observer_pair(order)
    return {S: recurrence_rows(characteristic(F_), size), T: krylov(F_, t_, size)}


def behind_the_cut(size, order):
    return {S_2: recurrence_rows(named_beta(order), size)[:, order:]}


def in_another_unit(size, order):
    """S and kappa where time is measured in units of tau, and what that multiplies."""
    tau, beta_ = sp.Symbol("tau", positive=True), named_beta(order)
    scaled = [b / tau ** (order - j) for j, b in enumerate(beta_)]
    sequence = sp.Matrix(sp.symbols(f"kappa_:{size}"))
    return {
        S_T: recurrence_rows(scaled, size),
        k_T: sp.diag(*(tau**-i for i in range(size))) * sequence,
        Lam: sp.diag(*(tau ** -(i + order) for i in range(size - order))),
        S: recurrence_rows(beta_, size),
        kappa: sequence,
    }


# -- the page -------------------------------------------------------------------------

no_entry, no_column = ZeroMatrix(1, 1), ZeroMatrix(r, 1)


page = Page(letters=letters, source=f"{SOURCE}, (2), (8)-(13)")

page("""In observable companion form the plant moves every entry down by one, and the
    last column has the coefficients of its polynomial. The one output is the last
    entry.""")
is_A = page(suppose(A, Z - alpha * c, "2"))

page("""Let `T` have the columns `t_1`, `F t_1`, and so on up to `F^(n-1) t_1`. Its
    columns moved to the left by one are its columns times `F`, except for the last; and
    `D` is minus the plant's polynomial at `F`, times `t_1`.""")
columns = page(suppose(T * Z, F * T - f * c, "9"))
is_D = page(let(D_1, -(f + T * alpha), "8"))
page.chain(
    "5, 8, 9",
    "these solve the equation",
    T * A - F * T,
    Line(T * Z - T * alpha * c - F * T, by=(is_A,)),
    Line(-f * c - T * alpha * c, by=(columns,)),
    Line(D_1 * c, by=(is_D,)),
)

page("Nothing else does, for the equation moves the columns of `T` in the same way.")
solved = page(suppose(T * A, F * T + D_1 * c, "5"))
page.chain(
    "5, 9",
    "nothing else solves it",
    T * Z,
    Line(T * A + T * alpha * c, by=(is_A,)),
    Line(F * T + (D_1 + T * alpha) * c, by=(solved,)),
)

page("""Let `beta` be the polynomial of `F`. The first row of `S` gives `T S'` the
    column `beta(F) t_1`, which is zero by Cayley and Hamilton. Every further row of `S`
    is the one before it, moved by one place; the one before it ends with a zero.""")
next_row = page(let(s_in, Z * s_i, "11"))
ends = page(suppose(c * s_i, no_entry, "11"))
gone = page(suppose(T * s_i, no_column))
page.chain(
    "11, 12",
    "one row after the other",
    T * s_in,
    Line(T * Z * s_i, by=(next_row,)),
    Line(F * T * s_i - f * c * s_i, by=(columns,)),
    Line(no_column, by=(gone, ends)),
)
page(
    Explicit(
        "11, 12",
        "all rows, written out",
        S * T.T,
        ZeroMatrix(n - r, r),
        at_sizes(pattern),
        why="Cayley and Hamilton",
    )
)

page("If `k` is a combination of the rows of `T`, its entries obey the recurrence.")
read = page(suppose(k, P * T, "7"))
annihilated = page(suppose(T * S.T, ZeroMatrix(r, n - r)))
page.chain(
    "10",
    "a combination of rows obeys the recurrence",
    k * S.T,
    Line(P * T * S.T, by=(read,)),
    Line(ZeroMatrix(1, n - r), by=(annihilated,)),
)

page("""Conversely let `k` obey it. Cut `S`, `T` and `k` behind column `r`. The cut
    makes `T_1` a controllability matrix, which has an inverse, and `S_2` a triangle
    with ones on its diagonal.""")
page(
    Explicit(
        "11",
        "the last columns have the determinant one",
        sp.Determinant(S_2),
        sp.S.One,
        at_sizes(behind_the_cut),
    )
)
cut_T = page(suppose(T_2 * S_2.T, -T_1 * S_1.T))
cut_k = page(suppose(k_2 * S_2.T, -k_1 * S_1.T))
continued = page.chain(
    "10",
    "the recurrence continues both alike",
    k_1 * T_1.I * T_2,
    Line(k_1 * T_1.I * T_2 * S_2.T * S_2.T.I, why="put in an inverse"),
    Line(-k_1 * T_1.I * T_1 * S_1.T * S_2.T.I, by=(cut_T,)),
    Line(-k_1 * S_1.T * S_2.T.I, why="the inverse cancels"),
    Line(k_2 * S_2.T * S_2.T.I, by=(cut_k,)),
    Line(k_2, why="the inverse cancels"),
)
read_1 = page(suppose(P * T_1, k_1, "7"))
read_2 = page(suppose(P * T_2, k_2, "7"))
page(
    Construction(
        "10",
        "so k is a combination of the rows",
        {P: k_1 * T_1.I},
        satisfies=(read_1, read_2),
        by=(continued,),
    )
)

page("""In other coordinates there is a state `g` that `C`, `C A`, up to `C A^(n-2)` do
    not see, while `C A^(n-1) g` is one. The columns `g`, `A g`, and so on take the
    plant to the form above, because `A^n g` is a combination of them by Cayley and
    Hamilton.""")
moved = page(suppose(K * Z, A * K - g_n * c))
hamilton = page(suppose(g_n, -K * alpha, "12"))
is_form = page(suppose(A_o, Z - alpha * c, "2"))
page.chain(
    "1, 2",
    "the plant in observable companion form",
    K * A_o,
    Line(K * Z - K * alpha * c, by=(is_form,)),
    Line(A * K - g_n * c - K * alpha * c, by=(moved,)),
    Line(A * K, by=(hamilton,)),
)

page("""So Moore's entries of `k` are the numbers `k A^i g`. They are also what the
    observer answers to `T g`, since the output does not see `A^i g` for `i < n -
    1`.""")
next_g = page(let(g_in, A * g_i))
hidden = page(suppose(c_1 * g_i, no_entry))
solved_1 = page(suppose(T * A, F * T + D_1 * c_1, "5"))
page.chain(
    "10",
    "what is tracked moves as the observer does",
    T * g_in,
    Line(T * A * g_i, by=(next_g,)),
    Line(F * T * g_i + D_1 * c_1 * g_i, by=(solved_1,)),
    Line(F * T * g_i, by=(hidden,)),
)

page("""The first row of `S` turns these columns into `beta(A) g`, and each further row
    is the one before it moved by one place. So row `i` of the recurrence says that `k
    beta(A) A^i g` is zero: the condition for any number of outputs, beside the states
    that `C`, `C A`, up to `C A^(r-1)` do not see.""")
page.chain(
    "13",
    "one row of the recurrence after the other",
    K * s_in,
    Line(K * Z * s_i, by=(next_row,)),
    Line(A * K * s_i - g_n * c * s_i, by=(moved,)),
    Line(A * K * s_i, by=(ends,)),
)

page("""Time can be measured in any unit. With a unit of `tau` the sequence is divided
    by powers of `tau`, the coefficients as well, and so is each row.""")
page(
    Explicit(
        "13",
        "another unit of time divides each row",
        S_T * k_T,
        Lam * S * kappa,
        at_sizes(in_another_unit),
    )
)
