"""The gain of least error trace in the coordinates of the paper, block by block.

The unbiased estimates that keep the accurate outputs are a family in two gains, and the
error trace is a quadratic in them.  Its gradients are one linear equation, whose
solution is the minimum, because the trace is a completed square around it.

Source: Leondes and Novak (1974), section III, (24)-(33).
"""

from sympy import Trace, eye, zeros

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix
from matrixproof.symbols import plus

from .coordinates import is_H, split_v
from .huddle import seen
from .letters import SOURCE, letters, m1, n, p, p2, r
from .letters.accurate import L_M
from .letters.canonical import (
    H_2,
    K_1,
    K_2,
    R_11,
    R_21,
    R_22,
    H,
    K_low,
    N_low,
    Omega_11,
    Omega_21,
    Omega_22,
)
from .letters.observer import P, T, V, X, eps, eps_next, z
from .letters.plant import R, v, w, y
from .letters.step import M, Omega, Sigma, e
from .quadratic import is_Omega, is_Sigma
from .stochastic_system import is_Q

letters = letters.here()
y_1 = letters("y_1", m1, 1, "accurate outputs")
y_2 = letters("y_2", p2, 1, "other outputs")
K_star = letters("K_star", r, p, "the gains of least trace")


T_any = letters("T_any", r, n, "what an observer might follow")
T_1 = letters("T_1", r, m1, "its columns for the accurate outputs")
T_2 = letters("T_2", r, r, "its other columns")
zero, kept, rest = ZeroMatrix, Identity(m1), Identity(r)


def split(whole, *parts):
    """A column as its parts, by definition."""
    return letters.suppose(whole, BlockMatrix([[part] for part in parts]))


def trace_of(X):
    """The part of the trace in which the gains are, for both gains X."""
    return plus(Trace(X * M * X.T), -2 * Trace(N_low * X.T))


WITNESS = {Sigma: zeros(2, 2), L_M: eye(2)}


page = Page(letters=letters, source=f"{SOURCE}, section III", witness=WITNESS)

page("""The accurate outputs are kept as they are, so the observer follows the other
    states alone. Two gains are free.""")
is_P = page.let(P, BlockMatrix([[zero(m1, r)], [rest]]), "24")
is_V = page.let(V, BlockMatrix([[kept, zero(m1, p2)], [K_1, K_2]]), "24")
split_y = page(split(y, y_1, y_2))
page(
    letters.derive(
        "24", "the estimate keeps the accurate outputs", P * z + V * y
    ).multiply(is_P, is_V, split_y)
)

page("""The measurement matrix has the form of (18). What the observer follows is then
    fixed by unbiasedness.""")
page(is_H)
is_T = page.let(T, BlockMatrix([[-K_1, rest - K_2 * H_2]]), "25")
page(
    letters.derive("13, 25", "the estimate is unbiased", P * T + V * H).multiply(
        is_P, is_T, is_V, is_H
    )
)
is_any = page.let(T_any, BlockMatrix([[T_1, T_2]]))
page(
    letters.derive(
        "25", "it is unbiased for no other choice", P * T_any + V * H
    ).multiply(is_P, is_any, is_V, is_H)
)

page("""The lower row is `[0, I]` only for `T_1 = - K_1` and `T_2 = I - K_2 H_2`. The
    error of the estimate is the noise of the accurate outputs, and below it the
    observer's own error with the noise that the gains let in.""")
page(split_v)
page(letters.derive("26", "the error", P * eps + V * v).multiply(is_P, is_V, split_v))
is_R = page.let(
    R, BlockMatrix([[R_11, R_21.T], [R_21, R_22]]), "31", name="the blocks of R"
)
is_K_low = page.let(K_low, BlockMatrix([[K_1, K_2]]), "33")
short = plus(Trace(R_11), Trace(X + K_low * R * K_low.T))
page(
    letters.derive("27", "the error trace", Trace(P * X * P.T + V * R * V.T)).by(
        short, is_P, is_V, is_R, is_K_low
    )
)


page("""The observer errs as the prediction does, seen through `T`. Its covariance is
    therefore that of the prediction between `T` and its transpose. This matrix,
    `Omega`, has no gain of the next instant in it.""")
page(is_Sigma, is_Q)
apart = page.moment(e * w.T, zero(n, n))
page(is_Omega)
page(
    letters.derive(
        "28, 29", "the covariance of the observer's error", eps_next * eps_next.T
    )
    .put(seen)
    .expect(is_Sigma, is_Q, apart)
    .fold(is_Omega)
)
in_blocks = page.suppose(
    Omega,
    BlockMatrix([[Omega_11, Omega_21.T], [Omega_21, Omega_22]]),
    "29",
    name="the blocks of Ω",
)

page("Both parts of the trace, multiplied out, are what (30) should print.")
noise_part = page(
    letters.derive("30", "the noise in the trace", Trace(V * R * V.T)).multiply(
        is_V, is_R
    )
)
prediction_part = page(
    letters.derive(
        "30", "the prediction in the trace", Trace(T * Omega * T.T)
    ).multiply(is_T, in_blocks)
)

page("""With letters for the matrices in (33) the ten traces are four. The matrix `M` is
    the covariance of the innovation, and `N_low` holds the lower rows of what the
    Kalman filter multiplies its inverse with.""")
M_blocks = page.let(
    M,
    BlockMatrix(
        [
            [Omega_11 + R_11, R_21.T + Omega_21.T * H_2.T],
            [R_21 + H_2 * Omega_21, R_22 + H_2 * Omega_22 * H_2.T],
        ]
    ),
    "33",
    name="the blocks of M",
)
N_blocks = page.let(N_low, BlockMatrix([[Omega_21, Omega_22 * H_2.T]]), "33")
innovation = H * Omega * H.T + R
page(
    letters.derive("31, 33", "the covariance of the innovation", innovation).by(
        M, is_H, in_blocks, is_R, M_blocks
    )
)
page(
    letters.derive("33", "the lower rows of the Kalman gain", P.T * Omega * H.T).by(
        N_low, is_P, is_H, in_blocks, N_blocks
    )
)
both = plus(Trace(V * R * V.T), Trace(T * Omega * T.T))
page(
    letters.derive("30", "the trace is a quadratic in both gains", both).by(
        plus(Trace(R_11), Trace(Omega_22), *trace_of(K_low).args),
        *(is_V, is_R, is_T, in_blocks, M_blocks, N_blocks, is_K_low),
    )
)

page("""The gradient in both gains at once is linear. Set to zero and written in blocks,
    it is the pair of coupled equations (32).""")
slope = page(
    letters.derive("32", "the gradient in both gains", trace_of(K_low)).gradient(
        K_low, held=(M, N_low)
    )
)
coupled = page(
    letters.derive("32", "the coupled equations", K_low * M - N_low)
    .multiply(is_K_low, M_blocks, N_blocks)
    .factor()
)

page("""Gains that solve them are the minimum, because the trace is a completed square
    around these: it needs no inverse but that of `M`, and no second derivative.""")
is_K_star = page(slope.solve(K_low, "33", name=K_star))
square = page(
    letters.derive("33", "the completed square", trace_of(K_low)).square(
        K_low, is_K_star
    )
)
root = page.suppose(M, L_M * L_M.T)
page(letters.derive("33", "no gains do better", square.right).drop(root))
page(letters.derive("33", "the gains", K_star).by(N_low * M.I, is_K_star))
