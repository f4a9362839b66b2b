"""The likelihood of a record and its gradient, in passes of the filter in full.

The same plants and records as in `filter_step`.  statsmodels computes the likelihood
alone; a gradient by differences takes it one more likelihood for each number.  Then the
worst cases of a grid over sizes, lengths, gaps and starts: `WORST`.

Run:  OMP_NUM_THREADS=1 python benchmarks/likelihood.py [--quick]
"""

import sys
from dataclasses import replace

import numpy as np
from common import first_prior, in_turns, line, plant, record, record_of, same
from statsmodels.tsa.statespace import kalman_filter

import luenberger as lb

SIZES = [(3, 2), (10, 4)]
WORST = [(6, 4, 50_000), (6, 1, 10_000), (10, 1, 2_000)]  # gaps, an unknown start
MISSING = 0.05
STEPS, ROUNDS = 10_000, 11


def statsmodels(plant, y):
    """Its compiled likelihood; tolerance 0: no covariance is taken as converged."""
    model = kalman_filter.KalmanFilter(k_endog=plant.p, k_states=plant.n)
    model.bind(y)
    model["design"], model["transition"] = plant.C, plant.A
    model["selection"] = np.eye(plant.n)
    model["state_cov"], model["obs_cov"] = plant.Q, plant.R
    model.initialize_known(np.zeros(plant.n), first_prior(plant))
    model.tolerance = 0
    return model.loglike


def contestants(plant, y, backend, start=True):
    """The filter first: ratios are to its time.  Without `start` P0 is not known."""
    judged = plant if start else replace(plant, P0=None)

    def likelihood(**options):
        return lb.log_likelihood(judged, y, backend=backend, **options)

    return {
        "filter": lambda: lb.filter_data(plant, y, settle=None, backend=backend),
        "likelihood": likelihood,
        "gradient": lambda: likelihood(gradient=True),
    }


def records(quick=False):
    """One row a size and backend, nanoseconds a step."""
    for n, p in SIZES[: 1 if quick else None]:
        for backend, steps in (("numba", STEPS), ("numpy", STEPS // 20)):
            one = plant(n, p)
            y = np.random.default_rng(1).normal(size=(steps, p))
            runs = contestants(one, y, backend)
            if backend == "numba":
                runs["statsmodels' likelihood"] = statsmodels(one, y)
                same("statsmodels", statsmodels(one, y)(), runs["likelihood"]())
            for run in runs.values():
                run()
            work = dict.fromkeys(runs, steps)
            times = in_turns(runs, 3 if quick else ROUNDS, work)
            row = f"likelihood, {backend}"
            yield record(row, f"n = {n}, p = {p}", "ns", times, 1e9)
    for n, p, steps in WORST[: 1 if quick else None]:
        rng = np.random.default_rng(1)
        y = record_of(plant(n, p), steps, rng)
        y[rng.random(y.shape) < MISSING] = np.nan
        runs = contestants(plant(n, p), y, "numba", start=False)
        for run in runs.values():
            run()
        times = in_turns(runs, 3 if quick else ROUNDS, dict.fromkeys(runs, steps))
        case = f"n = {n}, p = {p}, {steps} rows, gaps, unknown start"
        yield record("likelihood", case, "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
