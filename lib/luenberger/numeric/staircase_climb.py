"""Up the stairs of a pair (A, C), by unitary transformations of the state.

Source: Van Dooren (1984), (7), (8) and remark 2(c).
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
from scipy.linalg.lapack import get_lapack_funcs

from . import Matrix, Vector
from .linalg import eigenvalues


class Climbed(NamedTuple):
    """What `climb` makes of A and C: U, A_U, r_1..r_k, and how many are hidden."""

    C: Matrix
    U: Matrix
    A: Matrix
    sizes: list[int]
    hidden: int

    @property
    def hidden_modes(self) -> Vector:
        return eigenvalues(self.A[: self.hidden, : self.hidden])


def climb(A: Matrix, C: Matrix, tol: float) -> tuple[Climbed, int, float]:
    """Compress C, then the block above it, and so on; its rank and smallest stair too.

    Each stage turns the N columns not yet used so that X = [0 | echelon].  The rows
    of X belong to the stage before, which stays as it is.
    """
    n, kind = len(A), np.result_type(A, C)
    A, X = np.array(A, kind, order="F"), _unit_rows(C).astype(kind)
    U = np.eye(n, dtype=A.dtype, order="F")
    size_A = float(np.linalg.norm(_scaled(A)) * np.abs(A).max(initial=0))
    scale = float(np.linalg.norm(X, 2)) if X.size else 0.0
    N, sizes, margin = n, list[int](), np.inf
    while N:
        V, S, small, rank, least = _compress(X, tol * scale)
        if rank == 0:
            break
        margin = min(margin, least / scale)
        below = N + (sizes[0] if sizes else 0)  # rows of A that columns :N reach
        _turn(A[:below, :N], V, S, small)
        _turn(U[:, :N], V, S, small)
        _turn(A[:N].T, V.conj(), S.conj(), small.conj())
        if sizes:  # exact zeros, also below the diagonal that ends in the last corner
            done = A[N:below, :N]
            done[:, : N - rank] = 0
            done[:, N - rank :] = np.triu(done[:, N - rank :], rank - len(done))
        N, sizes, scale = N - rank, [rank, *sizes], size_A
        if rank == 1:
            A, U, sizes, N, least = _climb_steps(A, U, N, sizes, tol * size_A)
            margin = min(margin, least / (size_A or 1))
            break
        X = A[N : N + rank, :N]
    return Climbed(C, U, A, sizes, N), n - N, margin


def _climb_steps(
    A: Matrix, U: Matrix, N: int, sizes: list[int], least: float
) -> tuple[Matrix, Matrix, list[int], int, float]:
    """The rest of `_climb` when every stair left is one wide: LAPACK's Hessenberg.

    Reduced is the transpose about the antidiagonal, of which row N of A is the
    first column, so the stairs below stay as they are.
    """
    k = N + 1
    flipped = A[:k, :k].T[::-1, ::-1]
    H, Q = scipy.linalg.hessenberg(flipped, calc_q=True)
    Z = Q.conj()[::-1, ::-1]
    A[:k, k:] = Z.conj().T @ A[:k, k:]
    A[:k, :k] = H.T[::-1, ::-1]
    U[:, :k] = U[:, :k] @ Z
    smallest = np.inf
    while N and abs(A[N, N - 1]) > least:
        smallest = min(smallest, abs(A[N, N - 1]))
        N, sizes = N - 1, [1, *sizes]
    A[N:k, :N] = 0 if N else A[N:k, :N]
    return A, U, sizes, N, smallest


def _unit_rows(C: Matrix) -> Matrix:
    unit = _scaled(C, axis=1)
    lengths = np.linalg.norm(unit, axis=1, keepdims=True)
    return unit / np.where(lengths > 0, lengths, 1)


def _scaled(X: Matrix, axis: int | None = None) -> Matrix:
    """X with its largest entry (of each row) at 1, so that no square overflows."""
    top = np.abs(X).max(axis, initial=0, keepdims=True)
    return X / np.where(top > 0, top, 1)


def _compress(X: Matrix, least: float) -> tuple[Matrix, Matrix, Matrix, int, float]:
    """V, S, small of the unitary Z with X Z = [0 | echelon of full rank].

    Then that rank, and the smallest singular value that was kept.

    Z = (I - V S V') diag(I, small): reflectors that bring X to its last columns,
    then an SVD and an RQ factorisation of what is left, which is small.
    """
    m, N = X.shape
    if m == 0:
        return np.zeros((N, 0)), np.eye(0), np.eye(N), 0, 0.0
    V, S = np.zeros((N, 0), X.dtype), np.eye(0)
    if m < N:
        geqrt = get_lapack_funcs("geqrt", (X,))
        packed, S, _ = geqrt(m, X.conj().T[::-1])
        V = np.tril(packed, -1)
        V[np.arange(m), np.arange(m)] = 1
        V = V[::-1]
        X = np.triu(packed[:m])[::-1].conj().T
    _, values, right = scipy.linalg.svd(X, full_matrices=True)
    rank = int((values > least).sum())
    small = right[::-1].conj().T  # the largest singular direction last
    kept = small.shape[1] - rank
    if rank:
        _, Q = scipy.linalg.rq(X @ small[:, kept:], mode="full")
        small[:, kept:] = small[:, kept:] @ Q.conj().T
    return V, S, small, rank, float(values[rank - 1]) if rank else 0.0


def _turn(X: Matrix, V: Matrix, S: Matrix, small: Matrix) -> None:
    """X <- X Z in place."""
    X -= ((X @ V) @ S) @ V.conj().T
    k = X.shape[1] - len(small)
    X[:, k:] = X[:, k:] @ small
