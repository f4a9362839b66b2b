"""Autocovariances of the innovations of any stable gain.

A predictor with any stable gain leaves innovations that need not be white.  Their
autocovariances are linear in the covariances of the noises, so those can be found from
these by least squares.

Source: Mehra (1970), "On the identification of variances and adaptive Kalman
filtering"; Odelson, Rajamani and Rawlings (2006), "A new autocovariance least-squares
method for estimating noise covariances", (5)-(11).
"""

from functools import cache

from matrixproof import Derivation, Expect, Line, Stage

from .any_gain_letters import *

SOURCE = "Mehra (1970); Odelson, Rajamani and Rawlings (2006)"

PAGE = (
    """Predict a state with any gain `L` for which the error dies out. What the inputs
    do is known and left out here.""",
    plant := define(x_next, A * x + w),
    measured := define(y, C * x + v),
    is_e := define(x_hat, x - e, name="the error of the prediction"),
    is_nu := define(nu, y - C * x_hat),
    predicts := define(x_hat_next, A * x_hat + L * nu),
    is_A_L := define(A_L, A - L * C),
    shows := chain(
        "",
        "what an innovation shows",
        nu,
        Line(y - C * x_hat, by=(is_nu,)),
        Line(C * x + v - C * (x - e), by=(measured, is_e)),
        Line(C * e + v, why="the state cancels"),
    ),
    moves := chain(
        "",
        "how the error moves",
        x_next - x_hat_next,
        Line(A * x + w - A * x_hat - L * nu, by=(plant, predicts)),
        Line(A * x + w - A * (x - e) - L * nu, by=(is_e,)),
        Line(A * e + w - L * (C * e + v), by=(shows,)),
        Line(A_L * e + w - L * v, by=(is_A_L,)),
    ),
    """Both noises are white, and independent of the error, which stems from earlier
    ones. What drives the error has a covariance that is linear in those of the
    noises.""",
    is_Q := moment(w * w.T, Q),
    is_R := moment(v * v.T, R),
    is_S := moment(w * v.T, S),
    is_P := moment(e * e.T, P),
    past_w := moment(e * w.T, ZeroMatrix(n, n)),
    past_v := moment(e * v.T, ZeroMatrix(n, p)),
    is_W := define(W, Q - S * L.T - L * S.T + L * R * L.T),
    drives := chain(
        "",
        "the covariance of what drives the error",
        (w - L * v) * (w - L * v).T,
        Expect(
            Q - S * L.T - L * S.T + L * R * L.T,
            moments=(is_Q, is_S, is_R),
        ),
        Line(W, by=(is_W,)),
    ),
    is_P_next := define(P_next, A_L * P * A_L.T + W),
    chain(
        "",
        "the covariance of the error",
        (A_L * e + w - L * v) * (A_L * e + w - L * v).T,
        Expect(
            A_L * P * A_L.T + Q - S * L.T - L * S.T + L * R * L.T,
            moments=(is_P, is_Q, is_S, is_R, past_w, past_v),
        ),
        Line(A_L * P * A_L.T + W, by=(is_W,)),
        Line(P_next, by=(is_P_next,)),
    ),
    """With a constant gain it settles where `P_next` is `P`. The innovation then has
    the covariance `Lambda_0`.""",
    is_Lambda_0 := define(Lambda_0, C * P * C.T + R),
    chain(
        "",
        "the covariance of the innovation",
        (C * e + v) * (C * e + v).T,
        Expect(C * P * C.T + R, moments=(is_P, is_R, past_v)),
        Line(Lambda_0, by=(is_Lambda_0,)),
    ),
    """The next error is correlated with this innovation: through the error before it,
    and through the noises that both contain.""",
    is_N_1 := define(N_1, A_L * P * C.T + S - L * R),
    chain(
        "",
        "the covariance of the next error and the innovation",
        (A_L * e + w - L * v) * (C * e + v).T,
        Expect(
            A_L * P * C.T + S - L * R,
            moments=(is_P, is_S, is_R, past_w, past_v),
        ),
        Line(N_1, by=(is_N_1,)),
    ),
    """From there on only the dynamics carry the correlation, because later noises are
    independent of this innovation.""",
    is_N_k := moment(e_late * nu.T, N_k),
    later_w := moment(w_late * nu.T, ZeroMatrix(n, p)),
    later_v := moment(v_late * nu.T, ZeroMatrix(p, p)),
    is_later := define(N_next, A_L * N_k),
    later := define(e_later, A_L * e_late + w_late - L * v_late),
    chain(
        "",
        "how it is carried on",
        e_later * nu.T,
        Line((A_L * e_late + w_late - L * v_late) * nu.T, by=(later,)),
        Expect(A_L * N_k, moments=(is_N_k, later_w, later_v)),
        Line(N_next, by=(is_later,)),
    ),
    is_Lambda_k := define(Lambda_k, C * N_k),
    chain(
        "",
        "the autocovariance at a lag",
        (C * e_late + v_late) * nu.T,
        Expect(C * N_k, moments=(is_N_k, later_v)),
        Line(Lambda_k, by=(is_Lambda_k,)),
    ),
)


@cache
def error_noise():
    """The covariance of what drives the error of a predictor with the gain L."""
    return Derivation(
        (Q, R, S, L),
        (Stage(W, is_W.right, symmetric=True, by=(is_W,)),),
        source=SOURCE,
        letters=letters,
        says="what drives the error of a predictor",
    )


@cache
def first_autocovariances():
    """Of the innovation with itself, and of the next error with it."""
    return Derivation(
        (A_L, C, L, R, S, P),
        (
            Stage(Lambda_0, C * P * C.T + R, symmetric=True, by=(is_Lambda_0,)),
            Stage(N_1, A_L * P * C.T + S - L * R, by=(is_N_1,)),
        ),
        source=SOURCE,
        letters=letters,
        says="the innovation with itself, and the next error with it",
    )


@cache
def autocovariance_step():
    """The autocovariance at a lag, and what the next one is made of."""
    return Derivation(
        (A_L, C, N_k),
        (
            Stage(Lambda_k, C * N_k, by=(is_Lambda_k,)),
            Stage(N_next, A_L * N_k, by=(is_later,)),
        ),
        source=SOURCE,
        letters=letters,
        says="one lag, and the step to the next",
    )


@cache
def derive():
    """The page."""
    stages = (error_noise(), first_autocovariances(), autocovariance_step())
    return Derivation(page=(*PAGE, *stages), letters=letters, source=SOURCE)
