"""The information of a record whose start is not known: its first rows as one row.

The readings that determine the state say nothing of the noises by themselves.  Given
them, the other readings of the first rows, and the state after these rows, are one
measurement and one state of an ordinary filter.

Source: our own; conditioning on the readings that determine the state is due to
Wecker and Ansley (1983), "The signal extraction approach to nonlinear regression".
"""

from functools import cache

from sympy import symbols

from ...symbolic import Derivation, Differential, Expect, Line, Stage
from .direction_letters import *
from .direction_letters import letters as of_directions

SOURCE = "our own; Wecker and Ansley (1983)"
a, a_1, f = symbols("a a_1 f", integer=True, positive=True)

letters = of_directions.here()
chain, define, moment = letters.chain, letters.define, letters.moment

# -- the state above all readings so far -----------------------------------------------

s = letters("s", a, 1, "state above the readings so far")
Phi = letters("Phi", a, n, "what the state at the first row does to them")
mu = letters("mu", a, 1, "what the inputs did to them")
epsilon = letters("epsilon", a, 1, "what the noises did to them")
P = letters("P", a, a, "covariance of `epsilon`", symmetric=True)
Z = letters("Z", a_1, a, "makes the next state, and one more row of readings, of them")
beta = letters("beta", a_1, 1, "what the input adds")
J = letters("J", a_1, a_1, "covariance of what the noises add", symmetric=True)
w = letters("w", a_1, 1, "what the noises add")
Phi_next = letters("Phi_next", a_1, n, "`Phi` one row on")
mu_next = letters("mu_next", a_1, 1, "`mu` one row on")
P_next = letters("P_next", a_1, a_1, "`P` one row on", symmetric=True)
delta = letters("delta", n, 1, "state at the first row")

# -- after the first rows --------------------------------------------------------------

E_d = letters("E_d", n, a, "takes what determines the state out of the readings")
E_r = letters("E_r", f, a, "takes the rest, below the state")
d = letters("d", n, 1, "what determines the state, of the readings")
L = letters("L", f, n, "what the rest follows from `d`")
H = letters("H", f, a, "leaves of the rest what does not follow from `d`")
inverse = letters("inverse", n, n, "of `E_d Phi`")
J_r = letters("J_r", f, f, "covariance of the rest, given `d`", symmetric=True)
beta_r = letters("beta_r", f, 1, "mean of the rest, given `d`")

# -- their changes ---------------------------------------------------------------------

dZ = letters("dZ", a_1, a, "change of `Z`")
dbeta = letters("dbeta", a_1, 1, "change of `beta`")
dJ = letters("dJ", a_1, a_1, "change of `J`", symmetric=True)
dPhi = letters("dPhi", a, n, "change of `Phi`")
dmu = letters("dmu", a, 1, "change of `mu`")
dP = letters("dP", a, a, "change of `P`", symmetric=True)
dPhi_next = letters("dPhi_next", a_1, n, "`dPhi` one row on")
dmu_next = letters("dmu_next", a_1, 1, "`dmu` one row on")
dP_next = letters("dP_next", a_1, a_1, "`dP` one row on", symmetric=True)
dL = letters("dL", f, n, "change of `L`")
dH = letters("dH", f, a, "change of `H`")
dJ_r = letters("dJ_r", f, f, "change of `J_r`", symmetric=True)
dbeta_r = letters("dbeta_r", f, 1, "change of `beta_r`")

