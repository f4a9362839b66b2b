"""What a record shows of changes of the noises, instant by instant.

For plants that vary over time and records with gaps there is no constant gain.  The
gains are those of a Kalman filter for noises of size one, under which errors die out.
An instant shows a change of what the next error has in common with its innovation only
as far as later outputs show that error.
"""

from typing import Any

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix
from ..numeric.covariance_maps import packing
from ..numeric.independent_rows import outside
from ..numeric.linalg import RANK_TOL
from ..plant import Plant
from ..run.filter import Filter
from .derivation import change_step

TOGETHER = 64  # instants that are asked at first, and whose rows are reduced at once
CLEAR = 1e-4  # least singular value of what determines every change


def shown_by(A: Matrix, C: Matrix, changes: Matrices, seen: Matrix) -> Matrix:
    """A square root of what a record shows of the changes, for any start.

    It is measured by what the record would show of them if the start were known.

    What a part of a record shows, the record shows.  So later instants are left out
    where those before determine every change clearly.

    Parameters
    ----------
    A, C : (n, n) and (p, n), or stacks of them, ndarray
        In units in which their numbers are of like size.
    changes : dict
        {"Q", "R", "S"}: stacks (k, ., .), in these units.
    seen : (N, p) ndarray of bool

    Returns
    -------
    (r, k) ndarray
    """
    n = A.shape[-1]
    one = Plant(A, None, C, Q=np.eye(n), R=np.eye(C.shape[-2]), P0=np.eye(n), dt=1.0)
    rows = TOGETHER
    while True:
        shown = _shown(one, changes, seen[:rows])
        if rows >= len(seen) or _clear(shown):
            return shown
        rows *= 2


def _shown(plant: Plant, changes: Matrices, seen: Matrix) -> Matrix:
    n, count = plant.n, len(changes["Q"])
    _, unpack = packing(n)
    first = unpack(np.eye(n * (n + 1) // 2))
    wide = {k: np.concatenate([np.zeros((len(first), *X.shape[1:])), X])
            for k, X in changes.items()}  # fmt: skip
    X = np.concatenate([first, np.zeros((count, n, n))])
    gains = Filter(plant).run(np.where(seen, 0.0, np.nan)).K
    later = _later(plant, gains, seen)
    root = np.zeros((0, len(X)))
    for k in range(0, len(seen), TOGETHER):
        here = range(k, min(k + TOGETHER, len(seen)))
        rows, X = _rows(plant, here, gains, later, seen, wide, X)
        root = _triangle(np.vstack([root, *rows]))
    # The start's covariance explains what it can; a record need not show all of it.
    given = root[:, len(first) :]
    largest = max(np.linalg.norm(given, 2), 1e-300)
    of_start, size, _ = np.linalg.svd(root[:, : len(first)], full_matrices=False)
    of_start = of_start[:, size > RANK_TOL * max(size.max(initial=0.0), largest)]
    left = outside(given.T, of_start.T).T / largest
    return np.pad(left, ((0, max(0, count - len(left))), (0, 0)))


def _at(plant: Plant, k: int, gains: Matrix, seen: Matrix) -> tuple[Matrix, ...]:
    """A_L, C and L at a row, of the outputs that are seen there."""
    at, now = seen[k], plant.at(k + 1)
    C, L = now.C[at], now.A @ gains[k][:, at]
    return now.A - L @ C, C, L


def _triangle(X: Matrix) -> Matrix:
    """R of X = Q R."""
    found: Any = np.linalg.qr(X, mode="r")
    return np.asarray(found)


def _later(plant: Plant, gains: Matrix, seen: Matrix) -> list[Matrix]:
    """For each row, a square root of what the rows after it show of the next error."""
    found = [np.zeros((0, plant.n))]
    for k in range(len(seen) - 1, 0, -1):
        A_L, C, _ = _at(plant, k, gains, seen)
        found.append(_triangle(np.vstack([C, found[-1] @ A_L])))
    return found[::-1]


def _rows(
    plant: Plant, here: range, gains: Matrix, later: list[Matrix], seen: Matrix,
    wide: Matrices, X: Matrix,
) -> tuple[list[Matrix], Matrix]:  # fmt: skip
    """What some rows show of the changes, and how these go on after them."""
    step, rows = kernels.compiled(change_step, stacks=True), list[Matrix]()
    for k in here:
        at, (A_L, C, L) = seen[k], _at(plant, k, gains, seen)
        found = step(
            A_L=A_L, C=C, L=L, dQ=wide["Q"],
            dR=wide["R"][:, at][:, :, at], dS=wide["S"][:, :, at], X=X,
        )  # fmt: skip
        for one in (found["dLambda_0"], later[k] @ found["dN_1"]):
            rows.append(one.reshape(len(X), one[0].size).T)
        X = found["X_next"]
    return rows, X


def _clear(shown: Matrix) -> bool:
    """Whether every change is shown, far from rounding."""
    values = np.linalg.svd(shown, compute_uv=False)
    return bool(values.min(initial=1.0) > CLEAR)
