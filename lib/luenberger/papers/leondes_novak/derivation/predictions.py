"""A record from prediction to prediction, with outputs missing or without noise.

A filter that goes from one prediction to the next asks nothing of the measurement
noise: only the covariance of the innovation has to have an inverse.  Outputs that did
not arrive keep their places.

Source: our own; the recursion is that of Kalman (1960).
"""

from functools import cache

from ....symbolic import Derivation, Expect, Line, Solve, Stage, ZeroMatrix
from .best_coordinates import as_kalman
from .letters import *
from .missing_outputs import pa
from .on_target import Omega_next, device, x_minus_next
from .one_pass import Z, innovation, is_Z, quick, x_minus
from .quadratic import is_Kmv, is_M, is_N, is_Y

OURS = "our own; Kalman (1960)"

letters = device.here()
chain, define, moment = letters.chain, letters.define, letters.moment
xt = letters("xt", n, 1, "state")
xt_next = letters("xt_next", n, 1, "the next state")
err = letters("err", n, 1, "what the prediction is off by")
F = letters("F", n, n, "moves the error of the prediction")
G = letters("G", n, p, "gain of the next prediction")
W = letters("W", p, p, "inverse of `M`", symmetric=True)
e = letters("e", p, 1, "innovation, weighed by its covariance")
N_x = letters("N_x", n, p, "covariance of the next state and the innovation")
D = letters("D", n, n, "the next `Omega`, before a correction for the gain's error")
X = letters("X", n, n, "covariance of the next state, before `y`", symmetric=True)
Pick = letters("Pick", pa, p, "picks the outputs that arrived")
C_seen = letters("C_seen", pa, n, "rows of `C`: what arrived")
R_seen = letters("R_seen", pa, pa, "noise of what arrived", symmetric=True)
S_seen = letters("S_seen", n, pa, "columns of `S`: what arrived")
M_seen = letters("M_seen", pa, pa, "innovation covariance of that", symmetric=True)
N_seen = letters("N_seen", n, pa, "covariance of the next state and that innovation")
G_seen = letters("G_seen", n, pa, "gain of the next prediction, for what arrived")
rest = Identity(p) - Pick.T * Pick
T = letters("T", n, p, "what an innovation tells of the process noise")
G_x = letters("G_x", n, p, "what it tells of the state that the plant moves on")
v_s = letters("v_s", n, 1, "the variances in `Omega`")
q_s = letters("q_s", n, 1, "the variances in `Q`")
A_s = letters("A_s", n, n, "squares of the entries of `A`")
C_s = letters("C_s", p, n, "squares of the entries of `C`")
K_s = letters("K_s", n, p, "squares of the entries of `K`")
c_s = letters("c_s", p, 1, "squares that the variances of outputs are sums of")
e_s = letters("e_s", n, 1, "the same of `Sigma`")
X_s = letters("X_s", n, 1, "the same of the next `Omega`")

PAGE = (
    """The next prediction moves the state on, and adds the innovation with a gain.""",
    plant := define(xt_next, A * xt + B * u + w),
    measured := define(y, C * xt + E * u + v),
    is_innovation := define(innovation, y - E * u - C * x_minus),
    is_next := define(x_minus_next, A * x_minus + B * u + G * innovation),
    is_err := define(err, x_minus - xt),
    is_F := define(F, A - G * C),
    off := chain(
        "",
        "what the next prediction is off by",
        x_minus_next - xt_next,
        Line(
            A * x_minus + B * u + G * innovation - A * xt - B * u - w,
            by=(is_next, plant),
        ),
        Line(
            A * (x_minus - xt) + G * (y - E * u - C * x_minus) - w,
            by=(is_innovation,),
        ),
        Line(A * (x_minus - xt) - G * C * (x_minus - xt) + G * v - w, by=(measured,)),
        Line(F * err + G * v - w, by=(is_err, is_F)),
    ),
    """The noises are independent of what was read before them. For any gain the
    covariance is a sum that rounding leaves positive. Multiplied out it takes two
    products of states by states, and an error of the gain enters in its square.""",
    is_Omega := moment(err * err.T, Omega),
    is_Q := moment(w * w.T, Q),
    is_R := moment(v * v.T, R),
    is_S := moment(w * v.T, S),
    apart_w := moment(err * w.T, ZeroMatrix(n, n)),
    apart_v := moment(err * v.T, ZeroMatrix(n, p)),
    is_N,
    is_N_x := define(N_x, A * N + S),
    is_M,
    is_X := define(X, A * Omega * A.T + Q),
    is_D := define(D, X - G * N_x.T),
    is_Omega_next := define(Omega_next, D - (N_x - G * M) * G.T),
    chain(
        "",
        "the covariance of the next prediction, for any gain",
        (x_minus_next - xt_next) * (x_minus_next - xt_next).T,
        Line((F * err + G * v - w) * (F * err + G * v - w).T, by=(off,)),
        Expect(
            F * Omega * F.T + Q - G * S.T - S * G.T + G * R * G.T,
            moments=(is_Omega, is_Q, is_R, is_S, apart_w, apart_v),
        ),
        Line(
            A * Omega * A.T
            + Q
            - G * (C * Omega * A.T + S.T)
            - (A * Omega * C.T + S) * G.T
            + G * (C * Omega * C.T + R) * G.T,
            by=(is_F,),
        ),
        Line(X - G * N_x.T - N_x * G.T + G * M * G.T, by=(is_X, is_N, is_N_x, is_M)),
        Line(D - (N_x - G * M) * G.T, by=(is_D,)),
        Line(Omega_next, by=(is_Omega_next,)),
    ),
    is_G := define(G * M, N_x),
    is_W := define(W * M, Identity(p)),
    is_e := define(e, W * innovation),
)

