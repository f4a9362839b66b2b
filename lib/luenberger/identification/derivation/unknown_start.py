"""The likelihood of a record whose start is not known.

Nothing is known of the state at the first row.  That is no wide covariance: the state
is a number to be integrated out, and a filter from any covariance can do it.

Source: our own; the likelihood is that of de Jong (1988), "The likelihood for a state
space model", and the collapse that of de Jong (1991), "The diffuse Kalman filter".
"""

from functools import cache

from sympy import Symbol

from ...symbolic import Derivation, Expect, Line, Solve, Stage
from .letters import *

SOURCE = "our own; de Jong (1988, 1991)"
N_r = Symbol("N_r", integer=True, positive=True)

letters = letters.here()
chain, define, moment = letters.chain, letters.define, letters.moment
x = letters("x", n, 1, "prediction, if the mean of the first state is zero")
x_next = letters("x_next", n, 1, "the same one step on")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
nu = letters("nu", p, 1, "innovation, if that mean is zero")
delta = letters("delta", n, 1, "mean of the state at the first row, not known")
delta_hat = letters("delta_hat", n, 1, "its best value, from the first rows")
delta_all = letters("delta_all", n, 1, "its best value, from the whole record")
X = letters("X", n, n, "what that mean does to the prediction")
X_next = letters("X_next", n, n, "the same one step on")
X_f = letters("X_f", n, n, "what it does to the estimate after the measurement")
z = letters("z", N_r, 1, "white innovations of the first rows")
V = letters("V", N_r, n, "what they show of the mean")
Q_r = letters("Q_r", N_r, n, "orthonormal columns that span those of `V`")
R_r = letters("R_r", n, n, "triangle, `V = Q_r R_r`")
inverse = letters("inverse", n, n, "its inverse")
x_f = letters("x_f", n, 1, "estimate after the measurement, if the mean is zero")
x_c = letters("x_c", n, 1, "that estimate, the mean integrated out")
rho = letters("rho", p, 1, "what `x_f` leaves of the measurement")
rho_c = letters("rho_c", p, 1, "what `x_c` leaves of it")
K = letters("K", n, p, "gain of the filter")
epsilon = letters("epsilon", n, 1, "error of the estimate, if the mean were known")
mu = letters("mu", n, 1, "error of the mean's best value, turned by `R_r`")
Sigma = letters("Sigma", n, n, "covariance of `epsilon`", symmetric=True)
H_c = letters("H_c", n, n, "columns that the mean adds to a root of it")
eta_c = letters("eta_c", n, 1, "gradient in the prediction, from the rows to come")
Pi_c = letters("Pi_c", n, n, "what they tell of it", symmetric=True)
Pi = letters("Pi", n, n, "what they tell of it, if the mean is known", symmetric=True)
B_c = letters("B_c", n, n, "what a white error of the mean does to the prediction")
D_c = letters("D_c", n, n, "what the rows to come leave of that error", symmetric=True)
L_c = letters("L_c", n, n, "a root of it")
N_c = letters("N_c", n, n, "`Pi_c B_c`, divided by it")
T_c = letters("T_c", n, n, "root of the covariance of the mean, from the whole record")
d = letters("d", n, 1, "error of the mean's best value, from the whole record")
eta_n = letters("eta_n", n, n, "columns that this error adds to the gradient")
first = letters("first", 1, c, "one, and zeros for the other columns")
Delta = letters("Delta", n, c, "`delta_all`, beside the columns of `T_c`")
e = letters("e", p, 1, "innovation, weighed, if the mean is zero")
x_n = letters("x_n", n, c, "prediction, beside what the error of the mean does to it")
e_n = letters("e_n", p, c, "weighed innovation, beside the same")
T_1 = letters("T_1", n, n, "the same root, where no row comes before")

MOVES = (
    """Nothing is known of the state at the first row: it has any mean `delta`, around
    it any covariance, and the likelihood is integrated over `delta`. A filter that
    takes the mean for zero errs in every prediction by `X delta`.""",
    is_nu := define(nu, y - E * u - C * x),
    is_x_next := define(x_next, A * x + B * u + G * nu),
    is_F := define(F, A - G * C),
    is_X_next := define(X_next, F * X),
    chain(
        "",
        "an innovation moves with the mean",
        y - E * u - C * (x + X * delta),
        Line(nu - C * X * delta, by=(is_nu,)),
    ),
    chain(
        "",
        "the next prediction moves with the mean",
        A * (x + X * delta) + B * u + G * (nu - C * X * delta),
        Line(A * x + B * u + G * nu + (A - G * C) * X * delta, why="collect"),
        Line(x_next + X_next * delta, by=(is_x_next, is_F, is_X_next)),
    ),
)

