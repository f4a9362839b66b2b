"""Kawazoe's coordinates, and the form that they give the plant.

The coordinates are outputs, of now and of later samples.  What holds for every size is
proved in letters.  What rests on the pattern of zeros and ones in (11) and (14) is
evaluated for several lists of indices `p_1` to `p_m`, with a symbol for every other
entry.

Source: Kawazoe (1978), (1)-(14), (19); the order of the search is our own.
"""

import sympy as sp

from matrixproof import BlockMatrix, Cyclic, Explicit, Line, Page

from .letters import *

PATTERNS = ((3, 1), (2, 1), (2, 2), (2, 2, 1))

# -- explicit patterns ----------------------------------------------------------------


def named(letter, rows, cols):
    return sp.Matrix(
        rows, cols, lambda i, j: sp.Symbol(f"{letter}_{i + 1}{j + 1}", real=True)
    )


def picks(entries, total):
    """The rows of the identity that pick entries of a column."""
    return sp.eye(total).extract(entries, range(total))


class Pattern:
    """Phi of (11) and H of (14) for indices p_1 .. p_m, the last rows of Phi named.

    The interleaved search leaves phi_ij^k (k from 1) free where C_i A^(p_i) may depend
    on that row: on lower powers, k - 1 < p_i, and on the same power of an earlier
    output, k - 1 = p_i with j < i.
    """

    def __init__(self, indices):
        self.indices, self.n, self.m = tuple(indices), sum(indices), len(indices)
        self.samples = max(indices)
        self.ends = [sum(indices[: i + 1]) for i in range(self.m)]
        self.heads = [end - size for end, size in zip(self.ends, indices)]
        self.H = picks(self.heads, self.n)
        self.Phi = sp.Matrix(self.n, self.n, lambda k, c: int(c == k + 1))
        for i, end in enumerate(self.ends):
            self.Phi[end - 1, :] = self._last_row(i)

    def _last_row(self, i):
        row = sp.zeros(1, self.n)
        for j, width in enumerate(self.indices):
            for k in range(min(width, self.indices[i] + (j < i))):
                row[self.heads[j] + k] = sp.Symbol(f"phi_{i + 1}{j + 1}^{k + 1}")
        return row


def over_patterns(values):
    """{"p = ..": values(its `Pattern`)} of each index pattern."""
    return {f"p = {indices}": values(Pattern(indices)) for indices in PATTERNS}


def rows_of_Phi(of):
    last = [end - 1 for end in of.ends]
    full, chosen = of.Phi.extract(last, range(of.n)), picks(last, of.n)
    return {Z: of.Phi - chosen.T * full, E_p: chosen, phi: full, Phi: of.Phi}


def ends(of):
    below = sp.ones(of.m).lower_triangular()
    return {L: below, p: sp.Matrix(of.indices), v: sp.Matrix(of.ends)}


def heads(of):
    numbers = sp.Matrix(range(1, of.n + 1))
    sizes = {p: sp.Matrix(of.indices), v: sp.Matrix(of.ends)}
    return {H: of.H, count: numbers, **sizes, ones: sp.ones(of.m, 1)}


def by_polynomial(size):
    """A plant with one output, and minus the coefficients of its polynomial in Phi."""
    moves, row = named("a", size, size), named("c", 1, size)
    last = -sp.Matrix([moves.charpoly().all_coeffs()[:0:-1]])
    up = sp.Matrix(size - 1, size, lambda i, j: int(j == i + 1))
    rows = [row]
    for _ in range(size - 1):
        rows.append((rows[-1] * moves).expand())
    return {P: sp.Matrix.vstack(*rows), A: moves, Phi: up.col_join(last)}


PLANT = {
    A: sp.Matrix([[0, 1, 0], [0, 0, 1], sp.symbols("a_1:4")]),
    C_1: sp.Matrix([[1, 0, 0]]),
    C_2: sp.Matrix([[0, 1, 0]]),
    P_r: sp.eye(3),
}


def of_plant(*wanted):
    """A plant on which the order of the search matters."""
    return {"": {letter: PLANT[letter] for letter in wanted}}


