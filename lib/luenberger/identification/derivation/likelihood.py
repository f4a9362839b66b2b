"""The likelihood of a record, from the innovations of its filter.

A filter turns a record into innovations: each is what a measurement adds to those
before it.  They are independent, so the density of the record is the product of
theirs.

Source: our own; the factorisation is that of Schweppe (1965), "Evaluation of
likelihood functions for Gaussian signals".
"""

from functools import cache

from sympy import Symbol

from ...papers.leondes_novak.derivation.correlated_noise import is_As, told
from ...papers.leondes_novak.derivation.estimate import innovation
from ...papers.leondes_novak.derivation.letters import *
from ...papers.leondes_novak.derivation.one_pass import filter_step, loop
from ...papers.leondes_novak.derivation.quadratic import is_Kmv, is_M, is_N
from ...symbolic import Derivation, Line, Solve, Stage

SOURCE = "our own; Schweppe (1965)"
N_all = Symbol("N", integer=True, positive=True)

letters = loop.here()
chain, define = letters.chain, letters.define
G = letters("G", n, p, "gain of the prediction of the next state")
W = letters("W", p, p, "inverse of `M`", symmetric=True)
e = letters("e", p, 1, "innovation, weighed by its covariance")
y_all = letters("y_all", N_all, 1, "the whole record, less its mean")
nu_all = letters("nu_all", N_all, 1, "its innovations, one below the other")
T_all = letters("T_all", N_all, N_all, "lower triangle with ones on its diagonal")
V_all = letters("V_all", N_all, N_all, "covariance of the record", symmetric=True)
M_all = letters("M_all", N_all, N_all, "that of the innovations", symmetric=True)

PAGE = (
    """A measurement is what the filter predicts from those before it, and the
    innovation. So the record is a lower triangle times its innovations, with ones on
    the diagonal. The innovations are independent: `M_all` has their covariances `M`
    on its diagonal, and zeros elsewhere.""",
    triangle := define(y_all, T_all * nu_all),
    is_V := define(T_all * M_all, V_all * T_all.T.I),
    chain(
        "",
        "the exponent of the density, from the innovations",
        y_all.T * V_all.I * y_all,
        Line(nu_all.T * T_all.T * V_all.I * T_all * nu_all, by=(triangle,)),
        Line(
            nu_all.T * T_all.T * V_all.I * T_all * M_all * M_all.I * nu_all,
            why="`M_all` has an inverse",
        ),
        Line(nu_all.T * M_all.I * nu_all, by=(is_V,)),
    ),
    """The determinant of such a triangle is one, so that of `V_all` is the product of
    the determinants of all `M`. Of a record with `p` outputs at each instant the
    logarithm of the likelihood is therefore the sum over instants of
    `-1/2 (p log(2 pi) + log det(M) + innovation' W innovation)`, with `W` the inverse
    of `M`.""",
    is_W := define(W * M, Identity(p)),
    is_e := define(e, W * innovation),
    """The score needs the gain of the prediction as well, which leads from one
    prediction to the next. It is that of the filter, moved on, and what the
    measurement noise tells of the process noise.""",
    is_As,
    told,
    is_M,
    is_N,
    is_Kmv,
    is_G := define(G, As * Kmv + J),
    chain(
        "",
        "the gain of the prediction solves its equation",
        G * M,
        Line((As * Kmv + J) * M, by=(is_G,)),
        Line(As * N + J * M, by=(is_Kmv,)),
        Line(As * Omega * C.T + J * (C * Omega * C.T + R), by=(is_M, is_N)),
        Line(A * Omega * C.T + J * R, by=(is_As,)),
        Line(A * Omega * C.T + S, by=(told,)),
    ),
)


WEIGHED = (
    Stage(W, Solve(Identity(p), M), by=(is_W,)),
    Stage(e, W * innovation, by=(is_e,)),
)


@cache
def prediction_gain():
    """The gain of the prediction, from the filter's."""
    return Derivation(
        (As, J, Kmv),
        (Stage(G, As * Kmv + J, by=(is_G,)),),
        source=SOURCE,
        letters=letters,
        says="the gain of the prediction",
    )


@cache
def weighed():
    """The inverse of an innovation's covariance, and the innovation weighed by it."""
    return Derivation(
        (M, innovation),
        WEIGHED,
        source=SOURCE,
        letters=letters,
        says="an innovation, weighed",
    )


@cache
def likelihood_step():
    """`filter_step`, and what the score needs of it: W = M^-1 and e = W innovation."""
    step = filter_step()
    return Derivation(
        step.given,
        (*step.stages, *WEIGHED),
        source=SOURCE,
        letters=letters,
        says="one step of a filter, with the innovation weighed",
    )


@cache
def derive():
    """The page."""
    return Derivation(
        page=(*PAGE, weighed(), prediction_gain()), letters=letters, source=SOURCE
    )
