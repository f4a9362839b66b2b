"""Normal forms: matrix polynomials and linear combinations of traces."""

from __future__ import annotations

from typing import Any

import sympy as sp

from .symbols import Identity, MatrixProduct, MatrixSum, ZeroMatrix
from .typeset import latex
from .words import (
    Formula,
    Shape,
    ShapeError,
    Terms,
    gather,
    same_shape,
    same_size,
    spelling,
)


class Normal:
    """What all normal forms share: `algebra`, `+`, and `as_expr` back to SymPy."""

    def __neg__(self):
        return -1 * self

    def __sub__(self, other):
        return self + (-self.algebra.normal(other))

    def __repr__(self):
        return str(self.algebra.spelled(self.as_expr()))

    def _repr_latex_(self):
        return f"$\\displaystyle {latex(self.as_expr())}$"


class Sum(Normal):
    """A linear combination of words; what the two normal forms share."""

    def __init__(self, algebra, terms):
        self.algebra = algebra
        self.terms = terms

    @property
    def is_zero(self):
        return not self.terms

    def atoms(self):
        """The symbols that occur."""
        return {letter.atom for word in self.terms for letter in word}

    def ordered(self):
        """(word, coefficient) pairs in an order that does not change between runs."""
        return sorted(
            self.terms.items(), key=lambda term: (len(term[0]), spelling(term[0]))
        )

    def __rmul__(self, scalar):
        return self.like((w, scalar * c) for w, c in self.terms.items())

    def __radd__(self, other):
        return self.algebra.normal(other) + self

    def __rsub__(self, other):
        return self.algebra.normal(other) - self

    def __eq__(self, other):
        return (self - other).is_zero

    __hash__ = None  # type: ignore[assignment]


class Polynomial(Sum):
    """A matrix as a polynomial in non-commuting symbols, `terms` {word: coefficient}.

    Two expressions are equal when their difference has no terms.
    """

    def __init__(self, algebra: Any, pairs: Terms, shape: Shape) -> None:
        terms = {} if 0 in shape else gather(algebra.reduced(pairs))
        super().__init__(algebra, terms)
        self.shape = tuple(shape)

    def like(self, pairs: Terms) -> Polynomial:
        return Polynomial(self.algebra, pairs, self.shape)

    @property
    def is_scaled_identity(self) -> bool:
        """True for c I with a number c, zero included."""
        return all(word == () for word in self.terms)

    def __add__(self, other):
        other = self.algebra.normal(other)
        if not isinstance(other, Polynomial):
            return other + self
        if not same_shape(self.shape, other.shape):
            raise ShapeError(f"cannot add {self.shape} and {other.shape}")
        return self.like([*self.terms.items(), *other.terms.items()])

    def __matmul__(self, other):
        other = self.algebra.normal(other)
        if not isinstance(other, Polynomial):
            return NotImplemented
        if not same_size(self.shape[1], other.shape[0]):
            raise ShapeError(f"cannot multiply {self.shape} by {other.shape}")
        pairs = (
            (v + w, c * d)
            for v, c in self.terms.items()
            for w, d in other.terms.items()
        )
        return Polynomial(self.algebra, pairs, (self.shape[0], other.shape[1]))

    @property
    def T(self) -> Polynomial:
        pairs = ((self.algebra.flipped(w), c) for w, c in self.terms.items())
        return Polynomial(self.algebra, pairs, self.shape[::-1])

    def trace(self) -> Traces:
        if not same_size(*self.shape):
            raise ShapeError(f"a matrix of shape {self.shape} has no trace")
        size = self.shape[0]
        return Traces(
            self.algebra, ((w, c if w else c * size) for w, c in self.terms.items())
        )

    def as_expr(self) -> Formula:
        """Back to SymPy."""
        if not self.terms:
            return ZeroMatrix(*self.shape)
        return MatrixSum(*(self._term(word, c) for word, c in self.ordered()))

    def _term(self, word, c):
        one = () if word else (Identity(self.shape[0]),)
        return MatrixProduct(c, *(x.as_expr() for x in word), *one)


class Traces(Sum):
    """A scalar: traces of words, each word up to cyclic shift and transposition.

    The empty word stands for 1, so a term in the sizes alone can be kept as well.
    """

    def __init__(self, algebra: Any, pairs: Terms) -> None:
        super().__init__(algebra, gather(algebra.reduced_cyclically(pairs)))

    def like(self, pairs: Terms) -> Traces:
        return Traces(self.algebra, pairs)

    def __add__(self, other):
        other = self.algebra.normal(other)
        if not isinstance(other, Traces):
            raise ShapeError("cannot add a scalar and a matrix")
        return self.like([*self.terms.items(), *other.terms.items()])

    def as_expr(self) -> Formula:
        """Back to SymPy."""
        return sp.Add(
            *(
                c * sp.Trace(MatrixProduct(*(x.as_expr() for x in word))) if word else c
                for word, c in self.ordered()
            )
        )
