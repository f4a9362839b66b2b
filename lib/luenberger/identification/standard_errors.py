"""Standard errors of what was fitted, from the information of the record."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..numeric import Matrix, Vector
from .boundary import Face
from .unknowns import Unknowns

KNOWN = 1e-9  # of a scaled information: below it a direction is not determined


def covariance_of(information: Matrix) -> Matrix:
    """The inverse of an information matrix, at unit diagonal; zero where it is none."""
    diagonal = information.diagonal()
    unit = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information * unit * unit[:, None])
    keep = values > KNOWN * max(len(values), 1)
    half = vectors[:, keep] / np.sqrt(values[keep]) * unit[:, None]
    return half @ half.T


def errors(
    unknowns: Unknowns, theta: Vector, spread: Matrix, Q: Face, R: Face
) -> dict[str, Any]:
    """{"Q", "R", and each number by name: its standard error}.

    Parameters
    ----------
    unknowns : Unknowns
    theta : (k,) ndarray
    spread : (k, k) ndarray
        Covariance of theta.
    Q, R : Face
    """
    slopes, found = unknowns.slopes(theta), dict[str, Any]()
    for letter, one in (("Q", Q), ("R", R)):
        none = np.zeros(one.X.shape)
        moves = np.array([X.get(letter, none) for X in slopes])
        moves = moves.reshape(-1, *one.X.shape)
        variance = np.einsum("aij,ab,bij->ij", moves, spread, moves)
        found[letter] = np.where(one.bound, np.nan, np.sqrt(np.maximum(variance, 0)))
    sure = np.sqrt(np.maximum(spread.diagonal(), 0))
    for label, size in zip(unknowns.labels, sure):
        for one in (Q, R):
            if label in one.values:  # theta is half its logarithm
                nothing = label in one.gone
                found[label] = (
                    np.nan if nothing else float(2 * one.values[label] * size)
                )
    more = unknowns.parameters
    for name, scale, size in zip(
        more.names, more.scale, sure[len(sure) - len(more.names) :]
    ):
        found[name] = float(scale * size)
    return found
