"""Steps that are not lines: statements at explicit sizes, and objects that exist.

What is no identity of matrices of any size, such as a pattern of zeros, a product of
polynomials or a count, is written in letters, evaluated and shown.  Something exists
because here it is, and a claim is false because here are matrices that deny it.
"""

from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import ClassVar

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .chains import LATEX_MARKS, Shown
from .lines import cited_latex, cited_text, gap, idle, shown, words
from .models import differ, evaluate, model, sizes_of
from .prose import plain
from .relations import Reasons, named, refuse_means, unfounded
from .typeset import Show, columns, latex, padded, text
from .words import Formula, denied, exact, kept, same_shape


@dataclass(frozen=True, eq=False)
class Claim:
    """`left = right`, of explicit matrices or scalars; it is evaluated.

    Attributes
    ----------
    left, right : Matrix or scalar
        A right side of 0 fits every left side.
    """

    left: Formula
    right: Formula = 0

    @property
    def residual(self) -> Formula:
        """The difference of the sides."""
        left, right = (sp.sympify(exact(x, False)) for x in (self.left, self.right))
        if isinstance(left, sp.MatrixBase) and 0 in left.shape:
            raise ValueError(
                f"a claim about an empty matrix, {left.rows} x {left.cols}, "
                "says nothing"
            )
        bare = isinstance(self.right, int) and self.right == 0
        return left if bare else left - right

    @property
    def is_zero(self) -> bool:
        """Whether every entry is identically zero, as it stands or simplified."""
        residual = self.residual
        entries = residual if isinstance(residual, sp.MatrixBase) else [residual]
        return all(x == 0 or sp.simplify(x) == 0 for x in entries)


LISTED = 6  # choices that are named; of more, the first three
WIDEST_LINE = 72  # characters; a wider matrix has a line for each row


@dataclass(frozen=True, eq=False, repr=False)
class Explicit(Shown):
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
    >>> from matrixproof import letters
    >>> S, v = letters("S:n*n v:n")
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
        partly = any(sp.sympify(d).free_symbols for d in sizes)
        return "(✓)" if partly and not self._faults else super().mark

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

    def _as_text(self):
        yield f"  {text(self.left)} {self.sign} {text(self.right)}"
        for pair in self._shown.items():
            yield from rows_of(*pair)
        yield f"    {plain(self.reason())}  {self.mark}"

    def _as_latex(self):
        yield f"{latex(self.left)} &{self.sign} {latex(self.right)}"
        yield from (f"{latex(s)} &= {latex(v)}" for s, v in self._shown.items())
        yield f"&{words(self.reason())} && {LATEX_MARKS[self.mark]}"


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

    The sizes follow from the shapes, which must fit and leave none of them open.
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


@dataclass(frozen=True, eq=False, repr=False)
class Construction(Shown):
    """Something exists, because here it is.

    Parameters
    ----------
    number, says : str
    values : dict of MatrixSymbol to expression
        What is constructed, from other letters than these.
    satisfies : tuple of Relation
        What it must satisfy.
    by : tuple of Relation
        What is known, and needed; it says nothing of what is constructed.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose; what is constructed must be shown to be.

    Examples
    --------
    >>> from matrixproof import Identity, Relation, letters
    >>> C, G, X, N = letters("C:p*n G:n*p X:n*p N:p*p")
    >>> right_inverse = Relation("C G = I", C * G, Identity(C.rows))
    >>> solved = Construction("", "an equation that can be solved", {X: G * N},
    ...                       satisfies=[Relation("C X = N", C * X, N)],
    ...                       by=[right_inverse])
    >>> solved.check()
    []
    >>> print(solved)
    an equation that can be solved
      X = G N
        satisfies C X = N  C G = I  ✓
    """

    number: str
    says: str
    values: dict
    satisfies: tuple
    by: tuple = ()
    symmetric: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "satisfies", named(self.satisfies))
        object.__setattr__(self, "by", named(self.by))
        object.__setattr__(self, "symmetric", tuple(self.symmetric))
        object.__setattr__(self, "values", kept(self.values))
        refuse_means(self.relations)

    @property
    def relations(self) -> Reasons:
        """What it rests on."""
        return (*self.by, *self.satisfies)

    @property
    def expressions(self) -> list[Formula]:
        """Every expression in it."""
        return [
            *self.values,
            *self.values.values(),
            *(e for r in self.relations for e in r),
        ]

    @cached_property
    def _faults(self):
        if found := self._circular() or unfounded(self.by, self.symmetric):
            return found
        known = tuple(s for s in self.symmetric if s not in self.values)
        wanted = {
            f"{cited_text(r)} is not satisfied": [
                sp.sympify(side).xreplace(dict(self.values)) for side in r
            ]
            for r in self.satisfies
        }
        for s, value in self.values.items():
            if s in self.symmetric:
                wanted[f"{text(s)} is not symmetric"] = value.T, value
        missing = {what: gap(*two, self.by, known) for what, two in wanted.items()}
        found = [f"{what}: {why}" for what, why in missing.items() if why is not None]
        if found:
            return found
        holds = lambda others: all(  # noqa: E731
            gap(*two, others, known) is None for two in wanted.values()
        )
        found = [f"does not need {cited_text(r)}" for r in idle(self.by, holds)]
        also = [*self.values.values(), *(e for two in wanted.values() for e in two)]
        if model(self.by, known, also) is None:
            found.append(
                "no matrices were found that satisfy what is cited and have the "
                "inverses that are taken"
            )
        return found

    def _circular(self):
        """What would make it exist by supposing that it does, or be something else."""
        made, found = set(self.values), []
        if not made:
            return ["nothing is constructed"]
        for r in self.by:
            if named := made & letters_of(r.left, r.right):
                found.append(f"{cited_text(r)} supposes {listed(named)}, made here")
        for s, value in self.values.items():
            if named := made & letters_of(value):
                found.append(f"{text(s)} is constructed from {listed(named)}")
            if not same_shape(s.shape, value.shape):
                found.append(
                    f"{text(s)} has the shape {s.shape}, and its value {value.shape}"
                )
        asked = letters_of(*(side for r in self.satisfies for side in r))
        if idle_ones := made - asked:
            found.append(f"nothing is asked of {listed(idle_ones)}")
        return found

    def _as_text(self):
        yield from (f"  {text(s)} = {text(v)}" for s, v in self.values.items())
        does, reason = (
            ", ".join(map(cited_text, x)) for x in (self.satisfies, self.by)
        )
        yield f"    satisfies {does}  {reason}  {self.mark}"

    def _as_latex(self):
        yield from (f"{latex(s)} &= {latex(v)}" for s, v in self.values.items())
        does, reason = (
            r",\; ".join(map(cited_latex, x)) for x in (self.satisfies, self.by)
        )
        mark = LATEX_MARKS[self.mark]
        yield rf"&\text{{satisfies }} {does} && {reason} && {mark}"


