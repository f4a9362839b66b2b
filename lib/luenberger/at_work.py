"""An observer at work: a reading, then the input that acts until the next."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .errors import SAMPLE, DesignError, short
from .numeric import Vector
from .numeric.validation import vector


class Turns:
    """The order of calls: at each instant `measure`, then `advance`.

    Attributes
    ----------
    instant : int
        That of the last measurement; 0 before the first.
    """

    def __init__(self, inputs: int, direct: bool) -> None:
        self.instant = 0
        self._measured, self._told = False, False
        self._direct = direct
        self._zero = np.zeros(inputs)
        self._u = self._zero  # it acts until the next measurement

    def advance(self, u: Any = None) -> None:
        """Go on to the next instant; u (m,) acts until then, default zero."""
        if not self._measured:
            raise ValueError(
                f"instant {self.instant + 1} was not measured: call measure(y) before "
                "advance"
            )
        if u is not None and self._told:
            raise ValueError("measure(y, u) had the input: call advance() without it")
        if u is not None:
            self._u = self._input(u)
        elif not self._told:
            self._u = self._zero
        self._measured = False

    def _input(self, u: Any) -> Vector:
        """Numbers, in an array of their own."""
        found = np.array(u, dtype=float)
        if found.shape != self._zero.shape or not all(map(isfinite, found.tolist())):
            return vector("u", u, len(self._zero))
        return found

    def _next(self, u: Any) -> Vector | None:
        """The input that is given with the readings of a new instant."""
        if self._measured:
            raise ValueError(
                f"instant {self.instant} was measured already: call advance(u) before "
                "the next measure"
            )
        if u is not None:
            return self._input(u)
        if self._direct:
            raise ValueError(
                "the input acts on the readings of its own instant, so give it with "
                "them: measure(y, u), then advance()"
            )
        return None

    def _done(self, u: Vector | None) -> None:
        """The instant is measured."""
        self._told = u is not None
        if u is not None:
            self._u = u
        self._measured = True


class LiveObserver(Turns):
    """An observer that gets readings as they come; `Observer.live` makes it.

    At each instant call `measure` and then `advance`.

    Attributes
    ----------
    instant : int
        That of the last measurement; 0 before the first.
    """

    def __init__(self, observer: Any, z: Vector) -> None:
        super().__init__(observer.G.shape[-1], bool(np.any(observer.W)))
        self._observer, self._z = observer, z
        self._y = np.zeros(observer.D.shape[-1])

    def measure(self, y: Any, u: Any = None) -> Vector:
        """The estimate w^ (q,) with the readings y (p,) of the next instant.

        Parameters
        ----------
        y : (p,) array_like
            All of them; a filter takes NaN, ``Filter(plant).live()``.
        u : (m,) array_like, optional
            The input of this instant, where it acts on these readings (W).
        """
        u = self._next(u)
        y = np.asarray(y, dtype=float)
        if y.shape != self._y.shape or not all(map(isfinite, y.tolist())):
            raise ValueError(
                f"y must be {len(self._y)} finite numbers, got {short(y)}; a filter "
                "takes NaN as not measured: Filter(plant).live()"
            )
        steps = self._observer.steps
        if steps is not None and self.instant == steps:
            raise ValueError(
                f"the observer was designed for {steps} rows, and all were measured; "
                f"design it with steps={steps + 1} or more"
            )
        _, _, _, P, V, W = self._observer.at(self.instant)
        self._y, self.instant = y, self.instant + 1
        self._done(u)
        found = P @ self._z + V @ y
        return found if u is None else found + W @ u

    def advance(self, u: Any = None) -> None:
        """Go on to the next instant; u (m,) acts until then, default zero."""
        super().advance(u)
        F, G, D = self._observer.at(self.instant - 1)[:3]
        self._z = F @ self._z + G @ self._u + D @ self._y


def start(
    observer: Any,
    u0: ArrayLike | None = None,
    z0: ArrayLike | None = None,
    x0: ArrayLike | None = None,
) -> Vector:
    """The observer's state at its first row."""
    o = observer
    if z0 is not None and x0 is not None:
        raise ValueError("give z0 (the observer's state) or x0 (the plant's), not both")
    if u0 is not None and o.G0 is None:
        raise ValueError(
            "u0 is the input before the first row of a filter designed over steps; a "
            "constant observer starts from z0 or x0"
        )
    if z0 is not None:
        return vector("z0", z0, o.order)
    state = o.z0 if x0 is None else o.T0 @ vector("x0", x0, o.L.shape[1])
    return state if u0 is None else state + o.G0 @ vector("u0", u0, o.G.shape[-1])


def at_work(observer: Any, u0: Any, z0: Any, x0: Any) -> LiveObserver:
    """An observer before its first measurement; u0, z0 and x0 as in `estimate`."""
    if observer.is_complex:
        raise DesignError(
            "live is for real matrices, but the observer is complex. Separate real and "
            "imaginary parts into a real one of twice the size."
        )
    if observer.dt == 0:
        raise ValueError(
            "an observer at work needs a sampling period, and this one is continuous "
            f"(dt = 0). Design it for the sampled plant: {SAMPLE}."
        )
    return LiveObserver(observer, start(observer, u0, z0, x0))
