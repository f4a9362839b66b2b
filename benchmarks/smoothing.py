"""A record through `smooth`: nanoseconds a row, and in passes of the filter in full.

The first contestant is `filter_data`, so that the ratios are passes; then the filter
that keeps its covariances, as a smoother must, the smoother, the smoother with the
covariances of neighbours, and statsmodels' smoother on the same record.

Run:  OMP_NUM_THREADS=1 python benchmarks/smoothing.py [--quick]
"""

import sys

import numpy as np
from common import in_turns, line, plant, record, same
from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

import luenberger as lb

SIZES = [(3, 2), (6, 3), (10, 4), (30, 8)]
STEPS, ROUNDS, FEW = 50_000, 7, 20


def with_statsmodels(plant, y):
    """Its default smoother, from our start carried to the first sample."""
    model = KalmanSmoother(k_endog=plant.p, k_states=plant.n, k_posdef=plant.n)
    model["design"], model["transition"] = plant.C, plant.A
    model["selection"], model["state_cov"] = np.eye(plant.n), plant.Q
    model["obs_cov"] = plant.R
    first = plant.A @ plant.P0 @ plant.A.T + plant.Q
    model.initialize_known(np.zeros(plant.n), first)
    model.bind(np.asfortranarray(y.T))
    return model.smooth().smoothed_state.T


def contestants(plant, backend):
    """Ours first: ratios are to its time."""
    return {
        "filter": lambda y: lb.filter_data(plant, y, settle=None, backend=backend).x,
        "filter, kept": lambda y: (
            lb.filter_data(plant, y, settle=None, backend=backend, history=True).x
        ),
        "smoother": lambda y: lb.smooth(plant, y, backend=backend).x,
        "with neighbours": lambda y: lb.smooth(plant, y, backend=backend).lag_one,
        "statsmodels": lambda y: with_statsmodels(plant, y),
    }


def records(quick=False):
    """One row a size and backend, nanoseconds a row."""
    for backend in ("numba", "numpy"):
        for n, p in SIZES[: 2 if quick else None]:
            one = plant(n, p)
            steps = STEPS if backend == "numba" else STEPS // FEW
            y = np.random.default_rng(1).normal(size=(steps, p))
            runs = contestants(one, backend)
            same("smoother", runs["smoother"](y), runs["statsmodels"](y))
            calls = {k: lambda k=k: runs[k](y) for k in runs}  # noqa: B023
            runs["with neighbours"](y)
            work = dict.fromkeys(runs, steps)
            times = in_turns(calls, 5 if quick else ROUNDS, work)
            yield record(f"smoothing, {backend}", f"n = {n}, p = {p}", "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
