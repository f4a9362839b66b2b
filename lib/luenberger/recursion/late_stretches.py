"""Stretches of rows that are on time, many at once: grown at either end.

The formulas are those of late_stretch.py and late_joined.py in
papers/leondes_novak/derivation.  They run in compiled code, or in NumPy over stacks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import factor
from ..papers.leondes_novak.derivation import late_pair, late_row, late_single
from .filter_stacks import BEFORE, Stacks
from .late_passage import MOST, PARTS, Stretches, found_of
from .state import State, flat

NAMES = ("A", "B", "Q", "C", "E", "R")
SHAPES = dict(A="nn", B="nm", Q="nn", C="pn", E="pm", R="pp")
INPUTS = (("y", "y", 0), ("u", "u", 0), ("u_next", "u", 1))
KINDS = dict(zip(PARTS, ("matrix", "vector", "matrix", "vector", "matrix")))
ROW = kernels.Recursion(
    late_row,
    carried=tuple((f"{name}_next", name) for name in PARTS),
    rows=INPUTS,
    written=tuple((f"{name}s", f"{name}_next", kind) for name, kind in KINDS.items()),
    symmetric=("Q", "R", "Sigma", "Lambda"),
    fresh=True,
)
SINGLE = kernels.Recursion(
    late_single,
    carried=(),
    rows=INPUTS,
    written=(("xis", "xi_next", "vector"), ("thetas", "theta_next", "vector")),
)
PAIR = kernels.Recursion(
    late_pair,
    carried=tuple((name, f"{name}_2") for name in PARTS),
    rows=(("xi_1", "xi_1s", 0), ("theta_1", "theta_1s", 0)),
    written=tuple((f"{name}s", name, kind) for name, kind in KINDS.items()),
    symmetric=("Lambda_1", "Sigma_2", "Lambda_2"),
    backward=True,
    fresh=True,
)
SILENT = {  # the same where no output is on time: C has no rows, and nothing is said
    one: replace(one, zero=zero)
    for one, zero in (
        (ROW, ("C", "E", "theta", "Lambda")),
        (SINGLE, ("K", "W")),
        (PAIR, ("theta_1", "Lambda_1", "theta_2", "Lambda_2")),
    )
}


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a record with what is on time in them.

    Attributes
    ----------
    stacks : Stacks
    tables : dict of str to (U, rows * cols) ndarray
        Matrices: of the step to a row, and of the row.  U is 1 for what all rows have.
    index : (N,) ndarray of int
        The matrices of each row.
    good : (N,) ndarray of bool
        Whether its outputs all carry noise.
    y, u : (N, p), (N + 1, m) ndarray
    changing : frozenset of str
        Names of the tables that have more than one.
    compile : bool
    silent : bool
        Whether no output is on time in any of them.
    """

    stacks: Stacks
    tables: Matrices
    index: np.ndarray
    good: np.ndarray
    y: np.ndarray
    u: np.ndarray
    changing: frozenset[str]
    compile: bool
    silent: bool

    @classmethod
    def of(
        cls, stacks: Stacks, state: State, y: Matrix, u: Matrix, compile: bool,
        silent: bool,
    ) -> Rows:  # fmt: skip
        """The rows after `state`; what is late in them is NaN in y."""
        if silent:  # any readings will do, where nothing is read off them
            y = np.zeros_like(y)
        given, _, changing = stacks.given(state, y, u)
        tables, N = {name: given[name] for name in NAMES}, len(y)
        changing &= frozenset(NAMES)
        index, good = given["now"], given["good"]
        if stacks.varying:
            now = {True: given["before"], False: index}
            tables = {name: X[now[name in BEFORE]] for name, X in tables.items()}
            index = np.arange(N)
        elif not changing:
            index, good = np.zeros(N, dtype=np.int64), np.ones(N, dtype=bool)
        if silent:
            good = np.ones(N, dtype=bool)
            tables |= {name: np.zeros_like(tables[name]) for name in "CE"}
        return cls(
            stacks, tables, index, good, given["y"], given["u"], changing, compile,
            silent,
        )  # fmt: skip

    def matrices(self, index: Vector) -> Matrices:
        """Matrices by their numbers, in stacks; one of what all rows have."""
        sizes = dict(self.stacks.sizes)
        shapes = {name: [sizes[k] for k in two] for name, two in SHAPES.items()}
        some = {k: X if len(X) == 1 else X[index] for k, X in self.tables.items()}
        return {k: X.reshape(len(X), *shapes[k]) for k, X in some.items()}

    def columns(self, rows: Vector) -> Matrices:
        """Readings and inputs of some rows."""
        u, u_next = self.u[rows][..., None], self.u[rows + 1][..., None]
        return dict(y=self.y[rows][..., None], u=u, u_next=u_next)

    def grown(self, stretches: Stretches, rows: Vector) -> Stretches:
        """Each of some stretches, one row longer, in NumPy."""
        have = self.matrices(self.index[rows]) | self.columns(rows)
        have |= stretches.named()
        wanted = tuple(f"{name}_next" for name in PARTS)
        return found_of(kernels.run(late_row, have, *wanted, stacks=True), "_next")

    def growing(
        self, begun: Stretches, fresh: Vector, rows: range, out: Stretches
    ) -> None:
        """Write the stretch up to each row, begun anew where `fresh`; compiled."""
        self.kernel(ROW)(
            start=rows.start, stop=rows.stop, now=self.index, before=self.index,
            good=self.good, keep=True, fresh=fresh, y=self.y, u=self.u,
            **self.tables, **{name: X[0].copy() for name, X in zip(PARTS, begun)},
            **out.arrays(),
        )  # fmt: skip

    def kernel(self, recursion: kernels.Recursion, *more: str) -> Any:
        """A recursion over these rows, compiled; `more` may change as well."""
        known = self.stacks.entries(self.changing)
        known = tuple((name, table) for name, table in known if name in NAMES)
        if self.silent:
            recursion = SILENT[recursion]
        changing = self.changing | (frozenset(more) if self.changing else frozenset())
        return kernels.over_record(recursion, self.stacks.sizes, known, changing)


