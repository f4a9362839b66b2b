"""What the smoother's way back carries from row to row, and what it finds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..numeric import Matrix
from ..recursion.root_step import Move

LEFT = 1e-3  # of a variance: what a difference may leave
MOST = 1e3  # what later rows may say of a variance by itself, the others being known


class Carried(NamedTuple):
    """What later rows leave to a row: by what they say, or by the next state.

    ``lamda`` (n, 1) and ``Ahead`` are of the next row's prediction, ``Theta`` is of its
    estimate.  Once ``half`` is there, it is a factor of the next row's smoothed
    covariance, and ``x`` (n, 1) its estimate: then what they say is not carried any
    more.
    """

    lamda: np.ndarray
    Theta: np.ndarray
    Ahead: np.ndarray
    x: np.ndarray
    half: np.ndarray | None


@dataclass(frozen=True, eq=False)
class Back:
    """What the pass finds, row by row.

    Attributes
    ----------
    x : (N, n) ndarray
        Smoothed estimates.
    Sigma : (N, n, n) ndarray
        Covariances of their errors.
    U : (N + 1, n, n) ndarray or None
        E[e_k e_{k-1}'], in row k, if it was asked for.  The first row is for what was
        before the record, the last has no meaning.
    lamda : (N + 1, n) ndarray
        What rows from k on say of the prediction of row k.
    deviations : (N, n) ndarray or None
        Roots of the diagonals of Sigma, if they were found by the way: reading them off
        takes as long as reading all of Sigma.
    """

    x: np.ndarray
    Sigma: np.ndarray
    U: np.ndarray | None
    lamda: np.ndarray
    deviations: np.ndarray | None = None

    def std(self, rows: slice) -> Matrix:
        """Standard deviations of some rows."""
        if self.deviations is not None:
            return self.deviations[rows]
        return roots(self.Sigma[rows].diagonal(axis1=1, axis2=2).copy())


def roots(variances: Matrix) -> Matrix:
    """Standard deviations in place of variances."""
    return np.sqrt(np.maximum(variances, 0, out=variances), out=variances)


class Ways(NamedTuple):
    """How rows lead on: for row k, C (p, n) and the `Move` to the next row.

    ``As`` and ``C`` are those of all rows, or stacks with one for each.
    """

    As: np.ndarray
    C: np.ndarray
    move: Callable[[int], Move]

    def at(self, k: int) -> tuple[Matrix, Matrix]:
        """As and C of row k."""
        As, C = (X if X.ndim == 2 else X[k] for X in (self.As, self.C))
        return As, C
