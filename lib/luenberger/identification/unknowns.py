"""All that is unknown of a plant as one vector: noises, then parameters."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..plant.checks import check_joint
from ..plant.instant import Instant
from .forms import Form
from .parameters import PARTS, Parameters


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

    @property
    def labels(self) -> list[str]:
        """Their names."""
        return [*self.Q.labels, *self.R.labels, *self.parameters.names]

    def split(self, theta: Vector) -> tuple[Vector, Vector, Vector]:
        """Those of Q, those of R, and the values of the parameters."""
        q, r = self.Q.count, self.Q.count + self.R.count
        more = self.parameters
        return theta[:q], theta[q:r], np.asarray(more.begin) + more.scale * theta[r:]

    def plant(self, theta: Vector) -> Plant:
        """The plant at a vector."""
        q, r, values = self.split(theta)
        return self.with_noise(self.Q.matrix(q), self.R.matrix(r), values)

    def instant(self, theta: Vector) -> Instant | None:
        """The matrices alone, without a Plant's checks, where only noises move."""
        template = self.parameters.template
        if self.parameters.names or self.S is not None or template.steps is not None:
            return None
        q, r, _ = self.split(theta)
        Q, R = self.Q.matrix(q), self.R.matrix(r)
        return template.at(0)._replace(Q=Q, R=R, S=None)

    @property
    def moved(self) -> tuple[str, ...]:
        """The matrices that the vector may move."""
        noises = [form.letter for form in (self.Q, self.R) if form.count]
        more = PARTS if self.parameters.names else ()
        return tuple(dict.fromkeys([*noises, *more]))

    def with_noise(self, Q: Matrix, R: Matrix, values: Vector) -> Plant:
        """The plant with these covariances and parameters.

        Raises
        ------
        DesignError
            If S, which is known, is more than Q and R allow.
        """
        made = self.parameters.plant(values)
        known: dict[str, Any] = {"Q": Q, "R": R, "S": self.S}
        if not self.Q.count and made.Q is not None:
            known["Q"] = made.Q
        if not self.R.count and made.R is not None:
            known["R"] = made.R
        require_room(known["Q"], known["R"], self.S)
        return dataclasses.replace(made, **known)

    def slopes(self, theta: Vector) -> list[Matrices]:
        """For each entry of the vector, how the matrices of the plant move with it."""
        q, r, values = self.split(theta)
        found: list[Matrices] = [{"Q": X} for X in self.Q.slopes(q)]
        found += [{"R": X} for X in self.R.slopes(r)]
        for slope, size in zip(self.parameters.slopes(values), self.parameters.scale):
            if self.Q.count:
                slope.pop("Q", None)
            if self.R.count:
                slope.pop("R", None)
            found.append({name: X * size for name, X in slope.items()})
        return found


def require_room(Q: Matrix | None, R: Matrix | None, S: Matrix | None) -> None:
    """DesignError unless a known S goes with Q and R."""
    if S is None:
        return
    try:
        check_joint(Q, R, S)
    except ValueError as error:
        raise DesignError(
            "S, which is known, is too large for the Q and R that the record shows, "
            "or that the search begins with: [[Q, S], [S', R]] is no covariance. Give "
            "a smaller S, or larger Q and R to begin with, start={'Q': ..., 'R': ...}"
        ) from error


def along(gradient: Matrices, slope: Matrices) -> float:
    """How fast a number rises along a slope, from its gradients in the matrices."""
    return float(sum((gradient[name] * X).sum() for name, X in slope.items()))
