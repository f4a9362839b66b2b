"""Expressions as they stand on a page, typeset and in Unicode.

Terms keep the order in which they were written.  A prime is the transpose; an
identity is I and a zero matrix 0, whatever their sizes.  Anything that this module
has no rule for is set by SymPy.
"""

import re
import unicodedata
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.matrices.expressions.matexpr import MatrixExpr

from .names import HIGH, latex_name, text_name
from .symbols import Member, Over, closed
from .words import Formula, plain

SUM, PRODUCT, POSTFIX, ATOM = range(4)  # how tightly an expression holds together
WIDEST = 110  # characters of one side in Unicode; a page breaks it between terms

Show = Callable[[Formula], str]  # `latex` or `text`


def latex(expr: Formula) -> str:
    r"""An expression in LaTeX.

    >>> from sympy import Trace
    >>> from matrixproof import letters
    >>> K, C, Omega = letters("K_mv:n*p C:p*n Omega_next:n*n")
    >>> print(latex(K * C * Omega * C.T), latex(Trace(2 * Omega.I)))
    K_{\mathrm{mv}} C \Omega_{+} C' \operatorname{tr}\left(2 \Omega_{+}^{-1}\right)
    """
    return word_spaced(LATEX.show(expr))


def word_spaced(string):
    r"""Thin spaces around letters that are words, where a product would join them.

    >>> print(word_spaced(r"C \mathrm{Pick} R"), word_spaced(r"K_{\mathrm{mv}} M"))
    C \, \mathrm{Pick} \, R K_{\mathrm{mv}} M
    """
    string = re.sub(r"(?<=[\w'}]) (?=\\mathrm\{(?:d|\w{2,})\})", r" \\, ", string)
    return re.sub(r"(\\mathrm\{\w{2,}\}'?) (?=[\w\\])", r"\1 \\, ", string)


def text(expr: Formula) -> str:
    """An expression in Unicode, on one line.

    >>> from matrixproof import letters
    >>> K, C, Omega = letters("K:n*p C:p*n Omega:n*n")
    >>> print(text((K * C + Omega).I * Omega.I * (K * C).T))
    (K C + Ω)⁻¹ Ω⁻¹ (K C)'
    """
    return TEXT.show(expr)


def width(expr):
    """How many columns an expression takes in Unicode."""
    return columns(text(expr))


def columns(string):
    """How many columns a string takes: an accent stands over its letter.

    >>> columns("Q\u0302 + x"), len("Q\u0302 + x")
    (5, 6)
    """
    return sum(not unicodedata.combining(c) for c in string)


def padded(string, wide):
    """A string with blanks behind it."""
    return string + " " * (wide - columns(string))


class Printer:
    """Sets expressions in Unicode."""

    open, close, trace, determinant, differential = "(", ")", "tr", "det", "d"
    tight = POSTFIX  # how the parts of a quotient and a root must hold together
    name, fallback = staticmethod(text_name), staticmethod(str)

    def function(self, name):
        return name

    def series(self, k, a, b, body):
        return f"Σ[{k} = {a} .. {b}] {body}"

    def sum(self, index):
        return f"Σ_{index}"

    def power(self, base, k):
        if k.lstrip("-").isdigit():
            return base + k.translate(HIGH)
        return f"{base}^{k}" if k.isalnum() else f"{base}^({k})"

    def fraction(self, p, q):
        return f"{p}/{q}"

    def quotient(self, above, below):
        return f"{above}/{below}"

    def root(self, inner):
        return f"√{inner}"

    def rows(self, rows):
        """Rows of entries; those with blanks stand further apart."""
        wide = any(" " in cell for row in rows for cell in row)
        return "[" + "; ".join(("  " if wide else " ").join(row) for row in rows) + "]"

    @property
    def inner(self):
        """Within a quotient or a power, where quotients have a slash."""
        return self

    # -- the same for every style -----------------------------------------------------

    def show(self, expr, least=SUM):
        """The expression, in brackets if it holds together less than `least`."""
        string, tightness = as_set(self, plain(expr))
        return string if tightness >= least else f"{self.open}{string}{self.close}"

    def _sum(self, e):
        out = ""
        for sign, term in signed(e):
            body = self.show(term, PRODUCT)
            if not out:
                out = ("-" if sign < 0 else "") + body
            else:
                out += (" - " if sign < 0 else " + ") + body
        return out, SUM

    def _product(self, e):
        above, below = denominator(e)
        if below != 1:
            return self._quotient(above, below)
        number, factors = split(e)
        if number < 0:
            return "-" + self.show(rebuilt(-number, factors, e), PRODUCT), SUM
        least = PRODUCT if len(factors) == 1 else POSTFIX
        parts = [self.show(f, least) for f in factors]
        if number != 1 or not parts:
            parts.insert(0, self._number(number)[0])
        return " ".join(parts), PRODUCT if len(parts) > 1 else POSTFIX

    def _quotient(self, above, below):
        if above.could_extract_minus_sign():
            return "-" + self._quotient(-above, below)[0], SUM
        top = self.inner.show(above, min(PRODUCT, self.tight))
        below = self.inner.show(below, self.tight)
        return self.quotient(top, below), PRODUCT

    def _derivative(self, e):
        ((by, k),) = e.variable_count
        d, once = self.differential, self.show(by)
        marks = (d, d + once)
        if k != 1:
            marks = (self.power(d, str(k)), d + self.power(once, str(k)))
        return f"{self.quotient(*marks)} {self.show(e.expr, POSTFIX)}", PRODUCT

    def _transpose(self, e):
        inner = e.arg
        if isinstance(inner, (sp.MatPow, sp.Pow)) or has_mark_above(inner):
            return self._grouped(self.show(inner, POSTFIX)) + "'", POSTFIX
        return self.show(inner, ATOM) + "'", POSTFIX

    def _power(self, e):
        base, exponent = e.base, e.exp
        above, below = denominator(e)
        if below != 1:
            return self._quotient(above, below)
        if exponent == sp.S.Half:
            return self.root(self.show(base, self.tight)), ATOM
        if isinstance(base, sp.Transpose) or has_mark_above(base):
            shown = self._grouped(self.show(base, POSTFIX))
        else:
            shown = self.inner.show(base, ATOM)
        return self.power(shown, self.inner.show(exponent)), POSTFIX

    def _grouped(self, string):
        """Two marks on one letter: braces keep LaTeX from refusing them."""
        return f"{{{string}}}" if self is LATEX else string

    def _call(self, function, argument):
        inner = f"{self.open}{self.show(argument)}{self.close}"
        return function + inner, ATOM

    def _series(self, e):
        out = self.show(e.function, PRODUCT)
        for limits in e.limits:
            out = self.series(*map(self.show, limits), out)
        return out, PRODUCT

    def _number(self, q):
        if q < 0:
            return f"-{self._number(-q)[0]}", SUM
        if q.q == 1:
            return str(q.p), ATOM
        return self.fraction(q.p, q.q), PRODUCT


