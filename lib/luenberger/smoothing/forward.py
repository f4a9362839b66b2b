"""The filter's pass over a record, with all that a smoother needs of each row."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import CLEAR, lengths
from ..papers.leondes_novak.derivation import kept_step
from ..plant import Plant
from ..recursion.filter_stacks import FILTER
from ..recursion.predicted import Loops
from ..recursion.root_step import Spread
from ..recursion.settings import Setting
from ..recursion.state import Step, flat
from .derivation import said, said_by_root

_KEPT = replace(
    FILTER,
    stages=kept_step,
    written=(
        *FILTER.written,
        ("innovations", "innovation", "vector"),
        ("sayings", "W", "matrix"),
    ),
)
KEPT = Loops(_KEPT)


@dataclass(frozen=True, eq=False)
class Kept:
    """Rows of the filter's pass.

    Attributes
    ----------
    x : (N, n) ndarray
        The filter's estimates.
    Sigma : (N, n, n) ndarray
        Covariances of their errors.
    K : (N + 1, n, p) ndarray
        Gains; columns of missing outputs are zero, and so is all behind the last row.
    W : (N + 1, p, p) ndarray
        How much the innovations say; the same holds of it.
    innovation : (N, p) ndarray
        Zero for missing outputs.
    variances : (N, n) ndarray
    spreads : dict of int to Spread
        Of the rows whose covariance is singular, or nearly.
    """

    x: np.ndarray
    Sigma: np.ndarray
    K: np.ndarray
    W: np.ndarray
    innovation: np.ndarray
    variances: np.ndarray
    spreads: dict[int, Spread] = field(default_factory=dict)

    kept = True

    @classmethod
    def empty(cls, rows: int, plant: Plant) -> Kept:
        """Room for so many rows."""
        n, p = plant.n, plant.p
        x, variances, Sigma = (np.empty((rows, *s)) for s in ((n,), (n,), (n, n)))
        K, W = np.empty((rows + 1, n, p)), np.empty((rows + 1, p, p))
        K[rows:], W[rows:] = 0, 0
        return cls(x, Sigma, K, W, np.empty((rows, p)), variances)

    def put(self, k: int, row: Step) -> None:
        """Write row k, which NumPy did."""
        state, seen = row.state, row.state.seen
        assert state.setting is not None
        self.x[k], self.Sigma[k] = state.x[:, 0], state.Sigma
        self.variances[k] = state.Sigma.diagonal()
        for X in (self.K, self.W, self.innovation):
            X[k] = 0
        self.K[k][:, seen] = row.new["K"]
        self.W[k][np.ix_(seen, seen)] = _said(state.setting, row.new)
        self.innovation[k][seen] = row.innovation[:, 0]
        if state.spread.half is not None:
            self.spreads[k] = state.spread

    @property
    def arrays(self) -> Matrices:
        """What compiled code writes to."""
        return dict(
            xs=self.x, variances=self.variances, covariances=flat(self.Sigma),
            gains=flat(self.K), innovations=self.innovation, sayings=flat(self.W),
        )  # fmt: skip

    def forget(self, missing: Matrix) -> None:
        """Have the outputs `missing` (N, p) say nothing; compiled code does not."""
        k, j = np.nonzero(missing)
        self.W[k, j, j] = 0

    def spread(self, k: int) -> Spread:
        """The covariance of row k, with its factor where one was kept."""
        return self.spreads.get(k) or Spread(self.Sigma[k])

    def __len__(self) -> int:
        return len(self.x)

    def since(self, k: int) -> Kept:
        """Row k and those behind it."""
        x, Sigma, K, W, innovation, variances = (X[k:] for X in self._rows)
        moved = {i - k: one for i, one in self.spreads.items() if i >= k}
        return Kept(x, Sigma, K, W, innovation, variances, moved)

    def before(self, other: Kept) -> Kept:
        """These rows and then those of `other`."""
        N = len(self)
        x, Sigma, K, W, innovation, variances = (
            np.concatenate([X[:N], Z]) for X, Z in zip(self._rows, other._rows)
        )
        moved = {i + len(self): one for i, one in other.spreads.items()}
        return Kept(x, Sigma, K, W, innovation, variances, self.spreads | moved)

    @property
    def _rows(self) -> tuple[Matrix, ...]:
        return self.x, self.Sigma, self.K, self.W, self.innovation, self.variances


def _said(now: Setting, new: Matrices) -> Matrix:
    """W of one row, from the matrices of its step."""
    if "L" not in new:
        return kernels.compiled(said)(M=new["M"])["W"]
    Z = np.concatenate([new["L"], now.V], axis=1)
    B = inverse_root(Z, new.get("unit"))
    return kernels.compiled(said_by_root)(B=B)["W"]


def inverse_root(Z: Matrix, unit: Vector | None) -> Matrix:
    """B with B B' an inverse of Z Z', as far as it has one.

    `unit` (p,) is the rounding in each row of Z, and what is below is taken for
    zero; without it Z Z' is definite.
    """
    scale = lengths(Z) if unit is None else unit
    scale = np.where(scale > 0, scale, np.inf)  # a row of no size says nothing
    U, D, _ = np.linalg.svd(Z / scale[:, None], full_matrices=False)
    keep = D > (0 if unit is None else CLEAR)
    return U[:, keep] / D[keep] / scale[:, None]
