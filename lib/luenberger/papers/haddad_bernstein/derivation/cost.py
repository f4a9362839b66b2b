"""The cost, and the dual of the moment that gives it as well.

Source: Haddad and Bernstein (1987), sections 2 to 4, (3.4), (3.5), (4.5), (4.7).
"""

from functools import cache

from sympy import Trace

from matrixproof import (
    BlockMatrix,
    Page,
    Stage,
    ZeroMatrix,
)

from .augmented import (
    is_At,
    is_At1,
    is_F,
    is_Q,
    is_Qt,
    is_Qxy,
    is_Qyy,
    is_steady,
    is_V2,
    is_xt,
    is_y,
)
from .letters import SOURCE, assign, each, l, letters, listed, n, r, sum_i
from .letters.both import (
    F1,
    P1,
    P2,
    P12,
    Q1,
    Q2,
    Q12,
    At,
    At1,
    Lt,
    Pt,
    Qt,
    Rt,
    both,
    xt,
)
from .letters.estimator import Ae, Be, Ce, De, J, Sigma, e, xe, ye
from .letters.kernels import M1, M2, M12, M_nu, Qxy, Qyy, S_e
from .letters.plant import C1, V2, W2, A, C, L, R, w2, x, x_nu, y
from .letters.theorem import Lq

letters = letters.here()
says = "how the noise of a parameter reaches the measurement"
Ct1 = letters("C_tilde_1", l, both, says, **each("C_tilde"))
Rt_0 = letters(
    "R_tilde_0", both, both, "weight of both, without parameter noise", symmetric=True
)


missed = L - De * C
corner = sum_i * C1.T * De.T * R * De * C1


page = Page(letters=letters, source=SOURCE)

page("Recalled are the measurement, the state of both, and the moments in blocks.")
page(is_y, is_xt, is_Q, is_Qt, is_Qxy, is_Qyy, is_V2)

page("""The estimator answers `y_e` for `L x`. Its error is seen through the state of
    both, beside what is noise.""")
is_ye = page.let(ye, Ce * xe + De * y, "3.4")
is_e = page.let(e, L * x - ye, "3.5")
is_Lt = page.let(Lt, BlockMatrix([[L - De * C, -Ce]]))
error = page(
    letters.derive("3.4", "the error shows the state of both", is_e)
    .put(is_ye)
    .by(Lt * xt - De * (sum_i * C1 * x_nu + w2), is_y, is_Lt, is_xt)
)

page("The terms are uncorrelated with each other, those of two parameters among them.")
is_Q1_nu = page.moment(x_nu * x_nu.T, Q1)
is_W2 = page.moment(w2 * w2.T, W2, "section 2")
alone_e = page.moment(x_nu * x_nu.other.T, ZeroMatrix(n, n))
apart_e = page.moment(xt * x_nu.T, ZeroMatrix(both, n))
white_e = page.moment(xt * w2.T, ZeroMatrix(both, l))
white_1 = page.moment(x_nu * w2.T, ZeroMatrix(n, l))
is_Sigma = page.let(Sigma, Lt * Qt * Lt.T + De * V2 * De.T)
page(
    letters.derive("3.5", "the covariance of the error", e * e.T)
    .put(error)
    .expect(is_Q, is_Q1_nu, is_W2, alone_e, apart_e, white_e, white_1)
    .fold(is_V2)
    .fold(is_Sigma)
)

page("""Multiplied out, the covariance is written in moments that the library computes
    one by one.""")
is_J = page.let(J, R * Sigma, "3.5")
is_S = page.let(S_e, (L * Q12 - De * C * Q12) * Ce.T + L * Qxy * De.T)
shown = page(
    letters.derive("3.5", "the covariance of the error by blocks", is_Sigma).by(
        L * Q1 * L.T - S_e - S_e.T + Ce * Q2 * Ce.T + De * Qyy * De.T,
        *(is_Lt, is_Qt, is_Qxy, is_Qyy, is_S),
    )
)