ROWS = (
    """Put the state above all readings so far. They are what the state `delta` at the
    first row does, what the inputs did, and what the noises did. A row adds readings,
    and each part moves in the same way.""",
    parts := define(s, Phi * delta + mu + epsilon),
    is_Phi := define(Phi_next, Z * Phi),
    is_mu := define(mu_next, Z * mu + beta),
    chain(
        "",
        "the state above the readings, one row on",
        Z * s + beta + w,
        Line(Z * Phi * delta + Z * mu + Z * epsilon + beta + w, by=(parts,)),
        Line(Phi_next * delta + mu_next + Z * epsilon + w, by=(is_Phi, is_mu)),
    ),
    is_P := moment(epsilon * epsilon.T, P),
    is_J := moment(w * w.T, J),
    apart := moment(epsilon * w.T, ZeroMatrix(a, a_1)),
    is_P_next := define(P_next, Z * P * Z.T + J),
    chain(
        "",
        "the covariance of what the noises did, one row on",
        (Z * epsilon + w) * (Z * epsilon + w).T,
        Expect(Z * P * Z.T + J, moments=(is_P, is_J, apart)),
        Line(P_next, by=(is_P_next,)),
    ),
    "So the changes of these parts are as follows.",
    is_dPhi := define(dPhi_next, dZ * Phi + Z * dPhi),
    is_dmu := define(dmu_next, dZ * mu + Z * dmu + dbeta),
    is_dP := define(dP_next, dZ * P * Z.T + Z * dP * Z.T + Z * P * dZ.T + dJ),
    chain(
        "",
        "how the part of the start moves",
        Z * Phi,
        Differential(dZ * Phi + Z * dPhi, of={Z: dZ, Phi: dPhi}),
        Line(dPhi_next, by=(is_dPhi,)),
    ),
    chain(
        "",
        "how the part of the inputs moves",
        Z * mu + beta,
        Differential(dZ * mu + Z * dmu + dbeta, of={Z: dZ, mu: dmu, beta: dbeta}),
        Line(dmu_next, by=(is_dmu,)),
    ),
    chain(
        "",
        "how the covariance moves",
        Z * P * Z.T + J,
        Differential(
            dZ * P * Z.T + Z * dP * Z.T + Z * P * dZ.T + dJ, of={Z: dZ, P: dP, J: dJ}
        ),
        Line(dP_next, by=(is_dP,)),
    ),
)

ONE_ROW = (
    """When the readings determine the state, take as many combinations `d` of them as
    there are states. The start has any value, so `d` is as likely as any other, and
    only the rest tells something. The rest is the state, and all other combinations of
    the readings. What it is beyond `L d` has nothing of the start in it.""",
    is_d := define(d, E_d * s),
    is_inverse := define(E_d * Phi * inverse, Identity(n)),
    is_L := define(L * E_d * Phi, E_r * Phi),
    is_H := define(H, E_r - L * E_d),
    blind := chain(
        "",
        "nothing of the start is in it",
        H * Phi,
        Line(E_r * Phi - L * E_d * Phi, by=(is_H,)),
        Line(ZeroMatrix(f, n), by=(is_L,)),
    ),
    rest := chain(
        "",
        "the rest, given what determines the state",
        E_r * s,
        Line(L * E_d * s + H * s, by=(is_H,)),
        Line(L * d + H * s, by=(is_d,)),
        Line(L * d + H * Phi * delta + H * mu + H * epsilon, by=(parts,)),
        Line(L * d + H * mu + H * epsilon, by=(blind,)),
    ),
    """So the rest is a state and a measurement after a row in which nothing is moved
    and everything is an input or a noise.""",
    is_J_r := define(J_r, H * P * H.T),
    is_beta_r := define(beta_r, L * d + H * mu),
    chain(
        "",
        "the covariance of the rest",
        H * epsilon * epsilon.T * H.T,
        Expect(H * P * H.T, moments=(is_P,)),
        Line(J_r, by=(is_J_r,)),
    ),
    """When the plant moves, `d` is the same, and `E_d` and `E_r` are the same
    combinations of the readings. `L` moves so that it still leaves nothing of the
    start.""",
    is_dL := define(dL, H * dPhi * inverse),
    is_dH := define(dH, -dL * E_d),
    chain(
        "",
        "how the rest follows from what determines the state, moved",
        L * E_d * Phi - E_r * Phi,
        Differential(
            dL * E_d * Phi + L * E_d * dPhi - E_r * dPhi,
            of={L: dL, Phi: dPhi},
            held=(E_d, E_r),
        ),
        Line(dL * E_d * Phi - H * dPhi, by=(is_H,)),
        Line(H * dPhi * inverse * E_d * Phi - H * dPhi, by=(is_dL,)),
        Line(ZeroMatrix(f, n), by=(is_inverse,)),
    ),
    chain(
        "",
        "how that moves which leaves the rest",
        E_r - L * E_d,
        Differential(-dL * E_d, of={L: dL}, held=(E_d, E_r)),
        Line(dH, by=(is_dH,)),
    ),
    is_dJ_r := define(dJ_r, dH * P * H.T + H * dP * H.T + H * P * dH.T),
    chain(
        "",
        "how the covariance of the rest moves",
        H * P * H.T,
        Differential(dH * P * H.T + H * dP * H.T + H * P * dH.T, of={H: dH, P: dP}),
        Line(dJ_r, by=(is_dJ_r,)),
    ),
    is_dbeta_r := define(dbeta_r, dL * d + dH * mu + H * dmu),
    chain(
        "",
        "how the mean of the rest moves",
        L * d + H * mu,
        Differential(dL * d + dH * mu + H * dmu, of={L: dL, H: dH, mu: dmu}, held=(d,)),
        Line(dbeta_r, by=(is_dbeta_r,)),
    ),
)