# -- the page -------------------------------------------------------------------------

I = Identity(n)  # noqa: E741
found_first = BlockMatrix([[C_1], [C_1 * A], [C_1 * A * A]])
found_by_level = BlockMatrix([[C_1], [C_2], [C_2 * A]])


page = Page(letters=letters, source=f"{SOURCE}, (1)-(14), (19)")

page("The plant, in discrete time, and the rows of what it measures.")
is_x = page(let(x_next, A * x + B * u, "1"))
is_y = page(let(y, C * x, "2"))
is_C_i = page(let(C_i, e_i * C, "4"))

page("""Coordinates are rows `C_i A^k`, searched in the order `C_1` to `C_m`, then those
    times `A`, and so on. A row is kept if it is independent of the rows before it. If
    it is not, no later row of that output is either, because `A` takes the rows before
    it to rows before the next one.""")
depends = page(let(c_k, a * R, "5"))
next_row = page(let(c_next, c_k * A, "5"))
before = page(suppose(R * A, M * R_next, "5"))
page.chain(
    "5",
    "behind a row that depends all rows depend",
    c_next,
    Line(c_k * A, by=(next_row,)),
    Line(a * R * A, by=(depends,)),
    Line(a * M * R_next, by=(before,)),
)

page("""So output `i` contributes `C_i`, `C_i A` and so on, `p_i` rows. The rows of `C`
    come first and are independent, so each output contributes one at least. The page
    leaves the order open, and it matters. Take this plant, and search output by output:
    the first one contributes everything.""")
page(
    Explicit(
        "5, 6",
        "row by row the first output contributes everything",
        found_first,
        P_r,
        of_plant(A, C_1, P_r),
    )
)

page("""Three samples seem to be needed, and `C_2` is not the first row of a block. In
    the order above `C_1 A` is not kept, for it is `C_2`.""")
page(Explicit("5", "a row that depends", C_1 * A, C_2, of_plant(A, C_1, C_2)))

page("What is kept is `C_1`, `C_2` and `C_2 A`: two samples are enough.")
page(
    Explicit(
        "5, 6",
        "the rows that are kept are independent",
        found_by_level,
        I,
        of_plant(A, C_1, C_2),
    )
)

page("""Sorted by output the rows that are kept are `P`, which has a block for each
    output. Block `i` begins with `C_i`. `A` takes each of its rows to the next, and the
    last one to a combination `phi_i` of all rows.""")
is_head = page(suppose(e_v * P, C_i, "6"))
goes_on = page(suppose(e_k * P * A, e_kn * P, "6"))
is_last = page(suppose(e_p * P * A, phi_i * P, "6"))

page("""Each row is in one block. With two outputs, of which `E_1` and `E_2` pick the
    blocks, the indices therefore add up to `n`; each further output adds a term.""")
split = page(suppose(E_1.T * E_1 + E_2.T * E_2, I, "6"))
size_1 = page(suppose(E_1 * E_1.T, Identity(p_1), "6"))
size_2 = page(suppose(E_2 * E_2.T, Identity(p_2), "6"))
page.chain(
    "7",
    "the indices add up",
    n,
    Line(sp.Trace(E_1.T * E_1 + E_2.T * E_2), by=(split,)),
    Cyclic(sp.Trace(E_1 * E_1.T) + sp.Trace(E_2 * E_2.T)),
    Line(p_1 + p_2, by=(size_1, size_2)),
)

page("""The new coordinates are `w = P x`. The matrix `Phi` that moves them has a row
    for each row of `P`: ones above the diagonal, and the combinations `phi_i`.""")
shifts = page(suppose(e_k * Phi, e_kn, "11"))
is_full = page(suppose(e_p * Phi, phi_i, "11"))
page.chain(
    "11",
    "a row of a block that is not its last",
    e_k * P * A,
    Line(e_kn * P, by=(goes_on,)),
    Line(e_k * Phi * P, by=(shifts,)),
)
page.chain(
    "11",
    "the last row of a block",
    e_p * P * A,
    Line(phi_i * P, by=(is_last,)),
    Line(e_p * Phi * P, by=(is_full,)),
)

