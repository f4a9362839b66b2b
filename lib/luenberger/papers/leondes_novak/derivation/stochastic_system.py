"""The plant and its statistics.

The mean of the state moves without the noises, and its covariance with one of them.
What each assumption of the paper is good for is seen in the reasons of the lines.

Source: Leondes and Novak (1974), section I, (1)-(6).
"""

from functools import cache

from matrixproof import Derivation, Expect, Line, ZeroMatrix

from .letters import *

PAGE = (
    """The plant is linear, and what is measured of it as well. The paper has no
    feedthrough, `E = 0`; carrying it along costs nothing.""",
    plant := define(x_next, A * x + B * u + w, "1"),
    measured := define(y, C * x + E * u + v, "2"),
    """Both noises have mean zero and are white. The state has a mean and deviates from
    it. At the start its mean and the covariance of its deviation are given.""",
    mean_w := moment(w, ZeroMatrix(n, 1), "3"),
    mean_v := moment(v, ZeroMatrix(p, 1), "3"),
    mean_x := moment(x, x_bar, "6"),
    chain(
        "1, 3",
        "the mean of the state moves without the noise",
        x_next,
        Line(A * x + B * u + w, by=(plant,)),
        Expect(A * x_bar + B * u, moments=(mean_x, mean_w)),
    ),
    chain(
        "2, 3",
        "the mean of the measurement",
        y,
        Line(C * x + E * u + v, by=(measured,)),
        Expect(C * x_bar + E * u, moments=(mean_x, mean_v)),
    ),
    "So the deviation moves with the plant, and noise is added to it.",
    is_d := define(d, x - x_bar, "6"),
    deviation := chain(
        "1, 6",
        "the deviation from the mean",
        x_next - (A * x_bar + B * u),
        Line(A * x + B * u + w - A * x_bar - B * u, by=(plant,)),
        Line(A * (x - x_bar) + w, why="the input is known"),
        Line(A * d + w, by=(is_d,)),
    ),
    """The noise of an instant is independent of all that was before it. The covariance
    is then a sum of two terms.""",
    is_Sigma_x := moment(d * d.T, Sigma, "6"),
    is_Q := moment(w * w.T, Q, "4"),
    white := moment(d * w.T, ZeroMatrix(n, n), "4"),
    chain(
        "4, 6",
        "the covariance of the state",
        (A * d + w) * (A * d + w).T,
        Expect(A * Sigma * A.T + Q, moments=(is_Sigma_x, is_Q, white)),
    ),
    """A measurement has the covariance of what it shows and of its noise. The two are
    independent, because the measurement noise is white and independent of the process
    noise.""",
    is_R := moment(v * v.T, R, "4"),
    apart := moment(d * v.T, ZeroMatrix(n, p), "5"),
    chain(
        "4, 5",
        "the covariance of the measurement",
        (C * d + v) * (C * d + v).T,
        Expect(C * Sigma * C.T + R, moments=(is_Sigma_x, is_R, apart)),
    ),
)


@cache
def derive():
    """The page."""
    return Derivation(page=PAGE, letters=letters, source=f"{SOURCE}, section I")
