"""Loops over plain arrays: compiled by numba where it is installed, else Python.

The texts of one module are compiled together, when one of them is first called, and
kept on disk beside it until the module changes.  So they call each other, and nothing
that another module defines.  To load numba takes as long as many a record; so little
work is done as Python before, with the same bits.
"""

import types
from collections.abc import Callable
from functools import cache, cached_property
from importlib.util import find_spec
from threading import Lock
from typing import Any

import numpy as np

EARLY = 100_000  # microseconds of Python: numba takes three times as long to load
WAYS: dict[str, Any] = dict(cache=True, error_model="numpy", nogil=True)
FAST = {"contract", "reassoc"}  # sums in any order: for sizes that only loops can do


@cache
def installed() -> bool:
    """Whether there is a compiler."""
    return find_spec("numba") is not None


_spent = 0.0


def early(work: float) -> bool:
    """Whether work of so many microseconds is done as Python.

    So it is until all such work in a process comes to EARLY, or a text is compiled.
    """
    global _spent
    _spent += work
    return _spent <= EARLY or not installed()


_ONE_AT_A_TIME = Lock()


class Text:
    """A function of loops over arrays, as it is written in `plain`."""

    def __init__(self, plain: Callable) -> None:
        self.plain = plain

    def __call__(self, *given: Any) -> Any:
        if "exact" not in vars(self) and early(_size(given)):
            return self.python(*given)
        return self.exact(*given)

    @cached_property
    def python(self) -> Callable:
        """The text as it is written."""
        return self.on()

    @cached_property
    def exact(self) -> Callable:
        """The function that runs, with every operation where it is written."""
        return self._compiled("_exact", WAYS)

    @cached_property
    def fast(self) -> Callable:
        """The same, with sums in the order that the compiler likes."""
        return self._compiled("_fast", WAYS | {"fastmath": FAST})

    def _compiled(self, which: str, ways: dict[str, Any]) -> Callable:
        names = self.plain.__globals__
        if not installed():
            return self.python
        import numba

        global _spent
        _spent = np.inf
        with _ONE_AT_A_TIME:  # of several threads
            made = names.setdefault(which, {})
            known = dict(names)
            for name, text in names.items() if not made else ():
                if isinstance(text, Text):
                    plain = types.FunctionType(text.plain.__code__, known)
                    plain.__qualname__ += which  # numba's cache goes by the name
                    known[name] = made[name] = numba.njit(**ways)(plain)
        return made[self.plain.__name__]

    def on(self, **names: Any) -> Callable:
        """The text as Python in which some names stand for other things.

        So it runs on numbers that are no floats; what it calls is Python as well.
        """
        known = dict(self.plain.__globals__)
        for name, one in self.plain.__globals__.items():
            if isinstance(one, Text):
                known[name] = types.FunctionType(one.plain.__code__, known)
        known |= names
        return types.FunctionType(self.plain.__code__, known)


def _size(given: Any) -> int:
    """How many numbers there are in arrays, and in tuples of them."""
    return sum(map(_size, given)) if isinstance(given, tuple) else np.size(given)
