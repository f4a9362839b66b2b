"""How a filter moves with its plant: the change of each row in one direction.

Move everything that the plant says in one direction, and differentiate the filter.
Its gain moves too, but the covariance of the prediction does not feel that.

Source: our own; the recursions are those of Gupta and Mehra (1974), "Computational
aspects of maximum likelihood estimation and reduction in sensitivity function
calculations".
"""

from functools import cache

from ...symbolic import Derivation, Differential, Expect, Line, Stage
from .direction_letters import *

SOURCE = "our own; Gupta and Mehra (1974)"
after = (A - G * C) * Omega * (A - G * C).T + Q - S * G.T - G * S.T + G * R * G.T

PAGE = (
    """Move `A`, `B`, `C`, `E`, `Q`, `R` and `S` in one direction. The innovation of a
    row and its covariance are the following, and so they move.""",
    is_nu := define(nu, y - E * u - C * x),
    is_dnu := define(dnu, -dE * u - dC * x - C * dx),
    chain(
        "",
        "how an innovation moves",
        nu,
        Line(y - E * u - C * x, by=(is_nu,)),
        Differential(-dE * u - dC * x - C * dx, of={E: dE, C: dC, x: dx}),
        Line(dnu, by=(is_dnu,)),
    ),
    is_M := define(M, C * Omega * C.T + R),
    is_dM := define(dM, dC * Omega * C.T + C * dOmega * C.T + C * Omega * dC.T + dR),
    chain(
        "",
        "how its covariance moves",
        C * Omega * C.T + R,
        Differential(
            dC * Omega * C.T + C * dOmega * C.T + C * Omega * dC.T + dR,
            of={C: dC, Omega: dOmega, R: dR},
        ),
        Line(dM, by=(is_dM,)),
    ),
    """The gain solves `G M = N`, whatever the plant says. So the difference of both
    sides does not move either. `T` stands for what is left of it without the change of
    the gain.""",
    is_N := define(N, A * Omega * C.T + S),
    is_G := define(G * M, N),
    is_W := define(M * W, Identity(p)),
    is_F := define(F, A - G * C),
    is_H := define(H, dA - G * dC),
    is_T := define(
        T, F * dOmega * C.T + H * Omega * C.T + F * Omega * dC.T + dS - G * dR
    ),
    chain(
        "",
        "how the gain moves",
        A * Omega * C.T + S - G * (C * Omega * C.T + R),
        Differential(
            dA * Omega * C.T
            + A * dOmega * C.T
            + A * Omega * dC.T
            + dS
            - dG * (C * Omega * C.T + R)
            - G * (dC * Omega * C.T + C * dOmega * C.T + C * Omega * dC.T + dR),
            of={A: dA, C: dC, Omega: dOmega, S: dS, R: dR, G: dG},
        ),
        Line(
            (dA - G * dC) * Omega * C.T
            + (A - G * C) * dOmega * C.T
            + (A - G * C) * Omega * dC.T
            + dS
            - G * dR
            - dG * M,
            by=(is_M,),
        ),
        Line(T - dG * M, by=(is_T, is_F, is_H)),
    ),
    """So `dG M = T`. The next prediction moves with the plant, with the prediction
    before it, and with the gain.""",
    is_x_next := define(dx_next, F * dx + H * x + b * u + dG * nu),
    is_b := define(b, dB - G * dE),
    moves := chain(
        "",
        "how the next prediction moves",
        A * x + B * u + G * nu,
        Differential(
            dA * x + A * dx + dB * u + dG * nu + G * dnu,
            of={A: dA, x: dx, B: dB, G: dG, nu: dnu},
        ),
        Line(
            (dA - G * dC) * x + (A - G * C) * dx + (dB - G * dE) * u + dG * nu,
            by=(is_dnu,),
        ),
        Line(H * x + F * dx + b * u + dG * nu, by=(is_H, is_F, is_b)),
        Line(dx_next, by=(is_x_next,)),
    ),
    """In the covariance of the next prediction the change of the gain meets a factor
    that is zero, because no gain leaves a smaller covariance.""",
    is_U := define(U, C * Omega * F.T + S.T - R * G.T),
    nothing := chain(
        "",
        "what the change of the gain meets",
        U,
        Line(C * Omega * (A - G * C).T + S.T - R * G.T, by=(is_U, is_F)),
        Line(C * Omega * A.T + S.T - (C * Omega * C.T + R) * G.T, why="collect"),
        Line(N.T - M * G.T, by=(is_N, is_M)),
        Line(ZeroMatrix(p, n), by=(is_G,)),
    ),
    is_D := define(
        D,
        H * Omega * F.T + F * Omega * H.T + dQ - dS * G.T - G * dS.T + G * dR * G.T,
    ),
    is_dOmega_next := define(dOmega_next, F * dOmega * F.T + D),
    chain(
        "",
        "how the covariance of the next prediction moves",
        after,
        Differential(
            F * dOmega * F.T + D - dG * U - U.T * dG.T,
            of={A: dA, C: dC, Omega: dOmega, Q: dQ, R: dR, S: dS, G: dG},
            by=(is_F, is_H, is_D, is_U),
        ),
        Line(F * dOmega * F.T + D, by=(nothing,)),
        Line(dOmega_next, by=(is_dOmega_next,)),
    ),
)

