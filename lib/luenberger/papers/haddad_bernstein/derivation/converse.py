"""Do (3.14)-(3.17) imply stationarity?  Yes, if (3.17) is read as it is printed.

(3.17) asks for one xi that makes both Qh and Ph diagonal, tau = xi E xi^-1.  Then
tau Qh = Qh tau' and Ph tau = tau'Ph, and these two alignments are all that is needed:
with Q2 = Gam Qh Gam', P2 = G Ph G', Q12 = G'Q2, P12 = -Gam'P2, Q1 = Q + G'Q2 G every
block of (4.6), (4.7) and every gradient vanishes.  Stationarity in turn gives the
alignments (`stationarity`), and they give such a xi.  So the theorem is an
equivalence: stationary points are choices of n_e eigenprojections of Qh Ph.

Not for the weaker reading, a projection of rank n_e with tau = Qhat Phat (Qhat
Phat)^#, Qhat = tau Qh tau', Phat = tau'Ph tau: that last equation holds for every
tau.  Nor is one of the alignments enough (`counterexamples`).

Source: our own; Haddad and Bernstein (1987), theorem 3.1 and section 4.
"""

from functools import cache

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
    GAINS,
    P2,
    PAIRS,
    Q1,
    Q2,
    V1,
    A,
    C,
    De,
    L,
    Pt,
    Qt,
    R,
    adjoint,
    gradients,
    moment,
    n,
    r,
)
from .projecting import ALGEBRA, G, Gam, K, Q, Qhat, Qs, V2s, at, noise, theorem

TAU, QH, PH = (MatrixSymbol(k, n, n) for k in ("tau", "Qh", "Ph"))
one = Identity(n)
FACTORS = Algebra([QH, PH, Q2, P2], [(TAU, G.T * Gam), (Gam * G.T, Identity(r))])


ALIGNED = ALGEBRA.with_relations(
    (Gam * G.T, Identity(r)),
    (TAU, G.T * Gam),
    (QH * Gam.T, G.T * Q2),
    (PH * G.T, Gam.T * P2),
    symmetric=[QH, PH],
)


def equations():
    """(3.14)-(3.16) as {product: what it is}, given the alignments."""
    Aq = A - K * C
    shown = L.T * R * De * C
    known = (De * C).T * R * De * C
    return {
        V1: Q1 - A * Q1 * A.T - noise(Q + Qhat, 0, 0),
        Qs * V2s.I * Qs.T: QH - A * Qhat * A.T,
        L.T * R * L: PH - Aq.T * Gam.T * P2 * Gam * Aq + shown + shown.T - known,
    }


STATIONARY = ALIGNED.with_relations(*equations().items())


def aligned():
    """What the alignments give, and what (3.14)-(3.16) then say."""
    said, solved = theorem(TAU, QH, PH), equations()
    return claims(
        FACTORS,
        {
            "(3.17) Qh Gam' = G'(Gam Qh Gam'), as Qh tau' = tau Qh": (
                QH * Gam.T - G.T * Gam * QH * Gam.T,
                (QH * TAU.T - TAU * QH) * Gam.T,
            ),
            "(3.17) Ph G' = Gam'(G Ph G'), as Ph tau = tau'Ph": (
                PH * G.T - Gam.T * G * PH * G.T,
                (PH * TAU - TAU.T * PH) * G.T,
            ),
            "(3.17) tau Qh tau_perp' = (tau Qh - Qh tau') tau_perp'": (
                TAU * QH * (one - TAU).T,
                (TAU * QH - QH * TAU.T) * (one - TAU).T,
            ),
            "(3.17) tau_perp'Ph tau = tau_perp'(Ph tau - tau'Ph)": (
                (one - TAU).T * PH * TAU,
                (one - TAU).T * (PH * TAU - TAU.T * PH),
            ),
        },
    ) | claims(
        ALIGNED,
        {
            "(3.14) + (3.15) is (4.12): V1 = Q1 - A Q1 A' - sum A_i Q1 A_i'": (
                said["(3.14)"] + said["(3.15)"],
                V1 - solved[V1],
            ),
            "(3.15) says Qs V2s^-1 Qs' = Qh - A G'Q2 G A'": (
                said["(3.15)"],
                Qs * V2s.I * Qs.T - solved[Qs * V2s.I * Qs.T],
            ),
            "(3.16) solved for L'R L": (
                said["(3.16)"],
                L.T * R * L - solved[L.T * R * L],
            ),
        },
    )


def sufficient():
    """(3.14)-(3.17) imply (4.6)-(4.11)."""
    ahead, back, g = moment(PAIRS), adjoint(PAIRS), gradients(PAIRS)
    best = STATIONARY.with_relations((De * V2s, L * Q * C.T))
    names = {(0, 0): "11", (0, 1): "12", (1, 1): "22"}
    blocks = {
        f"(4.6) block {name} holds if (3.14)-(3.17) do": (
            at(ahead[ij]),
            Qt.blocks[ij],
        )
        for ij, name in names.items()
    } | {
        f"(4.7) block {name} holds if (3.14)-(3.17) do": (
            at(back[ij]),
            Pt.blocks[ij],
        )
        for ij, name in names.items()
        if name != "11"  # which defines P1
    }
    return claims(STATIONARY, blocks) | claims(
        best,
        {
            f"(4.{j}) the gradient in {X.name} vanishes if (3.14)-(3.17) hold": (
                at(g[X]),
                0,
            )
            for j, X in enumerate(GAINS, 8)
        },
    )


