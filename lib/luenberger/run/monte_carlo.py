"""Many simulated runs of one observer: the error's statistics, with their errors.

Floating-point sums depend on their order.  Here it is fixed by the numbers of the
runs alone: blocks of 64, joined two by two as in a binary tree over the numbers of
the blocks.  Who computed which block, and how many at a time, leaves no trace, nor
does the number of threads that BLAS has there (see `simulate.times`).
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy  # its parts load when first used
from numpy.typing import ArrayLike

from ..analysis.disturbance import EXACT_TOL, NO_INPUT, disturbed
from ..analysis.error_system import error_system
from ..arguments import expect
from ..at_work import start
from ..certificate import certify, require_match, require_real
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..observer import Observer
from ..plant import Plant
from .executor import Progress, in_order, reporting
from .simulate import follow, noise_roots, times, trajectory

TASKS = 64  # parts that an executor is given, unless the caller says how many runs
BLOCK = 64  # runs; part of what defines the result's last bits
ROWS = 128  # taken together when sums are formed, so that they stay in the cache
FEW = 6  # outputs; the dot products of so few are faster one by one than as a matrix
SMALL = 1e-6  # of the numbers that meet in an error: the least unit of its deviation
TOL = 1e-12  # a variance in these units that counts as none: errors below are rounding
RULED_OUT = 8  # times as large as that: more than rounding
Sums = tuple[np.ndarray, ...]  # over runs, of what `_sums` says
Node = tuple[int, int, Sums]  # of the tree over blocks; see `join`


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Statistics of e = w^ - L x over runs; rows as in `error_covariance`.

    A standard error is the one-sigma sampling error of the figure it belongs to; it
    falls as one over the square root of the number of runs.

    Attributes
    ----------
    mean, mean_standard_error : (steps + 1, q) ndarray
        Mean error; about zero if the observer starts without bias.
    covariance, standard_error : (steps + 1, q, q) ndarray
        Mean of e e', to be compared with `error_covariance`.
    nees, nees_standard_error : (steps + 1,) ndarray or None
        Mean of the normalised estimation error squared, e' X^+ e, X the covariance
        that is claimed: about `dof` if the claim is right, more if it promises too
        much, less if too little.  inf where an error occurred that X rules out.
    dof : (steps + 1,) ndarray of int, or None
        Rank of X.  A standard deviation below 1e-12 of the numbers that meet in an
        error is rounding, and counts as zero.
    runs : int
    note : str
        Says so where the known input disturbs the estimate, which is zero in all runs;
        else empty.
    """

    mean: np.ndarray
    mean_standard_error: np.ndarray
    covariance: np.ndarray
    standard_error: np.ndarray
    nees: np.ndarray | None
    nees_standard_error: np.ndarray | None
    dof: np.ndarray | None
    runs: int
    note: str = ""

    def nees_bounds(self, confidence: float = 0.95) -> Matrix:
        """Bounds (2, steps + 1) of `nees`, for Gaussian errors and a right claim.

        ``runs * nees`` then has a chi-square distribution of ``runs * dof`` degrees
        of freedom at each instant, provided that e is Gaussian with mean zero: no
        multiplicative noise, no bias.  Of many instants a part ``1 - confidence``
        lies outside, neighbours together.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
        >>> found = lb.monte_carlo(plant, lb.kalman_filter(plant, steps=1), runs=50,
        ...                        steps=1, seed=8)
        >>> found.nees_bounds()[:, 0].round(3)  # of the mean of 50, Bar-Shalom et al.
        array([0.647, 1.428])
        """
        if not 0 < confidence < 1:
            raise ValueError(f"confidence must be between 0 and 1, got {confidence!r}")
        if self.dof is None:
            raise DesignError(
                "there is no claim to test: the error covariance depends on the known "
                "input; give monte_carlo a covariance as claimed"
            )
        tails = np.array([[1 - confidence], [1 + confidence]]) / 2
        shape = 0.5 * self.runs * self.dof
        half = scipy.special.gammaincinv(np.where(shape > 0, shape, 1), tails)
        return np.where(shape > 0, 2 * half / self.runs, 0.0)


