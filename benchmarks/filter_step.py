"""One filter step of filter_data beside FilterPy's and statsmodels': ratios, one run.

The same work everywhere: a constant plant without inputs, a complete record, the
Kalman filter (m1 = 0) with its covariance at every step.  Contestants take turns, so
that a slow minute of the machine hits all of them, and medians are compared.  Before
any timing the estimates are compared, to 1e-8.

Run:  OMP_NUM_THREADS=1 python benchmarks/filter_step.py
"""

import time

import numpy as np
from filterpy.kalman import KalmanFilter
from statsmodels.tsa.statespace.kalman_filter import KalmanFilter as StateSpace

import luenberger as lb

SIZES = [(3, 2), (6, 3), (10, 4)]
STEPS, ROUNDS = 1000, 15


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
    x, P = np.empty((len(y), plant.n)), np.empty((len(y), plant.n, plant.n))
    for k, row in enumerate(y):
        kf.predict()
        kf.update(row[:, None])
        x[k], P[k] = kf.x[:, 0], kf.P
    return x, P


def with_statsmodels(plant, y):
    """Its compiled filter; from the first prior, which is where it starts."""
    model = StateSpace(k_endog=plant.p, k_states=plant.n)
    model.bind(np.ascontiguousarray(y))
    model["transition"], model["design"] = plant.A, plant.C
    model["state_cov"], model["obs_cov"] = plant.Q, plant.R
    model["selection"] = np.eye(plant.n)
    first = plant.A @ plant.P0 @ plant.A.T + plant.Q
    model.initialize_known(np.zeros(plant.n), first)
    model.tolerance = 0  # every covariance is computed, none taken as converged
    found = model.filter()
    return found.filtered_state.T, found.filtered_state_cov.transpose(2, 0, 1)


def with_luenberger(plant, y):
    found = lb.filter_data(plant, y, history=True)
    return found.x, found.P


CONTESTANTS = {
    "luenberger": with_luenberger,
    "FilterPy": with_filterpy,
    "statsmodels": with_statsmodels,
}


def medians(plant, y):
    """Microseconds per step of each contestant, in turns."""
    times = {name: [] for name in CONTESTANTS}
    for _ in range(ROUNDS):
        for name, run in CONTESTANTS.items():
            start = time.perf_counter()
            run(plant, y)
            times[name].append((time.perf_counter() - start) / len(y) * 1e6)
    return {name: float(np.median(all_)) for name, all_ in times.items()}


def agree(plant, y):
    """Nothing is timed that does not compute the same."""
    wanted = with_luenberger(plant, y)
    for name, run in CONTESTANTS.items():
        for a, b in zip(run(plant, y), wanted):
            if np.abs(a - b).max() > 1e-8 * np.abs(b).max():
                raise SystemExit(f"{name} computes something else; nothing was timed")


def main():
    print(f"{STEPS} steps, median of {ROUNDS} rounds, microseconds a step (ratio)")
    print("n, p   " + "".join(f"{name:>20}" for name in CONTESTANTS))
    for n, p in SIZES:
        y = np.random.default_rng(1).normal(size=(STEPS, p))
        agree(plant(n, p), y)
        found = medians(plant(n, p), y)
        base = found["luenberger"]
        cells = (f"{t:.1f} ({t / base:.2f})" for t in found.values())
        print(f"{n:2}, {p}  " + "".join(f"{cell:>20}" for cell in cells))


if __name__ == "__main__":
    main()