SOLVED = (
    """So the white innovations of the first rows are `z - V delta`. Their squares are
    those of the best value, and a square of what the mean differs from it.""",
    triangle := define(V, Q_r * R_r),
    columns := define(Q_r.T * Q_r, Identity(n)),
    best := define(R_r * delta_hat, Q_r.T * z),
    chain(
        "",
        "the exponent is a square in the mean",
        (z - V * delta).T * (z - V * delta),
        Line((z - Q_r * R_r * delta).T * (z - Q_r * R_r * delta), by=(triangle,)),
        Line(
            z.T * z - 2 * delta.T * R_r.T * Q_r.T * z + delta.T * R_r.T * R_r * delta,
            by=(columns,),
        ),
        Line(
            z.T * z
            - delta_hat.T * R_r.T * R_r * delta_hat
            + (delta - delta_hat).T * R_r.T * R_r * (delta - delta_hat),
            by=(best,),
        ),
    ),
    """Integrated over `delta`, the last square gives `(2 pi)^(n/2)`, divided by the
    determinant of `R_r`. After that the state is known as usual: the error of the
    mean, turned by `R_r`, has the covariance `I`, and it is independent of the error
    that the filter would make if it knew the mean.""",
    is_inverse := define(inverse * R_r, Identity(n)),
    is_X_f := define(X_f, X - K * C * X),
    is_H_c := define(H_c, X_f * inverse),
    is_error := define(delta_hat - delta, inverse * mu),
    chain(
        "",
        "that error, turned",
        R_r * (delta_hat - delta),
        Line(R_r * inverse * mu, by=(is_error,)),
        Line(mu, by=(is_inverse,)),
    ),
    chain(
        "",
        "what an error of the mean does to the estimate",
        X_f * (delta_hat - delta),
        Line(X_f * inverse * mu, by=(is_error,)),
        Line(H_c * mu, by=(is_H_c,)),
    ),
    is_Sigma := moment(epsilon * epsilon.T, Sigma),
    is_mu := moment(mu * mu.T, Identity(n)),
    apart := moment(epsilon * mu.T, ZeroMatrix(n, n)),
    chain(
        "",
        "the covariance, the mean integrated out",
        (epsilon + H_c * mu) * (epsilon + H_c * mu).T,
        Expect(Sigma + H_c * H_c.T, moments=(is_Sigma, is_mu, apart)),
    ),
    is_x_c := define(x_c, x_f + X_f * delta_hat),
    is_rho_c := define(rho_c, rho - C * X_f * delta_hat),
)