def as_printed():
    """xi = [X1 X2] makes Qh and Ph diagonal: then tau = X1 Y1 is aligned with both."""
    d = n - r
    X1, X2 = MatrixSymbol("X_1", n, r), MatrixSymbol("X_2", n, d)
    Y1, Y2 = MatrixSymbol("Y_1", r, n), MatrixSymbol("Y_2", d, n)
    D1, E1 = MatrixSymbol("D_1", r, r), MatrixSymbol("E_1", r, r)
    D2, E2 = MatrixSymbol("D_2", d, d), MatrixSymbol("E_2", d, d)
    xi, inverse = BlockMatrix([[X1, X2]]), BlockMatrix([[Y1], [Y2]])
    algebra = Algebra(
        [D1, D2, E1, E2],
        [
            (TAU, X1 * Y1),
            (QH, X1 * D1 * X1.T + X2 * D2 * X2.T),
            (PH, Y1.T * E1 * Y1 + Y2.T * E2 * Y2),
            *((Y * X, Identity(X.shape[1])) for X, Y in ((X1, Y1), (X2, Y2))),
            (Y1 * X2, ZeroMatrix(r, d)),
            (Y2 * X1, ZeroMatrix(d, r)),
        ],
    )
    diagonal = lambda a, b: BlockMatrix(  # noqa: E731
        [[a, ZeroMatrix(r, d)], [ZeroMatrix(d, r), b]]
    )
    return claims(
        algebra,
        {
            "(3.17) xi^-1 Qh xi^-T is diagonal": (
                inverse * QH * inverse.T,
                diagonal(D1, D2),
            ),
            "(3.17) xi'Ph xi is diagonal": (xi.T * PH * xi, diagonal(E1, E2)),
            "(3.17) xi^-1 Qh Ph xi is diagonal; its first n_e entries are Q2 P2": (
                inverse * QH * PH * xi,
                diagonal(D1 * E1, D2 * E2),
            ),
            "(3.17) gives tau Qh = Qh tau'": (TAU * QH, QH * TAU.T),
            "(3.17) gives Ph tau = tau'Ph": (PH * TAU, TAU.T * PH),
            "(3.17) gives tau^2 = tau, G' = X_1, Gam = Y_1": (TAU * TAU, X1 * Y1),
            "(3.17) Q2 = Gam Qh Gam' = D_1": (Y1 * QH * Y1.T, D1),
            "(3.17) P2 = G Ph G' = E_1": (X1.T * PH * X1, E1),
        },
    )


def necessary():
    """The alignments give a xi: G'X and N Y diagonalise the two parts of Qh and Ph."""
    d = n - r
    N, M = MatrixSymbol("N", n, d), MatrixSymbol("M", d, n)
    X, Y = MatrixSymbol("X", r, r), MatrixSymbol("Y", d, d)
    D1, E1 = MatrixSymbol("D_1", r, r), MatrixSymbol("E_1", r, r)
    D2, E2 = MatrixSymbol("D_2", d, d), MatrixSymbol("E_2", d, d)
    Xi, Yi = X.I, Y.I
    xi = BlockMatrix([[G.T * X, N * Y]])
    inverse = BlockMatrix([[Xi * Gam], [Yi * M]])
    algebra = Algebra(
        [D1, D2, E1, E2],
        [
            (QH, G.T * X * D1 * X.T * G + N * Y * D2 * Y.T * N.T),
            (PH, Gam.T * Xi.T * E1 * Xi * Gam + M.T * Yi.T * E2 * Yi * M),
            (Gam * G.T, Identity(r)),
            (M * N, Identity(d)),
            (Gam * N, ZeroMatrix(r, d)),
            (M * G.T, ZeroMatrix(d, r)),
            (N * M, one - G.T * Gam),
        ],
    )
    diagonal = lambda a, b: BlockMatrix(  # noqa: E731
        [[a, ZeroMatrix(r, d)], [ZeroMatrix(d, r), b]]
    )
    return claims(
        algebra,
        {
            "(3.17) from the alignments: xi^-1 xi = I": (
                inverse * xi,
                diagonal(Identity(r), Identity(d)),
            ),
            "(3.17) from the alignments: xi xi^-1 = I": (xi * inverse, one),
            "(3.17) from the alignments: xi^-1 Qh xi^-T is diagonal": (
                inverse * QH * inverse.T,
                diagonal(D1, D2),
            ),
            "(3.17) from the alignments: xi'Ph xi is diagonal": (
                xi.T * PH * xi,
                diagonal(E1, E2),
            ),
            "(3.17) from the alignments: xi [I 0; 0 0] xi^-1 = G'Gam": (
                xi * diagonal(Identity(r), ZeroMatrix(d, d)) * inverse,
                G.T * Gam,
            ),
        },
    )


@cache
def derive():
    return Derivation(
        formulas={"(3.17) tau": G.T * Gam, "Qh": QH, "Ph": PH},
        steps=aligned() | sufficient() | as_printed() | necessary(),
        source="our own",
    )
