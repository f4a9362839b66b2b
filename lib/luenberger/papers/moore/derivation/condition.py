"""When there is an observer without feedthrough: a condition on its poles alone.

(5) and `P T = k` leave `T` to be eliminated.  In companion coordinates `T` is built
from `k` row by row, and `T A - F T = D C` can fail in one row only.  Conversely every
observer obeys what that row says, by Cayley and Hamilton.  All of it holds in any
coordinates, for any number of outputs and for a polynomial in factors.

Source: Moore (1973), (5), (10), (12), (13); this form of them is our own.
"""

from matrixproof import Page, ZeroMatrix

from .letters import A, C, D, F, P, T, k, letters, n, o, p, r, t

letters = letters.here()
N = letters("N", r, r, "moves the rows of a matrix up by one; the last becomes zero")
L = letters("L", r, r, "coefficients, each in the column of its factor's first row")
e_i = letters("e_i", 1, r, "picks row `i`")
e_next = letters("e_next", 1, r, "picks row `i + 1`; zero behind the last row")
e_f = letters("e_f", 1, r, "picks the first row of the factor")
h_f = letters("h_f", 1, n, "`h` at the first row of the factor")
s_f = letters("s_f", 1, n, "`s` at the first row of the factor")
t_next = letters("t_next", 1, n, "row `i + 1` of `T`")
b = letters("b", 1, 1, "coefficient of the polynomial beside row `i`")
d = letters("d", 1, p, "row `i` of `D`")
h = letters("h", 1, n, "`k` times the polynomial down to row `i`, at `A`")
h_next = letters("h_next", 1, n, "the same down to row `i + 1`")
s = letters("s", 1, n, "combination of the rows of `C`, `C A`, ...")
s_next = letters("s_next", 1, n, "the same down to row `i + 1`")
O = letters("O", o, n, "the rows of `C`, `C A`, ..., one below the other")
d_all = letters("d_all", 1, o, "the rows of `D` side by side")
X = letters("X", n, 1, "a state that these rows do not see")
Q = letters("Q", r, r, "change of coordinates to companion form")
q = letters("q", 1, r, "row `i` of it: `P` times the polynomial so far, at `F`")
q_next = letters("q_next", 1, r, "row `i + 1` of it; `P beta(F)` behind the last")


page = Page(letters=letters, source="Moore (1973), (5), (10), (12), (13)")

page("""Let `F` be a companion form: `N` moves rows up, and row `i` of `L` has one
    coefficient `b` of the polynomial, in the column of the first row. A polynomial in
    factors has a block for each of them, which feeds the block before it; then the
    first row of the factor is meant.""")
is_F = page.let(F, N - L)
up = page.suppose(e_i * N, e_next)
coefficient = page.suppose(e_i * L, b * e_f)
first = page.suppose(e_f * T, k, "7")
is_t = page.suppose(e_i * T, t)
is_d = page.suppose(e_i * D, d)
start = letters.derive("5", "what one row says", e_i * (T * A - F * T - D * C))
row = page(start.put(is_F).expand().use(is_t, is_d, up, coefficient).use(first))

page("""So every row of `T` follows from the row above it. The first is `k`, because `P`
    reads the first state; behind the last there is none, and the row that would follow
    must be zero.""")
tracked = page.suppose(T * A, F * T + D * C, "5")
is_t_next = page.let(t_next, e_next * T)
step = page(
    letters.derive("5", "a row from the row above it", t_next)
    .put(is_t_next)
    .insert(t * A + b * k - d * C - e_i * (T * A - F * T - D * C), row)
    .use(tracked)
)

page("""Row after row that is Horner's scheme for `k beta(A)`, less what `D` takes away.
    The first row has `h = k` and `s = 0`; if a row is `h - s`, so is the next. With one
    factor `h_f = k` and `s_f = 0` throughout.""")
closed = page.suppose(t, h - s)
closed_first = page.suppose(k, h_f - s_f)
is_h_next = page.let(h_next, h * A + b * h_f)
is_s_next = page.let(s_next, s * A + b * s_f + d * C)
start = letters.derive("13", "all rows by Horner's scheme", t_next)
page(start.put(step).put(closed, closed_first).expand().fold(is_h_next, is_s_next))

page("""Behind the last row `h` is `k beta(A)`, and `s` is a combination of the rows of
    `C`, `C A`, up to `C A^(r-1)`, with coefficients `D` that are free. So an observer
    with the polynomial `beta` exists if `k beta(A)` is such a combination. Whether it
    is, shows beside the states that none of these rows see.""")
is_s = page.suppose(s, d_all * O)
unseen = page.suppose(O * X, ZeroMatrix(o, 1))
start = letters.derive("13", "beside what is not seen", (h - s) * X)
page(start.put(is_s).expand().use(unseen))

page("""Every observer obeys the condition. Take any `F`, `P` with the polynomial
    `beta`, and rows that begin with `q = P` and go on as follows. This loses nothing,
    because they turn `F`, `P` into companion form.""")
is_q_next = page.let(q_next, q * F + b * P)
is_q = page.suppose(e_i * Q, q)
heads = page.suppose(e_f * Q, P)
follows = page.suppose(e_next * Q, q_next)
page(
    letters.derive("12", "these rows lead to companion form", e_i * (N - L) * Q)
    .expand()
    .use(up, coefficient)
    .use(follows, heads)
    .put(is_q_next)
    .expand()
    .fold(is_q)
)

page("""Applied to `T` they obey the rule above, with `d = q D`. Behind the last row `q`
    is `P beta(F)`, again by Horner's scheme, which is zero by Cayley and Hamilton. So
    `k beta(A)` is a combination of those rows.""")
read = page.suppose(P * T, k, "7")
own = page.suppose(q * T, t)
page(
    letters.derive("10, 13", "an observer's own rows follow the same rule", q_next * T)
    .put(is_q_next)
    .expand()
    .insert(q * (T * A - D * C) + b * P * T, tracked)
    .use(own, read)
)


companion_row = page.program(
    "one row of T from the row above it", (t, A, b, k, d, C), (step, "(5)")
)