BACK = (
    """The way back begins with what the rows to come make of the prediction: `eta_c`
    and `Pi_c`. The score of an integral is the mean of the scores, over what the whole
    record leaves of the mean. Its error `d` has the covariance `T_c T_c'`.""",
    is_B_c := define(B_c, X * inverse),
    is_D_c := define(D_c, Identity(n) - B_c.T * Pi_c * B_c),
    root := define(L_c * L_c.T, D_c),
    is_T_c := define(T_c, inverse * L_c),
    chain(
        "",
        "what the whole record leaves of the mean",
        T_c * T_c.T,
        Line(inverse * L_c * L_c.T * inverse.T, by=(is_T_c,)),
        Line(inverse * D_c * inverse.T, by=(root,)),
        Line(
            inverse * inverse.T - inverse * B_c.T * Pi_c * B_c * inverse.T,
            by=(is_D_c,),
        ),
    ),
    """If the mean were known, the rows to come would tell more of the prediction.""",
    is_N_c := define(N_c, Pi_c * B_c * D_c.I),
    is_Pi := define(Pi, Pi_c + N_c * B_c.T * Pi_c),
    known := chain(
        "",
        "what the rows to come tell of the mean",
        Pi * B_c,
        Line(Pi_c * B_c + N_c * B_c.T * Pi_c * B_c, by=(is_Pi,)),
        Line(Pi_c * B_c + N_c * (Identity(n) - D_c), by=(is_D_c,)),
        Line(N_c, by=(is_N_c,)),
    ),
    is_eta_n := define(eta_n, -Pi * X * T_c),
    turned := chain(
        "",
        "the columns that the error of the mean adds",
        eta_n,
        Line(-Pi * X * inverse * L_c, by=(is_eta_n, is_T_c)),
        Line(-Pi * B_c * L_c, by=(is_B_c,)),
        Line(-N_c * L_c, by=(known,)),
    ),
    centred := moment(d, ZeroMatrix(n, 1)),
    is_T := moment(d * d.T, T_c * T_c.T),
    chain(
        "",
        "the mean of the squares of the gradient",
        (eta_c - Pi * X * d) * (eta_c - Pi * X * d).T,
        Expect(
            eta_c * eta_c.T + Pi * X * T_c * T_c.T * X.T * Pi, moments=(centred, is_T)
        ),
        Line(eta_c * eta_c.T + eta_n * eta_n.T, by=(is_eta_n,)),
    ),
    """Beside `Pi` this is what `eta_c` is beside `Pi_c`. So a row of the score with
    these columns, and `Pi`, is right for every row of the first ones.""",
    chain(
        "",
        "both say the same of the covariance",
        eta_n * eta_n.T - Pi,
        Line(N_c * L_c * L_c.T * N_c.T - Pi, by=(turned,)),
        Line(N_c * D_c * N_c.T - Pi, by=(root,)),
        Line(N_c * B_c.T * Pi_c - Pi, by=(is_N_c,)),
        Line(-Pi_c, by=(is_Pi,)),
    ),
    is_delta_all := define(delta_all, delta_hat + inverse * B_c.T * eta_c),
    """A row of the score has a column for the best value of the mean, and one for each
    column of `T_c`, in which everything but the mean is zero.""",
    is_e := define(e, W * nu),
    is_x_n := define(x_n, x * first + X * Delta),
    is_e_n := define(e_n, W * (nu * first - C * X * Delta)),
    columns_of_e := chain(
        "",
        "the weighed innovations with the mean",
        e_n,
        Line(W * (nu * first - C * X * Delta), by=(is_e_n,)),
        Line(e * first - W * C * X * Delta, by=(is_e,)),
    ),
    """At the first row itself `X` is the identity, and the whole record gives the mean
    the covariance `T_1 T_1'`, the inverse of `Pi`. The gradient in the covariance that
    the filter began with is zero: any covariance will do.""",
    is_T_1 := define(Pi * T_1 * T_1.T, Identity(n)),
    chain(
        "",
        "any covariance of the first state will do",
        (Pi * T_1) * (Pi * T_1).T - Pi,
        Line(ZeroMatrix(n, n), by=(is_T_1,)),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def mean_moves():
    """What the mean of the first state does to the next prediction."""
    stages = (
        Stage(F, A - G * C, by=(is_F,)),
        Stage(X_next, F * X, by=(is_X_next,)),
    )
    return listed((A, C, G, X), stages, "what the mean does to the next prediction")


@cache
def collapse():
    """The estimate after a row, the mean integrated out; [half, H_c] is the factor."""
    stages = (
        Stage(X_f, X - K * C * X, by=(is_X_f,)),
        Stage(H_c, X_f * inverse, by=(is_H_c,)),
        Stage(x_c, x_f + X_f * delta_hat, by=(is_x_c,)),
        Stage(rho_c, rho - C * X_f * delta_hat, by=(is_rho_c,)),
    )
    given = (C, X, inverse, delta_hat, K, x_f, rho)
    return listed(given, stages, "the estimate, the mean integrated out")


@cache
def before_start():
    """What the rows after the first ones leave of the mean's error."""
    stages = (
        Stage(B_c, X * inverse, by=(is_B_c,)),
        Stage(D_c, is_D_c.right, symmetric=True, by=(is_D_c,)),
    )
    return listed((X, inverse, Pi_c), stages, "what the rows to come leave of the mean")


@cache
def after_start():
    """What the score of the first rows begins with; L_c is a root of D_c."""
    stages = (
        Stage(N_c, Solve(Pi_c * B_c, D_c), by=(is_N_c,)),
        Stage(Pi, Pi_c + N_c * B_c.T * Pi_c, symmetric=True, by=(is_Pi,)),
        Stage(eta_n, -N_c * L_c, by=(turned,)),
        Stage(T_c, inverse * L_c, by=(is_T_c,)),
        Stage(delta_all, is_delta_all.right, by=(is_delta_all,)),
    )
    given = (Pi_c, B_c, D_c, L_c, inverse, delta_hat, eta_c)
    return listed(given, stages, "what the score of the first rows begins with")


@cache
def with_mean():
    """A row's prediction and weighed innovation, with columns for the mean."""
    stages = (
        Stage(x_n, is_x_n.right, by=(is_x_n,)),
        Stage(e_n, e * first - W * C * X * Delta, by=(columns_of_e,)),
    )
    given = (C, W, x, e, X, first, Delta)
    return listed(given, stages, "a row, with columns for the mean")


@cache
def derive():
    """The page."""
    lists = mean_moves(), collapse(), before_start(), after_start(), with_mean()
    page = (*MOVES, *lists[:1], *SOLVED, lists[1], *BACK, *lists[2:])
    return Derivation(page=page, letters=letters, source=SOURCE)
