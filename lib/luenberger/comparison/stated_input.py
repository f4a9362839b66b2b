"""Whether the input of a record is what is said of the known input."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..analysis.known_input import known_input
from ..errors import DesignError, short
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..show import number

ROUNDING = 1e-6  # of an input's size: it moves by no more where it stays at a level
SURE = 4.0  # standard errors that a mean square may be off by
SLOWEST = 0.999  # the largest factor of a model that is proposed


def require_stated(plant: Plant, u: Matrix) -> None:
    """Raise unless a record's input can be what the plant's U says.

    At a level it does not move, and is at that level.  Of white inputs the mean square
    is their variance, within its sampling error.  Other models are not judged.

    Parameters
    ----------
    plant : Plant
        With U.
    u : (N, m) ndarray

    Raises
    ------
    DesignError
        Naming the input, with what the record has, and what to write instead.
    """
    given = known_input(plant)
    if not u.size:
        return
    wrong = _levels(given.level, plant, u) if given.still else iter(())
    if isinstance(plant.U, np.ndarray) and plant.U.ndim == 2:
        wrong = _variances(np.diagonal(plant.U), plant, u)
    said = next(wrong, "")
    if said:
        raise DesignError(f"{said}. {_instead(plant, u)}")


def _levels(level: Vector, plant: Plant, u: Matrix) -> Iterator[str]:
    off = np.abs(u - level).max(axis=0)
    size = np.maximum(np.abs(level), np.abs(u).max(axis=0))
    for j in np.flatnonzero(off > ROUNDING * size):
        yield (
            f"U says that the known input {short(plant.input_names[j])} is constant "
            f"for ever at {number(level[j], 6)}, but in the record it has the "
            f"{_has(u[:, j])}"
        )


def _variances(claimed: Vector, plant: Plant, u: Matrix) -> Iterator[str]:
    squares = u**2
    error = np.maximum(np.sqrt(2) * claimed, squares.std(axis=0)) / np.sqrt(len(u))
    off = np.abs(squares.mean(axis=0) - claimed)
    for j in np.flatnonzero(off > SURE * error + ROUNDING * claimed):
        yield (
            f"U says that the known input {short(plant.input_names[j])} is white noise "
            f"with the root mean square {number(np.sqrt(claimed[j]), 6)}, but in the "
            f"record it has {number(np.sqrt(squares[:, j].mean()), 6)}: the "
            f"{_has(u[:, j])}"
        )


def _has(one: Vector) -> str:
    """Mean and deviation of an input, and between what it moves."""
    moves = f" and moves between {number(one.min(), 6)} and {number(one.max(), 6)}"
    return (
        f"mean {number(one.mean(), 6)} and the standard deviation "
        f"{number(one.std(), 6)},{moves if np.ptp(one) else ' and never moves'}"
    )


def _instead(plant: Plant, u: Matrix) -> str:
    """What to say of such an input."""
    if not np.ptp(u, axis=0).any():
        return f"Give its level, {','.join(number(one, 6) for one in u[0])}."
    square = (u**2).mean(axis=0)
    next_to = (u[1:] * u[:-1]).sum(axis=0)
    sums = (u[:-1] ** 2).sum(axis=0)
    slow = np.divide(next_to, sums, out=np.zeros_like(sums), where=sums > 0)
    slow = np.clip(slow, -SLOWEST, SLOWEST)
    driven = square * (1 - slow**2)
    model = ", ".join(
        f'"{name}": {_rows(rows)}'
        for name, rows in (
            ("A", np.diag(slow)),
            ("C", np.eye(plant.m)),
            ("Q", np.diag(driven)),
            ("R", np.zeros((plant.m, plant.m))),
        )
    )
    return (
        f'Give a plant that drives such an input, of a file with {{"dt": '
        f"{plant.dt!r}, {model}}} that this record proposes, or where samples have "
        f'nothing to do with each other {{"U": {_rows(np.diag(square))}}}.'
    )


def _rows(X: Matrix) -> str:
    """A matrix as JSON has it."""
    rows = (", ".join(f"{one:.4g}" for one in row) for row in X)
    return f"[{', '.join(f'[{row}]' for row in rows)}]"
