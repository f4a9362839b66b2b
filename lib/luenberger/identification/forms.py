"""Forms of an unknown covariance: full, diagonal, along given columns, a function.

A form is a linear part of all covariances, with a name for each of its coordinates,
and a way to reach its semi-definite ones from a vector without bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import DesignError, short
from ..numeric import Matrix, Vector, covariances
from ..numeric.validation import matrix

LEAST = 1e-3  # of a start that is singular: its share of the unit, as a deviation
FAR = 300.0  # logarithm of a deviation beyond which floats end
STEP = 1e-5  # relative, for slopes of a user's function


@dataclass(frozen=True, eq=False)
class Form:
    """A covariance that is known; in other forms, X = sum of q_k X_k with q_k > 0.

    Attributes
    ----------
    letter : str
        "Q" or "R".
    known : (k, k) ndarray
        The covariance where nothing is free, else zeros.
    labels : tuple of str
        Names of the coordinates in which the covariance is linear.
    parts : (count, k, k) ndarray
        What each of them adds.
    unit : (k,) ndarray
        Sizes of the noise.
    """

    letter: str
    known: np.ndarray
    labels: tuple[str, ...] = ()
    parts: Any = None
    unit: Any = None

    @property
    def count(self) -> int:
        """Numbers that are free."""
        return len(self.labels)

    @property
    def named(self) -> bool:
        """Whether its numbers are no entries of the covariance, such as q[0]."""
        return any("," not in label for label in self.labels)

    def directions(self, theta: Vector) -> Matrix:
        """(count, k, k): what each coordinate adds, near the vector."""
        return self.slopes(theta) if self.parts is None else self.parts

    def matrix(self, theta: Vector) -> Matrix:
        """The covariance at a vector (count,), logarithms of deviations."""
        X: Matrix = self.known + np.tensordot(variances(theta), self.parts, 1)
        return X

    def slopes(self, theta: Vector) -> Matrix:
        """(count, k, k): its derivative there."""
        X: Matrix = 2 * variances(theta)[:, None, None] * self.parts
        return X

    def at(self, X: Matrix, unit: Vector) -> Vector:
        """The vector at which the covariance is near X, whose unit is `unit` (k,)."""
        if not self.count:
            return np.zeros(0)
        scale = unit * unit[:, None]
        flat = (self.parts / scale).reshape(self.count, -1)
        size = np.linalg.norm(flat, axis=1)
        wanted = (X / scale).ravel()
        q = np.linalg.lstsq((flat / size[:, None]).T, wanted, rcond=None)[0]
        found: Vector = 0.5 * np.log(np.maximum(q, LEAST**2) / size)
        return found


@dataclass(frozen=True, eq=False)
class Full(Form):
    """Every entry is free: X = U N N' U with a lower triangle N of positive diagonal.

    U has `unit` on its diagonal, so that N has entries of size one.  The vector has the
    logarithms of N's diagonal.
    """

    def _triangle(self, theta: Vector) -> tuple[Matrix, Vector, Vector, Vector]:
        columns, rows = np.triu_indices(len(self.known))
        N, diagonal = np.zeros(self.known.shape), rows == columns
        N[rows, columns] = np.where(diagonal, np.exp(np.clip(theta, -FAR, FAR)), theta)
        return N, rows, columns, diagonal

    def matrix(self, theta: Vector) -> Matrix:
        half = self.unit[:, None] * self._triangle(theta)[0]
        return half @ half.T

    def slopes(self, theta: Vector) -> Matrix:
        N, rows, columns, diagonal = self._triangle(theta)
        dN = np.zeros((self.count, *N.shape))
        moved = np.where(diagonal, N[rows, columns], 1.0)
        dN[np.arange(self.count), rows, columns] = moved
        half = dN @ N.T * self.unit[:, None] * self.unit
        return half + half.mT

    def at(self, X: Matrix, unit: Vector) -> Vector:
        floor = LEAST * unit
        values, vectors = np.linalg.eigh(X / floor / floor[:, None])
        lifted = (vectors * np.maximum(values, 1)) @ vectors.T
        N = floor[:, None] / self.unit[:, None] * np.linalg.cholesky(lifted)
        columns, rows = np.triu_indices(len(N))
        diagonal = rows == columns
        found = N[rows, columns]
        return np.where(diagonal, np.log(np.where(diagonal, found, 1)), found)


@dataclass(frozen=True, eq=False)
class Of(Form):
    """X = f(q) with a function of positive numbers q, such as intensities."""

    function: Callable[[Vector], Any] = np.diag
    begin: np.ndarray = field(default_factory=lambda: np.ones(0))

    def directions(self, theta: Vector) -> Matrix:
        X: Matrix = self.slopes(theta) / (2 * np.exp(2 * theta[:, None, None]))
        return X

    def matrix(self, theta: Vector) -> Matrix:
        X = self.function(variances(theta))
        return covariances.covariance(f"{self.letter}(q)", X, len(self.known))

    def slopes(self, theta: Vector) -> Matrix:
        steps = STEP * np.eye(len(theta))
        pairs = [(self.matrix(theta + d), self.matrix(theta - d)) for d in steps]
        return np.array([(up - down) / (2 * STEP) for up, down in pairs])

    def at(self, X: Matrix, unit: Vector) -> Vector:
        found: Vector = 0.5 * np.log(self.begin)
        return found


def variances(theta: Vector) -> Vector:
    """exp(2 theta); theta = -inf is a variance at its bound."""
    found: Vector = np.exp(2 * np.clip(theta, -FAR, FAR))
    return np.where(theta == -np.inf, 0.0, found)


def form_of(
    letter: str, wanted: Any, size: int, given: Any, start: Any, unit: Vector
) -> Form:
    """The form that a caller asks for by `wanted`, as in `fit_noise`.

    `given` is the plant's covariance, `start` where the search is to begin, and `unit`
    (size,) has sizes of the noise, for scaling.
    """
    none, small = np.zeros((size, size)), letter.lower()
    if wanted is None:
        if given is None:
            raise DesignError(
                f"{letter}=None keeps the plant's {letter}, and it has none; give "
                f"Plant(..., {letter}=...), or a form: 'full', 'diagonal' or a matrix"
            )
        return Form(letter, given, (), np.zeros((0, size, size)), unit)
    if callable(wanted):
        q = _positive(letter, start)
        names = tuple(f"{small}[{k}]" for k in range(len(q)))
        return Of(letter, none, names, None, unit, wanted, q)
    if isinstance(wanted, str) and wanted == "full":
        rows, columns = np.triu_indices(size)
        names = tuple(f"{letter}[{i},{j}]" for i, j in zip(rows, columns))
        parts = np.zeros((len(rows), size, size))
        parts[np.arange(len(rows)), rows, columns] = 1
        return Full(letter, none, names, np.maximum(parts, parts.mT), unit)
    if isinstance(wanted, str) and wanted == "scaled":
        if given is None or not np.any(given):
            raise DesignError(
                f"{letter}='scaled' is the plant's {letter} times a number, and the "
                f"plant has none; give Plant(..., {letter}=...)"
            )
        return Form(letter, none, (f"{small}[0]",), np.array(given)[None], unit)
    if isinstance(wanted, str) and wanted == "diagonal":
        return _along(
            letter, np.eye(size), [f"{letter}[{k},{k}]" for k in range(size)], unit
        )
    if not isinstance(wanted, str) and np.ndim(wanted) == 2:
        G = matrix(f"{letter}, a matrix G,", wanted, rows=size)
        return _along(letter, G, [f"{small}[{k}]" for k in range(G.shape[1])], unit)
    raise ValueError(
        f"{letter} must be 'full', 'diagonal', 'scaled', a matrix G ({size} x k) for "
        f"{letter} = G diag(q) G', a function of q, or None for the plant's own; got "
        f"{short(wanted)}"
    )


def _along(letter: str, G: Matrix, names: Sequence[str], unit: Vector) -> Form:
    """G diag(q) G'."""
    for k in np.flatnonzero(~G.any(axis=0)).tolist():
        raise ValueError(
            f"column {k} of the matrix G of {letter} is zero; leave it out. A {letter} "
            f"that is known, zero too, is given in the plant, with {letter}=None here"
        )
    parts = np.array([np.outer(g, g) for g in G.T])
    return Form(letter, np.zeros((len(G), len(G))), tuple(names), parts, unit)


def _positive(letter: str, start: Any) -> Vector:
    try:
        found = np.array([] if start is None else start, dtype=float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.ndim != 1 or not len(found) or not ((found > 0) & (found < np.inf)).all():
        raise ValueError(
            f"{letter} is a function of positive numbers q, so the search needs some "
            f"to begin with: start={{'{letter}': [q0, q1, ...]}}; got {short(start)}"
        )
    return found
