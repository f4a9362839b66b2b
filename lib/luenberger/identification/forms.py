"""Forms of an unknown covariance: full, diagonal, along given columns, a function.

A form is a linear part of all covariances, with a name for each of its coordinates,
and a way to reach its semi-definite ones from a vector without bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from ..errors import DesignError, short
from ..numeric import Matrix, Vector, covariances
from ..numeric.validation import matrix

Function = Callable[[Vector], Any]
LEAST = 1e-3  # of a start that is singular: its share of the unit, as a deviation
FAR = 300.0  # logarithm of a deviation beyond which floats end
STEP = 1e-5  # relative, for slopes of a user's function


class Shape(Protocol):
    """A covariance as a function of a vector."""

    @property
    def known(self) -> Matrix:
        """A matrix of its size."""

    @property
    def count(self) -> int:
        """Entries of the vector."""

    def matrix(self, theta: Vector) -> Matrix:
        """The covariance."""

    def slopes(self, theta: Vector) -> Matrix:
        """Its derivative, a stack."""


@dataclass(frozen=True, eq=False)
class Form:
    """A covariance that is known: nothing is free.

    Attributes
    ----------
    letter : str
        "Q" or "R".
    known : (k, k) ndarray
        The covariance; for other forms, zeros of its size.
    """

    letter: str
    known: np.ndarray

    @property
    def labels(self) -> list[str]:
        """Names of the coordinates in which the covariance is linear."""
        return []

    @property
    def directions(self) -> Matrix:
        """What each of them adds, as (count, k, k)."""
        return np.zeros((0, *self.known.shape))

    @cached_property
    def count(self) -> int:
        """Numbers that are free."""
        return len(self.labels)

    def matrix(self, theta: Vector) -> Matrix:
        """The covariance at a vector (count,)."""
        return self.known

    def slopes(self, theta: Vector) -> Matrix:
        """(count, k, k): its derivative there."""
        return self.directions

    def at(self, X: Matrix, unit: Vector) -> Vector:
        """The vector at which the covariance is near X, whose unit is `unit` (k,)."""
        return np.zeros(0)


@dataclass(frozen=True, eq=False)
class Full(Form):
    """Every entry is free: X = U N N' U with a lower triangle N of positive diagonal.

    `unit` (k,) is the diagonal of U, so that N has entries of size one.
    """

    unit: Any = None

    @property
    def labels(self) -> list[str]:
        return [f"{self.letter}[{i},{j}]" for i, j in zip(*self._entries)]

    @cached_property
    def _entries(self) -> tuple[Vector, Vector]:
        return np.triu_indices(len(self.known))

    @property
    def directions(self) -> Matrix:
        rows, columns = self._entries
        found = np.zeros((len(rows), *self.known.shape))
        found[np.arange(len(rows)), rows, columns] = 1
        return np.maximum(found, found.mT)

    def _triangle(self, theta: Vector) -> Matrix:
        columns, rows = self._entries
        N = np.zeros(self.known.shape)
        N[rows, columns] = np.where(rows == columns, np.exp(_capped(theta)), theta)
        return N

    @property
    def scale(self) -> Vector:
        return np.ones(len(self.known)) if self.unit is None else self.unit

    def matrix(self, theta: Vector) -> Matrix:
        half = self.scale[:, None] * self._triangle(theta)
        return half @ half.T

    def slopes(self, theta: Vector) -> Matrix:
        columns, rows = self._entries
        N, unit = self._triangle(theta), self.scale
        dN = np.zeros((self.count, *N.shape))
        dN[np.arange(self.count), rows, columns] = np.where(
            rows == columns, N[rows, columns], 1.0
        )
        half = dN @ N.T * unit[:, None] * unit
        return half + half.mT

    def at(self, X: Matrix, unit: Vector) -> Vector:
        scaled = X / self.scale / self.scale[:, None]
        floor = (LEAST * unit / self.scale) ** 2
        values, vectors = np.linalg.eigh(
            scaled / np.sqrt(floor) / np.sqrt(floor)[:, None]
        )
        lifted = (vectors * np.maximum(values, 1)) @ vectors.T
        N = np.linalg.cholesky(lifted * np.sqrt(floor) * np.sqrt(floor)[:, None])
        columns, rows = self._entries
        found = N[rows, columns]
        return np.where(
            rows == columns, np.log(np.where(rows == columns, found, 1)), found
        )


@dataclass(frozen=True, eq=False)
class Along(Form):
    """X = sum of q_k X_k with variances q_k > 0: diagonal, or G diag(q) G'.

    Attributes
    ----------
    parts : (count, k, k) ndarray
        The X_k.
    names : tuple of str
    """

    parts: Any = None
    names: tuple[str, ...] = ()

    @property
    def labels(self) -> list[str]:
        return list(self.names)

    @property
    def directions(self) -> Matrix:
        return self.parts

    def matrix(self, theta: Vector) -> Matrix:
        return np.tensordot(_variances(theta), self.parts, 1)

    def slopes(self, theta: Vector) -> Matrix:
        return 2 * _variances(theta)[:, None, None] * self.parts

    def at(self, X: Matrix, unit: Vector) -> Vector:
        scale = unit * unit[:, None]
        flat = (self.parts / scale).reshape(len(self.parts), -1)
        size = np.linalg.norm(flat, axis=1)
        wanted = (X / scale).ravel()
        q = np.linalg.lstsq((flat / size[:, None]).T, wanted, rcond=None)[0]
        return 0.5 * np.log(np.maximum(q, LEAST**2) / size)


@dataclass(frozen=True, eq=False)
class Of(Form):
    """X = f(q) with a function of positive numbers q, such as intensities."""

    function: Function = np.diag
    begin: Any = None

    @property
    def labels(self) -> list[str]:
        return [f"{self.letter.lower()}[{k}]" for k in range(len(self.begin))]

    @property
    def directions(self) -> Matrix:
        return self.slopes(0.5 * np.log(self.begin)) / (2 * self.begin[:, None, None])

    def matrix(self, theta: Vector) -> Matrix:
        X = self.function(_variances(theta))
        return covariances.covariance(f"{self.letter}(q)", X, len(self.known))

    def slopes(self, theta: Vector) -> Matrix:
        steps = STEP * np.eye(len(theta))
        pairs = [(self.matrix(theta + d), self.matrix(theta - d)) for d in steps]
        found = [(up - down) / (2 * STEP) for up, down in pairs]
        return np.array(found).reshape(-1, *self.known.shape)

    def at(self, X: Matrix, unit: Vector) -> Vector:
        return 0.5 * np.log(self.begin)


def _variances(theta: Vector) -> Vector:  # theta = -inf is a variance at its bound
    return np.where(theta == -np.inf, 0.0, np.exp(2 * _capped(theta)))


def _capped(theta: Vector) -> Vector:
    return np.clip(theta, -FAR, FAR)


def form_of(
    letter: str, wanted: Any, size: int, given: Any, start: Any, unit: Vector
) -> Form:
    """The form that a caller asks for.

    Parameters
    ----------
    letter : str
        "Q" or "R".
    wanted : "full", "diagonal", "scaled", None, matrix or callable
        None is the plant's own, which is `given`, and "scaled" that times a number; a
        matrix has the columns G.
    size : int
    given, start : ndarray or None
        The plant's covariance; where the search is to begin.
    unit : (size,) ndarray
        Sizes of the noise, for scaling.
    """
    none = np.zeros((size, size))
    if wanted is None:
        if given is None:
            raise DesignError(
                f"{letter}=None keeps the plant's {letter}, and it has none; give "
                f"Plant(..., {letter}=...), or a form: 'full', 'diagonal' or a matrix"
            )
        return Form(letter, given)
    if callable(wanted):
        return Of(letter, none, wanted, _positive(letter, start))
    if isinstance(wanted, str):
        if wanted == "full":
            return Full(letter, none, unit)
        if wanted == "scaled":
            return _scaled(letter, given)
        if wanted == "diagonal":
            names = tuple(f"{letter}[{k},{k}]" for k in range(size))
            return _along(letter, np.eye(size), names)
    elif np.ndim(wanted) == 2:
        G = matrix(f"{letter}, a matrix G,", wanted, rows=size)
        return _along(letter, G, [f"{letter.lower()}[{k}]" for k in range(G.shape[1])])
    raise ValueError(
        f"{letter} must be 'full', 'diagonal', 'scaled', a matrix G ({size} x k) for "
        f"{letter} = G diag(q) G', a function of q, or None for the plant's own; got "
        f"{short(wanted)}"
    )


def _scaled(letter: str, given: Any) -> Along:
    if given is None or not np.any(given):
        raise DesignError(
            f"{letter}='scaled' is the plant's {letter} times a number, and the plant "
            f"has none; give Plant(..., {letter}=...)"
        )
    name = f"{letter.lower()}[0]"
    return Along(letter, np.zeros(np.shape(given)), np.array(given)[None], (name,))


def _along(letter: str, G: Matrix, names: Sequence[str]) -> Along:
    for k in np.flatnonzero(~G.any(axis=0)).tolist():
        raise ValueError(
            f"column {k} of the matrix G of {letter} is zero; leave it out. A {letter} "
            f"that is known, zero too, is given in the plant, with {letter}=None here"
        )
    parts = np.array([np.outer(g, g) for g in G.T])
    return Along(letter, np.zeros((len(G), len(G))), parts, tuple(names))


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