class LatexPrinter(Printer):
    """Sets expressions in LaTeX."""

    open, close, trace = r"\left(", r"\right)", r"\operatorname{tr}"
    determinant, differential, tight = r"\det", r"\mathrm{d}", SUM
    name, fallback = staticmethod(latex_name), staticmethod(sp.latex)

    def function(self, name):
        return rf"\{name}" if hasattr(sp, name) else name

    def series(self, k, a, b, body):
        return rf"\sum_{{{k}={a}}}^{{{b}}} {body}"

    def sum(self, index):
        return rf"\sum_{{{index}}}"

    def power(self, base, k):
        return f"{base}^{{{k}}}"

    def fraction(self, p, q):
        return rf"\tfrac{{{p}}}{{{q}}}"

    def quotient(self, above, below):
        return rf"\frac{{{above}}}{{{below}}}"

    def root(self, inner):
        return rf"\sqrt{{{inner}}}"

    def rows(self, rows):
        body = r" \\ ".join(" & ".join(row) for row in rows)
        return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"

    @property
    def inner(self):
        return SLASHED


class Slashed(LatexPrinter):
    """The same for where a bar would be too small."""

    tight, quotient = Printer.tight, Printer.quotient


TEXT, LATEX, SLASHED = Printer(), LatexPrinter(), Slashed()


@lru_cache(20_000)
def as_set(printer, e):
    """An expression and how tightly it holds; a page cites the same ones repeatedly."""
    for kinds, rule in RULES:
        if isinstance(e, kinds):
            return rule(printer, e)
    return printer.fallback(e), SUM if isinstance(e, MatrixExpr) else ATOM


def of_blocks(printer, rows):
    shown = [[printer.show(x) for x in row] for row in rows]
    return printer.rows(shown), ATOM


RULES = (
    (Member, lambda p, e: (p.name(e.shown_name), ATOM)),
    (Over, lambda p, e: (p.sum(e.shown_index), POSTFIX)),
    ((sp.MatrixSymbol, sp.Symbol), lambda p, e: (p.name(e.name), ATOM)),
    (sp.Identity, lambda p, e: ("I", ATOM)),
    (sp.ZeroMatrix, lambda p, e: ("0", ATOM)),
    ((sp.MatAdd, sp.Add), Printer._sum),
    ((sp.MatMul, sp.Mul), Printer._product),
    (sp.Transpose, Printer._transpose),
    ((sp.MatPow, sp.Pow), Printer._power),
    (sp.Trace, lambda p, e: p._call(p.trace, e.arg)),
    (type(sp.I), lambda p, e: ("j", ATOM)),
    (sp.Sum, Printer._series),
    (sp.Determinant, lambda p, e: p._call(p.determinant, e.arg)),
    (sp.Rational, Printer._number),
    (sp.Derivative, Printer._derivative),
    (sp.exp, lambda p, e: (p.power("e", p.show(e.exp)), POSTFIX)),
    (
        (AppliedUndef, sp.sin, sp.cos, sp.log),
        lambda p, e: p._call(p.function(e.func.__name__), *e.args),
    ),
    (sp.BlockMatrix, lambda p, e: of_blocks(p, e.blocks.tolist())),
    (sp.MatrixBase, lambda p, e: of_blocks(p, e.tolist())),
)


