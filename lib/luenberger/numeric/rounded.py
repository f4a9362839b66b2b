"""Matrices that know how far rounding has put them off, entry by entry.

A stage list that runs on them, rather than on arrays, bounds its own rounding: each
product and sum adds what it rounds to what its factors are off (a running error
analysis; Higham, Accuracy and Stability of Numerical Algorithms, section 3.3).  The
bound of a product holds for sums in any order, with and without fused operations.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self, TypeVar

import numpy as np

from . import Matrix
from .factors import EPS
from .linalg import eye

UNIT = EPS / 2  # the most that rounding to nearest changes a number, beside it
TINY = float(np.finfo(float).tiny)  # what underflow may take from a product


R = TypeVar("R", bound="Rounded")


class Rounded:
    """A matrix, of which no entry of `value` is off by more than that of `off`."""

    __array_ufunc__ = None  # so that an ndarray leaves sums with one of these to it
    corrections = 0  # of a solution of equations

    def __init__(self, value: Matrix, off: Matrix) -> None:
        self.value, self.off = value, off

    @classmethod
    def of(cls, X: Matrix) -> Self:
        """A matrix of floats, as it is."""
        return cls(X, np.zeros_like(X))

    def like(self, X: Self | Matrix) -> Self:
        """X as one of these."""
        return self.of(X) if isinstance(X, np.ndarray) else X

    @property
    def shape(self) -> tuple[int, ...]:
        """That of the matrix."""
        return self.value.shape

    @property
    def T(self) -> Self:
        """The transpose."""
        return type(self)(self.value.T, self.off.T)

    def __neg__(self) -> Self:
        return type(self)(-self.value, self.off)

    def __add__(self, other: Self | Matrix) -> Self:
        other = self.like(other)
        total = self.value + other.value
        off = self.off + other.off
        return type(self)(total, off + UNIT * (np.abs(total) + off))

    def __radd__(self, other: Matrix) -> Self:
        return self + other

    def __sub__(self, other: Self | Matrix) -> Self:
        return self + -self.like(other)

    def __rsub__(self, other: Matrix) -> Self:
        return -self + other

    def dot(self, other: Self) -> Self:
        """The product of two matrices."""
        n = self.shape[1]
        size, beyond = np.abs(self.value), np.abs(other.value)
        lost = (n + 1) * UNIT
        off = size @ (other.off + lost * beyond)
        off += self.off @ (beyond + other.off) + n * TINY
        return type(self)(self.value @ other.value, off * (1 + lost))

    def halved(self) -> Self:
        """Half of it."""
        return type(self)(self.value / 2, self.off / 2)

    def short(self) -> Rounded:
        """The same, as one float an entry."""
        return Rounded(self.value, self.off)

    def beside(self, X: Matrix) -> Rounded:
        """What it has beside a matrix of floats."""
        return (self - X).short()


def joined(*parts: Rounded) -> Rounded:
    """Matrices beside each other."""
    values, offs = ([getattr(X, k) for X in parts] for k in ("value", "off"))
    return Rounded(np.concatenate(values, axis=1), np.concatenate(offs, axis=1))


def symmetrise(X: R) -> R:
    """The mean of X and X'."""
    return (X + X.T).halved()


def solve_right(B: R, M: R) -> R:
    """B M^-1, for M that is symmetric positive definite.

    What the solution leaves of B bounds how far it is off.  That is infinite where M is
    so near to singular that its inverse has no good digit.
    """
    if not B.value.size:
        return B
    inverse = np.linalg.inv(M.value)
    X = B.like(B.value @ inverse)
    for _ in range(B.corrections):
        X = X + (B - X.dot(M)).value @ inverse
    left, size = B - X.dot(M), np.abs(inverse)
    wrong = np.abs(M.value @ inverse - np.eye(len(size))) + M.off @ size
    wrong += (len(size) + 2) * EPS * np.abs(M.value) @ size  # of the inverse
    off = (np.abs(left.value) + left.off) @ size
    if np.linalg.norm(wrong, np.inf) > 0.5:
        off += np.inf
    X.off = off + 2 * off.sum(axis=1, keepdims=True) * wrong.max()
    return X


NAMESPACE: dict[str, Callable[..., Any]] = dict(
    eye=eye, symmetrise=symmetrise, solve_right=solve_right
)
