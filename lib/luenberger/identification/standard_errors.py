"""Standard errors from the curvature of the likelihood, and variances that are zero.

Errors are those of variances themselves, in which covariances are linear.  So they are
there at a variance of zero, too, which a search in logarithms never reaches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..numeric import Matrices, Matrix, Vector
from .forms import Form, Full
from .parameters import Unknowns
from .search import Likelihood

STEP = 1e-4  # of a number, or of its error where that is larger: for differences
WIDE = 1e-3  # the same of a parameter, whose slope is a difference already
NEAR = 5.0  # times a step, that one is good enough
TRIES = 5
KNOWN = 1e-9  # of a scaled information: below it a direction is not determined
PART = 1e-7  # of such a direction: an unknown with a smaller share is determined
FLAT = 1e-6  # of a covariance in even units: what leaves the face on which it lies
VAGUE = 3.0  # times a variance: an error that is larger may mean that it is zero
NOTHING = 1e-6  # of a variance's unit, at which least squares have put it at zero
SMALL = 0.03  # a deviation below this part of the noise's size is tried at zero


class Face(NamedTuple):
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
    sentences: tuple[str, ...] = ()


def share(form: Form, X: Matrix, way: Matrix) -> float:
    """How often a covariance has what a number adds to it."""
    moved = way.diagonal() > 0
    return float((X.diagonal()[moved] / way.diagonal()[moved]).min(initial=np.inf))


def face(
    form: Form, theta: Vector, likely: Callable[[Matrix], bool], error: Vector | None
) -> Face:
    """The face of the set of covariances on which a form's best one lies.

    The set ends where a direction has no variance.  If the record is as likely there,
    the covariance is set there.  Variances are tried, the smallest first, if their
    standard errors are large beside them; if there are no errors, where a search has
    put them at zero already.
    """
    X, n = form.matrix(theta), len(form.known)
    q = dict(zip(form.labels, np.exp(2 * theta).tolist())) if form.named else {}
    inside = Face(X, q, np.zeros(X.shape, dtype=bool))
    if isinstance(form, Full):
        if error is None:
            return inside
        values, vectors = np.linalg.eigh(X / form.unit / form.unit[:, None])
        sides = np.sqrt(np.maximum(values, 0)) * vectors * form.unit[:, None]
        lost = 0
        while lost < n and values[lost] <= SMALL**2 * max(values[-1], 1):
            tried = sides[:, lost + 1 :]
            if not likely(tried @ tried.T):
                break
            lost += 1
        said = (
            f"{form.letter} has rank {n - lost} of {n}, at its bound: the record is as "
            "likely without variance in the other directions, and standard errors are "
            "those that hold without the bound."
        )
        H, all_ = sides[:, lost:], np.full(X.shape, lost == n)
        return Face(H @ H.T, {}, all_, (), (said,)) if lost else inside
    size, slopes = np.exp(2 * theta), np.abs(form.slopes(theta))
    least = NOTHING * np.array([share(form, np.diag(form.unit**2), way)
                                for way in form.directions(theta)])  # fmt: skip
    vague = size < least if error is None else ~(error <= VAGUE * size)
    at, gone, unit = theta.copy(), list[int](), np.sqrt(slopes.sum(axis=0).diagonal())
    unit = np.where(unit > 0, unit, 1.0)
    part = (slopes / unit / unit[:, None]).max(axis=(1, 2), initial=0)
    for k in (int(k) for k in np.argsort(part) if vague[k]):
        tried = np.where(np.arange(len(at)) == k, -np.inf, at)
        if likely(form.matrix(tried)):
            at, gone = tried, sorted([*gone, k])
    if not gone:
        return inside
    names = tuple(form.labels[k] for k in gone)
    says = (
        f"{name} is at its bound, zero: the record is as likely without it, and it has "
        "no standard error there."
        for name in names
    )
    left = np.delete(slopes, gone, axis=0).sum(axis=0) > 0
    values = q | dict.fromkeys(names if q else (), 0.0)
    bound = (slopes[gone].sum(axis=0) > 0) & ~left
    return Face(form.matrix(at), values, bound, names, tuple(says))


def spread_of(
    unknowns: Unknowns, theta: Vector, likelihood: Likelihood, noises: Matrices
) -> tuple[Matrix, float]:
    """The covariance of the unknowns: the inverse of the curvature at a maximum.

    Returns the likelihood as well.

    `noises` may be at their bounds, so that variances only grow.  There the likelihood
    need not be curved in directions that leave the bound.  Then those that do not are
    taken for all that is unknown.
    """
    ways, values = unknowns.ways(theta, linear=True), unknowns.split(theta)[2]
    count, scale = unknowns.count, unknowns.parameters.scale

    def slope(move: Vector) -> tuple[float, Vector]:
        Q, R = (noises[k] + sum((size * way[k] for size, way in zip(move, ways)
                                 if k in way), np.zeros_like(noises[k]))
                for k in "QR")  # fmt: skip
        there = values + scale * move[len(ways) :]
        return likelihood.slope({"Q": Q, "R": R}, there, ways)

    (best, base), H = slope(np.zeros(count)), np.zeros((count, count))
    one, sizes, mixed = np.eye(count), np.ones(count), _mixed(unknowns)
    for k in (k for k in range(count) if k not in mixed):
        value, first, step = 0.0, WIDE, WIDE
        if k < len(ways):
            letter, way = next(iter(ways[k].items()))
            form, step = getattr(unknowns, letter), STEP
            value = share(form, noises[letter], way)
            first = STEP * (value or share(form, np.diag(form.unit**2), way))
        for _ in range(TRIES):
            sizes[k], H[k] = first, (base - slope(one[k] * first)[1]) / first
            error = 1 / np.sqrt(abs(H[k, k])) if H[k, k] else 0.0
            first = step * max(value, error)
            if not first or sizes[k] / NEAR <= first <= sizes[k] * NEAR:
                break
    for k, (i, j) in mixed.items():  # (e_i + e_j) (e_i + e_j)' is a covariance
        ratio = np.sqrt(sizes[i] * sizes[j])
        move = sizes[i] * one[i] + sizes[j] * one[j] + ratio * one[k]
        H[k] = (base - slope(move)[1] - H[i] * sizes[i] - H[j] * sizes[j]) / ratio
    H = 0.5 * (H + H.T)
    unit = 1 / np.sqrt(np.where(H.diagonal() != 0, np.abs(H.diagonal()), 1.0))
    if not (np.linalg.eigvalsh(H * unit * unit[:, None])[:1] < -KNOWN).any():
        return covariance_of(H), best
    inside = _inside(noises, ways, count)
    found = covariance_of(inside.T @ H @ inside)
    lost = np.isinf(found.diagonal())
    found[lost, lost] = 0.0
    spread = inside @ found @ inside.T
    lost = (np.abs(inside[:, lost]) > 0).any(axis=1)
    spread[lost, lost] = np.inf
    return spread, best


def _mixed(unknowns: Unknowns) -> dict[int, tuple[int, int]]:
    """The covariances among the unknowns, each with the two variances beside it."""
    found, at = dict[int, tuple[int, int]](), 0
    for form in (unknowns.Q, unknowns.R):
        if isinstance(form, Full):
            pairs = list(zip(*np.triu_indices(len(form.known))))
            place = {pair: at + k for k, pair in enumerate(pairs)}
            found |= {place[i, j]: (place[i, i], place[j, j])
                      for i, j in pairs if i != j}  # fmt: skip
        at += form.count
    return found


def _inside(noises: Matrices, ways: list[Matrices], count: int) -> Matrix:
    """A basis of the moves that stay on the faces on which Q and R lie."""
    rows = []
    for name, X in noises.items():
        unit = np.sqrt(np.where(X.diagonal() > 0, X.diagonal(), 1.0))
        values, vectors = np.linalg.eigh(X / unit / unit[:, None])
        out = vectors[:, values <= FLAT * max(values.max(initial=0), 1e-300)]
        moves = [way.get(name, np.zeros_like(X)) for way in ways]
        moves += [np.zeros_like(X)] * (count - len(moves))
        left = [(out.T @ (D / unit / unit[:, None])).ravel() for D in moves]
        rows.append(np.reshape(left, (count, -1)).T)
    all_ = np.concatenate(rows)
    size = np.sqrt((all_**2).sum(axis=0))
    size = np.where(size > 0, size, 1.0)
    _, values, right = np.linalg.svd(all_ / size)
    return right[int((values > FLAT).sum()) :].T / size[:, None]


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


def errors(
    unknowns: Unknowns, theta: Vector, spread: Matrix, faces: dict[str, Face]
) -> dict[str, Any]:
    """{"Q", "R", and each number by name: its standard error}.

    `spread` is the covariance of the unknowns, `faces` has those of Q and R.
    """
    ways, found = unknowns.ways(theta, linear=True), dict[str, Any]()
    sure, noises = np.sqrt(spread.diagonal()), len(ways)
    lost = np.isinf(sure)[:noises]
    finite = np.where(np.isinf(spread), 0.0, spread)[:noises, :noises]
    for letter, one in faces.items():
        none = np.zeros(one.X.shape)
        moves = np.reshape([way.get(letter, none) for way in ways], (-1, *none.shape))
        variance = np.einsum("aij,ab,bij->ij", moves, finite, moves)
        error = np.where(moves[lost].any(axis=0), np.inf,
                         np.sqrt(np.maximum(variance, 0)))  # fmt: skip
        found[letter] = np.where(one.bound, np.nan, error)
    for label, size in zip((*unknowns.Q.labels, *unknowns.R.labels), sure):
        for one in faces.values():
            if label in one.values:
                found[label] = np.nan if label in one.gone else float(size)
    more = unknowns.parameters
    return found | dict(zip(more.names, (more.scale * sure[noises:]).tolist()))
