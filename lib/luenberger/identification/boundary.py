"""Variances that are most likely zero, where a search in logarithms never arrives.

The set of covariances ends where a direction has no variance.  If the record is as
likely there as at the best that was found, the covariance is set there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..numeric import Matrix, Vector
from .forms import Along, Form, Full, Of

VAGUE = 0.15  # error of the logarithm of a deviation; below it, zero is far away
SMALL = 0.03  # a deviation below this part of the noise's size is tried at zero

Likely = Callable[[Matrix], bool]  # whether a covariance is as likely as the best


@dataclass(frozen=True, eq=False)
class Face:
    """A covariance that was found, and what of it is at its bound.

    Attributes
    ----------
    X : (k, k) ndarray
    values : dict of str to float
        Numbers of the form that are no entries, such as q[0].
    bound : (k, k) ndarray of bool
        Entries whose variance is at its bound, zero.
    gone : tuple of str
        Those of the values that are.
    sentences : tuple of str
    """

    X: np.ndarray
    values: dict[str, float]
    bound: np.ndarray
    gone: tuple[str, ...] = ()
    sentences: tuple[str, ...] = field(default=())


def unsure(spread: Matrix, theta: Vector) -> Vector:
    """Which variances exp(2 theta) are worth a trial at their bound.

    `spread` is the covariance of their errors.
    """
    error = np.sqrt(np.maximum(spread.diagonal(), 0))
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return ~(error <= 2 * VAGUE * np.exp(2 * theta))


def face(form: Form, theta: Vector, likely: Likely, vague: Vector) -> Face:
    """The face of the set of covariances on which a form's best one lies.

    Only variances whose logarithm is `vague` are tried at zero.
    """
    if isinstance(form, Full):
        return _of_full(form, theta, likely)
    if isinstance(form, Along | Of):
        return _of_variances(form, theta, likely, vague)
    return inside(form, theta)


def inside(form: Form, theta: Vector) -> Face:
    """A covariance with nothing at its bound."""
    X = form.matrix(theta)
    return Face(X, _named(form, theta), np.zeros(X.shape, dtype=bool))


def _named(form: Form, theta: Vector) -> dict[str, float]:
    """The numbers of a form that are no entries of its covariance."""
    if not isinstance(form, Along | Of):
        return {}
    q = np.exp(2 * theta)
    return {k: float(v) for k, v in zip(form.labels, q) if "," not in k}


def _of_variances(
    form: Along | Of, theta: Vector, likely: Likely, vague: Vector
) -> Face:
    """Each variance is tried at zero, that with the smallest share first."""
    at, gone = theta.copy(), list[int]()
    slopes = form.slopes(theta)
    unit = np.sqrt(np.abs(slopes).sum(axis=0).diagonal())
    unit = np.where(unit > 0, unit, 1.0)
    share = [np.abs(X / unit / unit[:, None]).max(initial=0) for X in slopes]
    for k in (int(k) for k in np.argsort(share) if vague[k]):
        tried = at.copy()
        tried[k] = -np.inf
        if likely(form.matrix(tried)):
            at, gone = tried, [*gone, k]
    moved = np.delete(np.abs(slopes), gone, axis=0).sum(axis=0) > 0
    names = [form.labels[k] for k in sorted(gone)]
    said = (
        f"{name} is at its bound, zero: the record is as likely without it, and it has "
        "no standard error there."
        for name in names
    )
    bound = (np.abs(slopes[gone]).sum(axis=0) > 0) & ~moved
    return Face(form.matrix(at), _named(form, at), bound, tuple(names), tuple(said))


def _of_full(form: Full, theta: Vector, likely: Likely) -> Face:
    """Directions of small variance are tried at zero, the smallest first."""
    X, n, unit = form.matrix(theta), len(form.known), form.scale
    values, vectors = np.linalg.eigh(X / unit / unit[:, None])
    sides = np.sqrt(np.maximum(values, 0)) * vectors * unit[:, None]
    lost = 0
    while lost < n and values[lost] <= SMALL**2 * max(values[-1], 1):
        tried = sides[:, lost + 1 :]
        if not likely(tried @ tried.T):
            break
        lost += 1
    if not lost:
        return inside(form, theta)
    H = sides[:, lost:]
    said = (
        f"{form.letter} has rank {n - lost} of {n}, at its bound: the record is as "
        "likely without variance in the other directions, and standard errors are "
        "those that hold without the bound."
    )
    return Face(H @ H.T, {}, np.full(X.shape, lost == n), (), (said,))
