"""Modal coordinates: every pole, or pair of conjugate poles, on its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.linalg import modes
from .system import Change, System

DIGITS_LOST = 1e6  # a pole that moves further per unit of F is nearly defective
SEEN = 1e-6  # of the largest entry: what is less is no place for a one
RESPONSE = 1e-10  # of the modes in a response: what is less is none
PAIRS = ("rotation", "companion")


class Mode(NamedTuple):
    """A pole with its left and right vectors; of a pair, the upper one."""

    pole: complex
    left: Vector
    right: Vector

    @property
    def single(self) -> bool:
        return self.pole.imag == 0


def modal(system: System, pairs: str = "rotation") -> Change:
    """Modal coordinates, scaled so that each mode has a one among its gains."""
    if pairs not in PAIRS:
        raise ValueError(
            f"pairs must be {' or '.join(map(repr, PAIRS))}, got {pairs!r}"
        )
    found = _modes(system.F)
    shown = np.array([system.P @ one.right for one in found]).T  # (q, modes)
    enters = np.array([one.left @ system.N for one in found])  # (modes, inputs)
    _require_no_cancelling(system, found, shown, enters)
    change = Change(np.empty_like(system.F), system.F, np.zeros_like(system.F))
    k = 0
    for i, one in enumerate(found):
        place = _place(shown, enters, i)
        at: slice | int = k if one.single else slice(k, k + 2)
        factor = _put_one(change, one, place, at, shown, enters, i, pairs)
        _put_mode(change, one, factor, k, pairs)
        k += 1 if one.single else 2
    change.U = np.linalg.inv(change.S)
    return change


def _put_one(
    change: Change, one: Mode, place: tuple[str, int] | None, at: slice | int,
    shown: Matrix, enters: Matrix, i: int, pairs: str,
) -> complex:  # fmt: skip
    """Note the one that a mode gets, and the zero of a pair; return its factor."""
    if place is None:
        return 1 / float(np.linalg.norm(one.left))
    name, j = place
    if name == "P":
        change.P.append(((j, at), 1 if one.single else (1, 0)))
        return shown[j, i] * (1 if one.single else 2)
    if one.single or pairs == "rotation":
        change.N.append(((at, j), 1 if one.single else (1, 0)))
        return 1 / enters[i, j]
    change.N.append(((at, j), (0, 1)))
    return -1j / (one.pole.imag * enters[i, j])


def _put_mode(change: Change, one: Mode, factor: complex, k: int, pairs: str) -> None:
    """A mode's row, or two, of S, and its block of F."""
    assert change.F is not None
    left, pole = factor * one.left, one.pole
    if one.single:
        change.S[k], change.F[k, k] = left.real, pole.real
        return
    rotates = pairs == "rotation"
    change.S[k : k + 2] = (left.real, left.imag if rotates else (pole * left).real)
    change.F[k : k + 2, k : k + 2] = (
        [[pole.real, -pole.imag], [pole.imag, pole.real]]
        if rotates
        else [[0, 1], [-(abs(pole) ** 2), 2 * pole.real]]
    )


def _place(shown: Matrix, enters: Matrix, i: int) -> tuple[str, int] | None:
    """Where mode i gets its one: in P if there is one estimate, else in [G, D].

    Each estimate and each input is seen beside its own largest entry, so that units
    have no say.
    """
    levels = {
        "P": np.abs(shown[:, i]) / _largest(shown, axis=1),
        "N": np.abs(enters[i]) / _largest(enters, axis=0),
    }
    order = ("P", "N") if len(shown) == 1 else ("N", "P")
    for name in order:
        if levels[name].max(initial=0.0) > SEEN:
            return name, int(np.argmax(levels[name]))
    return None


def _largest(X: Matrix, axis: int) -> Vector:
    top = np.abs(X).max(axis=axis, initial=0.0)
    return np.where(top > 0, top, 1.0)


def _modes(F: Matrix) -> list[Mode]:
    """The modes of F; parts that do not meet are taken apart, so their zeros stay."""
    from scipy.sparse.csgraph import connected_components  # slow to import

    count, part = connected_components(F != 0, directed=False)
    found = list[Mode]()
    for members in (np.flatnonzero(part == k) for k in range(count)):
        for one in _modes_of_part(F[np.ix_(members, members)]):
            left, right = np.zeros((2, len(F)), dtype=complex)
            left[members], right[members] = one.left, one.right
            found.append(Mode(one.pole, left, right))
    return sorted(found, key=lambda one: (one.pole.real, one.pole.imag))


def _modes_of_part(F: Matrix) -> list[Mode]:
    poles, vectors = scipy.linalg.eig(F, left=True, right=False)
    upper = np.flatnonzero(poles.imag >= 0)
    rows = [vectors[:, i].conj() for i in upper]
    single = poles[upper].imag == 0
    S = np.vstack([(row.real,) if one else (row.real, row.imag)
                   for row, one in zip(rows, single)])  # fmt: skip
    try:
        U = np.linalg.inv(S)
    except np.linalg.LinAlgError:
        U = np.full_like(S, np.inf)
    starts = np.cumsum(np.where(single, 1, 2)) - np.where(single, 1, 2)
    found = [
        Mode(
            complex(poles[i]),
            row,
            U[:, k] + 0j if one else (U[:, k] - 1j * U[:, k + 1]) / 2,
        )
        for i, row, one, k in zip(upper, rows, single, starts)
    ]
    _require_apart(found)
    return found


def _require_apart(found: list[Mode]) -> None:
    moved = [np.linalg.norm(one.left) * np.linalg.norm(one.right) for one in found]
    _refuse([one.pole for one, much in zip(found, moved) if not much <= DIGITS_LOST])


def _require_no_cancelling(
    system: System, found: list[Mode], shown: Matrix, enters: Matrix
) -> None:
    """Raise where modes are far larger than what is left of their sum, in any units."""
    if not shown.size or not enters.size:
        return
    rate = np.abs([one.pole for one in found]).max() or 1.0
    response, size = system.N, np.abs(system.P @ system.N)
    for _ in found:
        response = system.F @ response / rate
        size = np.maximum(size, np.abs(system.P @ response))
    parts = np.abs(shown[:, :, None] * enters)  # (q, modes, inputs)
    level = np.abs(shown).max(axis=1)[:, None] * np.abs(enters).max(axis=0)
    size = np.maximum(size, RESPONSE * level)
    large = (parts > DIGITS_LOST * size[:, None]).any(axis=(0, 2))
    _refuse([one.pole for one, cancels in zip(found, large) if cancels])


def _refuse(poles: list[complex]) -> None:
    if poles:
        raise DesignError(
            "there is no modal form in working precision: the poles "
            f"{modes(poles)} are defective or nearly so, and their modes cancel. Use "
            "companion(), or design with poles further apart."
        )
