"""What a record shows of changes of the noises, instant by instant.

For plants that vary over time and records with gaps there is no constant gain.  The
gains are those of a Kalman filter for noises of size one, under which errors die out.
"""

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import packing
from ..plant import Plant
from ..run.filter_data import filter_data
from .derivation import change_step

TOGETHER = 64  # instants whose rows are reduced at once


def shown_by(
    plant: Plant, changes: Matrices, seen: Matrix | None, x: Vector, y: Vector
) -> Matrix:
    """A square root of what all instants show of the changes, for any start.

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
    gains = filter_data(plant, np.where(seen, 0.0, np.nan), history=True).K
    assert gains is not None
    n, count = plant.n, len(changes["Q"])
    _, unpack = packing(n)
    start = unpack(np.eye(n * (n + 1) // 2))
    wide = {k: np.concatenate([np.zeros((len(start), *X.shape[1:])), X])
            for k, X in changes.items()}  # fmt: skip
    X = np.concatenate([start, np.zeros((count, n, n))])
    root, rows = np.zeros((0, len(X))), []
    step = kernels.compiled(change_step, stacks=True)
    for k, here in enumerate(seen):
        now = plant.at(k + 1)
        K, C = gains[k][:, here], now.C[here]
        L = now.A @ K
        found = step(
            A_L=now.A - L @ C, C=C, L=L, dQ=wide["Q"],
            dR=wide["R"][:, here][:, :, here], dS=wide["S"][:, :, here], X=X,
        )  # fmt: skip
        for name in ("dLambda_0", "dN_1"):
            rows.append(found[name].reshape(len(X), found[name][0].size).T)
        X = found["X_next"]
        if len(rows) >= 2 * TOGETHER or k == len(seen) - 1:
            root, rows = np.linalg.qr(np.vstack([root, *rows]), mode="r"), []
    root = np.pad(root, ((0, max(0, len(X) - len(root))), (0, 0)))
    return root[len(start) : len(X), len(start) :]


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
