"""A record from prediction to prediction, with outputs missing or without noise.

A filter that goes from one prediction to the next asks nothing of the measurement
noise: only the covariance of the innovation has to have an inverse.  Outputs that did
not arrive keep their places.

Source: our own; the recursion is that of Kalman (1960).
"""

from functools import cache

from sympy import symbols

from ...symbolic import Derivation, Expect, Line, Solve, Stage
from .letters import *

SOURCE = "our own; Kalman (1960)"

letters = letters.here()
chain, define, moment = letters.chain, letters.define, letters.moment
x = letters("x", n, 1, "prediction of the state")
x_next = letters("x_next", n, 1, "the next prediction")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
nu = letters("nu", p, 1, "innovation")
e = letters("e", p, 1, "innovation, weighed by its covariance")
xt = letters("xt", n, 1, "state")
xt_next = letters("xt_next", n, 1, "the next state")
err = letters("err", n, 1, "what the prediction is off by")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
H = letters("H", n, p, "covariance of prediction and innovation")
Omega_next = letters("Omega_next", n, n, "the next `Omega`", symmetric=True)
D = letters("D", n, n, "the next `Omega`, before a correction for the gain's error")
X = letters("X", n, n, "covariance of the next state, before `y`", symmetric=True)
pa = symbols("p_a", integer=True, nonnegative=True)
Pick = letters("Pick", pa, p, "picks the outputs that arrived")
C_seen = letters("C_seen", pa, n, "rows of `C`: what arrived")
R_seen = letters("R_seen", pa, pa, "noise of what arrived", symmetric=True)
S_seen = letters("S_seen", n, pa, "columns of `S`: what arrived")
M_seen = letters("M_seen", pa, pa, "innovation covariance of that", symmetric=True)
N_seen = letters("N_seen", n, pa, "covariance of the next state and that innovation")
G_seen = letters("G_seen", n, pa, "gain of the next prediction, for what arrived")
rest = Identity(p) - Pick.T * Pick

PAGE = (
    """The next prediction moves the state on, and adds the innovation with a gain.""",
    plant := define(xt_next, A * xt + B * u + w),
    measured := define(y, C * xt + E * u + v),
    is_nu := define(nu, y - E * u - C * x),
    is_x_next := define(x_next, A * x + B * u + G * nu),
    is_err := define(err, x - xt),
    is_F := define(F, A - G * C),
    off := chain(
        "",
        "what the next prediction is off by",
        x_next - xt_next,
        Line(A * x + B * u + G * nu - A * xt - B * u - w, by=(is_x_next, plant)),
        Line(A * (x - xt) + G * (y - E * u - C * x) - w, by=(is_nu,)),
        Line(A * (x - xt) - G * C * (x - xt) + G * v - w, by=(measured,)),
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
    is_H := define(H, Omega * C.T),
    is_N := define(N, A * H + S),
    is_M := define(M, C * H + R),
    is_X := define(X, A * Omega * A.T + Q),
    is_D := define(D, X - G * N.T),
    is_Omega_next := define(Omega_next, D - (N - G * M) * G.T),
    chain(
        "",
        "the covariance of the next prediction, for any gain",
        (x_next - xt_next) * (x_next - xt_next).T,
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
        Line(X - G * N.T - N * G.T + G * M * G.T, by=(is_X, is_H, is_N, is_M)),
        Line(D - (N - G * M) * G.T, by=(is_D,)),
        Line(Omega_next, by=(is_Omega_next,)),
    ),
    is_G := define(G * M, N),
    is_W := define(W * M, Identity(p)),
    is_e := define(e, W * nu),
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
        Line(C * Omega * C.T + R, by=(is_M, is_H)),
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
        Line(N, by=(is_N, is_H)),
    ),
)


@cache
def prediction_step():
    """A row from prediction to prediction: x and Omega to those of the next."""
    return Derivation(
        (A, B, C, E, Q, R, S, Omega, x, y, u),
        (
            Stage(H, Omega * C.T, by=(is_H,)),
            Stage(N, A * H + S, by=(is_N,)),
            Stage(M, C * H + R, symmetric=True, by=(is_M,)),
            Stage(G, Solve(N, M), by=(is_G,)),
            Stage(W, Solve(Identity(p), M), by=(is_W,)),
            Stage(nu, y - E * u - C * x, by=(is_nu,)),
            Stage(e, W * nu, by=(is_e,)),
            Stage(x_next, A * x + B * u + G * nu, by=(is_x_next,)),
            Stage(X, A * Omega * A.T + Q, symmetric=True, by=(is_X,)),
            Stage(D, X - G * N.T, by=(is_D,)),
            Stage(Omega_next, is_Omega_next.right, symmetric=True, by=(is_Omega_next,)),
        ),
        source=SOURCE,
        letters=letters,
        says="a row from prediction to prediction",
    )


@cache
def derive():
    """The page."""
    page = (*PAGE, prediction_step(), *PLACES)
    return Derivation(page=page, letters=letters, source=SOURCE)
