"""The likelihood of rows that were filtered, and what it says of their noises."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DesignError
from ..numeric import Matrices, Matrix
from ..plant import Plant
from . import passes, settled
from .pack import Passage
from .unknown import GROWN, LARGE, units


def value(passages: Sequence[Passage], plant: Plant) -> float:
    """The logarithm of the likelihood of the rows of a record."""
    pivot, nu = (np.concatenate([getattr(one.tape, k) for one in passages]).ravel()
                 for k in ("pivot", "nu"))  # fmt: skip
    total = 0.0
    if plant.P0 is None:
        large = pivot > LARGE
        if large.sum() < plant.n:
            raise _undetermined(passages, plant)
        total = float(np.log(units(plant)).sum())
        total -= 0.5 * float(np.log(pivot[large] / GROWN).sum())
        pivot, nu = pivot[~large], nu[~large]
    counted = pivot > 0
    if not counted.all():
        pivot, nu = pivot[counted], nu[counted]
    squares = float((nu * (nu / pivot)).sum())
    return total - 0.5 * (float(np.log(2 * np.pi * pivot).sum()) + squares)


def _undetermined(passages: Sequence[Passage], plant: Plant) -> DesignError:
    """Why the start cannot be found in the record."""
    variances = np.concatenate([one.variances for one in passages])
    blind = variances > LARGE
    last = np.flatnonzero(blind.any(axis=1))
    blind = blind[last[-1]] if len(last) else np.ones(plant.n, dtype=bool)
    names = [name for name, one in zip(plant.state_names, blind) if one]
    read = sum(int((one.tape.pivot >= 0).sum()) for one in passages)
    return DesignError(
        f"the plant has no P0, and the record, of {len(variances)} instants with "
        f"{read} measured values, does not determine where it starts: a combination "
        f"of {', '.join(names)} is not seen. Give P0, or a longer record, or measure "
        "more."
    )


def normalised(passages: Sequence[Passage]) -> Matrix:
    """Innovations in units of their deviations (N, p), NaN where they have none."""
    pivot, nu = (np.concatenate([getattr(one.tape, k) for one in passages])
                 for k in ("pivot", "nu"))  # fmt: skip
    counted = (pivot > 0) & (pivot < LARGE)
    return np.where(counted, nu / np.sqrt(np.where(counted, pivot, 1.0)), np.nan)


@dataclass(frozen=True)
class Score:
    """The gradient of a likelihood in the covariances of the noises.

    Attributes
    ----------
    Q, R, S : ndarray
        Each is the matrix G with ``d log_likelihood = sum(G * dX)`` for a change dX of
        all instants; Q and R are symmetric, for symmetric changes.
    """

    Q: np.ndarray
    R: np.ndarray
    S: np.ndarray

    def along(self, move: Matrices) -> float:
        """How fast the likelihood rises along {"Q", "R", "S": a direction}."""
        return float(sum((getattr(self, name) * X).sum() for name, X in move.items()))


def _parts(one: Passage) -> Iterator[tuple[slice, bool]]:
    """Rows of a passage, and whether all of them have one gain."""
    k = 0
    for same in one.settled:
        yield slice(k, same.start), False
        yield same, True
        k = same.stop
    yield slice(k, len(one.tape.nu)), False


def score(passages: Sequence[Passage], plant: Plant, joint: bool = True) -> Score:
    """That of the rows of a record; without `joint` S is zero, and takes no time."""
    n, p = plant.n, plant.p
    lam, Lam = np.zeros(n), np.zeros((n, n))
    Q, R, S = np.zeros((n, n)), np.zeros((p, p)), np.zeros((n, p))
    for one in reversed(passages):
        _, _, at, maps, mix = one.packed
        R_at = np.zeros((len(mix), p, p))
        S_at = np.zeros((len(mix) * joint, n, p))
        for rows, same in reversed(list(_parts(one))):
            given = at[rows.start : rows.stop + 1], maps, settled.part(one.tape, rows)
            if same:
                settled.back(*given, lam, Lam, Q, R_at)
            else:
                run: Any = passes.score.fast
                run(*given, lam, Lam, Q, R_at, S_at)
        R += (mix.mT @ R_at @ mix).sum(axis=0)
        if joint:
            S += (S_at @ mix).sum(axis=0)
    return Score(0.5 * Q, 0.5 * R, S)
