"""A fixed lag: what a stretch of rows says is one map, and two stretches are one.

The smoother's backward step maps what later rows say to what they say one row earlier.
The maps of neighbouring stretches are joined to one of the same form.  So the windows
of all rows, each from the next row to the lag, are found together by doubling.

Source: our own.
"""

from functools import cache

from ...symbolic import Derivation, Line, Stage
from .adjoint import is_Lambda, is_lamda, is_Theta, is_theta
from .letters import *

letters = letters.here()
chain, define = letters.chain, letters.define
a = letters("a", n, 1, "what a stretch says by itself")
F = letters("F", n, n, "moves a predicted error through a stretch")
D = letters("D", n, n, "how much the stretch says by itself", symmetric=True)
a_1 = letters("a_1", n, 1, "the same of the first of two stretches")
F_1 = letters("F_1", n, n, "the same of the first")
D_1 = letters("D_1", n, n, "the same of the first", symmetric=True)
a_2 = letters("a_2", n, 1, "the same of the second")
F_2 = letters("F_2", n, n, "the same of the second")
D_2 = letters("D_2", n, n, "the same of the second", symmetric=True)
lamda_2 = letters("lamda_2", n, 1, "what is said where the second begins")
Lambda_2 = letters("Lambda_2", n, n, "how much is said there", symmetric=True)

PAGE = (
    """One row maps what later rows say to what it and they say together.""",
    is_theta,
    is_Theta,
    is_lamda,
    is_Lambda,
    is_F := define(F, As * Y),
    is_Y := define(Y, I - K * C),
    is_a := define(a, C.T * W * innovation),
    is_D := define(D, C.T * W * C),
    chain(
        "",
        "a row maps the vector",
        lamda,
        Line(C.T * W * innovation + Y.T * theta, by=(is_lamda,)),
        Line(C.T * W * innovation + Y.T * As.T * lamda_next, by=(is_theta,)),
        Line(a + F.T * lamda_next, by=(is_a, is_F)),
    ),
    chain(
        "",
        "a row maps the matrix",
        Lambda,
        Line(C.T * W * C + Y.T * Theta * Y, by=(is_Lambda,)),
        Line(C.T * W * C + Y.T * As.T * Lambda_next * As * Y, by=(is_Theta,)),
        Line(D + F.T * Lambda_next * F, by=(is_D, is_F)),
    ),
    moved := chain(
        "",
        "what the row makes of a predicted error",
        F,
        Line(As * Y, by=(is_F,)),
        Line(As * (I - K * C), by=(is_Y,)),
        Line(As - As * K * C, why="multiply out"),
    ),
    """Stretches of rows map in the same form, with their own `a`, `F` and `D`. One
    stretch behind another is a stretch again.""",
    second_vector := define(lamda_2, a_2 + F_2.T * lamda_next),
    second_matrix := define(Lambda_2, D_2 + F_2.T * Lambda_next * F_2),
    vector := chain(
        "",
        "two stretches map the vector as one",
        a_1 + F_1.T * lamda_2,
        Line(a_1 + F_1.T * (a_2 + F_2.T * lamda_next), by=(second_vector,)),
        Line((a_1 + F_1.T * a_2) + (F_2 * F_1).T * lamda_next, why="collect"),
    ),
    chain(
        "",
        "two stretches map the matrix as one",
        D_1 + F_1.T * Lambda_2 * F_1,
        Line(D_1 + F_1.T * (D_2 + F_2.T * Lambda_next * F_2) * F_1, (second_matrix,)),
        Line(
            (D_1 + F_1.T * D_2 * F_1) + (F_2 * F_1).T * Lambda_next * (F_2 * F_1),
            why="collect",
        ),
    ),
)
JOINED = (
    "So these are the parts of the joined map.",
    joined_a := define(a, a_1 + F_1.T * a_2),
    joined_F := define(F, F_2 * F_1),
    joined_D := define(D, D_1 + F_1.T * D_2 * F_1),
)


@cache
def row():
    """What a row by itself says, and what it makes of what later ones say."""
    return Derivation(
        (As, C, K, W, innovation),
        (
            Stage(a, is_a.right, by=(is_a,)),
            Stage(F, moved.right, by=(moved,)),
            Stage(D, is_D.right, symmetric=True, by=(is_D,)),
        ),
        source="our own",
        letters=letters,
        says="what one row says",
    )


@cache
def joined():
    """Two stretches of rows as one, the second behind the first."""
    return Derivation(
        (a_1, F_1, D_1, a_2, F_2, D_2),
        (
            Stage(a, joined_a.right, by=(joined_a,)),
            Stage(F, joined_F.right, by=(joined_F,)),
            Stage(D, joined_D.right, symmetric=True, by=(joined_D,)),
        ),
        source="our own",
        letters=letters,
        says="two stretches of rows as one",
    )


@cache
def derive():
    """The page."""
    page = (*PAGE, row(), *JOINED, joined())
    return Derivation(page=page, letters=letters, source="our own")
