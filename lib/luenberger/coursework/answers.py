"""One answer: an expression, a number, several numbers, one of several choices."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp

from .given import alone, described, require
from .strings import letter_of, parsed

INFINITE = ("inf", "infinity", "oo", "∞")


def expression(answer: Any, letters: Iterable[sp.Symbol], name: str) -> sp.Expr:
    """An answer as an expression in the letters of the task.

    Parameters
    ----------
    answer : expression, number or str
        Also in a list or matrix of one entry, or as the right side of an equation.  A
        symbol counts by its name, also if it was declared again or in another case.
    letters : iterable of Symbol
    name : str
        What the student calls it, for messages.

    Raises
    ------
    AssertionError
        If it is no expression in these letters.

    Examples
    --------
    >>> a, r = sp.symbols("a r_1", positive=True)
    >>> expression("2 A r1 + a^2", (a, r), "q") == 2 * a * r + a**2
    True
    >>> expression([1, 2], (a, r), "q")
    Traceback (most recent call last):
    AssertionError: q: expected an expression in a, r_1, got a list of 2
    """
    known = {letter.name: letter for letter in letters}
    wanted = f"{name}: expected an expression in {', '.join(known)}"
    given = alone(answer)
    if isinstance(given, str):
        given = parsed(given, known, wanted)
    try:
        found = sp.sympify(given, strict=True)
    except sp.SympifyError:
        raise AssertionError(f"{wanted}, got {described(answer)}") from None
    if isinstance(found, sp.Equality):
        found = found.rhs
    scalar = isinstance(found, sp.Expr) and not isinstance(found, sp.MatrixBase)
    require(scalar, f"{wanted}, got {described(answer)}")
    meant = {symbol: letter_of(symbol.name, known) for symbol in found.free_symbols}
    strange = sorted(symbol.name for symbol in meant if meant[symbol] is None)
    require(not strange, f"{wanted}, got one with {', '.join(strange)}")
    return found.xreplace(meant)


def number(answer: Any, name: str, infinite: bool = False) -> float:
    """An answer as a number.

    Parameters
    ----------
    answer : number, expression or str
    name : str
    infinite : bool
        Whether infinity is an answer.

    Raises
    ------
    AssertionError
        If it is none, or not finite and `infinite` is false.

    Examples
    --------
    >>> number("3/2", "q"), number(["0,25"], "q"), number(np.float64(2), "q")
    (1.5, 0.25, 2.0)
    >>> number("oo", "q", infinite=True)
    inf
    >>> number(None, "q")
    Traceback (most recent call last):
    AssertionError: q: expected a number, got None
    """
    given = alone(answer)
    if infinite and str(given).strip("+ ").casefold() in INFINITE:
        return math.inf
    if isinstance(given, str):
        with_point = re.sub(r"^(\s*[-+−]?\d+),(\d+\s*)$", r"\1.\2", given)
        given = parsed(with_point, {}, f"{name}: expected a number")
    wrong = f"{name}: expected a number, got {described(answer)}"
    try:
        value = float(given)
    except (TypeError, ValueError):
        raise AssertionError(wrong) from None
    require(not isinstance(given, bool) and np.isfinite(value), wrong)
    return value


def numbers(answer: Any, names: Sequence[str]) -> list[float]:
    """An answer of several numbers: in a list, an array, text, or a dict by name.

    >>> numbers("(1, 2)", ["q", "r"]), numbers({"r": 2, "q": 1}, ["q", "r"])
    ([1.0, 2.0], [1.0, 2.0])
    >>> numbers(3, ["q", "r"])
    Traceback (most recent call last):
    AssertionError: expected q, r: 2 numbers, got int 3
    """
    given = answer
    if isinstance(given, str):
        given = [part for part in re.split(r"[,;\s]+", given.strip("()[]{} ")) if part]
    if isinstance(given, Mapping):
        given = [given.get(name) for name in names]
    wrong = f"expected {', '.join(names)}: {len(names)} numbers, got"
    try:
        found = list(np.ravel(np.array(given, dtype=object)))
    except ValueError:
        raise AssertionError(f"{wrong} {described(answer)}") from None
    require(len(found) == len(names), f"{wrong} {described(answer)}")
    return [number(one, name) for one, name in zip(found, names)]


def choice(answer: Any, choices: Sequence[str], name: str) -> str:
    """An answer as one of several: brackets, quotes and case do not count.

    >>> choice(" (D).", "abcdef", "wrong_line"), choice(True, ["yes", "no"], "changes")
    ('d', 'yes')
    >>> choice("g", "abc", "wrong_line")
    Traceback (most recent call last):
    AssertionError: wrong_line: expected one of a, b, c, got the text 'g'
    """
    given = alone(answer)
    if isinstance(given, bool | np.bool_):
        given = "yes" if given else "no"
    read = str(given).strip(" ()[]{}.:'\"").casefold()
    for one in choices:
        if one.casefold() == read:
            return one
    listed = ", ".join(choices)
    raise AssertionError(f"{name}: expected one of {listed}, got {described(answer)}")
