"""The smoother's way back in compiled code."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrices, Matrix
from ..numeric.factors import SAFE
from ..recursion.state import flat
from .carried import LEFT, MOST, Back, Carried, Ways
from .derivation import backward_loop
from .forward import Kept

BACKWARD = kernels.Recursion(
    backward_loop,
    carried=(
        ("lamda", "lamda_next"),
        ("Theta", "Theta_next"),
    ),
    rows=(
        ("innovation", "innovations", 0),
        ("x", "xs", 0),
        ("K_next", "K", 1),
        ("W_next", "W", 1),
    ),
    written=(
        ("smoothed", "x_s", "vector"),
        ("variances", "Sigma_s", "diagonal"),
        ("covariances", "Sigma_s", "matrix"),
        ("sayings", "lamda", "vector"),
    ),
    symmetric=("Sigma", "Theta_next", "W", "W_next"),
    definite=(Factor("Sigma_s", SAFE, "Sigma", known=True),),
    bounds=(
        ("Sigma_s", "Sigma", "above", LEFT),
        ("Theta", "Sigma", "product", MOST),
    ),
    replaces=(("covariances", "Sigma"),),
    backward=True,
)
NEIGHBOURS = replace(  # takes half as long again
    BACKWARD,
    carried=(*BACKWARD.carried, ("Ahead", "Ahead_next")),
    written=(*BACKWARD.written, ("neighbours", "U_next", "matrix")),
)


class Compiled:
    """The pass in compiled code, which gives up where digits would be lost.

    It writes to the covariances of `kept`, row by row.
    """

    def __init__(self, kept: Kept, ways: Ways, out: Back, variances: Matrix) -> None:
        self.kept, self.out, n = kept, out, kept.x.shape[1]
        moves = leading(ways)
        stacked = {"Sigma", "K", "W"} | {k for k, X in moves.items() if X.ndim == 3}
        sizes = (("n", n), ("p", kept.K.shape[2]))
        known = entries(moves)
        recursion = BACKWARD if out.U is None else NEIGHBOURS
        self.kernel = kernels.over_record(recursion, sizes, known, frozenset(stacked))
        self.given = stacks(moves)
        self.given |= dict(Sigma=flat(kept.Sigma), K=flat(kept.K), W=flat(kept.W))
        self.given |= dict(innovations=kept.innovation, xs=kept.x)
        self.found = dict(
            smoothed=out.x, covariances=flat(out.Sigma), sayings=out.lamda,
            variances=variances,
        )  # fmt: skip
        if out.U is not None:
            self.found["neighbours"] = flat(out.U[1:])

    def run(self, carried: Carried, turn: int) -> tuple[Carried, int]:
        """From what is carried to a row: what is carried on, and the row not done.

        Where a stretch of rows is given up, its rows are done one by one up to the one
        that fails.
        """
        N = len(self.kept)
        while turn < N:
            carried, turn = self._rows(carried, turn, N)
            if turn < N:
                carried, done = self._rows(carried, turn, turn + 1)
                if done == turn:
                    break
                turn = done
        return carried, turn

    def _rows(self, carried: Carried, turn: int, stop: int) -> tuple[Carried, int]:
        """Rows from `turn` to `stop`, counted from the last one down."""
        now = dict(lamda_next=carried.lamda, Theta_next=carried.Theta)
        if self.out.U is not None:
            now["Ahead_next"] = carried.Ahead
        after = {name: X.flatten() for name, X in now.items()}
        done = self.kernel(
            last=len(self.kept) - 1, start=turn, stop=stop, keep=True,
            **self.given, **self.found, **after,
        )  # fmt: skip
        shaped = {name: after[name].reshape(X.shape) for name, X in now.items()}
        return Carried(
            shaped["lamda_next"], shaped["Theta_next"],
            shaped.get("Ahead_next", carried.Ahead), carried.x, None,
        ), done  # fmt: skip


def leading(ways: Ways) -> Matrices:
    """As, C, and C of the next row times As of a row; nothing is behind the last."""
    As, C = ways.As, ways.C
    ahead = C if C.ndim == 2 else np.concatenate([C[1:], 0 * C[:1]])
    return dict(As=As, C=C, Seen=ahead @ As)


def entries(moves: Matrices) -> tuple[tuple[str, Any], ...]:
    """What is known of the entries of each matrix."""
    every = {name: X if X.ndim == 3 else X[None] for name, X in moves.items()}
    zero = {name: (X == 0).all(axis=0) for name, X in every.items()}
    one = {name: (X == 1).all(axis=0) for name, X in every.items()}
    return tuple((name, kernels.entries_known(zero[name], one[name])) for name in moves)


def stacks(moves: Matrices) -> Matrices:
    """As compiled code reads them, a row for each or one for all."""
    every = {name: X if X.ndim == 3 else X[None] for name, X in moves.items()}
    return {name: flat(kernels.plain_array(X)) for name, X in every.items()}
