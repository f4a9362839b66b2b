"""The deadbeat observer: Van Dooren's recursion with every pole at zero.

Sorted by level, Kawazoe's coordinates are a staircase whose stairs hold the ones of
(11).  Each row block of `T A - F T = D C` is solved column by column, with zero
diagonal blocks in `F`: it has the subdiagonal of `A` and nothing else.  The entries of
`T` and `D` are polynomials in `phi`, so nothing is divided.  Numbers with VD are those
of Van Dooren (1984).

Source: Kawazoe (1978), (11)-(14); Van Dooren (1984), (4), (7), (13)-(20).
"""

import sympy as sp

from matrixproof import Explicit, Identity, Page, ZeroMatrix
from matrixproof.explicit import Construction

from .form import over_patterns, picks
from .letters import Phi, letters, m, n, p_i, q, r_c, r_h, r_n

letters = letters.here()
Pi = letters("Pi", n, n, "sorts the entries of `w` by level, the highest first")
A_U = letters("A_U", n, n, "`Phi` in these coordinates: a staircase")
C_U = letters("C_U", m, n, "`H` in these coordinates: only the last columns")
T_U = letters("T_U", n - m, n, "what the observer tracks in them: a unit triangle")
S_U = letters("S_U", n, n, "`T_U` above `C_U`")
F = letters("F", n - m, n - m, "moves the observer's state")
F_l = letters("F_l", n - m, n - m, "`F` to the power `l`")
D = letters("D", n - m, m, "what the measurement does to it")
S_i = letters("S_i", p_i, n - m, "picks a row block")
S_h = letters("S_h", r_h, n - m, "picks the row block above it")
S_1 = letters("S_1", m, n - m, "picks the first row block")
T_i = letters("T_i", p_i, n, "that row block of `T_U`")
T_h = letters("T_h", r_h, n, "the row block above it")
D_i = letters("D_i", p_i, m, "that row block of `D`")
A_i = letters("A_i", p_i, r_h, "the stair to the left of the diagonal in these rows")
N_c = letters("N_c", n, r_c, "picks a column block")
N_n = letters("N_n", n, r_n, "picks the column block after it")
N_m = letters("N_m", n, m, "picks the last column block")
K_c = letters("K_c", n, q, "picks the columns up to that block")
A_c = letters("A_c", q, r_c, "the column block of `A_U`, down to the diagonal")
A_m = letters("A_m", n, m, "its last column block")
S_c = letters("S_c", r_n, r_c, "the stair below the diagonal")
J_c = letters("J_c", r_c, r_n, "a left inverse of it")
T_c = letters("T_c", p_i, q, "the entries of the row block up to there")
T_n = letters("T_n", p_i, r_n, "the entries that come next")
T_hc = letters("T_h_c", r_h, r_c, "the row block above, in the column block")
T_hm = letters("T_h_m", r_h, m, "the row block above, in the last column block")
x_i = letters("x_i", 1, n + m - 1, "the entries of one row: of `F`, of `T_U`, of `D`")
M_i = letters("M_i", n + m - 1, n, "the matrix of Van Dooren's (18)")
a_f = letters("a_f", 1, n, "the row of `A_U`")


# -- explicit patterns ----------------------------------------------------------------


def levels(indices):
    """Which outputs have a row C_i A^k, for each power k, the highest first."""
    powers = reversed(range(max(indices)))
    return [[i for i, size in enumerate(indices) if size > k] for k in powers]


def by_level(of):
    """The staircase of a pattern, and what sorts its coordinates."""
    top, has = of.samples - 1, levels(of.indices)
    order = [of.heads[i] + top - k for k, own in enumerate(has) for i in own]
    turn = picks(order, of.n)
    return {Pi: turn, Phi: of.Phi, A_U: turn * of.Phi * turn.T}


def units(of):
    """A left inverse of each stair: output i's row is the unit of output i."""
    has = levels(of.indices)
    return [
        picks([below.index(i) for i in above], len(below))
        for above, below in zip(has, has[1:])
    ]


def observer(of):
    """T, F and D, row block by row block."""
    A_, sizes = by_level(of)[A_U], [len(own) for own in levels(of.indices)]
    at = [sum(sizes[:i]) for i in range(len(sizes) + 1)]
    blocks = [slice(*pair) for pair in zip(at, at[1:])]
    last, order, inverses = len(sizes) - 1, at[-2], units(of)
    T_, F_, D_ = sp.zeros(order, of.n), sp.zeros(order), sp.zeros(order, of.m)
    for i, me in enumerate(blocks[:last]):
        T_[me, me], above = sp.eye(sizes[i]), slice(at[i - 1] if i else 0, at[i])
        if i:
            F_[me, above] = A_[me, above]
        for c in range(i, last + 1):
            here, known = blocks[c], slice(at[i], at[c + 1])
            rest = F_[me, above] * T_[above, here] - T_[me, known] * A_[known, here]
            if c < last:
                T_[me, blocks[c + 1]] = (rest * inverses[c]).expand()
            else:
                D_[me, :] = -rest.expand()
    C_ = sp.zeros(of.m, order).row_join(sp.eye(of.m))
    return {T_U: T_, A_U: A_, F: F_, D: D_, C_U: C_}


def stacked(of):
    found = observer(of)
    return {S_U: found[T_U].col_join(found[C_U])}


def one_row(of, k):
    """The entries of row k, and the matrix of Van Dooren's (18) with f_kk = 0."""
    found = observer(of)
    T_, A_, F_, D_, C_ = found.values()
    return {
        x_i: sp.Matrix.hstack(F_[k, :k], T_[k, k + 1 :], D_[k, :]),
        M_i: sp.Matrix.vstack(-T_[:k, :], A_[k + 1 :, :], -C_),
        a_f: A_[k, :],
    }


