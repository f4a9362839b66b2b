"""The smoother over a long record, in fewer multiplications.

What a row says of its prediction is not formed: the gain of the next row is taken off
what moves this row's error there, so how much is said goes from estimate to estimate.

Source: our own.
"""

from functools import cache

from ...symbolic import Derivation, Line, Stage
from .adjoint import (
    HANDS_ON,
    SMOOTHS,
    SPEAKS,
    Ahead_next,
    is_Left,
    is_New,
    is_new,
    is_Theta,
    is_theta,
)
from .adjoint import letters as smoothed
from .letters import *

letters = smoothed.here()
chain, define = letters.chain, letters.define
C_next = letters("C_next", p, n, "what is measured one step on")
K_next = letters("K_next", n, p, "the gain there")
Y_next = letters("Y_next", n, n, "what it leaves of a predicted error")
W_next = letters("W_next", p, p, "how much the innovation says there", symmetric=True)
Theta_next = letters("Theta_next", n, n, "`Theta` one step on", symmetric=True)
Seen = letters("Seen", p, n, "what the next row measures of this row's error")
Past = letters("Past", n, n, "what its gain leaves of this row's error")

PAGE = (
    """How much later rows say of the next prediction is what the next row says, and
    what its gain leaves of what is said of its estimate. With a gain on either side
    of a matrix that takes some `3.5 n^2 p` multiplications.""",
    is_Theta,
    is_Y_next := define(Y_next, I - K_next * C_next),
    one_step_on := define(
        Lambda_next, C_next.T * W_next * C_next + Y_next.T * Theta_next * Y_next
    ),
    """The gain may be taken off what moves the error instead. That takes some
    `1.5 n^2 p`, as `Seen` does not change where the plant does not.""",
    is_Seen := define(Seen, C_next * As),
    is_Past := define(Past, Y_next * As),
    quick_Past := chain(
        "",
        "what the next gain leaves of this row's error",
        Past,
        Line(Y_next * As, by=(is_Past,)),
        Line((I - K_next * C_next) * As, by=(is_Y_next,)),
        Line(As - K_next * C_next * As, why="multiply out"),
        Line(As - K_next * Seen, by=(is_Seen,)),
    ),
    quick_Theta := chain(
        "",
        "how much later rows say, in fewer multiplications",
        Theta,
        Line(As.T * Lambda_next * As, by=(is_Theta,)),
        Line(
            As.T * (C_next.T * W_next * C_next + Y_next.T * Theta_next * Y_next) * As,
            by=(one_step_on,),
        ),
        Line(
            (C_next * As).T * W_next * (C_next * As)
            + (Y_next * As).T * Theta_next * (Y_next * As),
            why="multiply out",
        ),
        Line(Seen.T * W_next * Seen + Past.T * Theta_next * Past, (is_Seen, is_Past)),
    ),
    "All else is as it was: what later rows say of the estimate, and of the row.",
    is_theta,
    is_Left,
    is_new,
    is_New,
)


@cache
def handed_on():
    """How much a row and later ones say of its prediction."""
    return Derivation(
        (C, K, W, Theta),
        HANDS_ON,
        source="our own",
        letters=letters,
        says="how much a row hands on",
    )


@cache
def backward_loop():
    """The same row of a long record, from how much is said of the next estimate."""
    gain = K_next, W_next, Seen
    carried = lamda_next, Theta_next, Ahead_next
    return Derivation(
        (As, C, K, W, innovation, Sigma, x, *gain, *carried),
        (
            SPEAKS,
            Stage(Past, quick_Past.right, by=(quick_Past,)),
            Stage(Theta, quick_Theta.right, symmetric=True, by=(quick_Theta,)),
            *SMOOTHS,
        ),
        source="our own; Bryson and Frazier (1963)",
        letters=letters,
        says="one row of the smoother, in fewer multiplications",
    )


@cache
def derive():
    """The page."""
    page = (*PAGE, handed_on(), backward_loop())
    return Derivation(page=page, letters=letters, source="our own")
