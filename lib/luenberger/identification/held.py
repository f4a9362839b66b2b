"""What no record determines, kept where a search begins.

The likelihood is flat along such a direction.  A square of the distance along it has
its least value, zero, at the start, and moves nothing that the record determines.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..numeric import Matrices, Vector
from .identifiability import Identifiability
from .noise_fit import NoiseFit
from .search import Objective
from .unknowns import Unknowns


def held(
    objective: Objective, unknowns: Unknowns, fixed: tuple[Matrices, ...], at: Vector
) -> Objective:
    """The objective, with the square of the distance along each fixed direction."""
    if not fixed:
        return objective
    units = _units(unknowns, at)
    pulls = []
    for one in fixed:
        even = {k: X / units[k] for k, X in one.items() if k in units}
        size = np.sqrt(sum((X**2).sum() for X in even.values()))
        pulls.append({k: X / units[k] / size for k, X in even.items()})

    def distances(theta: Vector) -> Vector:
        Q, R = (getattr(unknowns.plant(theta), name) for name in "QR")
        return np.array([along(dict(Q=Q, R=R), pull) for pull in pulls])

    begin = distances(at)

    def value(theta: Vector) -> tuple[float, Vector]:
        least, slope = objective(theta)
        far = distances(theta) - begin
        moves = [[along(pull, X) for pull in pulls] for X in unknowns.slopes(theta)]
        slope[: len(moves)] += np.array(moves) @ far
        return least + 0.5 * float(far @ far), slope

    return value


def along(pull: Matrices, X: Matrices) -> float:
    """How far matrices reach along a direction."""
    return float(sum((pull[name] * X[name]).sum() for name in pull if name in X))


def _units(unknowns: Unknowns, at: Vector) -> Matrices:
    """The sizes of the entries of Q and R at the start."""
    plant, found = unknowns.plant(at).at(0), {}
    for name, X in zip("QR", plant.covariances()):
        size = np.sqrt(np.where(X.diagonal() > 0, X.diagonal(), 1.0))
        found[name] = np.outer(size, size)
    return found


def said(fit: NoiseFit, told: Identifiability) -> NoiseFit:
    """The fit, with what was kept because no record determines it."""
    kept = [
        f"No record determines {sentence} The fit keeps the rest as it was where its "
        "search began."
        for sentence in told.sentences
    ]
    return dataclasses.replace(fit, unidentifiable=kept + fit.unidentifiable)
