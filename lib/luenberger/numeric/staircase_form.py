"""Van Dooren's staircase form of a pair (A, C), by unitary transformations.

Source: Van Dooren (1984), (7), (8) and remark 2(c).
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from ..errors import DesignError
from . import Matrix, Vector
from .even_pair import Pair, even_pair, highest
from .linalg import decaying, modes
from .staircase_climb import Climbed, climb
from .validation import matrix

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
