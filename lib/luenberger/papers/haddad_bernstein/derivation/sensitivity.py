"""The best output for given moments, and how everything moves with the gains.

A search for the best estimator needs both: the output matrices are eliminated by a
regression, and second derivatives of the cost come from moments that move.

Source: Haddad and Bernstein (1987), (4.10), (4.11); the differentials are our own.
"""

from functools import cache

from matrixproof import BlockMatrix, Line, Page, Solve, Stage, ZeroMatrix
from matrixproof.operators import Differential

from .augmented import is_N2, is_N12
from .cost import is_M2, is_M12
from .gradients import is_gradAe, is_gradBe, is_gradCe, is_gradDe
from .letters import SOURCE, assign, l, letters, listed, n, q, r
from .letters.both import P2, P12, Q2, Q12
from .letters.estimator import Ae, Be, Ce, De
from .letters.kernels import (
    INCREMENTS,
    MOVING,
    Qxy,
    Qxy_next,
    Qyy,
    dAe,
    dBe,
    dCe,
    dDe,
    dgradAe,
    dgradBe,
    dgradCe,
    dgradDe,
    dP2,
    dP12,
    dQ2,
    dQ12,
    gradCe,
    gradDe,
)
from .letters.plant import A, C, L, R

letters = letters.here()
Czy = letters(
    "Czy",
    r + l,
    r + l,
    "covariance of estimator and measurement together",
    symmetric=True,
)
Nzy = letters("Nzy", q, r + l, "covariance of `L x` with these")
CeDe = letters("CeDe", q, r + l, "`C_e` and `D_e` side by side")
dCeDe = letters("dCeDe", q, r + l, "how they move")
dNzy = letters("dNzy", q, r + l, "what moves them")
dN12 = letters("dN12", n, r, "what drives `dQ_12`")
dN2 = letters("dN2", r, r, "what drives `dQ_2`", symmetric=True)
dM12 = letters("dM12", n, r, "what drives `dP_12`")
dM2 = letters("dM2", r, r, "what drives `dP_2`", symmetric=True)


missed, dmissed = L - De * C, -dDe * C
STEP = dict(zip(MOVING, INCREMENTS))


def moved_in(expr):
    """How the letters of an expression move."""
    return {x: dx for x, dx in STEP.items() if expr.has(x)}


# each is half of a symmetric sum
dN2_half = (
    (dAe * Q2 + dBe * C * Q12) * Ae.T
    + Be * C * (dQ12 * Ae.T + Q12 * dAe.T)
    + dBe * Qyy * Be.T
)
dM2_half = dAe.T * P2 * Ae + dCe.T * R * Ce


def moves(says, left, by, expanded, right, named):
    """How an expression moves with the gains and the moments."""
    held = (L,) if expanded.has(L) else ()
    moved = Differential(right, of=STEP, held=held, by=(named,))
    return page.chain("", says, left, Line(expanded, by=(by,)), moved)


page = Page(letters=letters, source=SOURCE)

page("Recalled are the gradients, and what drives the moments and their duals.")
page(is_gradAe, is_gradBe, is_gradCe, is_gradDe, is_N12, is_N2, is_M12, is_M2)

page("""The gradients in `C_e` and `D_e` are linear in these two. For given `A_e` and
    `B_e` the best output is a regression on estimator and measurement together.""")
is_Czy = page.let(Czy, BlockMatrix([[Q2, Q12.T * C.T], [C * Q12, Qyy]]))
is_Nzy = page.let(Nzy, BlockMatrix([[L * Q12, L * Qxy]]))
is_CeDe = page.let(CeDe, BlockMatrix([[Ce, De]]))
best = page.suppose(CeDe * Czy, Nzy, "4.10, 4.11")
regression = page(
    letters.derive(
        "4.10, 4.11",
        "the best output is a regression",
        BlockMatrix([[gradCe, gradDe]]),
    )
    .by(
        2 * R * (CeDe * Czy - Nzy),
        *(is_gradCe, is_gradDe, is_CeDe, is_Czy, is_Nzy),
    )
    .use(best)
)

page("Without feedthrough it is a regression on the estimator alone.")
silent = page.suppose(De, ZeroMatrix(q, l))
best_alone = page.suppose(Ce * Q2, L * Q12, "4.10")
alone = page(
    letters.derive("4.10", "the best output without feedthrough", is_gradCe)
    .use(silent)
    .use(best_alone)
)

page("""When the moments move, the best output moves so that its equation goes on to
    hold.""")
is_dNzy = page.let(
    dNzy,
    BlockMatrix([[L * dQ12 - De * C * dQ12 - Ce * dQ2, -Ce * dQ12.T * C.T]]),
)
is_dCeDe = page.let(dCeDe, BlockMatrix([[dCe, dDe]]))
best_moves = page.suppose(dCeDe * Czy, dNzy)
slopes = BlockMatrix(
    [[Ce * Q2 + De * C * Q12 - L * Q12, Ce * Q12.T * C.T + De * Qyy - L * Qxy]]
)
moving = page(
    letters.derive("", "how the best output moves", slopes)
    .differential(moved_in(slopes), held=(L,))
    .by(dCeDe * Czy - dNzy, is_dCeDe, is_Czy, is_dNzy)
    .use(best_moves)
)
best_alone_moves = page.suppose(dCe * Q2, L * dQ12 - Ce * dQ2)
slope = Ce * Q2 - L * Q12
moving_alone = page(
    letters.derive("", "how it moves without feedthrough", slope)
    .differential(moved_in(slope), held=(L,))
    .use(best_alone_moves)
)

