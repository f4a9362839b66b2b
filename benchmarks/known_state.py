"""What does a step cost where a covariance is singular, beside the same where none is?

One state is a constant that is known, so every covariance is singular; or one output
has no noise, so those of estimates are, and not those of predictions; or one noise
drives the state ("told") or none ("silent"), and outputs without noise tell all of it.
Beside them the plant of the other benchmarks, of the same size.  numba's `filter_data`
over every row, and exported C (gcc -O3 -march=native), each beside itself; estimates of
both are compared with those of NumPy before anything is timed.

Run:  OMP_NUM_THREADS=1 python benchmarks/known_state.py [--quick]
"""

import dataclasses
import pathlib
import shutil
import sys
import tempfile

import numpy as np
from c_export import over_records
from common import in_turns, line, plant, record, same

import luenberger as lb

SIZES = [(3, 2), (10, 4), (30, 6)]
WORK, ROUNDS = 4e8, 15  # cubes of n in a record, about; rounds


def with_constant(one):
    """The same plant, but its last state is 1 for ever."""
    A, Q, P0, x0 = one.A.copy(), one.Q.copy(), one.P0.copy(), np.eye(one.n)[-1]
    A[-1] = x0
    A[:-1, :-1] *= 0.95 / max(0.95, np.abs(np.linalg.eigvals(A[:-1, :-1])).max())
    for X in (Q, P0):
        X[-1], X[:, -1] = 0, 0
    return dataclasses.replace(one, A=A, Q=Q, P0=P0, x0=x0)


def with_exact_output(one):
    """The same plant, but its first output has no noise."""
    R = one.R.copy()
    R[0], R[:, 0] = 0, 0
    return dataclasses.replace(one, R=R)


def told(one, drives=True):
    """The same with one noise, and two outputs without; or with no noise at all.

    Its modes are faster: where rounding would grow, NumPy does each row.
    """
    G, R = np.linalg.cholesky(one.Q)[:, :1] * drives, one.R * drives
    R[:2], R[:, :2] = 0, 0
    return dataclasses.replace(one, A=0.3 * one.A, Q=G @ G.T, R=R)


KINDS = {
    "": lambda one: one,
    ", known": with_constant,
    ", exact": with_exact_output,
    ", told": told,
    ", silent": lambda one: told(one, drives=False),
}
TOLD = {", told", ", silent"}  # with readings that do not contradict each other
MOST = 200_000  # such readings


def told_record(one, rows, seed=1):
    """Measurements (rows, p) of a run of a plant with one noise, or none."""
    rng, x = np.random.default_rng(seed), np.ones(one.n)
    G = np.sqrt(one.Q.diagonal()) * np.where(one.Q[0] < 0, -1, 1)
    noise = np.zeros((rows, one.p))
    if one.R.any():
        noise[:, 2:] = rng.multivariate_normal(np.zeros(one.p - 2), one.R[2:, 2:], rows)
    states = np.empty((rows, one.n))
    for k, w in enumerate(rng.normal(size=rows)):
        states[k] = x = one.A @ x + G * w
    return states @ one.C.T + noise


def contestants(n, p, folder):
    """Filters by name, and the records of a kind: each way, each kind of plant."""
    found, made = {}, {}
    for kind, change in KINDS.items():
        one = change(plant(n, p))
        found["numba" + kind] = lambda y, one=one: (
            lb.filter_data(one, y, settle=None, backend="numba").x
        )
        rows = int(WORK / (4 * n**3 + 300))
        y = np.random.default_rng(1).normal(size=(rows, p))
        made[kind] = told_record(one, min(rows, MOST)) if kind in TOLD else y
        if shutil.which("gcc") and kind in ("", ", known"):
            name = f"made{len(found)}"
            found["exported C" + kind] = over_records(one, pathlib.Path(folder), name)
        y = made[kind][:300]
        wanted = lb.filter_data(one, y, settle=None, backend="numpy").x
        for name, run in found.items():
            if name.partition(",")[2] == kind[1:]:
                same(name, run(y), wanted)
    return found, made


def records(quick=False):
    """Two rows a size, ratios are to the plant without such a thing."""
    for n, p in SIZES[: 2 if quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            runs, made = contestants(n, p, folder)
            for way in ("numba", "exported C"):
                names = {kind[2:] or "none": way + kind for kind in KINDS}
                names = {k: name for k, name in names.items() if name in runs}
                if way not in runs:
                    continue
                y = {k: made[name.removeprefix(way)] for k, name in names.items()}
                calls = {
                    k: lambda run=runs[names[k]], y=y[k]: run(y)  # noqa: B023
                    for k in names
                }
                rows = {k: len(one) for k, one in y.items()}
                times = in_turns(calls, 5 if quick else ROUNDS, rows)
                row, case = f"a known state, {way}", f"n = {n}, p = {p}"
                yield record(row, case, "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
