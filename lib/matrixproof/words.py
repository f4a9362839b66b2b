"""Words: products of matrix symbols, each perhaps transposed or inverted."""

from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

import sympy as sp
from sympy.logic.boolalg import BooleanAtom
from sympy.matrices.exceptions import NonInvertibleMatrixError, NonSquareMatrixError

Formula = Any  # of SymPy: a matrix, a scalar or a number; or the normal form of one
Size: TypeAlias = int | sp.Expr
Shape = tuple[Size, ...]
Values = dict[sp.Basic, Any]  # of symbols, in a model


class ShapeError(NonSquareMatrixError, NonInvertibleMatrixError):
    """The shapes of a sum, product or trace do not fit, at symbolic sizes.

    SymPy, too, takes it for its own refusal of a shape; it is a ValueError.
    """


class Letter(NamedTuple):
    """One factor of a word.  A word is a tuple of letters; () is the identity."""

    atom: sp.MatrixSymbol
    transposed: bool = False
    inverted: bool = False

    @property
    def rows(self) -> Size:
        return self.atom.shape[1 if self.transposed else 0]

    def as_expr(self) -> sp.MatrixExpr:
        expr = self.atom.I if self.inverted else self.atom
        return expr.T if self.transposed else expr

    def __str__(self):
        mark = "^-1" if self.inverted else ""
        return self.atom.name + mark + ("'" if self.transposed else "")


Word = tuple[Letter, ...]
Terms = Iterable[tuple[Word, Any]]  # with their coefficients
Symbols = Iterable[sp.MatrixSymbol]


def is_letter(expr: Any) -> bool:
    """Whether an expression is a letter, for a matrix or for a number."""
    return isinstance(expr, sp.MatrixSymbol | sp.Symbol)


def spelling(word):
    """A word as a string: what words are ordered and printed by."""
    return " ".join(str(letter) for letter in word)


def rotations(word):
    """The word and its cyclic shifts."""
    return [word[i:] + word[:i] for i in range(max(len(word), 1))]


def cancelled(word, cyclic=False):
    """The word without what stands beside its own inverse; in a trace, also the ends.

    >>> A, B = (Letter(sp.MatrixSymbol(name, 2, 2)) for name in "AB")
    >>> spelling(cancelled((A, B, A._replace(inverted=True)), cyclic=True))
    'B'
    """
    found = []
    for x in word:
        if found and found[-1] == x._replace(inverted=not x.inverted):
            found.pop()
        else:
            found.append(x)
    while cyclic and len(found) > 1 and cancelled((found[-1], found[0])) == ():
        found = found[1:-1]
    return tuple(found)


def exact(expr, real=True):
    """The expression, if its numbers are exact, and real where that is asked.

    >>> exact(sp.Float(0.1) * sp.Symbol("t"))
    Traceback (most recent call last):
        ...
    TypeError: 0.1 is a float, which is not exact; write Rational(1, 10)
    """
    whole = expr.as_immutable() if isinstance(expr, sp.MatrixBase) else expr
    refuse_truth(whole, "a formula")
    if complaint := _inexact(whole, real):
        raise TypeError(complaint)
    return expr


@lru_cache(20_000, typed=True)
def _inexact(expr, real):
    """What is wrong with the first of its numbers that is not exact, or not real."""
    for x in sp.preorder_traversal(sp.sympify(expr)):
        if isinstance(x, sp.Float) and x.is_finite:
            q = sp.Rational(str(float(x)))
            better = q.p if q.q == 1 else f"Rational({q.p}, {q.q})"
            return f"{float(x)!r} is a float, which is not exact; write {better}"
        if not isinstance(x, sp.Number | sp.NumberSymbol | sp.Symbol | type(sp.I)):
            continue
        if x in (sp.nan, sp.zoo) or getattr(x, "is_infinite", None):
            return f"{x} is not a number"
        if x.is_commutative is False:
            return f"{x} does not commute, as numbers do here"
        declared = x.is_extended_real is None and x.is_complex
        if real and (declared or x.is_extended_real is False):
            return f"{x} is not real, as numbers are here"
    return ""


def plain(expr):
    """A SymPy expression; a normal form is written out."""
    return expr.as_expr() if hasattr(expr, "algebra") else sp.sympify(expr)


def refuse_truth(step: Any, what: str) -> None:
    """Raise for the outcome of a comparison, which would be taken for 0.

    >>> refuse_truth(sp.Symbol("a") == sp.Symbol("b"), "a step")
    Traceback (most recent call last):
        ...
    TypeError: a step is False, the outcome of a comparison, which proves nothing: \
write Claim(left, right) or Equation(left, right) instead of ==
    """
    kind = str(getattr(step, "dtype", ""))  # of NumPy
    if isinstance(step, bool | BooleanAtom) or kind == "bool":
        raise TypeError(
            f"{what} is {step}, the outcome of a comparison, which proves nothing: "
            "write Claim(left, right) or Equation(left, right) instead of =="
        )


def kept(values: Mapping[Any, Any]) -> Mapping[Any, Any]:
    """Values that do not change when what they were made from does."""
    fixed = {
        s: x.as_immutable() if isinstance(x, sp.MatrixBase) else x
        for s, x in values.items()
    }
    return MappingProxyType(fixed)


def denied(symbol, value):
    """What a number says against what is assumed of its letter; "" if nothing.

    >>> denied(sp.Symbol("t", positive=True), 0), denied(sp.Symbol("t"), 0)
    ('t = 0 is not positive', '')
    """
    value = sp.sympify(value)
    told = symbol.assumptions0 if isinstance(symbol, sp.Symbol) else {}
    for what in ("positive", "negative", "nonnegative", "nonpositive", *sorted(told)):
        if what in told and getattr(value, f"is_{what}") is (not told[what]):
            return f"{symbol} = {value} is {'not ' if told[what] else ''}{what}"
    return ""


def same_size(a, b):
    """Whether two sizes, numbers or expressions, are provably equal."""
    return a is b or _same_size(a, b)


@cache
def _same_size(a, b):
    return a == b or sp.expand(a - b) == 0


def same_shape(a, b):
    return same_size(a[0], b[0]) and same_size(a[1], b[1])


def gather(pairs):
    """Sum (word, coefficient) pairs into a dict without zero coefficients."""
    terms = {}
    for word, coefficient in pairs:
        terms[word] = terms[word] + coefficient if word in terms else coefficient
    return {w: c for w, c in ((w, tidy(c)) for w, c in terms.items()) if c != 0}


def tidy(coefficient):
    """A coefficient multiplied out, so that what is zero is seen to be."""
    known = isinstance(coefficient, (int, sp.Rational))
    return sp.sympify(coefficient) if known else sp.expand(coefficient)
