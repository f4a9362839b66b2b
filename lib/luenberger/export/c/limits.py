"""How far the estimates of an exported observer are from exact ones, at most.

What is exact, and what the device makes of it, are told apart matrix by matrix.  The
bound holds at every instant, and follows export/derivation/rounding.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...kernels import run
from ...numeric import Matrices, Matrix, Vector
from ...numeric.power_sums import SLACK, PowerSums, power_sums, proved
from ...observer import Observer
from ..derivation import added, errs

UNIT = {"float": 2.0**-24, "double": 2.0**-53}  # rounding of one operation
LEAST = {"float": 2.0**-126, "double": 2.0**-1022}  # numbers with all digits
EXTENDED = 1 + 2.0**-10  # sums that are kept longer and rounded when they are stored


@dataclass(frozen=True, eq=False)
class Limits:
    """Sizes entry by entry, in columns: of each case that was asked for, one.

    Attributes
    ----------
    state, state_error : (r, c) ndarray
    estimate, error : (q, c) ndarray
        How large the exact ones are, and how far those of the device are off.
    """

    state: np.ndarray
    state_error: np.ndarray
    estimate: np.ndarray
    error: np.ndarray


@dataclass(eq=False)
class Exact:
    """An observer with inputs and measurements as one, and the sums of its powers."""

    observer: Observer
    blocks: Matrices = field(init=False)
    powers: PowerSums | None = field(init=False)

    def __post_init__(self) -> None:
        self.blocks, one = blocks(self.observer), self.observer
        whole = np.eye(one.order)
        inputs = np.hstack([whole, self.blocks["B"]])
        first = np.hstack([one.z0[:, None], whole])
        self.powers = power_sums(self.blocks["F"], self.blocks["P"], inputs, first)

    def limits(
        self, device: Device, start: Vector, s: Matrix, ds: Matrix
    ) -> Limits | None:
        """The bounds; None where none was proved.

        `start` is the first state of the device; what it lacks is an error at first.
        `s` are the sizes of inputs and measurements, `ds` those of their rounding,
        (m + p, c).  What does not depend on them is in the last column.
        """
        sums, r = self.powers, self.observer.order
        if sums is None:
            return None
        lacks = np.abs(start - self.observer.z0)
        state, first = sums.sums[:, r:] @ s, np.zeros((r, s.shape[1]))
        estimate = (np.abs(self.blocks["V"]) + sums.seen[:, r:]) @ s
        shown = np.zeros((len(estimate), s.shape[1]))
        state[:, -1] += sums.peaks[:, 0]
        estimate[:, -1] += sums.seen_peaks[:, 0]
        first[:, -1] = sums.peaks[:, 1:] @ lacks
        shown[:, -1] = sums.seen_peaks[:, 1:] @ lacks
        have = device.sizes(self.blocks, s.shape[1])
        have |= dict(Z=state, s_fs=s + ds, ds_s=ds, a_0=first, a_0w=shown)
        have |= dict(S=sums.sums[:, :r], S_P=sums.seen[:, :r])
        have |= run(added, have)
        none = np.zeros_like(state)
        once = run(errs, have | dict(e_s=none), "a_e")["a_e"]
        error = proved(have["S"] @ have["M_z"], once * (1 + SLACK))
        if error is None:
            return None
        found = run(errs, have | dict(e_s=error), "a_w")["a_w"] * (1 + SLACK)
        sizes = (X * (1 + SLACK) for X in (state, error, estimate))
        state, error, estimate = sizes
        everything = (state, error, estimate, found)
        return Limits(*everything) if all(map(_finite, everything)) else None


@dataclass(eq=False)
class Device:
    """What a device makes of an observer: its matrices, and how it rounds sums.

    Attributes
    ----------
    blocks : dict
        F, B, P, V in its numbers.
    part_z, part_w : (r,), (q,) ndarray
        What rounding is of the sizes that a sum adds up, at most.
    least_z, least_w : (r,), (q,) ndarray
        What it is besides, at most.
    """

    blocks: Matrices
    part_z: np.ndarray
    part_w: np.ndarray
    least_z: np.ndarray
    least_w: np.ndarray

    def sizes(self, exact: Matrices, columns: int) -> Matrices:
        """By the letters of the derivation; what is constant in the last column."""
        have = {f"d{k}_s": np.abs(self.blocks[k] - exact[k]) for k in "FBPV"}
        have |= {f"{k}_fs": np.abs(self.blocks[k]) for k in "FBPV"}
        have |= {f"{k}_s": np.abs(exact[k]) for k in "BV"}
        have |= dict(gamma_z=np.diag(self.part_z), gamma_w=np.diag(self.part_w))
        for letter, least in (("eta_z", self.least_z), ("eta_w", self.least_w)):
            have[letter] = np.zeros((len(least), columns))
            have[letter][:, -1] = least
        return have


def blocks(observer: Observer) -> Matrices:
    """F, B = [G, D], P and V = [W, V]: inputs first, then measurements."""
    one = observer
    B, V = np.hstack([one.G, one.D]), np.hstack([one.W, one.V])
    return dict(F=one.F, B=B, P=one.P, V=V)


def floating(observer: Observer, real: str) -> Device:
    """A device that computes in floating point, of an observer in its numbers.

    In any order of a sum, with products rounded or not, with intermediate results in
    more digits or not, with small numbers flushed to zero or not.
    """
    made = blocks(observer)
    (part_z, least_z), (part_w, least_w) = (
        _sums(np.hstack([made[one], made[two]]), real) for one, two in ("FB", "PV")
    )
    return Device(made, part_z, part_w, least_z, least_w)


def _sums(rows: Matrix, real: str) -> tuple[Vector, Vector]:
    """Of sums with these coefficients: rounding beside the sizes, and besides it.

    A zero adds nothing, and a product with a power of two is exact.
    """
    terms = (rows != 0).sum(axis=1)
    whole = (np.abs(np.frexp(rows)[0]) == 0.5) | (rows == 0)
    times = np.maximum(terms - 1, 0) + ~whole.all(axis=1)
    lost = times * UNIT[real] * EXTENDED
    least = 2 * LEAST[real] * (2 * terms + np.abs(rows).sum(axis=1))
    return lost / (1 - lost), least


def each(observer: Observer, real: str) -> tuple[Matrix, Matrix]:
    """`s` and `ds` of floating point: each signal of size one alone, and none."""
    k = observer.G.shape[1] + observer.D.shape[1]
    s = np.eye(k, k + 1)
    ds = s * UNIT[real] * EXTENDED
    ds[:, -1] = LEAST[real]
    return s, ds


def _finite(X: Matrix) -> bool:
    return bool(np.isfinite(X).all())
