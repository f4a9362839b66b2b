"""The staircase exists: every observable pair is brought to it, by induction.

A unitary matrix gathers the outputs in the last states, in independent columns.  What
is left is a smaller pair, with what drives those states as its outputs, and it is
observable again.  Its staircase and these states make that of the whole.  A star is the
conjugate transpose, as on the other pages.

Source: Van Dooren (1984), (7); the paper cites the staircase, the proof is our own.
"""

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix

from .letters import A, C, I, letters, n, q, r, s

letters = letters.here()
v_0 = letters("v_0", n, 1, "a column of length one that `C` does not see")
Q_0 = letters("Q_0", n, n, "unitary, with that column first")
Q_1 = letters("Q_1", n, n - 1, "its other columns")
W_a = letters("W_a", n - 1, n - q - 1, "of a unitary matrix, columns that are not seen")
W_b = letters("W_b", n - 1, q, "its last columns, which are seen")
U_0 = letters("U_0", n, n, "both unitary matrices, one after the other")
C_1 = letters("C_1", r, q, "what `C` becomes; its columns are independent")
U_C = letters("U_C", n, n, "unitary: the coordinates in which `C` has become that")
Us_C = letters("U_C^*", n, n, "its conjugate transpose")
A_b = letters("A_b", n, n, "`A` in these coordinates")
C_b = letters("C_b", r, n, "`C` in these coordinates")
U_a = letters("U_a", n, n - q, "its columns that `C` does not see")
U_as = letters("U_a^*", n - q, n, "their conjugate transpose")
U_b = letters("U_b", n, q, "its other columns")
U_bs = letters("U_b^*", q, n, "their conjugate transpose")
A_1 = letters("A_1", n - q, n - q, "moves the states that `C` does not see")
A_2 = letters("A_2", n - q, q, "what the other states do to them")
A_3 = letters("A_3", q, n - q, "what they do to the other states")
A_4 = letters("A_4", q, q, "moves the other states")
V_0 = letters("V_0", n - q, s, "columns that the smaller pair hides")
M_0 = letters("M_0", s, s, "which combinations of themselves they are taken to")
U_2 = letters("U_2", n - q, n - q, "unitary: the staircase of the smaller pair")
Us_2 = letters("U_2^*", n - q, n - q, "its conjugate transpose")
D_2 = letters("D_2", n, n, "`U_2` beside the identity")
Ds_2 = letters("D_2^*", n, n, "its conjugate transpose")
A_t = letters("A_t", n - q, n - q, "the staircase of the smaller pair")
A_l = letters("A_l", q, n - q, "its outputs: zero but for the last columns")


def blocks(*rows):
    return BlockMatrix([list(row) for row in rows])


none, no_output = ZeroMatrix(n - q, q), ZeroMatrix(r, n - q)
last = Identity(q)

page = Page(letters=letters, source="Van Dooren (1984), (7)")

page("""If the columns of `C` are independent, nothing is to be done. If they are not,
    there is a column `v_0` of length one with `C v_0 = 0`. A reflector takes the first
    column of the identity to it. So it is the first column of a unitary matrix.""")
is_Q_0 = page.let(Q_0, blocks([v_0, Q_1]))
unseen = page.suppose(C * v_0, ZeroMatrix(r, 1))
page(letters.derive("7", "one column less", C * Q_0).multiply(is_Q_0).use(unseen))

page("""By induction over the columns, the others are gathered by a unitary matrix with
    the columns `W_a` and `W_b`: the first meet no output, the last are independent.""")
gathered_a = page.suppose(C * Q_1 * W_a, ZeroMatrix(r, n - q - 1))
gathered_b = page.suppose(C * Q_1 * W_b, C_1)
is_U_0 = page.let(U_0, blocks([v_0, Q_1 * W_a, Q_1 * W_b]))
start = letters.derive("7", "the outputs meet the last states only", C * U_0)
page(start.multiply(is_U_0).use(unseen, gathered_a, gathered_b))

page("""In these coordinates, with the columns `U_a` and `U_b`, the plant has four
    blocks. Those that begin with the states that `C` does not meet make the smaller
    pair: `A_1`, with `A_3` for its outputs.""")
apart = page.suppose(C * U_a, no_output, "7")
orthonormal = page.suppose(U_as * U_a, Identity(n - q), "7")
whole = page.suppose(U_a * U_as + U_b * U_bs, I, "7")
is_A_1 = page.let(A_1, U_as * A * U_a, "7")
is_A_3 = page.let(A_3, U_bs * A * U_a, "7")
moves = page(
    letters.derive("7", "what moves the states that are not met", A * U_a)
    .insert((U_a * U_as + U_b * U_bs) * A * U_a, whole)
    .expand()
    .fold(is_A_1, is_A_3)
)

page("""A pair is observable if no columns but zeros are taken to combinations of
    themselves and meet no output. Take columns `V_0` that are so in the smaller pair.
    Then `U_a V_0` are so in the whole one.""")
with page.scope(
    letters.suppose(A_1 * V_0, V_0 * M_0), letters.suppose(A_3 * V_0, ZeroMatrix(q, s))
) as hidden:
    start = letters.derive("7", "hidden columns move among themselves", A * U_a * V_0)
    page(start.use(moves).use(*hidden))
    page(letters.derive("7", "and meet no output", C * U_a * V_0).use(apart))

page("""If the whole pair is observable, `U_a V_0` is therefore zero, and `V_0` with it.
    So the smaller pair is observable.""")
with page.scope(letters.suppose(U_a * V_0, ZeroMatrix(n, s))) as zero:
    start = letters.derive("7", "no columns are hidden in the smaller pair", V_0)
    page(start.insert(U_as * U_a * V_0, orthonormal).use(zero))

page("""By induction over the states, the smaller pair is brought to a staircase by a
    unitary `U_2`: `A_t` has the stairs, and `A_l` is zero but for its last columns,
    which are the next stair. `U_2` beside the identity is unitary, and keeps what `C`
    has become.""")
is_A_b = page.let(A_b, Us_C * A * U_C, "7")
is_C_b = page.let(C_b, C * U_C, "7")
four = page.suppose(A_b, blocks([A_1, A_2], [A_3, A_4]), "7")
gathered = page.suppose(C_b, blocks([no_output, C_1]), "7")
is_D_2 = page.let(D_2, blocks([U_2, none], [none.T, last]))
is_Ds_2 = page.let(Ds_2, blocks([Us_2, none], [none.T, last]))
unitary = page.suppose(Us_2 * U_2, Identity(n - q))
is_A_s = page.let(A_t, Us_2 * A_1 * U_2, "7")
is_A_l = page.let(A_l, A_3 * U_2, "7")
start = letters.derive("7", "both together are unitary", Ds_2 * D_2)
page(start.multiply(is_Ds_2, is_D_2).use(unitary))
start = letters.derive("7", "the staircase of the whole", Ds_2 * Us_C * A * U_C * D_2)
page(start.fold(is_A_b).multiply(four, is_Ds_2, is_D_2).fold(is_A_s, is_A_l))
start = letters.derive("7", "the outputs stay where they are", C * U_C * D_2)
page(start.fold(is_C_b).multiply(gathered, is_D_2))

page("""`C` is not zero, because the pair is observable, so each step takes one state at
    least. It ends when the columns of `C` are independent and no state is left. Every
    stair, and `C_k`, has independent columns: it is the `C_1` of its step.""")
