"""The cost, and the dual of the moment that gives it as well.

Source: Haddad and Bernstein (1987), sections 2 to 4, (3.4), (3.5), (4.5), (4.7).
"""

from functools import cache

from sympy import Trace

from matrixproof import (
    BlockMatrix,
    Cyclic,
    Expect,
    Line,
    Page,
    Substitute,
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
    is_x_nu,
    is_xt,
    is_y,
)
from .letters import *

missed = L - De * C
corner = C1.T * De.T * R * De * C1


page = Page(letters=letters, source=SOURCE)

page("Recalled are the measurement, the state of both, and the moments in blocks.")
page(is_y, is_x_nu, is_xt, is_Q, is_Qt, is_Qxy, is_Qyy, is_V2)

page("""The estimator answers `y_e` for `L x`. Its error is seen through the state of
    both, beside what is noise.""")
is_ye = page(let(ye, Ce * xe + De * y, "3.4"))
is_e = page(let(e, L * x - ye, "3.5"))
is_Lt = page(let(Lt, BlockMatrix([[L - De * C, -Ce]])))
error = page.chain(
    "3.4",
    "the error shows the state of both",
    e,
    Line(L * x - (Ce * xe + De * y), by=(is_e, is_ye)),
    Line(L * x - Ce * xe - De * (C * x + C1 * x_nu + w2), by=(is_y, is_x_nu)),
    Substitute(Lt * xt - De * (C1 * x_nu + w2), by=(is_Lt, is_xt)),
)

page("The terms are uncorrelated with each other.")
is_Q1_nu = page(moment(x_nu * x_nu.T, Q1))
is_W2 = page(moment(w2 * w2.T, W2, "section 2"))
apart_e = page(moment(xt * x_nu.T, ZeroMatrix(both, n)))
white_e = page(moment(xt * w2.T, ZeroMatrix(both, l)))
white_1 = page(moment(x_nu * w2.T, ZeroMatrix(n, l)))
is_Sigma = page(let(Sigma, Lt * Qt * Lt.T + De * V2 * De.T))
page.chain(
    "3.5",
    "the covariance of the error",
    e * e.T,
    Line(
        (Lt * xt - De * (C1 * x_nu + w2)) * (Lt * xt - De * (C1 * x_nu + w2)).T,
        by=(error,),
    ),
    Expect(
        Lt * Qt * Lt.T + De * (C1 * Q1 * C1.T + W2) * De.T,
        moments=(is_Q, is_Q1_nu, is_W2, apart_e, white_e, white_1),
    ),
    Line(Lt * Qt * Lt.T + De * V2 * De.T, by=(is_V2,)),
    Line(Sigma, by=(is_Sigma,)),
)

page("""Multiplied out, the covariance is written in moments that the library computes
    one by one.""")
is_J = page(let(J, R * Sigma, "3.5"))
is_S = page(let(S_e, (L * Q12 - De * C * Q12) * Ce.T + L * Qxy * De.T))
shown = page.chain(
    "3.5",
    "the covariance of the error by blocks",
    Sigma,
    Line(Lt * Qt * Lt.T + De * V2 * De.T, by=(is_Sigma,)),
    Substitute(
        L * Q1 * L.T - S_e - S_e.T + Ce * Q2 * Ce.T + De * Qyy * De.T,
        by=(is_Lt, is_Qt, is_Qxy, is_Qyy, is_S),
    ),
)

page("The cost is linear in the moment of both, with a weight for both.")
is_Ct1 = page(let(Ct1, BlockMatrix([[C1, ZeroMatrix(l, r)]])))
is_Rt = page(let(Rt, Lt.T * R * Lt + Ct1.T * De.T * R * De * Ct1, "section 2"))
weight = page.chain(
    "section 2",
    "the weight of both by blocks",
    Rt,
    Line(Lt.T * R * Lt + Ct1.T * De.T * R * De * Ct1, by=(is_Rt,)),
    Substitute(
        BlockMatrix(
            [
                [missed.T * R * missed + corner, -missed.T * R * Ce],
                [-Ce.T * R * missed, Ce.T * R * Ce],
            ]
        ),
        by=(is_Lt, is_Ct1),
    ),
)
cost = page.chain(
    "3.5",
    "the cost is linear in the moment",
    Trace(R * Sigma),
    Line(Trace(R * (Lt * Qt * Lt.T + De * V2 * De.T)), by=(is_Sigma,)),
    Line(
        Trace(R * (Lt * Qt * Lt.T + De * C1 * Q1 * C1.T * De.T + De * W2 * De.T)),
        by=(is_V2,),
    ),
    Substitute(
        Trace(Qt * (Lt.T * R * Lt + Ct1.T * De.T * R * De * Ct1))
        + Trace(De * W2 * De.T * R),
        by=(is_Lt, is_Qt, is_Ct1),
    ),
    Line(Trace(Qt * Rt) + Trace(De * W2 * De.T * R), by=(is_Rt,)),
)
page(is_At, is_At1, is_steady)