def monte_carlo(
    plant: Plant,
    observer: Observer,
    *,
    runs: int,
    steps: int,
    seed: int,
    claimed: ArrayLike | None = None,
    executor: Executor | None = None,
    chunk: int | None = None,
    progress: Progress = False,
) -> Ensemble:
    """Simulate many runs and gather the statistics of the estimation error.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    >>> found = lb.monte_carlo(plant, lb.kalman_filter(plant, steps=3), runs=200,
    ...                        steps=3, seed=8)
    >>> found.covariance.shape, found.nees.round(1), found.runs
    ((4, 1, 1), array([0.9, 1.1, 1. , 0.9]), 200)

    Each run has a random stream that depends on `seed` and its number only, runs are
    computed in fixed blocks, and the sums of blocks are joined in a fixed tree.  So
    the result is bit for bit the same whatever the executor, the number of its
    workers, and the runs that one task takes, on machines of one kind.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q, R and P0; what the runs obey.  The known input is zero, and
        `note` of the result says so where that matters; `simulate` takes u.
    observer : Observer
        Designed for this plant or, to see what a wrong model costs, another one.
    runs, steps : int
    seed : int
    claimed : (q, q) or (steps + 1, q, q) array_like, optional
        The error covariance that is to be tested; default
        ``error_covariance(observer, plant, steps=steps)``, the true one.  To test a
        wrong model: the same of that model.
    executor : concurrent.futures.Executor, optional
        Where runs are computed: a pool of threads or processes, or that of a Dask
        cluster, ``client.get_executor()``.  Default here.
    chunk : int, optional
        Runs that one task of the executor takes, rounded up to blocks of 64.
    progress : bool or callable, default False
        True shows a bar (needs tqdm); a function is called with (runs done, runs).

    Returns
    -------
    Ensemble

    Raises
    ------
    DesignError
        If the plant has no noise or initial covariance to draw from.
    ValueError
        If a number is not what it should be, or observer or `claimed` do not fit.
    BrokenExecutor
        If a worker died and its pool does not replace it.  Nothing is returned then.
    ImportError
        If a bar is asked for and tqdm is not installed.

    References
    ----------
    Bar-Shalom, Li, Kirubarajan (2001), Estimation with Applications to Tracking and
    Navigation, section 5.4, on the normalised estimation error squared.
    """
    expect(plant=plant, observer=observer)
    require_match(observer, plant)
    require_real("simulation", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None or plant.P0 is None:
        raise DesignError(
            "a Monte Carlo run needs dt > 0 and the covariances Q, R, P0; "
            f"{FIT if plant.dt else SAMPLE}"
        )
    counts = dict(runs=runs, steps=steps, seed=seed)
    for name, value in (counts if chunk is None else counts | {"chunk": chunk}).items():
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise ValueError(f"{name} must be a whole number, got {value!r}")
        if value < (least := 0 if name == "seed" else 1):
            raise ValueError(f"{name} must be at least {least}, got {value}")
    tested = _claim(plant, observer, steps, claimed)
    roots = noise_roots(plant, steps)
    batch = Batch(plant, observer, steps, seed, runs, tested, roots)
    blocks = -(-runs // BLOCK)
    size = -(-blocks // TASKS) if chunk is None else -(-chunk // BLOCK)
    jobs = [(batch, range(a, min(a + size, blocks))) for a in range(0, blocks, size)]
    nodes: list[Any] = []
    parts = in_order(sums_of, jobs, executor)
    with reporting(progress, runs, "run") as report, closing(parts):
        for (_, some), part in zip(jobs, parts):
            nodes = join([*nodes, *part])
            report(min(some.stop * BLOCK, runs))
    found = _ensemble(total(nodes), runs, tested)
    if plant.m and disturbed(observer, plant, certify(observer, plant)):
        return replace(found, note=NO_INPUT)
    return found


class Claim(NamedTuple):
    """An error covariance X at each instant, ready for e' X^+ e = |root e|^2."""

    root: np.ndarray  # (steps + 1, q, q), rows of zeros for directions without variance
    null: np.ndarray | None  # the same with rows N, |N e| <= 1 if e is rounding
    rank: np.ndarray  # (steps + 1,)


def _claim(
    plant: Plant, observer: Observer, steps: int, claimed: ArrayLike | None
) -> Claim | None:
    """The claim that is tested, the true one by default; None where there is none.

    Each error is counted in its claimed deviation, or in `SMALL` of the deviation of
    its part of the state about zero, if that is more.  A combination of errors whose
    variance is then at most `TOL` is claimed to be rounding.
    """
    q, X = len(observer.L), None
    if claimed is not None:
        X = covariance("claimed", claimed, q, steps=True)
        if X.ndim == 3 and len(X) != steps + 1:
            raise ValueError(
                f"claimed must be ({q}, {q}) or ({steps + 1}, {q}, {q}), got {X.shape}"
            )
        X = np.broadcast_to(X, (steps + 1, q, q))
    elif plant.m:
        certificate = certify(observer, plant)
        if max(certificate.input, certificate.feedthrough) > EXACT_TOL:
            return None
    system = error_system(observer, plant, steps)
    X = system.over(steps) if X is None else X
    states = np.array([np.sqrt(M.diagonal()) for M in system.of_state(steps)])
    size = states[:, : plant.n] @ np.abs(observer.L).T
    deviations = np.sqrt(np.maximum(np.diagonal(X, axis1=1, axis2=2), 0))
    unit = np.maximum(deviations, SMALL * size)
    unit[unit == 0] = 1.0
    values, axes = np.linalg.eigh(X / unit[:, :, None] / unit[:, None])
    kept = values > TOL
    rows = axes.mT / unit[:, None] / np.sqrt(np.maximum(values, TOL))[..., None]
    null = np.where(kept[..., None], 0.0, rows)
    return Claim(rows - null, null if null.any() else None, kept.sum(axis=1))


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
    errors, claim, parts = batch.errors(block), batch.claim, []
    for a in range(0, len(errors), ROWS):
        here = slice(a, a + ROWS)
        e = np.ascontiguousarray(errors[here])
        squares = e * e
        sums = [e.sum(axis=-1), _products(e), _products(squares)]
        if claim is not None:
            root, null = claim.root[here], claim.null
            white = times(root, e, out=squares)  # in their place, which is in the cache
            nees = np.einsum("rij,rij->rj", white, white)
            if null is not None:
                beyond = np.abs(times(null[here], e)) > RULED_OUT
                nees = np.where(beyond.any(axis=-2), np.inf, nees)
            sums += [nees.sum(axis=-1), np.vecdot(nees, nees)]
        parts.append(sums)
    return tuple(map(np.concatenate, zip(*parts)))


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


def _ensemble(sums: Sums, runs: int, tested: Claim | None) -> Ensemble:
    e, products, squares, *normalised = sums
    mean, second = e / runs, products / runs
    variance = np.diagonal(second, axis1=-2, axis2=-1) - mean**2
    nees = spread = dof = None
    if tested is not None:
        nees, of_squares = (one / runs for one in normalised)
        ruled_out = np.isinf(nees)
        finite = np.where(ruled_out, 0.0, nees)
        spread = _standard_error(np.where(ruled_out, 0.0, of_squares) - finite**2, runs)
        spread = np.where(ruled_out, np.inf, spread)
        dof = tested.rank
    of_mean = _standard_error(variance, runs)
    of_second = _standard_error(squares / runs - second**2, runs)
    return Ensemble(mean, of_mean, second, of_second, nees, spread, dof, runs)


def _standard_error(variance: Matrix, runs: int) -> Matrix:
    """Of a mean over runs; a single run does not say how far it may be off."""
    if runs == 1:
        return np.full_like(variance, np.inf)
    return np.sqrt(np.maximum(variance, 0) / (runs - 1))
