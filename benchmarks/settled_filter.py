"""A long record of a plant that does not change: where a filter may stop its recursion.

`filter_data` at its defaults, beside its own full recursion and statsmodels, which
takes a covariance as converged where two of them are close.  Of ours the estimates are
read; another contestant reads deviations too, which are written when they are asked
for.  The default setting of statsmodels is one contestant; the other keeps no more than
the estimates, its fastest way.  Records are so long that the rows before the stop count
little; the bound takes as long on any record.  "off" is the largest error of an
estimate, in standard deviations, beside the full recursion.

Run:  OMP_NUM_THREADS=1 python benchmarks/settled_filter.py [--quick]
"""

import sys

import numpy as np
from common import first_prior, in_turns, line, plant, record
from statsmodels.tsa.statespace import kalman_filter

import luenberger as lb

SIZES = [
    (3, 2, 1_000_000), (10, 4, 300_000), (10, 4, 1_000_000), (30, 6, 100_000),
    (100, 10, 40_000),
]  # fmt: skip
OURS = ("numba", "numba, deviations")
ROUNDS, PEER_ROWS = 5, 100_000  # rounds; rows at most that the others filter


def model(plant, y, lean):
    """statsmodels' filter, from our start carried to the first sample."""
    found = kalman_filter.KalmanFilter(k_endog=plant.p, k_states=plant.n)
    if lean:
        for what in ("forecast", "predicted", "smoothing", "likelihood", "gain"):
            setattr(found, f"memory_no_{what}", True)
    found.bind(np.ascontiguousarray(y))
    found["transition"], found["design"] = plant.A, plant.C
    found["state_cov"], found["obs_cov"] = plant.Q, plant.R
    found["selection"] = np.eye(plant.n)
    found.initialize_known(np.zeros(plant.n), first_prior(plant))
    return found.filter().filtered_state.T


def deviations(plant, y):
    """Estimates, once deviations have been read too."""
    found = lb.filter_data(plant, y, backend="numba")
    return (found.std, found.x)[1]


def contestants(plant):
    """Ours first: ratios are to its time."""
    return {
        "numba": lambda y: lb.filter_data(plant, y, backend="numba").x,
        "numba, deviations": lambda y: deviations(plant, y),
        "full recursion": lambda y: (
            lb.filter_data(plant, y, settle=None, backend="numba").x
        ),
        "statsmodels": lambda y: model(plant, y, lean=False),
        "statsmodels, lean": lambda y: model(plant, y, lean=True),
    }


def records(quick=False):
    """One row a size, nanoseconds a step."""
    for n, p, rows in SIZES[: 2 if quick else None]:
        one, runs = plant(n, p), None
        y = np.random.default_rng(1).normal(size=(rows, p))
        runs = contestants(one)
        peers = 4000 if n > 50 else PEER_ROWS
        given = {name: y if name in OURS else y[:peers] for name in runs}
        told(one, y[:peers], runs)
        calls = {name: lambda k=name: runs[k](given[k]) for name in runs}  # noqa: B023
        work = {name: len(Y) for name, Y in given.items()}
        times = in_turns(calls, 3 if quick else ROUNDS, work, twice=True)
        case = f"n = {n}, p = {p}, {rows} rows"
        yield record("settled filter", case, "ns", times, 1e9)


def told(plant, y, runs):
    """Print where ours stopped, its bound, and how far off each one is."""
    found = lb.filter_data(plant, y, backend="numba")
    full = lb.filter_data(plant, y, settle=None, backend="numba")
    off = {
        name: np.abs((runs[name](y) - full.x) / full.std).max()
        for name in runs
        if name != "full recursion"
    }
    said = ", ".join(f"{name} {value:.1e}" for name, value in off.items())
    print(f"n = {plant.n}: one gain from row {found.settled_at} on, ", end="")
    print(f"bound {found.settle_bound:.1e}; off: {said}", flush=True)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
