"""The letters of a text: declared once, each with its size and what it stands for."""

from __future__ import annotations

import re
from collections.abc import Mapping
from string import ascii_letters, digits
from typing import Any

import sympy as sp

from .chains import Chain
from .dependence import letters as inside
from .deriving import Derived, begun
from .families import over
from .lines import Line
from .names import BACK
from .relations import Let, Moment, Relation, Steady, equation, under
from .symbols import MatrixSymbol, Member, Over, Symmetric
from .typeset import text
from .words import Formula, Size, Values, is_letter, plain

TERM = r"(\d+|\d*[A-Za-z]\w*)"  # of a size
KNOWN = frozenset(ascii_letters + digits + "_^*+-#").union(BACK)


class Notation:
    """The letters of a text, and chains and definitions that are written in them.

    Parameters
    ----------
    sizes : dict of expression to expression, optional
        Sizes that are shown otherwise: {n - r: m_1}.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import Line, Notation
    >>> n, p = symbols("n p", integer=True, positive=True)
    >>> letters = Notation()
    >>> C = letters("C", p, n, "a linear map")
    >>> Omega = letters("Omega", n, n, "the covariance of x", symmetric=True)
    >>> N = letters("N", n, p, "the covariance of x and C x")
    >>> letters.let(N, Omega * C.T, "33")
    Let (33) N = Ω C'
    """

    def __init__(self, sizes: Mapping[Any, Any] | None = None) -> None:
        self.meaning: dict[Any, str] = {}
        self.symmetric: tuple[MatrixSymbol, ...] = ()
        self.sizes = sizes or {}
        self.taken_over: frozenset[str] = frozenset()

    def __call__(
        self,
        name: str,
        rows: Size,
        cols: Size,
        meaning: str,
        symmetric: bool = False,
        index: str = "",
        family: str = "",
    ) -> MatrixSymbol:
        """A new letter; with an index, for each member of a family."""
        made = Member(name, rows, cols, index, family) if index else None
        symbol = self._new(made or MatrixSymbol(name, rows, cols), meaning)
        if symmetric:
            self.symmetric += (symbol,)
        return symbol

    def scalar(self, name: str, meaning: str, **assumptions: bool) -> sp.Symbol:
        """A new letter for a number, with what SymPy is to assume of it."""
        return self._new(sp.Symbol(name, **assumptions), meaning)

    def _new(self, symbol, meaning):
        """The symbol, with its meaning; no two of a page may look alike."""
        strange = [x for x in symbol.name if x not in KNOWN]
        if strange or not symbol.name:
            raise ValueError(
                f"the name {symbol.name!r} has {strange[:1] or 'no letter'}: a letter "
                "is named in ASCII letters, digits and _ ^ * + - #, Greek ones in words"
            )
        alike = [s for s in self.meaning if text(s) == text(symbol)]
        gone = [s for s in alike if s.name in self.taken_over]
        if gone:
            self.taken_over -= {s.name for s in gone}
            self.meaning = {s: m for s, m in self.meaning.items() if s not in gone}
            self.symmetric = tuple(s for s in self.symmetric if s not in gone)
        for known in alike:
            if known not in gone:
                raise ValueError(
                    f"the letter {symbol.name} is taken: {kind(known)} {known.name} "
                    f"stands for {self.meaning[known]!r}; rename one of them"
                )
        self.meaning[symbol] = meaning
        return symbol

    def here(self, **meanings: str) -> Notation:
        """The same letters, of which some stand for something else on one page.

        What is declared in them anew, with another size, also stands for that alone.
        """
        found = Notation(self.sizes)
        found.meaning, found.symmetric = dict(self.meaning), self.symmetric
        found.taken_over = frozenset(symbol.name for symbol in self.meaning)
        for symbol in self.meaning:
            if symbol.name in meanings:
                found.meaning[symbol] = meanings[symbol.name]
        return found

    def let(
        self, letter: Formula, right: Formula, number: str = "", name: str = ""
    ) -> Let:
        """What a new letter stands for.

        Raises
        ------
        ValueError
            The left side is no letter, or it occurs in the right side.  A page also
            refuses a letter of which it says something already.
        """
        if not is_letter(letter):
            raise ValueError(
                f"let(...) says what a letter stands for, and {text(letter)} is none: "
                "write suppose(...)"
            )
        if letter in inside(plain(right)):
            raise ValueError(
                f"{text(letter)} stands for {text(right)}, in which it occurs: write "
                "steady(...) of a fixed point, or suppose(...)"
            )
        return Let(under(number, name or equation(letter, right)), letter, right)

    def suppose(
        self, left: Formula, right: Formula, number: str = "", name: str = ""
    ) -> Relation:
        """An equation that is a hypothesis."""
        return Relation(under(number, name or equation(left, right)), left, right)

    def steady(
        self, letter: Formula, right: Formula, number: str = "", name: str = ""
    ) -> Steady:
        """A hypothesis, too: a letter is what a step makes of it.

        Raises
        ------
        ValueError
            The letter does not occur in the right side.
        """
        if letter not in inside(plain(right)):
            raise ValueError(
                f"{text(letter)} does not occur in {text(right)}, so that is no fixed "
                "point: write let(...) or suppose(...)"
            )
        return Steady(under(number, name or equation(letter, right)), letter, right)

    def moment(self, left: Formula, right: Formula, number: str = "") -> Moment:
        """The expectation of a product, or of a vector, that is supposed."""
        says = Moment("", left, right).show(text)
        return Moment(under(number, says), left, right)

    def chain(
        self,
        number: str,
        says: str,
        left: Formula,
        *lines: Line,
        witness: Values | None = None,
    ) -> Chain:
        """A chain in these letters."""
        return Chain(number, says, left, lines, self.symmetric, witness or {})

    def derive(
        self, number: str, says: str, left: Any, witness: Values | None = None
    ) -> Derived:
        """A derivation in these letters, whose operations find its lines.

        It begins with an expression; or with a relation or a chain, whose right side
        is the first line.
        """
        return begun(number, says, left, self.symmetric, witness=witness or {})


