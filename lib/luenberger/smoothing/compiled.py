"""The smoother's way back in compiled code, some rows at a time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrix
from ..numeric.factors import SAFE
from ..recursion.state import flat
from .carried import LEFT, MOST, Back, Carried, Ways
from .derivation import backward_step
from .forward import Kept

NEAR = 2_000_000  # bytes that are worked on at a time: what a processor has at hand

BACKWARD = kernels.Recursion(
    backward_step,
    carried=(
        ("lamda", "lamda_next"),
        ("Lambda", "Lambda_next"),
    ),
    rows=(("innovation", "innovations", 0), ("x", "xs", 0)),
    written=(
        ("smoothed", "x_s", "vector"),
        ("variances", "Sigma_s", "diagonal"),
        ("covariances", "Sigma_s", "matrix"),
        ("sayings", "lamda", "vector"),
        ("thetas", "Theta", "diagonal"),
    ),
    symmetric=("Sigma", "Lambda_next"),
    definite=(Factor("Sigma_s", SAFE, "Sigma"),),
    backward=True,
)
NEIGHBOURS = replace(  # takes half as long again
    BACKWARD,
    carried=(*BACKWARD.carried, ("Ahead", "Ahead_next")),
    written=(*BACKWARD.written, ("neighbours", "U_next", "matrix")),
)


class Compiled:
    """The pass in compiled code, which gives up where digits would be lost.

    Some rows at a time are copied to where the processor finds them at once: it fetches
    ahead what is read forward, and not what is read backward.
    """

    def __init__(self, kept: Kept, ways: Ways, out: Back) -> None:
        self.kept, self.out, (N, n) = kept, out, kept.x.shape
        stacked = {"Sigma", "K", "W"} | {
            name for name in ("As", "C") if getattr(ways, name).ndim == 3
        }
        sizes = (("n", n), ("p", kept.K.shape[2]))
        known = tuple((name, _known(getattr(ways, name))) for name in ("As", "C"))
        recursion = BACKWARD if out.U is None else NEIGHBOURS
        self.kernel = kernels.over_record(recursion, sizes, known, frozenset(stacked))
        given = {name: _stack(getattr(ways, name)) for name in ("As", "C")}
        given |= dict(Sigma=flat(kept.Sigma), K=flat(kept.K), W=flat(kept.W))
        given |= dict(innovations=kept.innovation, xs=kept.x)
        rows = {*stacked, "innovations", "xs"}
        self.far = {name: X for name, X in given.items() if name in rows}
        self.fixed = {name: X for name, X in given.items() if name not in rows}
        assert out.variances is not None  # this pass is given where to write them
        self.found = dict(
            smoothed=out.x, covariances=flat(out.Sigma), sayings=out.lamda,
            variances=out.variances,
        )  # fmt: skip
        if out.U is not None:
            self.found["neighbours"] = flat(out.U[1:])
        width = sum(X[0].nbytes for X in (*self.far.values(), *self.found.values()))
        self.most = min(max(NEAR // width, 16), N)
        self.thetas = np.empty((self.most, n))
        self.near = {
            name: np.empty((self.most, X.shape[1])) for name, X in self.far.items()
        }

    def run(self, carried: Carried, turn: int) -> tuple[Carried, int]:
        """From what is carried to a row: what is carried on, and the row not done."""
        N = len(self.kept)
        while turn < N:
            count = min(self.most, N - turn)
            rows = slice(N - turn - count, N - turn)
            for name, X in self.far.items():
                self.near[name][:count] = X[rows]
            after, done = self._rows(carried, rows, count)
            good = self._good(rows, done)
            if good < done:
                self._restore(rows, count)
                after, done = self._rows(carried, rows, good)
            self._restore(rows, count - done)
            carried, turn = after, turn + done
            if done < count:
                break
        return carried, turn

    def _restore(self, rows: slice, left: int) -> None:
        """Give the first rows the covariances back that they had."""
        self.far["Sigma"][rows][:left] = self.near["Sigma"][:left]

    def _good(self, rows: slice, done: int) -> int:
        """The first turn whose covariance has lost too many digits, or `done`."""
        last = slice(rows.stop - rows.start - done, rows.stop - rows.start)
        before = self.kept.variances[rows][last]
        few = before * LEFT >= self.found["variances"][rows][last]
        few |= before * self.thetas[last] > MOST
        turns = np.flatnonzero(np.any(few, axis=1)[::-1])
        return int(turns[0]) if len(turns) else done

    def _rows(self, carried: Carried, rows: slice, stop: int) -> tuple[Carried, int]:
        """So many of the rows, from the last one down."""
        now = dict(lamda_next=carried.lamda, Lambda_next=carried.Lambda)
        if self.out.U is not None:
            now["Ahead_next"] = carried.Ahead
        found = {name: X[rows] for name, X in self.found.items()}
        after = {name: X.flatten() for name, X in now.items()}
        done = self.kernel(
            last=rows.stop - rows.start - 1, start=0, stop=stop, keep=True,
            thetas=self.thetas, **self.fixed, **self.near, **found, **after,
        )  # fmt: skip
        shaped = {name: after[name].reshape(X.shape) for name, X in now.items()}
        return Carried(
            shaped["lamda_next"], shaped["Lambda_next"],
            shaped.get("Ahead_next", carried.Ahead), carried.x, None,
        ), done  # fmt: skip


def _known(X: Matrix) -> Any:
    every = X if X.ndim == 3 else X[None]
    return kernels.entries_known((every == 0).all(axis=0), (every == 1).all(axis=0))


def _stack(X: Matrix) -> Matrix:
    return flat(kernels.plain_array(X if X.ndim == 3 else X[None]))
