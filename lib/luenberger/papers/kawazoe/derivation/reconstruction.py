"""The state from the fewest samples: outputs, less what the inputs contribute.

In Kawazoe's coordinates the outputs of the coming samples are the state itself, but
for the inputs.  What holds for every size is proved in letters; the whole is
evaluated at several index patterns, with outputs that are run symbol by symbol.

Source: Kawazoe (1978), (15)-(26).
"""

import sympy as sp

from matrixproof import Explicit, Line, Page

from .form import is_h, is_w, named, over_patterns, picks
from .letters import *

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


def coefficients(of):
    rows = [of.H[i, :] * of.Phi**k for i in range(of.m) for k in range(of.indices[i])]
    return {K: sp.Matrix.vstack(*rows)}


def one_sample_less(of):
    rows = [of.H * of.Phi**k for k in range(of.samples - 1)]
    end = of.ends[of.indices.index(of.samples)] - 1
    return {O_s: sp.Matrix.vstack(*rows), b: picks([end], of.n).T}


# -- the page -------------------------------------------------------------------------


page = Page(letters=letters, source=f"{SOURCE}, (15)-(26)")

page("""The plant in Kawazoe's coordinates. Output `i` is the first entry of block `i`,
    so `m` entries of `w` are read.""")
is_y = page(let(y, H * w, "10"))
page(is_h)
page.chain(
    "18",
    "what is read",
    e_i * y,
    Line(e_i * H * w, by=(is_y,)),
    Line(e_v * w, by=(is_h,)),
)

page("""A later output shows the state of the moment, and what the inputs since have
    added.""")
later = page(let(w_l, Phi_l * w + s_l, "15"))
powers = page(let(Phi_next, Phi * Phi_l))
added = page(let(s_next, Phi * s_l + G * u, "15"))
page.chain(
    "15",
    "one more sample",
    Phi * w_l + G * u,
    Line(Phi * Phi_l * w + Phi * s_l + G * u, by=(later,)),
    Line(Phi_next * w + s_next, by=(powers, added)),
)
is_y_l = page(let(y_l, H * w_l, "10"))
page.chain(
    "15",
    "a later output",
    y_l,
    Line(H * w_l, by=(is_y_l,)),
    Line(H * Phi_l * w + H * s_l, by=(later,)),
)

page("""Take output `i`. As long as `l < p_i`, each further `Phi` moves the one in `e_v`
    on by one entry.""")
so_far = page(suppose(e_v * Phi_l, e_l))
commute = page(suppose(Phi * Phi_l, Phi_l * Phi))
moves = page(suppose(e_l * Phi, e_ln, "11"))
page.chain(
    "16",
    "the coefficient moves on by one entry",
    e_v * Phi_next,
    Line(e_v * Phi_l * Phi, by=(powers, commute)),
    Line(e_l * Phi, by=(so_far,)),
    Line(e_ln, by=(moves,)),
)

page("So the output shows that entry of the state. All of them make the identity.")
shown = page.chain(
    "16",
    "an output after some samples",
    e_i * y_l,
    Line(e_i * H * w_l, by=(is_y_l,)),
    Line(e_v * w_l, by=(is_h,)),
    Line(e_v * Phi_l * w + e_v * s_l, by=(later,)),
    Line(e_l * w + e_v * s_l, by=(so_far,)),
)
page(
    Explicit(
        "16",
        "the coefficients of the state",
        K,
        Identity(n),
        over_patterns(coefficients),
    )
)

page("Hence the state is these outputs, less what the inputs contribute.")
page.chain(
    "17, 20",
    "an entry of the state",
    e_l * w,
    Line(e_i * y_l - e_v * s_l, by=(shown,)),
)

page("""What they contribute follows row by row: an input that has moved an entry of the
    block, with a row `g_l` of `G`, has moved the entry before it one sample later.""")
row_of_G = page(let(g_l, e_l * G, "13"))
page.chain(
    "25",
    "a row of the contributions from the next one",
    e_l * s_next,
    Line(e_l * Phi * s_l + e_l * G * u, by=(added,)),
    Line(e_ln * s_l + g_l * u, by=(moves, row_of_G)),
)

page("""For a whole block this is a matrix `D_b` times the inputs. Its first row is
    zero, since the first entry is read; the other rows are `Delta_i`, and `Y_i` has the
    outputs from the next sample on.""")
is_block = page(let(w_b, Y_b - D_b * u_p, "17"))
is_w_v = page(let(w_v, E_v * w_b, "23"))
is_Y_i = page(let(Y_i, E_v * Y_b, "24"))
is_Delta = page(let(Delta_i, E_v * D_b, "25"))
page.chain(
    "22, 23, 24",
    "what is computed of a block",
    w_v,
    Line(E_v * w_b, by=(is_w_v,)),
    Line(E_v * Y_b - E_v * D_b * u_p, by=(is_block,)),
    Line(Y_i - Delta_i * u_p, by=(is_Y_i, is_Delta)),
)

page("What is read and what is computed make the block.")
together = page(suppose(e_1.T * e_1 + E_v.T * E_v, Identity(p_i)))
page.chain(
    "18, 23",
    "both together are the block",
    w_b,
    Line((e_1.T * e_1 + E_v.T * E_v) * w_b, by=(together,)),
    Line(e_1.T * e_1 * w_b + E_v.T * w_v, by=(is_w_v,)),
)

page("""Written out, all of it is as follows, with inputs that differ at every sample.
    Each block of `Delta` is a lower block Toeplitz matrix.""")
page(
    Explicit(
        "16, 17",
        "the state from outputs and inputs",
        y_s - d_s,
        w,
        of_window(y_s, d_s, w),
    )
)
page(
    Explicit(
        "20, 22, 25",
        "what is computed of all blocks",
        y_o - Delta * u_p,
        w_o,
        of_window(y_o, Delta, u_p, w_o),
    )
)

page("""That takes `p_M` samples, the largest of the indices. One sample less does not
    see the last entry of the longest block.""")
page(
    Explicit(
        "21",
        "one sample less is not enough",
        O_s * b,
        ZeroMatrix(s, 1),
        over_patterns(one_sample_less),
    )
)

page("The state of the plant follows from that of its coordinates.")
page(is_w)
page.chain(
    "26",
    "the way back",
    x,
    Line(P.I * P * x, why="P is invertible"),
    Line(P.I * w, by=(is_w,)),
)
