"""The algebra: normal forms, which symbols are symmetric, and calculus."""

from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .blocks import Blocks, product
from .polynomials import Polynomial, Traces
from .symbols import MatrixSymbol, Own, Symmetric
from .words import (
    Formula,
    Letter,
    ShapeError,
    Symbols,
    Terms,
    Word,
    cancelled,
    exact,
    rotations,
    same_shape,
    same_size,
    spelling,
)

KINDS = MatrixSymbol, Own, Symmetric, sp.MatrixSymbol  # of letters


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
        return ((cancelled(word), c) for word, c in pairs)

    def reduced_cyclically(self, pairs: Terms) -> Terms:
        """The same for traces: modulo cyclic shift and transposition."""
        for word, c in pairs:
            short = cancelled(word, cyclic=True)
            if short:
                turned = rotations(short) + rotations(self.flipped(short))
                yield min(turned, key=spelling), c
            else:  # the trace of what has become the identity is its size
                yield short, c * word[0].rows if word else c

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
            elif isinstance(total, Blocks) or isinstance(a, Blocks):
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