MEANS = (
    """An innovation has the mean zero, and so what an input does to the changes is in
    their means alone.""",
    is_dn := define(dn, -dE * u - dC * mean - C * dm),
    is_dm_next := define(dm_next, F * dm + H * mean + b * u),
    is_mean_next := define(mean_next, A * mean + B * u),
    is_x_mean := moment(x, mean),
    is_dx_mean := moment(dx, dm),
    is_nu_mean := moment(nu, ZeroMatrix(p, 1)),
    chain(
        "",
        "the mean of the change of an innovation",
        -dE * u - dC * x - C * dx,
        Expect(-dE * u - dC * mean - C * dm, moments=(is_x_mean, is_dx_mean)),
        Line(dn, by=(is_dn,)),
    ),
    chain(
        "",
        "the mean of the change of the next prediction",
        F * dx + H * x + b * u + dG * nu,
        Expect(
            F * dm + H * mean + b * u,
            moments=(is_dx_mean, is_x_mean, is_nu_mean),
        ),
        Line(dm_next, by=(is_dm_next,)),
    ),
    chain(
        "",
        "the mean of the next prediction",
        A * x + B * u + G * nu,
        Expect(A * mean + B * u, moments=(is_x_mean, is_nu_mean)),
        Line(mean_next, by=(is_mean_next,)),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def gain_of_prediction():
    """The gain of the prediction, from the covariance and W = M^-1."""
    stages = (
        Stage(N, A * Omega * C.T + S, by=(is_N,)),
        Stage(G, N * W, by=(is_G, is_W)),
    )
    return listed((A, C, S, Omega, W), stages, "the gain of a prediction")


@cache
def driven():
    """What a row adds to the change of the covariance."""
    stages = (
        Stage(F, A - G * C, by=(is_F,)),
        Stage(H, dA - G * dC, by=(is_H,)),
        Stage(D, is_D.right, symmetric=True, by=(is_D,)),
    )
    given = (A, C, Omega, G, dA, dC, dQ, dR, dS)
    return listed(given, stages, "what a row adds to the change of the covariance")


@cache
def changed_on():
    """The change of the covariance, one row on."""
    stages = (
        Stage(dOmega_next, F * dOmega * F.T + D, symmetric=True, by=(is_dOmega_next,)),
    )
    return listed((F, D, dOmega), stages, "the change of the covariance, one row on")


@cache
def shown_by_row():
    """The change of the innovation's covariance, and of the gain times M."""
    stages = (
        Stage(dM, is_dM.right, symmetric=True, by=(is_dM,)),
        Stage(T, is_T.right, by=(is_T,)),
    )
    given = (C, Omega, G, F, H, dC, dR, dS, dOmega)
    return listed(given, stages, "how a row's innovation and gain move")


@cache
def mean_step():
    """The means of a prediction and of the changes, one row on."""
    stages = (
        Stage(b, dB - G * dE, by=(is_b,)),
        Stage(dn, is_dn.right, by=(is_dn,)),
        Stage(dm_next, is_dm_next.right, by=(is_dm_next,)),
        Stage(mean_next, is_mean_next.right, by=(is_mean_next,)),
    )
    given = (A, B, C, G, F, H, dB, dC, dE, mean, dm, u)
    return listed(given, stages, "the means, one row on")


@cache
def derive():
    """The page."""
    lists = gain_of_prediction(), driven(), changed_on(), shown_by_row()
    page = (*PAGE, *lists, *MEANS, mean_step())
    return Derivation(page=page, letters=letters, source=SOURCE)
