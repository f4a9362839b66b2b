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


class Wide(Rounded):
    """A matrix ``value + rest``; no entry is off by more than that of `off`."""

    corrections = 2

    def __init__(self, value: Matrix, off: Matrix, rest: Matrix | None = None) -> None:
        super().__init__(value, off)
        self.rest = np.zeros_like(value) if rest is None else rest

    @property
    def T(self) -> Self:
        """The transpose."""
        return type(self)(self.value.T, self.off.T, self.rest.T)

    def __neg__(self) -> Self:
        return type(self)(-self.value, self.off, -self.rest)

    def __add__(self, other: Self | Matrix) -> Self:
        other = self.like(other)
        total = self.value + other.value
        part = total - self.value
        rest = (self.value - (total - part)) + (other.value - part)  # exactly
        rest += self.rest + other.rest
        value = total + rest
        size = np.abs(self.value) + np.abs(other.value)
        off = self.off + other.off + 4 * EPS**2 * size
        return type(self)(value, off, rest - (value - total))

    def dot(self, other: Self) -> Self:
        """The product of two matrices."""
        n = self.shape[1]
        bits = (DIGITS - n.bit_length()) // 2  # no sum of products has more than DIGITS
        A, B = _slices(self.value, 1, bits), _slices(other.value, 0, bits)
        small, beyond = A[2] + self.rest, B[2] + other.rest
        rest = self.value @ beyond + small @ (B[0] + B[1]) + self.rest @ other.rest
        found = self.of(A[0] @ B[0])
        for part in (A[0] @ B[1], A[1] @ B[0], A[1] @ B[1], rest):
            found = found + part
        size = np.abs(self.value) + np.abs(self.rest) + self.off
        left = np.abs(A[2]) + np.abs(self.rest)
        whole = np.abs(other.value) + np.abs(other.rest)
        lost = (2 * n + 4) * EPS
        off = size @ (other.off + lost * (np.abs(B[2]) + np.abs(other.rest)))
        off += (self.off + lost * left) @ whole + found.off + n * TINY
        return type(self)(found.value, off * (1 + lost), found.rest)

    def halved(self) -> Self:
        """Half of it."""
        return type(self)(self.value / 2, self.off / 2, self.rest / 2)

    def short(self) -> Rounded:
        """The same, as one float an entry."""
        return Rounded(self.value, self.off + np.abs(self.rest))


def _slices(X: Matrix, axis: int, bits: int) -> tuple[Matrix, Matrix, Matrix]:
    """Two parts of X with so many bits each, in a unit for a row or column; the rest.

    `axis` is the one along which the unit is the same.
    """
    _, high = np.frexp(np.abs(X).max(axis=axis, keepdims=True, initial=0.0))
    parts = []
    for unit in (high - bits, high - 2 * bits - 1):
        shift = np.ldexp(1.5, unit + DIGITS - 1)
        parts.append((X + shift) - shift)
        X = X - parts[-1]
    return parts[0], parts[1], X
