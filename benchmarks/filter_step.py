"""One filter step of filter_data beside its peers and hand-written C: ratios, one run.

The same work everywhere: a constant plant without inputs, a complete record, the
Kalman filter (m1 = 0) with gain and covariance at every step.  Contestants take turns,
so that a slow minute of the machine hits all of them, and medians are compared, of
processor time: everything runs in one thread.  Before any timing the estimates are
compared, to 1e-8.

Run:  OMP_NUM_THREADS=1 python benchmarks/filter_step.py [FILE.json]
"""

import ctypes
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from filterpy.kalman import KalmanFilter
from statsmodels.tsa.statespace import kalman_filter

import luenberger as lb

SIZES = [(2, 1), (3, 2), (6, 3), (10, 4), (30, 6), (100, 10)]
SLOW, ROUNDS = 0.1, 11  # seconds that a contestant runs in a round, about; rounds


def plant(n, p, seed=8):
    """A random stable plant with full-rank noise."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    H, h = rng.normal(size=(n, n)), rng.normal(size=(p, p))
    C = rng.normal(size=(p, n))
    return lb.Plant(A, None, C, dt=1.0, Q=H @ H.T, R=h @ h.T, P0=np.eye(n))


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
    first = plant.A @ plant.P0 @ plant.A.T + plant.Q
    model.initialize_known(np.zeros(plant.n), first)
    model.tolerance = 0
    return model.filter().filtered_state.T


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


def contestants(n, p, folder):
    found = {
        "numba": lambda plant, y: lb.filter_data(plant, y, backend="numba").x,
        "NumPy": lambda plant, y: lb.filter_data(plant, y, backend="numpy").x,
        "C by hand": with_c(n, p, folder),
        "statsmodels": with_statsmodels,
        "FilterPy": with_filterpy,
    }
    return {name: run for name, run in found.items() if run is not None}


def medians(runs, plant, y):
    """Nanoseconds per step of each contestant, in turns, and their quartiles."""
    records = {}
    for name, run in runs.items():  # as many steps as take a while
        start = time.process_time()
        for _ in range(3):
            run(plant, y)
        each = (time.process_time() - start) / len(y) / 3
        records[name] = np.tile(y, (max(1, int(SLOW / each / len(y))), 1))
    times = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, run in runs.items():
            start = time.process_time()
            run(plant, records[name])
            each = (time.process_time() - start) / len(records[name])
            times[name].append(each * 1e9)
    return {name: np.percentile(all_, [25, 50, 75]) for name, all_ in times.items()}


def agree(runs, plant, y):
    """Nothing is timed that does not compute the same."""
    wanted = lb.filter_data(plant, y, backend="numpy").x
    for name, run in runs.items():
        if np.abs(run(plant, y) - wanted).max() > 1e-8 * np.abs(wanted).max():
            raise SystemExit(f"{name} computes something else; nothing was timed")


def main(file=None):
    print(f"nanoseconds a step, median of {ROUNDS} rounds (ratio to luenberger, numba)")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for n, p in SIZES:
            runs = contestants(n, p, folder)
            y = np.random.default_rng(1).normal(size=(50 if n > 50 else 500, p))
            agree(runs, plant(n, p), y)
            found = medians(runs, plant(n, p), y)
            base = found["numba"][1]
            cells = (f"{k} {t[1]:.0f} ({t[1] / base:.2f})" for k, t in found.items())
            print(f"{n}, {p}: " + "  ".join(cells), flush=True)
            quartiles = {k: [float(f"{v:.4g}") for v in t] for k, t in found.items()}
            rows.append({"n": n, "p": p, "quartiles_ns": quartiles})
    if file is not None:
        Path(file).write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
