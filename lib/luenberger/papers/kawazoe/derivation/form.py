"""Kawazoe's coordinates, and the form that they give the plant.

The coordinates are outputs, of now and of later samples.  The form follows from the
order in which they are searched, for every size.  What it looks like is written out for
several lists of indices `p_1` to `p_m`, with a symbol for every entry that is free.

Source: Kawazoe (1978), (1)-(14), (19); the order of the search is our own.
"""

import sympy as sp

from matrixproof import BlockMatrix, Explicit, Identity, Page, ZeroMatrix

from .letters import E_0, E_n, G, H, P, Phi, Phi_l, e_i, e_v, letters, u, w, x, y

n, m, r, s, q = sp.symbols("n m r s q", integer=True, nonnegative=True)
p_i, p_j, v_h, v_i = sp.symbols("p_i p_j v_h v_i", integer=True, positive=True)
letters = letters.here()
A = letters("A", n, n, "moves the state")
B = letters("B", n, r, "what the input does to the state")
C = letters("C", m, n, "what is measured; its rows are independent")
x_next = letters("x_next", n, 1, "state one sample on")
C_i = letters("C_i", 1, n, "row `i` of `C`")
C_1 = letters("C_1", 1, n, "its first row")
C_2 = letters("C_2", 1, n, "its second row")
c_k = letters("c", 1, n, "the row `C_i A^k`")
c_next = letters("c_next", 1, n, "the row after it in the table, that row times `A`")
R = letters("R", s, n, "the rows that come before it in the order of the search")
R_next = letters("R_next", s, n, "the rows that come before the next one")
a = letters("a", 1, s, "coefficients of a combination of them")
M = letters("M", s, s, "says which of them is which")
P_r = letters("P_r", n, n, "rows of the table, taken row by row")
P_q = letters("P_q", q, n, "the rows of the table that are kept")
X_q = letters("X_q", n, q, "a right inverse of them")
K_R = letters("K_R", s, q, "says which combinations of them the rows of `R` are")
J = letters("J", n, s, "a left inverse of the whole table")
E_h = letters("E_h", v_h, n, "picks the blocks before block `i`, if there are any")
E_i = letters("E_i", p_i, n, "picks block `i`")
E_to = letters("E_to", v_i, n, "picks the blocks up to block `i`")
E_p = letters("E_p", m, n, "picks the last entry of each block")
A_p = letters("A_p", m, s, "says which combinations of the table the next rows are")
K_P = letters("K_P", s, n, "says which combinations of `P` the rows of the table are")
phi = letters("phi", m, n, "what the last rows times `A` are of all rows")
alpha = letters("alpha", m, n, "with one output, the coefficients of the polynomial")
Z = letters("Z", n, n, "ones above the diagonal, but for the last row of each block")
phi_i = letters("phi_i", 1, n, "row `i` of `phi`")
E_j = letters("E_j", p_j, n, "picks block `j`")
E_o = letters("E_o", n - p_j, n, "picks the other blocks")
phi_ij = letters("phi_ij", 1, p_j, "the entries of `phi_i` in block `j`")
phi_o = letters("phi_o", 1, n - p_j, "its other entries")
P_j = letters("P_j", p_j, n, "block `j` of `P`")
P_o = letters("P_o", n - p_j, n, "its other blocks")
w_next = letters("w_next", n, 1, "the same one sample on")
A_l = letters("A_l", n, n, "`A` to the power `l`")
A_next = letters("A_l_next", n, n, "`A` to the power `l + 1`")
Phi_next = letters("Phi_l_next", n, n, "`Phi` to the power `l + 1`")
p = letters("p", m, 1, "the indices `p_i`, one below the other")
v = letters("v", m, 1, "where the blocks end: `v_i = p_1 + ... + p_i`")
count = letters("k", n, 1, "the numbers from 1 to `n`")
ones = letters("j", m, 1, "a column of ones")


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


def example():
    """A plant with p = (2, 1) in its own coordinates, with all that is picked of it."""
    first, last = picks([0, 1], 3), picks([2], 3)
    moves, outputs = sp.Matrix([[0, 1, 0], [1, 2, 0], [1, 0, 1]]), picks([0, 2], 3)
    rows = picks([0, 2, 1], 3)
    found = {letter: sp.eye(3) for letter in (P, P_q, X_q, E_to)}
    found |= {A: moves, A_l: moves, Phi_l: moves, C: outputs, R: rows, R_next: rows}
    found |= {E_0: picks([0], 3), E_n: picks([1], 3), E_p: picks([1, 2], 3)}
    found |= {E_h: first, E_j: first, E_i: last, E_o: last}
    found |= {J: rows, K_P: rows, K_R: rows}
    return found | {A_p: sp.Matrix([[1, 0, 2], [1, 1, 0]])}