page("A dual of the moment, driven by the weight, gives the same cost.")
dual = page(steady(Pt, At.T * Pt * At + At1.T * Pt * At1 + Rt, "4.5"))
pairing = page.chain(
    "4.5",
    "the dual gives the same cost",
    Trace(Qt * Rt),
    Line(Trace(Qt * (Pt - At.T * Pt * At - At1.T * Pt * At1)), by=(dual,)),
    Cyclic(Trace(Pt * (Qt - At * Qt * At.T - At1 * Qt * At1.T))),
    Line(Trace(Pt * Wt), by=(is_steady,)),
)
is_Lq = page(let(Lq, L - De * C))
is_Rt_0 = page(let(Rt_0, Lt.T * R * Lt))

page("""Block by block, the parameters' noise enters the dual in the first block alone,
    and no gain depends on that block.""")
is_Pt = page(suppose(Pt, BlockMatrix([[P1, P12], [P12.T, P2]])))
page(is_F)
is_M_nu = page(let(M_nu, F1.T * Pt * F1 + corner))
is_M1 = page(
    let(
        M1,
        A.T * P12 * Be * C
        + (A.T * P12 * Be * C).T
        + C.T * Be.T * P2 * Be * C
        + missed.T * R * missed,
    )
)
is_M12 = page(let(M12, C.T * Be.T * P2 * Ae - missed.T * R * Ce))
is_M2 = page(let(M2, Ce.T * R * Ce))
duals = page.chain(
    "4.7",
    "the dual equation by blocks",
    BlockMatrix([[P1, P12], [P12.T, P2]]),
    Substitute(Pt, by=(is_Pt,)),
    Line(At.T * Pt * At + At1.T * Pt * At1 + Rt, by=(dual,)),
    Line(
        At.T * Pt * At + At1.T * Pt * At1 + Lt.T * R * Lt + Ct1.T * De.T * R * De * Ct1,
        by=(is_Rt,),
    ),
    Substitute(
        BlockMatrix(
            [
                [A.T * P1 * A + M1 + M_nu, A.T * P12 * Ae + M12],
                [Ae.T * P12.T * A + M12.T, Ae.T * P2 * Ae + M2],
            ]
        ),
        by=(
            is_At,
            is_At1,
            is_Lt,
            is_Ct1,
            is_Pt,
            is_F,
            is_M_nu,
            is_M1,
            is_M12,
            is_M2,
        ),
    ),
)

page("Without it the other two blocks obey the same equations.")
unnoised = page.chain(
    "4.7",
    "the dual equation without the noise of the parameters",
    At.T * Pt * At + Rt_0,
    Line(At.T * Pt * At + Lt.T * R * Lt, by=(is_Rt_0,)),
    Substitute(
        BlockMatrix(
            [
                [A.T * P1 * A + M1, A.T * P12 * Ae + M12],
                [Ae.T * P12.T * A + M12.T, Ae.T * P2 * Ae + M2],
            ]
        ),
        by=(is_At, is_Lt, is_Pt, is_M1, is_M12, is_M2),
    ),
)


@cache
def adjoint_moments():
    """Right sides of P2 = Ae'P2 Ae + M2, P12 = A'P12 Ae + M12, P1 = A'P1 A + M1."""
    stages = [assign(r, "(4.7)") for r in (is_M2, is_M12, is_M1)]
    given = (A, C, L, R, Ae, Be, Ce, De, P12, P2)
    return listed(given, stages, "what drives their duals", duals)


page(adjoint_moments())


@cache
def weight_of_both():
    """What drives the dual, without the noise of the parameters."""
    stages = (
        Stage(Lt, BlockMatrix([[Lq, -Ce]]), "section 2", by=(is_Lt, is_Lq)),
        assign(is_Rt_0),
    )
    return listed((Lq, R, Ce), stages, "the weight of both", unnoised)


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
        assign(is_J, "(3.5)"),
    )
    given = (C, L, R, Ce, De, Qxy, Qyy, Q1, Q12, Q2)
    return listed(given, stages, "the cost of an estimator", cost)


page(projection_cost())
