"""Van Dooren's staircase form of a pair (A, C), by unitary transformations.

Source: Van Dooren (1984), (7), (8) and remark 2(c).
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike
from scipy.linalg.lapack import get_lapack_funcs

from ..errors import DesignError
from . import Matrix, Vector
from .even_pair import Pair, even_pair, highest
from .linalg import decaying, eigenvalues, modes
from .validation import matrix


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


RANK_UNITS = 10.0  # default tolerance of a rank decision: 10 max(n, p) eps


@dataclass(frozen=True, eq=False)
class Staircase:
    r"""What `staircase` returns: (7), with Y' C U = C_U and U' A U = A_U.

    Attributes
    ----------
    U : (n, n) ndarray
        Unitary.
    A : (n, n) ndarray
        A_U of (7a): block Hessenberg, with zeros stored as zeros.
    C : (p, n) ndarray
        C_U of (7b): zero but for C_k in its last r_k columns and first r_k rows.
    blocks : tuple of int
        r_1 <= ... <= r_k, from the top; the last one is the rank of C.
    Y : (p, p) ndarray
        Unitary output transformation; the identity when C has full row rank.
    tol : float
        The one tolerance of every rank decision: a singular value of a block of A
        counts when it exceeds tol ||A||_F, of C (rows at unit length) when it
        exceeds tol times the largest.
    leads : (n,) int ndarray
        For column c the last row of [A_U; C_U] that it reaches; these rows are all
        different, which is the echelon form.
    """

    U: np.ndarray
    A: np.ndarray
    C: np.ndarray
    blocks: tuple[int, ...]
    Y: np.ndarray
    tol: float
    leads: np.ndarray

    @property
    def rank(self) -> int:
        """r, the rank of C."""
        return self.blocks[-1]

    @property
    def redundant(self) -> int:
        """How many outputs say nothing that the others do not, p - r."""
        return len(self.C) - self.rank

    @property
    def indices(self) -> tuple[int, ...]:
        """Observability indices, largest first; (7) is their conjugate partition."""
        return conjugate(self.blocks)


def conjugate(blocks: tuple[int, ...]) -> tuple[int, ...]:
    """The conjugate partition: of the widths of stairs, their heights."""
    sizes = np.array(blocks)
    return tuple(int((sizes >= k).sum()) for k in range(1, max(blocks, default=0) + 1))


def staircase(A: ArrayLike, C: ArrayLike, tol: float | None = None) -> Staircase:
    r"""Unitary staircase form of an observable pair, (7) and (8).

    >>> import luenberger as lb
    >>> form = staircase([[0, 1, 0], [0, 0, 1], [1, 2, 3]], [[1, 0, 0]])
    >>> form.blocks, form.indices, form.redundant
    ((1, 1, 1), (3,), 0)

    .. math:: U^*AU = \begin{bmatrix} A_{11} & \cdots & & A_{1k}\\
              A_{21} & A_{22} & & \vdots\\ & \ddots & \ddots & \\
              & & A_{k,k-1} & A_{kk} \end{bmatrix},\qquad
              Y^*CU = \begin{bmatrix} 0 & \cdots & 0 & C_k\end{bmatrix}.

    Every block below the diagonal, and C_k, has full column rank.  A square one is
    upper triangular; a tall one is zero below the diagonal that ends in its last
    corner, and that triangle can be singular though the block is not.  (The printed
    form (8) has a regular triangle in the first rows; without an output
    transformation that can be had only when the stairs are equal.)  Redundant
    outputs are compressed by Y, so that C_k = [R; 0].

    Parameters
    ----------
    A, C : (n, n), (p, n) array_like
        Real or complex; C of any rank.
    tol : float, optional
        Relative tolerance of the rank decisions, default ``10 max(n, p) eps``.

    Returns
    -------
    Staircase
        With ``U' A U``, ``Y' C U`` and ``U' U`` right to a few eps.

    Raises
    ------
    DesignError
        If the pair is not observable: the message names the unobservable
        eigenvalues and which of them are stable.
    ValueError
        If a matrix has the wrong shape, or tol is not in [0, 1).

    References
    ----------
    Van Dooren (1984), (7), (8), remark 2(c); papers/van_dooren/derivation/rows.py.
    """
    A, C, tol = _checked(A, C, tol)
    return _finished(climb(A, C, tol)[0], tol, None)


def find_in_even_units(
    A: Matrix, C: Matrix, dt: float, fastest: float = 0.0
) -> tuple[Pair, Staircase]:
    """The units in which what the outputs see is judged, and the form there.

    `fastest` is the largest rate that an observer is asked for, if any.
    """
    pair, climbed, tol = _in_even_units(A, C, dt, fastest)
    return pair, _finished(climbed, tol, dt, pair.rate)


def unobservable(
    A: Matrix, C: Matrix, dt: float, tol: float | None = None
) -> tuple[Vector, tuple[int, ...]]:
    """Eigenvalues of A that do not reach the outputs, and the widths of the stairs.

    Examples
    --------
    >>> A, C = np.array([[0.5, 0], [0, 2]]), np.array([[1, 0]])
    >>> hidden, sizes = unobservable(A, C, dt=1.0)
    >>> hidden.tolist(), sizes
    ([2.0], (1,))
    """
    pair, climbed, _ = _in_even_units(A, C, dt, tol=tol)
    return climbed.hidden_modes * pair.rate, tuple(climbed.sizes)


def _in_even_units(
    A: Matrix, C: Matrix, dt: float, fastest: float = 0.0, tol: float | None = None
) -> tuple[Pair, Climbed, float]:
    A, C, tol = _checked(A, C, tol)
    pair = even_pair(A, C, dt, fastest)
    return *highest(pair, lambda A, C: climb(A, C, tol)), tol


def _checked(
    A: ArrayLike, C: ArrayLike, tol: float | None
) -> tuple[Matrix, Matrix, float]:
    """All three, once they are right."""
    A = matrix("A", A, field=complex)
    n = len(A)
    A = matrix("A", A, n, n, field=complex)
    if n == 0:
        raise ValueError("A must not be empty: there is no state to observe")
    C = matrix("C", C, cols=n, field=complex)
    if tol is None:
        tol = RANK_UNITS * max(n, len(C)) * np.finfo(float).eps
    if not (isinstance(tol, Real) and 0 <= tol < 1):
        raise ValueError(f"tol must be a number in [0, 1), got {tol!r}")
    return A, C, float(tol)


def _finished(
    climbed: Climbed, tol: float, dt: float | None, rate: float = 1.0
) -> Staircase:
    """The form, or the refusal; A is in units of time of 1 / rate."""
    C, U, AU, sizes, hidden = climbed
    (p, n), r = C.shape, max(sizes, default=0)
    if hidden:
        raise DesignError(_unobservable(climbed.hidden_modes * rate, dt))
    CU = C @ U
    CU[:, : n - r] = 0
    Y = np.eye(p, dtype=CU.dtype)
    if r < p:
        Y, R = scipy.linalg.qr(CU[:, n - r :])
        CU[:, n - r :] = R
    CU[:, n - r :] = np.triu(CU[:, n - r :])
    return Staircase(U, AU, CU, tuple(sizes), Y, tol, _leads(sizes))


def _leads(sizes: list[int]) -> Vector:
    """Row of [A_U; C_U] with the last nonzero entry of each column."""
    ends = np.cumsum(sizes)
    last = [*sizes[1:], sizes[-1]]  # C_k keeps its triangle in its first r_k rows
    parts = (
        end + below - width + np.arange(width)
        for end, below, width in zip(ends, last, sizes)
    )
    return np.concatenate([*parts])


def _unobservable(hidden: Vector, dt: float | None) -> str:
    """The message: which eigenvalues, and which of them decay."""
    hidden = np.asarray(hidden, dtype=complex)
    continuous, discrete = (hidden[decaying(hidden, k)] for k in (False, True))
    units = ""
    if dt is None:  # for a form in the user's units
        units = (
            "; if the units of the states differ by many orders of magnitude, scale "
            "them first"
        )
        stable = (
            f"In continuous time the stable ones are {modes(continuous) or 'none'}; in "
            f"discrete time {modes(discrete) or 'none'}."
        )
    else:
        found = discrete if dt else continuous
        stable = f"Stable among them: {modes(found) or 'none'}."
    return (
        f"not observable: the eigenvalue(s) {modes(hidden)} of A do not reach the "
        f"outputs, so no observer can move them. {stable} Add a sensor that sees them, "
        f"or leave those states out of the model{units}."
    )
