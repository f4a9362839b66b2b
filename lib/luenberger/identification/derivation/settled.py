"""A record of a plant that does not change, from a filter that has settled.

Where all outputs arrive at every row, the gain of the best prediction settles.  With
the settled gain each row is the same linear map, forward and back, and a start that is
not the settled one is put right afterwards.

Source: our own; what a start adds is a case of Rosenberg (1973), "Random coefficient
models: the analysis of a cross section of time series by stochastically convergent
parameter regression".
"""

from functools import cache

from sympy import Symbol

from ...symbolic import Derivation, Line, Solve, Stage
from .letters import *

SOURCE = "our own; Rosenberg (1973)"
N_all = Symbol("N", integer=True, positive=True)

letters = letters.here()
chain, define = letters.chain, letters.define
x = letters("x", n, 1, "prediction of the state")
x_0 = letters("x_0", n, 1, "mean of the start")
x_1 = letters("x_1", n, 1, "the first prediction")
u_0 = letters("u_0", m, 1, "input between start and first row")
x_next = letters("x_next", n, 1, "the same one step on")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
nu = letters("nu", p, 1, "innovation")
e = letters("e", p, 1, "innovation, weighed by its covariance")
h = letters("h", p, 1, "gradient of the likelihood in the measurement, turned")
eta = letters("eta", n, 1, "gradient of the likelihood in `x`")
eta_next = letters("eta_next", n, 1, "the same one step on")
X = letters("X", n, n, "what the first prediction does to this one")
X_next = letters("X_next", n, n, "the same one step on")
delta = letters("delta", n, 1, "what the first prediction is off by")
f = letters("f", n, n, "`F`, or its transpose on the way back")
g = letters("g", n, 1, "what the record adds to a row")
z = letters("z", n, 1, "prediction, or on the way back its gradient")
z_next = letters("z_next", n, 1, "the same in the row that is done next")
Omega_1 = letters("Omega_1", n, n, "covariance at the first row", symmetric=True)
P0 = letters("P0", n, n, "covariance of the start", symmetric=True)
Delta = letters("Delta", n, n, "what it has beside `Omega`", symmetric=True)
Y_1 = letters("Y_1", n, n, "what the record takes from a start, inverted")
T_1 = letters("T_1", n, n, "weight of the start", symmetric=True)
d = letters("d", N_all, 1, "the whole record, less its mean")
O = letters("O", N_all, n, "what the first state does to the whole record")
V_all = letters("V_all", N_all, N_all, "covariance of the record", symmetric=True)
W_all = letters("W_all", N_all, N_all, "its inverse", symmetric=True)
eta_1 = letters("eta_1", n, 1, "gradient in the first prediction")
delta_hat = letters("delta_hat", n, 1, "the best value of `delta`")
eta_2 = letters("eta_2", n, 1, "gradient in the first prediction, put right")

ROWS = (
    """A covariance that has settled is the same in the next row. Its gain then makes
    it again, which is how it is found: from a gain the covariance, from the covariance
    the next gain.""",
    is_N := define(N, A * Omega * C.T + S),
    is_M := define(M, C * Omega * C.T + R),
    is_G := define(G * M, N),
    is_W := define(W * M, Identity(p)),
    is_F := define(F, A - G * C),
    is_V := define(V, W * C),
    settled := define(Omega, A * Omega * A.T + Q - G * N.T, name="it has settled"),
    chain(
        "",
        "the settled covariance, made by its gain",
        Omega,
        Line(A * Omega * A.T + Q - G * N.T, by=(settled,)),
        Line(A * Omega * A.T + Q - G * N.T - N * G.T + G * M * G.T, by=(is_G,)),
        Line(
            F * Omega * F.T + Q - G * S.T - S * G.T + G * R * G.T,
            by=(is_N, is_M, is_F),
        ),
    ),
    """Each row then does the same to the prediction and, on the way back, to its
    gradient.""",
    is_nu := define(nu, y - E * u - C * x),
    chain(
        "",
        "the next prediction has one gain for all rows",
        A * x + B * u + G * nu,
        Line(A * x + B * u + G * (y - E * u - C * x), by=(is_nu,)),
        Line(F * x + B * u + G * (y - E * u), by=(is_F,)),
    ),
    is_h := define(e, h + G.T * eta_next),
    is_eta := define(eta, A.T * eta_next + C.T * h),
    back := chain(
        "",
        "so has its gradient on the way back",
        eta,
        Line(A.T * eta_next + C.T * h, by=(is_eta,)),
        Line(A.T * eta_next + C.T * (e - G.T * eta_next), by=(is_h,)),
        Line(F.T * eta_next + C.T * e, by=(is_F,)),
    ),
    is_z := define(z_next, f * z + g),
)

