"""H2 model reduction is a fixed-order filter of a plant that is its own noise.

A model Am, Bm, Cm of low order is to answer white noise as A, B, C does, in
continuous time.  The Cayley transform Ad = (I + A/a)(I - A/a)^-1, Bd = sqrt(2/a)
(I - A/a)^-1 B leaves the solution of the Lyapunov equation as it is, and so the
distance of the two models.  In discrete time the noise itself is measured, y = w:
the plant has C = 0, V1 = Bd Bd', V12 = Bd, V2 = I, and the filter of least error
without feedthrough is the transform of the best model.

Source: our own.
"""

from functools import cache

import sympy as sp
from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)
from .blocks import (
    Q1,
    Q2,
    Q12,
    SYMMETRIC,
    V1,
    V2,
    V12,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    Qt,
    R,
    cost,
    l,
    moment,
    n,
    r,
)

a = sp.Symbol("a", positive=True)
N, Nm = MatrixSymbol("N", n, n), MatrixSymbol("Nm", r, r)  # I - A/a, I - Am/a
Am, B, Bm = MatrixSymbol("Am", r, r), MatrixSymbol("B", n, l), MatrixSymbol("Bm", r, l)
Ad, Bd = 2 * N.I - Identity(n), sp.sqrt(2 / a) * N.I * B
Amd, Bmd = 2 * Nm.I - Identity(r), sp.sqrt(2 / a) * Nm.I * Bm
ALGEBRA = Algebra(SYMMETRIC, [(A, a * (Identity(n) - N)), (Am, a * (Identity(r) - Nm))])

PLANT = {
    A: Ad,
    C: ZeroMatrix(l, n),
    V1: Bd * Bd.T,
    V12: Bd,
    V2: Identity(l),
    Ae: Amd,
    Be: Bmd,
    De: ZeroMatrix(*De.shape),
}


def steps():
    both = BlockMatrix([[B], [Bm]])
    flow = BlockMatrix([[A, ZeroMatrix(n, r)], [ZeroMatrix(r, n), Am]])
    continuous = flow * Qt + Qt * flow.T + both * both.T
    ahead = moment()
    left = [N, Nm]
    found = {
        "Ad (I - A/a) = I + A/a": (Ad * N, Identity(n) + A / a),
        "the distance of two models is J of the filter": (
            cost().as_expr().xreplace(PLANT),
            Trace(
                R * (L * Q1 * L.T - L * Q12 * Ce.T - Ce * Q12.T * L.T + Ce * Q2 * Ce.T)
            ),
        ),
    }
    for (i, j), name in {(0, 0): "11", (0, 1): "12", (1, 1): "22"}.items():
        discrete = ahead[i, j].as_expr().xreplace(PLANT) - Qt.blocks[i, j]
        found[f"block {name} of (4.6) is (2/a) that of the continuous equation"] = (
            left[i] * discrete * left[j].T,
            2 / a * ALGEBRA.normal(continuous)[i, j].as_expr(),
        )
    return found


@cache
def derive():
    return Derivation(
        given=(A, B, L),
        formulas={"Ad": Ad, "Bd": Bd},
        steps=claims(ALGEBRA, steps()),
        source="our own",
    )
