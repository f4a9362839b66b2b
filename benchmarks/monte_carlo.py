"""Monte Carlo beside simdkalman: nanoseconds per series and step, ratios, one run.

Ours draws the noise, simulates the plant, runs the Kalman filter over it and gathers
the error's mean, covariance, standard errors and NEES.  simdkalman vectorises over
series; it is handed the measurements, and only filters.  So ours does more and is
timed for all of it.  simdkalman's filter computes gains along with the estimates and
for every series; ours is designed over steps beforehand, and that is timed too.

Before anything is timed the estimates are compared, to 1e-8.  Contestants take turns,
each on one core, and it is the time of that core which is counted, so that what else
the machine does matters less.

Run:  OMP_NUM_THREADS=1 python benchmarks/monte_carlo.py [runs steps sizes]
"""

import sys
import time
from functools import partial

import numpy as np
import simdkalman

import luenberger as lb

SIZES = [(3, 2), (6, 3), (10, 4)]
ROUNDS = 5


def plant(n, p, seed=8):
    """A random stable plant with full-rank noise."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    H, h = rng.normal(size=(n, n)), rng.normal(size=(p, p))
    C = rng.normal(size=(p, n))
    return lb.Plant(A, None, C, dt=1.0, Q=H @ H.T, R=h @ h.T, P0=np.eye(n))


def with_simdkalman(plant, y):
    """Filtered means (series, steps, n), all series at once."""
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
        covariances=False,
    )
    return found.filtered.states.mean


def with_luenberger(plant, runs, steps, backend):
    observer = lb.kalman_filter(plant, steps=steps)
    return lb.monte_carlo(
        plant, observer, runs=runs, steps=steps, seed=1, backend=backend
    )


def agree(plant):
    """Nothing is timed that does not compute the same."""
    y = np.random.default_rng(1).normal(size=(3, 50, plant.p))
    observer = lb.kalman_filter(plant, steps=50)
    wanted = np.stack([lb.estimate(observer, series) for series in y])
    if np.abs(with_simdkalman(plant, y) - wanted).max() > 1e-8 * np.abs(wanted).max():
        raise SystemExit("simdkalman computes something else; nothing was timed")
    few = dict(runs=100, steps=50)
    one, other = (with_luenberger(plant, **few, backend=b) for b in ("numpy", "numba"))
    if np.abs(one.covariance - other.covariance).max() > 1e-8 * one.covariance.max():
        raise SystemExit("the backends disagree; nothing was timed")


def medians(plant, runs, steps):
    """Nanoseconds per series and step of each contestant, in turns."""
    batch = min(runs, 1000)  # more series at once do not make simdkalman faster
    y = np.random.default_rng(1).normal(size=(batch, steps, plant.p))
    ours = partial(with_luenberger, plant, runs, steps)
    contestants = {
        "luenberger, numba": (runs, partial(ours, "numba")),
        "luenberger, NumPy": (runs, partial(ours, "numpy")),
        "simdkalman": (batch, partial(with_simdkalman, plant, y)),
    }
    times = {name: [] for name in contestants}
    for round_ in range(ROUNDS + 1):
        for name, (series, run) in contestants.items():
            start = time.process_time()
            run()
            taken = (time.process_time() - start) / series / steps * 1e9
            if round_:  # the first one compiles
                times[name].append(taken)
    return {name: np.quantile(all_, [0.5, 0, 1]) for name, all_ in times.items()}


def main():
    given = [int(text) for text in sys.argv[1:]]
    runs, steps, sizes = (*given, *(10_000, 1000, len(SIZES))[len(given) :])
    print(f"{runs} runs of {steps} steps, ns per series and step, median of {ROUNDS}")
    print("(least-most), and simdkalman's median over ours")
    for n, p in SIZES[:sizes]:
        agree(plant(n, p))
        found = medians(plant(n, p), runs, steps)
        peer = found["simdkalman"][0]
        for name, (middle, least, most) in found.items():
            print(
                f"{n:2}, {p}  {name:18} {middle:8.0f} ({least:.0f}-{most:.0f})"
                f"  {peer / middle:6.1f}"
            )


if __name__ == "__main__":
    main()
