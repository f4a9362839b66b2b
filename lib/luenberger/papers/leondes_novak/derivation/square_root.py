"""The filter's recursions with covariances as factors, Sigma = H H'.

A covariance that is singular is carried as H: A Sigma A' + Q is then [A H, G] times
its transpose, with G G' = Q, and (I - K C) Omega (I - K C)' + K R K' is that of
[(I - K C) H_minus, K V], with V V' = R.  Nothing is subtracted, so no product is ever
indefinite, and rounding of eps in H is eps^2 in Sigma.  Orthogonal rows between the
factors, H U U' H', bring the number of columns back to n.

Where M = Z Z' is singular, Z = [C H_minus, V], its singular values take the place of
the solve, and those that are rounding are left out.

Source: our own; the recursions are Leondes and Novak's (1974), (11), (26), (27), (33).
"""

from dataclasses import replace
from functools import cache

import sympy as sp
from sympy import Identity, MatrixSymbol, ZeroMatrix

from ....symbolic import Algebra, Derivation, Solve, Stage, claims, matrices, named
from .correlated_noise import decorrelation, error_recursion
from .letters import n, p, r, squares
from .quadratic import joseph

k, q, d = sp.symbols("k q d", integer=True, nonnegative=True)
SOURCE = "our own"


@cache
def root_gain():
    """H_minus to the gain of least trace, where M is positive definite."""
    (C,), (H_minus,), (L,) = (
        matrices("C", p, n),
        matrices("H_minus", n, k),
        matrices("L", p, k),
    )
    R, M = squares("R M", p)
    (Kmv,) = matrices("Kmv", n, p)
    stages = (
        Stage(L, C * H_minus),
        Stage(M, L * L.T + R, "(33)", symmetric=True),
        Stage(Kmv, Solve(H_minus * L.T, M), "(33)"),
    )
    found = Derivation((C, R, H_minus), stages, source=SOURCE)
    return replace(found, steps=_is_the_gain(found) | _is_a_gain_of_singular_M())


def _is_the_gain(derivation):
    s, f = named(derivation), derivation.unfolded()
    inner = derivation.unfolded(keep=("M",))
    C, R, M, H_minus = (s[name] for name in ("C", "R", "M", "H_minus"))
    A, Sigma, Omega, Q = squares("A Sigma Omega Q")
    H, G = MatrixSymbol("H", n, d), MatrixSymbol("G", n, q)
    factored = Algebra([R, M, Omega], [(H_minus * H_minus.T, Omega)])
    ahead = Algebra([Q, Sigma], [(H * H.T, Sigma), (G * G.T, Q)])
    return claims(
        factored,
        {
            "(33) M = C Omega C' + R": (f["M"], C * Omega * C.T + R),
            "(33) Kmv M = Omega C'": (inner["Kmv"] * M, Omega * C.T),
        },
    ) | claims(
        ahead,
        {
            "(44) [A H, G] [A H, G]' = A Sigma A' + Q": (
                (A * H) * (A * H).T + G * G.T,
                A * Sigma * A.T + Q,
            )
        },
    )


def _is_a_gain_of_singular_M():
    """Kmv = Hx T D^-1 U' W^-1 with Z = W U D T' satisfies Kmv M = Hx Z'."""
    Z, Hx = MatrixSymbol("Z", p, k), MatrixSymbol("Hx", n, k)
    U, T = MatrixSymbol("U", p, r), MatrixSymbol("T", k, r)
    D, W = MatrixSymbol("D", r, r), MatrixSymbol("W", p, p)
    algebra = Algebra(
        [D, W],
        [(Z, W * U * D * T.T), (T.T * T, Identity(r)), (U.T * U, Identity(r))],
    )
    return claims(
        algebra,
        {
            "(33) M singular, Z = W U D T': Kmv M = Hx Z', M = Z Z'": (
                Hx * T * D.I * U.T * W.I * Z * Z.T,
                Hx * Z.T,
            )
        },
    )


@cache
def root_update():
    """H_minus and Kmv to the factor [kept, drawn] of Sigma_next, for any gain."""
    (C,), (H_minus,), (V,) = (
        matrices("C", p, n),
        matrices("H_minus", n, k),
        matrices("V", p, q),
    )
    Gamma, Kmv, K = matrices("Gamma Kmv K", n, p)
    (Y,), (kept,), (drawn,) = (
        squares("Y"),
        matrices("kept", n, k),
        matrices("drawn", n, q),
    )
    stages = (
        Stage(K, Kmv + Gamma - Gamma * (C * Kmv)),
        Stage(Y, Identity(n) - K * C, "(13)"),
        Stage(kept, Y * H_minus),
        Stage(drawn, K * V),
    )
    found = Derivation((C, V, Gamma, Kmv, H_minus), stages, source=SOURCE)
    return replace(found, steps=_is_the_covariance(found))


