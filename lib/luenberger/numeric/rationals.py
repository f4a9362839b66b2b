"""Linear algebra over the rationals: matrices are object arrays of Fractions.

Elimination is Bareiss's: rows are first scaled to integers, and every division
after that is exact, so no fraction has to be reduced on the way.
"""

from collections.abc import Callable
from fractions import Fraction
from math import lcm
from typing import SupportsIndex

import numpy as np

from . import Matrix, Vector


def zeros(*shape: SupportsIndex) -> Matrix:
    out = np.empty(shape, dtype=object)
    out.fill(Fraction(0))
    return out


def eye(n: SupportsIndex) -> Matrix:
    out = zeros(n, n)
    for k in range(n):
        out[k, k] = Fraction(1)
    return out


def makers(exactly: bool) -> tuple[Callable[[int], Matrix], Callable[..., Matrix]]:
    """eye(n) and zeros(*shape), of Fractions or of floats."""
    return (eye, zeros) if exactly else (np.eye, lambda *shape: np.zeros(shape))


def solve(M: Matrix, N: Matrix) -> Matrix:
    """The exact X with M X = N; ZeroDivisionError when M is singular.

    Elimination above and below the pivot: at the end every diagonal entry is the
    determinant, and each entry of X is one fraction, reduced once.
    """
    n = len(M)
    rows = [_integers([*M[i], *N[i]]) for i in range(n)]
    previous = 1
    for k in range(n):
        pivot = next((i for i in range(k, n) if rows[i][k]), None)
        if pivot is None:
            raise ZeroDivisionError("the matrix is singular")
        rows[k], rows[pivot] = rows[pivot], rows[k]
        top = rows[k]
        for i in range(n):
            if i != k:
                row, head = rows[i], rows[i][k]
                rows[i] = [
                    (top[k] * a - head * b) // previous for a, b in zip(row, top)
                ]
        previous = top[k]
    X = zeros(n, N.shape[1])
    for i, j in np.ndindex(*X.shape):
        X[i, j] = Fraction(rows[i][n + j], rows[i][i])
    return X


def reduced(M: Matrix) -> tuple[Matrix, list[int]]:
    """Reduced row echelon form of M without its zero rows, and the pivot columns."""
    rows = [_integers(row) for row in M]
    pivots: list[int] = []
    for j in range(M.shape[1]):
        at = len(pivots)
        pivot = next((i for i in range(at, len(rows)) if rows[i][j]), None)
        if pivot is None:
            continue
        rows[at], rows[pivot] = rows[pivot], rows[at]
        top = rows[at]
        for i, row in enumerate(rows):
            if i != at and row[j]:
                rows[i] = _integers([top[j] * a - row[j] * b for a, b in zip(row, top)])
        pivots.append(j)
    out = zeros(len(pivots), M.shape[1])
    for i, j in enumerate(pivots):
        out[i] = [Fraction(entry, rows[i][j]) for entry in rows[i]]
    return out, pivots


def null_space(M: Matrix) -> Matrix:
    """Columns that span the x with M x = 0; each has a one where the others have 0."""
    echelon, pivots = reduced(M)
    free = [j for j in range(M.shape[1]) if j not in pivots]
    basis = zeros(M.shape[1], len(free))
    for k, j in enumerate(free):
        basis[j, k] = Fraction(1)
        for i, pivot in enumerate(pivots):
            basis[pivot, k] = -echelon[i, j]
    return basis


class Span:
    """The rows accepted so far, in echelon form over the integers."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, list[int]]] = []  # leading column, integer row

    def accept(self, row: Vector) -> bool:
        """Take `row` in and return True, or return False if it depends on the rest."""
        row = _integers(row)
        for lead, other in self._rows:
            if row[lead]:
                row = [other[lead] * a - row[lead] * b for a, b in zip(row, other)]
        lead = next((j for j, entry in enumerate(row) if entry), None)
        if lead is None:
            return False
        self._rows.append((lead, _integers(row)))
        return True


def _integers(row: Vector | list[int] | list[Fraction]) -> list[int]:
    """The row times the positive number that makes it integers without a divisor."""
    scale = lcm(*(entry.denominator for entry in row)) if len(row) else 1
    row = [int(entry * scale) for entry in row]
    common = int(np.gcd.reduce(np.array(row, dtype=object))) if any(row) else 1
    return [entry // common for entry in row]
