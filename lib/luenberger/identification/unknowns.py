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
from .forms import Form
from .parameters import Parameters


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
        """For each number of Q and R, how the covariance moves with it."""
        q, r, _ = self.split(theta)
        return [{"Q": X} for X in self.Q.slopes(q)] + [
            {"R": X} for X in self.R.slopes(r)
        ]


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
