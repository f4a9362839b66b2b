"""Monte Carlo beside simdkalman: nanoseconds per series and step, ratios, one run.

The work: draw the noise of a plant, simulate it, run the Kalman filter with its
covariance, and gather the error's mean, covariance, standard errors and NEES.
simdkalman, which filters many series at once, does not simulate; it is given plain
NumPy, vectorised over series too, for the rest.

Two rows are for the kernels alone: simdkalman filters measurements that are there
already, without covariances; ours simulates and filters, from noise drawn already.

Before anything is timed the results are compared.  Contestants take turns, each on one
core, and it is the time of that core which is counted, so that what else the machine
does matters less.

Run:  OMP_NUM_THREADS=1 python benchmarks/monte_carlo.py [--quick]
"""

import sys
from functools import partial

import numpy as np
import simdkalman
from common import in_turns, line, plant, record

import luenberger as lb
from luenberger.run.monte_carlo_blocks import Batch
from luenberger.run.simulate import noise_roots

SIZES = [(3, 2), (6, 3)]
ROUNDS = 5


def filtered(plant, y, covariances):
    """Means (series, steps, n) and covariances, all series at once."""
    model = simdkalman.KalmanFilter(
        state_transition=plant.A,
        process_noise=plant.Q,
        observation_model=plant.C,
        observation_noise=plant.R,
    )
    first = plant.A @ plant.P0 @ plant.A.T + plant.Q
    found = model.compute(
        y,
        0,
        initial_value=np.zeros(plant.n),
        initial_covariance=first,
        filtered=True,
        smoothed=False,
        observations=False,
        covariances=covariances,
    ).filtered.states
    return found.mean, found.cov if covariances else None


def with_simdkalman(plant, runs, steps):
    """The whole of it: mean, covariance, standard errors, NEES."""
    n, p = plant.n, plant.p
    rng = np.random.default_rng(1)
    start, Hw, Hv = (np.linalg.cholesky(X) for X in (plant.P0, plant.Q, plant.R))
    state = rng.standard_normal((runs, n)) @ start.T
    w = rng.standard_normal((runs, steps, n)) @ Hw.T
    v = rng.standard_normal((runs, steps, p)) @ Hv.T
    x = np.empty((runs, steps, n))
    for k in range(steps):
        x[:, k] = state = state @ plant.A.T + w[:, k]
    mean, P = filtered(plant, x @ plant.C.T + v, True)
    e = mean - x
    products = e[..., :, None] * e[..., None, :]
    nees = (e[..., None, :] @ np.linalg.solve(P, e[..., None]))[..., 0, 0]
    spread = products.std(axis=0) / np.sqrt(runs)
    return e.mean(axis=0), products.mean(axis=0), spread, nees.mean(axis=0)


def with_luenberger(plant, runs, steps, backend):
    observer = lb.kalman_filter(plant, steps=steps, backend=backend)
    return lb.monte_carlo(
        plant, observer, runs=runs, steps=steps, seed=1, backend=backend
    )


def kernel(plant, runs, steps):
    """Our compiled loop on noise that is drawn already, for a constant gain."""
    batch = Batch(
        plant, lb.kalman_filter(plant), steps, 1, runs, None, noise_roots(plant, steps)
    )
    xi = np.random.default_rng(1).standard_normal((runs, steps + 1, plant.n + plant.p))
    e, w = np.empty((2, steps + 1, plant.n))

    def run():
        for noise in xi:
            start = dict(x=np.zeros(plant.n), z=np.zeros(plant.n))
            batch.loop(**start, xi=noise, es=e, ws=w)

    return run


def agree(plant):
    """Nothing is timed that does not compute the same."""
    y = np.random.default_rng(1).normal(size=(3, 50, plant.p))
    observer = lb.kalman_filter(plant, steps=50)
    wanted = np.stack([lb.estimate(observer, series) for series in y])
    if (
        np.abs(filtered(plant, y, False)[0] - wanted).max()
        > 1e-8 * np.abs(wanted).max()
    ):
        raise SystemExit("simdkalman computes something else; nothing was timed")
    one, other = (with_luenberger(plant, 500, 20, b) for b in ("numpy", "numba"))
    if np.abs(one.covariance - other.covariance).max() > 1e-8 * one.covariance.max():
        raise SystemExit("the backends disagree; nothing was timed")
    _, covariance, spread, _ = with_simdkalman(plant, 500, 20)
    apart = np.hypot(spread, one.standard_error[1:])
    if (np.abs(covariance - one.covariance[1:]) > 6 * apart).any():
        raise SystemExit("the statistics disagree; nothing was timed")


def records(quick=False):
    """Two rows a size: the whole experiment and the kernels, ns a run and step."""
    runs, steps = 4000 if quick else 10_000, 1000
    batch = 1000  # more series at once do not make simdkalman faster
    for n, p in SIZES[: 1 if quick else None]:
        one = plant(n, p)
        agree(one)
        whole = partial(with_luenberger, one, runs, steps)
        calls = {
            "numba": partial(whole, "numba"),
            "NumPy": partial(whole, "numpy"),
            "simdkalman": partial(with_simdkalman, one, batch, steps),
        }
        work = {name: runs * steps for name in calls} | {"simdkalman": batch * steps}
        size = f"n = {n}, p = {p}"
        times = in_turns(calls, 3 if quick else ROUNDS, work)
        yield record(f"Monte Carlo of {runs} runs", size, "ns", times, 1e9)
        y = np.random.default_rng(1).normal(size=(batch, steps, p))
        calls = {
            "numba": kernel(one, batch, steps),
            "simdkalman": partial(filtered, one, y, False),
        }
        calls["numba"]()  # compiles
        work = dict.fromkeys(calls, batch * steps)
        times = in_turns(calls, 3 if quick else ROUNDS, work)
        yield record("Monte Carlo, kernels alone", size, "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