START = (
    """The first prediction may be off by `delta`. Then each prediction is off by
    `X delta`, and the record tells of `delta` what `Pi` says, which has settled as
    well.""",
    is_X := define(X_next, F * X),
    is_Pi := define(Pi, F.T * Pi * F + C.T * V, name="what the rows to come tell"),
    is_e := define(e, W * nu),
    chain(
        "",
        "how the gradient moves with the start",
        F.T * (eta_next - Pi * X_next * delta) + C.T * (e - V * X * delta),
        Line(
            F.T * eta_next + C.T * e - (F.T * Pi * F + C.T * V) * X * delta, by=(is_X,)
        ),
        Line(F.T * eta_next + C.T * e - Pi * X * delta, by=(is_Pi,)),
        Line(eta - Pi * X * delta, by=(back,)),
    ),
    """The exponents of a row and of those to come are again of this form.""",
    chain(
        "",
        "how the exponents move with the start",
        (nu - C * X * delta).T * W * (nu - C * X * delta)
        - 2 * delta.T * X_next.T * eta_next
        + delta.T * X_next.T * Pi * X_next * delta,
        Line(
            nu.T * W * nu
            - 2 * delta.T * X.T * (F.T * eta_next + C.T * W * nu)
            + delta.T * X.T * (F.T * Pi * F + C.T * W * C) * X * delta,
            by=(is_X,),
        ),
        Line(
            nu.T * W * nu - 2 * delta.T * X.T * eta + delta.T * X.T * Pi * X * delta,
            by=(back, is_e, is_Pi, is_V),
        ),
    ),
    """So `Pi` and `eta_1`, the gradient in the first prediction, are what the whole
    record tells of its start. Let the covariance there be `Omega_1`, which `Delta`
    leads to from the settled one. Of a start that is not known `Delta` has no bound,
    and `T_1` is the inverse of `Pi`.""",
    is_x_1 := define(x_1, A * x_0 + B * u_0),
    is_Omega_1 := define(Omega_1, A * P0 * A.T + Q),
    is_Delta := define(Delta, Omega_1 - Omega),
    is_Y_1 := define(Y_1, Identity(n) + Delta * Pi),
    is_T_1 := define(Y_1 * T_1, Delta),
    inverse := define(V_all * W_all, Identity(N_all)),
    told := define(Pi, O.T * W_all * O, name="the whole record tells `Pi`"),
    chain(
        "",
        "the inverse of the covariance of the record",
        (V_all + O * Delta * O.T) * (W_all - W_all * O * T_1 * O.T * W_all),
        Line(
            Identity(N_all)
            + O * (Delta - (Identity(n) + Delta * O.T * W_all * O) * T_1) * O.T * W_all,
            by=(inverse,),
        ),
        Line(
            Identity(N_all)
            + O * (Delta - (Identity(n) + Delta * Pi) * T_1) * O.T * W_all,
            by=(told,),
        ),
        Line(
            Identity(N_all) + O * (Delta - Y_1 * T_1) * O.T * W_all,
            by=(is_Y_1,),
        ),
        Line(Identity(N_all), by=(is_T_1,)),
    ),
    """Its determinant is that of `V_all` times that of `Y_1`. The exponent is found
    without a difference of large numbers: by a second pass that begins at the best
    value of the start.""",
    is_eta_1 := define(eta_1, O.T * W_all * d),
    best := define(delta_hat, T_1 * eta_1),
    is_eta_2 := define(Y_1.T * eta_2, eta_1),
    put_right := chain(
        "",
        "the gradient at the best value",
        eta_1 - Pi * delta_hat,
        Line(eta_1 - Pi * T_1 * eta_1, by=(best,)),
        Line(Y_1.T * eta_2 - Pi * T_1 * Y_1.T * eta_2, by=(is_eta_2,)),
        Line(Y_1.T * eta_2 - Pi * Delta * eta_2, by=(is_T_1,)),
        Line(eta_2, by=(is_Y_1,)),
    ),
    chain(
        "",
        "the exponent, from a second pass",
        (d - O * delta_hat).T * W_all * (d - O * delta_hat) + delta_hat.T * eta_2,
        Line(
            d.T * W_all * d
            - 2 * delta_hat.T * O.T * W_all * d
            + delta_hat.T * O.T * W_all * O * delta_hat
            + delta_hat.T * (eta_1 - Pi * delta_hat),
            by=(put_right,),
        ),
        Line(
            d.T * W_all * d - delta_hat.T * eta_1,
            by=(told, is_eta_1),
        ),
        Line(
            d.T * (W_all - W_all * O * T_1 * O.T * W_all) * d,
            by=(best, is_eta_1),
        ),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def settled_row():
    """What all rows share, from the covariance of a prediction."""
    stages = (
        Stage(N, A * Omega * C.T + S, by=(is_N,)),
        Stage(M, C * Omega * C.T + R, symmetric=True, by=(is_M,)),
        Stage(W, Solve(Identity(p), M), by=(is_W,)),
        Stage(G, N * W, by=(is_G, is_W)),
        Stage(F, A - G * C, by=(is_F,)),
        Stage(V, W * C, by=(is_V,)),
    )
    return listed((A, C, R, S, Omega), stages, "what all rows share")


@cache
def carried_on():
    """From one row to the next, forward or back."""
    return listed((f, z, g), (Stage(z_next, f * z + g, by=(is_z,)),), "one row")


@cache
def settled_start():
    """What a known start has beside the settled one; T_1 solves Y_1 T_1 = Delta."""
    stages = (
        Stage(x_1, is_x_1.right, by=(is_x_1,)),
        Stage(Omega_1, is_Omega_1.right, symmetric=True, by=(is_Omega_1,)),
        Stage(Delta, Omega_1 - Omega, symmetric=True, by=(is_Delta,)),
        Stage(Y_1, Identity(n) + Delta * Pi, by=(is_Y_1,)),
    )
    return listed(
        (A, B, Q, P0, x_0, u_0, Omega, Pi), stages, "a known start, beside the settled"
    )


@cache
def derive():
    """The page."""
    page = (*ROWS, settled_row(), carried_on(), *START, settled_start())
    return Derivation(page=page, letters=letters, source=SOURCE)
