"""Matrix identities that must be proved, and false ones that must be refuted.

Each entry is (left, right, given, symmetric); the last two may be left out.
"""

import sympy as sp
from sympy import Rational, Trace

from matrixproof import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix

n, m, k = sp.symbols("n m k", integer=True, positive=True)
s, t = sp.symbols("s t", positive=True)
In, Im, Ik = Identity(n), Identity(m), Identity(k)


def square(names, size=n):
    return [MatrixSymbol(name, size, size) for name in names.split()]


A, B, C, X, Y, Z, P, Q, N = square("A B C X Y Z P Q N")
D, S, R, W = square("D S R W", m)
U, F, L = (MatrixSymbol(name, n, m) for name in "UFL")
V, H, G = (MatrixSymbol(name, m, n) for name in "VHG")
J = MatrixSymbol("J", m, k)
u, v = MatrixSymbol("u", n, 1), MatrixSymbol("v", n, 1)
ZERO, ONE = ZeroMatrix(n, n), Identity(1)


def penrose(A, X):
    """X is the Moore-Penrose inverse of A."""
    return [(A * X * A, A), (X * A * X, X), ((A * X).T, A * X), ((X * A).T, X * A)]


INVERSES = {
    "push-through": ((In + U * V).I * U, U * (Im + V * U).I),
    "push-through, minus": ((s * In - U * V).I * U, U * (s * Im - V * U).I),
    "push-through, both sides": (V * (In + U * V).I, (Im + V * U).I * V),
    "inverse of I + U V": ((In + U * V).I, In - U * (Im + V * U).I * V),
    "what is left of I": (In - (In + A).I, A * (In + A).I),
    "Woodbury": ((A + U * D * V).I, A.I - A.I * U * (D.I + V * A.I * U).I * V * A.I),
    "Woodbury without D^-1": (
        (A + U * D * V).I,
        A.I - A.I * U * (Im + D * V * A.I * U).I * D * V * A.I,
    ),
    "Woodbury without A^-1": (
        (In + A * U * D * V).I * A,
        A - A * U * (Im + D * V * A * U).I * D * V * A,
    ),
    "Sherman-Morrison": (
        (A + u * v.T).I,
        A.I - A.I * u * (ONE + v.T * A.I * u).I * v.T * A.I,
    ),
    "Sherman-Morrison with a scalar": (
        (A + u * v.T).I,
        A.I - A.I * u * v.T * A.I / (1 + s),
        [(v.T * A.I * u, s * ONE)],
    ),
    "Henderson-Searle": (
        (A + U * D * V).I * U * D,
        A.I * U * (Im + D * V * A.I * U).I * D,
    ),
    "Henderson-Searle with D^-1": (
        (A + U * D * V).I * U * D,
        A.I * U * (D.I + V * A.I * U).I,
    ),
    "parallel sum commutes": (A * (A + B).I * B, B * (A + B).I * A),
    "parallel sum": (A * (A + B).I * B, (A.I + B.I).I),
    "parallel sum as a difference": (A - A * (A + B).I * A, A * (A + B).I * B),
    "sum of inverses": (A.I + B.I, A.I * (A + B) * B.I),
    "difference of inverses": (A.I - B.I, A.I * (B - A) * B.I),
    "inverse of a product": (
        X,
        B.I * A.I,
        [(X * A * B, In), (A * B * X, In)],
    ),
    "left and right inverse": (U, F, [(V * F, Im), (V * U, Im), (F * V, In)]),
    "AB = I, CA = I": (B, C, [(A * B, In), (C * A, In)]),
    "resolvents": (
        (s * In - A).I - (t * In - A).I,
        (t - s) * (s * In - A).I * (t * In - A).I,
    ),
    "resolvents commute": (
        (s * In - A).I * (t * In - A).I,
        (t * In - A).I * (s * In - A).I,
    ),
    "resolvent and matrix": (A * (s * In - A).I, (s * In - A).I * A),
    "second resolvent identity": (
        (s * In - A).I - (s * In - B).I,
        (s * In - A).I * (A - B) * (s * In - B).I,
    ),
    "Cayley transform": ((In - A) * (In + A).I, (In + A).I * (In - A)),
    "Cayley transform is orthogonal": (
        ((In - A) * (In + A).I).T * (In - A) * (In + A).I,
        In,
        [(A.T, -A)],
    ),
    "transpose of an inverse": ((In + A.T * B.T).I, ((In + B * A).I).T),
    "geometric sum": ((In - A).I, In + A + A**2 + A**3 * (In - A).I),
}

