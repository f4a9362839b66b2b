"""Whether an answer is right, and which common mistake it is."""

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from .given import require


def same(left: Any, right: Any) -> bool:
    """Whether two expressions, matrices or lists are equal, whatever their form.

    >>> a = sp.Symbol("a")
    >>> same((1 - a) ** 2, 1 - 2 * a + a**2), same([a, 1], [1, a])
    (True, False)
    """
    left, right = sp.Matrix([left]), sp.Matrix([right])
    if left.shape != right.shape:
        return False
    rest = [sp.sympify(entry) for entry in left - right]
    if any(map(_differs_at_primes, rest)):
        return False
    return not any(sp.simplify(entry) for entry in rest if sp.expand(entry) != 0)


def _differs_at_primes(rest: sp.Expr) -> bool:
    """Whether an expression is a rational number other than zero at the first primes.

    Then it is not zero, which `simplify` would find as well, and much later.
    """
    some = sorted(rest.free_symbols, key=str)
    values = {symbol: sp.Integer(sp.prime(k)) for k, symbol in enumerate(some, 1)}
    if not all(_may_be(symbol, value) for symbol, value in values.items()):
        return False
    value = rest.subs(values)
    return bool(value.is_Rational and value != 0)


def _may_be(symbol: Any, value: sp.Integer) -> bool:
    """Whether all that is supposed of a scalar symbol is true of a number."""
    supposed = symbol.assumptions0 if isinstance(symbol, sp.Symbol) else {"scalar": 1}
    return all(
        getattr(value, f"is_{name}", None) is so for name, so in supposed.items()
    )


def spot(
    found: Any, lessons: Mapping[str, Any], equal: Callable[[Any, Any], bool] = same
) -> None:
    """Recognise a common mistake, and say what to think about.

    Raises
    ------
    AssertionError
        With the lesson of the first mistake that the answer is equal to.

    Examples
    --------
    >>> spot(-2, {"Look at the sign.": -2})
    Traceback (most recent call last):
    AssertionError: Look at the sign.
    """
    for lesson, mistake in lessons.items():
        require(not equal(found, mistake), lesson)
