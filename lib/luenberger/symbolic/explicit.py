"""A statement at explicit sizes: letters for the matrices, symbols for their entries.

What is no identity of matrices of any size, such as a pattern of zeros, a product of
polynomials or a count, is written in letters as well, evaluated and shown.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import sympy as sp

from .chains import framed
from .claims import Claim
from .models import sizes_that_fit
from .typeset import columns, latex, padded, text
from .words import Formula

LISTED = 6  # choices that are named; of more, the first three
WIDEST_LINE = 72  # characters; a wider matrix has a line for each row


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
    >>> from luenberger.symbolic import MatrixSymbol
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
        evaluated for n = 2  ✓
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
        return [
            f"{self.fault}{f' for {name}' if name else ''}"
            for name, claim in self.claims.items()
            if not claim.is_zero
        ]

    # -- shown ------------------------------------------------------------------------

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
        out.append(f"    {self.reason()}  {'✗' if self.check() else '✓'}")
        return "\n".join([*out, *(f"  {fault}" for fault in self.check())])

    __repr__ = __str__

    def _repr_latex_(self):
        mark = r"\times" if self.check() else r"\checkmark"
        rows = [f"{latex(self.left)} &{self.latex_sign} {latex(self.right)}"]
        rows += [f"{latex(s)} &= {latex(v)}" for s, v in self._shown.items()]
        rows.append(rf"&\text{{{self.reason()}}} && {mark}")
        return framed(rows, self.number)


class Positive(Explicit):
    """`left > right` at explicit values, in every entry.

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
        positive = (sp.factor(sp.simplify(x)).is_positive for x in entries)
        return Claim(sp.Integer(sum(not so for so in positive)))


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
    """
    gaps = [
        a - b
        for symbol, matrix in values.items()
        if hasattr(symbol, "shape")
        for a, b in zip(symbol.shape, matrix.shape)
    ]
    sizes = sizes_that_fit([gap for gap in gaps if gap != 0])
    put = {symbol: sp.sympify(x) for symbol, x in values.items()}
    found = sp.sympify(expr).xreplace({**put, **sizes}).doit()
    if getattr(found, "is_Matrix", False):
        return found.as_explicit().applyfunc(sp.expand)
    return found
