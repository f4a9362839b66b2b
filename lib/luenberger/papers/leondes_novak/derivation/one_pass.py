"""One step of a filter over a record, as one stage list that compiled loops run.

The step is that of the gain and that of the estimate, with the covariance written for
speed.

Source: Leondes and Novak (1974), (27), (33), (43); the rest is our own.
"""

from functools import cache

from ....symbolic import Derivation, Expect, Identity, Line, Solve, Stage
from .best_coordinates import gain_stage
from .estimate import (
    before,
    corrects,
    innovation,
    is_innovation,
    is_minus,
    is_rho_next,
    rho,
    rho_next,
    running,
    truth_next,
    x_minus,
)
from .letters import *
from .quadratic import apart, is_Kmv, is_M, is_N, is_Q, is_Sigma, is_Sigma_next, is_Y

loop = running.here(Q="covariance of the process noise that is left")
chain, define = loop.chain, loop.define
Z = loop("Z", n, n, "what the gain leaves of `Omega`")
known = loop("known", p, 1, "measurement less what the input does to it")
W = loop("W", p, p, "how much an innovation says", symmetric=True)

STEP = (
    """A step over a record first predicts. The prediction errs as on the page on the
    estimate. Here `Q` is the covariance of the process noise that is left once the
    measurement noise has told its part.""",
    is_Sigma,
    is_Q,
    apart,
    is_Omega := define(Omega, As * Sigma * As.T + Q, "44"),
    chain(
        "43, 44",
        "the covariance of the prediction",
        (x_minus - truth_next) * (x_minus - truth_next).T,
        Line((As * e - w) * (As * e - w).T, by=(before,)),
        Expect(As * Sigma * As.T + Q, moments=(is_Sigma, is_Q, apart)),
        Line(Omega, by=(is_Omega,)),
    ),
    """Then comes the gain of the page on the best coordinates, and the covariance that
    it leaves. Written with `Z`, the covariance takes some `n^2 p` multiplications
    instead of `n^3`. The formula holds for any gain, so an error in the gain is no more
    amplified than before.""",
    is_N,
    is_M,
    is_Kmv,
    is_Y,
    is_Sigma_next,
    is_Z := define(Z, Omega - K * N.T),
    quick := chain(
        "27",
        "the covariance in fewer multiplications",
        Y * Omega * Y.T + K * R * K.T,
        Line((I - K * C) * Omega * (I - K * C).T + K * R * K.T, by=(is_Y,)),
        Line(
            Omega - K * C * Omega - (Omega - K * C * Omega) * C.T * K.T + K * R * K.T,
            why="multiply out",
        ),
        Line(Omega - K * N.T - (Omega - K * N.T) * C.T * K.T + K * R * K.T, by=(is_N,)),
        Line(Z - Z * C.T * K.T + K * R * K.T, by=(is_Z,)),
        Line(Z - (Z * C.T - K * R) * K.T, why="factor"),
    ),
    """The estimate is corrected as on its own page. What the input does to the
    measurement is subtracted only once.""",
    is_minus,
    is_known := define(known, y - E * u_next),
    is_innovation,
    corrects,
    is_rho_next,
)
SAID = (
    """A smoother needs of each row how much its innovation says.""",
    is_W := define(W * M, Identity(p)),
)

TO_Z = (
    Stage(N, Omega * C.T, by=(is_N,)),
    Stage(M, C * N + R, "(33)", symmetric=True, by=(is_M, is_N)),
    Stage(Kmv, Solve(N, M), "(33)", by=(is_Kmv,)),
    gain_stage,
    Stage(Z, Omega - K * N.T, by=(is_Z,)),
)


@cache
def filter_step() -> Derivation:
    """Sigma, x, rho at i and y at i + 1 to the gain, Sigma, x, rho at i + 1.

    As and Q are those after decorrelation; without S, As is A.
    """
    return Derivation(
        (A, As, Q, B, J, C, R, E, Gamma, Sigma, x, rho, u, y, u_next),
        (
            Stage(Omega, is_Omega.right, "(44)", symmetric=True, by=(is_Omega,)),
            *TO_Z,
            Stage(
                Sigma_next,
                quick.right,
                "(27)",
                symmetric=True,
                by=(is_Sigma_next, quick),
            ),
            Stage(x_minus, A * x + B * u + J * rho, "(43)", by=(is_minus,)),
            Stage(known, y - E * u_next, by=(is_known,)),
            Stage(
                innovation, known - C * x_minus, "(43)", by=(is_innovation, is_known)
            ),
            Stage(x_next, x_minus + K * innovation, "(43)", by=(corrects,)),
            Stage(rho_next, known - C * x_next, by=(is_rho_next, is_known)),
        ),
        source=SOURCE,
        letters=loop,
        says="one step of a filter over a record",
    )


@cache
def kept_step():
    """The same step, and W, from which a smoother goes on."""
    step = filter_step()
    return Derivation(
        step.given,
        (*step.stages, Stage(W, Solve(Identity(p), M), symmetric=True, by=(is_W,))),
        source=SOURCE,
        letters=loop,
        says="one step of a filter over a record that is smoothed later",
    )


@cache
def derive():
    """The page."""
    page = (*STEP, filter_step(), *SAID, kept_step())
    return Derivation(page=page, letters=loop, source=f"{SOURCE}, (27), (33), (43)")
