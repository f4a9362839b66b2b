"""Rows of a record, and what they tell of the directions in which a plant moves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..stage_list import StageList
from .carried_rows import ENOUGH, Each, compiled_back, compiled_each
from .derivation import (
    changed_on,
    correlations,
    driven,
    mean_step,
    shown_by_row,
    told_back,
    weighed_mean,
    weighed_motion,
    weighed_noise,
)
from .ways import Ways

TOGETHER = 8192  # changes of rows that are kept at once, of all directions


class Carried(NamedTuple):
    """What a row passes on to the next, for each direction.

    ``dOmega`` (q, n, n) is the change of the prediction's covariance, X (1, n, n) the
    covariance of the prediction and ``X_i`` (q, n, n) that of its change with it;
    ``mean`` (1, n, 1) and ``dm`` (q, n, 1) are the means of both.
    """

    dOmega: np.ndarray
    X: np.ndarray
    X_i: np.ndarray
    mean: np.ndarray
    dm: np.ndarray

    @classmethod
    def start(cls, mean: Matrix, dm: Matrix, dOmega: Matrix) -> Carried:
        """From a prediction (n, 1) that is known; how it and its covariance move."""
        n = len(mean)
        return cls(dOmega, np.zeros((1, n, n)), np.zeros_like(dOmega), mean[None], dm)


@dataclass(frozen=True, eq=False)
class Stretch:
    """Rows, one after the other, with all that the recursions need of them.

    Attributes
    ----------
    given : dict of str to ndarray
        "A", "B", "C", "E", "S", "Omega", "G", "W": (rows or 1, 1, ., .).
    changes : dict of str to ndarray
        "dA", ...: (rows or 1, q, ., .).
    rows : int
    u : (N, 1, m, 1) ndarray
        Inputs, of all rows of the record.
    index : (N,) ndarray of int
        Which row each row of the record is: a row may stand for many.
    """

    given: Matrices
    changes: Matrices
    rows: int
    u: np.ndarray
    index: np.ndarray

    def part(self, here: slice) -> Matrices:
        """Everything of some rows."""
        both = self.given | self.changes
        return {name: X if len(X) == 1 else X[here] for name, X in both.items()}

    def pieces(self) -> Iterator[tuple[slice, Matrices]]:
        """Everything, some rows at a time."""
        size = max(1, TOGETHER // self.changes["dQ"].shape[1])
        for k in range(0, self.rows, size):
            here = slice(k, min(k + size, self.rows))
            yield here, self.part(here)

    def back(self, Pi: Matrix, fast: bool) -> tuple[Matrix, Matrix]:
        """What the rows after each row tell, (rows, n, n), and all rows together.

        With `fast`, in compiled code if there are enough of them.
        """
        if fast and self.rows >= ENOUGH:
            return compiled_back(self.given, self.rows, Pi)
        step, found = kernels.compiled(told_back), np.empty((self.rows, *Pi.shape))
        stacks = [self.given[name][:, 0] for name in "ACGW"]
        for k in reversed(range(self.rows)):
            found[k] = Pi
            A, C, G, W = (X[k if len(X) > 1 else 0] for X in stacks)
            Pi = step(A=A, C=C, G=G, W=W, Pi_next=Pi)["Pi"]
        return found, Pi

    def forward(
        self, Pi_next: Matrix, now: Carried, ways: Ways, fast: bool
    ) -> tuple[Matrix, Carried]:
        """The information of the rows, and what the last one passes on.

        Parameters
        ----------
        Pi_next : (rows, n, n) ndarray
            What the rows after each row tell.
        now : Carried
            Before the first.
        ways : Ways
        fast : bool
            Whether to use compiled code.
        """
        weight = np.bincount(self.index, minlength=self.rows).astype(float)
        total, kept = np.zeros((ways.count, ways.count)), list[Matrices]()
        for here, have in self.pieces():
            at = Pi_next[here, None]
            one = _each if not fast or len(weight[here]) < ENOUGH else compiled_each
            found, have, now = _shown(have, at, weight[here], now, ways.moving, one)
            total += found
            kept.append({name: have[name] for name in "FH"} if ways.shifting else {})
        if ways.shifting and (now.mean.any() or now.dm.any() or self.u.any()):
            whole = {name: np.concatenate([one[name] for one in kept]) for name in "FH"}
            found, now = self.means(whole, now)
            total += found
        return 0.5 * (total + total.T), now

    def means(self, whole: Matrices, now: Carried) -> tuple[Matrix, Carried]:
        """The information of all rows of the record in its mean."""
        step, have = kernels.compiled(mean_step, stacks=True), self.part(slice(None))
        have = {name: X for name, X in (have | whole).items() if name in step.given}
        mean, dm, W = now.mean, now.dm, self.given["W"]
        dn = np.empty((len(self.index), len(dm), W.shape[-1], 1))
        for k, row in enumerate(self.index):
            at = {name: X[row if len(X) > 1 else 0] for name, X in have.items()}
            found = step(**at, m_x=mean, dm_x=dm, u=self.u[k])
            mean, dm, dn[k] = found["m_x_next"], found["dm_x_next"], found["dn"]
        W = W if len(W) == 1 else W[self.index]
        B_n = kernels.run(weighed_mean, dict(W=W, dn_i=dn), stacks=True)["B_n"]
        return _inner(B_n, dn, np.ones(len(dn))), now._replace(mean=mean, dm=dm)


def _shown(
    have: Matrices, Pi_next: Matrix, weight: Vector, now: Carried, moving: bool,
    each: Each,
) -> tuple[Matrix, Matrices, Carried]:  # fmt: skip
    """Of some rows: what they tell of the noises, F and H, and what is passed on."""
    have |= kernels.run(driven, have, stacks=True)
    before, after = each(changed_on, have, len(weight), dOmega=now.dOmega)
    now, have = now._replace(**after), have | before
    have |= kernels.run(shown_by_row, have, stacks=True)
    have |= dict(Pi_next=Pi_next, dM_i=have["dM"], T_i=have["T"])
    have |= kernels.run(weighed_noise, have, stacks=True)
    total = _inner(have["B_M"], have["dM"], weight)
    total += _inner(have["B_T"], have["T"], weight)
    if moving:
        have |= dict(H_i=have["H"], dC_i=have["dC"])
        before, after = each(correlations, have, len(weight), X=now.X, X_i=now.X_i)
        now, have = now._replace(**after), have | before
        have |= kernels.run(weighed_motion, have, stacks=True)
        half = _inner(have["B_C"], have["dC"], weight)
        half += _inner(have["B_H"], have["H"], weight)
        total += half + half.T
    return total, have, now


def _inner(B: Matrix, X: Matrix, weight: Vector) -> Matrix:
    """The sum over rows and entries of B of one direction times X of another."""
    rows, q = len(weight), B.shape[1]
    B, X = (
        np.broadcast_to(Y, (rows, *Y.shape[1:])).swapaxes(0, 1).reshape(q, rows, -1)
        for Y in (B, X)
    )
    return (B * weight[:, None]).reshape(q, -1) @ X.reshape(q, -1).T


def _each(
    stages: StageList, have: Matrices, rows: int, **carried: Matrix
) -> tuple[Matrices, Matrices]:
    """What is carried, before each row as stacks, and after the last."""
    step = kernels.compiled(stages, *(f"{name}_next" for name in carried), stacks=True)
    given = {name: have[name] for name in step.given if name not in carried}
    before = {name: np.empty((rows, *X.shape)) for name, X in carried.items()}
    for k in range(rows):
        for name, X in carried.items():
            before[name][k] = X
        at = {name: X[k if len(X) > 1 else 0] for name, X in given.items()}
        found = step(**at, **carried)
        carried = {name: found[f"{name}_next"] for name in carried}
    return before, carried
