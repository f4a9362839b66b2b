"""A statement at explicit sizes: letters for the matrices, symbols for their entries.

What is no identity of matrices of any size, such as a pattern of zeros, a product of
polynomials or a count, is written in letters as well, evaluated and shown.
"""

from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import ClassVar

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .chains import framed
from .claims import Claim
from .models import sizes_of
from .prose import plain
from .reasons import words
from .typeset import columns, latex, padded, text
from .words import Formula, denied, exact, kept

LISTED = 6  # choices that are named; of more, the first three
WIDEST_LINE = 72  # characters; a wider matrix has a line for each row
LATEX_MARKS = {"✓": r"\checkmark", "(✓)": r"(\checkmark)", "✗": r"\times"}


@dataclass(frozen=True, eq=False, repr=False)
class Explicit:
    """`left = right` at explicit matrices, at one or at several sizes.

    Parameters
    ----------
    number, says : str
        As for a `Chain`.
    left, right : expression
        In letters of any size, or scalars.
    cases : dict of str to dict of MatrixSymbol to Matrix
        {what is chosen: the values of the letters}; entries may be symbols.  A letter
        may be a number or a function of one, too.  The first choice is shown.
    why : str
        Words for the reason.

    Examples
    --------
    >>> from sympy import Matrix, symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> S, v = MatrixSymbol("S", n, n), MatrixSymbol("v", n, 1)
    >>> a, b = symbols("a b")
    >>> turned = {S: Matrix([[0, 1], [1, 0]]), v: Matrix([a, b])}
    >>> swap = Explicit("", "a swap undoes itself", S * S * v, v, {"n = 2": turned})
    >>> swap.check()
    []
    >>> print(swap)
    a swap undoes itself
      S S v = v
        S = [0 1; 1 0]
        v = [a; b]
        evaluated for n = 2  (✓)

    The mark in brackets says that it is so at these sizes, and not proved for all.
    """

    number: str
    says: str
    left: Formula
    right: Formula
    cases: dict = field(default_factory=dict)
    why: str = ""

    sign: ClassVar[str] = "="
    latex_sign: ClassVar[str] = "="
    fault: ClassVar[str] = "the sides differ"
    relations: ClassVar[tuple] = ()

    def __post_init__(self):
        fixed = {name: kept(values) for name, values in self.cases.items()}
        object.__setattr__(self, "cases", MappingProxyType(fixed))

    @property
    def expressions(self) -> list[Formula]:
        """Both sides, and the letters that have values."""
        return [self.left, self.right, *self._shown]

    @cached_property
    def claims(self) -> dict[str, Claim]:
        """The `Claim` that is evaluated, for each thing that is chosen."""
        return {
            name: self.claim(value(self.left, chosen), value(self.right, chosen))
            for name, chosen in (self.cases or {"": {}}).items()
        }

    def claim(self, left: Formula, right: Formula) -> Claim:
        """What must be so at one choice."""
        return Claim(left, right)

    def check(self) -> list[str]:
        """What is wrong; [] when the statement holds wherever it is evaluated."""
        return list(self._faults)

    @cached_property
    def _faults(self):
        try:
            return [
                f"{self.fault}{f' for {name}' if name else ''}"
                for name, claim in self.claims.items()
                if not claim.is_zero
            ]
        except (TypeError, ValueError) as e:
            return [f"cannot be evaluated: {e}"]

    # -- shown ------------------------------------------------------------------------

    @property
    def mark(self) -> str:
        """✓ or ✗; (✓) where letters of any size have some sizes only."""
        sizes = (d for chosen in self.cases.values() for x in chosen for d in shape(x))
        right = "(✓)" if any(sp.sympify(d).free_symbols for d in sizes) else "✓"
        return "✗" if self.check() else right

    @property
    def _shown(self):
        return next(iter(self.cases.values()), {})

    def reason(self) -> str:
        """The reason in words, and for what it was evaluated."""
        names = [name for name in self.cases if name]
        if len(names) > LISTED:
            names = [*names[:3], f"{len(names) - 3} more"]
        where = f"evaluated for {'; '.join(names)}" if names else ""
        return ", ".join(filter(None, [self.why, where])) or "evaluated"

    def __str__(self):
        title = f"({self.number}) {self.says}" if self.number else self.says
        out = [title, f"  {text(self.left)} {self.sign} {text(self.right)}"]
        out += [line for pair in self._shown.items() for line in rows_of(*pair)]
        out.append(f"    {plain(self.reason())}  {self.mark}")
        return "\n".join([*out, *(f"  {fault}" for fault in self.check())])

    __repr__ = __str__

    def _repr_latex_(self):
        mark = LATEX_MARKS[self.mark]
        rows = [f"{latex(self.left)} &{self.latex_sign} {latex(self.right)}"]
        rows += [f"{latex(s)} &= {latex(v)}" for s, v in self._shown.items()]
        rows.append(f"&{words(self.reason())} && {mark}")
        return framed(rows, self.number)