@dataclass(frozen=True, eq=False, repr=False)
class Counterexample(Shown):
    """A claim that is false, because here are matrices that deny it.

    Parameters
    ----------
    number, says : str
    left, right : expression
        The sides of the claim.
    values : dict of symbol to explicit Matrix
        With rational entries.
    given, symmetric : tuple
        What the claim supposes; the matrices must satisfy it.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from matrixproof import letters
    >>> A, B = letters("A:n*n B:n*n")
    >>> sums = Counterexample("", "the inverse of a sum", (A + B).I, A.I + B.I,
    ...                       {A: Matrix([[1]]), B: Matrix([[1]])})
    >>> sums.check()
    []
    >>> print(sums)
    the inverse of a sum
      (A + B)⁻¹ ≠ A⁻¹ + B⁻¹
        with A = 1, B = 1, the sides are 1/2 and 2  ✓
    """

    number: str
    says: str
    left: Formula
    right: Formula
    values: dict
    given: tuple = ()
    symmetric: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "given", named(self.given))
        object.__setattr__(self, "symmetric", tuple(self.symmetric))
        object.__setattr__(self, "values", kept(self.values))
        refuse_means(self.given)

    @property
    def relations(self) -> Reasons:
        """What the claim supposes."""
        return self.given

    @property
    def expressions(self) -> list[Formula]:
        """Every expression in it."""
        return [self.left, self.right, *(e for r in self.given for e in r)]

    @cached_property
    def _faults(self):
        found = [
            f"does not satisfy {cited_text(r)}"
            for r in self.given
            if differ(r.left, r.right, self.values)
        ]
        found += [
            f"{text(s)} is not symmetric"
            for s in self.symmetric
            if s in self.values and differ(s, sp.Transpose(s), self.values)
        ]
        found += [says for pair in self.values.items() if (says := denied(*pair))]
        one, other = (getattr(side, "shape", ()) for side in (self.left, self.right))
        alike = same_shape(one, other) if one and other else one == other
        if not alike and self.right != 0:
            found.append(f"no claim: the sides have shapes {one} and {other}")
        elif not differ(self.left, self.right, self.values):
            found.append("the sides are equal")
        return found

    def said(self, show: Show) -> tuple[list[str], str, str]:
        """The values as equations, and the two sides at them."""
        values = [f"{show(s)} = {shown(v, show)}" for s, v in self.values.items()]
        sides = self.left, self.right
        return values, *(shown(evaluate(x, self.values), show) for x in sides)

    def _as_text(self):
        values, left, right = self.said(text)
        said = f"with {', '.join(values)}, the sides are {left} and {right}"
        yield f"  {text(self.left)} ≠ {text(self.right)}"
        yield f"    {said}  {self.mark}"

    def _as_latex(self):
        values, left, right = self.said(latex)
        yield rf"{latex(self.left)} &\ne {latex(self.right)}"
        said = r",\; ".join(values)
        yield rf"{left} &\ne {right} && {said} && {LATEX_MARKS[self.mark]}"


def letters_of(*expressions):
    """The matrix symbols in expressions."""
    return {s for e in expressions for s in sp.sympify(e).atoms(sp.MatrixSymbol)}


def listed(letters):
    return " and ".join(sorted(map(text, letters)))
