"""Matrix symbols whose expressions stay as they are written.

SymPy sorts the terms of a sum and cancels what it can before anybody looks: to it
X X^-1 is I for X that is not square, and A I is A whatever the size of I.  The classes
here have SymPy's names and print as SymPy's do, but sums, products, transposes and
inverses of them are kept, in the order in which they were written, and every shape is
checked at once.  `doit()` hands an expression to SymPy, as after explicit matrices
have been put in.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.core.symbol import Str
from sympy.matrices.expressions.matexpr import MatrixExpr
from sympy.printing.precedence import PRECEDENCE

from .words import ShapeError, same_shape, same_size


class Operators:
    """What `+ - * / **`, `.T` and `.I` build: expressions that are not evaluated."""

    _op_priority = 12.0  # before SymPy's own, where one side is SymPy's

    def __add__(self, other):
        return MatrixSum(self, other)

    def __radd__(self, other):
        return self if isinstance(other, int) and other == 0 else MatrixSum(other, self)

    def __neg__(self):
        return MatrixProduct(-1, self)

    def __sub__(self, other):
        return MatrixSum(self, MatrixProduct(-1, other))

    def __rsub__(self, other):
        return (
            -self if isinstance(other, int) and other == 0 else MatrixSum(other, -self)
        )

    def __mul__(self, other):
        if isinstance(other, MatrixExpr) and closed(self, [other]):
            if other.has(Over):
                return MatrixProduct(self, other)
            return MatrixProduct(*self.args, other)  # the sum goes on to the right
        return MatrixProduct(self, other)

    def __rmul__(self, other):
        return MatrixProduct(other, self)

    __matmul__, __rmatmul__ = __mul__, __rmul__

    def __truediv__(self, other):
        return MatrixProduct(1 / sp.sympify(other), self)

    def __pow__(self, exponent):
        exponent = sp.sympify(exponent)
        if exponent == -1:
            return self.I
        power = MatrixPower(self, exponent)
        if exponent == 0:
            return Identity(self.rows)
        return self if exponent == 1 else power

    @property
    def T(self):
        return MatrixTranspose(self)

    @property
    def I(self):  # noqa: E743
        return MatrixInverse(self)

    def transpose(self):
        return self.T

    def inverse(self):
        return self.I

    inv = inverse


class MatrixSymbol(Operators, sp.MatrixSymbol):
    """A matrix with a name and a size; sizes may be symbols.

    Raises
    ------
    ShapeError
        From an expression that is built with it, if shapes are not provably equal, or
        from `.I` if it is not provably square.  The message names both shapes.

    Examples
    --------
    >>> from matrixproof import Identity, letters
    >>> X, K = letters("X:n*m K:m*n")
    >>> X * K + Identity(X.rows)
    X*K + I
    >>> X.I
    Traceback (most recent call last):
        ...
    matrixproof.words.ShapeError: X is (n, m), not square: it has no inverse
    """


class Symmetric(MatrixSymbol):
    """A letter that equals its transpose."""

    def __new__(cls, name, n, m):
        _square(sp.MatrixSymbol(name, n, m), "it is not symmetric")
        return super().__new__(cls, name, n, m)

    @property
    def T(self) -> Symmetric:
        return self


class Own(MatrixSymbol):
    """A letter that an algebra makes: equal to none of yours, whatever it is called."""


class Member(MatrixSymbol):
    """A letter with an index: it stands for each member of a family.

    Parameters
    ----------
    name : str
        As programs know it.
    n, m : int or expression
        Rows and columns, of every member.
    index : str
    family : str
        Its name on a page, without the index.  The name `A_i` has it in itself.
    """

    def __new__(cls, name: Any, n: Any, m: Any, index: Any, family: Any = "") -> Member:
        plain = sp.MatrixSymbol(str(name), n, m)
        family = str(family) or str(name).removesuffix(f"_{index}")
        made: Member = sp.Basic.__new__(cls, *plain.args, Str(str(index)), Str(family))
        return made

    def _sympystr(self, _: Any) -> str:
        return self.shown_name

    @property
    def index(self) -> str:
        return str(self.args[3])

    @property
    def other(self) -> Any:
        """Another member, for what is said of two that differ.

        >>> from matrixproof import letters, text
        >>> sum_i, x_i = letters("sum_i x_i:n")
        >>> print(text(x_i * x_i.other.T))
        x_i x_j'
        """
        return at(self, self.index + "'")

    @property
    def shown_name(self) -> str:
        """Its name on a page, with its index below."""
        return f"{self.args[4]}_{shown(self.index)}"


def at(member: Member, index: str) -> Member:
    """The member of the same family at another index."""
    name, n, m, _, family = member.args
    return Member(name, n, m, index, family)


def first(letter: Any) -> Any:
    """A letter; of the members of a family, the one that stands for all."""
    if not isinstance(letter, Member):
        return letter
    return at(letter, letter.index.rstrip("'"))


class Over(sp.Symbol):
    """The sign of a sum over an index, named `sum_i`.

    Where matrices are sought for which something holds, it is how many members there
    are, all of them equal.
    """

    def __new__(cls, name: str, **_: Any) -> Over:
        return super().__new__(cls, name, integer=True, nonnegative=True)

    @property
    def index(self) -> str:
        return self.name.removeprefix("sum_")

    @property
    def shown_index(self) -> str:
        return shown(self.index)


def shown(index):
    """An index as it stands on a page: a copy of i is j.

    >>> shown("i"), shown("i'")
    ('i', 'j')
    """
    family = index.rstrip("'")
    return family[:-1] + chr(ord(family[-1]) + len(index) - len(family))


class Identity(Operators, sp.Identity):
    """The identity matrix of a size."""

    @property
    def T(self) -> Identity:
        return self

    @property
    def I(self) -> Identity:  # noqa: E743
        return self


class ZeroMatrix(Operators, sp.ZeroMatrix):
    """The zero matrix of a shape."""

    @property
    def T(self) -> ZeroMatrix:
        return ZeroMatrix(self.cols, self.rows)


class BlockMatrix(Operators, sp.BlockMatrix):
    """A partitioned matrix, from a list of rows of blocks."""

    @property
    def T(self) -> BlockMatrix:
        grid = self.blocks.tolist()
        return BlockMatrix([[block.T for block in column] for column in zip(*grid)])

    def _sympystr(self, printer):
        rows = self.blocks.tolist()
        return "[" + "; ".join(", ".join(map(printer._print, r)) for r in rows) + "]"


class MatrixSum(Operators, sp.MatAdd):
    """A sum in the order written; sums in it are opened, zero matrices left out."""

    def __new__(cls, *terms, **_):
        terms = [sp.sympify(term) for term in terms]
        for term in terms:
            if not isinstance(term, MatrixExpr | sp.MatrixBase):
                raise ShapeError(f"{term} is a scalar: it cannot be added to a matrix")
            if not same_shape(term.shape, terms[0].shape):
                raise ShapeError(
                    f"cannot add {brief(terms[0])} of shape {terms[0].shape} "
                    f"and {brief(term)} of shape {term.shape}"
                )
        parts = [
            x for t in terms for x in (t.args if isinstance(t, sp.MatAdd) else [t])
        ]
        kept = [x for x in parts if not isinstance(x, sp.ZeroMatrix)]
        if len(kept) > 1:
            return _node(cls, *kept)
        return kept[0] if kept else ZeroMatrix(*terms[0].shape)

    def _sympystr(self, printer):
        return joined_by_sign([printer._print(x) for x in self.args])

    def _latex(self, printer):
        return joined_by_sign([printer._print(x) for x in self.args])


class MatrixProduct(Operators, sp.MatMul):
    """A product in the order written; products in it are opened, numbers in front."""

    def __new__(cls, *factors, **_):
        number, matrices, factors = sp.S.One, [], tuple(map(sp.sympify, factors))
        for k, factor in enumerate(factors):
            others = factors[:k] + factors[k + 1 :]
            opened = isinstance(factor, sp.MatMul) and not closed(factor, others)
            for part in factor.args if opened else [factor]:
                if getattr(part, "is_Matrix", False):
                    matrices.append(part)
                else:
                    number = number * part
        for a, b in zip(matrices, matrices[1:]):
            if not same_size(a.shape[1], b.shape[0]):
                raise ShapeError(
                    f"cannot multiply {brief(a)} of shape {a.shape} "
                    f"by {brief(b)} of shape {b.shape}"
                )
        if not matrices:
            return number
        if number == 0:
            return ZeroMatrix(matrices[0].shape[0], matrices[-1].shape[1])
        if number == 1:
            return _node(cls, *matrices) if len(matrices) > 1 else matrices[0]
        return _node(cls, number, *matrices)

    def as_coeff_mmul(self):
        number, matrices = self.as_coeff_matrices()
        return number, _node(MatrixProduct, *matrices)

    def could_extract_minus_sign(self):
        return self.as_coeff_matrices()[0].could_extract_minus_sign()


def closed(factor: Any, others: Any) -> bool:
    """Whether a factor is a sum over an index that others have, too."""
    number = factor.args[0] if isinstance(factor, sp.MatMul) else sp.S.One
    if number.is_Number or number.is_Matrix or not number.has(Over):
        return False
    inside = {x.index for x in number.atoms(Over)}
    return any(x.index in inside for e in others for x in e.atoms(Over, Member))


class MatrixTranspose(Operators, sp.Transpose):
    """A transpose, of whatever was transposed."""

    precedence = PRECEDENCE["Pow"]

    def __new__(cls, matrix):
        return matrix.arg if isinstance(matrix, sp.Transpose) else _node(cls, matrix)


class MatrixInverse(Operators, sp.Inverse):
    """An inverse; what is inverted must be square at symbolic sizes."""

    precedence = PRECEDENCE["Pow"]

    def __new__(cls, matrix, exponent=-1):
        _square(matrix, "it has no inverse")
        return _node(cls, matrix, sp.S.NegativeOne)


class MatrixPower(Operators, sp.MatPow):
    """A power of a square matrix."""

    precedence = PRECEDENCE["Pow"]

    def __new__(cls, matrix, exponent, **_):
        _square(matrix, "it has no powers")
        return _node(cls, matrix, sp.sympify(exponent))


def brief(expr):
    """An expression in a message: its beginning, where it is long."""
    text = str(expr)
    return text if len(text) < 60 else text[:50] + " ..."


def joined_by_sign(terms):
    """Terms joined by their signs, in the order given."""
    text = terms[0]
    for term in terms[1:]:
        minus = term.startswith("-")
        text += " - " + term[1:].lstrip() if minus else " + " + term
    return text


def _node(cls, *args):
    return sp.Basic.__new__(cls, *args)


def _square(matrix, so):
    if not same_size(*matrix.shape):
        raise ShapeError(f"{matrix} is {matrix.shape}, not square: {so}")


def plus(*terms: sp.Expr) -> sp.Expr:
    """A sum of scalars, as of traces, in the order written.

    >>> from sympy import Trace
    >>> A, B = MatrixSymbol("A", 2, 2), MatrixSymbol("B", 2, 2)
    >>> from matrixproof import text
    >>> print(text(plus(Trace(B), Trace(A))))
    tr(B) + tr(A)
    """
    return sp.Add(*terms, evaluate=False)
