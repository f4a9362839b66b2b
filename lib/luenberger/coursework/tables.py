"""Answers of several entries: matrices, arrays, entries by name, several choices."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp

from .answers import choice, expression, number
from .given import described, require


def matrix(
    answer: Any, shape: tuple[int, int], letters: Iterable[sp.Symbol], name: str
) -> sp.Matrix:
    """An answer as a matrix of expressions.

    Parameters
    ----------
    answer : Matrix, list of rows, array or str
        Of one row or column also without its inner brackets.
    shape : tuple of int
    letters : iterable of Symbol
        See `expression`.
    name : str

    Raises
    ------
    AssertionError
        If it has another shape, or an entry that cannot be read.

    Examples
    --------
    >>> a = sp.Symbol("a")
    >>> matrix("[-2 a, 1]", (1, 2), [a], "T")
    Matrix([[-2*a, 1]])
    >>> matrix([[a], [1]], (1, 2), [a], "T")
    Traceback (most recent call last):
    AssertionError: T: expected a matrix of shape (1, 2), got a list of 2
    """
    letters = list(letters)
    wanted = f"{name}: expected a matrix of shape {shape}"
    entries = _entries(answer, shape, wanted)
    return sp.Matrix(*shape, [expression(entry, letters, name) for entry in entries])


def array(answer: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
    """An answer as an array of numbers.

    Raises
    ------
    AssertionError
        If it has another shape, or an entry that is no number.

    Examples
    --------
    >>> array([["1/2"], ["2"]], (2, 1), "K2").tolist()
    [[0.5], [2.0]]
    >>> array(None, (2, 1), "K2")
    Traceback (most recent call last):
    AssertionError: K2: expected an array of shape (2, 1), got None
    """
    wanted = f"{name}: expected an array of shape {shape}"
    entries = _entries(answer, shape, wanted)
    return np.array([number(entry, name) for entry in entries]).reshape(shape)


def by_name(answer: Any, names: Sequence[str], name: str) -> dict[str, Any]:
    """The entries of an answer by name; case and signs in a name do not count.

    Parameters
    ----------
    answer : dict, or list in the order of the names
    names : sequence of str
    name : str

    Raises
    ------
    AssertionError
        If it does not have these entries.

    Examples
    --------
    >>> by_name({"Order-1 ": 3, "order 2": 4}, ["order 1", "order 2"], "found")
    {'order 1': 3, 'order 2': 4}
    >>> by_name({"order 1": 3}, ["order 1", "order 2"], "found")
    Traceback (most recent call last):
    AssertionError: found: expected entries order 1; order 2, got a dict of 1
    """
    wrong = f"{name}: expected entries {'; '.join(names)}, got {described(answer)}"
    if isinstance(answer, Mapping):
        given = {_plain(key): entry for key, entry in answer.items()}
        require(set(given) == set(map(_plain, names)), wrong)
        return {each: given[_plain(each)] for each in names}
    listed = isinstance(answer, list | tuple | np.ndarray)
    require(listed and len(answer) == len(names), wrong)
    return dict(zip(names, answer))


def choices(answer: Any, of: Sequence[str], name: str) -> set[str]:
    """An answer as several of some words, in any order.

    >>> sorted(choices("p, (Phi)", ["P", "Phi", "G"], "changes"))
    ['P', 'Phi']
    >>> choices(["x"], ["P", "Phi"], "changes")
    Traceback (most recent call last):
    AssertionError: changes: expected one of P, Phi, got the text 'x'
    """
    if isinstance(answer, str):
        answer = [
            word for word in re.split(r"[,;\s]+", answer.strip(" {}[]()")) if word
        ]
    wrong = f"{name}: expected some of {', '.join(of)}, got {described(answer)}"
    require(isinstance(answer, list | tuple | set | frozenset | np.ndarray), wrong)
    return {choice(one, of, name) for one in answer}


def instance(answer: Any, kind: type, name: str) -> Any:
    """An answer that must be of a kind, such as an observer.

    >>> instance(3, dict, "found")
    Traceback (most recent call last):
    AssertionError: found: expected dict, got int 3
    """
    wrong = f"{name}: expected {kind.__name__}, got {described(answer)}"
    require(isinstance(answer, kind), wrong)
    return answer


def _entries(answer, shape, wanted):
    """The entries of a table, row by row."""
    given = _rows(answer) if isinstance(answer, str) else answer
    if isinstance(given, sp.MatrixBase):
        given = given.tolist()
    wrong = f"{wanted}, got {described(answer)}"
    require(isinstance(given, list | tuple | np.ndarray), wrong)
    try:
        found = np.array(given, dtype=object)
    except ValueError:
        raise AssertionError(wrong) from None
    long = [size for size in shape if size != 1]
    bare = found.ndim < len(shape) and [s for s in found.shape if s != 1] == long
    require(found.shape == tuple(shape) or bare, wrong)
    return list(found.ravel())


def _rows(text):
    """The rows of a table that was written as text; the entries of one row."""
    rows = re.split(r"[\])]\s*,|;", text)
    table = [[entry.strip(" []") for entry in row.split(",")] for row in rows]
    return table if len(table) > 1 else table[0]


def _plain(name):
    return re.sub(r"\W|_", "", str(name)).casefold()
