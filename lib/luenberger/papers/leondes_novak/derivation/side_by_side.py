"""Plant and observer side by side, one step: what a Monte Carlo run repeats.

The noises are w = Hw xi and v = Hv xi of one white vector xi, [Hw; Hv] being a root
of their joint covariance.  The known input is zero: the error does not depend on it.

Source: Leondes and Novak (1974), (1), (2), (9), (11), (26).
"""

from dataclasses import replace
from functools import cache

import sympy as sp

from ....symbolic import Algebra, Derivation, MatrixSymbol, Stage, claims, matrices
from .letters import SOURCE as PAPER
from .letters import n, p, r, squares

d, q = sp.symbols("d q", integer=True, nonnegative=True)


@cache
def side_by_side():
    """x, z and xi at one instant to x, z at the next, and the error in between."""
    (A,), (F,) = squares("A"), squares("F", r)
    (C,), (D,), (L,) = matrices("C", p, n), matrices("D", r, p), matrices("L", q, n)
    (P,), (V,) = matrices("P", q, r), matrices("V", q, p)
    (Hw,), (Hv,) = matrices("Hw", n, d), matrices("Hv", p, d)
    (xi,) = matrices("xi", d, 1)
    (x, x_next), (z, z_next) = matrices("x x_next", n, 1), matrices("z z_next", r, 1)
    (y,), (w, w_hat, e) = matrices("y", p, 1), matrices("w w_hat e", q, 1)
    stages = (
        Stage(y, C * x + Hv * xi, "(2)"),
        Stage(w, L * x),
        Stage(w_hat, P * z + V * y),
        Stage(e, w_hat - w),
        Stage(z_next, F * z + D * y, "(9)"),
        Stage(x_next, A * x + Hw * xi, "(1)"),
    )
    given = (A, C, L, F, D, P, V, Hw, Hv, x, z, xi)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=_error_equation(found))


def _error_equation(derivation):
    """The error of an observer of L x is driven by the noises alone."""
    f = derivation.unfolded()
    A, C, L, F, D, P, V, Hw, Hv, x, z, xi = derivation.given
    T, T_next = MatrixSymbol("T", r, n), MatrixSymbol("T_next", r, n)
    algebra = Algebra([], [(T_next * A, F * T + D * C), (P * T, L - V * C)])
    eps, w, v = z - T * x, Hw * xi, Hv * xi
    return claims(
        algebra,
        {
            "(11) eps+ = F eps + D v - T+ w": (
                f["z_next"] - T_next * f["x_next"],
                F * eps + D * v - T_next * w,
            ),
            "(26) e = P eps + V v": (f["e"], P * eps + V * v),
        },
    )
