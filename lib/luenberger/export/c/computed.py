"""Matrices as a device computes them, of which bounds are known entry by entry.

A program that runs on them bounds its own rounding: in any order of a sum, with
products fused or not, with intermediate results in more digits or not, and with small
numbers flushed to zero or not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...kernels.program import (
    IDENTITY,
    Assign,
    Operand,
    Program,
    Substitute,
    Term,
)
from ...numeric import Matrix
from ...numeric.factors import EPS
from .limits import EXTENDED, LEAST, UNIT

HERE = 2.0**-53  # rounding of one operation where bounds are computed
Errors = dict[str, tuple[Matrix, Matrix]]


@dataclass(eq=False)
class Computed:
    """A matrix on a device, around one that is known.

    Attributes
    ----------
    value : (a, b) ndarray
        What is known.
    wide : (a, b) ndarray
        How far the matrix is from that at most, without rounding on the device.
    noise : (2, a, b) ndarray
        What rounding adds at most, on the device and to `value` here.
    joint : bool
        Whether the columns are parts of one: what different signals are to blame for.
    errors : dict
        Roundings of matrices before, and what they are multiplied by from the right on
        their way into this one; they are part of `noise`.
    """

    value: np.ndarray
    wide: np.ndarray
    noise: np.ndarray
    joint: bool = False
    errors: Errors = field(default_factory=dict)
    most: np.ndarray = field(init=False)
    size: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.most = np.abs(self.value) + self.wide
        self.size = self.most + self.noise[0]

    @classmethod
    def of(
        cls,
        value: Matrix,
        wide: Matrix | float = 0.0,
        off: Matrix | float = 0.0,
        joint: bool = False,
    ) -> Computed:
        """A matrix that is known but for `wide`, and off by `off` on the device."""
        none = np.zeros_like(value)
        return cls(value, none + wide, np.stack([none + off, none]), joint)

    @property
    def off(self) -> Matrix:
        """What rounding on the device adds at most."""
        return np.asarray(self.noise[0])

    @property
    def lost(self) -> Matrix:
        """How far `value` is from what it stands for, as it was computed here."""
        return np.asarray(self.noise[1])

    @property
    def T(self) -> Computed:
        """The transpose."""
        return Computed(self.value.T, self.wide.T, self.noise.swapaxes(1, 2))

    def exactly(self) -> Computed:
        """The same matrix, as one that is not rounded but may be anywhere around."""
        wide = self.wide + self.noise.sum(axis=0)
        return Computed(self.value, wide, np.zeros_like(self.noise), self.joint)

    @property
    def felt(self) -> Matrix:
        """Ones where an entry may be another number than zero."""
        there = self.size > 0
        if self.joint:
            there = np.broadcast_to(there.any(axis=1, keepdims=True), there.shape)
        return there.astype(float)

    @property
    def inexact(self) -> Matrix:
        """Ones where a product with an entry may have to be rounded."""
        whole = (self.size == np.abs(self.value)) & (
            np.abs(np.frexp(self.value)[0]) == 0.5
        )
        return self.felt * ~whole


@dataclass(eq=False)
class Parts:
    """What a sum adds up: itself, sizes, and how often it is rounded."""

    value: np.ndarray
    wide: np.ndarray
    noise: np.ndarray
    size: np.ndarray
    terms: np.ndarray
    inexact: np.ndarray
    least: np.ndarray
    errors: Errors

    def __add__(self, other: Parts) -> Parts:
        numbers: Any = {k: getattr(self, k) + getattr(other, k) for k in NUMBERS}
        return Parts(**numbers, errors=_together(self.errors, other.errors))


NUMBERS = ("value", "wide", "noise", "size", "terms", "inexact", "least")


def passed(
    program: Program,
    given: Mapping[str, Computed],
    real: str,
    solved: Callable[[Computed, Computed], Computed],
    apart: Mapping[str, str],
) -> tuple[dict[str, Computed], dict[str, Computed]]:
    """All matrices of a program, and those whose rounding is counted by itself.

    ``solved(N, M)`` is what the program solves for.  What follows a matrix in `apart`
    takes it as one that is not rounded.
    """
    have, alone = dict(given), dict[str, Computed]()

    def of(operand: Operand) -> Computed:
        found = have[operand.name]
        return found.T if operand.turned else found

    for step in program.steps:
        if isinstance(step, Assign):
            have[step.target] = _assigned(step, of, real)
        elif isinstance(step, Substitute):
            have[step.target] = solved(of(step.right), have[step.matrix])
        if isinstance(step, Assign | Substitute) and step.target in apart:
            alone[apart[step.target]] = have[step.target]
            have[step.target] = have[step.target].exactly()
    return have, alone


def _assigned(step: Assign, of: Callable[[Operand], Computed], real: str) -> Computed:
    """A sum, rounded: on the device as export/c/limits.py counts, and here."""
    joint = False
    found: Parts | None = None
    for term in step.terms:
        factors = [of(one) for one in term.factors if one.name != IDENTITY]
        joint |= any(one.joint for one in factors)
        part = _term(term, factors, found)
        found = part if found is None else found + part
    assert found is not None
    times = np.maximum(found.terms - 1, 0) + (found.inexact > 0)
    rounds = np.stack([times * UNIT[real], (found.terms + 1) * HERE]) * EXTENDED
    new = found.noise + rounds / (1 - rounds) * found.size
    new[0] += 2 * LEAST[real] * found.least
    noise = new + sum(S @ np.abs(right) for S, right in found.errors.values())
    wide = found.wide + (found.terms + 1) * EPS * found.size
    errors = found.errors | {step.target: (new, np.eye(new.shape[-1]))}
    if step.symmetric and not joint:
        wide, noise = np.maximum(wide, wide.T), np.maximum(noise, noise.swapaxes(1, 2))
        found.value, errors = (found.value + found.value.T) / 2, {}
    return Computed(found.value, wide, noise, joint, errors)


def _term(term: Term, factors: list[Computed], before: Parts | None) -> Parts:
    """One term: a matrix, the product of two, or a multiple of the identity."""
    scale = float(term.scale)
    if not factors:
        assert before is not None
        value = scale * np.eye(len(before.value))
        none, one = np.zeros_like(value), np.abs(value)
        return Parts(value, none, np.stack([none, none]), one, 1.0 * (one > 0), none,
                     none, {})  # fmt: skip
    if len(factors) == 1:
        (a,) = factors
        noise = np.zeros_like(a.noise) if a.errors else a.noise
        none = np.zeros_like(a.value)
        found = Parts(a.value, a.wide, noise, a.size, a.felt, none, a.felt, a.errors)
    else:
        found = _product(*factors)
    if abs(scale) != 1:
        found.inexact = found.inexact + (np.frexp(abs(scale))[0] != 0.5) * found.terms
    found.value = scale * found.value
    for name in ("wide", "noise", "size"):
        setattr(found, name, abs(scale) * getattr(found, name))
    found.errors = {k: (S, scale * right) for k, (S, right) in found.errors.items()}
    return found


def _product(a: Computed, b: Computed) -> Parts:
    beside = b.off + b.wide + (len(b.value) + 4) * EPS * np.abs(b.value)
    return Parts(
        value=a.value @ b.value,
        wide=a.wide @ b.most + np.abs(a.value) @ b.wide,
        noise=a.noise @ (beside if a.errors else b.size) + a.most @ b.noise,
        size=a.size @ b.size,
        terms=a.felt @ b.felt,
        inexact=a.inexact @ b.inexact,
        least=2 * a.felt @ b.felt + a.size @ b.felt + a.felt @ b.size,
        errors={k: (S, right @ b.value) for k, (S, right) in a.errors.items()},
    )


def _together(a: Errors, b: Errors) -> Errors:
    """Errors of two terms; of one matrix they go both ways."""
    both = {k: (a[k][0], a[k][1] + b[k][1]) for k in a.keys() & b.keys()}
    return a | b | both