class Positive(Explicit):
    """`left > right` at explicit values, in every entry of a row or a column.

    Of any other matrix it is refused, since M > 0 is read as M is positive definite.

    >>> from sympy import symbols
    >>> a, b = symbols("a b", positive=True)
    >>> print(Positive("", "a sum", a + b, 0))
    a sum
      a + b > 0
        evaluated  ✓
    >>> Positive("", "a difference", a - b, 0).check()
    ['not every entry is known to be positive']
    """

    sign: ClassVar[str] = ">"
    latex_sign: ClassVar[str] = ">"
    fault: ClassVar[str] = "not every entry is known to be positive"

    def claim(self, left: Formula, right: Formula) -> Claim:
        """How many entries are not positive for sure, which must be none."""
        found = left - right if right != 0 else left
        entries = found if isinstance(found, sp.MatrixBase) else [found]
        if not len(entries):
            raise ValueError("a statement about an empty matrix says nothing")
        if isinstance(found, sp.MatrixBase) and 1 not in found.shape:
            raise ValueError(
                f"of a {found.rows} x {found.cols} matrix it is not said what > means: "
                "give its entries as a row or a column"
            )
        positive = (sp.factor(sp.simplify(x)).is_positive for x in entries)
        return Claim(sp.Integer(sum(not so for so in positive)))

    def reason(self) -> str:
        """The same; between rows or columns it is said what the sign means."""
        entries = value(self.left, self._shown)
        several = isinstance(entries, sp.MatrixBase) and len(entries) > 1
        return ("every entry, " if several else "") + super().reason()


def shape(letter):
    return getattr(letter, "shape", ())


def rows_of(symbol, matrix):
    """`symbol = matrix` in Unicode: on one line, or one line for each row."""
    line = f"    {text(symbol)} = {text(matrix)}"
    if columns(line) <= WIDEST_LINE or not hasattr(matrix, "tolist"):
        return [line]
    cells = [[text(x) for x in row] for row in matrix.tolist()]
    wide = [max(map(columns, column)) for column in zip(*cells)]
    head = f"    {text(symbol)} = "
    shown = ["  ".join(map(padded, row, wide)).rstrip() for row in cells]
    return [head + shown[0], *(" " * columns(head) + row for row in shown[1:])]


def value(expr, values):
    """An expression at explicit matrices, whose entries may be symbols.

    The sizes follow from the shapes.

    Raises
    ------
    ValueError
        The shapes do not fit, or leave a size open that the expression has.
    """
    for x in (expr, *values.values()):
        exact(x, real=False)
    for symbol, x in values.items():
        if says := denied(symbol, x):
            raise ValueError(says)
    sizes, free = sizes_of(values)
    if says := [why for pair in sizes.items() if (why := denied(*pair))]:
        raise ValueError(says[0])
    put = {symbol: sp.sympify(x) for symbol, x in values.items()}
    found = sp.sympify(expr)
    for size in sorted(symbols_beside(found, put) & set(sizes), key=str):
        if size in free:
            raise ValueError(f"no value says what the size {size} is")
    found = made_one(found.xreplace({**put, **sizes})).doit()
    if getattr(found, "is_Matrix", False):
        return found.as_explicit().applyfunc(sp.expand)
    return found


def symbols_beside(expr, values):
    """The symbols of an expression outside of the letters that have values."""
    if expr in values or isinstance(expr, sp.Symbol):
        return {expr} - set(values)
    return set().union(*(symbols_beside(arg, values) for arg in expr.args))


def made_one(expr):
    """Sums and products of explicit matrices made one, also inside of a determinant."""
    if isinstance(expr, sp.MatrixBase) or not expr.has(MatrixExpr, sp.MatrixBase):
        return expr
    if isinstance(expr, sp.BlockMatrix):
        rows = [[made_one(block) for block in row] for row in expr.blocks.tolist()]
        return sp.BlockMatrix(rows).as_explicit()
    if not isinstance(expr, sp.MatrixSymbol | sp.Identity | sp.ZeroMatrix):
        expr = expr.func(*map(made_one, expr.args))
    return expr.doit().as_explicit() if isinstance(expr, MatrixExpr) else expr
