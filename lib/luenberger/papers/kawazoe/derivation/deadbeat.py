"""The deadbeat observer: Van Dooren's recursion with every pole at zero.

Sorted by level, Kawazoe's coordinates are a staircase: the stairs hold the units of
(11).  Row block i of T A - F T = D C is then solved column by column with zero
diagonal blocks in F, and F is nothing but the subdiagonal of A: F^(p_M - 1) = 0.
The entries of T and D are polynomials in phi, so nothing is ever divided.

Source: Van Dooren (1984), (13)-(20); Kawazoe (1978), (11)-(14).
"""

from functools import cache

import sympy as sp
from sympy import Matrix

from ....certificate import residuals
from ....symbolic import Claim, Derivation
from .form import starts, structure


def by_level(indices):
    """Numbers of the coordinates, highest power of A first, and who has each level."""
    v, samples = starts(indices), max(indices)
    has = [
        [i for i, size in enumerate(indices) if size > k]
        for k in reversed(range(samples))
    ]
    order = [v[i] + samples - 1 - k for k, own in enumerate(has) for i in own]
    return order, has


def stairs(indices):
    """A and C in staircase coordinates, and left inverses of the stairs."""
    Phi, H = structure(indices)
    order, has = by_level(indices)
    A = Phi.extract(order, order)
    C = H.extract(list(range(len(indices))), order)
    units = [
        Matrix([[int(i == j) for j in below] for i in above])
        for above, below in zip(has, has[1:])
    ]
    return A, C, [len(own) for own in has], units


def recursion(A, sizes, units):
    """T, F and the last columns D, row block by row block."""
    at = [sum(sizes[:i]) for i in range(len(sizes) + 1)]
    last, order = len(sizes) - 1, at[-2]
    T, F = sp.zeros(order, at[-1]), sp.zeros(order)
    D = sp.zeros(order, sizes[-1])
    for i in range(last):
        me = slice(at[i], at[i + 1])
        T[me, me] = sp.eye(sizes[i])
        drive = sp.zeros(sizes[i], at[-1])
        if i:
            above = slice(at[i - 1], at[i])
            F[me, above] = A[me, above]
            drive = A[me, above] * T[above, :]
        for c in range(i, last + 1):
            here = slice(at[c], at[c + 1])
            known = slice(at[i], at[c + 1])
            rest = (drive[:, here] - T[me, known] * A[known, here]).expand()
            if c == last:
                D[me, :] = -rest
            else:
                T[me, at[c + 1] : at[c + 2]] = rest * units[c]
    return T, F, D


def van_dooren_rows(A, C, T, F, D):
    """[f_i' t_i' d_i'] M_i + af_i' of (18), (20) with f_ii = 0, all rows stacked."""
    n, rows = A.shape[0], []
    for i in range(T.shape[0]):
        M = Matrix.vstack(-T[:i, :], A[i + 1 :, :], -C)
        x = Matrix.hstack(F[i, :i], T[i, i + 1 :], D[i, :])
        rows.append((x * M + A[i, :]).expand())
    return Matrix.vstack(*rows) if rows else sp.zeros(0, n)


def form_13(T):
    """What must vanish for T to be unit upper triangular, as in (13)."""
    order, n = T.shape
    return Matrix(order, n, lambda i, j: T[i, j] - int(i == j) if j <= i else 0)


@cache
def derive(indices=(3, 1)):
    """The recursion for one index pattern, with symbols for every phi."""
    indices = tuple(indices)
    A, C, sizes, units = stairs(indices)
    T, F, D = recursion(A, sizes, units)
    n, m = sum(indices), len(indices)
    # of the four residuals only the first is asked for: no inputs, P and V left out
    B, E, G, W = (sp.zeros(rows, 0) for rows in (n, m, n - m, n))
    P, V = sp.zeros(n, n - m), sp.zeros(n, m)
    dynamics, *_ = residuals(A, B, C, E, sp.zeros(n), F, G, D, P, V, W, T, T)
    name = f"p = {indices}"
    steps = {
        f"(4a) T A - F T = D C [{name}]": Claim(dynamics.expand()),
        f"(4b) [T; C] is invertible: its determinant is 1 [{name}]": Claim(
            Matrix.vstack(T, C).det(), 1
        ),
        f"(13) T is unit upper triangular [{name}]": Claim(form_13(T)),
        f"(18), (20) every row solves Van Dooren's, f_ii = 0 [{name}]": Claim(
            van_dooren_rows(A, C, T, F, D)
        ),
        f"F^(p_M - 1) = 0: exact after p_M samples [{name}]": Claim(
            F ** (max(indices) - 1) if n > m else sp.zeros(1)
        ),
    }
    return Derivation(
        given=(A, C),
        formulas={
            "(7) A": A,
            "(7) C": C,
            "(13) T": T,
            "F": F,
            "D": D,
        },
        steps={name: one for name, one in steps.items() if not one.is_empty},
        source="Van Dooren (1984), section 3, with the poles of Kawazoe (1978)",
    )
