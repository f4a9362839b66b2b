"""The score by blocks: a row of the pass back over a record.

What the next state and the measurement have in common is taken apart again.  So it is
passed over one reading at a time.

Source: our own; see `score`.
"""

from functools import cache

from matrixproof import BlockMatrix, Derivation, Page, Stage, Substitute

from .letters import *
from .score import SOURCE, half, is_h, is_k, is_Pi_J, is_Z

page = Page(letters=letters, source=SOURCE)

page("""The gradients of a row are those of the page on the score. By blocks they are
    the following. Products that come back have letters.""")
page(is_Z, is_k, is_Pi_J, is_h)
is_F = page(let(F, A - G * C))
is_T = page(let(T, Pi_next * F))
is_V = page(let(V, W * C))
is_Y = page(let(Y, Pi_next * G))
is_eta = page(let(eta, A.T * eta_next + C.T * h))
is_Pi = page(let(Pi, F.T * T + C.T * V))
is_gQ = page(let(gQ, half * (eta_next * eta_next.T - Pi_next)))
is_gS = page(let(gS, eta_next * h.T + Y))
is_gR = page(let(gR, half * (h * h.T - W - G.T * Y)))
page.chain(
    "",
    "the gradient in the prediction, by blocks",
    Z.T * k,
    Substitute(eta, by=(is_Z, is_k, is_eta)),
)
page.chain(
    "",
    "what the record tells, by blocks",
    Z.T * Pi_J * Z,
    Substitute(Pi, by=(is_Z, is_Pi_J, is_Pi, is_T, is_V, is_F)),
)

page("""Off the diagonal of `J` stand `S` and its transpose. A change of `S` is one of
    both, so its gradient is twice the block.""")
page.chain(
    "",
    "the gradients in the covariances of the noises, by blocks",
    half * (k * k.T - Pi_J),
    Substitute(
        BlockMatrix([[gQ, half * gS], [half * gS.T, gR]]),
        by=(is_k, is_Pi_J, is_gQ, is_gS, is_gR, is_Y),
    ),
)

page("""One reading at a time is the same for a row that has one output and moves
    nothing, `A = I` and no `Q`; a prediction is one that has none. So a pass over the
    readings of a row finds its `eta` and `Pi`, and of `h` and `W + G' Pi_next G` the
    entries of each reading. Those of two readings are what both have in common: the
    later one moves the gradient that the earlier one meets.""")


@cache
def score_step():
    """A row, from the last to the first: eta, Pi and the gradients it adds."""
    return Derivation(
        (A, C, G, W, e, eta_next, Pi_next),
        (
            Stage(h, e - G.T * eta_next, by=(is_h,)),
            Stage(eta, A.T * eta_next + C.T * h, by=(is_eta,)),
            Stage(F, A - G * C, by=(is_F,)),
            Stage(T, Pi_next * F, by=(is_T,)),
            Stage(V, W * C, by=(is_V,)),
            Stage(Pi, F.T * T + C.T * V, symmetric=True, by=(is_Pi,)),
            Stage(Y, Pi_next * G, by=(is_Y,)),
            Stage(gQ, is_gQ.right, symmetric=True, by=(is_gQ,)),
            Stage(gR, is_gR.right, symmetric=True, by=(is_gR,)),
            Stage(gS, is_gS.right, by=(is_gS,)),
        ),
        source=SOURCE,
        letters=letters,
        says="a row of the score",
    )


page(score_step())
