"""What the likelihood and its score need of a filter's rows."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..recursion.filter_stacks import BEFORE, FILTER
from ..recursion.state import Step, flat
from .derivation import likelihood_step, prediction_gain, weighed
from .innovations import counted, pivots

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
        x, e, Omega, G, W = (np.zeros((some, *size)) for size in sizes)
        free = ~np.isnan(y)
        nu, M = np.zeros((N, p)), np.zeros((N, p, p))
        log_det, square = np.full((2, N), np.nan)
        compiled = np.ones(N, dtype=bool)
        rows = log_det, square, compiled, np.zeros((N, n))
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
        seen = np.flatnonzero(row.state.seen)
        self.compiled[k] = False
        self.variances[k] = row.state.Sigma.diagonal()
        if "L" not in row.new:
            self.M[k] = np.eye(len(self.M[k]))
            self.M[k][np.ix_(seen, seen)] = row.new["M"]
            self.innovations[k, seen] = row.innovation[:, 0]
            if self.kept:
                found = kernels.compiled(weighed)(
                    M=row.new["M"], innovation=row.innovation
                )
                self.put_score(k, row, seen, found | {"taken": np.eye(len(seen))})
            return
        here = counted(row)
        at = seen[here.free]
        self.free[k] = False
        self.free[k, at] = True
        self.log_det[k], self.square[k] = here.log_det, here.z @ here.z
        self.innovations[k], self.M[k] = 0, np.eye(len(self.free[k]))
        self.innovations[k, seen[here.free]] = here.z
        if self.kept:
            self.put_score(k, row, at, here.found())

    def put_score(self, k: int, row: Step, at: Vector, found: Matrices) -> None:
        """What the score needs of row k; `at` are the entries that count."""
        state, new, now = row.state, row.new, row.state.setting
        assert now is not None
        self.x[k] = (state.x - new["K"] @ row.innovation)[:, 0]
        self.Omega[k] = new["Omega"]
        self.e[k, at] = found["e"][:, 0]
        self.W[k][np.ix_(at, at)] = found["W"]
        gain = kernels.compiled(prediction_gain)(As=now.As, J=now.J, Kmv=new["K"])
        self.G[k][:, at] = gain["G"] @ found["taken"]

    def part(self, rows: slice) -> Trail:
        """Some of its rows."""
        return Trail(*(getattr(self, one.name)[rows] for one in fields(self)))

    def settled(self) -> Trail:
        """The same, with what compiled code leaves to do for all its rows at once."""
        rows = np.isnan(self.log_det)
        log_det, square = pivots(self.M[rows], self.innovations[rows])
        self.log_det[rows], self.square[rows] = log_det, square
        if self.kept and not self.free.all():
            # beside the ones of what did not arrive there are zeros
            self.W[self.compiled] *= self.free[self.compiled][:, :, None]
        return self
