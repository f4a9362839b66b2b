"""The score by blocks: a row of the pass back over a record.

What the next state and the measurement have in common is taken apart again, and what
comes back in several gradients gets a letter.

Source: our own; see `score`.
"""

from functools import cache

from ...symbolic import BlockMatrix, Derivation, Gradient, Line, Stage, Substitute
from .letters import *
from .score import (
    SOURCE,
    Pi_of_both,
    by_both,
    half,
    is_G,
    is_h,
    is_k,
    is_N,
    is_Pi_J,
    is_x_s,
    is_Z,
    of_one_row,
)

BLOCKS = (
    """The gradients of a row are those of the page on the score. By blocks they are the
    following. Products that come back have letters.""",
    is_Z,
    is_k,
    is_Pi_J,
    is_G,
    is_W := define(W * M, Identity(p)),
    is_N,
    is_h,
    is_x_s,
    is_F := define(F, A - G * C),
    is_T := define(T, Pi_next * F),
    is_V := define(V, W * C),
    is_U := define(U, V - G.T * T),
    is_Y := define(Y, Pi_next * G),
    is_eta := define(eta, A.T * eta_next + C.T * h),
    is_Pi := define(Pi, F.T * T + C.T * V),
    is_gA := define(gA, eta_next * x_s.T - T * Omega),
    is_gC := define(gC, h * x_s.T - U * Omega),
    is_gB := define(gB, eta_next * u.T),
    is_gE := define(gE, h * u.T),
    is_gQ := define(gQ, half * (eta_next * eta_next.T - Pi_next)),
    is_gS := define(gS, eta_next * h.T + Y),
    is_gR := define(gR, half * (h * h.T - W - G.T * Y)),
    chain(
        "",
        "the gradient in the prediction, by blocks",
        Z.T * k,
        Substitute(eta, by=(is_Z, is_k, is_eta)),
    ),
    chain(
        "",
        "what the record tells, by blocks",
        Z.T * Pi_J * Z,
        Substitute(Pi, by=(is_Z, is_Pi_J, is_Pi, is_T, is_V, is_F)),
    ),
    chain(
        "",
        "the gradients in what moves and what is measured, by blocks",
        k * x_s.T - Pi_J * Z * Omega,
        Substitute(
            BlockMatrix([[gA], [gC]]),
            by=(is_Z, is_k, is_Pi_J, is_gA, is_gC, is_U, is_T, is_V, is_F),
        ),
    ),
    chain(
        "",
        "the gradients in what the input does, by blocks",
        k * u.T,
        Substitute(BlockMatrix([[gB], [gE]]), by=(is_k, is_gB, is_gE)),
    ),
    """Off the diagonal of `J` stand `S` and its transpose. A change of `S` is one of
    both, so its gradient is twice the block.""",
    chain(
        "",
        "the gradients in the covariances of the noises, by blocks",
        half * (k * k.T - Pi_J),
        Substitute(
            BlockMatrix([[gQ, half * gS], [half * gS.T, gR]]),
            by=(is_k, is_Pi_J, is_gQ, is_gS, is_gR, is_Y),
        ),
    ),
)


STAGES = (
    Stage(h, e - G.T * eta_next, by=(is_h,)),
    Stage(eta, A.T * eta_next + C.T * h, by=(is_eta,)),
    Stage(F, A - G * C, by=(is_F,)),
    Stage(T, Pi_next * F, by=(is_T,)),
    Stage(V, W * C, by=(is_V,)),
    Stage(Pi, F.T * T + C.T * V, symmetric=True, by=(is_Pi,)),
    Stage(x_s, x + Omega * eta, by=(is_x_s,)),
    Stage(U, V - G.T * T, by=(is_U,)),
    Stage(Y, Pi_next * G, by=(is_Y,)),
    Stage(gA, eta_next * x_s.T - T * Omega, by=(is_gA,)),
    Stage(gB, eta_next * u.T, by=(is_gB,)),
    Stage(gC, h * x_s.T - U * Omega, by=(is_gC,)),
    Stage(gE, h * u.T, by=(is_gE,)),
    Stage(gQ, is_gQ.right, symmetric=True, by=(is_gQ,)),
    Stage(gR, is_gR.right, symmetric=True, by=(is_gR,)),
    Stage(gS, is_gS.right, by=(is_gS,)),
)


@cache
def score_step():
    """A row, from the last to the first: eta, Pi and the gradients it adds.

    W (p, p) has zeros for outputs that do not count, and so have G and e; they meet
    every row of C.
    """
    return Derivation(
        (A, C, Omega, G, W, e, x, u, eta_next, Pi_next),
        STAGES,
        source=SOURCE,
        letters=letters,
        says="a row of the score",
    )


@cache
def score_pass():
    """The same, with the gain made of the covariances; S may have any columns there."""
    return Derivation(
        (A, C, S, Omega, W, e, x, u, eta_next, Pi_next),
        (
            Stage(N, A * Omega * C.T + S, by=(is_N,)),
            Stage(G, N * W, by=(is_G, is_W)),
            *STAGES,
        ),
        source=SOURCE,
        letters=letters,
        says="a row of the score, with its gain",
    )


START = (
    """What is known of the state at instant 0 is a prediction that was corrected, so
    its mean has the gradient `eta`, and its covariance the following one.""",
    by_both,
    Pi_of_both,
    is_gP := define(gP, half * (eta * eta.T - Pi)),
    chain(
        "",
        "the gradient in the covariance of the start",
        of_one_row,
        Gradient(
            half * (Z.T * k * k.T * Z - Z.T * Pi_J * Z), of=Omega, held=(k, Pi_J, Z)
        ),
        Line(gP, by=(by_both, Pi_of_both, is_gP)),
    ),
)


@cache
def start_score():
    """The gradient in the covariance of the start."""
    return Derivation(
        (eta, Pi),
        (Stage(gP, is_gP.right, symmetric=True, by=(is_gP,)),),
        source=SOURCE,
        letters=letters,
        says="the score of the start",
    )


@cache
def derive():
    """The page."""
    lists = score_step(), score_pass()
    page = (*BLOCKS, *lists, *START, start_score())
    return Derivation(page=page, letters=letters, source=SOURCE)
