"""What a record shows of changes of the noises, instant by instant.

For plants that vary over time and records with gaps there is no constant gain.  The
gains are those of a Kalman filter for noises of size one, under which errors die out.
"""

from collections.abc import Iterator

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import packing
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.settings import Settings
from ..recursion.state import start
from .derivation import change_step

TOGETHER = 64  # instants whose rows are reduced at once
CLEAR = 1e-4  # least singular value of what determines every change, beside the largest


def shown_by(
    plant: Plant, changes: Matrices, seen: Matrix | None, x: Vector, y: Vector
) -> Matrix:
    """A square root of what a record shows of the changes, for any start.

    Later instants are left out once those before determine every change clearly: what
    a part of a record shows, the record shows.

    Parameters
    ----------
    plant : Plant
    changes : dict
        {"Q", "R", "S"}: stacks (k, ., .), in the units x of states and y of outputs.
    seen : (N, p) array_like of bool, or None for all
    x, y : (n,), (p,) ndarray

    Returns
    -------
    (k, k) ndarray
    """
    plant, seen = _unit_noise(plant, seen, x, y)
    n, count = plant.n, len(changes["Q"])
    _, unpack = packing(n)
    first = unpack(np.eye(n * (n + 1) // 2))
    wide = {k: np.concatenate([np.zeros((len(first), *X.shape[1:])), X])
            for k, X in changes.items()}  # fmt: skip
    X = np.concatenate([first, np.zeros((count, n, n))])
    root, shown = np.zeros((0, len(X))), np.zeros((count, count))
    for here, gains in _gains(plant, seen):
        rows, X = _rows(plant, here, gains, seen, wide, X)
        root = np.linalg.qr(np.vstack([root, *rows]), mode="r")
        root = np.pad(root, ((0, max(0, len(X) - len(root))), (0, 0)))
        shown = root[len(first) : len(X), len(first) :]
        if _clear(shown):
            break
    return shown


def _gains(plant: Plant, seen: Matrix) -> Iterator[tuple[slice, Matrix]]:
    """Some rows at a time, and the gains of the filter there."""
    settings = Settings(plant, 0)
    state = start(settings, plant.x0, np.zeros(0))
    fast = kernels.runs_compiled("auto", len(seen))
    for k in range(0, len(seen), TOGETHER):
        here = slice(k, min(k + TOGETHER, len(seen)))
        y, u = np.where(seen[here], 0.0, np.nan), np.zeros((here.stop - k, 0))
        state, out = Pass(settings).over(state, y, u, fast, history=True)
        yield here, out.K


def _rows(
    plant: Plant, here: slice, gains: Matrix, seen: Matrix, wide: Matrices, X: Matrix
) -> tuple[list[Matrix], Matrix]:
    """What some rows show of the changes, and how these go on after them."""
    step, rows = kernels.compiled(change_step, stacks=True), list[Matrix]()
    for k in range(here.start, here.stop):
        at, now = seen[k], plant.at(k + 1)
        K, C = gains[k - here.start][:, at], now.C[at]
        L = now.A @ K
        found = step(
            A_L=now.A - L @ C, C=C, L=L, dQ=wide["Q"],
            dR=wide["R"][:, at][:, :, at], dS=wide["S"][:, :, at], X=X,
        )  # fmt: skip
        for name in ("dLambda_0", "dN_1"):
            rows.append(found[name].reshape(len(X), found[name][0].size).T)
        X = found["X_next"]
    return rows, X


def _clear(shown: Matrix) -> bool:
    """Whether every change is shown, far from rounding."""
    values = np.linalg.svd(shown, compute_uv=False)
    return bool(values.min(initial=1.0) > CLEAR * values.max(initial=0.0))


def _unit_noise(
    plant: Plant, seen: Matrix | None, x: Vector, y: Vector
) -> tuple[Plant, Matrix]:
    """The plant in other units with noises of size one, and what is seen of it."""
    p = plant.p
    steps = plant.steps
    if seen is None:
        assert steps is not None
        seen = np.ones((steps - 1, p), dtype=bool)
    A, C = plant.A / x[:, None] * x, plant.C / y[:, None] * x
    one = Plant(A, None, C, Q=np.eye(plant.n), R=np.eye(p), P0=np.eye(plant.n), dt=1.0)
    return one, np.asarray(seen, dtype=bool)
