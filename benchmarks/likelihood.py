"""The likelihood of a record and its gradient, in passes of the filter in full.

The same plants and records as in `filter_step`.  statsmodels computes the likelihood
alone; a gradient by differences takes it one more likelihood for each number.

Run:  OMP_NUM_THREADS=1 python benchmarks/likelihood.py [--quick]
"""

import sys

import numpy as np
from common import first_prior, in_turns, line, plant, record, same
from statsmodels.tsa.statespace import kalman_filter

import luenberger as lb

SIZES = [(3, 2), (10, 4)]
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


def contestants(plant, y, backend):
    """The filter first: ratios are to its time."""

    def likelihood(**options):
        return lb.log_likelihood(plant, y, backend=backend, **options)

    return {
        f"{backend} filter": lambda: lb.filter_data(
            plant, y, settle=None, backend=backend
        ),
        "likelihood": likelihood,
        "likelihood and gradient": lambda: likelihood(gradient=True),
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
            yield record("likelihood", f"n = {n}, p = {p}", "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
