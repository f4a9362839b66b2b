"""What readings tell that have just arrived, of this instant or of earlier ones.

When a reading arrives, what was expected of it is found to be wrong by a known number.
All that is correlated with it is corrected: the state, and the readings to come.

Source: our own.
"""

from functools import cache

from sympy import symbols

from ....symbolic import AtLeast, Derivation, Expect, Line, Solve, Stage, ZeroMatrix
from .late_outputs import late
from .letters import *

k, s = symbols("k s", integer=True, nonnegative=True)
arriving = late.here()
chain, define, moment = arriving.chain, arriving.define, arriving.moment
t = arriving("t", k, 1, "readings that have just arrived")
t_hat = arriving("t_hat", k, 1, "what was expected of them")
x_r = arriving("xi", s, 1, "all that is not known yet: the state, readings to come")
x_hat_r = arriving("xi_hat", s, 1, "what is expected of it")
x_hat_r_next = arriving("xi_hat_next", s, 1, "the same once readings have arrived")
d_t = arriving("d_t", k, 1, "error of `t_hat`")
d_r = arriving("d_r", s, 1, "error of `xi_hat`")
P_rr = arriving("P_rr", s, s, "covariance of `d_r`", symmetric=True)
P_rt = arriving("P_rt", s, k, "covariance of `d_r` and `d_t`")
P_tt = arriving("P_tt", k, k, "covariance of `d_t`", symmetric=True)
P_next = arriving("P_next", s, s, "the same once readings have arrived", symmetric=True)
K_t = arriving("K_t", s, k, "gain of least covariance")
K_r = arriving("K_r", s, k, "any gain")
L_t = arriving("L_t", k, k, "a root of `P_tt`")

KNOWN = (
    """Some readings arrive at this instant, of this instant or of earlier ones. What
    was expected of them was wrong by a number that is known now. It corrects the state
    and the readings that are still to come.""",
    is_d_t := define(d_t, t_hat - t),
    is_d_r := define(d_r, x_hat_r - x_r),
    corrects := define(x_hat_r_next, x_hat_r + K_t * (t - t_hat), "43"),
    chain(
        "",
        "the error once readings have arrived",
        x_hat_r_next - x_r,
        Line(x_hat_r + K_t * (t - t_hat) - x_r, by=(corrects,)),
        Line(d_r - K_t * d_t, by=(is_d_r, is_d_t)),
    ),
    is_P_rr := moment(d_r * d_r.T, P_rr),
    is_P_rt := moment(d_r * d_t.T, P_rt),
    is_P_tt := moment(d_t * d_t.T, P_tt),
    is_K_t := define(K_t * P_tt, P_rt),
    square := chain(
        "27",
        "the covariance is a quadratic in the gain of what arrived",
        (d_r - K_r * d_t) * (d_r - K_r * d_t).T,
        Expect(
            P_rr - K_r * P_rt.T - P_rt * K_r.T + K_r * P_tt * K_r.T,
            moments=(is_P_rr, is_P_rt, is_P_tt),
        ),
        Line(P_rr - K_t * P_rt.T + (K_r - K_t) * P_tt * (K_r - K_t).T, by=(is_K_t,)),
    ),
    root := define(P_tt, L_t * L_t.T),
    chain(
        "",
        "no other gain does better with what arrived",
        P_rr - K_t * P_rt.T + (K_r - K_t) * P_tt * (K_r - K_t).T,
        AtLeast(P_rr - K_t * P_rt.T, by=(root,), root=(K_r - K_t) * L_t),
    ),
    is_P_next := define(P_next, P_rr - K_t * P_rt.T, "27"),
    """The filter that is run again from the first reading that arrived uses the same
    numbers. Its error, too, is correlated with none of them. Two such estimates are
    equal, since their difference has no variance.""",
    told := chain(
        "",
        "the error that is left is correlated with nothing that arrived",
        (d_r - K_t * d_t) * d_t.T,
        Expect(P_rt - K_t * P_tt, moments=(is_P_rt, is_P_tt)),
        Line(ZeroMatrix(s, k), by=(is_K_t,)),
    ),
    other := define(K_r * P_tt, P_rt),
    chain(
        "",
        "two estimates of least covariance are one",
        (K_r - K_t) * d_t * d_t.T * (K_r - K_t).T,
        Expect((K_r - K_t) * P_tt * (K_r - K_t).T, moments=(is_P_tt,)),
        Line((P_rt - K_t * P_tt) * (K_r - K_t).T, by=(other,)),
        Line(ZeroMatrix(s, s), by=(is_K_t,)),
    ),
)


@cache
def late_known():
    """What readings that have just arrived tell of the state and of those to come."""
    return Derivation(
        (P_rr, P_rt, P_tt),
        (
            Stage(K_t, Solve(P_rt, P_tt), by=(is_K_t,)),
            Stage(P_next, is_P_next.right, "(27)", symmetric=True, by=(is_P_next,)),
        ),
        source="our own",
        letters=arriving,
        says="what has just arrived",
    )


@cache
def late_corrected():
    """The expected values, corrected by readings that have just arrived."""
    return Derivation(
        (K_t, x_hat_r, t, t_hat),
        (Stage(x_hat_r_next, corrects.right, "(43)", by=(corrects,)),),
        source="our own",
        letters=arriving,
        says="what arrived corrects what was expected",
    )


@cache
def derive():
    """The page."""
    page = (*KNOWN, late_known(), late_corrected())
    return Derivation(page=page, letters=arriving, source="our own")
