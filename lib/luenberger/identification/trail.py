"""What the likelihood and its score need of a filter's rows."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..recursion.filter_stacks import BEFORE, FILTER
from ..recursion.state import Step, flat
from .derivation import likelihood_step, prediction_gain
from .innovations import Innovation, counted, pivots

TOGETHER = 4096  # rows of which determinants are found at once

LIKELIHOOD = kernels.Recursion(
    likelihood_step,
    carried=FILTER.carried,
    rows=FILTER.rows,
    written=(
        ("innovations", "innovation", "vector"),
        ("Ms", "M", "vector"),
        ("variances", "Sigma_next", "diagonal"),
        ("predictions", "x_minus", "matrix"),
        ("es", "e", "matrix"),
        ("Omegas", "Omega", "matrix"),
        ("Ws", "W", "matrix"),
    ),
    before=tuple(BEFORE),
    symmetric=FILTER.symmetric,
    definite=FILTER.definite,
    same=FILTER.same,
)


@dataclass(frozen=True, eq=False)
class Trail:
    """A row for each row of the record; outputs that do not count have zeros.

    Until rows are written there is anything in them.

    Attributes
    ----------
    innovations : (N, p) ndarray
    M : (N, p, p) ndarray
        Their covariances, with ones for outputs that did not arrive.  In a row that
        NumPy did they are whitened already, and M is the identity.
    free : (N, p) ndarray of bool
        The entries that count: they arrived, and those before do not determine them.
    log_det, square : (N,) ndarray
        log det(M) and innovation' W innovation of those; NaN until they are `settled`.
    compiled : (N,) ndarray of bool
        Whether compiled code did the row; it leaves out G.
    variances : (N, n) ndarray
        Of the estimates of the state; of its predictions in rows that go from one to
        the next.
    x, e, Omega, G, W : (N, ...) ndarray
        Predictions, weighed innovations, covariances of predictions, gains of the next
        predictions, and inverses of M; without rows where the score is not wanted.
    """

    innovations: np.ndarray
    M: np.ndarray
    free: np.ndarray
    log_det: np.ndarray
    square: np.ndarray
    compiled: np.ndarray
    variances: np.ndarray
    x: np.ndarray
    e: np.ndarray
    Omega: np.ndarray
    G: np.ndarray
    W: np.ndarray

    @classmethod
    def empty(cls, plant: Plant, y: Matrix, score: bool) -> Trail:
        """Room for the rows of y (N, p), with what the score needs if it is wanted."""
        (N, p), n = y.shape, plant.n
        some = N if score else 0
        sizes = (n,), (p,), (n, n), (n, p), (p, p)
        x, e, Omega, G, W = (np.empty((some, *size)) for size in sizes)
        free = ~np.isnan(y)
        nu, M = np.empty((N, p)), np.empty((N, p, p))
        log_det, square = np.full((2, N), np.nan)
        compiled = np.ones(N, dtype=bool)
        rows = log_det, square, compiled, np.empty((N, n))
        return cls(nu, M, free, *rows, x, e, Omega, G, W)

    @property
    def kept(self) -> bool:
        """Whether there is what the score needs."""
        return len(self.W) > 0

    @property
    def arrays(self) -> Matrices:
        """What compiled code writes to."""
        whole = dict(innovations=self.innovations, predictions=self.x, es=self.e)
        whole |= dict(variances=self.variances)
        stacks = dict(Ms=self.M, Omegas=self.Omega, Ws=self.W)
        return whole | {name: flat(X) for name, X in stacks.items()}

    def put(self, k: int, row: Step) -> None:
        """Write row k, which NumPy did."""
        self.put_counted(k, row, counted(row))

    def put_counted(self, k: int, row: Step, here: Innovation) -> None:
        """The same, where it is known what the row says."""
        at = np.flatnonzero(row.state.seen)[here.free]
        self.compiled[k] = self.free[k] = False
        self.free[k, at] = True
        self.variances[k] = row.state.Sigma.diagonal()
        self.log_det[k], self.square[k] = here.log_det, here.z @ here.z
        self.innovations[k], self.M[k] = 0, np.eye(len(self.free[k]))
        self.innovations[k, at] = here.z
        if self.kept:
            self.put_score(k, row, at, here.found())

    def put_score(self, k: int, row: Step, at: Vector, found: Matrices) -> None:
        """What the score needs of row k; `at` are the entries that count."""
        state, new, now = row.state, row.new, row.state.setting
        assert now is not None
        self.x[k] = (state.x - new["K"] @ row.innovation)[:, 0]
        self.Omega[k] = new["Omega"]
        self.e[k], self.W[k], self.G[k] = 0, 0, 0
        self.e[k, at] = found["e"][:, 0]
        self.W[k][at[:, None], at] = found["W"]
        gain = kernels.compiled(prediction_gain)(As=now.As, J=now.J, Kmv=new["K"])
        self.G[k][:, at] = gain["G"] @ found["taken"]

    def part(self, rows: slice) -> Trail:
        """Some of its rows."""
        return Trail(*(getattr(self, one.name)[rows] for one in fields(self)))

    def longer(self, plant: Plant, y: Matrix) -> Trail:
        """The same rows, with room for all of y."""
        found = Trail.empty(plant, y, self.kept)
        for one in fields(self):
            getattr(found, one.name)[: len(self.free)] = getattr(self, one.name)
        return found

    def settled(self) -> Trail:
        """The same, with what compiled code leaves to do for all its rows at once."""
        for k in range(0, len(self.free), TOGETHER):
            rows = slice(k, k + TOGETHER)
            left = np.isnan(self.log_det[rows])
            for mine, found in zip(
                (self.log_det[rows], self.square[rows]),
                pivots(self.M[rows], self.innovations[rows]),
            ):
                np.copyto(mine, found, where=left)
        if self.kept and not self.free.all():
            # beside the ones of what did not arrive there are zeros
            k, j = np.nonzero(~self.free)
            self.W[k, j] = self.W[k, :, j] = 0
        return self
