"""Many simulated runs of one observer: the error's statistics, with their errors."""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy  # its parts load when first used
from numpy.typing import ArrayLike

from ..analysis.disturbance import EXACT_TOL, NO_INPUT, disturbed
from ..arguments import expect
from ..certificate import certify, require_match, require_real
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..observer import Observer
from ..plant import Plant
from .claims import Claim, claim
from .executor import Progress, in_order, reporting
from .monte_carlo_blocks import BLOCK, Batch, Sums, join, sums_of, total
from .simulate import noise_roots

TASKS = 64  # parts that an executor is given, unless the caller says how many runs


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
        bounds = (
            2
            * scipy.special.gammaincinv(np.where(shape > 0, shape, 1), tails)
            / self.runs
        )
        return np.where(shape > 0, bounds, 0.0)


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

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    >>> found = lb.monte_carlo(plant, lb.kalman_filter(plant, steps=3), runs=200,
    ...                        steps=3, seed=8)
    >>> found.covariance.shape, found.nees.round(1), found.runs
    ((4, 1, 1), array([0.9, 1.1, 1. , 0.9]), 200)
    """
    expect(plant=plant, observer=observer)
    _require_runs(plant, observer, runs=runs, steps=steps, chunk=chunk, seed=seed)
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


def _require_runs(plant: Plant, observer: Observer, **counts: int | None) -> None:
    require_match(observer, plant)
    require_real("simulation", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None or plant.P0 is None:
        raise DesignError(
            "a Monte Carlo run needs dt > 0 and the covariances Q, R, P0; "
            f"{FIT if plant.dt else SAMPLE}"
        )
    for name, value in counts.items():
        if name == "chunk" and value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise ValueError(f"{name} must be a whole number, got {value!r}")
        least = 0 if name == "seed" else 1
        if value < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")


def _claim(
    plant: Plant, observer: Observer, steps: int, claimed: ArrayLike | None
) -> Claim | None:
    """The claim that is tested; None where there is none to be had."""
    q = len(observer.L)
    if claimed is not None:
        X = covariance("claimed", claimed, q, steps=True)
        if X.ndim == 3 and len(X) != steps + 1:
            raise ValueError(
                f"claimed must be ({q}, {q}) or ({steps + 1}, {q}, {q}), got {X.shape}"
            )
        X = np.broadcast_to(X, (steps + 1, q, q))
        return claim(observer, plant, steps, X)
    certificate = certify(observer, plant)
    if plant.m and max(certificate.input, certificate.feedthrough) > EXACT_TOL:
        return None
    return claim(observer, plant, steps)


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
    return Ensemble(
        mean,
        _standard_error(variance, runs),
        second,
        _standard_error(squares / runs - second**2, runs),
        nees,
        spread,
        dof,
        runs,
    )


def _standard_error(variance: Matrix, runs: int) -> Matrix:
    """Of a mean over runs; a single run does not say how far it may be off."""
    if runs == 1:
        return np.full_like(variance, np.inf)
    return np.sqrt(np.maximum(variance, 0) / (runs - 1))
