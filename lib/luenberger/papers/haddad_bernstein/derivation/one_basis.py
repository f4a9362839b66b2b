"""One basis for both hats: what (3.17) asks for, and what it amounts to.

There is always a basis in which both hats are diagonal.  A projection is a sum of its
directions exactly if it is aligned with both hats.  Alignment is what stationarity
gives, and what its converse needs.

Source: Haddad and Bernstein (1987), section 2 and (3.17); the proofs are our own.
"""

from sympy import diag, eye, symbols

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix
from matrixproof.explicit import Construction

from .letters import SOURCE, I, letters, n, r, square
from .letters.both import P2, Q2
from .letters.theorem import G, Gam, Ph, Qh, tau
from .projection import aligned, aligned_dual, one
from .stationarity import is_tau

n_1, n_2 = symbols("n_1 n_2", integer=True, nonnegative=True)
n_3, d = n - n_1 - n_2, n - r
delta = symbols("delta_i")

Psi = letters("Psi", n, n, "a basis in which both hats are diagonal")
Psi_inv = letters("Psi^-1", n, n, "its inverse")
X_1 = letters("X_1", n, n_1, "columns that both hats show")
X_2 = letters("X_2", n, n_2, "the other columns of the first hat")
X_3 = letters("X_3", n, n_3, "columns that complete a basis")
X_4 = letters("X_4", n, n_3, "these, without what the second hat shows of `X_1`")
Z_1 = letters("Z_1", n_1, n, "rows of the inverse of `[X_1, X_2, X_3]`")
Z_2 = letters("Z_2", n_2, n, "its next rows")
Z_3 = letters("Z_3", n_3, n, "its last rows")
T_1 = letters("T_1", n_1, n_3, "how much of `X_1` is taken from `X_3`")
W_3 = letters("W_3", n_3, n_3, "orthogonal columns")
Lam_1 = square("Lambda_1", n_1, "positive and diagonal")
Lam_3 = square("Lambda_3", n_3, "diagonal")
N = letters("N", n, d, "columns that the projection takes to zero")
M = letters("M", d, n, "rows that are biorthogonal to them")
Q_3 = square("Q_3", d, "the first hat in these")
P_3 = square("P_3", d, "the second hat in these")
X_r = letters("X_r", r, r, "a basis in which `Q_2` and `P_2` are diagonal")
Y_d = letters("Y_d", d, d, "a basis in which `Q_3` and `P_3` are diagonal")
D_1 = square("D_1", r, "`Q_2` there")
D_2 = square("D_2", d, "`Q_3` there")
E_1 = square("E_1", r, "`P_2` there")
E_2 = square("E_2", d, "`P_3` there")
D_Q = square("D_Q", n, "the first hat in the basis `Psi`, diagonal")
D_P = square("D_P", n, "the second hat in the basis `Psi`, diagonal")
e_i = letters(
    "e_i", n, 1, "column `i` of the identity; the paper's `E_i` is `e_i e_i'`"
)
pi_i = letters("Pi_i", n, n, "an eigenprojection")
J_e = letters("J_e", r, n, "rows of the identity that are chosen, `n_e` of them")
J_i = letters("J_i", r - 1, n, "the same but for row `i`")
zero = ZeroMatrix
ones = tuple(map(Identity, (n_1, n_2, n_3)))
still, none = zero(n_2, n_2), zero(n_3, n_3)


def diagonal(*blocks):
    """Square blocks along the diagonal."""
    sizes = [block.shape[0] for block in blocks]
    rows = [
        [blocks[i] if i == j else zero(a, b) for j, b in enumerate(sizes)]
        for i, a in enumerate(sizes)
    ]
    return BlockMatrix(rows)


def wanted(shown_Q, shown_P):
    """What makes columns and rows a basis in which both hats are diagonal."""
    ones = [Identity(block.shape[0]) for block in shown_Q]
    return (
        letters.suppose(Psi_inv * Psi, diagonal(*ones), name="they are a basis"),
        letters.suppose(
            Psi_inv * Qh * Psi_inv.T,
            diagonal(*shown_Q),
            name="the first hat is diagonal",
        ),
        letters.suppose(
            Psi.T * Ph * Psi, diagonal(*shown_P), name="the second hat is diagonal"
        ),
    )


