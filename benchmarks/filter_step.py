"""One filter step of filter_data beside its peers and hand-written C: ratios, one run.

The same work everywhere: a constant plant without inputs, a complete record, the
Kalman filter (m1 = 0) with gain and covariance at every step.  Contestants take turns,
so that a slow minute of the machine hits all of them, and medians are compared, of
processor time: everything runs in one thread.  Before any timing the estimates are
compared, to 1e-8.

Two peers do it in their own way.  python-control has no filter over a record: it
simulates its estimator, which is the one-step predictor with the same covariance.
simdkalman filters many series at once; its time is for one step of one of them.

Run:  OMP_NUM_THREADS=1 python benchmarks/filter_step.py [--quick]
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import control
import numpy as np
import pykalman
import simdkalman
from c_export import over_records
from common import first_prior, in_turns, line, plant, record, same, seconds
from filterpy.kalman import KalmanFilter
from statsmodels.tsa.statespace import kalman_filter

import luenberger as lb

SIZES = [(2, 1), (3, 2), (6, 3), (10, 4), (30, 6), (100, 10)]
SPELL, ROUNDS = 0.1, 9  # seconds that a contestant runs in a round, about; rounds


def with_filterpy(plant, y):
    """predict, update; the Joseph form, as in filter_data."""
    kf = KalmanFilter(dim_x=plant.n, dim_z=plant.p)
    kf.F, kf.H, kf.Q, kf.R = plant.A, plant.C, plant.Q, plant.R
    kf.x, kf.P = np.zeros((plant.n, 1)), plant.P0
    x = np.empty((len(y), plant.n))
    for k, row in enumerate(y):
        kf.predict()
        kf.update(row[:, None])
        x[k] = kf.x[:, 0]
    return x


def with_statsmodels(plant, y):
    """Its compiled filter, told to keep no more than the estimates.

    It starts from the first prior; tolerance 0: no covariance is taken as converged.
    """
    model = kalman_filter.KalmanFilter(k_endog=plant.p, k_states=plant.n)
    for what in ("forecast", "predicted", "smoothing", "likelihood", "gain"):
        setattr(model, f"memory_no_{what}", True)
    model.bind(np.ascontiguousarray(y))
    model["transition"], model["design"] = plant.A, plant.C
    model["state_cov"], model["obs_cov"] = plant.Q, plant.R
    model["selection"] = np.eye(plant.n)
    model.initialize_known(np.zeros(plant.n), first_prior(plant))
    model.tolerance = 0
    return model.filter().filtered_state.T


def with_pykalman(plant, y):
    """Its filter keeps the covariance of every step."""
    kf = pykalman.KalmanFilter(
        plant.A, plant.C, plant.Q, plant.R,
        initial_state_mean=np.zeros(plant.n),
        initial_state_covariance=first_prior(plant),
    )  # fmt: skip
    return kf.filter(y)[0]


def with_simdkalman(plant, y):
    """(N, p), or (series, N, p) side by side; it keeps the covariances too."""
    model = simdkalman.KalmanFilter(plant.A, plant.Q, plant.C, plant.R)
    found = model.compute(
        y.reshape(-1, *y.shape[-2:]), 0,
        initial_value=np.zeros(plant.n), initial_covariance=first_prior(plant),
        filtered=True, smoothed=False, observations=False, covariances=False,
    )  # fmt: skip
    return found.filtered.states.mean.reshape(*y.shape[:-1], plant.n)


def with_control(plant, y):
    """The one-step predictor A x, not x; x is not among its outputs."""
    n = plant.n
    # w enters as an input would, and there is none
    system = control.ss(plant.A, np.eye(n), plant.C, np.zeros(plant.C.shape), plant.dt)
    filter_ = control.create_estimator_iosystem(
        system, plant.Q, plant.R, first_prior(plant)
    )
    given = np.hstack([y, np.zeros((len(y), n))]).T
    start = np.concatenate([np.zeros(n), first_prior(plant).ravel()])
    T = np.arange(len(y)) * plant.dt
    return control.input_output_response(filter_, T, given, start).outputs.T


def with_c(n, p, folder):
    """`filter_step.c` compiled for one size by gcc -O3; None where there is no gcc."""
    if shutil.which("gcc") is None:
        return None
    library = Path(folder) / f"step_{n}_{p}.so"
    source = Path(__file__).with_suffix(".c")
    sizes = [f"-DN={n}", f"-DP={p}"]
    command = ["gcc", "-O3", *sizes, "-shared", "-fPIC", "-o", library, source]
    subprocess.run(command, check=True)
    code = ctypes.CDLL(str(library)).filter

    def run(plant, y):
        x, X = np.zeros(n), np.empty((len(y), n))
        arrays = plant.A, plant.C, plant.Q, plant.R, x, plant.P0.copy(), y, X
        code(*(ctypes.c_void_p(a.ctypes.data) for a in arrays), ctypes.c_long(len(y)))
        return X

    return run


def with_exported_c(one, folder):
    """What `to_c` writes, compiled for this processor; None where there is no gcc."""
    if shutil.which("gcc") is None:
        return None
    over = over_records(one, Path(folder), "step")
    return lambda plant, y: over(y)


def contestants(one, folder):
    """Ours first: ratios are to its time."""
    found = {
        "numba": lambda plant, y: (
            lb.filter_data(plant, y, settle=None, backend="numba").x
        ),
        "NumPy": lambda plant, y: (
            lb.filter_data(plant, y, settle=None, backend="numpy").x
        ),
        "exported C": with_exported_c(one, folder),
        "C by hand": with_c(one.n, one.p, folder),
        "statsmodels": with_statsmodels,
        "FilterPy": with_filterpy,
        "pykalman": with_pykalman,
        "simdkalman": with_simdkalman,
        "python-control": with_control,
    }
    return {name: run for name, run in found.items() if run is not None}


def agree(runs, plant, y):
    wanted = lb.filter_data(plant, y, settle=None, backend="numpy").x
    for name, run in runs.items():
        if name == "python-control":
            same(name, run(plant, y)[1:], wanted[:-1] @ plant.A.T)
        else:
            same(name, run(plant, y), wanted)


def long_enough(name, run, plant, y):
    """As many copies of a record as take a while: in a row, or side by side."""
    if name == "simdkalman":
        series = int(np.clip(2e7 / plant.n**2 / len(y), 20, 1000))  # 160 MB
        return np.repeat(y[None], series, axis=0)
    copies, taken = 1, 0.0
    while taken < SPELL / 2:  # a short record tells what a call costs, not a step
        copies = int(np.ceil(copies * min(10.0, SPELL / taken if taken else 1.0)))
        taken = seconds(lambda: run(plant, np.tile(y, (copies, 1))))[0]  # noqa: B023
    return np.tile(y, (copies, 1))


def records(quick=False):
    """One row a size, nanoseconds a step."""
    for n, p in SIZES[: 4 if quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            runs = contestants(one := plant(n, p), folder)
            y = np.random.default_rng(1).normal(size=(50 if n > 50 else 500, p))
            agree(runs, one, y)
            given = {name: long_enough(name, run, one, y) for name, run in runs.items()}
            work = {name: Y.size // p for name, Y in given.items()}
            calls = {
                name: lambda run=run, Y=given[name]: run(one, Y)  # noqa: B023
                for name, run in runs.items()
            }
            times = in_turns(calls, 5 if quick else ROUNDS, work)
        yield record("filter step", f"n = {n}, p = {p}", "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
