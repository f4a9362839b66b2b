"""The algebra: which symbols are symmetric, which relations hold, and calculus."""

from functools import cached_property
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .blocks import Blocks, product
from .polynomials import Polynomial, Traces
from .relations import Given, refuse_means
from .symbols import MatrixSymbol, Own, Symmetric
from .words import (
    Formula,
    Letter,
    ShapeError,
    Symbols,
    Terms,
    Word,
    exact,
    rotations,
    same_shape,
    same_size,
    text,
)

KINDS = MatrixSymbol, Own, Symmetric, sp.MatrixSymbol  # of letters
DEEPEST = 300  # rewritings of one word, one inside the other, before we give up


class Algebra:
    """Symbols with what is known of them.

    Parameters
    ----------
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose.
    relations : iterable of (left, right)
        Equations between matrix expressions.  The left side must be one product of
        symbols; wherever it occurs, also transposed and, in a trace, also across the
        cyclic seam, it is replaced by the right side.

    Notes
    -----
    A symbol X may be inverted by writing ``X.I``; X times X.I cancels.  A composite
    must be named first, which is no loss: solve its definition for another symbol
    and give that as a relation, e.g. ``(R, M - C * Omega * C.T)``.
    """

    def __init__(self, symmetric: Symbols = (), relations: Given = ()) -> None:
        self.symmetric = frozenset(symmetric)
        self.relations = tuple(relations)
        refuse_means(self.relations)
        self._known, self._known_cyclic = dict[Word, Any](), dict[Word, Any]()

    def __eq__(self, other):
        if not isinstance(other, Algebra):
            return NotImplemented
        return self._knows() == other._knows()

    def __hash__(self):
        return hash(self._knows())

    def _knows(self):
        return self.symmetric, frozenset(map(tuple, self.relations))

    @cached_property
    def _rules(self):
        """(word, {word: coefficient}) pairs, made when first needed."""
        plain = Algebra(self.symmetric) if self.relations else self
        rules = (plain._rule(left, right) for left, right in self.relations)
        return [rule for pair in rules for rule in pair]

    # -- words ------------------------------------------------------------------

    def letter(
        self, atom: sp.MatrixSymbol, transposed: bool = False, inverted: bool = False
    ) -> Letter:
        return Letter(atom, transposed and atom not in self.symmetric, inverted)

    def flipped(self, word: Word) -> Word:
        """The transpose of a word."""
        return tuple(self.letter(a, not t, i) for a, t, i in reversed(word))

    def _rule(self, left, right):
        left, right = self.normal(left), self.normal(right)
        if left.terms and left.is_scaled_identity:  # I = A B says what A B is
            left, right = right, left
        single = len(left.terms) == 1 and not left.is_scaled_identity
        if not (single and same_shape(left.shape, right.shape)):
            raise ShapeError(f"{left} = {right} is not a relation word = polynomial")
        ((word, c),) = left.terms.items()
        if sp.sympify(c).is_zero is not False:
            why = f"{c} may be zero; say that it is not, as Symbol(name, nonzero=True)"
            raise ValueError(f"{left} = {right} is no rule for {text(word)}: {why}")
        right = (1 / sp.sympify(c)) * right
        flipped = self.flipped(word)
        rules = [(word, right.terms)]
        return rules if flipped == word else [*rules, (flipped, right.T.terms)]

    def _rewritten(self, word):
        """{word: coefficient} after one rewriting, or None if nothing applies."""
        for i in range(len(word) - 1):
            a, b = word[i], word[i + 1]
            if a == (b.atom, b.transposed, not b.inverted):
                return {word[:i] + word[i + 2 :]: 1}
        for pattern, terms in self._rules:
            k = len(pattern)
            for i in range(len(word) - k + 1):
                if word[i : i + k] == pattern:
                    return {word[:i] + w + word[i + k :]: c for w, c in terms.items()}
        return None

    def _reduce(self, word, depth=0):
        """{word: coefficient} that no relation can simplify further."""
        if word not in self._known:
            if depth > DEEPEST:
                raise RecursionError(f"rewriting does not stop at {text(word)}")
            step = self._rewritten(word)
            self._known[word] = (
                {word: 1} if step is None else self._combine(step, self._reduce, depth)
            )
        return self._known[word]

    def _reduce_cyclic(self, word, depth=0):
        """The same for a trace: modulo cyclic shift and transposition."""
        if not word:
            return {(): 1}
        if word not in self._known_cyclic:
            if depth > DEEPEST:
                raise RecursionError(f"rewriting does not stop at tr {text(word)}")
            turned = rotations(word) + rotations(self.flipped(word))
            for w in turned:
                step = self._rewritten(w)
                if step is not None:
                    # the trace of what has become the identity is its size
                    step = {v: c if v else c * w[0].rows for v, c in step.items()}
                    done = self._combine(step, self._reduce_cyclic, depth)
                    break
            else:
                done = {min(turned, key=text): 1}
            self._known_cyclic[word] = done
        return self._known_cyclic[word]

    @staticmethod
    def _combine(terms, reduce, depth):
        total = {}
        for word, c in terms.items():
            for w, d in reduce(word, depth + 1).items():
                total[w] = total.get(w, 0) + c * d
        return total

    def reduced(self, pairs: Terms) -> Terms:
        """Rewrite each (word, coefficient) as far as the relations go."""
        return ((w, c * d) for word, c in pairs for w, d in self._reduce(word).items())

    def reduced_cyclically(self, pairs: Terms) -> Terms:
        cyclic = self._reduce_cyclic
        return ((w, c * d) for word, c in pairs for w, d in cyclic(word).items())

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
        if known is self or known == self:
            return value
        extra = [r for r in known.relations if r not in self.relations]
        extra += sorted(known.symmetric - self.symmetric, key=str)
        if extra:
            raise ValueError(
                f"a normal form made with {extra[0]} is not one of this algebra, "
                "which does not know that; give the expression itself"
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