page("""A step of all gains moves the moments, their duals and the gradients. What
    drives the moved moments is linear in the step. With them the second derivatives of
    the cost are exact.""")
is_dN12 = page.let(dN12, A * Q12 * dAe.T + Qxy_next * dBe.T)
is_dN2 = page.let(dN2, dN2_half + dN2_half.T)
is_dM2 = page.let(dM2, dM2_half + dM2_half.T)
is_dM12 = page.let(
    dM12,
    A.T * P12 * dAe
    + C.T * (dBe.T * P2 * Ae + Be.T * dP2 * Ae + Be.T * P2 * dAe)
    - dmissed.T * R * Ce
    - missed.T * R * dCe,
)
moving_Q12, moving_Q2, moving_P2, moving_P12 = (
    moves(
        f"how the {which} moves",
        shown + by.left,
        by,
        shown + by.right,
        moved + named.left,
        named,
    )
    for which, shown, by, moved, named in (
        (
            "moment of state and estimator",
            A * Q12 * Ae.T,
            is_N12,
            A * dQ12 * Ae.T,
            is_dN12,
        ),
        ("moment of the estimator", Ae * Q2 * Ae.T, is_N2, Ae * dQ2 * Ae.T, is_dN2),
        (
            "dual of the estimator's moment",
            Ae.T * P2 * Ae,
            is_M2,
            Ae.T * dP2 * Ae,
            is_dM2,
        ),
        (
            "dual of state and estimator",
            A.T * P12 * Ae,
            is_M12,
            A.T * dP12 * Ae,
            is_dM12,
        ),
    )
)
is_dgradAe = page.let(
    dgradAe,
    2
    * (
        P12.T * A * dQ12
        + dP12.T * A * Q12
        + dP2 * (Be * C * Q12 + Ae * Q2)
        + P2 * (dBe * C * Q12 + Be * C * dQ12 + dAe * Q2 + Ae * dQ2)
    ),
)
is_dgradBe = page.let(
    dgradBe,
    2
    * (
        dP12.T * Qxy_next
        + dP2 * (Be * Qyy + Ae * Q12.T * C.T)
        + P2 * (dBe * Qyy + dAe * Q12.T * C.T + Ae * dQ12.T * C.T)
    ),
)
is_dgradCe = page.let(
    dgradCe,
    2 * (R * (dCe * Q2 + Ce * dQ2 + dDe * C * Q12 + De * C * dQ12 - L * dQ12)),
)
is_dgradDe = page.let(
    dgradDe, 2 * (R * (dDe * Qyy + dCe * Q12.T * C.T + Ce * dQ12.T * C.T))
)
moving_Ae, moving_Be, moving_Ce, moving_De = (
    moves(
        f"how the gradient in its {which} moves",
        slope.left,
        slope,
        slope.right,
        named.left,
        named,
    )
    for which, slope, named in (
        ("own matrix", is_gradAe, is_dgradAe),
        ("input", is_gradBe, is_dgradBe),
        ("output", is_gradCe, is_dgradCe),
        ("static gain", is_gradDe, is_dgradDe),
    )
)


@cache
def best_output():
    """[Ce De] of least cost for given Ae, Be; or Ce alone, if De = 0."""
    stages = (
        assign(letters, is_Czy),
        assign(letters, is_Nzy),
        Stage(CeDe, Solve(Nzy, Czy), "(4.10),(4.11)", by=(best,)),
        Stage(Ce, Solve(L * Q12, Q2), "(4.10)", by=(best_alone,)),
    )
    return listed(
        letters,
        (C, L, Qxy, Qyy, Q12, Q2),
        stages,
        "the best output matrices",
        regression,
        alone,
    )


page(best_output())


@cache
def best_output_differential():
    """How `best_output` moves with Q12 and Q2: of [Ce De], or of Ce if De = 0."""
    stages = (
        assign(letters, is_dNzy),
        Stage(dCeDe, Solve(dNzy, Czy), by=(best_moves,)),
        Stage(dCe, Solve(L * dQ12 - Ce * dQ2, Q2), by=(best_alone_moves,)),
    )
    given = (C, L, Ce, De, Q2, Czy, dQ12, dQ2)
    return listed(
        letters,
        given,
        stages,
        "how the best output matrices move",
        moving,
        moving_alone,
        source="our own",
    )


page(best_output_differential())


@cache
def projection_differential():
    """How right sides and gradients move with the gains: exact second derivatives.

    The moved moments solve the same equations: dQ12 = A dQ12 Ae' + dN12,
    dQ2 = Ae dQ2 Ae' + dN2, dP2 = Ae'dP2 Ae + dM2 and dP12 = A'dP12 Ae + dM12.
    """
    driven = (is_dN12, is_dN2, is_dM2, is_dM12)
    slopes = (is_dgradAe, is_dgradBe, is_dgradCe, is_dgradDe)
    stages = [assign(letters, r) for r in (*driven, *slopes)]
    moments = (Qxy_next, Qyy, Q12, Q2, P12, P2)
    given = (A, C, L, R, Ae, Be, Ce, De, *moments, *INCREMENTS)
    return listed(
        letters,
        given,
        stages,
        "how moments and gradients move",
        moving_Q12,
        moving_Q2,
        moving_P2,
        moving_P12,
        moving_Ae,
        moving_Be,
        moving_Ce,
        moving_De,
        source="our own",
    )


page(projection_differential())
