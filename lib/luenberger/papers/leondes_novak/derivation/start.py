"""How the observer starts, from what is known of the first state.

It starts at what it would follow if the state were its mean, and errs by the rest.  An
observer that starts elsewhere errs by the difference as well.

Source: Leondes and Novak (1974), section III, (34)-(36); the root is our own.
"""

from functools import cache

from sympy import symbols

from ....symbolic import (
    BlockMatrix,
    Derivation,
    Expect,
    Line,
    Stage,
    Substitute,
    ZeroMatrix,
)
from .letters import *
from .quadratic import is_Omega
from .stochastic_system import deviation, is_d, is_Q, is_Sigma_x, white

k = symbols("k", integer=True, nonnegative=True)
H_x = letters("H_x", n, k, "a root of the covariance of the state")
H_eps = letters("H_eps", r, k + 1, "a root of the second moment of the error")

PAGE = (
    """The observer starts at what is known of the first state. It then errs by what is
    not known, and the recursion starts with (36).""",
    starts := define(z_next, T_next * (A * x_bar + B * u), "34"),
    errs := define(eps_next, z_next - T_next * x_next, "8"),
    start := chain(
        "34",
        "the error at the start",
        eps_next,
        Line(z_next - T_next * x_next, by=(errs,)),
        Line(T_next * (A * x_bar + B * u) - T_next * x_next, by=(starts,)),
        Line(-T_next * (A * d + w), by=(deviation,)),
    ),
    is_Sigma_x,
    is_Q,
    white,
    is_Omega,
    chain(
        "35, 36",
        "its covariance",
        eps_next * eps_next.T,
        Line(T_next * (A * d + w) * (A * d + w).T * T_next.T, by=(start,)),
        Expect(
            T_next * (A * Sigma * A.T + Q) * T_next.T,
            moments=(is_Sigma_x, is_Q, white),
        ),
        Line(T_next * Omega * T_next.T, by=(is_Omega,)),
    ),
    """An observer that starts at some other `z` errs by what the mean of the state
    does not explain, too. That has no spread. In a root of the second moment, beside
    one of the covariance of the state, it is a single column.""",
    is_d,
    here := define(eps, z - T * x, "8"),
    elsewhere := chain(
        "8",
        "the error of any start",
        eps,
        Line(z - T * x, by=(here,)),
        Line((z - T * x_bar) - T * (x - x_bar), why="add and subtract"),
        Line((z - T * x_bar) - T * d, by=(is_d,)),
    ),
    centred := moment(d, ZeroMatrix(n, 1), "6"),
    is_H_x := define(Sigma, H_x * H_x.T),
    is_H_eps := define(H_eps, BlockMatrix([[T * H_x, z - T * x_bar]])),
    chain(
        "35",
        "the second moment of any start",
        eps * eps.T,
        Line(((z - T * x_bar) - T * d) * ((z - T * x_bar) - T * d).T, by=(elsewhere,)),
        Expect(
            T * Sigma * T.T + (z - T * x_bar) * (z - T * x_bar).T,
            moments=(is_Sigma_x, centred),
        ),
        Line(T * H_x * H_x.T * T.T + (z - T * x_bar) * (z - T * x_bar).T, by=(is_H_x,)),
        Substitute(H_eps * H_eps.T, by=(is_H_eps,)),
    ),
)


@cache
def start_root():
    """Of E[eps eps'], eps = z - T x with x of mean x_bar and covariance H_x H_x'."""
    return Derivation(
        (T, H_x, z, x_bar),
        (Stage(H_eps, is_H_eps.right, "(35)", by=(is_H_eps,)),),
        source="our own",
        letters=letters,
        says="a root of the second moment of the error at any start",
    )


@cache
def derive():
    """The page."""
    page = (*PAGE, start_root())
    return Derivation(page=page, letters=letters, source=f"{SOURCE}, section III")