WITNESS = {
    Psi: eye(3),
    X_1: [1, 0, 0],
    X_2: [0, 1, 0],
    X_3: [0, 0, 1],
    T_1: 0,
    W_3: 1,
    Qh: diag(1, 1, 0),
    Ph: diag(1, 0, 1),
    J_i: [[1, 0, 0]],
    e_i: [0, 1, 0],
    N: [0, 0, 1],
    M: [[0, 0, 1]],
    X_r: eye(2),
    Y_d: 1,
}


page = Page(letters=letters, source=SOURCE, witness=WITNESS)

page("""For matrices that are not negative there is a basis in which both are diagonal,
    even if both are singular. Write the first hat as `F F'`, and take the columns of
    `F` in a basis in which `F' Ph F` is diagonal. Those with an entry that is not zero
    are `X_1`; the others are `X_2`. A sum of squares vanishes only if every square
    does, so `Ph X_2 = 0`.""")
hat = page.suppose(Qh, X_1 * X_1.T + X_2 * X_2.T)
shown_1 = page.suppose(X_1.T * Ph * X_1, Lam_1)
unseen_2 = page.suppose(Ph * X_2, zero(n, n_2))

page("Complete them to a basis, and take from the new columns what is not orthogonal.")
is_T1 = page.suppose(Lam_1 * T_1, X_1.T * Ph * X_3)
is_X4 = page.let(X_4, X_3 - X_1 * T_1)
apart = page(
    letters.derive(
        "", "the new columns are orthogonal to the first ones", X_1.T * Ph * X_4
    )
    .use(is_X4)
    .use(shown_1)
    .use(is_T1)
)
inverse = page.suppose(
    BlockMatrix([[Z_1], [Z_2], [Z_3]]) * BlockMatrix([[X_1, X_2, X_3]]),
    diagonal(*ones),
    name="the rows of the inverse",
)
turned = page.suppose(W_3.T * X_4.T * Ph * X_4 * W_3, Lam_3)
orthogonal = page.suppose(W_3.T * W_3, Identity(n_3))

page("Wanted are columns and rows with these three properties.")
whole = page(*wanted((*ones[:2], none), (Lam_1, still, Lam_3)))
page(
    Construction(
        "section 3",
        "a basis in which both hats are diagonal",
        {
            Psi: BlockMatrix([[X_1, X_2, X_4 * W_3]]),
            Psi_inv: BlockMatrix([[Z_1 + T_1 * Z_3], [Z_2], [W_3.T * Z_3]]),
        },
        satisfies=whole,
        by=(hat, shown_1, unseen_2, is_X4, apart, inverse, turned, orthogonal),
        symmetric=letters.symmetric,
    )
)

page("""In such a basis each direction `e_i` gives an eigenprojection of the product of
    the hats, and (3.17) adds up `n_e` of them.""")
diagonal_Q = page.suppose(Qh, Psi * D_Q * Psi.T, "3.17")
diagonal_P = page.suppose(Ph, Psi.I.T * D_P * Psi.I, "3.17")
is_pi = page.let(pi_i, Psi * e_i * e_i.T * Psi.I, "section 2")
unit = page.suppose(e_i.T * e_i, Identity(1))
entry = page.suppose(D_Q * D_P * e_i, delta * e_i)
page(
    letters.derive("section 2", "a direction is a projection", pi_i * pi_i)
    .use(is_pi)
    .use(unit)
    .fold(is_pi)
)
page(
    letters.derive("section 2", "a direction is an eigenprojection", Qh * Ph * pi_i)
    .use(diagonal_Q, diagonal_P)
    .use(is_pi)
    .use(entry)
    .fold(is_pi)
)
with page.scope(letters.let(tau, Psi * J_e.T * J_e * Psi.I, "3.17")) as is_sum:
    rows = page.let(J_e, BlockMatrix([[J_i], [e_i.T]]))
    page(
        letters.derive("3.17", "the projection is a sum of eigenprojections", is_sum)
        .put(rows)
        .fold(is_pi)
    )

    page("""A choice of rows takes a diagonal matrix to the entries that are chosen. So
        the projection is aligned with both hats.""")
    chosen_Q = page.suppose(J_e * D_Q, D_1 * J_e)
    chosen_P = page.suppose(J_e * D_P, E_1 * J_e)
    aligned_basis_Q = page(
        letters.derive(
            "3.17", "one basis aligns the projection with the first hat", tau * Qh
        )
        .use(is_sum, diagonal_Q)
        .use(chosen_Q)
        .by(Psi * D_Q * J_e.T * J_e * Psi.T, chosen_Q)
        .by(Qh * tau.T, is_sum, diagonal_Q)
    )
    aligned_basis_P = page(
        letters.derive(
            "3.17", "one basis aligns the projection with the second hat", Ph * tau
        )
        .use(is_sum, diagonal_P)
        .use(chosen_P)
        .fold(chosen_P)
        .by(tau.T * Ph, is_sum, diagonal_P)
    )

    page("""The factors are columns of the basis and rows of its inverse. `Q_2` and
        `P_2` are the chosen entries, which are positive where the product of the hats
        is not zero.""")
    chosen = page.suppose(J_e * J_e.T, Identity(r))
    is_G = page.let(G, J_e * Psi.T, "3.8")
    is_Gam = page.let(Gam, J_e * Psi.I, "3.8")
    is_Q2 = page.let(Q2, Gam * Qh * Gam.T)
    is_P2 = page.let(P2, G * Ph * G.T)
    page(
        letters.derive("3.8", "the projection from columns of the basis", is_sum).fold(
            is_G, is_Gam
        )
    )
    page(
        letters.derive("3.9", "columns of a basis are biorthogonal", Gam * G.T)
        .use(is_G, is_Gam)
        .use(chosen)
    )
    page(
        letters.derive("3.17", "the moment of the estimator in this basis", is_Q2)
        .use(is_Gam, diagonal_Q)
        .use(chosen_Q, chosen)
    )
    page(
        letters.derive("3.17", "its dual in this basis", is_P2)
        .use(is_G, diagonal_P)
        .use(chosen_P, chosen)
    )

