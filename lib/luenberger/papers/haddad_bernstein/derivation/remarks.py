"""What is said beside the theorem: lemma 3.1, (3.18)-(3.20), remarks 3.3 and 3.4.

Source: Haddad and Bernstein (1987), section 3.
"""

from functools import cache

from sympy import Trace

from ....symbolic import Algebra, Derivation, Identity, MatrixSymbol, ZeroMatrix, claims
from .blocks import (
    P2,
    P12,
    PAIRS,
    Q2,
    Q12,
    SYMMETRIC,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    R,
    adjoint,
    cost,
    gradients,
    l,
    moment,
    n,
    q,
    r,
)
from .projecting import BEST, PROJECTING, G, Gam, K, Q, V2s, at, formulas, tau

S = MatrixSymbol("S", r, r)
Si = S.I
xe, xh, k, y = (
    MatrixSymbol(name, d, 1) for name, d in zip(("x_e", "xhat", "k", "y"), (r, n, n, l))
)


def lemma():
    """Lemma 3.1; that tau of rank n_e is X Y, of full rank, is a rank argument."""
    X, Y = MatrixSymbol("X", n, r), MatrixSymbol("Y", r, n)
    Xl, Yr = MatrixSymbol("X+", r, n), MatrixSymbol("Y+", n, r)
    G1, Gam1 = MatrixSymbol("G_1", r, n), MatrixSymbol("Gam_1", r, n)
    change, back = Gam1 * G.T, Gam * G1.T
    between = G1.T * Gam1 - G.T * Gam
    factors = Algebra([], [(Gam * G.T, Identity(r)), (Gam1 * G1.T, Identity(r))])
    full = Algebra([], [(Xl * X, Identity(r)), (Y * Yr, Identity(r))])
    return claims(
        factors,
        {
            "(3.6) lemma 3.1: tau^2 = tau if Gam G' = I": (tau * tau, tau),
            "(3.7) lemma 3.1: Gam tau G' = I, so tau has rank n_e": (
                Gam * tau * G.T,
                Identity(r),
            ),
            "(3.8) lemma 3.1, two factorisations of one tau: Gam_1 = S Gam": (
                Gam1 - change * Gam,
                Gam1 * between,
            ),
            "(3.8) lemma 3.1, two factorisations of one tau: G_1' = G' S^-1": (
                G1.T - G.T * back,
                between * G1.T,
            ),
            "(3.9) lemma 3.1: S = Gam_1 G' has the inverse Gam G_1'": (
                Identity(r) - change * back,
                Gam1 * between * G1.T,
            ),
            "(3.9) lemma 3.1: and on the other side": (
                Identity(r) - back * change,
                -Gam * between * G.T,
            ),
        },
    ) | claims(
        full,
        {
            "(3.8),(3.9) lemma 3.1: X Y X Y = X Y is Y X = I for X, Y of full rank": (
                Xl * (X * Y * X * Y - X * Y) * Yr,
                Y * X - Identity(r),
            )
        },
    )


def remarks():
    """(3.18)-(3.20), and remarks 3.3 and 3.4."""
    J = cost(PAIRS).as_expr()
    silent = {De: ZeroMatrix(q, l)}
    observer = Gam * A * G.T * xe + Gam * K * (y - C * G.T * xe)
    moved = {Ae: S * Ae * Si, Be: S * Be, Ce: Ce * Si}
    moments_ = {Q12: Q12 * S.T, Q2: S * Q2 * S.T, P12: P12 * Si, P2: Si.T * P2 * Si}
    both = moved | moments_
    ahead, back, g = moment(PAIRS), adjoint(PAIRS), gradients(PAIRS)
    best = PROJECTING.with_relations((De * V2s, L * Q * C.T))
    plain = Algebra(SYMMETRIC)
    found = claims(
        PROJECTING,
        {
            "(3.18) De = 0, remark 3.3: J = tr L Q L'R": (
                at(cost(PAIRS), {Ce: BEST[Ce]}).xreplace(silent),
                Trace(L * Q * L.T * R),
            ),
            "(3.19) x_e+ = Ae x_e + Be y is Gam A G'x_e + Gam K (y - C G'x_e)": (
                BEST[Ae] * xe + BEST[Be] * y,
                observer,
            ),
            "(3.20) x^ = G'x_e: x^_+ = tau A x^ + tau K (y - C x^)": (
                G.T * observer,
                (tau * A * xh + tau * K * (y - C * xh)).xreplace({xh: G.T * xe}),
            ),
            "(3.20) tau x^ = x^ for x^ = G'x_e": (tau * G.T * xe, G.T * xe),
            "(3.20) of an error input k the estimator sees Gam k = Gam (tau k) alone": (
                Gam * k,
                Gam * (tau * k),
            ),
        },
    )
    found |= claims(
        PROJECTING,
        {
            f"({k}) De = 0, remark 3.3: the gradient in {X.name} vanishes as before": (
                at(g[X]).xreplace(silent),
                0,
            )
            for k, X in zip(("3.10", "3.11", "3.12"), (Ae, Be, Ce))
        },
    ) | claims(
        best,
        {
            "(3.18) J = tr (L Q L' - De V2s De') R": (
                at(cost(PAIRS), {Ce: BEST[Ce]}),
                formulas()["(3.18) J"],
            )
        },
    )
    return found | claims(
        plain,
        {
            "remark 3.4: S leaves the cost alone": (J.xreplace(both), J),
            "remark 3.4: block 12 of (4.6) turns by S": (
                at(ahead[0, 1], both),
                ahead[0, 1].as_expr() * S.T,
            ),
            "remark 3.4: block 22 of (4.6) turns by S": (
                at(ahead[1, 1], both),
                S * ahead[1, 1].as_expr() * S.T,
            ),
            "remark 3.4: block 12 of (4.7) turns by S^-1": (
                at(back[0, 1], both),
                back[0, 1].as_expr() * Si,
            ),
            "remark 3.4: block 22 of (4.7) turns by S^-1": (
                at(back[1, 1], both),
                Si.T * back[1, 1].as_expr() * Si,
            ),
            "remark 3.4: tau = G'Gam does not change": (
                (S.T.I * G).T * (S * Gam),
                tau,
            ),
        },
    )


@cache
def derive():
    return Derivation(
        formulas={
            "(3.19) x_e+": Gam * A * G.T * xe + Gam * K * (y - C * G.T * xe),
            "(3.20) x^_+": tau * A * xh + tau * K * (y - C * xh),
        },
        steps=lemma() | remarks(),
        source="Haddad and Bernstein (1987), section 3",
    )
