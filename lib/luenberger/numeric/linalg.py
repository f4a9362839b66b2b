"""Numerical steps shared by the designs, each with its refusal.

The primitives are LAPACK's, through SciPy; what is decided here is what to do when
a matrix is singular, and what to tell the user.
"""

from collections.abc import Iterable
from functools import cache

import numpy as np
import scipy.linalg
from scipy.linalg.lapack import dposv

from ..errors import DesignError
from . import Matrix, Vector
from .balance import evened
from .factors import factor

SINGULAR_TOL = 1e-13  # 1 - (multiple correlation)^2 below this: a redundant output
ROUNDING = 1e-14  # a variance this small beside the terms it is made of is zero
RANK_TOL = 1e-10  # smallest singular value, relative to the largest, called nonzero
UNIT_TOL = 1e-9  # a pole this close to the unit circle is called on it
ZERO_TOL = 1e-13  # an eigenvalue this small beside the largest may be a zero


@cache
def eye(n: int) -> Matrix:
    """The identity matrix, made once for each size; read-only."""
    identity = np.eye(n)
    identity.setflags(write=False)
    return identity


def symmetrise(X: Matrix) -> Matrix:
    """(X + X') / 2: rounding that is not symmetric would grow from step to step."""
    return 0.5 * (X + X.mT)


def solve_right(N: Matrix, M: Matrix) -> Matrix:
    """Return X with X M = N for symmetric positive semi-definite M.

    Cholesky where M is definite.  A singular M has redundant rows; then the
    solution of least norm, which exists for every gain because the rows of N lie in
    the range of M.  Singularity is judged at unit diagonal, so units play no part.
    """
    if M.ndim == 2 and N.ndim > 2 and N.size:
        return solve_right(N.reshape(-1, len(M)), M).reshape(N.shape)
    if M.ndim > 2:
        lead = np.broadcast_shapes(N.shape[:-2], M.shape[:-2])
        N, M = (np.broadcast_to(X, lead + X.shape[-2:]) for X in (N, M))
        out = np.empty(N.shape)
        for index in np.ndindex(*lead):
            out[index] = solve_right(N[index], M[index])
        return out
    if N.size == 0:
        return np.zeros(N.shape)
    lower, X, info = dposv(M, N.T)
    if info == 0:
        pivots, diagonal = lower.diagonal(), M.diagonal()
        if (pivots * pivots > SINGULAR_TOL * diagonal).all():
            return X.T
    return N @ pseudo_inverse(M)


def pseudo_inverse(M: Matrix) -> Matrix:
    """Moore-Penrose inverse of a symmetric positive semi-definite M, scaled.

    The rank is decided at unit diagonal.
    """
    diagonal = M.diagonal()
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(M * scale * scale[:, None])
    keep = values > SINGULAR_TOL * max(len(M), 1)
    half = vectors[:, keep] / np.sqrt(values[keep]) * scale[:, None]
    return half @ half.T


def null_directions(X: Matrix) -> Matrix:
    """Orthonormal columns spanning the null space of a covariance X, at unit scale."""
    diagonal = X.diagonal()
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(X * scale * scale[:, None])
    return scale[:, None] * vectors[:, values <= SINGULAR_TOL * max(len(X), 1)]


