"""Whole numbers for an observer: how many places each signal and each sum gets.

Every signal has a range that it cannot leave, proved, and the finest places at which
that range fits.  Sums are exact: no sum of products can leave its own whole number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ...numeric import Matrices, Matrix, Vector
from .limits import Device, Exact, Limits

SUM = {16: 32, 32: 64}  # bits of a sum of products
NEAREST = 0.5 * (1 + 1e-9)  # of a count, with what a sum in double does to it
TRIES = 64  # of places, one less at a time where a signal did not fit


class Unfit(Exception):
    """Why so many bits do not suffice."""


class Row(NamedTuple):
    """A sum of products in whole numbers, rounded to nearest after a shift."""

    weights: tuple[int, ...]
    shift: int

    @property
    def rounds(self) -> bool:
        """Whether anything can be left to round."""
        return any(w % 2**self.shift for w in self.weights)

    def __call__(self, signals: Sequence[int]) -> int:
        """The row of these whole numbers, exactly as the device computes it."""
        total = sum(w * s for w, s in zip(self.weights, signals, strict=True))
        size = (abs(total) + 2 ** (self.shift - 1)) >> self.shift
        return -size if total < 0 else size


@dataclass(frozen=True, eq=False)
class Formats:
    """An observer in whole numbers.

    Attributes
    ----------
    bits : int
    read, state, shown : tuple of int
        Places behind the binary point of inputs and measurements, states, estimates.
    most : tuple of int
        The largest whole number of each input and measurement.
    start : tuple of int
        The first state.
    moves, shows : tuple of Row
        Of each state and each estimate: weights of states, inputs, measurements.
    limits : Limits
        One column: sizes and errors in units of the plant.
    """

    bits: int
    read: tuple[int, ...]
    state: tuple[int, ...]
    shown: tuple[int, ...]
    most: tuple[int, ...]
    start: tuple[int, ...]
    moves: tuple[Row, ...]
    shows: tuple[Row, ...]
    limits: Limits

    def run(self, read: Sequence[Sequence[int]]) -> list[list[int]]:
        """Estimates of rows of inputs and measurements, all in whole numbers."""
        z, shown = list(self.start), []
        for row in read:
            signals = [*z, *row]
            shown.append([one(signals) for one in self.shows])
            z = [one(signals) for one in self.moves]
        return shown


def largest(bits: int) -> int:
    """Of whole numbers with a sign; the other end, one further, stands for none."""
    return 2 ** (bits - 1) - 1


def formats(
    exact: Exact, ranges: Vector, bits: int, states: list[str], what: list[str]
) -> Formats:
    """Places for all signals of an observer whose inputs stay within `ranges`.

    Raises
    ------
    Unfit
        If a weight, a signal or what is left of an estimate asks for more bits.
    """
    read = [places(size, largest(bits) - 1) for size in ranges.tolist()]
    most = [int(np.ceil(np.ldexp(size, k))) for size, k in zip(ranges, read)]
    sizes = np.ldexp(np.array(most, float), -np.array(read, int))[:, None]
    half = np.ldexp(NEAREST, -np.array(read, int))[:, None]
    bare = exact.limits(_same(exact), exact.observer.z0, sizes, 0 * half)
    if bare is None:
        raise Unfit("the observer is too slow for a bound of its states")
    state = [places(size, largest(bits)) for size in bare.state[:, 0].tolist()]
    shown = [places(size, largest(bits)) for size in bare.estimate[:, 0].tolist()]
    for _ in range(TRIES):
        made = _Whole(exact, bits, read, state, shown, most, states, what)
        limits = made.limits(sizes, half)
        wide = [
            _wide(limits.state + limits.state_error, state, bits),
            _wide(limits.estimate + limits.error, shown, bits),
        ]
        if not any(map(any, wide)):
            _require_digits(limits, what)
            return Formats(
                bits, tuple(read), tuple(state), tuple(shown), tuple(most),
                tuple(made.start), tuple(made.moves), tuple(made.shows), limits,
            )  # fmt: skip
        state, shown = (
            [k - int(more) for k, more in zip(ks, mores, strict=True)]
            for ks, mores in zip((state, shown), wide, strict=True)
        )
    raise Unfit("no places were found at which every state fits with its error")


def places(size: float, most: int) -> int:
    """The most places at which a size is a whole number of at most `most`.

    >>> places(1.0, 127), places(0.75, 127), places(300.0, 127), places(0.0, 127)
    (6, 7, -2, 6)
    """
    if size == 0:
        size = 1.0
    k = int(np.floor(np.log2(most / size))) + 1
    while Fraction(size) * Fraction(2) ** k > most:
        k -= 1
    return k


def _wide(sizes: Matrix, places_: list[int], bits: int) -> list[bool]:
    """Whether a whole number of this size, rounded, may be beyond the largest one."""
    room = np.ldexp(float(largest(bits)), -np.array(places_, int))
    return list(sizes[:, 0] * (1 + 1e-12) > room)


def _require_digits(limits: Limits, what: list[str]) -> None:
    for name, error, size in zip(what, limits.error[:, 0], limits.estimate[:, 0]):
        if error >= size > 0:
            raise Unfit(
                f"the estimate {name!r} may be off by {error:.3g}, and is itself at "
                f"most {size:.3g}"
            )


def _same(exact: Exact) -> Device:
    """A device without rounding."""
    r, q = exact.blocks["F"].shape[0], exact.blocks["P"].shape[0]
    return Device(exact.blocks, np.zeros(r), np.zeros(q), np.zeros(r), np.zeros(q))


class _Whole:
    """Weights and first states at given places."""

    def __init__(
        self, exact: Exact, bits: int, read: list[int], state: list[int],
        shown: list[int], most: list[int], states: list[str], what: list[str],
    ) -> None:  # fmt: skip
        self.exact, self.bits, self.state, self.shown = exact, bits, state, shown
        self.places, self.sizes = state + read, [largest(bits)] * len(state) + most
        self.start = [_nearest(z, k) for z, k in zip(exact.observer.z0.tolist(), state)]
        back = [
            float(Fraction(z) / Fraction(2) ** k) for z, k in zip(self.start, state)
        ]
        self.first, one = np.array(back), exact.blocks
        self.moves = self.rows(np.hstack([one["F"], one["B"]]), state, "state", states)
        self.shows = self.rows(np.hstack([one["P"], one["V"]]), shown, "estimate", what)

    def rows(
        self, X: Matrix, places_: list[int], kind: str, names: list[str]
    ) -> list[Row]:
        found = []
        for row, k, name in zip(X.tolist(), places_, names, strict=True):
            exact = [
                Fraction(x) * Fraction(2) ** (k - one)
                for x, one in zip(row, self.places, strict=True)
            ]
            found.append(_row(exact, self.sizes, self.bits, f"the {kind} {name!r}"))
        return found

    def limits(self, sizes: Matrix, half: Matrix) -> Limits:
        r, q = len(self.state), len(self.shown)
        made: Matrices = {}
        for one, two, rows, places_ in (
            ("F", "B", self.moves, self.state),
            ("P", "V", self.shows, self.shown),
        ):
            whole = [
                [
                    float(w / Fraction(2) ** (row.shift + k - own))
                    for w, own in zip(map(Fraction, row.weights), self.places)
                ]
                for row, k in zip(rows, places_, strict=True)
            ]
            both = np.array(whole).reshape(len(rows), len(self.places))
            made[one], made[two] = both[:, :r], both[:, r:]
        half_z, half_w = (
            np.array([row.rounds for row in rows]) * np.ldexp(0.5, -np.array(ks, int))
            for rows, ks in ((self.moves, self.state), (self.shows, self.shown))
        )
        device = Device(made, np.zeros(r), np.zeros(q), half_z, half_w)
        found = self.exact.limits(device, self.first, sizes, half)
        if found is None:
            raise Unfit("rounding the weights makes the error grow without a bound")
        return found


def _row(exact: list[Fraction], sizes: list[int], bits: int, what: str) -> Row:
    """Weights as fine as bits and sum allow, then as small as they are exact."""
    most, total = largest(bits), largest(SUM[bits])
    for shift in range(SUM[bits] - 2, 0, -1):
        weights = [round(x * 2**shift) for x in exact]
        sum_ = sum(abs(w) * size for w, size in zip(weights, sizes, strict=True))
        fits = max(map(abs, weights), default=0) <= most
        if fits and sum_ + 2 ** (shift - 1) <= total:
            break
    else:
        raise Unfit(f"{what} is a sum of parts that are much larger than itself")
    while shift > 1 and not any(w % 2 for w in weights):
        weights, shift = [w // 2 for w in weights], shift - 1
    return Row(tuple(weights), shift)


def _nearest(value: float, places_: int) -> int:
    return round(Fraction(value) * Fraction(2) ** places_)