def _is_the_covariance(derivation):
    s, f = named(derivation), derivation.unfolded(keep=("K",))
    C, V, H_minus, K = (s[name] for name in ("C", "V", "H_minus", "K"))
    (R,), (Omega,) = squares("R", p), squares("Omega")
    U, H = MatrixSymbol("U", k, d), MatrixSymbol("H", n, d)
    algebra = Algebra([R, Omega], [(H_minus * H_minus.T, Omega), (V * V.T, R)])
    turned = Algebra([], [(U.T * U, Identity(d))])
    whole, Gamma, Kmv = derivation.unfolded(), s["Gamma"], s["Kmv"]
    return claims(
        algebra,
        {
            "(27) kept kept' + drawn drawn' = Y Omega Y' + K R K', any K": (
                f["kept"] * f["kept"].T + f["drawn"] * f["drawn"].T,
                joseph(K, C, Omega, R),
            ),
            "K = Kmv + Gamma - Gamma C Kmv": (
                whole["K"],
                Kmv + Gamma - Gamma * C * Kmv,
            ),
            "(13) Y = I - K C": (f["Y"], Identity(n) - K * C),
        },
    ) | claims(
        turned,
        {"orthogonal rows change no covariance: H U' U H' = H H'": (
            (H * U.T) * (H * U.T).T, H * H.T,
        )},
    )  # fmt: skip


@cache
def root_error():
    """A factor H of cov(eps) one step on, and of the error itself: (11), (26).

    Nw and Nv are the rows of a factor of [[Q, S], [S', R]].
    """
    (F,), (D,) = matrices("F", r, r), matrices("D", r, p)
    (T_next,), (P,), (V,) = (
        matrices("T_next", r, n),
        matrices("P", n, r),
        matrices("V", n, p),
    )
    (Nw,), (Nv,), (H,) = matrices("Nw", n, q), matrices("Nv", p, q), matrices("H", r, k)
    moved, shown = matrices("moved", r, k)[0], matrices("shown", n, k)[0]
    drive, drawn = matrices("drive", r, q)[0], matrices("drawn", n, q)[0]
    stages = (
        Stage(moved, F * H, "(11)"),
        Stage(drive, D * Nv - T_next * Nw, "(11)"),
        Stage(shown, P * H, "(26)"),
        Stage(drawn, V * Nv, "(26)"),
    )
    found = Derivation((F, D, T_next, P, V, Nw, Nv, H), stages, source=SOURCE)
    return replace(found, steps=_is_the_error(found))


def _is_the_error(derivation):
    s, f = named(derivation), derivation.unfolded()
    old = error_recursion()
    Q, S, R, X = (named(old)[name] for name in "QSRX")
    H, Nw, Nv = (s[name] for name in ("H", "Nw", "Nv"))
    algebra = Algebra(
        [Q, R, X],
        [
            (H * H.T, X),
            (Nw * Nw.T, Q),
            (Nv * Nv.T, R),
            (Nw * Nv.T, S),
            (Nv * Nw.T, S.T),
        ],
    )
    wanted = old.unfolded()
    return claims(
        algebra,
        {
            "(11) moved moved' + drive drive' = X_next": (
                f["moved"] * f["moved"].T + f["drive"] * f["drive"].T,
                wanted["X_next"],
            ),
            "(26) shown shown' + drawn drawn' = Sigma": (
                f["shown"] * f["shown"].T + f["drawn"] * f["drawn"].T,
                wanted["Sigma"],
            ),
        },
    )


@cache
def root_decorrelation():
    """A factor G of Qs, from the rows Nw, Nv of one of [[Q, S], [S', R]]."""
    (Nw,), (Nv,), (J,) = matrices("Nw", n, q), matrices("Nv", p, q), matrices("J", n, p)
    (G,) = matrices("G", n, q)
    found = Derivation((Nw, Nv, J), (Stage(G, Nw - J * Nv),), source=SOURCE)
    return replace(found, steps=_is_the_noise(found) | _which_J())


def _is_the_noise(derivation):
    s, f, old = named(derivation), derivation.unfolded(), decorrelation()
    Q, S, J = (named(old)[name] for name in "QSJ")
    R, Nw, Nv = MatrixSymbol("R", p, p), s["Nw"], s["Nv"]
    algebra = Algebra(
        [Q, R],
        [
            (Nw * Nw.T, Q),
            (Nv * Nv.T, R),
            (Nw * Nv.T, S),
            (Nv * Nw.T, S.T),
            (S, J * R),
        ],
    )
    return claims(algebra, {"G G' = Qs": (f["G"] * f["G"].T, old.unfolded()["Qs"])})


def _which_J():
    """R singular, b'R = 0: J + Z b' is as good a J, and tells the filter b'rho too."""
    (C,), (R, M), (Omega,) = matrices("C", p, n), squares("R M", p), squares("Omega")
    J, S, Gamma = matrices("J S Gamma", n, p)
    b, Z = MatrixSymbol("b", p, q), MatrixSymbol("Z", n, q)
    Kmv = Omega * C.T * M.I
    K = Kmv + Gamma - Gamma * C * Kmv
    free = Algebra([R], [(S, J * R), (b.T * R, ZeroMatrix(q, p))])
    blind = Algebra([M, Omega], [(b.T * C * Omega * C.T, b.T * M)])  # b'(M - R)
    return claims(
        free, {"R singular: (J + Z b') R = S where b'R = 0": ((J + Z * b.T) * R, S)}
    ) | claims(
        blind,
        {
            "R singular: b'(I - C K) M = -b'C Gamma R, b'rho is zero if that is": (
                b.T * (Identity(p) - C * K) * M,
                -b.T * C * Gamma * (M - C * Omega * C.T),
            )
        },
    )
