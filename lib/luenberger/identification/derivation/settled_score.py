"""The score of a settled record: its sums, and what an uncertain start adds.

Every row has the same matrices, so the gradients are made of a few sums of products
over all rows, and nothing is kept row by row.

Source: our own; the gradients of one row are those of `score_by_blocks`.
"""

from functools import cache

from ...symbolic import BlockMatrix, Derivation, Expect, Line, Stage, Substitute
from .letters import *
from .score import half

SOURCE = "our own"

letters = letters.here()
chain, define, moment = letters.chain, letters.define, letters.moment
Z = letters("Z", n, n, "what `Pi` is too large by, so near the end")
Z_next = letters("Z_next", n, n, "the same one step on")
Pi = letters("Pi", n, n, "what the rows to come tell, if many", symmetric=True)
Pi_2 = letters("Pi_2", n, n, "sum of all `Z`", symmetric=True)
Pi_all = letters("Pi_all", n, n, "`Pi`, once for each row", symmetric=True)
W_all = letters("W_all", p, p, "`W`, once for each row", symmetric=True)
D = letters("D", n, n, "sum over the rows of what those to come tell", symmetric=True)
delta = letters("delta", n, 1, "what the first prediction is off by")
T_1 = letters("T_1", n, n, "its covariance, given the record", symmetric=True)
eta_2 = letters("eta_2", n, 1, "gradient in the first prediction, put right")
Pi_1 = letters("Pi_1", n, n, "what the record tells of it", symmetric=True)
X = letters("X", n, c, "what the columns of a root of `T_1` do to all predictions")
Y = letters("Y", n, n, "sum of their squares over the rows", symmetric=True)
H = letters("H", n, n, "`Pi F Y`")
U = letters("U", p, n, "what is left of `V`")
eta_d = letters("eta_d", n, 2 * c, "`eta_next`, beside what those columns do to it")
h_d = letters("h_d", p, 2 * c, "`h`, beside the same")
x_d = letters("x_d", n, 2 * c, "`x`, beside the same")
x_s = letters("x_s", n, 2 * c, "`x_d`, corrected by the whole record")
J_ee = letters("J_ee", n, n, "`eta_next eta_next'`, all rows", symmetric=True)
J_eh = letters("J_eh", n, p, "`eta_next h'`, all rows")
J_hh = letters("J_hh", p, p, "`h h'`, all rows", symmetric=True)
J_ex = letters("J_ex", n, n, "`eta_next x'`, all rows")
J_hx = letters("J_hx", p, n, "`h x'`, all rows")
K_ee = letters("K_ee", n, n, "`J_ee`, with the columns", symmetric=True)
K_eh = letters("K_eh", n, p, "`J_eh`, with the columns")
K_hh = letters("K_hh", p, p, "`J_hh`, with the columns", symmetric=True)
K_ex = letters("K_ex", n, n, "`J_ex`, with the columns")
K_hx = letters("K_hx", p, n, "`J_hx`, with the columns")

ENDS = (
    """Near the end of a record fewer rows are to come, and they tell less than `Pi`.
    After the last one they tell nothing, so there `Z` is `Pi`. Backwards it fades.""",
    is_Pi := define(Pi, F.T * Pi * F + C.T * V, name="what the rows to come tell"),
    is_Z := define(Z, F.T * Z_next * F),
    chain(
        "",
        "what the rows to come tell, near the end",
        F.T * (Pi - Z_next) * F + C.T * V,
        Line(Pi - F.T * Z_next * F, by=(is_Pi,)),
        Line(Pi - Z, by=(is_Z,)),
    ),
    is_Pi_2 := define(Pi_2, F.T * Pi_2 * F + Pi, name="the sum of all `Z`"),
    chain(
        "",
        "the sum of what fades",
        Pi_2 - F.T * Pi_2 * F,
        Line(Pi, by=(is_Pi_2,)),
    ),
    is_D := define(D, Pi_all - Pi_2),
)