def nonsingular(X: Matrix) -> np.ndarray | np.bool:
    """Whether a covariance, or each of a stack, has no null direction at unit scale."""
    diagonal = np.diagonal(X, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values = np.linalg.eigvalsh(X * scale[..., :, None] * scale[..., None, :])
    return (values > SINGULAR_TOL * max(X.shape[-1], 1)).all(axis=-1)


def complete(
    C1: Matrix, weight: Matrix | None = None, labels: Iterable[str] | None = None
) -> tuple[Matrix, Matrix, Matrix]:
    """Return Phat, Gamma1, That with [That; C1]^-1 = [Phat | Gamma1], (47).

    Phat spans the null space of C1 and contains rows of the identity chosen by
    pivoted QR, so each observer state tracks one named plant state and the choice
    does not hang on signs.  Gamma1 = W^-1 C1' (C1 W^-1 C1')^-1 is the right inverse
    of least error trace for the weight W, default the identity; of a singular W it is
    one of them.
    """
    m1, n = C1.shape
    if m1 == 0:
        return np.eye(n), np.zeros((n, 0)), np.eye(n)
    found = _independent(C1, np.ones(n))
    if found is None:  # perhaps in better units
        found = _independent(C1, evened(C1)[2])
    if found is None:
        which = f"outputs {list(labels)}" if labels is not None else "rows of C1"
        raise DesignError(
            f"the accurate {which} are linearly dependent, so x^ cannot reproduce "
            "each of them. Take fewer of them as accurate."
        )
    bound, free = found
    Phat = np.zeros((n, n - m1))
    Phat[free, np.arange(n - m1)] = 1
    Phat[bound] = 0.0 - np.linalg.solve(C1[:, bound], C1[:, free])  # no -0.0
    Gamma1 = _right_inverse(C1, Phat, weight)
    Gamma1 = Gamma1 + Gamma1 @ (np.eye(m1) - C1 @ Gamma1)  # what rounding left
    That = np.linalg.inv(np.hstack([Phat, Gamma1]))[: n - m1]
    return Phat, Gamma1, That


def _independent(C1: Matrix, units: Vector) -> tuple[Vector, Vector] | None:
    """Columns of C1 that are a basis, and the others; None if rows are dependent."""
    scaled = C1 * units
    for size in (lambda row: np.abs(row).max(initial=0), np.linalg.norm):
        rows = np.array([size(row) for row in scaled])[:, None]  # no square overflows
        scaled = scaled / np.where(rows > 0, rows, 1)
    _, upper, pivots = scipy.linalg.qr(scaled, mode="economic", pivoting=True)
    diagonal, m1 = np.abs(np.diagonal(upper)), len(C1)
    if m1 > C1.shape[1] or diagonal[-1] <= RANK_TOL * diagonal[0]:
        return None
    return np.sort(pivots[:m1]), np.sort(pivots[m1:])


def _right_inverse(C1: Matrix, Phat: Matrix, weight: Matrix | None) -> Matrix:
    """W^-1 C1' (C1 W^-1 C1')^-1 by QR, as the Gram matrix squares what units do.

    The largest states come first, and columns are pivoted: then no small state loses
    its digits.  (A. J. Cox and N. J. Higham, Stability of Householder QR for weighted
    least squares problems, 1998.)  But QR rounds the zeros between states that share
    no output; what that leaves along Phat, as Phat' W Gamma1 = 0 tells, is taken away.
    """
    lower = np.eye(C1.shape[1])
    if weight is not None:
        if not nonsingular(weight):
            return _seen_in_part(_right_inverse(C1, Phat, None), Phat, weight)
        lower = np.linalg.cholesky(weight)
    lifted = _triangular(lower, C1.T, lower=True)
    rows = np.argsort(-np.abs(lifted).max(axis=1))
    basis, upper, order = scipy.linalg.qr(lifted[rows], mode="economic", pivoting=True)
    basis = basis[np.argsort(rows)]
    basis = _triangular(lower, basis, lower=True, trans_a=1)
    inverse = np.empty_like(basis)
    inverse[:, order] = _triangular(upper, basis.T).T
    free = lower.T @ Phat
    left = (free.T @ (lower.T @ inverse)).T
    return inverse - Phat @ solve_right(left, free.T @ free).T


def _triangular(X: Matrix, B: Matrix, **form: int) -> Matrix:
    """Solve with a triangular X by BLAS, which leaves small ones to one thread.

    LAPACK's solver of OpenBLAS wakes all threads for 5 x 5, and is ten times as slow.
    """
    (solve,) = scipy.linalg.get_blas_funcs(("trsm",), (X, B))
    found: Matrix = solve(1.0, X, B, **form)
    return found


def _seen_in_part(Gamma: Matrix, Phat: Matrix, weight: Matrix) -> Matrix:
    """Gamma - Phat X L_W' Gamma, X the pseudoinverse of L_W' Phat and W = L_W L_W'."""
    root = factor(weight).T
    return Gamma - Phat @ np.linalg.lstsq(root @ Phat, root @ Gamma, rcond=RANK_TOL)[0]


def left_over(L: Matrix, V: Matrix, C: Matrix, x: Vector) -> Matrix:
    """(L - V C) diag(x), and 0 where rounding is all that the difference leaves."""
    left, size = (L - V @ C) * x, (np.abs(L) + np.abs(V) @ np.abs(C)) * x
    return np.where(np.abs(left) > ROUNDING * size.max(axis=1, keepdims=True), left, 0)


def lyapunov(F: Matrix, Q: Matrix) -> Matrix:
    """Solve X = F X F' + Q for stable F, by doubling.

    The sum of F^k Q F^k' is doubled in length each time, so X stays semi-definite,
    and an F with large entries and small poles does no harm.
    """
    X, power = symmetrise(Q), F
    for _ in range(64):  # 2^64 terms: no pole below 1 in floating point needs more
        more = power @ X @ power.T
        X = symmetrise(X + more)
        if (more.diagonal() <= 1e-17 * X.diagonal()).all():
            break
        power = power @ power
    return X


def radius(F: Matrix) -> float:
    """Largest |eigenvalue| of F; 0 for an empty matrix."""
    return float(np.abs(np.linalg.eigvals(F)).max(initial=0.0))


def eigenvalues(F: Matrix) -> Vector:
    """Eigenvalues of F, taken from its diagonal blocks where it is block triangular.

    Those of a triangular matrix are exactly its diagonal, whatever their
    multiplicity, where a QR iteration on the whole would scatter them.
    """
    if F.size == 0:
        return np.zeros(0)
    for X in (F, F.T):
        rows, cols = np.nonzero(X)
        # right[k]: the furthest column that rows 0 .. k reach
        right = np.arange(len(X))
        np.maximum.at(right, rows, cols)
        right = np.maximum.accumulate(right)
        ends = np.flatnonzero(right == np.arange(len(X))) + 1
        if len(ends) > 1:
            break
    starts = np.concatenate([[0], ends[:-1]])
    if len(ends) == len(F):
        return F.diagonal().copy()
    blocks = (F[a:b, a:b] for a, b in zip(starts, ends))
    return np.concatenate([np.linalg.eigvals(block) for block in blocks])


def decaying(modes: Vector, discrete: bool) -> Vector:
    """Which modes decay; one on the boundary does not, wherever rounding puts it."""
    size = np.abs(modes)
    if discrete:
        return size < 1 - UNIT_TOL
    least = np.maximum(UNIT_TOL * size, ZERO_TOL * size.max(initial=0.0))
    return np.real(modes) < -least


def modes(values: Iterable[complex]) -> str:
    """A short readable list of complex numbers, conjugates once."""
    shown = []
    for value in sorted(values, key=lambda v: (v.real, abs(v.imag))):
        real, imag = f"{value.real + 0.0:.6g}", f"{abs(value.imag):.6g}"  # no -0
        level = max(1e-12, 1e-6 * abs(value))  # what six digits leave out
        text = real if abs(value.imag) < level else f"{real} +- {imag}j"
        if text not in shown:
            shown.append(text)
    return ", ".join(shown)


def finite(X: Matrix) -> bool:
    """Whether no entry is infinite or NaN, as a quick look tells: False may be wrong.

    The sum has none of these if no entry has; only a sum beyond all floats looks worse
    than its terms.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(np.sum(X)))
