"""The same observer in coordinates where T has orthonormal rows.

A chain of factors is short to derive, but where its rows of T are nearly dependent D
has to be large and digits cancel.  Here the rows are found again from the last to the
first.  Row t for the pole a satisfies

    t (A - a I) = f T_below + d C,

so [t, -f, -d] is in the left null space of [A - a I; T_below; C]; in it the vector
closest to the chain's row is taken, and t turned orthogonal to the rows below.  F is
upper triangular, with 2 x 2 blocks for conjugate pairs, so the poles stay exact.

With one output there is no choice but of sign, and what the chain lost does not count.
"""

import numpy as np

from ...numeric import Matrix, Vector
from .companion_chain import Chain
from .driven import pivoted

NULL_TOL = 1e-12  # a singular value this small beside the largest is zero


def orthonormal(
    A: Matrix, C: Matrix, k: Vector, chain: Chain, poles: Vector
) -> Chain | None:
    """A `Chain` with the same poles; None where rounding leaves no independent row.

    `poles` are in the order of the chain's factors, of a pair the one with positive
    imaginary part first.
    """
    n, order, p = len(A), len(poles), len(C)
    T, F, D = np.zeros((0, n)), np.zeros((order, order)), np.zeros((order, p))
    i = order
    while i:
        paired = poles[i - 1].imag != 0
        i -= 2 if paired else 1
        below = i + (2 if paired else 1)
        pole = poles[i] if paired else poles[i].real
        wanted = _complex_row(chain, i, pole) if paired else chain.T[i]
        t, f, d = _row(A, C, pole, T, F[below:, below:], D[below:], wanted)
        me, size = slice(i, below), np.linalg.norm(t)
        if not size > 0:
            return None
        if paired:
            t, f, d, F[me, me] = _pair(t, f, d, pole)
            if not np.isfinite(t).all():
                return None
        else:
            t, f, d = t[None] / size, f[None] / size, d[None] / size
            F[i, i] = pole
        F[me, below:], D[me] = f, d
        T = np.vstack([t, T])
    return Chain(F, D, T, (k @ T.T)[None])


def _complex_row(chain: Chain, i: int, pole: complex) -> Vector:
    """The row of the pole alone in the span of rows i and i + 1, which share a pair."""
    share = (pole - chain.F[i + 1, i + 1]) / chain.F[i, i + 1]
    return share * chain.T[i] + chain.T[i + 1]


def _row(
    A: Matrix, C: Matrix, pole: complex, T: Matrix, F: Matrix, D: Matrix, wanted: Vector
) -> tuple[Vector, Vector, Vector]:
    """t, f, d with t (A - pole I) = f T + d C, t orthogonal to T and near `wanted`."""
    n, below = len(A), len(T)
    pencil = np.vstack([A - pole * np.eye(n), T, C])
    left, rank = pivoted(pencil, NULL_TOL)
    null = left[:, rank:].conj().T
    outside = null[:, :n] - (null[:, :n] @ T.T) @ T
    wanted = wanted - (wanted @ T.T) @ T
    wanted = wanted / max(np.linalg.norm(wanted), np.finfo(float).tiny)
    found = np.linalg.lstsq(outside.T, wanted, rcond=NULL_TOL)[0] @ null
    t, f, d = found[:n], -found[n : n + below], -found[n + below :]
    along = t @ T.T
    t, f, d = t - along @ T, f - along @ (F - pole * np.eye(below)), d - along @ D
    more = t @ T.T  # once more: twice is enough
    return t - more @ T, f - more @ (F - pole * np.eye(below)), d - more @ D


def _pair(
    t: Vector, f: Vector, d: Vector, pole: complex
) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Real rows from a complex one, turned until its two parts are orthogonal."""
    turn = np.exp(-0.5j * np.angle(t @ t))
    t, f, d = t * turn, f * turn, d * turn
    a, b = pole.real, pole.imag
    x, y = np.linalg.norm(t.real), np.linalg.norm(t.imag)
    size = np.array([[x], [y]])
    with np.errstate(divide="ignore", invalid="ignore"):  # of a part that vanishes
        t, f, d = (np.array([v.real, v.imag]) / size for v in (t, f, d))
        return t, f, d, np.array([[a, -b * y / x], [b * x / y, a]])
