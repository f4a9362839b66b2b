"""How the observer starts, from what is known of the first state.

It starts at what it would follow if the state were its mean, and errs by the rest.

Source: Leondes and Novak (1974), section III, (34)-(36).
"""

from functools import cache

from ....symbolic import Derivation, Expect, Line
from .letters import *
from .quadratic import is_Omega
from .stochastic_system import deviation, is_Q, is_Sigma_x, white

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
)


@cache
def derive():
    """The page."""
    return Derivation(page=PAGE, letters=letters, source=f"{SOURCE}, section III")
