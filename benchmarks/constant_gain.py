"""A record through an observer of constant gain: nanoseconds a step, ratios, one run.

The steady Kalman filter of a random plant, as an `Observer`, on one record.  Peers that
run a constant state-space system: scipy.signal.dlsim and control.forced_response, given
our matrices, and FilterPy with its `update_steadystate`.  statsmodels, pykalman and
simdkalman have no filter whose gain is given: they recompute it at every step.
C by hand has matrices and sizes as constants; so has the exported C.

Run:  OMP_NUM_THREADS=1 python benchmarks/constant_gain.py [--quick]
"""

import shutil
import sys
import tempfile
from pathlib import Path

import c_export
import control
import numpy as np
import scipy.signal
from common import in_turns, line, plant, record, same
from filterpy.kalman import KalmanFilter

import luenberger as lb
from luenberger.export import to_control, to_scipy

SIZES = [(3, 2), (10, 4), (30, 6)]
STEPS, ROUNDS = 20_000, 11
FEW = 10  # those who take microseconds a step get a record this many times shorter


def with_filterpy(plant, observer, y):
    """predict, update, with its K held; that of our steady filter is V."""
    kf = KalmanFilter(dim_x=plant.n, dim_z=plant.p)
    kf.F, kf.H, kf.K = plant.A, plant.C, observer.V
    kf.x = np.zeros((plant.n, 1))
    x = np.empty((len(y), plant.n))
    for k, row in enumerate(y):
        kf.predict_steadystate()
        kf.update_steadystate(row[:, None])
        x[k] = kf.x[:, 0]
    return x


def with_dlsim(system, observer, y):
    return scipy.signal.dlsim(system, y, x0=observer.z0)[1]


def with_control(system, observer, y):
    T = np.arange(len(y)) * observer.dt
    return control.forced_response(system, T, y.T, X0=observer.z0).outputs.T


def contestants(plant, observer, folder):
    """Ours first: ratios are to its time."""
    scipy_, control_ = to_scipy(observer), to_control(observer)
    found = {
        "numba": lambda y: lb.estimate(observer, y, backend="numba"),
        "NumPy": lambda y: lb.estimate(observer, y, backend="numpy"),
    }
    if shutil.which("gcc") is not None:
        made = c_export.contestants(Path(folder), observer, plant.n, plant.p)
        for name, run in (("exported C", "exported"), ("C by hand", "by hand")):
            found[name] = lambda y, run=made[run]: c_export.called(run, observer, y)
    return found | {
        "FilterPy": lambda y: with_filterpy(plant, observer, y),
        "SciPy": lambda y: with_dlsim(scipy_, observer, y),
        "python-control": lambda y: with_control(control_, observer, y),
    }


def records(quick=False):
    """One row a size, nanoseconds a step."""
    for n, p in SIZES[: 2 if quick else None]:
        one = plant(n, p)
        observer = lb.kalman_filter(one)
        y = np.random.default_rng(1).normal(size=(STEPS, p))
        with tempfile.TemporaryDirectory() as folder:
            runs = contestants(one, observer, folder)
            wanted = lb.estimate(observer, y, backend="numpy")
            for name, run in runs.items():
                same(name, run(y), wanted)
            slow = "FilterPy", "SciPy", "python-control"
            given = {k: y[: STEPS // FEW] if k in slow else y for k in runs}
            calls = {k: lambda k=k: runs[k](given[k]) for k in runs}  # noqa: B023
            work = {name: len(Y) for name, Y in given.items()}
            times = in_turns(calls, 5 if quick else ROUNDS, work)
        yield record("constant-gain estimate", f"n = {n}, p = {p}", "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