class Singles:
    """Each of some rows as a stretch by itself, to be put before what follows it."""

    def __init__(self, rows: Rows) -> None:
        self.rows, n = rows, rows.stacks.plant.n
        self.n, U = n, max(map(len, rows.tables.values()))
        found = rows.stacks.found.get(rows.silent) if U == 1 else None
        if found is None:
            found = self.matrices(U)
        if U == 1:
            rows.stacks.found[rows.silent] = found
        self.Phi, self.Lambda = found["Phi_next"], found["Lambda_next"]
        self.F, self.sizes = found["F"], found["sizes"]
        self.xi, self.theta = self.vectors(found["K"], found["W"])

    def matrices(self, U: int) -> Matrices:
        """What the matrices of a row make of it, in stacks of U."""
        rows, n = self.rows, self.n
        have = rows.matrices(np.arange(U)) | Stretches.empty(1, n).named()
        wanted = ("K", "W", "Phi_next", "Sigma_next", "Lambda_next")
        found = kernels.run(late_row, have, *wanted, stacks=True)
        found = {k: np.broadcast_to(X, (U, *X.shape[-2:])) for k, X in found.items()}
        found["F"] = np.zeros((U, n, n))
        for k, Sigma in enumerate(found["Sigma_next"]):
            F = factor(Sigma)
            found["F"][k, :, : F.shape[1]] = F
        return found | {"sizes": np.einsum("kij,kij->ki", found["F"], found["F"])}

    def vectors(self, K: Matrix, W: Matrix) -> tuple[Matrix, Matrix]:
        """What each row says by itself: xi and theta (N, n)."""
        rows, N = self.rows, len(self.rows.y)
        if rows.compile:
            xi, theta = np.zeros((2, N, self.n))
            rows.kernel(SINGLE, "K", "W")(
                start=0, stop=N, now=rows.index, before=rows.index, good=rows.good,
                keep=False, y=rows.y, u=rows.u, K=whole(K), W=whole(W), xis=xi,
                thetas=theta, **rows.tables,
            )  # fmt: skip
            return xi, theta
        have = rows.matrices(rows.index) | rows.columns(np.arange(N))
        have |= dict(K=K[rows.index], W=W[rows.index])
        found = kernels.run(late_single, have, stacks=True)
        return found["xi_next"][..., 0], found["theta_next"][..., 0]

    def before(self, stretches: Stretches, rows: Vector) -> Stretches:
        """Each of some stretches with one row before it, in NumPy."""
        index = self.rows.index[rows]
        have = stretches.named("_2") | dict(
            Phi_1=self.Phi[index], F_1=self.F[index], Lambda_1=self.Lambda[index],
            xi_1=self.xi[rows][..., None], theta_1=self.theta[rows][..., None],
        )  # fmt: skip
        return found_of(kernels.run(late_pair, have, *PARTS, stacks=True))

    def growing(self, fresh: Vector, rows: range, out: Stretches) -> None:
        """Write the stretch from each row to the next that is `fresh`; compiled."""
        index = self.rows.index
        sizes = (("n", self.n), ("r", self.n))
        tables = dict(Phi_1=self.Phi, F_1=self.F, Lambda_1=self.Lambda)
        changing = frozenset(tables) if len(self.F) > 1 else frozenset()
        pair = SILENT[PAIR] if self.rows.silent else PAIR
        kernel = kernels.over_record(pair, sizes, (), changing)
        if changing:
            tables = {name: X[index] for name, X in tables.items()}
        begun = Stretches.empty(1, self.n)
        kernel(
            last=rows.stop - 1, start=0, stop=len(rows), keep=True, fresh=fresh,
            xi_1s=self.xi, theta_1s=self.theta,
            **{name: whole(X) for name, X in tables.items()},
            **{f"{name}_2": X[0].copy() for name, X in zip(PARTS, begun)},
            **out.arrays(),
        )  # fmt: skip

    def clear(self, out: Stretches, rows: Vector) -> Vector:
        """Whether what follows each of these rows says little of its own noise."""
        if self.rows.silent:
            return np.ones(len(rows), dtype=bool)
        said = np.concatenate([out.Lambda, np.zeros((1, self.n**2))])[rows + 1]
        size = self.sizes[self.rows.index[rows]]
        return np.einsum("ki,ki->k", said[:, :: self.n + 1], size) <= MOST


def whole(X: Matrix) -> Matrix:
    """A stack of matrices as compiled code reads it."""
    return flat(kernels.plain_array(np.ascontiguousarray(X)))