def heads(of):
    numbers = sp.Matrix(range(1, of.n + 1))
    sizes = {p: sp.Matrix(of.indices), v: sp.Matrix(of.ends)}
    return {H: of.H, count: numbers, **sizes, ones: sp.ones(of.m, 1)}


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


page = Page(letters=letters, source="Kawazoe (1978), (1)-(14), (19)", witness=example())

page("The plant, in discrete time, and the rows of what it measures.")
is_x = page.let(x_next, A * x + B * u, "1")
is_y = page.let(y, C * x, "2")
is_C_i = page.let(C_i, e_i * C, "4")

page("""Coordinates are rows `C_i A^k`, searched in the order `C_1` to `C_m`, then those
    times `A`, and so on. A row is kept if it is independent of the rows before it. If
    it is not, no later row of that output is either, because `A` takes the rows before
    it to rows before the next one.""")
depends = page.let(c_k, a * R, "5")
next_row = page.let(c_next, c_k * A, "5")
before = page.suppose(R * A, M * R_next, "5")
start = letters.derive("5", "behind a row that depends all rows depend", c_next)
page(start.put(next_row, depends).use(before))

page("""By induction, all rows that have been looked at are combinations of those that
    are kept. So is a row that depends on them, and a row that is kept is one of
    those.""")
with page.scope(letters.suppose(R, K_R * P_q, "6")) as so_far:
    says = "a row that depends is a combination of what is kept"
    page(letters.derive("6", says, c_k).put(depends, so_far))

page("""At the end `R` is the whole table. Observability gives it a left inverse, and
    independence gives one to the right of the rows that are kept. They are `n` rows.
    """)
table = page.suppose(R, K_R * P_q, "6")
observable = page.suppose(J * R, I, "3")
independent = page.suppose(P_q * X_q, Identity(q), "5")
start = letters.derive("6", "the rows that are kept span", I)
spans = page(start.insert(J * R, observable).put(table))
start = letters.derive("6", "their inverse is an inverse on both sides", X_q * P_q)
both = page(start.insert(J * K_R * P_q * X_q * P_q, spans).use(independent).use(spans))
start = letters.derive("6", "how many rows are kept", n)
page(start.insert(sp.Trace(X_q * P_q), both).cyclic(P_q).use(independent))

page("""So output `i` contributes `C_i`, `C_i A` and so on, `p_i` rows. The rows of `C`
    come first and are independent, so each output contributes one at least. The page
    leaves the order open, and it matters. Take this plant, and search output by output:
    the first one contributes everything.""")
says = "row by row the first output contributes everything"
page(Explicit("5, 6", says, found_first, P_r, of_plant(A, C_1, P_r)))

page("""Three samples seem to be needed, and `C_2` is not the first row of a block. In
    the order above `C_1 A` is not kept, for it is `C_2`.""")
page(Explicit("5", "a row that depends", C_1 * A, C_2, of_plant(A, C_1, C_2)))

page("What is kept is `C_1`, `C_2` and `C_2 A`: two samples are enough.")
says = "the rows that are kept are independent"
page(Explicit("5, 6", says, found_by_level, I, of_plant(A, C_1, C_2)))

page("""Sorted by output the rows that are kept are `P`, which has an inverse. It has a
    block for each output. `A` takes each row that is not the last of its block to the
    next: in the table it is the next power. What follows a last row depends, on rows
    of the table, which are combinations of `P`.""")
goes_on = page.suppose(E_0 * P * A, E_n * P, "6")
follows = page.suppose(E_p * P * A, A_p * R, "5")
in_P = page.suppose(R, K_P * P, "6")
is_phi = page.let(phi, A_p * K_P, "11")
start = letters.derive("11", "the last rows one step on", E_p * P * A)
ends = page(start.use(follows).put(in_P).fold(is_phi))

page("""Each row is in one block. By induction over the blocks, block `i` ends where the
    blocks before it end and `p_i` rows further. So the last one ends at the sum of all
    indices, which is `n`.""")
split = page.suppose(E_to.T * E_to, E_h.T * E_h + E_i.T * E_i, "6")
size_to = page.suppose(E_to * E_to.T, Identity(v_i), "6")
size_h = page.suppose(E_h * E_h.T, Identity(v_h), "6")
size_i = page.suppose(E_i * E_i.T, Identity(p_i), "6")
page(
    letters.derive("7, 19", "the indices add up", v_i)
    .insert(sp.Trace(E_to * E_to.T), size_to)
    .cyclic(E_to.T)
    .use(split)
    .by(v_h + p_i, size_h, size_i)
)

page("""The new coordinates are `w = P x`. The matrix `Phi` that moves them has ones
    that take each row to the next, and the combinations `phi` in the last rows.""")
