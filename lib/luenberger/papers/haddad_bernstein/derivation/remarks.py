"""What is said beside the theorem: lemma 3.1, (3.19), (3.20) and the remarks.

A projection has two factors, unique but for a basis of the estimator's state.  With
them the estimator is an observer, and a filter of full order seen through the
projection.

Source: Haddad and Bernstein (1987), section 3.
"""

from sympy import Matrix

from matrixproof import Identity, Page, ZeroMatrix
from matrixproof.explicit import Counterexample
from matrixproof.lines import Equation, Iff

from .augmented import is_xe_next
from .cost import is_e, is_ye
from .equations import regression
from .letters import SOURCE, l, letters, n, q, r
from .letters.estimator import Ae, Be, Ce, De, xe, xe_next
from .letters.plant import A, C, L, x, y
from .letters.theorem import G, Gam, Kq, Ph, Qh, tau, xh
from .projection import aligned, aligned_dual, one
from .sensitivity import silent
from .stationarity import gain_Ae, is_Ae, is_Be, is_Ce, is_tau

U = letters("U", n, r, "columns that span what a projection leaves as it is")
Z = letters("Z", r, n, "the other factor of the projection")
U_left = letters("U^+", r, n, "a left inverse of `U`")
Z_right = letters("Z^+", n, r, "a right inverse of `Z`")
S = letters("S", r, r, "a change of basis of the estimator")
G_1 = letters("G_1", r, n, "another factor `G`")
Gam_1 = letters("Gam_1", r, n, "another factor `Gamma`")
xe_1 = letters("x_e1", r, 1, "state of the estimator in another basis")
xe_1_next = letters("x_e1_next", r, 1, "the same one step on")
Ae_1 = letters("A_e1", r, r, "moves it")
Be_1 = letters("B_e1", r, l, "what a measurement does to it")
Ce_1 = letters("C_e1", q, r, "what the estimator says from it")
xh_next = letters("xhat_next", n, 1, "what it says of the next state")
kappa = letters("kappa", n, 1, "an input in place of the weighted innovation")
one_state = Identity(r)


page = Page(letters=letters, source=SOURCE)

page("""Lemma 3.1 takes a projection apart. A matrix of rank `n_e` is a product of two
    factors of full rank, and these have one-sided inverses. If the matrix is
    idempotent, the factors are biorthogonal.""")
with page.scope(letters.let(tau, U * Z, "3.8")) as is_UZ:
    from_left = page.suppose(U_left * U, one_state)
    from_right = page.suppose(Z * Z_right, one_state)
    squared = page.suppose(tau * tau, tau, "3.6")
    page(
        letters.derive("3.9", "factors of full rank are biorthogonal", Z * U)
        .insert(U_left * U * Z * U * Z * Z_right, from_left, from_right)
        .fold(is_UZ)
        .use(squared)
        .put(is_UZ)
        .use(from_left, from_right)
    )

page("""So `G = U'` and `Gamma = Z` will do. That (3.8) and (3.9) give (3.6) and (3.7)
    is in the section on the projection. Two pairs of factors differ by a change of
    basis, which the two pairs make.""")
page(is_tau)
is_tau_1 = page.suppose(tau, G_1.T * Gam_1, "3.8")
one_1 = page.suppose(Gam_1 * G_1.T, one_state, "3.9")
is_S_G = page.let(S, Gam_1 * G.T)
same_Gam = page(
    letters.derive("3.8", "one factor in another basis", Gam_1)
    .insert(Gam_1 * tau, is_tau_1, one_1)
    .put(is_tau)
    .fold(is_S_G)
)
page(
    letters.derive("3.8", "the other factor in another basis", G.T)
    .insert(tau * G.T, is_tau, one)
    .put(is_tau_1)
    .fold(is_S_G)
)
page(
    letters.derive("3.9", "the change of basis has an inverse", S * Gam * G_1.T)
    .fold(same_Gam)
    .use(one_1)
)

page("""Remark 3.2: the projection is idempotent, and in general it is not symmetric.
    Nothing in (3.6) to (3.9) and (3.17) makes it so.""")
