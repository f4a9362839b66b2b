"""Matrices with twice the digits of a float, and a bound on what they are off.

An entry is the sum of two floats, of which the second is as small as the rounding of
the first.  Products are exact where that matters: of matrices cut into slices with few
bits BLAS rounds no product, in whatever order it sums (Ozaki, Ogita, Oishi and Rump,
Numer. Algorithms 59 (2012) 95-118).  What is rounded is bounded entry by entry.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from . import Matrix
from .factors import EPS
from .rounded import TINY, Rounded

DIGITS = 53  # bits of a float
Slices = tuple[Matrix, Matrix, Matrix]


class Wide(Rounded):
    """A matrix ``value + rest``; no entry is off by more than that of `off`."""

    corrections = 1

    def __init__(self, value: Matrix, off: Matrix, rest: Matrix | None = None) -> None:
        super().__init__(value, off)
        self.rest = np.zeros_like(value) if rest is None else rest
        self.cut: dict[int, Slices] = {}

    @property
    def T(self) -> Self:
        """The transpose."""
        made = type(self)(self.value.T, self.off.T, self.rest.T)
        made.cut = {1 - k: (X.T, Y.T, Z.T) for k, (X, Y, Z) in self.cut.items()}
        return made

    def __neg__(self) -> Self:
        return type(self)(-self.value, self.off, -self.rest)

    def __add__(self, other: Self | Matrix) -> Self:
        other = self.like(other)
        total, rest = _sum(self.value, other.value)
        rest += self.rest + other.rest
        value = total + rest
        size = np.abs(self.value) + np.abs(other.value)
        off = self.off + other.off + 4 * EPS**2 * size
        return type(self)(value, off, rest - (value - total))

    def dot(self, other: Self) -> Self:
        """The product of two matrices."""
        n = self.shape[1]
        A, B = self.slices(1), other.slices(0)
        left, beyond = A[2] + self.rest, B[2] + other.rest
        high, next_ = A[0] @ B[0], _side(A[0], A[1]) @ _below(B[1], B[0])  # exactly
        rest = _side(A[1], self.value, left)
        rest = rest @ _below(B[1], beyond, other.value - B[2])
        total, small = _sum(high, next_)
        rest += small
        lost = (
            3 * n + 8
        ) * EPS  # of products in the rest, and of what they are made of
        size, whole = np.abs(self.value), np.abs(other.value)
        far = np.abs(B[2]) + np.abs(other.rest)
        near = self.off + lost * (np.abs(A[2]) + np.abs(self.rest))
        off = _side(size + np.abs(self.rest) + self.off, near, lost * np.abs(A[1]))
        whole = whole + np.abs(other.rest)
        off = off @ _below(other.off + lost * far, whole, np.abs(B[1]))
        value, rest = _sum(total, rest)
        off += 4 * EPS * np.abs(rest) + EPS**2 * np.abs(value) + n * TINY
        return type(self)(value, off * (1 + lost), rest)

    def slices(self, axis: int) -> Slices:
        """Parts of the value for products along an axis, made once."""
        if axis not in self.cut:
            twice = 2 * self.shape[axis]  # so many products add up to DIGITS
            bits = (DIGITS - twice.bit_length()) // 2
            self.cut[axis] = _slices(self.value, axis, bits)
        return self.cut[axis]

    def halved(self) -> Self:
        """Half of it."""
        return type(self)(self.value / 2, self.off / 2, self.rest / 2)

    def short(self) -> Rounded:
        """The same, as one float an entry."""
        return Rounded(self.value, self.off + np.abs(self.rest))


def _sum(X: Matrix, Y: Matrix) -> tuple[Matrix, Matrix]:
    """X + Y as a float and a rest, exactly."""
    total = X + Y
    part = total - X
    return total, (X - (total - part)) + (Y - part)


def _side(*parts: Matrix) -> Matrix:
    return np.concatenate(parts, axis=1)


def _below(*parts: Matrix) -> Matrix:
    return np.concatenate(parts)


def _slices(X: Matrix, axis: int, bits: int) -> Slices:
    """Two parts of X with so many bits each, in a unit for a row or column; the rest.

    `axis` is the one along which the unit is the same.
    """
    _, high = np.frexp(np.abs(X).max(axis=axis, keepdims=True, initial=0.0))
    shift = np.ldexp(1.5, high + (DIGITS - 1 - bits))
    first = (X + shift) - shift
    X, shift = X - first, shift * 2.0 ** -(bits + 1)
    second = (X + shift) - shift
    return first, second, X - second
