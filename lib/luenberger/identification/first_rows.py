"""The first rows of a record whose start is not known, as one row of a filter."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtrtri

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from .derivation import (
    as_one_row,
    more_readings,
    moved_readings,
    one_row_moved,
    weighed,
)
from .stretch import Stretch
from .ways import Ways


def first_stretch(
    plant: Plant, ways: Ways, free: Matrix, y: Matrix, u: Matrix, unit: Vector
) -> Stretch:
    """One row that stands for the first rows, and for the state after them.

    Parameters
    ----------
    plant : Plant
    ways : Ways
    free, y : (k, p) ndarray
        Which entries count, and what was read.
    u : (k, m) ndarray
    unit : (p,) ndarray
        Units in which the outputs are of like size.
    """
    have, readings, units = _collected(plant, ways, free, y, u, unit)
    n = plant.n
    Q, R = np.linalg.qr(have["Phi"][n:] / units[:, None], mode="complete")
    turned = Q.T / units
    rest = len(units) - n
    have["E_d"] = np.hstack([np.zeros((n, n)), turned[:n]])
    have["E_r"] = np.block(
        [[np.eye(n), np.zeros((n, n + rest))], [np.zeros((rest, n)), turned[n:]]]
    )
    have["inverse"] = np.triu(dtrtri(R[:n])[0])
    have["d"] = have["E_d"] @ readings
    have |= kernels.run(as_one_row, have)
    have |= kernels.run(one_row_moved, have, stacks=True)
    return _one_row(have, n, ways.count)


def _collected(
    plant: Plant, ways: Ways, free: Matrix, y: Matrix, u: Matrix, unit: Vector
) -> tuple[Matrices, Matrix, Vector]:
    """Phi, mu, P and their changes; the state's place above the readings; units."""
    n, q = plant.n, ways.count
    have: Matrices = dict(Phi=np.eye(n), mu=np.zeros((n, 1)), P=np.zeros((n, n)))
    moved: Matrices = {f"d{name}": np.zeros((q, *X.shape)) for name, X in have.items()}
    readings, units = np.zeros(0), np.zeros(0)
    for k, seen in enumerate(free):
        at = plant.at(k + 1)
        Q, R, S = at.covariances()
        one = dict(A=at.A, B=at.B, C=at.C, E=at.E, Q=Q, R=R, S=S)
        have |= moved | _row(one, u[k], seen, len(units))
        changes = {name[1:]: X[0] for name, X in ways.rows(k + 1, 1).items()}
        row = _row(changes, u[k], seen, len(units), still=0.0)
        have |= {f"d{name}": X for name, X in row.items()}
        found = kernels.run(more_readings, have)
        found |= kernels.run(moved_readings, have, stacks=True)
        have = {name: found[f"{name}_next"] for name in ("Phi", "mu", "P")}
        moved = {f"d{name}": found[f"d{name}_next"] for name in have}
        readings = np.concatenate([y[k, seen], readings])
        units = np.concatenate([unit[seen], units])
    stack = np.concatenate([np.zeros(n), readings])[:, None]
    return have | moved, stack, units


def _row(
    at: Matrices, u: Vector, seen: Vector, old: int, still: float = 1.0
) -> Matrices:
    """Z, beta and J of one row; `still` is what an old reading keeps of itself."""
    A, C = at["A"], at["C"][..., seen, :]
    n, k = A.shape[-1], C.shape[-2]
    size = n + k + old
    Z = np.zeros((*A.shape[:-2], size, n + old))
    Z[..., :n, :n], Z[..., n : n + k, :n] = A, C
    Z[..., n + k :, n:] = still * np.eye(old)
    beta = np.zeros((*A.shape[:-2], size, 1))
    beta[..., :n, 0], beta[..., n : n + k, 0] = at["B"] @ u, at["E"][..., seen, :] @ u
    J = np.zeros((*A.shape[:-2], size, size))
    S = at["S"][..., seen]
    J[..., :n, :n], J[..., :n, n : n + k], J[..., n : n + k, :n] = at["Q"], S, S.mT
    J[..., n : n + k, n : n + k] = at["R"][..., seen, :][..., seen]
    return dict(Z=Z, beta=beta, J=J)


def _one_row(have: Matrices, n: int, q: int) -> Stretch:
    """A row in which nothing moves: what there is are an input of one, and noises."""
    J, dJ, mean, dmean = (have[k] for k in ("J_r", "dJ_r", "beta_r", "dbeta_r"))
    k = len(J) - n
    R, S = J[n:, n:], J[:n, n:]
    W = np.zeros((0, 0))
    if k:
        W = kernels.compiled(weighed)(M=R, innovation=np.zeros((k, 1)))["W"]
    none, blind = np.zeros((n, n)), np.zeros((k, n))
    given = dict(A=none, B=mean[:n], C=blind, E=mean[n:], S=S, Omega=none, W=W)
    given["G"] = S @ W
    zero = np.zeros((q, n, n))
    changes = dict(
        dA=zero, dB=dmean[:, :n], dC=np.zeros((q, k, n)), dE=dmean[:, n:],
        dQ=dJ[:, :n, :n], dR=dJ[:, n:, n:], dS=dJ[:, :n, n:],
    )  # fmt: skip
    return Stretch(
        {name: X[None, None] for name, X in given.items()},
        {name: X[None] for name, X in changes.items()},
        1, np.ones((1, 1, 1, 1)), np.zeros(1, dtype=int),
    )  # fmt: skip
