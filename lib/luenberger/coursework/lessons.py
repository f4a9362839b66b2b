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
    return left.shape == right.shape and not any((left - right).applyfunc(sp.simplify))


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
