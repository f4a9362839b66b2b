"""Partitioned matrices, multiplied block by block.

SymPy's `block_collapse` is wrong when an identity meets a partitioned matrix
(sympy #22034), so it is not used: blocks are normal forms and we multiply them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp

from .polynomials import Normal, Polynomial, Traces
from .symbols import BlockMatrix
from .words import Formula, Shape, ShapeError, Size, same_shape, same_size


class Blocks(Normal):
    """A matrix of `Polynomial` entries with row sizes and column sizes."""

    def __init__(self, algebra: Any, entries: Sequence[Sequence[Polynomial]]) -> None:
        self.algebra = algebra
        self.entries = tuple(tuple(row) for row in entries)
        self.rows = tuple(row[0].shape[0] for row in self.entries)
        self.cols = tuple(entry.shape[1] for entry in self.entries[0])

    @classmethod
    def of(
        cls, algebra: Any, nested: Sequence[Sequence[Formula]]
    ) -> Blocks | Polynomial:
        """From nested sequences of SymPy expressions or normal forms.

        Blocks of no rows or no columns are dropped, so that a limiting size leaves
        the partition it should; a single block left is no longer partitioned.
        """
        grid = [[algebra.normal(x) for x in row] for row in nested]
        rows = [row for row in grid if not same_size(row[0].shape[0], 0)] or grid[:1]
        wide = [not same_size(x.shape[1], 0) for x in grid[0]]
        wide = wide if any(wide) else [True] + wide[1:]
        rows = [[x for x, keep in zip(row, wide) if keep] for row in rows]
        return rows[0][0] if len(rows) == len(rows[0]) == 1 else cls(algebra, rows)

    @classmethod
    def spread(
        cls, value: Blocks | Polynomial, rows: Sequence[Size], cols: Sequence[Size]
    ) -> Blocks:
        """A `Polynomial` on a given partition: only c I and 0 are known there."""
        if isinstance(value, Blocks):
            return value
        if len(rows) == len(cols) == 1:
            return cls(value.algebra, [[value]])
        whole = sp.Add(*rows), sp.Add(*cols)
        if not value.is_scaled_identity or (value.terms and not same(rows, cols)):
            raise ShapeError(f"{value} is not partitioned into {rows} by {cols}")
        if not same_shape(value.shape, whole):
            raise ShapeError(f"{value} of shape {value.shape} meets blocks of {whole}")
        c = value.terms.get((), 0)
        entry = lambda i, j: {(): c} if i == j and c != 0 else {}  # noqa: E731
        return cls(
            value.algebra,
            [
                [
                    Polynomial(value.algebra, entry(i, j).items(), (rows[i], cols[j]))
                    for j in range(len(cols))
                ]
                for i in range(len(rows))
            ],
        )

    @property
    def shape(self) -> Shape:
        return sp.Add(*self.rows), sp.Add(*self.cols)

    @property
    def is_zero(self) -> bool:
        return all(entry.is_zero for row in self.entries for entry in row)

    @property
    def T(self) -> Blocks:
        columns = zip(*self.entries)
        return Blocks(self.algebra, [[x.T for x in column] for column in columns])

    def __getitem__(self, index):
        i, j = index
        return self.entries[i][j]

    def map(self, function: Callable[[Any], Any]) -> Blocks:
        return Blocks(self.algebra, [[function(x) for x in y] for y in self.entries])

    def __add__(self, other):
        other = Blocks.spread(self.algebra.normal(other), self.rows, self.cols)
        if not (same(self.rows, other.rows) and same(self.cols, other.cols)):
            raise ShapeError(
                f"cannot add blocks {self.rows} x {self.cols} "
                f"and {other.rows} x {other.cols}"
            )
        return Blocks(
            self.algebra,
            [
                [x + y for x, y in zip(a, b)]
                for a, b in zip(self.entries, other.entries)
            ],
        )

    def __matmul__(self, other):
        return product(self, self.algebra.normal(other))

    def __rmatmul__(self, other):
        return product(self.algebra.normal(other), self)

    def __rmul__(self, scalar):
        return self.map(lambda x: scalar * x)

    def trace(self) -> Traces:
        if not same(self.rows, self.cols):
            raise ShapeError(f"no trace of blocks {self.rows} x {self.cols}")
        return sum(
            (self[i, i].trace() for i in range(1, len(self.rows))), self[0, 0].trace()
        )

    def as_expr(self) -> BlockMatrix:
        """Back to SymPy."""
        return BlockMatrix([[x.as_expr() for x in row] for row in self.entries])


def same(a, b):
    """Whether two partitions are equal."""
    return len(a) == len(b) and all(same_size(x, y) for x, y in zip(a, b))


def beside(value, sizes, axis):
    """A polynomial partitioned to stand before (axis 0) or behind `sizes`."""
    if value.is_scaled_identity and same_size(*value.shape):
        return Blocks.spread(value, sizes, sizes)
    far = value.shape[axis : axis + 1]
    if value.is_zero:
        return Blocks.spread(value, *((far, sizes) if axis == 0 else (sizes, far)))
    return Blocks(value.algebra, [[value]])


def product(left, right):
    """Multiply two normal forms, at least one of them partitioned."""
    if isinstance(left, Polynomial):
        left = beside(left, right.rows, 0)
    if isinstance(right, Polynomial):
        right = beside(right, left.cols, 1)
    if not same(left.cols, right.rows):
        raise ShapeError(f"cannot multiply blocks {left.cols} by {right.rows}")
    columns = list(zip(*right.entries))

    def entry(row, column):
        terms = [x @ y for x, y in zip(row, column)]
        return sum(terms[1:], terms[0])

    grid = [[entry(row, column) for column in columns] for row in left.entries]
    return grid[0][0] if len(grid) == len(grid[0]) == 1 else Blocks(left.algebra, grid)