FINITE = {
    "square: AB = I, BA = I": (B * A, In, [(A * B, In)]),
    "square: AB = A + B commute": (A * B, B * A, [(A * B, A + B)]),
    "square: three factors": (C * A * B, In, [(A * B * C, In)]),
    "square: scaled": (B * A, 3 * In, [(A * B, 3 * In)]),
    "orthogonal on both sides": (A * A.T, In, [(A.T * A, In)]),
    "1 x 1: transposes": (u.T * A * v, v.T * A.T * u),
    "1 x 1: numbers commute": (u * v.T * A * u * u.T * v, u * u.T * v * v.T * A * u),
    "1 x 1: symmetric form": (u.T * P * v, v.T * P * u, [], [P]),
    "Householder": ((In - 2 * u * u.T) ** 2, In, [(u.T * u, ONE)]),
}

PROJECTIONS = {
    "complement of an idempotent": ((In - P) ** 2, In - P, [(P * P, P)]),
    "product of idempotents": (
        (P * Q) ** 2,
        P * Q,
        [(P * P, P), (Q * Q, Q), (P * Q, Q * P)],
    ),
    "sum of idempotents": (
        P * Q,
        ZERO,
        [(P * P, P), (Q * Q, Q), ((P + Q) * (P + Q), P + Q)],
    ),
    "inverse of I + P": ((In + P).I, In - P / 2, [(P * P, P)]),
    "reflection": ((In - 2 * P) ** 2, In, [(P * P, P)]),
    "involution": (((In + A) / 2) ** 2, (In + A) / 2, [(A * A, In)]),
    "nilpotent": ((In - N).I, In + N + N**2, [(N**3, ZERO)]),
    "nilpotents that commute": (
        (A + B) ** 3,
        ZERO,
        [(A * A, ZERO), (B * B, ZERO), (A * B, B * A)],
    ),
    "oblique projection": ((U * V) ** 2, U * V, [(V * U, Im)]),
    "oblique projection, explicit": (
        (U * (V * U).I * V) ** 2,
        U * (V * U).I * V,
    ),
    "equal ranges": (P * Q, Q, [(P, U * V), (Q, U * G), (V * U, Im), (G * U, Im)]),
}

whole = BlockMatrix([[A, U], [V, D]])
schur, other = D - V * A.I * U, A - U * D.I * V
by_schur = BlockMatrix(
    [
        [A.I + A.I * U * schur.I * V * A.I, -A.I * U * schur.I],
        [-schur.I * V * A.I, schur.I],
    ]
)
by_other = BlockMatrix(
    [
        [other.I, -other.I * U * D.I],
        [-D.I * V * other.I, D.I + D.I * V * other.I * U * D.I],
    ]
)
Onm, Omn = ZeroMatrix(n, m), ZeroMatrix(m, n)

BLOCKS = {
    "block inverse": (whole * by_schur, Identity(n + m)),
    "block inverse, from the left": (by_schur * whole, Identity(n + m)),
    "block inverse, other complement": (whole * by_other, Identity(n + m)),
    "both complements": (by_schur, by_other),
    "block factors": (
        whole,
        BlockMatrix([[In, Onm], [V * A.I, Im]])
        * BlockMatrix([[A, Onm], [Omn, schur]])
        * BlockMatrix([[In, A.I * U], [Omn, Im]]),
    ),
    "block triangular inverse": (
        BlockMatrix([[A, U], [Omn, D]])
        * BlockMatrix([[A.I, -A.I * U * D.I], [Omn, D.I]]),
        Identity(n + m),
    ),
    "Sylvester makes blocks diagonal": (
        BlockMatrix([[A, F], [Omn, D]]) * BlockMatrix([[In, U], [Omn, Im]]),
        BlockMatrix([[In, U], [Omn, Im]]) * BlockMatrix([[A, Onm], [Omn, D]]),
        [(U * D - A * U, F)],
    ),
}

innovation = H * P * H.T + R
gain = P * H.T * innovation.I
after = (P.I + H.T * R.I * H).I
K = MatrixSymbol("K", n, m)

FILTER = {
    "information form": (after, P - gain * H * P, [], [P, R]),
    "gain of the information form": (after * H.T * R.I, gain, [], [P, R]),
    "Joseph form": (
        (In - gain * H) * P * (In - gain * H).T + gain * R * gain.T,
        (In - gain * H) * P,
        [],
        [P, R],
    ),
    "completed square": (
        (In - K * H) * P * (In - K * H).T + K * R * K.T,
        P - L * S * L.T + (K - L) * S * (K - L).T,
        [(S, innovation), (L * S, P * H.T)],
        [P, R, S],
    ),
    "residual": (Im - H * gain, R * innovation.I, [], [P, R]),
    "inverse innovation": (
        innovation.I,
        R.I - R.I * H * after * H.T * R.I,
        [],
        [P, R],
    ),
    "Riccati, two forms": (
        A * (P - gain * H * P) * A.T,
        A * P * (In + H.T * R.I * H * P).I * A.T,
        [],
        [P, R],
    ),
    "Riccati step is symmetric": (
        P * (In + Q * P).I,
        (In + P * Q).I * P,
        [],
        [P, Q],
    ),
    "Riccati step equals its transpose": (
        (A * P * (In + Q * P).I * A.T).T,
        A * P * (In + Q * P).I * A.T,
        [],
        [P, Q],
    ),
    "whitening": (W.I * S * W.T.I, Im, [(S, W * W.T)], [S]),
    "observer error": (
        Z * (A * X + B) - (Y * Z * X + Q * X + Z * B),
        ZERO,
        [(Z * A - Y * Z, Q)],
    ),
}