def letters(declared: str) -> tuple[Any, ...]:
    """Letters with their sizes, for a cell.

    Parameters
    ----------
    declared : str
        `A:n*m` is a matrix with n rows and m columns, `Q:n*n=` one that equals its
        transpose, `x:n` a column, `J:n-r*2p` has 2 p columns, and `t` is a number.
        After `sum_i`, which is the sign of the sum over i, `B_i:n*m` is a family.

    Examples
    --------
    >>> from matrixproof import letters
    >>> A, Q, x, t = letters("A:n*n Q:n*n= x:n t")
    >>> A.shape, x.shape, Q.T == Q
    ((n, n), (n, 1), True)
    >>> letters("C:p*n=")
    Traceback (most recent call last):
        ...
    matrixproof.words.ShapeError: C is (p, n), not square: it is not symmetric
    """
    taken, found = Notation(), []
    for item in declared.split():
        name, _, sizes = item.partition(":")
        index = name.rpartition("_")[2]
        if name.startswith("sum_"):
            found.append(Over(name))
            continue
        if not sizes:
            found.append(taken.scalar(name, item, real=True))
            continue
        shape = [size_of(part, item) for part in sizes.rstrip("=").split("*")]
        if len(shape) > 2:
            raise ValueError(f"{item!r} has {len(shape)} sizes: write {name}:n*m")
        shape += [sp.S.One] * (2 - len(shape))
        if over(index) in found:
            letter = Member(name, shape[0], shape[1], index)
        else:
            letter = (Symmetric if item.endswith("=") else MatrixSymbol)(name, *shape)
        found.append(taken._new(letter, item))
    return tuple(found)


def size_of(part, item):
    """A number of rows or columns, as `3`, `2n` or `n-r`."""
    if not re.fullmatch(TERM + f"([+-]{TERM})*", part):
        raise ValueError(f"{part!r} in {item!r} is no size: write A:n*m")
    total = 0
    for sign, number, name in re.findall(r"([+-]?)(\d*)([A-Za-z]\w*)?", part):
        term = sp.Symbol(name, integer=True, positive=True) if name else 1
        total += sp.Integer(f"{sign}{number or int(bool(name))}") * term
    return total


def kind(symbol):
    """What a letter is, in a message."""
    shape = getattr(symbol, "shape", ())
    return "the {} x {} matrix".format(*shape) if shape else "the number"