page("The cost is linear in the moment of both, with a weight for both.")
is_Ct1 = page.let(Ct1, BlockMatrix([[C1, ZeroMatrix(l, r)]]))
is_Rt = page.let(Rt, Lt.T * R * Lt + sum_i * Ct1.T * De.T * R * De * Ct1, "section 2")
weight = page(
    letters.derive("section 2", "the weight of both by blocks", is_Rt).by(
        BlockMatrix(
            [
                [missed.T * R * missed + corner, -missed.T * R * Ce],
                [-Ce.T * R * missed, Ce.T * R * Ce],
            ]
        ),
        *(is_Lt, is_Ct1),
    )
)
cost = page(
    letters.derive("3.5", "the cost is linear in the moment", Trace(R * Sigma))
    .put(is_Sigma, is_V2)
    .by(
        Trace(Qt * (Lt.T * R * Lt + sum_i * Ct1.T * De.T * R * De * Ct1))
        + Trace(De * W2 * De.T * R),
        *(is_Lt, is_Qt, is_Ct1),
    )
    .fold(is_Rt)
)
page(is_At, is_At1, is_steady)

page("A dual of the moment, driven by the weight, gives the same cost.")
dual = page.steady(Pt, At.T * Pt * At + sum_i * At1.T * Pt * At1 + Rt, "4.5")
pairing = page(
    letters.derive("4.5", "the dual gives the same cost", Trace(Qt * Rt))
    .fold(dual)
    .fold(is_steady)
)
is_Lq = page.let(Lq, L - De * C)
is_Rt_0 = page.let(Rt_0, Lt.T * R * Lt)

page("""Block by block, the parameters' noise enters the dual in the first block alone,
    and no gain depends on that block.""")
is_Pt = page.suppose(Pt, BlockMatrix([[P1, P12], [P12.T, P2]]))
page(is_F)
is_M_nu = page.let(M_nu, sum_i * F1.T * Pt * F1 + corner)
is_M1 = page.let(
    M1,
    A.T * P12 * Be * C
    + (A.T * P12 * Be * C).T
    + C.T * Be.T * P2 * Be * C
    + missed.T * R * missed,
)
is_M12 = page.let(M12, C.T * Be.T * P2 * Ae - missed.T * R * Ce)
is_M2 = page.let(M2, Ce.T * R * Ce)


def by_blocks(first):
    """One step of the dual, with what drives its first block."""
    mixed = A.T * P12 * Ae + M12
    return BlockMatrix([[A.T * P1 * A + first, mixed], [mixed.T, Ae.T * P2 * Ae + M2]])


driven = is_M1, is_M12, is_M2
duals = page(
    letters.derive("4.7", "the dual equation by blocks", is_Pt.right)
    .fold(is_Pt)
    .put(dual)
    .put(is_Rt)
    .by(
        by_blocks(M1 + M_nu),
        *(is_At, is_At1, is_Lt, is_Ct1, is_Pt, is_F, is_M_nu, *driven),
    )
)

page("Without it the other two blocks obey the same equations.")
says = "the dual equation without the noise of the parameters"
unnoised = page(
    letters.derive("4.7", says, At.T * Pt * At + Rt_0)
    .put(is_Rt_0)
    .by(by_blocks(M1), is_At, is_Lt, is_Pt, *driven)
)


@cache
def adjoint_moments():
    """Right sides of P2 = Ae'P2 Ae + M2, P12 = A'P12 Ae + M12, P1 = A'P1 A + M1."""
    stages = [assign(letters, r, "(4.7)") for r in (is_M2, is_M12, is_M1)]
    given = (A, C, L, R, Ae, Be, Ce, De, P12, P2)
    return listed(letters, given, stages, "what drives their duals", duals)


page(adjoint_moments())


@cache
def weight_of_both():
    """What drives the dual, without the noise of the parameters."""
    stages = (
        Stage(Lt, BlockMatrix([[Lq, -Ce]]), "section 2", by=(is_Lt, is_Lq)),
        assign(letters, is_Rt_0),
    )
    return listed(letters, (Lq, R, Ce), stages, "the weight of both", unnoised)


page(weight_of_both())


@cache
def projection_cost():
    """Covariance Sigma of L x - y_e; the cost is the trace of R Sigma."""
    half = is_S.right
    stages = (
        Stage(
            Sigma,
            L * Q1 * L.T - half - half.T + Ce * Q2 * Ce.T + De * Qyy * De.T,
            "(3.5)",
            symmetric=True,
            by=(shown, is_S),
        ),
        assign(letters, is_J, "(3.5)"),
    )
    given = (C, L, R, Ce, De, Qxy, Qyy, Q1, Q12, Q2)
    return listed(letters, given, stages, "the cost of an estimator", cost)


page(projection_cost())