page("""The alignments in turn give such a basis. They split each hat into two parts,
    one on either side of the projection.""")
page(is_tau, is_Q2, is_P2)
is_NM = page.suppose(N * M, I - G.T * Gam)
below = page.suppose(M * G.T, zero(d, r))
beside = page.suppose(Gam * N, zero(r, d))
dual_basis = page.suppose(M * N, Identity(d))
is_Q3 = page.let(Q_3, M * Qh * M.T)
is_P3 = page.let(P_3, N.T * Ph * N)
split_Q = page(
    letters.derive("3.17", "the alignment splits the first hat", Qh)
    .insert((tau + N * M) * Qh, is_NM, is_tau)
    .insert((tau + N * M) * Qh * (tau + N * M).T, is_NM, is_tau)
    .by(
        tau * Qh * tau.T + N * Q_3 * N.T + (Qh * tau.T * M.T * N.T) + N * M * tau * Qh,
        aligned,
        is_Q3,
    )
    .by(tau * Qh * tau.T + N * Q_3 * N.T, is_tau, below)
    .put(is_tau)
    .fold(is_Q2)
)
split_P = page(
    letters.derive("3.17", "the alignment splits the second hat", Ph)
    .insert((tau + N * M).T * Ph * (tau + N * M), is_NM, is_tau)
    .by(
        tau.T * Ph * tau + M.T * P_3 * M + Ph * tau * N * M + M.T * N.T * tau.T * Ph,
        aligned_dual,
        is_P3,
    )
    .by(tau.T * Ph * tau + M.T * P_3 * M, is_tau, beside)
    .put(is_tau)
    .fold(is_P2)
)

page("""Each pair of parts has a basis of its own. Both together are a basis for the
    hats.""")
part_Q2 = page.suppose(Q2, X_r * D_1 * X_r.T)
part_P2 = page.suppose(P2, X_r.I.T * E_1 * X_r.I)
part_Q3 = page.suppose(Q_3, Y_d * D_2 * Y_d.T)
part_P3 = page.suppose(P_3, Y_d.I.T * E_2 * Y_d.I)
joined = page(*wanted((D_1, D_2), (E_1, E_2)))
both_tau = page.suppose(
    Psi_inv * tau * Psi,
    diagonal(Identity(r), zero(d, d)),
    name="the projection chooses the first part",
)
page(
    Construction(
        "3.17",
        "a basis from the alignments",
        {
            Psi: BlockMatrix([[G.T * X_r, N * Y_d]]),
            Psi_inv: BlockMatrix([[X_r.I * Gam], [Y_d.I * M]]),
        },
        satisfies=(*joined, both_tau),
        by=(
            *(split_Q, split_P, part_Q2, part_P2, part_Q3, part_P3),
            *(is_tau, one, below, beside, dual_basis),
        ),
        symmetric=letters.symmetric,
    )
)
