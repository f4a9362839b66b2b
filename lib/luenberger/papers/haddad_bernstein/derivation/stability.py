"""Is an estimator built from (3.14)-(3.17) stable?

Let V span the real invariant space of an eigenvalue, X V = V M with M M' = c I and
c its squared modulus.  P2 = Ae'P2 Ae + Ce'R Ce and P2 > 0 leave Ae the open disk and
those modes of modulus one that Ce does not show.  Phi = Gam A G', which is Ae before
the measurement, is always stable: Q2 = Phi Q2 Phi' + Be V2s Be' leaves it modes of
modulus one with Be'V = 0, and then G'Q2 V would span such modes of the stable A.

So Ae is stable if (Ae, Ce) is observable, as the paper's admissible set has it, or
if the joint covariance of w1, w2 is definite: a mode w of A~ of modulus one then
receives no noise, Be'v = 0, and it would be one of Phi.  Q2 > 0 and P2 > 0 alone are
not enough (`counterexamples`).

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
    JOINT,
    P2,
    PAIRS,
    Q2,
    SYMMETRIC,
    A,
    Ae,
    At,
    Be,
    C,
    Ce,
    Qt,
    R,
    Vt,
    adjoint,
    l,
    moment,
    n,
    r,
)
from .projecting import ALGEBRA, G, Gam, Qs, V2s, at

k = sp.Symbol("k", integer=True, nonnegative=True)
c = sp.Symbol("c", positive=True)
V, M = MatrixSymbol("V", r, k), MatrixSymbol("M", k, k)
Phi = MatrixSymbol("Phi", r, r)
TURNS = (M * M.T, c * Identity(k))


def observed():
    """The adjoint's side: modes of Ae."""
    algebra = Algebra(SYMMETRIC, [(Ae * V, V * M), TURNS])
    grown = (V.T * (P2 - Ae.T * P2 * Ae) * V, V.T * Ce.T * R * Ce * V)
    return claims(
        algebra,
        {
            "Ae V = V M: tr V'(P2 - Ae'P2 Ae) V = (1 - c) tr V'P2 V": (
                Trace(grown[0]),
                (1 - c) * Trace(V.T * P2 * V),
            )
        },
    ) | claims(
        Algebra(SYMMETRIC),
        {
            "(4.7) block 22: P2 - Ae'P2 Ae = Ce'R Ce": (
                adjoint(PAIRS)[1, 1],
                Ae.T * P2 * Ae + Ce.T * R * Ce,
            )
        },
    )


def driven():
    """The moment's side: modes of Phi = Gam A G'."""
    ahead = moment(PAIRS)
    observer = {Ae: Phi - Be * C * G.T}
    algebra = Algebra(SYMMETRIC, [(Phi.T * V, V * M), TURNS])
    unseen = Algebra(
        SYMMETRIC, [(Phi.T * V, V * M), (Be.T * V, ZeroMatrix(l, k)), TURNS]
    )
    return (
        claims(
            ALGEBRA,
            {
                "(4.6) block 22 is Phi Q2 Phi' + Be V2s Be', Ae = Phi - Be C G'": (
                    at(ahead[1, 1], observer),
                    Phi * Q2 * Phi.T + Be * V2s * Be.T,
                ),
                "(4.6) block 12 is A G'Q2 Phi' + Qs Be'": (
                    at(ahead[0, 1], observer),
                    A * G.T * Q2 * Phi.T + Qs * Be.T,
                ),
                "(3.10)' Ae = Phi - Be C G' with Phi = Gam A G'": (
                    Gam * A * G.T - Be * C * G.T,
                    (Phi - Be * C * G.T).xreplace({Phi: Gam * A * G.T}),
                ),
            },
        )
        | claims(
            algebra,
            {
                "Phi'V = V M: tr V'(Q2 - Phi Q2 Phi') V = (1 - c) tr V'Q2 V": (
                    Trace(V.T * (Q2 - Phi * Q2 * Phi.T) * V),
                    (1 - c) * Trace(V.T * Q2 * V),
                )
            },
        )
        | claims(
            unseen,
            {
                "Be'V = 0: block 12 gives Z = A Z M for Z = G'Q2 V, a mode of A": (
                    (A * G.T * Q2 * Phi.T + Qs * Be.T) * V,
                    A * (G.T * Q2 * V) * M,
                ),
                "Be'V = 0: a mode of Ae' is one of Phi'": (
                    (Phi - Be * C * G.T).T * V,
                    V * M,
                ),
            },
        )
    )


def definite():
    """A mode of A~ of modulus one receives no noise."""
    top, low = MatrixSymbol("X", n, k), V
    W = BlockMatrix([[top], [low]])
    mode = Algebra(
        SYMMETRIC,
        [(A.T * top, top * M - C.T * Be.T * low), (Ae.T * low, low * M), TURNS],
    )
    seen = BlockMatrix([[top], [Be.T * low]])
    return claims(
        mode,
        {
            "A~'W = W M for W = [X; V] with A'X + C'Be'V = X M, Ae'V = V M": (
                At.T * W,
                BlockMatrix([[top * M], [low * M]]),
            ),
            "tr W'(Q~ - A~Q~A~') W = (1 - c) tr W'Q~W": (
                Trace(W.T * (Qt - At * Qt * At.T) * W),
                (1 - c) * Trace(W.T * Qt * W),
            ),
            "W'V~W = [X; Be'V]'cov(w1, w2) [X; Be'V]": (
                W.T * Vt * W,
                seen.T * JOINT * seen,
            ),
        },
    )


@cache
def derive():
    return Derivation(
        formulas={"Phi": Gam * A * G.T, "Ae": Phi - Be * C * G.T},
        steps=observed() | driven() | definite(),
        source="our own",
    )
