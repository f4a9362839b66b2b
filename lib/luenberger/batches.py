"""Runs in blocks: the sums of one block, and of blocks, in a fixed order.

Floating-point sums depend on their order.  Here it is fixed by the numbers of the
runs alone: blocks of 64, joined two by two as in a binary tree over the numbers of
the blocks.  Who computed which block, and how many at a time, leaves no trace.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from .kernels import entries_known, over_record
from .linalg import SINGULAR_TOL
from .observer import Observer
from .plant import Plant
from .recorded import start
from .simulate import draw, follow, over, times, trajectory

BLOCK = 64  # runs; part of what defines the result's last bits
RULED_OUT = 1e-9  # an error beyond this, relative to w, is more than rounding


class Claim(NamedTuple):
    """An error covariance X, ready for e' X^+ e = |root e|^2.

    With a leading time axis if X has one.
    """

    root: np.ndarray  # (., q, q), rows of zeros for directions without variance
    null: np.ndarray | None  # (., q, q) rows N with N e = 0, None if there are none
    rank: np.ndarray  # () or (steps + 1,)


@dataclass(frozen=True, eq=False)
class Batch:
    """What every block of a Monte Carlo run has in common."""

    plant: Plant
    observer: Observer
    steps: int
    seed: int
    runs: int
    claim: Claim | None
    roots: tuple  # of the noise, found once: LAPACK too depends on threads
    compile: bool = False

    def estimates(self, block):
        """w^ and w (steps + 1, q, runs) of the runs of a block."""
        plant, L = self.plant, self.observer.L
        runs = range(block * BLOCK, min((block + 1) * BLOCK, self.runs))
        seeds = [np.random.SeedSequence(self.seed, spawn_key=(run,)) for run in runs]
        w_hat, w = (self.compiled if self.compile else self.plain)(seeds)
        if self.observer.steps is not None:  # row 0: known before the first sample
            known = np.broadcast_to((L @ plant.x0)[:, None], (1, *w_hat.shape[1:]))
            w_hat = np.concatenate([known, w_hat])
        return w_hat, w

    def plain(self, seeds):
        """w^ at the observer's rows and w at all, from all runs at once."""
        observer = self.observer
        x, y, u = trajectory(
            self.plant, observer, self.steps, seeds=seeds, roots=self.roots
        )
        _, w_hat = follow(observer, y, u, start(observer))
        return w_hat, times(observer.L, x)

    def compiled(self, seeds):
        """The same run by run, from `kernels.passes.side_by_side_recursion`."""
        plant, observer, (H0, H) = self.plant, self.observer, self.roots
        first, rows = int(observer.steps is not None), self.steps + 1
        (A0, *_), H1 = plant.at(0), H if H.ndim == 2 else H[0]
        x0, z0 = np.empty(plant.n), start(observer)
        xi = np.empty((rows, H.shape[-1]))
        w_hat = np.empty((len(seeds), rows - first, len(observer.L)))
        w = np.empty((len(seeds), rows, len(observer.L)))
        for run, seed in enumerate(seeds):
            draw(seed, x0, xi)
            x = plant.x0 + H0 @ x0
            if first:
                w[run, 0] = observer.L @ x
                if plant.P0_is == "posterior":
                    x = A0 @ x + H1[: plant.n] @ xi[0]
            self.loop(
                x=x, z=z0.copy(), xi=xi[first:], w_hats=w_hat[run], ws=w[run, first:]
            )
        return w_hat.transpose(1, 2, 0), w.transpose(1, 2, 0)

    @cached_property
    def loop(self):
        """The compiled loop over the rows of one run; see `kernels.over_record`."""
        plant, observer, H = self.plant, self.observer, self.roots[1]
        n, first = plant.n, int(observer.steps is not None)
        rows = self.steps + 1 - first
        given = dict(A=plant.A, C=plant.C, Hw=H[..., :n, :], Hv=H[..., n:, :])
        stacks = {k: _stack(X, self.steps + 1, first) for k, X in given.items()}
        stacks |= {k: _stack(getattr(observer, k), rows) for k in ("F", "D", "P", "V")}
        stacks["L"] = observer.L[None]
        changing = frozenset(k for k, X in stacks.items() if len(X) > 1)
        known = tuple(
            (k, entries_known((X == 0).all(axis=0), (X == 1).all(axis=0)))
            for k, X in stacks.items()
        )
        sizes = dict(d=H.shape[-1], n=n, p=plant.p, q=len(observer.L), r=observer.order)
        step = over_record(
            "side_by_side_recursion", tuple(sizes.items()), known, changing
        )
        flat = {
            k: np.array(X.reshape(len(X), X.shape[1] * X.shape[2]), order="C")
            for k, X in stacks.items()
        }
        index, good = np.arange(rows), np.ones(rows, dtype=bool)
        return partial(
            step,
            **flat,
            start=0,
            stop=rows,
            now=index,
            before=index,
            good=good,
            keep=False,
        )


def _stack(X, rows, first=0):
    """The matrices of the instants from `first` on; one, if it does not change."""
    return X[None] if X.ndim == 2 else over(X, rows)[first:]


def whiten(X):
    """The claim that the error covariance is X; rank decided at unit diagonal."""
    diagonal = np.diagonal(X, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(X * scale[..., :, None] * scale[..., None, :])
    keep = values > SINGULAR_TOL * X.shape[-1]
    rows = vectors.mT * scale[..., None, :]
    root = np.where(keep, 1 / np.sqrt(np.where(keep, values, 1.0)), 0.0)
    null = None if keep.all() else rows * ~keep[..., None]
    return Claim(root[..., None] * rows, null, keep.sum(axis=-1))


def sums_of(job):
    """Nodes of the tree over the blocks of one task; see `join`."""
    batch, blocks = job
    nodes = []
    for block in blocks:
        nodes = join([*nodes, (block, 0, _sums(batch, block))])
    return nodes


def _sums(batch, block):
    """Over the runs of a block: of e, e e', its entries squared, NEES and NEES^2."""
    w_hat, w = batch.estimates(block)
    e = np.subtract(w_hat, w, order="C")
    squares = e * e
    sums = e.sum(axis=-1), times(e, e.mT), times(squares, squares.mT)
    if batch.claim is None:
        return sums
    root, null, _ = batch.claim
    nees = (times(root, e) ** 2).sum(axis=-2)
    if null is not None:
        size = times(np.abs(null), np.abs(w_hat) + np.abs(w))
        beyond = np.abs(times(null, e)) > RULED_OUT * size
        nees = np.where(beyond.any(axis=-2), np.inf, nees)
    return *sums, nees.sum(axis=-1), (nees * nees).sum(axis=-1)


def join(nodes):
    """Add neighbours that are the two halves of a node of the tree.

    A node (start, level, sums) stands for the 2^level blocks from `start` on, a
    multiple of 2^level.  The nodes come from left to right.
    """
    joined = []
    for begin, level, sums in nodes:
        while (
            joined and joined[-1][1] == level and joined[-1][0] % 2 ** (level + 1) == 0
        ):
            begin, _, left = joined.pop()
            sums, level = _add(left, sums), level + 1
        joined.append((begin, level, sums))
    return joined


def total(nodes):
    """The sum over all blocks, from nodes that cover them."""
    *rest, (_, _, sums) = join(nodes)
    for _, _, left in reversed(rest):
        sums = _add(left, sums)
    return sums


def _add(left, right):
    return tuple(a + b for a, b in zip(left, right))
