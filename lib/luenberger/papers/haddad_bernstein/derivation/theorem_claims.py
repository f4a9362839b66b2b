"""What is claimed of the stage lists of `theorem_stages`.

The moments of a stationary estimator are written Q12 = G'Q2, P12 = -Gam'P2 and
Q1 = Q + G'Q2 G, which define G, Gam and Q; V2 and V12 are expressed by V2s and Qs,
so that the inverse of V2s is that of a symbol.

Source: Haddad and Bernstein (1987), theorem 3.1 and section 4.
"""

from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
    named,
)
from .blocks import (
    GAINS,
    P2,
    P12,
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
    R,
    adjoint,
    cost,
    gradients,
    l,
    moment,
    n,
    r,
)

G, Gam = MatrixSymbol("G", r, n), MatrixSymbol("Gam", r, n)
Q, Qs, V2s = (
    MatrixSymbol("Q", n, n),
    MatrixSymbol("Qs", n, l),
    MatrixSymbol("V2s", l, l),
)
MEANT = (
    (Q12, G.T * Q2),
    (P12, -Gam.T * P2),
    (Q1, Q + G.T * Q2 * G),
    (V2, V2s - C * Q * C.T),
    (V12, Qs - A * Q * C.T),
)
ALGEBRA = Algebra((*SYMMETRIC, Q, V2s), MEANT)
PROJECTING = ALGEBRA.with_relations((Gam * G.T, Identity(r)))


def projection_innovation(found):
    f = found.unfolded()
    joint = BlockMatrix(
        [
            [Q, ZeroMatrix(n, n), ZeroMatrix(n, l)],
            [ZeroMatrix(n, n), V1, V12],
            [ZeroMatrix(l, n), V12.T, V2],
        ]
    )
    after = BlockMatrix([[A, Identity(n), ZeroMatrix(n, l)]])
    innovation = BlockMatrix([[C, ZeroMatrix(l, n), Identity(l)]])
    return claims(
        Algebra((*SYMMETRIC, Q)),
        {
            "Qs = E[x+ (y - C x^)']": (f["Qs"], after * joint * innovation.T),
            "V2s = cov(y - C x^)": (f["V2s"], innovation * joint * innovation.T),
        },
    )


def projection_factors(found):
    s, f = named(found), found.unfolded()
    return claims(
        Algebra(SYMMETRIC),
        {
            "G'Q2 = Q12": (f["G"].T * Q2, Q12),
            "Gam'P2 = -P12": (f["Gam"].T * P2, -P12),
            "Q = Q1 - Q12 Q2^-1 Q12'": (f["Q"], Q1 - Q12 * Q2.I * Q12.T),
            "(3.8) tau = G'Gam": (f["tau"], f["G"].T * f["Gam"]),
            "(3.9) GamG = Gam G'": (f["GamG"], f["Gam"] * f["G"].T),
        },
    ) | claims(
        ALGEBRA,
        {
            "Q of the definitions is Q of the theorem": (f["Q"], s["Q"]),
            "G of the definitions is G of the theorem": (f["G"], s["G"]),
            "Gam of the definitions is Gam of the theorem": (f["Gam"], s["Gam"]),
        },
    )


def feedthrough_gain(found):
    f = found.unfolded()
    halves = gradients()
    missed = halves[De].as_expr().xreplace({De: f["De"], Ce: (L - f["De"] * C) * G.T})
    return claims(
        ALGEBRA,
        {
            "(3.13) De V2s = L Q C'": (f["De"] * V2s, L * Q * C.T),
            "(4.11) the gradient in De vanishes with (3.12), (3.13)": (missed, 0),
        },
    )


def projection_gains(found):
    f, halves = found.unfolded(), gradients()
    gains = {X: f[X.name] for X in (Ae, Be, Ce)}
    at = {X: halves[X].as_expr().xreplace(gains) for X in GAINS}
    return claims(
        ALGEBRA,
        {
            "(3.10)' Ae = Gam A G' - Be C G'": (
                f["Ae"],
                Gam * A * G.T - f["Be"] * C * G.T,
            ),
            "(4.8) the gradient in Ae vanishes with (3.10), (3.11)": (at[Ae], 0),
            "(4.9) the gradient in Be vanishes with (3.10), (3.11)": (at[Be], 0),
            "(4.10) the gradient in Ce vanishes with (3.12), for every De": (at[Ce], 0),
            "(3.11) Be V2s = Gam Qs": (f["Be"] * V2s, Gam * Qs),
            "(3.12) Ce = (L - De C) G'": (f["Ce"], (L - De * C) * G.T),
        },
    )


def at_gains(blocks, i, j):
    """A block of (4.6) or (4.7) with the gains (3.10)-(3.12)."""
    K = Qs * V2s.I
    gains = {Ae: Gam * (A - K * C) * G.T, Be: Gam * K, Ce: (L - De * C) * G.T}
    return blocks[i, j].as_expr().xreplace(gains)