ESTIMATE = (
    """The estimate of an instant stands beside this recursion, which does not need it.
    Its covariance is the sum of two terms for any gain, as in a step from estimate to
    estimate.""",
    is_Kmv,
    is_Y,
    is_Z,
    is_x := define(x, x_minus + K * innovation, "43"),
    is_Sigma := define(Sigma, Y * Omega * Y.T + K * R * K.T, "27"),
    chain(
        "27",
        "the covariance of the estimate, for any gain",
        (x - xt) * (x - xt).T,
        Line(
            (x_minus + K * (y - E * u - C * x_minus) - xt)
            * (x_minus + K * (y - E * u - C * x_minus) - xt).T,
            by=(is_x, is_innovation),
        ),
        Line((Y * err + K * v) * (Y * err + K * v).T, by=(measured, is_err, is_Y)),
        Expect(Y * Omega * Y.T + K * R * K.T, moments=(is_Omega, is_R, apart_v)),
        Line(Sigma, by=(is_Sigma,)),
    ),
)

ON = (
    """Where the estimate is wanted, it leads on to the next prediction in fewer
    multiplications: no gain of the prediction has to be found. What an innovation tells
    of the process noise is added, and vanishes where noises are independent.""",
    is_K := define(K, Kmv),
    is_T := define(T * M, S),
    split := define(G, A * K + T),
    parts := chain(
        "",
        "the gain of the next prediction, in two parts",
        G * M,
        Line((A * K + T) * M, by=(split,)),
        Line(A * N + S, by=(is_K, is_Kmv, is_T)),
        Line(N_x, by=(is_N_x,)),
    ),
    moved := chain(
        "",
        "the next prediction, from the estimate",
        x_minus_next,
        Line(A * x_minus + B * u + (A * K + T) * innovation, by=(is_next, split)),
        Line(A * (x_minus + K * innovation) + B * u + T * innovation, why="factor"),
        Line(A * x + B * u + T * innovation, by=(is_x,)),
    ),
    best := chain(
        "27",
        "what the best gain leaves of the covariance",
        Sigma,
        Line(Y * Omega * Y.T + K * R * K.T, by=(is_Sigma,)),
        Line(Omega - K * N.T - N * K.T + K * M * K.T, by=(is_Y, is_M, is_N)),
        Line(Omega - K * N.T, by=(is_K, is_Kmv)),
    ),
    is_G_x := define(G_x, A * K),
    spread := chain(
        "",
        "its covariance, from that of the estimate",
        Omega_next,
        Line(X - G * N_x.T - (N_x - G * M) * G.T, by=(is_Omega_next, is_D)),
        Line(X - (A * K + T) * N_x.T, by=(parts, split)),
        Line(A * Omega * A.T + Q - (A * K + T) * (A * N + S).T, by=(is_X, is_N_x)),
        Line(
            A * (Omega - K * N.T) * A.T + Q - A * K * S.T - S * K.T * A.T - T * S.T,
            by=(is_K, is_Kmv, is_T),
        ),
        Line(
            A * Sigma * A.T + Q - A * K * S.T - S * K.T * A.T - T * S.T,
            by=(best,),
        ),
        Line(A * Sigma * A.T + Q - (G_x + T) * S.T - S * G_x.T, by=(is_G_x,)),
    ),
    """A pivot of the next covariance is judged beside the numbers that were added up.
    Their squares are carried along: those of an output that is a small difference of
    large states are large, and so is what its gain adds to an estimate.""",
    is_c_s := define(c_s, C_s * v_s),
    is_e_s := define(e_s, v_s + K_s * c_s),
    is_X_s := define(X_s, A_s * e_s + q_s),
)

