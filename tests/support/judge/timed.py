"""One side of the timings: reads names of rows, answers with seconds and a number.

Run by `checkout.timings` with the library of one checkout on its path.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from . import adapter


def plant(n, p, exact=False, noises=True):
    """A random stable plant; with `exact` its first output has no noise."""
    rng = np.random.default_rng(8)
    A = rng.normal(size=(n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    H, h = rng.normal(size=(n, n)), rng.normal(size=(p, p))
    C, R = rng.normal(size=(p, n)), np.diag([0.0] + [1.0] * (p - 1))
    Q, R = H @ H.T, R if exact else h @ h.T
    if not noises:
        Q = R = None
    return adapter.plant(A, None, C, None, Q=Q, R=R, P0=np.eye(n) if noises else None,
                         x0=np.zeros(n))  # fmt: skip


def record(rows, p, gaps=0.0):
    rng = np.random.default_rng(1)
    y = rng.normal(size=(rows, p))
    y[rng.random(y.shape) < gaps] = np.nan
    return y


def simulated(rows):
    """A record of three states with independent noises, to be fitted."""
    one, rng = plant(3, 1), np.random.default_rng(1)
    x, y = np.zeros(3), np.empty((rows, 1))
    for row in y:
        row[:] = one.C @ x + rng.normal(size=1)
        x = one.A @ x + rng.normal(size=3)
    return plant(3, 1, noises=False), y


def library(*sources, flags=()):
    """C, compiled by gcc and loaded."""
    made = Path(tempfile.mkdtemp()) / "made.so"
    flags = [*"-std=c99 -O3 -shared -fPIC".split(), *flags]
    subprocess.run(["gcc", *flags, "-o", made, *sources, "-lm"], check=True)
    return ctypes.CDLL(str(made))


def device(one, y):
    """The exported filter, compiled, over a record."""
    run = library(*adapter.exported(one, Path(tempfile.mkdtemp()))).run
    what = np.empty((len(y), one.n))

    def over():
        status = run(*(ctypes.c_void_p(X.ctypes.data) for X in (y, what)), len(y))
        assert status == 0
        return what

    return over


def rows():
    """{name: () -> a call that is timed}."""

    def over(call, n, p, rows, gaps=0.0, exact=False, **options):
        def made():
            one, y = plant(n, p, exact), record(rows, p, gaps)
            return lambda: call(one, y, **options)

        return made

    def many():
        one, y = plant(3, 2), record(1024 * 250, 2, 0.1).reshape(1024, 250, 2)
        return lambda: adapter.over_rows(one, y)

    def fit():
        one, y = simulated(2000)
        return lambda: adapter.fitted(one, y)

    def short():
        one, y = plant(3, 2), record(200, 2)
        return lambda: [adapter.as_called(one, y) for _ in range(100)][0]

    filter_, smooth = adapter.over_rows, adapter.smoothed_rows
    likelihood = adapter.likelihood_of_rows
    return {
        "filter, noisy, n = 3": over(filter_, 3, 2, 200_000),
        "filter, noisy, n = 10": over(filter_, 10, 4, 40_000),
        "filter, noisy, n = 30": over(filter_, 30, 6, 6000),
        "filter, 10 % gaps, n = 3": over(filter_, 3, 2, 200_000, 0.1),
        "filter, 10 % gaps, n = 10": over(filter_, 10, 4, 40_000, 0.1),
        "filter, one exact output, n = 3": over(filter_, 3, 2, 200_000, exact=True),
        "filter, one exact output, n = 10": over(filter_, 10, 4, 40_000, exact=True),
        "likelihood, 10 % gaps, n = 3": over(likelihood, 3, 2, 200_000, 0.1),
        "fleet of 1024 with gaps, n = 3": many,
        "smoothing, n = 3": over(smooth, 3, 2, 100_000),
        "smoothing, n = 10": over(smooth, 10, 4, 20_000),
        "smoothing, one exact output, n = 3": over(smooth, 3, 2, 1000, exact=True),
        "settled tail, n = 3": over(filter_, 3, 2, 1_000_000, settled=True),
        "fit of noise, n = 3": fit,
        "100 calls of 200 rows, n = 3": short,
        "exported C, n = 3": lambda: device(plant(3, 2), record(200_000, 2)),
    }


def main():
    made, calls = rows(), {}
    for name in map(str.strip, sys.stdin):
        if name not in calls:
            calls[name] = made[name]()
            calls[name]()  # what is compiled or kept is not timed
        start = time.process_time()
        found = calls[name]()
        took = time.process_time() - start
        print(took, np.nanmean(np.abs(found)), flush=True)


if __name__ == "__main__":
    main()
