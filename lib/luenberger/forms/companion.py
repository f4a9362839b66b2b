"""Companion coordinates: a chain from an estimate, or from an input of the observer."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.balance import power_of_two
from ..numeric.linalg import eigenvalues
from .system import Change, System

WORST = 1e6  # condition of the chain, its rows of length one


def chain_from(F: Matrix, row: Vector) -> tuple[Matrix, Matrix]:
    """Rows `row` F^k, k < r, and the matrix that moves them: S F = F_S S.

    Zeros and ones of F_S are set, and its last row is solved for.
    """
    r = len(F)
    poles = eigenvalues(F)
    rate = float(power_of_two(np.abs(poles).max(initial=0.0) or 1.0))
    rows = [row]
    for _ in range(r):
        rows.append(rows[-1] @ F / rate)
    S = np.array(rows[:r])
    length = np.linalg.norm(S, axis=1)
    if not length.all() or not np.isfinite(length).all():
        return S, np.full((r, r), np.nan)
    values = np.linalg.svd(S / length[:, None], compute_uv=False)
    if not values[-1] * WORST >= values[0]:
        return S, np.full((r, r), np.nan)
    unit = power_of_two(length)
    last = np.linalg.solve((S / unit[:, None]).T, rows[r]) / unit
    powers = rate ** np.arange(r)
    F_S = np.eye(r, k=1)
    F_S[-1] = last * rate * powers[-1] / powers
    return S * powers[:, None], F_S


def companion_form(
    system: System, row: int | None = None, column: int | None = None
) -> Iterator[Change]:
    """Companion coordinates from a row of P, or from a column of [G, D], that work."""
    F, N, P, _ = system
    if row is not None:
        S, F_S = chain_from(F, P[row])
        if np.isfinite(F_S).all():
            first = np.eye(1, len(F))[0]
            yield Change(S, np.linalg.inv(S), F_S, P=[((row, slice(None)), first)])
    if column is not None:
        U, F_U = chain_from(F.T, N[:, column])
        if np.isfinite(F_U).all():
            first, U = np.eye(1, len(F))[0], U.T
            entries = [((slice(None), column), first)]
            yield Change(np.linalg.inv(U), U, F_U.T, N=entries)


def require_some(found: list, chosen: str, poles: str) -> None:
    """Raise where no chain reaches all states in working precision."""
    if not found:
        raise DesignError(
            f"there is no companion form {chosen} in working precision: the chain does "
            f"not reach all states, or its rows are nearly dependent (poles {poles}). "
            "Choose another estimate or output, or use modal()."
        )
