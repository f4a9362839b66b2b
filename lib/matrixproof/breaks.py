"""An expression in pieces between which a page may break it."""

import re
from typing import Any

import sympy as sp

from .styles import LATEX, TEXT
from .typeset import (
    POSTFIX,
    PRODUCT,
    Printer,
    latex,
    signed,
    split,
    width,
    word_spaced,
)
from .words import plain

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
    found = terms_in_pieces(plain(expr), Printer(LATEX if show is latex else TEXT))
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
    tr = printer.style.trace
    if width(e) <= LONG:
        shown = printer.show(e, least)
        return [word_spaced(shown) if printer.style is LATEX else shown]
    if isinstance(e, (sp.MatMul, sp.Mul)):
        number, factors = split(e)
        found = [one for x in factors for one in factors_in_pieces(x, printer)]
        if printer.style is LATEX:
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
        comma = r",\;" if printer.style is LATEX else ","
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
