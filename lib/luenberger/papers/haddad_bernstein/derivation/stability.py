"""Is an estimator built from (3.14)-(3.17) stable?

Its dual moment leaves it the open disk, and those modes of modulus one that its output
does not show.  So it is stable if it is observable, as in the paper's admissible set;
or if the joint covariance of the noises is definite.  A definite moment and a definite
dual alone are not enough (`counterexamples`).

Source: our own.
"""

from sympy import Trace

from matrixproof import (
    BlockMatrix,
    Page,
    ZeroMatrix,
)

from .augmented import (
    is_At,
    is_Bt,
    is_N2,
    is_N12,
    is_steady,
    is_W,
    is_Wt,
    moments,
)
from .cost import duals, is_M2
from .equations import is_root as is_root_Qt
from .equations import is_root_R, is_root_V
from .letters import l, letters, n, r
from .letters.both import P2, Q2, Q12, At, Bt, Qt, W, Wt, both
from .letters.estimator import Ae, Be, Ce
from .letters.plant import A, C
from .letters.theorem import G, Gam
from .mean_square import M_c, c, k, turn
from .stationarity import is_Ae, is_Q12, is_Qe, next_split, split

Phi = letters("Phi", r, r, "what the estimator tracks moves by this")
V_e = letters("V_e", r, k, "spans the real modes of one eigenvalue of the estimator")
V_w = letters("V_w", both, k, "spans those of one eigenvalue of `A_tilde'`")
V_x = letters("V_x", n, k, "its rows for the plant")
W_r = letters("H_W", n + l, n + l, "a root of `W`")


def grown(says, X, F, V, by):
    """What a matrix shows of modes, less what it shows of them one step on."""
    shown = letters.derive("", says, Trace(V.T * (X - F * X * F.T) * V))
    return shown.use(by).use(turn)


MODES = {W_r: [[0, 0], [-1, 0]], M_c: [[1, 0], [0, -1]], Qt: [[1, 0], [0, 1]]}


page = Page(letters=letters, source="our own", witness={Ce: [1, 0], **MODES})

page("""Let `V_e` span the real modes of an eigenvalue of `A_e`, and `c` be its squared
    modulus. The dual of the estimator's moment is driven by what its output shows.""")
page(turn, is_Ae)
own = page.suppose(Ae * V_e, V_e * M_c)
page(is_M2, is_root_R)
loses = page(grown("what the dual shows of the modes", P2, Ae.T, V_e, own))
page(
    letters.derive(
        "4.7",
        "the estimator's modes lie in the closed disk",
        (1 - c) * Trace(V_e.T * P2 * V_e),
    )
    .fold(loses)
    .fold(duals)
    .put(is_M2)
    .drop(is_root_R)
)

page("""So `c` is at most 1, because `P_2` is definite. Where it is 1, the square is
    zero: `C_e V_e = 0`. An observable estimator has no such modes, so it is stable.""")

page("""Before a measurement corrects it, the estimator moves by `Phi`. The moments are
    driven by the innovation alone.""")
is_Phi = page.let(Phi, Gam * A * G.T)
page(is_Q12, is_Qe, is_N2, is_N12)
corrected = page(
    letters.derive("3.10'", "the estimator before its correction", Phi - Be * C * G.T)
    .put(is_Phi)
    .fold(is_Ae)
)
inner = page(
    letters.derive("4.6", "the moment of the estimator by the innovation", Q2)
    .put(moments)
    .put(is_N2)
    .use(is_Q12)
    .fold(corrected)
    .use(split, is_Qe)
)
mixed = page(
    letters.derive("4.6", "the mixed moment by the innovation", Q12)
    .put(moments)
    .put(is_N12)
    .fold(corrected)
    .put(is_Q12, next_split)
    .use(is_Qe)
)

page("So the modes of `Phi` lie in the closed disk as well.")
page(is_root_V)
turned = page.suppose(Phi.T * V_e, V_e * M_c)
shows = page(grown("what the moment shows of the modes", Q2, Phi, V_e, turned))
page(
    letters.derive(
        "4.6",
        "the modes before the correction lie in the closed disk",
        (1 - c) * Trace(V_e.T * Q2 * V_e),
    )
    .fold(shows)
    .use(inner)
    .drop(is_root_V)
)

page("""Where `c` is 1, the square is zero: `B_e' V_e = 0`. Then `G' Q_2 V_e` spans
    modes of the plant. The plant is stable and has none of modulus one, so `Phi` has
    none.""")
unmoved = page.suppose(Be.T * V_e, ZeroMatrix(l, k))
page(
    letters.derive(
        "", "modes before the correction are modes of the plant", G.T * Q2 * V_e
    )
    .fold(is_Q12)
    .put(mixed)
    .use(unmoved, turned)
)

page("""The estimator is stable also if the joint covariance of the noises is definite,
    whether it is observable or not. Let `V_w` span modes of plant and estimator
    together. What the moment shows of them is driven by the noises.""")
page(is_At, is_Bt, is_W, is_Wt, is_root_Qt)
is_root_W = page.suppose(W, W_r * W_r.T)
page(is_steady)
joint = page.suppose(At.T * V_w, V_w * M_c)
whole = page(grown("what the moment of both shows of the modes", Qt, At, V_w, joint))
says = "the covariance of the additive noise from that of the noises"
reached = page(
    letters.derive("section 2", says, Wt).by(Bt * W * Bt.T, is_Wt, is_Bt, is_W)
)
page(
    letters.derive(
        "4.4",
        "the modes of both lie in the closed disk",
        (1 - c) * Trace(V_w.T * Qt * V_w),
        witness=MODES,
    )
    .fold(whole)
    .fold(is_steady)
    .drop(is_root_Qt)
    .use(reached)
    .drop(is_root_W)
)

page("""Where `c` is 1, both squares are zero, and with `W` definite `B_tilde' V_w = 0`.
    By blocks this is `V_x = 0` and `B_e' V_e = 0`.""")
by_rows = page.suppose(V_w, BlockMatrix([[V_x], [V_e]]))
page(
    letters.derive("section 2", "how the noises reach the modes", Bt.T * V_w).multiply(
        is_Bt, by_rows
    )
)

page("""A mode of `A_e'` of modulus one has such a `V_w`, because `A` has no mode in
    common with it. So it is not corrected, and it would be one of `Phi'`, which has
    none.""")
seen = page.suppose(Ae.T * V_e, V_e * M_c)
solved = page.suppose(A.T * V_x + C.T * Be.T * V_e, V_x * M_c)
page(
    letters.derive(
        "section 2", "the modes of both from those of the estimator", At.T * V_w
    )
    .multiply(is_At, by_rows)
    .use(solved, seen)
    .by(V_w * M_c, by_rows)
)
page(
    letters.derive("3.10'", "a mode that is not corrected", Phi.T * V_e)
    .use(corrected)
    .use(unmoved)
    .use(seen)
)
