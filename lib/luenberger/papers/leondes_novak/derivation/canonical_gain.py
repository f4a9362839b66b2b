"""The gain of least error trace in the coordinates of the paper, block by block.

The unbiased estimates that keep the accurate outputs are a family in two gains, and the
error trace is a quadratic in them.  Its gradients are one linear equation, whose
solution is the minimum, because the trace is a completed square around it.

Source: Leondes and Novak (1974), section III, (24)-(33).
"""

from functools import cache

from sympy import Trace, eye, zeros

from matrixproof import BlockMatrix, Derivation, Substitute, ZeroMatrix, plus

from .coordinates import is_H, split_v
from .huddle import seen
from .letters import *
from .quadratic import is_Omega, is_Sigma
from .stochastic_system import is_Q

T_any = letters("T_any", r, n, "what an observer might follow")
T_1 = letters("T_1", r, m1, "its columns for the accurate outputs")
T_2 = letters("T_2", r, r, "its other columns")
zero, kept, rest = ZeroMatrix, Identity(m1), Identity(r)


def split(whole, *parts):
    """A column as its parts, by definition."""
    return define(whole, BlockMatrix([[part] for part in parts]))


def trace_of(X):
    """The part of the trace in which the gains are, for both gains X."""
    return plus(Trace(X * M * X.T), -2 * Trace(N_low * X.T))


FAMILY = (
    """The accurate outputs are kept as they are, so the observer follows the other
    states alone. Two gains are free.""",
    is_P := define(P, BlockMatrix([[zero(m1, r)], [rest]]), "24"),
    is_V := define(V, BlockMatrix([[kept, zero(m1, p2)], [K_1, K_2]]), "24"),
    split_y := split(y, y_1, y_2),
    letters.derive(
        "24", "the estimate keeps the accurate outputs", P * z + V * y
    ).multiply(is_P, is_V, split_y),
    """The measurement matrix has the form of (18). What the observer follows is then
    fixed by unbiasedness.""",
    is_H,
    is_T := define(T, BlockMatrix([[-K_1, rest - K_2 * H_2]]), "25"),
    letters.derive("13, 25", "the estimate is unbiased", P * T + V * H).multiply(
        is_P, is_T, is_V, is_H
    ),
    is_any := define(T_any, BlockMatrix([[T_1, T_2]])),
    letters.derive(
        "25", "it is unbiased for no other choice", P * T_any + V * H
    ).multiply(is_P, is_any, is_V, is_H),
    """The lower row is `[0, I]` only for `T_1 = - K_1` and `T_2 = I - K_2 H_2`. The
    error of the estimate is the noise of the accurate outputs, and below it the
    observer's own error with the noise that the gains let in.""",
    split_v,
    letters.derive("26", "the error", P * eps + V * v).multiply(is_P, is_V, split_v),
    is_R := define(
        R, BlockMatrix([[R_11, R_21.T], [R_21, R_22]]), "31", name="the blocks of R"
    ),
    is_K_low := define(K_low, BlockMatrix([[K_1, K_2]]), "33"),
    chain(
        "27",
        "the error trace",
        Trace(P * X * P.T + V * R * V.T),
        Substitute(
            plus(Trace(R_11), Trace(X + K_low * R * K_low.T)),
            by=(is_P, is_V, is_R, is_K_low),
        ),
    ),
)

TRACE = (
    """The observer errs as the prediction does, seen through `T`. Its covariance is
    therefore that of the prediction between `T` and its transpose. This matrix,
    `Omega`, has no gain of the next instant in it.""",
    is_Sigma,
    is_Q,
    apart := moment(e * w.T, zero(n, n)),
    is_Omega,
    letters.derive(
        "28, 29", "the covariance of the observer's error", eps_next * eps_next.T
    )
    .put(seen)
    .expect(is_Sigma, is_Q, apart)
    .fold(is_Omega),
    in_blocks := define(
        Omega,
        BlockMatrix([[Omega_11, Omega_21.T], [Omega_21, Omega_22]]),
        "29",
        name="the blocks of Ω",
    ),
    """Both parts of the trace, multiplied out, are what (30) should print.""",
    noise_part := letters.derive(
        "30", "the noise in the trace", Trace(V * R * V.T)
    ).multiply(is_V, is_R),
    prediction_part := letters.derive(
        "30", "the prediction in the trace", Trace(T * Omega * T.T)
    ).multiply(is_T, in_blocks),
    """With letters for the matrices in (33) the ten traces are four. The matrix `M` is
    the covariance of the innovation, and `N_low` holds the lower rows of what the
    Kalman filter multiplies its inverse with.""",
    M_blocks := define(
        M,
        BlockMatrix(
            [
                [Omega_11 + R_11, R_21.T + Omega_21.T * H_2.T],
                [R_21 + H_2 * Omega_21, R_22 + H_2 * Omega_22 * H_2.T],
            ]
        ),
        "33",
        name="the blocks of M",
    ),
    N_blocks := define(N_low, BlockMatrix([[Omega_21, Omega_22 * H_2.T]]), "33"),
    chain(
        "31, 33",
        "the covariance of the innovation",
        H * Omega * H.T + R,
        Substitute(M, by=(is_H, in_blocks, is_R, M_blocks)),
    ),
    chain(
        "33",
        "the lower rows of the Kalman gain",
        P.T * Omega * H.T,
        Substitute(N_low, by=(is_P, is_H, in_blocks, N_blocks)),
    ),
    chain(
        "30",
        "the trace is a quadratic in both gains",
        plus(Trace(V * R * V.T), Trace(T * Omega * T.T)),
        Substitute(
            plus(
                Trace(R_11),
                Trace(Omega_22),
                Trace(K_low * M * K_low.T),
                -2 * Trace(N_low * K_low.T),
            ),
            by=(is_V, is_R, is_T, in_blocks, M_blocks, N_blocks, is_K_low),
        ),
    ),
)

MINIMUM = (
    """The gradient in both gains at once is linear. Set to zero and written in blocks,
    it is the pair of coupled equations (32).""",
    slope := letters.derive(
        "32", "the gradient in both gains", trace_of(K_low)
    ).gradient(K_low, held=(M, N_low)),
    coupled := letters.derive("32", "the coupled equations", K_low * M - N_low)
    .multiply(is_K_low, M_blocks, N_blocks)
    .factor(),
    """Gains that solve them are the minimum, because the trace is a completed square
    around these: it needs no inverse but that of `M`, and no second derivative.""",
    is_K_star := slope.solve(K_low, "33", name=K_star),
    square := letters.derive("33", "the completed square", trace_of(K_low)).square(
        K_low, is_K_star
    ),
    root := define(M, L_M * L_M.T),
    letters.derive("33", "no gains do better", square.right).drop(root),
    letters.derive("33", "the gains", K_star).by(N_low * M.I, is_K_star),
)


WITNESS = {Sigma: zeros(2, 2), L_M: eye(2)}


@cache
def derive():
    """The page."""
    page = (*FAMILY, *TRACE, *MINIMUM)
    source = f"{SOURCE}, section III"
    return Derivation(page=page, letters=letters, source=source, witness=WITNESS)