is_Z = page.let(Z, E_0.T * E_n, "11")
is_Phi = page.let(Phi, Z + E_p.T * phi, "11")
whole = page.suppose(E_0.T * E_0 + E_p.T * E_p, I, "6")
turned = page(
    letters.derive("11", "the rows that are kept one step on", P * A)
    .insert((E_0.T * E_0 + E_p.T * E_p) * P * A, whole)
    .expand()
    .use(goes_on, ends)
    .fold(is_Z, is_Phi)
)
page(letters.derive("11", "what moves the new coordinates", P * A * P.I).use(turned))

page("So a row of `Phi` is a row of the identity, or it is one of the combinations.")
alone = page.suppose(E_0 * E_0.T, Identity(n - m), "6")
alone_too = page.suppose(E_p * E_p.T, Identity(m), "6")
apart = page.suppose(E_0 * E_p.T, ZeroMatrix(n - m, m), "6")
start = letters.derive("11", "a row of a block that is not its last", E_0 * Phi)
shifts = page(start.put(is_Phi, is_Z).expand().use(alone, apart))
start = letters.derive("11", "the last row of a block", E_p * Phi)
page(start.put(is_Phi, is_Z).expand().use(apart, alone_too))

page("""Written out it is as follows. The order of the search makes some entries of
    `phi` zero: a row is a combination of rows before it.""")
page(Explicit("6, 11", "the pattern", Z + E_p.T * phi, Phi, over_patterns(rows_of_Phi)))

page("""Each row of `phi` has one part for each block, with as many entries as the block
    has rows. `E_j` picks block `j`, and `E_o` the others.""")
parts = page.suppose(E_j.T * E_j + E_o.T * E_o, I, "12")
is_phi_i = page.let(phi_i, e_i * phi, "12")
is_phi_ij = page.let(phi_ij, phi_i * E_j.T, "12")
is_phi_o = page.let(phi_o, phi_i * E_o.T, "12")
is_P_j = page.let(P_j, E_j * P)
is_P_o = page.let(P_o, E_o * P)
page(
    letters.derive("12", "each block has its own coefficients", e_i * E_p * P * A)
    .use(ends)
    .fold(is_phi_i)
    .insert(phi_i * (E_j.T * E_j + E_o.T * E_o) * P, parts)
    .expand()
    .fold(is_phi_ij, is_phi_o, is_P_j, is_P_o)
)

page("""With one output the last row times `A` is `C A^n`. By Cayley and Hamilton it is
    minus the combination of `C`, `C A` and so on that the characteristic polynomial of
    `A` has.""")
with page.scope(letters.suppose(E_p * P * A, -alpha * P, "11")) as hamilton:
    start = letters.derive("11", "one output and the characteristic polynomial", phi)
    page(start.insert(E_p * P * A * P.I, ends).use(hamilton))

page("The outputs are read off the first entries of the blocks, which are rows of `C`.")
read = page.suppose(H * P, C, "6, 14")
is_h = page.suppose(e_i * H, e_v, "14")
start = letters.derive("4, 14", "a row of the measurement", C_i)
page(start.put(is_C_i).fold(read).use(is_h))
page(letters.derive("14", "what reads the outputs", C * P.I).fold(read).expand())

page("Block `i` ends with entry `v_i`. So it begins with entry `1 + v_i - p_i`.")
says = "where they begin"
page(Explicit("14, 19", says, H * count, v - p + ones, over_patterns(heads)))

page("In these coordinates the plant moves and is measured as follows.")
is_w = page.let(w, P * x, "8")
is_w_next = page.let(w_next, P * x_next, "8")
is_G = page.let(G, P * B, "13")
start = letters.derive("9", "the plant in these coordinates", w_next)
page(start.put(is_w_next, is_x).expand().use(turned).fold(is_w, is_G))
start = letters.derive("10", "the measurement in these coordinates", y)
page(start.put(is_y).fold(read).fold(is_w))

page("""A row of the one observability matrix is the same row of the other, times `P`.
    So the new pair is observable exactly if the old one is.""")
start = letters.derive("3", "the first rows of both", C * I)
first_rows = page(start.by(H * I * P, read))
power = page.let(A_next, A_l * A)
new_power = page.let(Phi_next, Phi_l * Phi)
with page.scope(letters.suppose(C * A_l, H * Phi_l * P, "3")) as so_far:
    start = letters.derive("3", "the next rows of both", C * A_next)
    further = page(start.put(power).use(so_far).use(turned).fold(new_power))
page.induction(
    "3",
    "the rows of both observability matrices",
    so_far,
    base=first_rows,
    step=further,
    first={A_l: I, Phi_l: I},
    then={A_l: A_next, Phi_l: Phi_next},
)
