"""The state from the fewest samples: outputs, less what the inputs contribute.

In Kawazoe's coordinates the outputs of the coming samples are the state itself, but
for the inputs.  What holds for every size is proved in letters; the whole is
evaluated at several index patterns, with outputs that are run symbol by symbol.

Source: Kawazoe (1978), (15)-(26).
"""

import sympy as sp

from matrixproof import BlockMatrix, Explicit, Identity, Page, ZeroMatrix

from .form import is_h, is_w, named, over_patterns, shifts
from .letters import E_0, E_n, G, H, P, Phi, Phi_l, e_i, e_v, letters, u, w, y

n, m, r, s = sp.symbols("n m r s", integer=True, nonnegative=True)
p_i = sp.Symbol("p_i", integer=True, positive=True)
letters = letters.here()
y_o = letters("y_o", n - m, 1, "the outputs from the next sample on")
w_o = letters("w_o", n - m, 1, "`w` without the first entries of its blocks")
Delta = letters("Delta", n - m, s, "the blocks of (25) below each other")
u_p = letters("u_p", s, 1, "the inputs of the samples")
Phi_next = letters("Phi_l_next", n, n, "`Phi` to the power `l + 1`")
w_l = letters("w_l", n, 1, "state `l` samples on")
s_l = letters("s_l", n, 1, "what the inputs have added in `l` samples")
s_next = letters("s_l_next", n, 1, "what they have added in `l + 1` samples")
s_0 = letters("s_0", n, 1, "what they have added before the first sample")
s_1 = letters("s_1", n, 1, "what they have added in one sample")
y_l = letters("y_l", m, 1, "measurement `l` samples on")
Gam_l = letters("Gamma_l", n, s, "`Phi^(l-1) G`, ..., `Phi G`, `G` side by side")
Gam_next = letters("Gamma_l_next", n, s + r, "the same one sample on")
u_next = letters("u_next", s + r, 1, "the inputs of the samples, and one more")
e_l = letters("e_l", 1, n, "picks entry `l + 1` of block `i`")
e_ln = letters("e_l_next", 1, n, "picks the entry after it")
f_l = letters("f_l", 1, n - m, "says which row of `E_0` it is")
g_l = letters("g_l", 1, r, "that row of `G`")
K = letters("K", n, n, "the rows `h_i Phi^l` for `l < p_i`")
y_s = letters("y_s", n, 1, "the outputs `i` at `p_i` samples, stacked")
d_s = letters("d_s", n, 1, "what the inputs contribute to them")
Y_b = letters("Y_b", p_i, 1, "output `i` at `p_i` samples")
D_b = letters("D_b", p_i, s, "what the inputs contribute to it")
w_b = letters("w_b", p_i, 1, "block `i` of `w`")
w_v = letters("w_v_i", p_i - 1, 1, "that block without its first entry")
Y_i = letters("Y_i", p_i - 1, 1, "output `i` from the next sample on")
Delta_i = letters("Delta_i", p_i - 1, s, "what the inputs contribute to it")
e_1 = letters("e_1", 1, p_i, "picks the first entry of a block")
E_v = letters("E_v", p_i - 1, p_i, "picks its other entries")
O_s = letters("O_s", s, n, "the rows `C_i A^k` of one sample less")
M_s = letters("M_s", s, n - 1, "says which combinations of kept rows they are")
E_r = letters("E_r", n - 1, n, "picks the rows of `P` but that one")
e_k = letters("e_k", 1, n, "picks the last row of the longest block")
b = letters("b", n, 1, "a state that only that row sees")


INPUTS = 2  # concrete number r of inputs

# -- explicit patterns ----------------------------------------------------------------


def toeplitz(rows, samples):
    """(25) for one output: row j = [g_(v+j), ..., g_(v+1), 0, ...].

    `rows` are the rows of G of one block; there is a block row for each of them but
    the last, and a block column for each of u_k .. u_(k + p_M - 2).
    """
    blocks = [
        [rows[j - c, :] if c <= j else 0 * rows[0, :] for c in range(samples - 1)]
        for j in range(rows.rows - 1)
    ]
    empty = sp.zeros(0, rows.cols * (samples - 1))
    return sp.Matrix.vstack(empty, *(sp.Matrix.hstack(*row) for row in blocks))


