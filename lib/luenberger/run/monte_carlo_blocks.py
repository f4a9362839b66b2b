"""Runs in blocks: the sums of one block, and of blocks, in a fixed order.

Floating-point sums depend on their order.  Here it is fixed by the numbers of the
runs alone: blocks of 64, joined two by two as in a binary tree over the numbers of
the blocks.  Who computed which block, and how many at a time, leaves no trace, nor
does the number of threads that BLAS has there (see `simulate.times`).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..at_work import start
from ..numeric import Matrix
from ..observer import Observer
from ..plant import Plant
from .claims import RULED_OUT, Claim
from .simulate import follow, times, trajectory

BLOCK = 64  # runs; part of what defines the result's last bits
ROWS = 128  # taken together when sums are formed, so that they stay in the cache
FEW = 6  # outputs; the dot products of so few are faster one by one than as a matrix


Sums = tuple[np.ndarray, ...]  # over runs, of what `_sums` says
Node = tuple[int, int, Sums]  # of the tree over blocks; see `join`


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

    def errors(self, block: int) -> Matrix:
        """e (steps + 1, q, runs) of the runs of a block."""
        runs = range(block * BLOCK, min((block + 1) * BLOCK, self.runs))
        seeds = [np.random.SeedSequence(self.seed, spawn_key=(run,)) for run in runs]
        plant, observer = self.plant, self.observer
        x, y, u = trajectory(plant, observer, self.steps, seeds=seeds, roots=self.roots)
        _, w_hat = follow(observer, y, u, start(observer))
        w = times(observer.L, x)
        if observer.steps is not None:  # row 0: known before the first sample
            known = np.broadcast_to((observer.L @ plant.x0)[:, None], w[:1].shape)
            w_hat = np.concatenate([known, w_hat])
        return w_hat - w


def sums_of(job: tuple[Batch, range]) -> list[Node]:
    """Nodes of the tree over the blocks of one task; see `join`."""
    batch, blocks = job
    nodes: list[Node] = []
    for block in blocks:
        nodes = join([*nodes, (block, 0, _sums(batch, block))])
    return nodes


def _sums(batch: Batch, block: int) -> Sums:
    """Over the runs of a block: of e, e e', its entries squared, NEES and NEES^2."""
    e = batch.errors(block)
    parts = []
    for a in range(0, len(e), ROWS):
        here = slice(a, a + ROWS)
        parts.append(_sums_of_rows(batch.claim, e[here], here))
    return tuple(map(np.concatenate, zip(*parts)))


def _sums_of_rows(claim: Claim | None, e: Matrix, here: slice) -> Sums:
    e = np.ascontiguousarray(e)
    squares = e * e
    sums = e.sum(axis=-1), _products(e), _products(squares)
    if claim is None:
        return sums
    root, null = (None if X is None else X[here] for X in (claim.root, claim.null))
    white = times(root, e, out=squares)  # in their place, which is in the cache
    nees = np.einsum("rij,rij->rj", white, white)
    if null is not None:
        beyond = np.abs(times(null, e)) > RULED_OUT
        nees = np.where(beyond.any(axis=-2), np.inf, nees)
    return *sums, nees.sum(axis=-1), np.vecdot(nees, nees)


def _products(e: Matrix) -> Matrix:
    """Over the runs, the sum of e e' at each instant."""
    if e.shape[-2] <= FEW:
        return np.vecdot(e[:, :, None], e[:, None])
    return times(e, e.mT)


def join(nodes: Iterable[Node]) -> list[Node]:
    """Add neighbours that are the two halves of a node of the tree.

    A node (start, level, sums) stands for the 2^level blocks from `start` on, a
    multiple of 2^level.  The nodes come from left to right.
    """
    joined: list[Node] = []
    for begin, level, sums in nodes:
        while joined and joined[-1][1] == level and begin >> level & 1:
            begin, _, left = joined.pop()
            sums, level = _add(left, sums), level + 1
        joined.append((begin, level, sums))
    return joined


def total(nodes: Iterable[Node]) -> Sums:
    """The sum over all blocks, from nodes that cover them."""
    *rest, (_, _, sums) = join(nodes)
    for _, _, left in reversed(rest):
        sums = _add(left, sums)
    return sums


def _add(left: Sums, right: Sums) -> Sums:
    return tuple(a + b for a, b in zip(left, right))