PLACES = (
    """Outputs that did not arrive keep their places: there `C` has a row of zeros, `S`
    a column of zeros, and `R` a variance of one beside zeros. The covariance of the
    innovation is then that of what arrived, beside ones, and so is its determinant.""",
    picks := define(Pick * Pick.T, Identity(pa)),
    is_C := define(C, Pick.T * C_seen),
    is_S_places := define(S, S_seen * Pick),
    is_R_places := define(R, Pick.T * R_seen * Pick + rest),
    is_M_seen := define(M_seen, C_seen * Omega * C_seen.T + R_seen),
    is_N_seen := define(N_seen, A * Omega * C_seen.T + S_seen),
    is_G_seen := define(G_seen * M_seen, N_seen),
    beside := chain(
        "",
        "the covariance of the innovation, beside ones",
        M,
        Line(C * Omega * C.T + R, by=(is_M,)),
        Line(
            Pick.T * C_seen * Omega * C_seen.T * Pick + Pick.T * R_seen * Pick + rest,
            by=(is_C, is_R_places),
        ),
        Line(Pick.T * M_seen * Pick + rest, by=(is_M_seen,)),
    ),
    chain(
        "",
        "the gain is that of what arrived, beside zeros",
        G_seen * Pick * M,
        Line(G_seen * Pick * (Pick.T * M_seen * Pick + rest), by=(beside,)),
        Line(G_seen * M_seen * Pick, by=(picks,)),
        Line((A * Omega * C_seen.T + S_seen) * Pick, by=(is_G_seen, is_N_seen)),
        Line(A * Omega * C.T + S, by=(is_C, is_S_places)),
        Line(N_x, by=(is_N, is_N_x)),
    ),
)

GIVEN = (A, B, C, E, Q, R, S, Omega, x_minus, y, u)
BEGUN = (
    Stage(N, Omega * C.T, by=(is_N,)),
    Stage(M, C * N + R, symmetric=True, by=(is_M, is_N)),
    Stage(innovation, y - E * u - C * x_minus, by=(is_innovation,)),
)
MOVED = (
    Stage(N_x, A * N + S, by=(is_N_x,)),
    Stage(G, Solve(N_x, M), by=(is_G,)),
    Stage(x_minus_next, A * x_minus + B * u + G * innovation, by=(is_next,)),
    Stage(X, A * Omega * A.T + Q, symmetric=True, by=(is_X,)),
    Stage(D, X - G * N_x.T, by=(is_D,)),
    Stage(Omega_next, is_Omega_next.right, symmetric=True, by=(is_Omega_next,)),
)


@cache
def prediction_step():
    """A row from prediction to prediction: x and Omega to those of the next."""
    return Derivation(
        GIVEN,
        (
            *BEGUN,
            Stage(W, Solve(Identity(p), M), by=(is_W,)),
            Stage(e, W * innovation, by=(is_e,)),
            *MOVED,
        ),
        source=OURS,
        letters=letters,
        says="a row from prediction to prediction",
    )


@cache
def filtered_row():
    """The row with its estimate and its covariance, from which it leads on.

    Squares (A_s, C_s, K_s) and variances (v_s, q_s) are given.
    """
    return Derivation(
        (*GIVEN, A_s, C_s, K_s, v_s, q_s),
        (
            *BEGUN,
            Stage(c_s, C_s * v_s, by=(is_c_s,)),
            Stage(Kmv, Solve(N, M), "(33)", by=(is_Kmv,)),
            Stage(K, Kmv, by=(as_kalman,)),
            Stage(x, x_minus + K * innovation, "(43)", by=(is_x,)),
            Stage(Z, Omega - K * N.T, by=(is_Z,)),
            Stage(Sigma, quick.right, "(27)", symmetric=True, by=(is_Sigma, quick)),
            Stage(T, Solve(S, M), by=(is_T,)),
            Stage(G_x, A * K, by=(is_G_x,)),
            Stage(x_minus_next, moved.right, by=(moved,)),
            Stage(Omega_next, spread.right, symmetric=True, by=(spread,)),
            Stage(e_s, is_e_s.right, by=(is_e_s,)),
            Stage(X_s, is_X_s.right, by=(is_X_s,)),
        ),
        source=OURS,
        letters=letters,
        says="a row from prediction to prediction, and its estimate",
    )


@cache
def derive():
    """The page."""
    page = (*PAGE, prediction_step(), *ESTIMATE, *ON, filtered_row(), *PLACES)
    return Derivation(page=page, letters=letters, source=OURS)
