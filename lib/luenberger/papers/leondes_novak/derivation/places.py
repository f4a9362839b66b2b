"""The outputs that arrived, each in its place: no size depends on what is missing.

The outputs that did not arrive have a row of zeros in C and a variance of one in R.
The gain, the covariance and the estimate are then those of the shorter problem.

Source: our own; the step is that of Leondes and Novak (1974), (27), (33), (43).
"""

from functools import cache

from ....symbolic import Derivation, Line, Stage
from .best_coordinates import gain
from .estimate import innovation, is_innovation, rho, x_minus
from .letters import *
from .missing_outputs import pa
from .one_pass import W, is_W, loop
from .quadratic import is_Kmv, is_M, is_N, is_Y

letters = loop.here()
chain, define = letters.chain, letters.define
Pick = letters("Pick", pa, p, "picks the outputs that arrived, `y_seen = Pick y`")
C_seen = letters("C_seen", pa, n, "rows of `C`: what arrived")
E_seen = letters("E_seen", pa, m, "rows of `E`: what arrived")
R_seen = letters("R_seen", pa, pa, "noise of what arrived", symmetric=True)
M_seen = letters("M_seen", pa, pa, "innovation covariance of that", symmetric=True)
N_seen = letters("N_seen", n, pa, "covariance of that with the predicted error")
Gamma_seen = letters("Gamma_seen", n, pa, "the push, from the outputs that arrived")
J_seen = letters("J_seen", n, pa, "what their noise tells of the process noise")
Kmv_seen = letters("Kmv_seen", n, pa, "gain of minimum variance, for what arrived")
K_seen = letters("K_seen", n, pa, "the gain that runs, for what arrived")
y_seen = letters("y_seen", pa, 1, "the outputs that arrived")
rho_seen = letters("rho_seen", pa, 1, "what an estimate leaves of them")
innovation_seen = letters("innovation_seen", pa, 1, "what a prediction leaves")
Missing = letters("Missing", p, p, "diagonal: ones for the outputs that did not arrive")
W_seen = letters("W_seen", pa, pa, "how much that says", symmetric=True)
Said = letters("Said", p, p, "the same, zero for the rest", symmetric=True)
rest = Identity(p) - Pick.T * Pick

