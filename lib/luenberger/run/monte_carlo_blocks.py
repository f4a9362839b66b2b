"""Runs in blocks: the sums of one block, and of blocks, in a fixed order.

Floating-point sums depend on their order.  Here it is fixed by the numbers of the
runs alone: blocks of 64, joined two by two as in a binary tree over the numbers of
the blocks.  Who computed which block, and how many at a time, leaves no trace, nor
does the number of threads that BLAS has there (see `simulate.times`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.random import Generator, SeedSequence

from ..at_work import start
from ..kernels import Recursion
from ..numeric import Matrix
from ..observer import Observer
from ..papers.leondes_novak.derivation import side_by_side_step
from ..plant import Plant
from .claims import RULED_OUT, Claim
from .observer_pass import over_stacks
from .simulate import draw, follow, over, times, trajectory

BLOCK = 64  # runs; part of what defines the result's last bits
ROWS = 128  # taken together when sums are formed, so that they stay in the cache
FEW = 6  # outputs; the dot products of so few are faster one by one than as a matrix
SIDE_BY_SIDE = Recursion(
    side_by_side_step,
    carried=(("x_next", "x"), ("z_next", "z")),
    rows=(("xi", "xi", 0),),
    written=(("es", "e", "vector"),),
)


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
    compile: bool = False

    def errors(self, block: int) -> Matrix:
        """e (steps + 1, q, runs) of the runs of a block."""
        runs = range(block * BLOCK, min((block + 1) * BLOCK, self.runs))
        seeds = [np.random.SeedSequence(self.seed, spawn_key=(run,)) for run in runs]
        return (self.compiled if self.compile else self.plain)(seeds)

    def plain(self, seeds: Sequence[SeedSequence]) -> Matrix:
        """From all runs at once, instant by instant."""
        plant, observer = self.plant, self.observer
        x, y, u = trajectory(plant, observer, self.steps, seeds=seeds, roots=self.roots)
        _, w_hat = follow(observer, y, u, start(observer))
        w = times(observer.L, x)
        if observer.steps is not None:  # row 0: known before the first sample
            known = np.broadcast_to((observer.L @ plant.x0)[:, None], w[:1].shape)
            w_hat = np.concatenate([known, w_hat])
        return w_hat - w

    def compiled(self, seeds: Sequence[SeedSequence]) -> Matrix:
        """Run by run, plant and observer in one loop."""
        first, rows = int(self.observer.steps is not None), self.steps + 1
        streams = [np.random.default_rng(seed) for seed in seeds]
        z0, xi = start(self.observer), np.empty((rows - first, self.roots[1].shape[-1]))
        e = np.empty((len(seeds), rows, len(self.observer.L)))
        x = self.begin(streams, e)
        for run, stream in enumerate(streams):
            draw(stream, xi)  # one at a time: it is read while it is in the cache
            self.loop(x=x[run], z=z0.copy(), xi=xi, es=e[run, first:])
        return e.transpose(1, 2, 0)

    def begin(self, streams: Sequence[Generator], e: Matrix) -> Matrix:
        """The states (runs, n) at the observer's first row; fills the row before."""
        plant, observer, (H0, H) = self.plant, self.observer, self.roots
        deviation = times(H0, drawn(streams, plant.n))
        x = plant.x0[:, None] + deviation
        if observer.steps is not None:
            e[:, 0] = times(observer.L, -deviation)[..., 0]
            noise = drawn(streams, H.shape[-1])  # of instant 0, even if it is not used
            if not plant.at_first:
                H1 = (H if H.ndim == 2 else H[0])[: plant.n]
                x = times(plant.at(0).A, x) + times(H1, noise)
        return x[..., 0]

    @cached_property
    def loop(self) -> partial:
        """The compiled loop over the rows of one run; see `kernels.over_record`."""
        plant, observer, H = self.plant, self.observer, self.roots[1]
        n, first = plant.n, int(observer.steps is not None)
        rows = self.steps + 1 - first
        given = dict(A=plant.A, C=plant.C, Hw=H[..., :n, :], Hv=H[..., n:, :])
        stacks = {k: _stack(X, self.steps + 1, first) for k, X in given.items()}
        stacks |= {k: _stack(getattr(observer, k), rows) for k in ("F", "D", "P", "V")}
        stacks["L"] = observer.L[None]
        sizes = dict(d=H.shape[-1], n=n, p=plant.p, q=len(observer.L), r=observer.order)
        return partial(over_stacks(SIDE_BY_SIDE, sizes, stacks), stop=rows)


def drawn(streams: Sequence[Generator], size: int) -> Matrix:
    """The next numbers of each stream, a column for each (runs, size, 1)."""
    numbers = np.empty((len(streams), size, 1))
    for stream, one in zip(streams, numbers):
        draw(stream, one)
    return numbers


def _stack(X: Matrix, rows: int, first: int = 0) -> Matrix:
    """The matrices of the instants from `first` on; one, if it does not change."""
    return X[None] if X.ndim == 2 else over(X, rows)[first:]


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