def projection_scripts(found):
    f = found.unfolded(keep=())
    ahead, back = moment(), adjoint()
    return claims(
        ALGEBRA,
        {
            "(4.6) block 12 is Qh Gam' = Q12": (
                f["Qh"] * Gam.T - Q12,
                at_gains(ahead, 0, 1) - Q12,
            ),
            "(4.6) block 22 is Gam Qh Gam' = Q2": (
                Gam * f["Qh"] * Gam.T - Q2,
                at_gains(ahead, 1, 1) - Q2,
            ),
            "(4.7) block 12 is -Ph G' = P12": (
                -f["Ph"] * G.T - P12,
                at_gains(back, 0, 1) - P12,
            ),
            "(4.7) block 22 is G Ph G' = P2": (
                G * f["Ph"] * G.T - P2,
                at_gains(back, 1, 1) - P2,
            ),
        },
    )


def projection_equations(found):
    """Stationarity makes every residual vanish; Qh G', G Ph are then known."""
    s = named(found)
    f = found.unfolded(keep=("Aq", "Lq"))
    Qh, Ph, tau, Aq, Lq = (s[k] for k in ("Qh", "Ph", "tau", "Aq", "Lq"))
    stationary = PROJECTING.with_relations(
        (tau, G.T * Gam),
        (Qh * Gam.T, G.T * Q2),  # (4.13)
        (Ph * G.T, Gam.T * P2),  # (4.15)
        (V1, Q1 - A * Q1 * A.T),  # (4.12)
        (Qs * V2s.I * Qs.T, Qh - A * G.T * Q2 * G * A.T),  # script Q
        (Lq.T * R * Lq, Ph - Aq.T * Gam.T * P2 * Gam * Aq),  # script P
        symmetric=[Qh, Ph],
    )
    zero = {
        "riccati": "(3.14) Q = A Q A' + V1 - Qs V2s^-1 Qs' + tau_perp Qh tau_perp'",
        "estimate": "(3.15) Qh = A tau Qh tau' A' + Qs V2s^-1 Qs'",
        "adjoint": "(3.16) Ph = Aq'tau'Ph tau Aq + Lq'R Lq",
        "idempotent": "(3.6) tau^2 = tau",
        "aligned_Q": "(3.17) tau Qh = Qh tau'",
        "aligned_P": "(3.17) Ph tau = tau'Ph",
    }
    whole = {"Aq": A - Qs * V2s.I * C, "Lq": L - De * C}
    return claims(
        stationary, {f"stationary: {zero[k]}": (f[k], 0) for k in zero}
    ) | claims(
        ALGEBRA,
        {f"{k} of the theorem": (found.unfolded()[k], whole[k]) for k in whole}
        | {"(3.6) idempotent = tau^2 - tau": (f["idempotent"], tau * tau - tau)},
    )


def projection_trace(found):
    f = found.unfolded()
    J = cost().as_expr().xreplace({Ce: (L - De * C) * G.T})
    best = ALGEBRA.with_relations((De * V2s, L * Q * C.T))
    silent = {De: ZeroMatrix(*De.shape)}
    return claims(
        best,
        {"(3.18) J = tr (L Q L' - De V2s De') R": (Trace(f["J"]), J)},
    ) | claims(
        ALGEBRA,
        {
            "(3.18) De = 0: J = tr L Q L' R": (
                Trace(f["J"]).xreplace(silent),
                J.xreplace(silent),
            )
        },
    )


def innovations_plant(found):
    """Only V2s = V2 + C Q C' and Qs are used, and that x - x^ is orthogonal to x^."""
    s, f = named(found), found.unfolded()
    Kalman, De0 = s["De"], MatrixSymbol("De0", *De.shape)
    X = MatrixSymbol("X", n, n)  # second moment of x^
    algebra = Algebra((*SYMMETRIC, Q, V2s, X), (*MEANT[3:], (Q1, Q + X)))
    here = {V1: f["V1i"], V12: Qs, V2: V2s, Q1: X, L: f["Lq"]}
    ahead, on_it = moment(), {De: De0 - Kalman}
    J, Ji = (
        cost().as_expr().xreplace({De: De0}),
        cost().as_expr().xreplace(here | on_it),
    )
    best = algebra.with_relations((Kalman * V2s, L * Q * C.T))
    silent = {Kalman: ZeroMatrix(*De.shape)}
    least = Trace((L * Q * L.T - Kalman * V2s * Kalman.T) * R)
    names = {(0, 1): "Q12", (1, 1): "Q2"}
    return claims(
        algebra,
        {
            f"the equation of {name} is the same on both plants": (
                ahead[i, j].as_expr().xreplace(here),
                ahead[i, j].as_expr(),
            )
            for (i, j), name in names.items()
        }
        | {
            "without feedthrough: J - J_Kalman is the cost on this plant": (
                (J - least - Ji).xreplace(silent | {De0: ZeroMatrix(*De.shape)}),
                0,
            ),
            "x^ and the plant: V1 - V1i is what (3.14) with tau = I gives": (
                (A * Q1 * A.T + V1 - Q1).xreplace({Q1: Q + X})
                - (A * X * A.T + f["V1i"] - X),
                A * Q * A.T + V1 - Qs * V2s.I * Qs.T - Q,
            ),
        },
    ) | claims(
        best,
        {
            "with feedthrough: J - J_Kalman is the cost on this plant": (
                J - least - Ji,
                0,
            )
        },
    )
