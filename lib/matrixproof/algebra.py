"""Normal forms: polynomials in matrices, traces of them, and matrices in blocks.

An `Algebra` multiplies expressions out and differentiates them.  It knows which symbols
are symmetric, and nothing else of them.

SymPy's `block_collapse` is wrong when an identity meets a partitioned matrix
(sympy #22034), so it is not used: blocks are normal forms and we multiply them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .families import (
    in_turn,
    refuse_captured,
    settled,
    sums,
)
from .families import product as joined
from .symbols import (
    BlockMatrix,
    Identity,
    MatrixProduct,
    MatrixSum,
    MatrixSymbol,
    Member,
    Own,
    Symmetric,
    ZeroMatrix,
)
from .typeset import latex
from .words import (
    Formula,
    Letter,
    Shape,
    ShapeError,
    Size,
    Symbols,
    Terms,
    Word,
    cancelled,
    exact,
    gather,
    rotations,
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
            joined(v, c, w, d)
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
        one = Identity(self.shape[0])
        terms = ((c, [x.as_expr() for x in w] or [one]) for w, c in self.ordered())
        return MatrixSum(*(MatrixProduct(c, *factors) for c, factors in terms))


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


KINDS = MatrixSymbol, Member, Own, Symmetric, sp.MatrixSymbol  # of letters


class Algebra:
    """Symbols, of which some equal their transpose; nothing else is known of them.

    Parameters
    ----------
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose.

    Notes
    -----
    A symbol X may be inverted by writing ``X.I``; X times X.I cancels.  A composite
    must be named first.  What follows from relations is found by `prove`.
    """

    def __init__(self, symmetric: Symbols = ()) -> None:
        self.symmetric = frozenset(symmetric)

    # -- words ------------------------------------------------------------------

    def letter(
        self, atom: sp.MatrixSymbol, transposed: bool = False, inverted: bool = False
    ) -> Letter:
        return Letter(atom, transposed and atom not in self.symmetric, inverted)

    def flipped(self, word: Word) -> Word:
        """The transpose of a word."""
        return tuple(self.letter(a, not t, i) for a, t, i in reversed(word))

    def reduced(self, pairs: Terms) -> Terms:
        """(word, coefficient) pairs in which what meets its own inverse is gone."""
        return settled((cancelled(word), c) for word, c in pairs)

    def reduced_cyclically(self, pairs: Terms) -> Terms:
        """The same for traces: modulo cyclic shift and transposition."""
        for word, c in pairs:
            short = cancelled(word, cyclic=True)
            if short:
                turned = rotations(short) + rotations(self.flipped(short))
                if len(sums(c)) > 1:  # an index is named where it occurs first
                    yield min((in_turn(w, c) for w in turned), key=of_word)
                else:
                    yield min(turned, key=spelling), c
            else:  # the trace of what has become the identity is its size
                yield short, c * word[0].rows if word else c

    def depends(self, atom: sp.MatrixSymbol) -> set[str]:
        """The indices on which a letter depends."""
        return {atom.index} if isinstance(atom, Member) else set()

    def spelled(self, expr: Formula) -> Formula:
        """An expression as it is shown; nothing stands for anything else here."""
        return expr

    # -- SymPy in ---------------------------------------------------------------

    def normal(self, expr: Formula) -> Any:
        """Normal form of a SymPy expression: `Polynomial`, `Blocks` or `Traces`."""
        if isinstance(expr, (Polynomial, Blocks, Traces)):
            return self._adopted(expr)
        exact(expr)
        if isinstance(expr, MatrixExpr):
            return self._matrix(expr)
        return self._scalar(sp.sympify(expr))

    def _adopted(self, value):
        """A normal form of this algebra, or of one that knows no more than this."""
        known = value.algebra
        if known is self or known.symmetric == self.symmetric:
            return value
        if extra := sorted(known.symmetric - self.symmetric, key=str):
            raise ValueError(
                f"a normal form made with {extra[0]} symmetric is not one of this "
                "algebra, which does not know that; give the expression itself"
            )
        return self.normal(value.as_expr())

    def _matrix(self, expr):
        if isinstance(expr, sp.BlockMatrix):
            return Blocks.of(self, expr.blocks.tolist())
        if isinstance(expr, sp.MatAdd):
            return self._sum([self.normal(a) for a in expr.args])
        if isinstance(expr, sp.MatMul):
            return self._product(expr.args)
        if isinstance(expr, sp.Transpose):
            return self.normal(expr.arg).T
        if isinstance(expr, (sp.Inverse, sp.MatPow)):
            return self._power(expr.base, expr.exp)
        if isinstance(expr, sp.Identity):
            return Polynomial(self, [((), 1)], expr.shape)
        if isinstance(expr, sp.ZeroMatrix) or 0 in expr.shape:
            return Polynomial(self, [], expr.shape)
        if isinstance(expr, sp.MatrixSymbol):
            if type(expr) not in KINDS:
                raise TypeError(
                    f"{expr} is a {type(expr).__name__}, which may compute what is "
                    "written with it: use the letters of this package, or SymPy's"
                )
            return Polynomial(self, [((self.letter(expr),), 1)], expr.shape)
        raise TypeError(f"no normal form for {type(expr).__name__}: {expr}")

    def _sum(self, values):
        values.sort(key=lambda value: not isinstance(value, Blocks))
        total = values[0]
        for value in values[1:]:
            total = total + value
        return total

    def _product(self, args):
        total, scale = None, sp.S.One
        for a in args:
            if not isinstance(a, MatrixExpr):
                scale *= a
                continue
            a = self.normal(a)
            if total is None:
                total = a
                continue
            refuse_captured(total, a)
            if isinstance(total, Blocks) or isinstance(a, Blocks):
                total = product(total, a)
            else:
                total = total @ a
        if scale.has(sp.Trace):
            raise TypeError("a trace times a matrix has no normal form")
        return scale * total

    def _power(self, base, exponent):
        if not exponent.is_Integer or exponent == 0:
            raise TypeError(f"no normal form for the power {exponent}")
        factor = self._inverted(base) if exponent < 0 else self.normal(base)
        total = factor
        for _ in range(abs(int(exponent)) - 1):
            refuse_captured(total, factor)
            total = total @ factor
        return total

    def _inverted(self, base):
        """The inverse of a product of square symbols, each inverted in turn."""
        value = self.normal(base)
        if not same_size(*value.shape):
            raise ShapeError(f"{base} of shape {value.shape} has no inverse")
        if isinstance(value, Blocks) or len(value.terms) != 1:
            raise TypeError(f"name the composite before inverting it: {base}")
        ((word, c),) = value.terms.items()
        if not all(same_size(*x.atom.shape) for x in word):
            raise TypeError(f"name the composite before inverting it: {base}")
        turned = tuple(x._replace(inverted=not x.inverted) for x in reversed(word))
        return value.like([(turned, 1 / c)])

    def _scalar(self, expr):
        for found in expr.atoms(sp.Determinant):
            if not same_size(*found.arg.shape):
                raise ShapeError(f"{found.arg} is not square: it has no determinant")
        if isinstance(expr, sp.Add):
            return sum((self._scalar(a) for a in expr.args), Traces(self, []))
        if isinstance(expr, sp.Trace):
            return self.normal(expr.arg).trace()
        traces = [a for a in sp.Mul.make_args(expr) if a.has(sp.Trace)]
        if not traces:
            return Traces(self, [((), expr)])
        if len(traces) > 1 or not isinstance(traces[0], (sp.Trace, sp.Add)):
            raise TypeError(f"not linear in traces: {expr}")
        return (expr / traces[0]) * self._scalar(traces[0])

    # -- calculus ---------------------------------------------------------------

    def differential(self, expr: Formula, increments: dict[Any, Any]) -> Any:
        """First differential; `increments` is {symbol: its increment, a symbol}."""
        for x, dx in increments.items():
            if not all(isinstance(s, sp.MatrixSymbol) for s in (x, dx)):
                raise TypeError(f"{dx} is no increment of {x}: both must be letters")
            if isinstance(x, Member):
                raise TypeError(f"{x} is one of a family: the others would stay")
            if not same_shape(x.shape, dx.shape):
                raise ShapeError(f"{dx} {dx.shape} is no increment of {x} {x.shape}")
        value = self.normal(expr)
        if isinstance(value, Blocks):
            return value.map(lambda entry: self.differential(entry, increments))
        pairs = []
        for word, c in value.terms.items():
            for i, x in enumerate(word):
                if x.atom not in increments:
                    continue
                d = (self.letter(increments[x.atom], x.transposed),)
                sign = -1 if x.inverted else 1  # d X^-1 = -X^-1 dX X^-1
                d = (x, *d, x) if x.inverted else d
                pairs.append((word[:i] + d + word[i + 1 :], sign * c))
        return value.like(pairs)

    def gradient(self, scalar: Formula, X: sp.MatrixSymbol) -> Polynomial:
        """The matrix g with d scalar = tr(g' dX); symmetric if X is.

        SymPy's own derivative of a sum of traces is 0 (sympy #26561), hence this.
        """
        if not isinstance(X, sp.MatrixSymbol):
            raise TypeError(f"a gradient is taken in a letter, and {X} is none")
        dX = Own(f"d{X.name}", *X.shape)
        while dX in self.normal(scalar).atoms():
            dX = Own(f"{dX.name}'", *X.shape)
        moved = self.differential(self.normal(scalar), {X: dX})
        pairs = []
        for word, c in moved.terms.items():
            (i,) = (i for i, x in enumerate(word) if x.atom == dX)
            rest = word[i + 1 :] + word[:i]
            pairs.append((rest if word[i].transposed else self.flipped(rest), c))
        found = Polynomial(self, pairs, X.shape)
        return sp.S.Half * (found + found.T) if X in self.symmetric else found


def of_word(pair):
    """The spelling of the word of a (word, coefficient) pair."""
    return spelling(pair[0])