def listed(given, stages, says):
    """A stage list of this page."""
    return Derivation(given, stages, source=SOURCE, letters=letters, says=says)


@cache
def more_readings():
    """The state above the readings, one row on: three parts."""
    stages = (
        Stage(Phi_next, Z * Phi, by=(is_Phi,)),
        Stage(mu_next, Z * mu + beta, by=(is_mu,)),
        Stage(P_next, Z * P * Z.T + J, symmetric=True, by=(is_P_next,)),
    )
    return listed((Z, beta, J, Phi, mu, P), stages, "one more row of readings")


@cache
def moved_readings():
    """The changes of the three parts, one row on."""
    stages = (
        Stage(dPhi_next, dZ * Phi + Z * dPhi, by=(is_dPhi,)),
        Stage(dmu_next, dZ * mu + Z * dmu + dbeta, by=(is_dmu,)),
        Stage(dP_next, is_dP.right, symmetric=True, by=(is_dP,)),
    )
    given = (Z, Phi, mu, P, dZ, dbeta, dJ, dPhi, dmu, dP)
    return listed(given, stages, "how one more row of readings moves")


@cache
def as_one_row():
    """The rest, given what determines the state: H, covariance and mean."""
    stages = (
        Stage(L, E_r * Phi * inverse, by=(is_L, is_inverse)),
        Stage(H, E_r - L * E_d, by=(is_H,)),
        Stage(J_r, H * P * H.T, symmetric=True, by=(is_J_r,)),
        Stage(beta_r, L * d + H * mu, by=(is_beta_r,)),
    )
    return listed((E_d, E_r, Phi, inverse, P, d, mu), stages, "the first rows as one")


@cache
def one_row_moved():
    """The changes of the rest's covariance and mean."""
    stages = (
        Stage(dL, H * dPhi * inverse, by=(is_dL,)),
        Stage(dH, -dL * E_d, by=(is_dH,)),
        Stage(dJ_r, is_dJ_r.right, symmetric=True, by=(is_dJ_r,)),
        Stage(dbeta_r, is_dbeta_r.right, by=(is_dbeta_r,)),
    )
    given = (E_d, H, inverse, P, d, mu, dPhi, dmu, dP)
    return listed(given, stages, "how the first rows as one move")


@cache
def derive():
    """The page."""
    lists = more_readings(), moved_readings(), as_one_row(), one_row_moved()
    page = (*ROWS, *lists[:2], *ONE_ROW, *lists[2:])
    return Derivation(page=page, letters=letters, source=SOURCE)
