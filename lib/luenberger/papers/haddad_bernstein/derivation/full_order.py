"""The fixed-order filter of full order: corollary 3.1 and the Kalman filter.

With n_e = n the projection is the identity, and G = Gam = I in a basis of one's
choice.  (3.25) and (3.26) look coupled; but their sum is the plant's own Lyapunov
equation, so Q + Qh is known beforehand, and (3.25) is then the Riccati equation of
the equivalent plant.  The filter is Kalman's, with or without its measurement
update.

Source: Haddad and Bernstein (1987), corollary 3.1 and remark 3.6; the decoupling is
our own.
"""

from functools import cache

from sympy import Trace

from ....symbolic import Algebra, Derivation, Identity, MatrixSymbol, ZeroMatrix, claims
from . import stationarity
from .augmented import PAIRS, V1, V2, V12, A, Ae, Be, C, Ce, De, L, R, l, n, r
from .stationarity import BEST, G, Gam, Q, Qs, V2s, noise, theorem

one = Identity(n)
Qh = MatrixSymbol("Qh", n, n)
Q1 = MatrixSymbol("Q1", n, n)  # Q + Qh: the second moment of x
xh, y = MatrixSymbol("xhat", n, 1), MatrixSymbol("y", l, 1)
K = Qs * V2s.I
MEANT = (
    (V2, V2s - C * Q * C.T - noise(Q + Qh, 1, 1)),
    (V12, Qs - A * Q * C.T - noise(Q + Qh, 0, 1)),
)
ALGEBRA = Algebra([V1, V2, R, Q, Qh, Q1, V2s], MEANT)


def full(value):
    """A formula of the theorem with n_e = n and G = Gam = I."""
    value = value.subs(r, n)
    return value.xreplace({X.subs(r, n): one for X in (G, Gam)})


def formulas():
    """Corollary 3.1; (3.25) and (3.26) are right sides."""
    return {
        "(3.21) Ae": A - K * C,
        "(3.22) Be": K,
        "(3.23) Ce": L - De * C,
        "(3.24) De": L * Q * C.T * V2s.I,
        "(3.25) Q": A * Q * A.T + noise(Q + Qh, 0, 0) + V1 - K * Qs.T,
        "(3.26) Qh": A * Qh * A.T + K * Qs.T,
        "(3.27) J": Trace((L * Q * L.T - De * V2s * De.T) * R),
    }


def corollary():
    """(3.21)-(3.27) are (3.10)-(3.18) with tau = I."""
    f, said = formulas(), theorem(one, Qh, MatrixSymbol("Ph", n, n))
    shared = stationarity.formulas()
    gains = zip(("(3.21) Ae", "(3.22) Be", "(3.23) Ce"), (Ae, Be, Ce))
    return {
        f"{key} is that of the theorem with G = Gam = I": (f[key], full(BEST[X]))
        for key, X in gains
    } | {
        "(3.24) De is (3.13)": (f["(3.24) De"], shared["(3.13) De"]),
        "(3.25) is (3.14) with tau = I": (f["(3.25) Q"] - Q, said["(3.14)"]),
        "(3.26) is (3.15) with tau = I": (f["(3.26) Qh"] - Qh, said["(3.15)"]),
        "(3.27) is (3.18)": (f["(3.27) J"], shared["(3.18) J"]),
    }


def decoupling():
    """Q + Qh does not depend on the filter, and then (3.25) is a Riccati equation."""
    f = formulas()
    both = f["(3.25) Q"] + f["(3.26) Qh"]
    riccati = A * Q * A.T - K * Qs.T
    equivalent = V1 + noise(Q1, 0, 0)
    known = Algebra([V1, V2, R, Q, Q1, V2s], [(Qh, Q1 - Q)])
    plain = {X: ZeroMatrix(*X.shape) for pair in PAIRS for X in pair}
    return (
        claims(
            ALGEBRA,
            {
                "(3.25) + (3.26): Q + Qh = A (Q + Qh) A' + sum + V1, the plant's own": (
                    both,
                    A * (Q + Qh) * A.T + noise(Q + Qh, 0, 0) + V1,
                ),
                "(3.24) and (3.23): y_e = L (x^ + Q C'V2s^-1 (y - C x^)), the update": (
                    (L - f["(3.24) De"] * C) * xh + f["(3.24) De"] * y,
                    L * (xh + Q * C.T * V2s.I * (y - C * xh)),
                ),
                "(3.27) is the trace of L (Q - Q C'V2s^-1 C Q) L'R, after the update": (
                    f["(3.27) J"].xreplace({De: f["(3.24) De"]}),
                    Trace(L * (Q - Q * C.T * V2s.I * C * Q) * L.T * R),
                ),
                "(3.21),(3.22) x^_+ = A x^ + K (y - C x^), the predictor": (
                    f["(3.21) Ae"] * xh + f["(3.22) Be"] * y,
                    A * xh + K * (y - C * xh),
                ),
            },
        )
        | claims(
            known,
            {
                "(3.25) with Q + Qh = Q1: Kalman's, V1 + sum A_i Q1 A_i' for V1": (
                    f["(3.25) Q"],
                    riccati + equivalent,
                )
            },
        )
        | claims(
            Algebra([V1, V2, R, Q, V2s]),
            {
                "(3.25), remark 3.6: with A_i = C_i = 0 Kalman's equation, no Qh": (
                    f["(3.25) Q"].xreplace(plain),
                    riccati + V1,
                )
            },
        )
    )


@cache
def derive():
    return Derivation(
        given=(A, C, V1, V12, V2, L, R),
        formulas=formulas(),
        steps=claims(ALGEBRA, corollary()) | decoupling(),
        source="Haddad and Bernstein (1987), (3.21)-(3.27)",
    )
