"""Standard errors of what was fitted, from the information of the record."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..numeric import Matrices, Matrix, Vector
from .boundary import Face
from .forms import Form, Of
from .information import information
from .objective import backend_for
from .records import Records
from .unknowns import Unknowns

KNOWN = 1e-9  # of a scaled information: below it a direction is not determined
PART = 1e-7  # of such a direction: an unknown with a smaller share is determined


def directions(unknowns: Unknowns, theta: Vector) -> list[Matrices]:
    """What each unknown adds to the plant: covariances are linear in theirs.

    In these the information is that of variances themselves.  So it is there at a
    variance of zero, too, which is at an infinite distance in logarithms.
    """
    q, r, _ = unknowns.split(theta)
    found: list[Matrices] = [{"Q": X} for X in _linear(unknowns.Q, q)]
    found += [{"R": X} for X in _linear(unknowns.R, r)]
    return found + unknowns.slopes(theta)[len(found) :]


def _linear(form: Form, theta: Vector) -> Matrix:
    """What the numbers of a form add to its covariance."""
    if isinstance(form, Of):
        return form.slopes(theta) / (2 * np.exp(2 * theta[:, None, None]))
    return form.directions


def spread_of(unknowns: Unknowns, theta: Vector, plant: Any, data: Records) -> Matrix:
    """The covariance of the unknowns that Cramer and Rao promise, at a plant."""
    ys, us = [y for y, _ in data], [u for _, u in data]
    ways = directions(unknowns, theta)
    return covariance_of(
        information(plant, ys, us, along=ways, backend=backend_for(data))
    )


def covariance_of(information: Matrix) -> Matrix:
    """The inverse of an information matrix, at unit diagonal.

    An unknown that is not determined has an infinite variance, and no covariances.
    """
    diagonal = information.diagonal()
    unit = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information * unit * unit[:, None])
    keep = values > KNOWN * max(len(values), 1)
    half = vectors[:, keep] / np.sqrt(values[keep]) * unit[:, None]
    found = half @ half.T
    lost = (np.abs(vectors[:, ~keep]) > PART).any(axis=1)
    found[lost], found[:, lost] = 0, 0
    found[lost, lost] = np.inf
    return found


def of_logarithms(unknowns: Unknowns, theta: Vector, spread: Matrix) -> Matrix:
    """The covariance of the unknowns, from that of the vector that a search moves."""
    q, r, _ = unknowns.split(theta)
    J = np.eye(unknowns.count)
    at = 0
    for form, part in ((unknowns.Q, q), (unknowns.R, r)):
        here = slice(at, at := at + form.count)
        k = form.count
        adds, moves = (
            _linear(form, part).reshape(k, -1),
            form.slopes(part).reshape(k, -1),
        )
        J[here, here] = np.linalg.lstsq(adds.T, moves.T, rcond=None)[0]
    return J @ spread @ J.T


def errors(
    unknowns: Unknowns, theta: Vector, spread: Matrix, Q: Face, R: Face
) -> dict[str, Any]:
    """{"Q", "R", and each number by name: its standard error}.

    Parameters
    ----------
    unknowns : Unknowns
    theta : (k,) ndarray
    spread : (k, k) ndarray
        Covariance of the unknowns.
    Q, R : Face
    """
    ways, found = directions(unknowns, theta), dict[str, Any]()
    lost = np.isinf(spread.diagonal())
    finite = np.where(np.isinf(spread), 0.0, spread)
    for letter, one in (("Q", Q), ("R", R)):
        none = np.zeros(one.X.shape)
        moves = np.array([X.get(letter, none) for X in ways])
        moves = moves.reshape(-1, *one.X.shape)
        variance = np.einsum("aij,ab,bij->ij", moves, finite, moves)
        error = np.sqrt(np.maximum(variance, 0))
        error = np.where(moves[lost].any(axis=0), np.inf, error)
        found[letter] = np.where(one.bound, np.nan, error)
    sure = np.sqrt(spread.diagonal())
    for label, size in zip(unknowns.labels, sure):
        for one in (Q, R):
            if label in one.values:
                found[label] = np.nan if label in one.gone else float(size)
    more = unknowns.parameters
    for name, scale, size in zip(
        more.names, more.scale, sure[len(sure) - len(more.names) :]
    ):
        found[name] = float(scale * size)
    return found