page(
    Counterexample(
        "remark 3.2",
        "the projection need not be orthogonal",
        tau,
        tau.T,
        {
            G: Matrix([[1, 0]]),
            Gam: Matrix([[1, 1]]),
            tau: Matrix([[1, 1], [0, 0]]),
            Qh: Matrix([[3, -1], [-1, 1]]),
            Ph: Matrix([[1, 1], [1, 2]]),
        },
        given=(is_tau, one, aligned, aligned_dual),
        symmetric=(Qh, Ph),
    )
)

page("""Remark 3.3: an estimator without feedthrough has `D_e = 0`. The gradients in its
    other matrices vanish for any `D_e`, so (3.10) to (3.12) hold as they are. The least
    error covariance has one term.""")
page(silent)
page(
    letters.derive("remark 3.3", "the least error without feedthrough", regression).use(
        silent
    )
)

page("""Remark 3.4: another basis of the estimator's state changes its matrices, and
    nothing that is seen of it.""")
page(is_xe_next, is_ye, is_e)
is_xe_1 = page.let(xe_1, S * xe, "remark 3.4")
is_xe_1_next = page.let(xe_1_next, S * xe_next, "remark 3.4")
is_Ae_1 = page.let(Ae_1, S * Ae * S.I, "remark 3.4")
is_Be_1 = page.let(Be_1, S * Be, "remark 3.4")
is_Ce_1 = page.let(Ce_1, Ce * S.I, "remark 3.4")
page(
    letters.derive("remark 3.4", "the estimator in another basis", is_xe_1_next)
    .use(is_xe_next)
    .by(Ae_1 * S * xe + Be_1 * y, is_Ae_1, is_Be_1)
    .fold(is_xe_1)
)
page(
    letters.derive(
        "remark 3.4", "its error is the same", L * x - (Ce_1 * xe_1 + De * y)
    )
    .use(is_Ce_1, is_xe_1)
    .fold(is_ye)
    .fold(is_e)
)

page("""So the cost is the same. The matrices are those of other factors of the same
    projection.""")
page(is_Be, is_Ce)
is_G_1 = page.suppose(G_1.T, G.T * S.I, "remark 3.4")
is_Gam_1 = page.suppose(Gam_1, S * Gam, "remark 3.4")
page(
    letters.derive("remark 3.4", "the projection is the same", G_1.T * Gam_1)
    .use(is_G_1, is_Gam_1)
    .fold(is_tau)
)
page(
    letters.derive("remark 3.4", "its own matrix by the other factors", is_Ae_1)
    .put(gain_Ae)
    .fold(is_Gam_1, is_G_1)
)
page(
    letters.derive("remark 3.4", "its input matrix by the other factors", Be_1)
    .put(is_Be_1, is_Be)
    .fold(is_Gam_1)
)
page(
    letters.derive("remark 3.4", "its output matrix by the other factors", Ce_1)
    .put(is_Ce_1, is_Ce)
    .fold(is_G_1)
    .factor()
)

page("""Remark 3.5: the best estimator is an observer of `Gamma x`, which corrects
    itself by the innovation.""")
page(is_Ae)
observer = page(
    letters.derive("3.19", "the estimator as an observer", is_xe_next)
    .put(is_Ae, is_Be)
    .by(Gam * A * G.T * xe + Gam * Kq * (y - C * G.T * xe))
)

page("Lifted by `G'`, it is a filter of full order seen through the projection.")
is_xh = page.let(xh, G.T * xe, "remark 3.5")
is_xh_next = page.let(xh_next, G.T * xe_next, "remark 3.5")
page(
    letters.derive("3.20", "the estimator at full order", is_xh_next)
    .put(observer)
    .by(tau * A * xh + tau * Kq * (y - C * xh), is_tau, is_xh)
)
page(
    letters.derive("3.20", "the projection leaves the estimate as it is", tau * xh)
    .put(is_tau, is_xh)
    .use(one)
    .fold(is_xh)
)
page(
    letters.derive("3.20", "the state of the estimator from the estimate", Gam * xh)
    .put(is_xh)
    .use(one)
)

page("""An input in place of `K_q (y - C xhat)` reaches the estimator through `Gamma`.
    It is annihilated exactly if it lies in the null space of `tau`.""")
page.chain(
    "after 3.20",
    "which inputs are annihilated",
    Equation(Gam * kappa, ZeroMatrix(r, 1)),
    Iff(Equation(tau * kappa, ZeroMatrix(n, 1)), by=(is_tau, one)),
)