def inputs_of_16(of, G_, u, i, k):
    """The input term of (15), (16): h_i sum Phi^j G u, of output i after k samples."""
    terms = (of.H[i, :] * of.Phi ** (k - 1 - j) * G_ * u[j] for j in range(k))
    return sum(terms, sp.zeros(1, 1))[0].expand()


def window(of):
    """The outputs of p_M samples, run symbol by symbol, and what makes them."""
    u = [
        sp.Matrix([sp.Symbol(f"u_{i + 1}^{k}") for i in range(INPUTS)])
        for k in range(of.samples)
    ]
    G_, state = named("g", of.n, INPUTS), sp.Matrix(sp.symbols(f"w_1:{of.n + 1}"))
    start, outputs = state, []
    for now in u:
        outputs.append(of.H * state)
        state = (of.Phi * state + G_ * now).expand()
    pairs = [(i, k) for i, size in enumerate(of.indices) for k in range(size)]
    later = [at for at, (_, k) in enumerate(pairs) if k]
    stacked = sp.Matrix([outputs[k][i] for i, k in pairs])
    blocks = [G_[head:end, :] for head, end in zip(of.heads, of.ends)]
    return {
        y_s: stacked,
        d_s: sp.Matrix([inputs_of_16(of, G_, u, *pair) for pair in pairs]),
        w: start,
        y_o: stacked.extract(later, [0]),
        Delta: sp.Matrix.vstack(*(toeplitz(rows, of.samples) for rows in blocks)),
        u_p: sp.Matrix.vstack(*u[:-1]),
        w_o: start.extract(later, [0]),
    }


def of_window(*wanted):
    return over_patterns(lambda of: {letter: window(of)[letter] for letter in wanted})


# -- the page -------------------------------------------------------------------------


page = Page(letters=letters, source="Kawazoe (1978), (15)-(26)")

page("""The plant in Kawazoe's coordinates. Output `i` is the first entry of block `i`,
    so `m` entries of `w` are read.""")
is_y = page.let(y, H * w, "10")
page(is_h)
page(letters.derive("18", "what is read", e_i * y).put(is_y).use(is_h))

page("""A later output shows the state of the moment, and what the inputs since have
    added.""")
later = page.let(w_l, Phi_l * w + s_l, "15")
powers = page.let(Phi_next, Phi * Phi_l)
added = page.let(s_next, Phi * s_l + G * u, "15")
start = letters.derive("15", "one more sample", Phi * w_l + G * u)
page(start.put(later).expand().fold(powers, added))
is_y_l = page.let(y_l, H * w_l, "10")
page(letters.derive("15", "a later output", y_l).put(is_y_l, later).expand())

page("""What the inputs add is a sum, after any number of samples: the powers of `Phi`
    times `G` side by side, times all inputs. After one sample it is `G` times the
    input.""")
nothing = page.suppose(s_0, ZeroMatrix(n, 1))
once = page.let(s_1, Phi * s_0 + G * u, "15")
one_sample = page(letters.derive("15", "the sum of one sample", once).use(nothing))
longer = page.let(Gam_next, BlockMatrix([[Phi * Gam_l, G]]))
stacked = page.let(u_next, BlockMatrix([[u_p], [u]]))
with page.scope(letters.suppose(s_l, Gam_l * u_p, "15")) as summed:
    start = letters.derive("15", "the sum of one sample more", Gam_next * u_next)
    one_more = page(start.multiply(longer, stacked).fold(summed).fold(added))
page.induction(
    "15",
    "the sum of any number of samples",
    summed,
    base=one_sample,
    step=one_more,
    first={s_l: s_1, Gam_l: G, u_p: u},
    then={s_l: s_next, Gam_l: Gam_next, u_p: u_next},
)

page("""Take output `i`. After `l` samples the state is seen through `e_v Phi^l`. As
    long as entry `l + 1` of the block is not its last, one more `Phi` moves the one in
    that row on by one entry.""")
