"""All that is unknown of a plant as one vector: noises, then parameters."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import expect_as
from ..errors import DesignError, few, short
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..plant.plant import check_joint
from .forms import Form

ENTRY = re.compile(r"([ABCE])\[(\d+),\s*(\d+)\]")
WANTED = (
    "parameters must be {'B[1,0]': start, ...}, entries of A, B, C or E counted from "
    "0 with where to begin, or (function, {'name': start, ...}) with a function of "
    "their vector that returns a Plant"
)


@dataclass(frozen=True, eq=False)
class Parameters:
    """Numbers that a plant depends on: named entries of its matrices, or a function's.

    Attributes
    ----------
    template : Plant
        What they are put into.
    names : tuple of str
    begin : (k,) ndarray
        Where the search begins.
    function : callable, optional
        What makes a plant of their vector; else they are entries.
    """

    template: Plant
    names: tuple[str, ...] = ()
    begin: Any = ()
    function: Callable[[Vector], Plant] | None = None

    @property
    def scale(self) -> Vector:
        """A step of the search, which is the size of what it begins with, or 1."""
        begin = np.abs(np.array(self.begin, dtype=float))
        return np.where(begin > 0, begin, 1.0)

    @property
    def places(self) -> list[tuple[str, int, int]]:
        """Letter, row and column of each entry."""
        found = map(ENTRY.fullmatch, self.names if self.function is None else ())
        return [(one[1], int(one[2]), int(one[3])) for one in found if one]

    def plant(self, values: Vector) -> Plant:
        """The plant at these values."""
        if self.function is None:
            changed: dict[str, Any] = {}
            for (letter, i, j), value in zip(self.places, values):
                if letter not in changed:
                    changed[letter] = getattr(self.template, letter).copy()
                changed[letter][..., i, j] = value
            return dataclasses.replace(self.template, **changed)
        found = self.function(np.array(values, dtype=float))
        expect_as("what the function of the parameters returns", "plant", found)
        sizes, wanted = ((one.n, one.m, one.p) for one in (found, self.template))
        if sizes != wanted:
            raise ValueError(
                "the function of the parameters must return a plant with n, m, p = "
                f"{wanted}, as the plant that is fitted; it returned {sizes}"
            )
        return found


def parameters_of(plant: Plant, wanted: Any) -> Parameters:
    """The parameters that a caller names."""
    if wanted is None:
        return Parameters(plant)
    function = None
    if isinstance(wanted, tuple) and len(wanted) == 2 and callable(wanted[0]):
        function, wanted = wanted
    if not isinstance(wanted, Mapping) or not wanted:
        raise ValueError(f"{WANTED}; got {short(wanted)}")
    names, begin = tuple(wanted), np.array([_number(*one) for one in wanted.items()])
    found = Parameters(plant, names, begin, function)
    if function is None:
        unknown = [name for name in names if not ENTRY.fullmatch(name)]
        if unknown:
            raise ValueError(f"{few(unknown)} are no entries of the plant; {WANTED}")
        for name, (letter, i, j) in zip(names, found.places):
            rows, columns = getattr(plant, letter).shape[-2:]
            if i >= rows or j >= columns:
                raise ValueError(f"there is no {name}: {letter} is {rows} x {columns}")
        if len(set(found.places)) < len(names):
            raise ValueError(f"parameters {few(names)} name one entry twice")
    return found


def _number(name: Any, value: Any) -> float:
    if not isinstance(name, str):
        raise ValueError(f"{WANTED}; {short(name)} is no name")
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = np.nan
    if not np.isfinite(found):
        raise ValueError(f"the start of parameter {name!r} is no number: {value!r}")
    return found


@dataclass(frozen=True, eq=False)
class Unknowns:
    """The vector that a search moves, and the plant at it.

    Its first entries are those of the form of Q, then those of R; then, for each
    parameter, its distance from where it began in units of its size.

    Attributes
    ----------
    Q, R : Form
    S : (n, p) ndarray or None
        Known.
    parameters : Parameters
    """

    Q: Form
    R: Form
    S: np.ndarray | None
    parameters: Parameters

    @property
    def count(self) -> int:
        """Numbers that are unknown."""
        return self.Q.count + self.R.count + len(self.parameters.names)

    def split(self, theta: Vector) -> tuple[Vector, Vector, Vector]:
        """Those of Q, those of R, and the values of the parameters."""
        q, r = self.Q.count, self.Q.count + self.R.count
        more = self.parameters
        return theta[:q], theta[q:r], np.asarray(more.begin) + more.scale * theta[r:]

    def noises(self, theta: Vector) -> Matrices:
        """Q and R at a vector."""
        q, r, _ = self.split(theta)
        return {"Q": self.Q.matrix(q), "R": self.R.matrix(r)}

    def ways(self, theta: Vector, linear: bool = False) -> list[Matrices]:
        """For each number of Q and R, how the covariance moves with it.

        The numbers are those of the vector, or those in which covariances are linear.
        """
        q, r, _ = self.split(theta)
        Q, R = ((one.directions if linear else one.slopes) for one in (self.Q, self.R))
        return [{"Q": X} for X in Q(q)] + [{"R": X} for X in R(r)]

    def plant(self, noises: Matrices, made: Plant, checked: bool = False) -> Plant:
        """A plant with these Q and R, and S; those of the plant where they are known.

        `checked` it is as any other plant; else nothing is asked of its covariances.

        Raises
        ------
        DesignError
            If S, which is known, is more than Q and R allow.
        """
        own = {"Q": self.Q.count, "R": self.R.count}
        known = {k: X if own[k] or getattr(made, k) is None else getattr(made, k)
                 for k, X in noises.items()} | {"S": self.S}  # fmt: skip
        require_room(known["Q"], known["R"], self.S)
        if checked:
            return dataclasses.replace(made, **known)
        return changed(made, **known)


def changed(plant: Plant, **parts: Any) -> Plant:
    """The plant with other parts, of which nothing is asked: that takes its time."""
    found = object.__new__(type(plant))
    vars(found).update(plant.__getstate__(), **parts)
    return found


def require_room(Q: Matrix | None, R: Matrix | None, S: Matrix | None) -> None:
    """DesignError unless a known S goes with Q and R."""
    try:
        check_joint(Q, R, S)
    except ValueError as error:
        raise DesignError(
            "S, which is known, is too large for the Q and R that the record shows, "
            "or that the search begins with: [[Q, S], [S', R]] is no covariance. Give "
            "a smaller S, or larger Q and R to begin with, start={'Q': ..., 'R': ...}"
        ) from error