Ad, Ae = MatrixSymbol("A+", m, n), MatrixSymbol("A++", n, m)
AtA, AAt = MatrixSymbol("(A'A)+", m, m), MatrixSymbol("(AA')+", n, n)
Bd = MatrixSymbol("B+", k, m)

PSEUDO = {
    "pseudo-inverse is unique": (V, G, penrose(U, V) + penrose(U, G)),
    "U'U U+ = U'": (U.T * U * Ad, U.T, penrose(U, Ad)),
    "pseudo-inverse twice": (Ae, U, penrose(U, Ad) + penrose(Ad, Ae)),
    "pseudo-inverse of the transpose": (Ae, Ad.T, penrose(U, Ad) + penrose(U.T, Ae)),
    "U+ = (U'U)+ U'": (Ad, AtA * U.T, penrose(U, Ad) + penrose(U.T * U, AtA)),
    "U+ = U' (UU')+": (Ad, U.T * AAt, penrose(U, Ad) + penrose(U * U.T, AAt)),
    "(U'U)+ = U+ U+'": (AtA, Ad * Ad.T, penrose(U, Ad) + penrose(U.T * U, AtA)),
    "U (U'U)+ U'U = U": (U * AtA * U.T * U, U, penrose(U, Ad) + penrose(U.T * U, AtA)),
    "U U+ is a projection": ((U * Ad) ** 2, U * Ad, penrose(U, Ad)),
    "full column rank": (Ad, (U.T * U).I * U.T, penrose(U, Ad)),
    "full row rank": (MatrixSymbol("V+", n, m), V.T * (V * V.T).I,
                      penrose(V, MatrixSymbol("V+", n, m))),
    "of an orthogonal projection": (X, P, [*penrose(P, X), (P * P, P)], [P]),
    "reverse order, full ranks": (
        MatrixSymbol("(UJ)+", k, n),
        Bd * Ad,
        [
            *penrose(U, Ad),
            *penrose(J, Bd),
            *penrose(U * J, MatrixSymbol("(UJ)+", k, n)),
            (Ad * U, Im),
            (J * Bd, Im),
        ],
    ),
    "normal equations": (U.T * U * (Ad * u), U.T * u, penrose(U, Ad)),
    "of a symmetric matrix commutes": (P * X, X * P, penrose(P, X), [P]),
}  # fmt: skip

Gam, Gh = MatrixSymbol("Gamma", m, n), MatrixSymbol("G_h", m, n)
Q2, Ph = MatrixSymbol("Q_2", m, m), MatrixSymbol("Q_hat", n, n)
MOMENT = [(Gh.T * Q2, Ph * Gam.T), (Gam * Ph * Gam.T, Q2)]
tau = Gh.T * Gam

OBSERVERS = {
    "(3.9) Gamma G' = I": (Gam * Gh.T * Q2, Q2, MOMENT, [Q2, Ph]),
    "(3.9) with Q2 invertible": (
        Gam * Gh.T,
        Im,
        [*MOMENT, (Q2 * S, Im), (S * Q2, Im)],
        [Q2, Ph],
    ),
    "(3.6) tau is a projection": (
        tau * tau,
        tau,
        [*MOMENT, (Q2 * S, Im), (S * Q2, Im)],
        [Q2, Ph],
    ),
    "(3.15) projected moment": (tau * Ph * tau.T, Gh.T * Q2 * Gh, MOMENT, [Q2, Ph]),
    "Krein: adjoint equations": (
        Trace(Q * X),
        Trace(Y * B),
        [(A * X + X * A.T + B, ZERO), (A.T * Y + Y * A + Q, ZERO)],
        [X, Y, B, Q],
    ),
    "AX = XB, squares": (A**2 * U, U * D**2, [(A * U, U * D)]),
    "AX = XB, resolvents": (
        (s * In - A).I * U,
        U * (s * Im - D).I,
        [(A * U, U * D)],
    ),
    "AX = XB, similar": (X.I * A * X, B, [(A * X, X * B)]),
    "Lyapunov, symmetric difference": (
        (X - X.T) - A * (X - X.T) * A.T,
        ZERO,
        [(X, A * X * A.T + Q)],
        [Q],
    ),
    "change of coordinates": (
        X.I * (s * In - A).I * X,
        (s * In - X.I * A * X).I,
    ),
}

