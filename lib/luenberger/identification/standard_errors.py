"""Standard errors of what was fitted, from the curvature of the likelihood."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..numeric import Matrices, Matrix, Vector
from ..run.filter import Filter
from .boundary import Face
from .forms import Form, Full, Of
from .search import Likelihood
from .unknowns import Unknowns

STEP = 1e-3  # of a number, or of its error where that is larger: for differences
NEAR = 5.0  # times a step, that one is good enough
TRIES = 4
KNOWN = 1e-9  # of a scaled information: below it a direction is not determined
PART = 1e-7  # of such a direction: an unknown with a smaller share is determined
FLAT = 1e-6  # of a covariance in even units: what leaves the face on which it lies


def directions(unknowns: Unknowns, theta: Vector) -> list[Matrices]:
    """What each number of Q and R adds to it: covariances are linear in theirs.

    In these the information is that of variances themselves.  So it is there at a
    variance of zero, too, which is at an infinite distance in logarithms.
    """
    q, r, _ = unknowns.split(theta)
    found: list[Matrices] = [{"Q": X} for X in _linear(unknowns.Q, q)]
    return found + [{"R": X} for X in _linear(unknowns.R, r)]


def _linear(form: Form, theta: Vector) -> Matrix:
    """What the numbers of a form add to its covariance."""
    if isinstance(form, Of):
        return form.slopes(theta) / (2 * np.exp(2 * theta[:, None, None]))
    return form.directions


class Curvature:
    """Minus the second derivatives of a likelihood, by differences of its slope.

    Parameters
    ----------
    unknowns : Unknowns
    theta : (k,) ndarray
    likelihood : Likelihood
    Q, R : ndarray
        The covariances there; they may be at their bounds, so that variances only grow.
    """

    def __init__(
        self, unknowns: Unknowns, theta: Vector, likelihood: Likelihood, Q: Matrix,
        R: Matrix,
    ) -> None:  # fmt: skip
        self.unknowns, self.likelihood = unknowns, likelihood
        self.ways, self.Q, self.R = directions(unknowns, theta), Q, R
        self.values = unknowns.split(theta)[2]
        self.count = unknowns.count
        self.base = self._slope(np.zeros(self.count))

    def _slope(self, move: Vector) -> Vector:
        noises, scale = len(self.ways), self.unknowns.parameters.scale
        Q, R = self.Q, self.R
        for size, way in zip(move[:noises], self.ways):
            Q, R = Q + size * way.get("Q", 0.0), R + size * way.get("R", 0.0)
        values = self.values + scale * move[noises:]
        plant = self.unknowns.with_noise(Q, R, values)
        return self.likelihood.slope(plant, self.ways, values)[1]

    def along(self, move: Vector) -> Vector:
        """How the slope falls along a move; upward alone, to the second order."""
        one, two = self._slope(move), self._slope(2 * move)
        return (3 * self.base - 4 * one + two) / 2

    def step(self, k: int, value: float, size: float) -> tuple[float, Vector]:
        """A step of an unknown that has this value, and what `along` finds there."""
        for _ in range(TRIES):
            found = self.along(np.eye(self.count)[k] * size) / size
            error = 1 / np.sqrt(abs(found[k])) if found[k] else 0.0
            wanted = STEP * max(value, error)
            if not wanted or size / NEAR <= wanted <= size * NEAR:
                break
            size = wanted
        return size, found

    def matrix(self) -> Matrix:
        """All of it."""
        sizes, found = np.ones(self.count), np.zeros((self.count, self.count))
        mixed = self._mixed()
        first = self._first()
        for k in range(self.count):
            if k not in mixed:
                value = self._value(k)
                sizes[k], found[k] = self.step(k, value, value * STEP or first[k])
        for k, (i, j) in mixed.items():  # (e_i + e_j) (e_i + e_j)' is a covariance
            ratio = np.sqrt(sizes[i] * sizes[j])
            move = np.zeros(self.count)
            move[[i, j, k]] = sizes[i], sizes[j], ratio
            rest = found[i] * sizes[i] + found[j] * sizes[j]
            found[k] = (self.along(move) - rest) / ratio
        return 0.5 * (found + found.T)

    def _mixed(self) -> dict[int, tuple[int, int]]:
        """The covariances among the unknowns, each with the two variances beside it."""
        found: dict[int, tuple[int, int]] = {}
        at = 0
        for form in (self.unknowns.Q, self.unknowns.R):
            if isinstance(form, Full):
                rows, columns = np.triu_indices(len(form.known))
                where = {pair: at + k for k, pair in enumerate(zip(rows, columns))}
                found |= {k: (where[i, i], where[j, j])
                          for (i, j), k in where.items() if i != j}  # fmt: skip
            at += form.count
        return found

    def _value(self, k: int) -> float:
        """How large an unknown variance is: the least share that its matrix has."""
        if k >= len(self.ways):
            return 0.0
        (name, X), *_ = self.ways[k].items()
        moved = X.diagonal() > 0
        if not moved.any():
            return 0.0
        given = getattr(self, name).diagonal()
        return float((given[moved] / X.diagonal()[moved]).min())

    def _first(self) -> Vector:
        """A step of each unknown to begin with, by what it does to the innovations."""
        plant = self.unknowns.with_noise(self.Q, self.R, self.values)
        now, found = plant.at(0), np.full(self.count, STEP)
        run = Filter(plant)
        pivot = np.concatenate(
            [one.tape.pivot for rows in self.likelihood.rows
             for one in run.passed(rows, "values")]
        )  # fmt: skip
        size = np.nanmedian(np.where(pivot > 0, pivot, np.nan)[-100:], axis=0)
        for k, way in enumerate(self.ways):
            shown, X = way.get("R", np.zeros_like(now.R)).diagonal(), way.get("Q")
            for _ in range(plant.n if X is not None else 0):
                shown = shown + (now.C @ X @ now.C.T).diagonal()
                X = now.A @ X @ now.A.T
            some = shown > 0
            if some.any() and np.isfinite(size[some]).any():
                found[k] = STEP * np.nanmin(size[some] / shown[some])
        return found


def spread_of(
    unknowns: Unknowns, theta: Vector, likelihood: Likelihood, Q: Matrix, R: Matrix
) -> Matrix:
    """The covariance of the unknowns: the inverse of the curvature at a maximum.

    Where a covariance is at its bound the likelihood need not be curved in directions
    that leave the bound.  Then those that do not are taken for all that is unknown.
    """
    curve = Curvature(unknowns, theta, likelihood, Q, R)
    H = curve.matrix()
    unit = 1 / np.sqrt(np.where(H.diagonal() != 0, np.abs(H.diagonal()), 1.0))
    least = np.linalg.eigvalsh(H * unit * unit[:, None])[:1]
    if not (least < -KNOWN).any():
        return covariance_of(H)
    inside = _inside(curve)
    found = covariance_of(inside.T @ H @ inside)
    lost = np.isinf(found.diagonal())
    found[lost, lost] = 0.0
    spread = inside @ found @ inside.T
    lost = (np.abs(inside[:, lost]) > 0).any(axis=1)
    spread[lost, lost] = np.inf
    return spread


def _inside(curve: Curvature) -> Matrix:
    """A basis of the moves that stay on the faces on which Q and R lie."""
    rows = []
    for name in "QR":
        X = getattr(curve, name)
        unit = np.sqrt(np.where(X.diagonal() > 0, X.diagonal(), 1.0))
        values, vectors = np.linalg.eigh(X / unit / unit[:, None])
        out = vectors[:, values <= FLAT * max(values.max(initial=0), 1e-300)]
        moves = [way.get(name, np.zeros_like(X)) for way in curve.ways]
        moves += [np.zeros_like(X)] * (curve.count - len(moves))
        rows.append(np.array([(out.T @ (D / unit / unit[:, None])).ravel()
                              for D in moves]).reshape(curve.count, -1).T)  # fmt: skip
    rows_ = np.concatenate(rows)
    size = np.sqrt((rows_**2).sum(axis=0))
    _, values, right = np.linalg.svd(rows_ / np.where(size > 0, size, 1.0))
    rank = int((values > FLAT).sum())
    return right[rank:].T / np.where(size > 0, size, 1.0)[:, None]


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
    noises = len(ways)
    lost = np.isinf(spread.diagonal())[:noises]
    finite = np.where(np.isinf(spread), 0.0, spread)[:noises, :noises]
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