def denominator(e):
    """(what is above a bar, what is below it) of a scalar with letters below; or 1."""
    if isinstance(e, MatrixExpr):
        return e, sp.S.One
    above, below = sp.fraction(e, exact=True)
    return (above, below) if below.free_symbols else (e, sp.S.One)


def signed(e):
    """(sign, term) pairs of a sum, inner sums opened, in the order written."""
    for term in e.args:
        if isinstance(term, (sp.MatAdd, sp.Add)):
            yield from signed(term)
            continue
        number, factors = split(term)
        if number < 0:
            yield -1, rebuilt(-number, factors, term)
        else:
            yield 1, term


def split(e):
    """The number in front of a product, and its factors; inner products are opened."""
    if isinstance(e, sp.Rational):
        return e, []
    if not isinstance(e, (sp.MatMul, sp.Mul)):
        return sp.S.One, [e]
    number, factors = sp.S.One, []
    for k, arg in enumerate(e.args):
        others = e.args[:k] + e.args[k + 1 :]
        inner, rest = (1, [arg]) if closed(arg, others) else split(arg)
        number *= inner
        factors += rest
    signs = [x for x in factors if isinstance(x, Over)]  # in front of what is summed
    return number, signs + [x for x in factors if not isinstance(x, Over)]


def rebuilt(number, factors, like):
    """A product with another number in front, nothing evaluated."""
    kind = sp.MatMul if isinstance(like, MatrixExpr) else sp.Mul
    if number == 1 and len(factors) == 1:
        return factors[0]
    if not factors:
        return number
    args = factors if number == 1 else [number, *factors]
    return kind(*args, evaluate=False)


def has_mark_above(e):
    """Whether a symbol's own name has something above it already."""
    return isinstance(e, sp.MatrixSymbol) and "^" in latex_name(e.name)


WORD = r"\\mathrm\{\w{2,}\}"
LONG = 24  # columns of a product that a page may break as well


def pieces(expr: Any, show: Any) -> list[str]:
    """The terms of a sum with their signs, between which a page may break a line.

    A long product is broken between its factors, and a long bracket within.

    >>> from matrixproof import MatrixSymbol, text
    >>> A, B, C = (MatrixSymbol(name, 2, 2) for name in "ABC")
    >>> pieces(A - 2 * B * A, text)
    ['A', '- 2 B A']
    >>> pieces(A * (A * B * C * C + A * B * A * C - B * B * C * A + A * B).T, text)
    ['A', '(A B C C', '+ A B A C', '- B B C A', "+ A B)'"]
    """
    found = terms_in_pieces(plain(expr), LATEX if show is latex else TEXT)
    return [show(expr)] if len(found) == 1 else found


def terms_in_pieces(e, printer):
    """The pieces of a sum, or of what stands alone."""
    terms = signed(e) if isinstance(e, (sp.MatAdd, sp.Add)) else [(1, e)]
    found = []
    for sign, term in terms:
        first, *rest = factors_in_pieces(term, printer, PRODUCT)
        found += [f"{'-' if sign < 0 else '+'} {first}", *rest]
    return [found[0].removeprefix("+ "), *found[1:]]


def factors_in_pieces(e, printer, least=POSTFIX):
    """The pieces of a product, or of a bracket in one."""
    tr = printer.trace
    if width(e) <= LONG:
        shown = printer.show(e, least)
        return [word_spaced(shown) if printer is LATEX else shown]
    if isinstance(e, (sp.MatMul, sp.Mul)):
        number, factors = split(e)
        found = [one for x in factors for one in factors_in_pieces(x, printer)]
        if printer is LATEX:
            found = thinly_spaced(found)
        return found if number == 1 else enclosed(f"{printer.show(number)} ", found, "")
    if isinstance(e, sp.Trace):
        return enclosed(f"{tr}(", terms_in_pieces(e.arg, printer), ")")
    if isinstance(e, sp.Transpose) and isinstance(e.arg, sp.MatAdd):
        return enclosed("(", terms_in_pieces(e.arg, printer), ")'")
    if isinstance(e, (sp.MatAdd, sp.Add)):
        return enclosed("(", terms_in_pieces(e, printer), ")")
    if isinstance(e, sp.BlockMatrix) and e.blockshape[0] == 1:
        entries = [terms_in_pieces(entry, printer) for entry in e.blocks]
        comma = r",\;" if printer is LATEX else ","
        commas = [enclosed("", entry, comma) for entry in entries[:-1]]
        return enclosed("[", sum(commas, []) + entries[-1], "]")
    return [printer.show(e, least)]


def thinly_spaced(factors):
    """Factors in LaTeX with thin spaces around letters that are words."""
    found = factors[:1]
    for before, factor in zip(factors, factors[1:]):
        word = re.match(WORD, factor) or re.search(WORD + "'?$", before)
        found.append(rf"\, {factor}" if word else factor)
    return found


def enclosed(before, inner, after):
    """Pieces between brackets, of which each stands with what is next to it."""
    first, *rest = inner
    found = [f"{before}{first}", *rest]
    return [*found[:-1], f"{found[-1]}{after}"]
