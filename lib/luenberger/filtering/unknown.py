"""A start of which nothing is known: variances that are larger than any number.

`GROWN` stands for the large number kappa, and a variance of an unknown state is kappa
times a number. A sum of two floats keeps only what has the higher power of kappa, so
that only sums that cancel need care: `Leading` makes them zero.  What the
filter finds from leading terms is the limit as kappa grows.  Behind the row at which no
variance is that large the filter goes on in plain floats.

Source: identification/derivation/unknown_start.py.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any

import numpy as np

from ..numeric import Vector
from ..numeric.balance import balanced
from ..plant import Plant
from . import passes
from .passes import TINY, Maps, State, Tape

GROWN = 2.0**600  # floats have room for numbers 2^300 times larger and smaller
LARGE = 2.0**300  # between numbers with a factor kappa and those without


class Leading(float):
    """A float that is zero where it is rounding of what it was made of.

    `made` is the size of the largest number in the sums that led to it, or what
    factors have made of that.
    """

    __slots__ = ("made",)
    made: float

    def __new__(cls, value: Any, made: float = 0.0) -> Leading:
        """The value, or zero."""
        size = abs(float(value))
        one = super().__new__(cls, 0.0 if size <= TINY * made else value)
        one.made = max(size, made) if one else 0.0
        return one

    def __add__(self, other: Any) -> Leading:
        return Leading(float(self) + float(other), max(self.made, _made(other)))

    def __sub__(self, other: Any) -> Leading:
        return Leading(float(self) - float(other), max(self.made, _made(other)))

    def __rsub__(self, other: Any) -> Leading:
        return Leading(float(other) - float(self), max(self.made, _made(other)))

    def __mul__(self, other: Any) -> Leading:
        a, b = float(self), float(other)
        return Leading(a * b, max(self.made * abs(b), abs(a) * _made(other)))

    def __truediv__(self, other: Any) -> Leading:
        other = other if isinstance(other, Leading) else Leading(other)
        return self * (1.0 / other)

    def __rtruediv__(self, other: Any) -> Leading:
        a, b = float(other), float(self)
        return Leading(a / b, abs(a / b) * max(_made(other) / abs(a or 1.0),
                                               self.made / abs(b)))  # fmt: skip

    def __neg__(self) -> Leading:
        return Leading(-float(self), self.made)

    def __abs__(self) -> Leading:
        return Leading(abs(float(self)), self.made)

    __radd__, __rmul__ = __add__, __mul__


def _made(value: Any) -> float:
    return value.made if isinstance(value, Leading) else abs(float(value))


_each: Callable[..., Any] = np.frompyfunc(Leading, 1, 1)


def _leading(X: Any) -> Any:
    with np.errstate(invalid="ignore"):  # what was not measured
        return _each(X)


def _clear(value: Any, made: Any) -> Any:
    """As `passes.clear`, of numbers with like powers of kappa."""
    size = abs(value)
    return value if size > TINY * made or size * LARGE < made else 0


@cache
def _text() -> Callable[..., int]:
    return passes.forward.on(clear=_clear)


def units(plant: Plant) -> Vector:
    """Units of the states in which all of them are unknown to the same extent."""
    now = plant.at(0)
    return _balanced(now.A.tobytes(), now.C.tobytes(), plant.n)


@lru_cache(maxsize=64)
def _balanced(A: bytes, C: bytes, n: int) -> Vector:
    plain = [np.frombuffer(X).reshape(-1, n) for X in (A, C)]
    return balanced(plain[0], plain[1], 0.0, 0.0)[0]


def is_open(state: State) -> bool:
    """Whether something of the state is not known at all."""
    return bool(state.D.max(initial=0.0) > LARGE)


def forward(
    y: Any, drive: Any, at: Any, maps: Maps, state: State, xs: Any, variances: Any,
    tape: Tape,
) -> tuple[int, int]:  # fmt: skip
    """The rows until all is known of the state, as `passes.forward`.

    Returns how many these are, and what that returns.
    """
    for k in range(len(y)):
        if not is_open(state):
            return k, -1
        row, kept = slice(k, k + 1), [X[k : k + 1] for X in tape]
        own = np.array([max(at[k], -1), at[k + 1]])
        used = [i for i in dict.fromkeys(own.tolist()) if i >= 0]
        here = Maps(*(_leading(X[used]) for X in maps))
        own = np.array([used.index(i) if i >= 0 else -1 for i in own.tolist()])
        given = State(*(_leading(X) for X in state))
        out = [_leading(X) for X in (xs[row], variances[row], *kept)]
        clash = _text()(
            _leading(y[row]), _leading(drive[row]), own, here, given, *out[:2],
            Tape(*out[2:]),
        )  # fmt: skip
        for old, new in zip((*state, xs[row], variances[row], *kept), (*given, *out)):
            old[...] = new
        state.D[state.D < 1 / LARGE] = 0  # a number divided by kappa
        if clash >= 0:
            return k, k * y.shape[1] + clash
    return len(y), -1


def rts(at: Any, maps: Maps, tape: Tape, gains: Any) -> None:
    """As `passes.rts`, of rows at which something is not known at all."""
    given, found = Tape(*(_leading(X) for X in tape)), _leading(gains)
    run = passes.rts.on(clear=_clear)
    run(at, Maps(*(_leading(X) for X in maps)), given, found)
    for old, new in zip((*tape, gains), (*given, found)):
        old[...] = new