def rows():
    """`one_row` of each pattern and row, one that has a row above it first."""
    chosen = over_patterns(lambda of: [one_row(of, k) for k in range(of.n - of.m)])
    found = [
        (f"{name}, row {k + 1}", one)
        for name, each in chosen.items()
        for k, one in enumerate(each)
    ]
    return dict(sorted(found, key=lambda pair: "row 2" not in pair[0]))


# -- the page -------------------------------------------------------------------------

row_block = T_i * A_U - A_i * T_h - D_i * C_U


page = Page(
    letters=letters, source="Kawazoe (1978), with the rows of Van Dooren (1984)"
)

page("""Sort Kawazoe's coordinates by level, those with the highest power of `A` first.
    This is a staircase: below the diagonal it has the ones that move each row to the
    next, and nothing else. The outputs are the last entries.""")
page(Explicit("11", "a staircase of ones", Pi * Phi, A_U * Pi, over_patterns(by_level)))

page("""The observer is found block by block; `S_i` picks one row block of it, and `S_h`
    the one above. `F` is chosen as the part of `A_U` below the diagonal: in these rows
    it has the stair `A_i` alone, in the columns of the block above. The first row block
    has none above it, and no part in `F`.""")
is_T_i = page.suppose(S_i * T_U, T_i)
is_T_h = page.suppose(S_h * T_U, T_h)
is_D_i = page.suppose(S_i * D, D_i)
below = page.suppose(S_i * F, A_i * S_h)
says = "one row block of the equation"
start = letters.derive("VD 4, 10", says, S_i * (T_U * A_U - F * T_U - D * C_U))
page(start.expand().use(below).use(is_T_i, is_T_h, is_D_i))

page("""Take it column block by column block. A column block of `A_U` has entries down
    to the diagonal, and below it one stair. So it meets the entries of the row block
    that are known, and those that come next.""")
reaches = page.suppose(A_U * N_c, K_c * A_c + N_n * S_c)
unseen = page.suppose(C_U * N_c, ZeroMatrix(m, r_c))
is_T_c = page.suppose(T_i * K_c, T_c)
is_T_n = page.suppose(T_i * N_n, T_n)
is_T_hc = page.suppose(T_h * N_c, T_hc)
start = letters.derive("VD 10", "one column block of it", row_block * N_c)
page(start.expand().use(reaches, unseen).use(is_T_c, is_T_n, is_T_hc))

page("""The columns of a stair are independent, so it has a left inverse. That gives
    what comes next; with a stair of ones it is a matter of picking rows.""")
wanted = page.suppose(T_c * A_c + T_n * S_c, A_i * T_hc)
inverse = page.suppose(J_c * S_c, Identity(r_c))
page(
    Construction(
        "VD 10",
        "the next entries of the row block",
        {T_n: (A_i * T_hc - T_c * A_c) * J_c},
        satisfies=(wanted,),
        by=(inverse,),
    )
)

page("The library takes these entries.")
is_next = page.suppose(T_n, (A_i * T_hc - T_c * A_c) * J_c, "VD 10")

page("The last column block, the one that is measured, says what `D` is.")
is_A_m = page.suppose(A_U * N_m, A_m)
is_T_hm = page.suppose(T_h * N_m, T_hm)
measured = page.suppose(C_U * N_m, Identity(m))
start = letters.derive("VD 10", "the column block that is measured", row_block * N_m)
page(start.expand().use(is_A_m, is_T_hm, measured))

page("This block of the equation is to hold, too.")
holds = page.suppose(row_block * N_m, ZeroMatrix(p_i, m), "VD 10")
start = letters.derive("VD 10", "the gain of the measurement", D_i)
gain = page(start.by(T_i * A_m - A_i * T_hm, holds, is_A_m, is_T_hm, measured))

next_entries = page.program(
    "the next entries of a row block of T",
    (A_i, T_hc, T_c, A_c, J_c),
    (is_next, "(VD 10)"),
)
measured_gain = page.program(
    "a row block of D", (A_i, T_hm, T_i, A_m), (gain, "(VD 10)")
)

page("Written out, with a symbol for every entry of `Phi` that may differ from zero:")
says = "the observer"
page(Explicit("VD 4, 10", says, T_U * A_U - F * T_U, D * C_U, over_patterns(observer)))

page("""`T_U` is a unit triangle. So `T_U` above `C_U` is invertible: no state is left
    out.""")
says = "the determinant is one"
page(Explicit("VD 13", says, sp.Determinant(S_U), sp.S.One, over_patterns(stacked)))

page("""`F` has zeros on its diagonal. So each row solves Van Dooren's system with the
    pole zero: the deadbeat observer is his, with all poles at zero.""")
page(Explicit("VD 18, 20", "each row solves his system", x_i * M_i, -a_f, rows()))

page("""That all poles are zero only says that `F` vanishes after `n - m` steps. It does
    so earlier. The first block is zero at once. If a power of it is zero in the block
    above, the next power is zero in this one.""")
at_once = page.suppose(S_1 * F, ZeroMatrix(m, n - m))
first_block = page(letters.derive("", "the first block is zero", S_1 * F).use(at_once))
with page.scope(letters.suppose(S_h * F_l, ZeroMatrix(r_h, n - m))) as gone:
    start = letters.derive("", "one more power and one more block", S_i * F * F_l)
    next_block = page(start.use(below).use(gone))
page.induction(
    "",
    "each power is zero in one more block",
    gone,
    base=first_block,
    step=next_block,
    first={S_h: S_1, F_l: F},
    then={S_h: S_i, F_l: F * F_l},
)

page("""There are `p_M - 1` blocks, and `F` is zero after as many steps. So the observer
    is exact from sample number `p_M` on, whatever it began with.""")