TRACES = {
    "trace is cyclic": (Trace(A * B * C), Trace(C * A * B)),
    "trace of a transpose": (Trace(U.T * F), Trace(F.T * U)),
    "trace of a similar matrix": (Trace(X.I * A * X), Trace(A)),
    "symmetric part": (Trace(P * A), Trace(P * (A + A.T)) / 2, [], [P]),
    "symmetric times skew": (Trace(P * A), 0, [(A.T, -A)], [P]),
    "commutator": (Trace((A * B - B * A) * A), 0),
    "trace of a projection": (Trace(U * V), m, [(V * U, Im)]),
    "traces of two inverses": (Trace((In + U * V).I), Trace((Im + V * U).I) + n - m),
    "trace of U U+": (Trace(U * Ad), Trace(Ad * U * Ad * U), penrose(U, Ad)),
    "cost of a gain": (
        Trace((K - L) * S * (K - L).T),
        Trace(K * S * K.T) - 2 * Trace(P * H.T * K.T) + Trace(L * S * L.T),
        [(L * S, P * H.T)],
        [P, S],
    ),
    "adjoint of Lyapunov": (
        Trace(P * C),
        Trace(X * B),
        [(X, A * X * A.T + C), (P, A.T * P * A + B)],
    ),
    "scaled": (Trace(s * A - A * s) + Rational(1, 2) * Trace(2 * A), Trace(A)),
}

TRUE = {
    **INVERSES, **FINITE, **PROJECTIONS, **BLOCKS, **FILTER, **PSEUDO, **OBSERVERS,
    **TRACES
}  # fmt: skip

FALSE = {
    "inverse of a sum": ((A + B).I, A.I + B.I),
    "inverse of a product, wrong order": ((In + A) * X, In, [(X, A.I), (A * B, In)]),
    "products commute": (A * B, B * A),
    "push-through, wrong factor": ((In + A * B).I * A, A * (In + A * B).I),
    "Woodbury, wrong sign": (
        (A + U * D * V).I,
        A.I + A.I * U * (D.I + V * A.I * U).I * V * A.I,
    ),
    "Sherman-Morrison, one missing": ((A + u * v.T).I, A.I - A.I * u * v.T * A.I),
    "parallel sum, wrong": (A * (A + B).I * B, (A + B).I),
    "idempotent is invertible": (P, In, [(P * P, P)]),
    "sum of idempotents is idempotent": (
        (P + Q) ** 2,
        P + Q,
        [(P * P, P), (Q * Q, Q)],
    ),
    "product of projections": ((P * Q) ** 2, P * Q, [(P * P, P), (Q * Q, Q)], [P, Q]),
    "nilpotent is zero": (N, ZERO, [(N * N, ZERO)]),
    "nilpotents that do not commute": (
        (A + B) ** 3,
        ZERO,
        [(A * A, ZERO), (B * B, ZERO)],
    ),
    "one inner inverse": (V, G, [(U * V * U, U), (U * G * U, U)]),
    "reverse order without ranks": (
        Z,
        Y * X,
        [*penrose(A, X), *penrose(B, Y), *penrose(A * B, Z)],
    ),
    "short form with any gain": (
        (In - K * H) * P * (In - K * H).T + K * R * K.T,
        (In - K * H) * P,
        [],
        [P, R],
    ),
    "short form is symmetric": ((In - K * H) * P, P * (In - K * H).T, [], [P]),
    "both sides of an oblique projection": (U * V, In, [(V * U, Im)]),
    "AB = 0, BA = 0": (B * A, ZERO, [(A * B, ZERO)]),
    "1 x 1: another form": (u.T * A * v, v.T * A * u),
    "AX = XB, equal": (A, B, [(A * X, X * B)]),
    "square root is unique": (A, B, [(A * A, B * B)]),
    "trace is multiplicative in order": (Trace(A * B * C), Trace(A * C * B)),
    "trace of a square": (Trace(A * A), Trace(A * A.T)),
    "trace of two inverses, sizes forgotten": (
        Trace((In + U * V).I),
        Trace((Im + V * U).I),
    ),
    "Cayley transform of any matrix": (
        ((In - A) * (In + A).I).T * (In - A) * (In + A).I,
        In,
    ),
}


def parts(entry):
    """(left, right, given, symmetric) of an entry."""
    return (*entry, *((), ())[: 4 - len(entry)])
