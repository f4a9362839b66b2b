"""A bound on rounding as an object, and as lines of a header."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import ROUND_UP, Context, Decimal
from textwrap import wrap

import numpy as np

from ...analysis.step_cost import narrowed
from ...numeric import Matrix, Vector
from ...observer import Observer
from ...plant import Plant
from .identifiers import quoted
from .limits import Exact, Limits, each, floating
from .ranges import missing, ranges
from .source_and_header import Signals

WIDTH = 80


@dataclass(frozen=True)
class Words:
    """What a bound is about.

    Attributes
    ----------
    chains : str
        Where it is proved.
    beside : str
        What estimates are compared with.
    premise : str
        What has to be so besides the ranges; may be empty.
    """

    chains: str
    beside: str
    premise: str = ""


OBSERVER = Words(
    "luenberger/export/derivation/rounding.py", "exact sums of the matrices in double"
)


@dataclass(frozen=True, eq=False)
class RoundingBound:
    """How far the estimates of exported C are from exact ones, proved.

    The exact ones are those of the observer's matrices in double, without rounding, at
    the readings before they are rounded for the device.

    Attributes
    ----------
    dtype : str
        What the C computes in.
    largest : (q,) ndarray
        The bound, at every instant, in the units of each estimate.
    names : tuple of str
        Of the estimates.
    ranges : tuple of (str, float)
        Inputs and measurements with their largest sizes.  The bound holds while none
        of them is beyond.
    source : str
        Where ranges come from that were not given; may be empty.
    words : Words
        Where it is proved, beside what, and what else it takes.
    """

    dtype: str
    largest: np.ndarray
    names: tuple
    ranges: tuple[tuple[str, float], ...]
    source: str
    words: Words = OBSERVER

    @property
    def sentences(self) -> list[str]:
        """The bound in words, and what it takes."""
        said = [f"Rounding in {self.dtype}, proved:"]
        for name, bound in zip(self.names, self.largest, strict=True):
            said.append(f"{name}: off by at most {upward(bound)}.")
        listed = ", ".join(f"|{k}| <= {size:g}" for k, size in self.ranges)
        said.append(f"This holds while {listed or 'there is nothing to read'}.")
        if self.words.premise:
            said.append(f"It takes that {self.words.premise}.")
        return said + ([self.source] if self.source else [])

    def __repr__(self) -> str:
        return "\n".join(self.sentences)

    def notes(self) -> list[str]:
        """The same as lines of a header."""
        lines = ["", f"Rounding, proved in {self.words.chains}: while"]
        lines += [
            f"    {quoted(k)} is at most {size!r} in size," for k, size in self.ranges
        ]
        lines += wrapped(
            "each estimate is off by at most the following, at every instant, beside "
            f"{self.words.beside}:"
        )
        for name, bound in zip(self.names, self.largest, strict=True):
            lines.append(f"    {quoted(name)}: {upward(bound)}")
        return lines + taken(self.words) + wrapped(self.source)


COMPILED = (
    "A compiler may fuse products and sums, and do nothing else of what -ffast-math "
    "allows."
)


def taken(words: Words) -> list[str]:
    """What a bound takes besides ranges, as lines of a header."""
    if not words.premise:
        return []
    return wrapped(f"It takes that {words.premise}.  {COMPILED}")


def floating_notes(
    observer: Observer,
    real: str,
    signals: Signals,
    plant: Plant | None,
    given: Mapping[str, float] | None,
) -> list[str]:
    """Lines of the header of an observer in floating point, the exact one given."""
    limits, sizes, source = _floating(observer, real, signals, plant, given)
    if limits is None:
        return ["", "No bound on rounding was proved: the observer is too slow."]
    if missing(sizes, signals):
        return by_signal(limits.error, signals, OBSERVER)
    return _bound(limits, sizes, source, real, signals).notes()


def floating_bound(
    observer: Observer,
    real: str,
    signals: Signals,
    plant: Plant | None,
    given: Mapping[str, float] | None,
) -> tuple[RoundingBound | None, Vector]:
    """The bound in floating point, None where none was proved; and the ranges."""
    limits, sizes, source = _floating(observer, real, signals, plant, given)
    if limits is None or missing(sizes, signals):
        return None, sizes
    return _bound(limits, sizes, source, real, signals), sizes


def _floating(
    observer: Observer,
    real: str,
    signals: Signals,
    plant: Plant | None,
    given: Mapping[str, float] | None,
) -> tuple[Limits | None, Vector, str]:
    sizes, source = ranges(signals, plant, given)
    device = narrowed(observer, real)
    made, read = floating(device, real), each(observer, real)
    return Exact(observer).limits(made, device.z0, *read), sizes, source


def _bound(
    limits: Limits, sizes: Vector, source: str, real: str, signals: Signals
) -> RoundingBound:
    largest = limits.error @ np.append(sizes, 1.0)
    return RoundingBound(real, largest, signals.what, by_name(signals, sizes), source)


def by_name(signals: Signals, sizes: Vector) -> tuple[tuple[str, float], ...]:
    """Ranges with the names of inputs and measurements."""
    return tuple(zip((*signals.u, *signals.y), sizes.tolist(), strict=True))


def by_signal(error: Matrix, signals: Signals, words: Words) -> list[str]:
    """What each signal adds to the error, where ranges are not known."""
    lines = ["", f"Rounding, proved in {words.chains}:"]
    lines += wrapped(
        "each estimate is off by at most the sum of the following, at every instant, "
        f"beside {words.beside}.  max is the largest size of a signal so far."
    )
    for name, row in zip(signals.what, error, strict=True):
        lines.append(f"    {quoted(name)}:")
        parts = [f"{upward(row[-1])}"] if row[-1] else []
        for one, size in zip((*signals.u, *signals.y), row, strict=False):
            parts += [f"{upward(size)} max {quoted(one)}"] if size else []
        lines += [f"        {part}" for part in parts or ["0"]]
    return lines + taken(words)


def upward(value: float) -> str:
    """Three digits, rounded up.

    >>> upward(1.2301e-7), upward(0.0), upward(250.0)
    ('1.24e-07', '0', '250')
    """
    rounded = Context(prec=3, rounding=ROUND_UP).plus(Decimal(float(value)))
    return f"{float(rounded):.3g}"


def wrapped(text: str) -> list[str]:
    """A sentence in lines of a header."""
    return wrap(text, WIDTH)
