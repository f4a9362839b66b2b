"""The expected information of a record in what a plant says.

It is the mean of minus the second derivatives of the likelihood, and so of the squares
of its slopes.  A row shows a direction in two ways: its innovation's covariance moves,
and its innovation moves.  What moves the innovations of later rows is carried back to
the row where it arises.

Source: our own; the two parts are those of Schweppe (1965) and of Porat and Friedlander
(1986), "Computation of the exact information matrix of Gaussian time series".
"""

from functools import cache

from sympy import Rational, Trace

from ...symbolic import Derivation, Differential, Expect, Line, Stage, plus
from .direction_letters import *
from .sensitivity import is_F, is_N, is_W

SOURCE = "our own; Schweppe (1965), Porat and Friedlander (1986)"
half = Rational(1, 2)

PAGE = (
    """Half the logarithm of the determinant of `M` and half of `nu' M^-1 nu` is what a
    row takes from the logarithm of the likelihood. The logarithm of the determinant
    has the gradient `M^-1`. So a direction `i` gives the slope of a row.""",
    is_W,
    is_e := define(e, W * nu),
    chain(
        "",
        "the slope of the exponent",
        -half * Trace(nu.T * M.I * nu),
        Differential(
            plus(half * Trace(e.T * dM_i * e), -Trace(dnu_i.T * e)),
            of={M: dM_i, nu: dnu_i},
            by=(is_W, is_e),
        ),
    ),
    """Move that slope in a direction `j`, and take the mean. Given the rows before, an
    innovation has the mean zero, and its changes are known, because they depend on
    those rows alone. So `e` has the covariance `W M W`, which is `W`.""",
    is_ee := moment(e * e.T, W),
    is_N_ij := moment(dnu_i * dnu_j.T, N_ij + dn_i * dn_j.T),
    apart_i := moment(e * dnu_i.T, ZeroMatrix(p, p)),
    apart_j := moment(e * dnu_j.T, ZeroMatrix(p, p)),
    apart_ij := moment(e * ddnu.T, ZeroMatrix(p, p)),
    chain(
        "",
        "the mean curvature, as far as the covariance moved first",
        -half * Trace(M.I * dM_i) + half * Trace(nu.T * M.I * dM_i * M.I * nu),
        Differential(
            plus(
                half * Trace(W * dM_j * W * dM_i) - half * Trace(W * ddM),
                half * Trace(e.T * ddM * e) - Trace(e.T * dM_j * W * dM_i * e),
                Trace(dnu_j.T * W * dM_i * e),
            ),
            of={M: dM_j, nu: dnu_j, dM_i: ddM},
            by=(is_W, is_e),
        ),
        Expect(-half * Trace(W * dM_i * W * dM_j), moments=(is_ee, apart_j)),
    ),
    chain(
        "",
        "the mean curvature, as far as the innovation moved first",
        -Trace(dnu_i.T * M.I * nu),
        Differential(
            plus(
                -Trace(ddnu.T * e) + Trace(dnu_i.T * W * dM_j * e),
                -Trace(dnu_i.T * W * dnu_j),
            ),
            of={M: dM_j, nu: dnu_j, dnu_i: ddnu},
            by=(is_W, is_e),
        ),
        Expect(
            -Trace(W * N_ij) - Trace(W * dn_i * dn_j.T),
            moments=(is_N_ij, apart_i, apart_ij),
        ),
    ),
    """So the information of a row is the trace of `1/2 W dM_i W dM_j`, that of `W N_ij`
    and that of `W dn_i dn_j'`. For the second, the prediction and its changes are
    followed, and here they stand for what they are beyond their means.""",
    is_X := moment(x * x.T, X),
    is_X_i := moment(dx_i * x.T, X_i),
    is_X_j := moment(dx_j * x.T, X_j),
    is_D_ij := moment(dx_i * dx_j.T, D_ij),
    is_V_ij := define(V_ij, C * X_i * dC_j.T + dC_i * X_j.T * C.T + dC_i * X * dC_j.T),
    shown := define(N_ij, C * D_ij * C.T + V_ij),
    chain(
        "",
        "the covariance of the changes of an innovation",
        (C * dx_i + dC_i * x) * (C * dx_j + dC_j * x).T,
        Expect(
            C * D_ij * C.T + C * X_i * dC_j.T + dC_i * X_j.T * C.T + dC_i * X * dC_j.T,
            moments=(is_D_ij, is_X_i, is_X_j, is_X),
        ),
        Line(C * D_ij * C.T + V_ij, by=(is_V_ij,)),
        Line(N_ij, by=(shown,)),
    ),
    """An innovation is independent of the rows before. It moves the next prediction by
    the gain, and its changes by those of the gain, of which `T` is the product with
    `M`.""",
    of_gain := define(N, G * M),
    of_i := define(dG_i * M, T_i),
    of_j := define(dG_j, T_j * W),
    is_nunu := moment(nu * nu.T, M),
    apart_x := moment(x * nu.T, ZeroMatrix(n, p)),
    apart_dx_i := moment(dx_i * nu.T, ZeroMatrix(n, p)),
    apart_dx_j := moment(dx_j * nu.T, ZeroMatrix(n, p)),
    is_X_next := define(X_next, A * X * A.T + G * N.T),
    chain(
        "",
        "the covariance of the next prediction",
        (A * x + G * nu) * (A * x + G * nu).T,
        Expect(A * X * A.T + G * M * G.T, moments=(is_X, is_nunu, apart_x)),
        Line(A * X * A.T + G * N.T, by=(of_gain,)),
        Line(X_next, by=(is_X_next,)),
    ),
    is_X_i_next := define(X_i_next, F * X_i * A.T + H_i * X * A.T + T_i * G.T),
    chain(
        "",
        "the covariance of the next change and the next prediction",
        (F * dx_i + H_i * x + dG_i * nu) * (A * x + G * nu).T,
        Expect(
            F * X_i * A.T + H_i * X * A.T + dG_i * M * G.T,
            moments=(is_X_i, is_X, is_nunu, apart_x, apart_dx_i),
        ),
        Line(F * X_i * A.T + H_i * X * A.T + T_i * G.T, by=(of_i,)),
        Line(X_i_next, by=(is_X_i_next,)),
    ),
    is_Y_ij := define(Y_ij, F * X_i * H_j.T + H_i * X_j.T * F.T + H_i * X * H_j.T),
    is_D_ij_next := define(D_ij_next, F * D_ij * F.T + Y_ij + T_i * W * T_j.T),
    chain(
        "",
        "the covariance of the next changes",
        (F * dx_i + H_i * x + dG_i * nu) * (F * dx_j + H_j * x + dG_j * nu).T,
        Expect(
            F * D_ij * F.T
            + F * X_i * H_j.T
            + H_i * X_j.T * F.T
            + H_i * X * H_j.T
            + dG_i * M * dG_j.T,
            moments=(
                is_D_ij,
                is_X_i,
                is_X_j,
                is_X,
                is_nunu,
                apart_x,
                apart_dx_i,
                apart_dx_j,
            ),
        ),
        Line(F * D_ij * F.T + Y_ij + dG_i * M * dG_j.T, by=(is_Y_ij,)),
        Line(F * D_ij * F.T + Y_ij + T_i * W * T_j.T, by=(of_i, of_j)),
        Line(D_ij_next, by=(is_D_ij_next,)),
    ),
    """No pair of directions needs to be carried on, however. What the rows to come
    show of a change is `Pi_next`, as in the score, and it is carried back instead. So
    a row adds what it shows itself, and what it passes on.""",
    is_Pi := define(Pi, F.T * Pi_next * F + C.T * W * C),
    chain(
        "",
        "what a row and the rows to come show of the changes",
        Trace(W * N_ij) + Trace(Pi_next * D_ij_next),
        Line(
            plus(
                Trace(W * C * D_ij * C.T) + Trace(W * V_ij),
                Trace(Pi_next * F * D_ij * F.T) + Trace(Pi_next * Y_ij),
                Trace(Pi_next * T_i * W * T_j.T),
            ),
            by=(shown, is_D_ij_next),
        ),
        Line(
            plus(
                Trace(Pi * D_ij) + Trace(W * V_ij) + Trace(Pi_next * Y_ij),
                Trace(Pi_next * T_i * W * T_j.T),
            ),
            by=(is_Pi,),
        ),
    ),
    """So the information of the record is the sum of all but the first of these, and
    of those of covariances and means, over its rows. Each of them is what one direction
    leaves, weighed once, times what the other does, entry by entry.""",
    is_B_M := define(B_M, half * W * dM_i * W),
    is_B_n := define(B_n, W * dn_i),
    is_B_T := define(B_T, Pi_next * T_i * W),
    chain(
        "",
        "the information in covariances, means and gains",
        plus(
            half * Trace(W * dM_i * W * dM_j),
            Trace(W * dn_i * dn_j.T) + Trace(Pi_next * T_i * W * T_j.T),
        ),
        Line(
            Trace(B_M * dM_j) + Trace(B_n * dn_j.T) + Trace(B_T * T_j.T),
            by=(is_B_M, is_B_n, is_B_T),
        ),
    ),
    """Where `A` or `C` moves there is more. It is symmetric in the two directions, and
    each takes a half of what both contain.""",
    is_B_C := define(B_C, W * C * X_i + half * W * dC_i * X),
    is_B_C_j := define(B_C_j, W * C * X_j + half * W * dC_j * X),
    chain(
        "",
        "the information of a row in what moves",
        Trace(W * V_ij),
        Line(
            plus(
                Trace(W * C * X_i * dC_j.T) + Trace(W * C * X_j * dC_i.T),
                Trace(W * dC_i * X * dC_j.T),
            ),
            by=(is_V_ij,),
        ),
        Line(
            Trace(B_C * dC_j.T) + Trace(B_C_j * dC_i.T),
            by=(is_B_C, is_B_C_j),
        ),
    ),
    is_B_H := define(B_H, Pi_next * F * X_i + half * Pi_next * H_i * X),
    is_B_H_j := define(B_H_j, Pi_next * F * X_j + half * Pi_next * H_j * X),
    chain(
        "",
        "the information of later rows in what moves",
        Trace(Pi_next * Y_ij),
        Line(
            plus(
                Trace(Pi_next * F * X_i * H_j.T) + Trace(Pi_next * F * X_j * H_i.T),
                Trace(Pi_next * H_i * X * H_j.T),
            ),
            by=(is_Y_ij,),
        ),
        Line(
            Trace(B_H * H_j.T) + Trace(B_H_j * H_i.T),
            by=(is_B_H, is_B_H_j),
        ),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def told_back():
    """What a row and the rows to come tell of a prediction."""
    stages = (
        Stage(F, A - G * C, by=(is_F,)),
        Stage(Pi, F.T * Pi_next * F + C.T * W * C, symmetric=True, by=(is_Pi,)),
    )
    return listed((A, C, G, W, Pi_next), stages, "what rows tell of a prediction")


@cache
def weighed_noise():
    """What the changes of an innovation's covariance and of the gain are weighed to."""
    stages = (
        Stage(B_M, half * W * dM_i * W, symmetric=True, by=(is_B_M,)),
        Stage(B_T, Pi_next * T_i * W, by=(is_B_T,)),
    )
    return listed((W, Pi_next, dM_i, T_i), stages, "covariance and gain, weighed")


@cache
def weighed_motion():
    """What the changes of A and C meet in this row and in later ones."""
    stages = (
        Stage(B_C, is_B_C.right, by=(is_B_C,)),
        Stage(B_H, is_B_H.right, by=(is_B_H,)),
    )
    given = (C, F, W, Pi_next, X, X_i, dC_i, H_i)
    return listed(given, stages, "what moves and what is measured, weighed")


@cache
def weighed_mean():
    """What the mean of an innovation's change is weighed to."""
    stages = (Stage(B_n, W * dn_i, by=(is_B_n,)),)
    return listed((W, dn_i), stages, "a mean, weighed")


@cache
def correlations():
    """Covariances of a prediction, and of its change with it, one row on."""
    stages = (
        Stage(N, A * Omega * C.T + S, by=(is_N,)),
        Stage(X_next, A * X * A.T + G * N.T, symmetric=True, by=(is_X_next, of_gain)),
        Stage(X_i_next, is_X_i_next.right, by=(is_X_i_next,)),
    )
    given = (A, C, S, Omega, G, F, H_i, T_i, X, X_i)
    return listed(given, stages, "covariances with the prediction, one row on")


@cache
def derive():
    """The page."""
    lists = told_back(), correlations(), weighed_noise(), weighed_motion()
    page = (*PAGE, is_F, is_N, *lists, weighed_mean())
    return Derivation(page=page, letters=letters, source=SOURCE)