COLUMNS = (
    """Let a letter now have a column for each row of the record, so that a product of
    two of them is a sum over the rows. The first prediction is off by `delta`, which
    has the covariance `T_1`: the score is the mean of the scores, and for this they
    have another column for each row and each column of a root of `T_1`.""",
    is_h := define(h, e - G.T * eta_next),
    is_U := define(U, V - G.T * Pi * F),
    chain(
        "",
        "what moves the turned gradient",
        e - V * X - G.T * (eta_next - Pi * F * X),
        Line(h - V * X + G.T * Pi * F * X, by=(is_h,)),
        Line(h - U * X, by=(is_U,)),
    ),
    is_Y := define(X * X.T, Y),
    is_H := define(H, Pi * F * Y),
    is_eta_d := define(eta_d, BlockMatrix([[eta_next, -Pi * F * X]])),
    is_h_d := define(h_d, BlockMatrix([[h, -U * X]])),
    is_x_d := define(x_d, BlockMatrix([[x, X]])),
    is_J_ee := define(eta_next * eta_next.T, J_ee),
    is_J_eh := define(eta_next * h.T, J_eh),
    is_J_hh := define(h * h.T, J_hh),
    is_J_ex := define(eta_next * x.T, J_ex),
    is_J_hx := define(h * x.T, J_hx),
    is_K_ee := define(K_ee, J_ee + H * F.T * Pi),
    is_K_eh := define(K_eh, J_eh + H * U.T),
    is_K_hh := define(K_hh, J_hh + U * Y * U.T),
    is_K_ex := define(K_ex, J_ex - H),
    is_K_hx := define(K_hx, J_hx - U * Y),
    ee := chain(
        "",
        "the squares of the gradient in the next prediction",
        eta_d * eta_d.T,
        Substitute(eta_next * eta_next.T + Pi * F * X * X.T * F.T * Pi, by=(is_eta_d,)),
        Line(J_ee + Pi * F * Y * F.T * Pi, by=(is_J_ee, is_Y)),
        Line(K_ee, by=(is_H, is_K_ee)),
    ),
    eh := chain(
        "",
        "its products with the turned gradient",
        eta_d * h_d.T,
        Substitute(
            eta_next * h.T + Pi * F * X * X.T * U.T,
            by=(is_eta_d, is_h_d),
        ),
        Line(J_eh + Pi * F * Y * U.T, by=(is_J_eh, is_Y)),
        Line(K_eh, by=(is_H, is_K_eh)),
    ),
    hh := chain(
        "",
        "the squares of the turned gradient",
        h_d * h_d.T,
        Substitute(h * h.T + U * X * X.T * U.T, by=(is_h_d,)),
        Line(J_hh + U * Y * U.T, by=(is_J_hh, is_Y)),
        Line(K_hh, by=(is_K_hh,)),
    ),
    ex := chain(
        "",
        "the products with the prediction",
        eta_d * x_d.T,
        Substitute(eta_next * x.T - Pi * F * X * X.T, by=(is_eta_d, is_x_d)),
        Line(J_ex - Pi * F * Y, by=(is_J_ex, is_Y)),
        Line(K_ex, by=(is_H, is_K_ex)),
    ),
    hx := chain(
        "",
        "those of the turned gradient with it",
        h_d * x_d.T,
        Substitute(h * x.T - U * X * X.T, by=(is_h_d, is_x_d)),
        Line(J_hx - U * Y, by=(is_J_hx, is_Y)),
        Line(K_hx, by=(is_K_hx,)),
    ),
)
SUMS = (
    """The gradients of a row, by blocks, add up to the following. The prediction that
    the whole record corrects is made of the gradients, and need not be kept.""",
    is_x_s := define(x_s, x_d + Omega * (A.T * eta_d + C.T * h_d)),
    is_gA := define(gA, K_ex + (K_ee * A + K_eh * C) * Omega - D * F * Omega),
    is_gC := define(
        gC,
        K_hx + (K_eh.T * A + K_hh * C) * Omega - (W_all * C - G.T * D * F) * Omega,
    ),
    is_gQ := define(gQ, half * (K_ee - D)),
    is_gS := define(gS, K_eh + D * G),
    is_gR := define(gR, half * (K_hh - W_all - G.T * D * G)),
    chain(
        "",
        "the gradient in what moves the state, all rows",
        eta_d * x_s.T - D * F * Omega,
        Line(
            eta_d * x_d.T
            + (eta_d * eta_d.T * A + eta_d * h_d.T * C) * Omega
            - D * F * Omega,
            by=(is_x_s,),
        ),
        Line(
            K_ex + (K_ee * A + K_eh * C) * Omega - D * F * Omega,
            by=(ee, eh, ex),
        ),
        Line(gA, by=(is_gA,)),
    ),
    chain(
        "",
        "the gradient in what is measured, all rows",
        h_d * x_s.T - (W_all * C - G.T * D * F) * Omega,
        Line(
            h_d * x_d.T
            + (h_d * eta_d.T * A + h_d * h_d.T * C) * Omega
            - (W_all * C - G.T * D * F) * Omega,
            by=(is_x_s,),
        ),
        Line(
            K_hx + (K_eh.T * A + K_hh * C) * Omega - (W_all * C - G.T * D * F) * Omega,
            by=(eh, hh, hx),
        ),
        Line(gC, by=(is_gC,)),
    ),
    chain(
        "",
        "the gradient in the process noise, all rows",
        half * (eta_d * eta_d.T - D),
        Line(half * (K_ee - D), by=(ee,)),
        Line(gQ, by=(is_gQ,)),
    ),
    chain(
        "",
        "the gradient in the covariance of both noises, all rows",
        eta_d * h_d.T + D * G,
        Line(K_eh + D * G, by=(eh,)),
        Line(gS, by=(is_gS,)),
    ),
    chain(
        "",
        "the gradient in the measurement noise, all rows",
        half * (h_d * h_d.T - W_all - G.T * D * G),
        Line(half * (K_hh - W_all - G.T * D * G), by=(hh,)),
        Line(gR, by=(is_gR,)),
    ),
    """What the record tells of a start that is known is less than `Pi`, by what the
    start told already.""",
    centred := moment(delta, ZeroMatrix(n, 1)),
    is_T_1 := moment(delta * delta.T, T_1),
    is_Pi_1 := define(Pi_1, Pi - Pi * T_1 * Pi),
    chain(
        "",
        "the gradient in the covariance at the first row",
        (eta_2 - Pi * delta) * (eta_2 - Pi * delta).T - Pi,
        Expect(eta_2 * eta_2.T + Pi * T_1 * Pi - Pi, moments=(centred, is_T_1)),
        Line(eta_2 * eta_2.T - Pi_1, by=(is_Pi_1,)),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def settled_score():
    """The gradients of all rows, from their sums."""
    stages = (
        Stage(D, Pi_all - Pi_2, by=(is_D,)),
        Stage(U, V - G.T * Pi * F, by=(is_U,)),
        Stage(H, Pi * F * Y, by=(is_H,)),
        Stage(K_ee, J_ee + H * F.T * Pi, symmetric=True, by=(is_K_ee,)),
        Stage(K_eh, J_eh + H * U.T, by=(is_K_eh,)),
        Stage(K_hh, J_hh + U * Y * U.T, symmetric=True, by=(is_K_hh,)),
        Stage(K_ex, J_ex - H, by=(is_K_ex,)),
        Stage(K_hx, J_hx - U * Y, by=(is_K_hx,)),
        Stage(gA, is_gA.right, by=(is_gA,)),
        Stage(gC, is_gC.right, by=(is_gC,)),
        Stage(gQ, is_gQ.right, symmetric=True, by=(is_gQ,)),
        Stage(gR, is_gR.right, symmetric=True, by=(is_gR,)),
        Stage(gS, is_gS.right, by=(is_gS,)),
    )
    given = (A, C, Omega, G, F, V, Pi, Pi_2, Pi_all, W_all, Y)
    given += (J_ee, J_eh, J_hh, J_ex, J_hx)
    return listed(given, stages, "the gradients of all rows")


@cache
def told_of_start():
    """What the record tells of a start that is known."""
    stages = (Stage(Pi_1, is_Pi_1.right, symmetric=True, by=(is_Pi_1,)),)
    return listed((Pi, T_1), stages, "what the record tells of a known start")


@cache
def derive():
    """The page."""
    page = (*ENDS, *COLUMNS, *SUMS, settled_score(), told_of_start())
    return Derivation(page=page, letters=letters, source=SOURCE)
