"""What does a step cost where a covariance is singular, beside the same where none is?

One state is a constant that is known, so every covariance is singular; or one output
has no noise, so those of estimates are, and not those of predictions.  Beside both the
plant of the other benchmarks, of the same size.  numba's `filter_data` over every row,
and exported C (gcc -O3 -march=native), each beside itself; estimates of both are
compared with those of NumPy before anything is timed.

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


KINDS = {"": lambda one: one, ", known": with_constant, ", exact": with_exact_output}


def contestants(n, p, folder):
    """Filters of a record by name: each way, and each kind of plant that it has."""
    found = {}
    for kind, change in KINDS.items():
        one = change(plant(n, p))
        found["numba" + kind] = lambda y, one=one: (
            lb.filter_data(one, y, settle=None, backend="numba").x
        )
        if shutil.which("gcc") and kind != ", exact":
            name = f"made{len(found)}"
            found["exported C" + kind] = over_records(one, pathlib.Path(folder), name)
        y = np.random.default_rng(1).normal(size=(300, p))
        wanted = lb.filter_data(one, y, settle=None, backend="numpy").x
        for name, run in found.items():
            if name.partition(",")[2] == kind[1:]:
                same(name, run(y), wanted)
    return found


def records(quick=False):
    """Two rows a size, ratios are to the plant without such a thing."""
    for n, p in SIZES[: 2 if quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            runs = contestants(n, p, folder)
            y = np.random.default_rng(1).normal(size=(int(WORK / (4 * n**3 + 300)), p))
            for way in ("numba", "exported C"):
                names = {
                    "none": way,
                    "known": f"{way}, known",
                    "exact": f"{way}, exact",
                }
                names = {k: name for k, name in names.items() if name in runs}
                if way not in runs:
                    continue
                calls = {
                    k: lambda run=runs[names[k]]: run(y)  # noqa: B023
                    for k in names
                }
                times = in_turns(calls, 5 if quick else ROUNDS)
                row, case = f"a known state, {way}", f"n = {n}, p = {p}"
                yield record(row, case, "ns", times, 1e9 / len(y))


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