PADDED = (
    """Outputs that did not arrive keep their place: there `C` has a row of zeros, and
    `R` a variance of one. `Pick` has the rows of the identity that belong to what
    arrived.""",
    picks := define(Pick * Pick.T, Identity(pa)),
    is_C := define(C, Pick.T * C_seen),
    is_E := define(E, Pick.T * E_seen),
    is_R := define(R, Pick.T * R_seen * Pick + rest),
    """The ones are put together first, as `Missing`: added to a small variance and
    taken away again, they would take its digits along.""",
    is_Missing := define(Missing, rest),
    is_Gamma := define(Gamma, Gamma_seen * Pick),
    is_J := define(J, J_seen * Pick),
    """The covariance of the innovation is then that of what arrived, with ones on the
    rest of the diagonal. So it has an inverse.""",
    is_M,
    is_M_seen := define(M_seen, C_seen * Omega * C_seen.T + R_seen, "33"),
    beside := chain(
        "33",
        "the covariance of the innovation, beside ones",
        M,
        Line(C * Omega * C.T + R, by=(is_M,)),
        Line(
            Pick.T * C_seen * Omega * C_seen.T * Pick + Pick.T * R_seen * Pick + rest,
            by=(is_C, is_R),
        ),
        Line(Pick.T * M_seen * Pick + rest, by=(is_M_seen,)),
    ),
    """So the gain of minimum variance is that of what arrived, with columns of zeros
    for the rest.""",
    is_N,
    is_Kmv,
    is_N_seen := define(N_seen, Omega * C_seen.T, "33"),
    is_Kmv_seen := define(Kmv_seen * M_seen, N_seen, "33"),
    same_Kmv := chain(
        "33",
        "the gain of minimum variance is that of what arrived",
        Kmv_seen * Pick,
        Line(Kmv_seen * Pick * M * M.I, why="the covariance has an inverse"),
        Line(Kmv_seen * Pick * (Pick.T * M_seen * Pick + rest) * M.I, by=(beside,)),
        Line(Kmv_seen * M_seen * Pick * M.I, by=(picks,)),
        Line(Omega * C_seen.T * Pick * M.I, by=(is_Kmv_seen, is_N_seen)),
        Line(Omega * C.T * M.I, by=(is_C,)),
        Line(N * M.I, by=(is_N,)),
        Line(Kmv, by=(is_Kmv,)),
    ),
    is_K_seen := define(
        K_seen, Kmv_seen + Gamma_seen - Gamma_seen * C_seen * Kmv_seen, "33"
    ),
    same_K := chain(
        "33",
        "the gain that runs is that of what arrived",
        K,
        Line(gain.right, by=(gain,)),
        Line(
            Kmv_seen * Pick
            + Gamma_seen * Pick
            - Gamma_seen * Pick * Pick.T * C_seen * Kmv_seen * Pick,
            by=(is_C, is_Gamma, same_Kmv),
        ),
        Line(
            (Kmv_seen + Gamma_seen - Gamma_seen * C_seen * Kmv_seen) * Pick, by=(picks,)
        ),
        Line(K_seen * Pick, by=(is_K_seen,)),
    ),
    """The covariance, the correction and what the residual tells are therefore those of
    the shorter problem.""",
    is_Y,
    same_KC := chain(
        "",
        "what the gain takes of the state",
        K * C,
        Line(K_seen * Pick * Pick.T * C_seen, by=(same_K, is_C)),
        Line(K_seen * C_seen, by=(picks,)),
    ),
    same_KRK := chain(
        "",
        "what the gain takes of the noise",
        K * R * K.T,
        Line(
            K_seen * Pick * (Pick.T * R_seen * Pick + rest) * Pick.T * K_seen.T,
            by=(same_K, is_R),
        ),
        Line(K_seen * R_seen * K_seen.T, by=(picks,)),
    ),
    chain(
        "27",
        "the covariance is that of what arrived",
        Y * Omega * Y.T + K * R * K.T,
        Line((I - K * C) * Omega * (I - K * C).T + K * R * K.T, by=(is_Y,)),
        Line(
            (I - K_seen * C_seen) * Omega * (I - K_seen * C_seen).T
            + K_seen * R_seen * K_seen.T,
            by=(same_KC, same_KRK),
        ),
    ),
    is_innovation,
    is_y := define(y, Pick.T * y_seen),
    is_innovation_seen := define(
        innovation_seen, y_seen - E_seen * u_next - C_seen * x_minus, "43"
    ),
    chain(
        "43",
        "the correction is that of what arrived",
        K * innovation,
        Line(K * (y - E * u_next - C * x_minus), by=(is_innovation,)),
        Line(
            K * Pick.T * (y_seen - E_seen * u_next - C_seen * x_minus),
            by=(is_y, is_E, is_C),
        ),
        Line(K * Pick.T * innovation_seen, by=(is_innovation_seen,)),
        Line(K_seen * Pick * Pick.T * innovation_seen, by=(same_K,)),
        Line(K_seen * innovation_seen, by=(picks,)),
    ),
    is_rho := define(rho, Pick.T * rho_seen),
    chain(
        "43",
        "what the residual tells is that of what arrived",
        J * rho,
        Line(J_seen * Pick * Pick.T * rho_seen, by=(is_J, is_rho)),
        Line(J_seen * rho_seen, by=(picks,)),
    ),
    """What did not arrive says nothing to a smoother. The inverse of `M` has ones for
    it, those of `Missing`, which are taken away.""",
    is_W,
    is_W_seen := define(W_seen * M_seen, Identity(pa)),
    is_Said := define(Said, Pick.T * W_seen * Pick),
    both := chain(
        "",
        "how much what arrived says, beside ones",
        (Said + Missing) * M,
        Line(
            (Pick.T * W_seen * Pick + rest) * (Pick.T * M_seen * Pick + rest),
            by=(is_Said, is_Missing, beside),
        ),
        Line(Pick.T * W_seen * M_seen * Pick + rest, by=(picks,)),
        Line(Identity(p), by=(is_W_seen,)),
    ),
    says := chain(
        "",
        "how much what arrived says",
        Said,
        Line((Said + Missing) * M * M.I - Missing, why="the covariance has an inverse"),
        Line(M.I - Missing, by=(both,)),
        Line(W * M * M.I - Missing, by=(is_W,)),
        Line(W - Missing, why="cancel"),
    ),
)


@cache
def padded():
    """The matrices of the outputs that arrived, each in the place of its output.

    Pick (pa, p) holds rows of the identity, y_seen = Pick y.
    """
    return Derivation(
        (Pick, C_seen, E_seen, R_seen, Gamma_seen, J_seen),
        (
            Stage(C, Pick.T * C_seen, by=(is_C,)),
            Stage(E, Pick.T * E_seen, by=(is_E,)),
            Stage(Missing, rest, symmetric=True, by=(is_Missing,)),
            Stage(
                R,
                Pick.T * R_seen * Pick + Missing,
                symmetric=True,
                by=(is_R, is_Missing),
            ),
            Stage(Gamma, Gamma_seen * Pick, by=(is_Gamma,)),
            Stage(J, J_seen * Pick, by=(is_J,)),
        ),
        source="our own",
        letters=letters,
        says="the outputs that arrived, each in its place",
    )


@cache
def derive():
    """The page."""
    page = (*PADDED, padded())
    return Derivation(page=page, letters=letters, source=f"our own; {SOURCE}")
