"""Multiplicative noise acts only through the plant's own second moment.

No estimator changes Q1 = E[x x'], and the noise enters the rest of the augmented
moments as V1e = V1 + sum A_i Q1 A_i', V12e = V12 + sum A_i Q1 C_i' and
V2e = V2 + sum C_i Q1 C_i'.  So every linear estimator costs the same, and is
stationary under the same conditions, as on the plant without multiplicative noise
that has these covariances; only second moments are equal, which is all a linear
estimator sees.  One generalised Lyapunov equation, for Q1, is all that is left.

Source: our own; Haddad and Bernstein (1987) for the equations that are compared.
"""

from functools import cache

from ....symbolic import Algebra, Derivation, ZeroMatrix, claims
from .augmented import (
    GAINS,
    PAIRS,
    Q1,
    SYMMETRIC,
    V1,
    V2,
    V12,
    A,
    C,
    adjoint,
    cost,
    gradients,
    lagrangian,
    moment,
)
from .converse import PH, QH, TAU
from .stationarity import Q, V2s, noise, theorem

ALGEBRA = Algebra(SYMMETRIC)
EQUIVALENT = {
    V1: V1 + noise(Q1, 0, 0),
    V12: V12 + noise(Q1, 0, 1),
    V2: V2 + noise(Q1, 1, 1),
}
PLAIN = {X: ZeroMatrix(*X.shape) for pair in PAIRS for X in pair}


def there(value):
    """A normal form without pairs, on the equivalent plant."""
    return value.as_expr().xreplace(EQUIVALENT)


def moments():
    ahead, back, alone, dual = moment(PAIRS), adjoint(PAIRS), moment(), adjoint()
    names = {(0, 0): "11", (0, 1): "12", (1, 1): "22"}
    found = {
        f"(4.4) block {name} is that of the equivalent plant": (
            ahead[ij],
            there(alone[ij]),
        )
        for ij, name in names.items()
    }
    return found | {
        "(4.4) block 11 holds no estimator: Q1 = A Q1 A' + sum A_i Q1 A_i' + V1": (
            ahead[0, 0],
            A * Q1 * A.T + noise(Q1, 0, 0) + V1,
        ),
        "(4.5) block 12 holds no A_i, C_i": (back[0, 1], dual[0, 1]),
        "(4.5) block 22 holds no A_i, C_i": (back[1, 1], dual[1, 1]),
        "(3.5) J is that of the equivalent plant": (cost(PAIRS), there(cost())),
    }


def stationarity():
    there_ = gradients()
    return {
        f"(4.{k}) the gradient in {X.name} is that of the equivalent plant": (
            gradients(PAIRS)[X],
            there(there_[X]),
        )
        for k, X in enumerate(GAINS, 8)
    } | {
        "with Q1 in V1e, V12e, V2e the Lagrangian is the same expression": (
            lagrangian(PAIRS),
            there(lagrangian()),
        )
    }


def equations():
    """(3.14)-(3.18) go over into those with A_i = C_i = 0, as Q + tau Qh tau' = Q1."""
    known = Algebra((*SYMMETRIC, Q, QH, PH, V2s), [(TAU * QH * TAU.T, Q1 - Q)])
    said = theorem(TAU, QH, PH)
    return claims(
        known,
        {
            f"{key} is that of the equivalent plant": (
                residual,
                residual.xreplace(PLAIN).xreplace(EQUIVALENT),
            )
            for key, residual in said.items()
        }
        | {
            "V2s of section 2 is C Q C' + V2e": (
                V2 + C * Q * C.T + noise(Q + TAU * QH * TAU.T, 1, 1),
                (V2 + C * Q * C.T).xreplace(EQUIVALENT),
            ),
            "Qs of section 2 is A Q C' + V12e": (
                V12 + A * Q * C.T + noise(Q + TAU * QH * TAU.T, 0, 1),
                (V12 + A * Q * C.T).xreplace(EQUIVALENT),
            ),
        },
    )


@cache
def derive():
    return Derivation(
        given=(A, C, V1, V12, V2, Q1),
        formulas={
            "V1e": EQUIVALENT[V1],
            "V12e": EQUIVALENT[V12],
            "V2e": EQUIVALENT[V2],
        },
        steps=claims(ALGEBRA, moments() | stationarity()) | equations(),
        source="our own",
    )