so_far = page.suppose(e_v * Phi_l, e_l, "16")
commute = page.suppose(Phi * Phi_l, Phi_l * Phi)
row_of_G = page.let(g_l, e_l * G, "13")
is_next = page.let(e_ln, f_l * E_n, "6")
with page.scope(letters.suppose(e_l, f_l * E_0, "6")) as not_last:
    start = letters.derive("11", "a one moves on by one entry", e_l * Phi)
    moves = page(start.put(not_last).use(shifts).fold(is_next))
    says = "the coefficient moves on by one entry"
    start = letters.derive("16", says, e_v * Phi_next)
    page(start.put(powers).use(commute).use(so_far).use(moves))

    page("""So do the contributions of the inputs: an input that has moved an entry of
        the block, with a row `g_l` of `G`, has moved the entry before it one sample
        later.""")
    says = "a row of the contributions from the next one"
    start = letters.derive("25", says, e_l * s_next)
    page(start.put(added).expand().use(moves).fold(row_of_G))

page("""By induction from `l = 0`, where both are `e_v`, that is so for every `l < p_i`:
    the output shows one entry of the state. `K` has the coefficients of all of them as
    rows. Each is the row of the identity, so `K` is the identity.""")
start = letters.derive("16", "an output after some samples", e_i * y_l)
shown = page(start.put(is_y_l).use(is_h).put(later).expand().use(so_far))
is_K = page.suppose(e_l * K, e_v * Phi_l, "16")
start = letters.derive("16", "the coefficients of the state", e_l * K)
page(start.use(is_K).use(so_far))

page("Hence the state is these outputs, less what the inputs contribute.")
start = letters.derive("17, 20", "an entry of the state", e_i * y_l - e_v * s_l)
page(start.use(shown))

page("""What the inputs contribute to a block is a matrix `D_b` times them. Its first
    row is zero, since the first entry is read; the other rows are `Delta_i`, and `Y_i`
    has the outputs from the next sample on.""")
is_block = page.let(w_b, Y_b - D_b * u_p, "17")
is_w_v = page.let(w_v, E_v * w_b, "23")
is_Y_i = page.let(Y_i, E_v * Y_b, "24")
is_Delta = page.let(Delta_i, E_v * D_b, "25")
start = letters.derive("22, 23, 24", "what is computed of a block", w_v)
page(start.put(is_w_v, is_block).expand().fold(is_Y_i, is_Delta))

page("What is read and what is computed make the block.")
together = page.suppose(e_1.T * e_1 + E_v.T * E_v, Identity(p_i))
start = letters.derive("18, 23", "both together are the block", w_b)
page(start.insert((e_1.T * e_1 + E_v.T * E_v) * w_b, together).expand().fold(is_w_v))

page("""Written out, all of it is as follows, with inputs that differ at every sample.
    Each block of `Delta` is a lower block Toeplitz matrix.""")
says = "the state from outputs and inputs"
page(Explicit("16, 17", says, y_s - d_s, w, of_window(y_s, d_s, w)))
says = "what is computed of all blocks"
values = of_window(y_o, Delta, u_p, w_o)
page(Explicit("20, 22, 25", says, y_o - Delta * u_p, w_o, values))

page("""That takes `p_M` samples, the largest of the indices, and no fewer. The last row
    of the longest block was kept. The rows of one sample less come before it in the
    search, so they are combinations of the other rows of `P`. The last row alone sees
    the state `b`, and they do not.""")
is_b = page.let(b, P.I * e_k.T, "21")
before = page.suppose(O_s, M_s * E_r * P, "6")
others = page.suppose(E_r * e_k.T, ZeroMatrix(n - 1, 1), "6")
start = letters.derive("21", "one sample less is not enough", O_s * b)
page(start.put(before, is_b).use(others))
alone = page.suppose(e_k * e_k.T, Identity(1), "6")
page(letters.derive("21", "the last row sees it", e_k * P * b).put(is_b).use(alone))

page("The state of the plant follows from that of its coordinates.")
page(is_w)
page(letters.derive("26", "the way back", P.I * w).put(is_w).expand())
