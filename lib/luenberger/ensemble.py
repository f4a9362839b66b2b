"""Many simulated runs of one observer: the error's statistics, with their errors."""

from dataclasses import dataclass

import numpy as np

from .certificate import require_match, require_real
from .errors import DesignError
from .recorded import start
from .simulate import follow, trajectory

BLOCK = 64  # runs simulated together; fixed, so that results do not depend on workers


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Statistics of e = w^ - L x over runs; rows as in `error_covariance`.

    Attributes
    ----------
    mean : (steps + 1, q) ndarray
        Mean error.
    covariance : (steps + 1, q, q) ndarray
        Mean of e e', to be compared with `error_covariance`.
    standard_error : (steps + 1, q, q) ndarray
        One-sigma sampling error of each entry of `covariance`.
    runs : int
    """

    mean: np.ndarray
    covariance: np.ndarray
    standard_error: np.ndarray
    runs: int


def monte_carlo(plant, observer, *, runs, steps, seed, executor=None):
    """Simulate many runs and gather the statistics of the estimation error.

    Each run has a random stream that depends on `seed` and its number only, and
    sums are formed in fixed blocks, so the result is bit for bit the same whatever
    the executor and the number of its workers.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q, R and P0.
    observer : Observer
    runs, steps : int
    seed : int
    executor : concurrent.futures.Executor, optional
        Where blocks of runs are computed; default here.

    Returns
    -------
    Ensemble

    Raises
    ------
    DesignError
        If the plant has no noise or initial covariance to draw from.
    ValueError
        If runs or steps are not positive, or the observer does not fit.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    >>> found = lb.monte_carlo(plant, lb.kalman_filter(plant, steps=3), runs=200,
    ...                        steps=3, seed=8)
    >>> found.covariance.shape, found.runs
    ((4, 1, 1), 200)
    """
    require_match(observer, plant)
    require_real("simulation", plant, observer)
    if plant.dt == 0 or plant.Q is None or plant.R is None or plant.P0 is None:
        raise DesignError("a Monte Carlo run needs dt > 0 and the covariances Q, R, P0")
    for name, value in (("runs", runs), ("steps", steps)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise ValueError(f"{name} must be a whole number, got {value!r}")
        if value < 1:
            raise ValueError(f"{name} must be at least 1, got {value}")
    blocks = [range(a, min(a + BLOCK, runs)) for a in range(0, runs, BLOCK)]
    jobs = ((plant, observer, steps, seed, block) for block in blocks)
    parts = (map if executor is None else executor.map)(_block, jobs)
    total = sums = squares = 0.0
    for one, two, four in parts:  # in order, so rounding is the same every time
        total, sums, squares = total + one, sums + two, squares + four
    covariance = sums / runs
    spread = np.maximum(squares / runs - covariance**2, 0)
    return Ensemble(total / runs, covariance, np.sqrt(spread / max(runs - 1, 1)), runs)


def _block(job):
    """Sums over one block of e, e e' and its entries squared."""
    plant, observer, steps, seed, block = job
    seeds = [np.random.SeedSequence(seed, spawn_key=(run,)) for run in block]
    x, y, u = trajectory(plant, observer, steps, seeds=seeds)
    _, w_hat = follow(observer, y, u, start(observer))
    if observer.steps is not None:  # row 0 is what is known before the first sample
        known = np.broadcast_to(observer.L @ plant.x0, w_hat[:, :1].shape)
        w_hat = np.concatenate([known, w_hat], axis=1)
    e = w_hat - x @ observer.L.T
    products = e[..., :, None] * e[..., None, :]
    return e.sum(axis=0), products.sum(axis=0), (products**2).sum(axis=0)