page("These are all rows, so both sides are equal.")
turned = page(suppose(P * A, Phi * P, "11"))
page.chain(
    "11",
    "what moves the new coordinates",
    Phi,
    Line(Phi * P * P.I, why="put in an inverse"),
    Line(P * A * P.I, by=(turned,)),
)

page("""Written out, `Z` has the ones and `phi` the combinations. The order of the
    search makes some of their entries zero: a row is a combination of rows before
    it.""")
page(Explicit("6, 11", "the pattern", Z + E_p.T * phi, Phi, over_patterns(rows_of_Phi)))

page("""Each combination `phi_i` has one part for each block, with as many entries as
    the block has rows. `E_j` picks block `j`, and `E_o` the others.""")
parts = page(suppose(E_j.T * E_j + E_o.T * E_o, I, "12"))
is_phi_ij = page(let(phi_ij, phi_i * E_j.T, "12"))
is_phi_o = page(let(phi_o, phi_i * E_o.T, "12"))
is_P_j = page(let(P_j, E_j * P))
is_P_o = page(let(P_o, E_o * P))
page.chain(
    "12",
    "each block has its own coefficients",
    e_p * P * A,
    Line(phi_i * P, by=(is_last,)),
    Line(phi_i * (E_j.T * E_j + E_o.T * E_o) * P, by=(parts,)),
    Line(phi_ij * P_j + phi_o * P_o, by=(is_phi_ij, is_phi_o, is_P_j, is_P_o)),
)

page("""With one output they are minus the coefficients of the characteristic polynomial
    of `A`, by Cayley and Hamilton.""")
page(
    Explicit(
        "11",
        "one output and the characteristic polynomial",
        P * A,
        Phi * P,
        {f"n = {size}": by_polynomial(size) for size in (2, 3)},
    )
)

page("The outputs are read off the first entries of the blocks.")
is_h = page(suppose(e_i * H, e_v, "14"))
page.chain(
    "4, 14",
    "a row of the measurement",
    e_i * H * P,
    Line(e_v * P, by=(is_h,)),
    Line(C_i, by=(is_head,)),
    Line(e_i * C, by=(is_C_i,)),
)

page("That is so for every output, so both sides are equal.")
read = page(suppose(C, H * P, "14"))
page.chain(
    "14",
    "what reads the outputs",
    H,
    Line(H * P * P.I, why="put in an inverse"),
    Line(C * P.I, by=(read,)),
)

page("Block `i` ends with entry `v_i`, and begins with entry `1 + v_i - p_i`.")
page(Explicit("19", "where the blocks end", L * p, v, over_patterns(ends)))
page(
    Explicit(
        "14, 19", "where they begin", H * count, v - p + ones, over_patterns(heads)
    )
)

page("In these coordinates the plant moves and is measured as follows.")
is_w = page(let(w, P * x, "8"))
is_w_next = page(let(w_next, P * x_next, "8"))
is_G = page(let(G, P * B, "13"))
page.chain(
    "9",
    "the plant in these coordinates",
    w_next,
    Line(P * x_next, by=(is_w_next,)),
    Line(P * A * x + P * B * u, by=(is_x,)),
    Line(Phi * P * x + G * u, by=(turned, is_G)),
    Line(Phi * w + G * u, by=(is_w,)),
)
page.chain(
    "10",
    "the measurement in these coordinates",
    y,
    Line(C * x, by=(is_y,)),
    Line(H * P * x, by=(read,)),
    Line(H * w, by=(is_w,)),
)

page("""A row of the one observability matrix is the same row of the other, times `P`.
    So the new pair is observable exactly if the old one is.""")
so_far = page(suppose(C * A_l, H * Phi_l * P, "3"))
page.chain(
    "3",
    "the rows of both observability matrices",
    C * A_l * A,
    Line(H * Phi_l * P * A, by=(so_far,)),
    Line(H * Phi_l * Phi * P, by=(turned,)),
)
