"""How long a new process waits: imports, and the first record, cache cold and warm.

Processor time of the new process, which is what it takes on a machine with nothing
else to do.  Cold: the cache folder is empty, and the compiler runs.

Run:  OMP_NUM_THREADS=1 python benchmarks/first_call.py [--quick]
"""

import os
import subprocess
import sys
import tempfile

from common import line, record

ROUNDS = 7
FIRST = (
    "import numpy as np, luenberger as lb\n"
    "A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], [[1, 0, 0], [0, 1, 0]]\n"
    "plant = lb.Plant(A, None, C, dt=1.0, Q=np.diag([0.0, 0, 1]),\n"
    "                 R=np.diag([0.25, 4]), P0=np.eye(3))\n"
    "lb.filter_data(plant, np.zeros((1000, 2)), backend={!r})\n"
)
IMPORTS = {
    "NumPy": "import luenberger",
    "numba": "import luenberger, numba",
    "statsmodels": "import statsmodels.tsa.statespace.kalman_filter",
    "FilterPy": "import filterpy.kalman",
    "pykalman": "import pykalman",
    "simdkalman": "import simdkalman",
    "python-control": "import control",
    "SciPy": "import scipy.linalg, scipy.signal",
}


def seconds(code, folder):
    """A process has its own clock, so `common.in_turns` cannot be used."""
    environment = os.environ | {"LUENBERGER_CACHE": folder}
    before = os.times()
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    after = os.times()
    user = after.children_user - before.children_user
    return user + after.children_system - before.children_system


def in_turns(codes, folders, rounds):
    times = {name: [] for name in codes}
    for _ in range(rounds):
        for name, code in codes.items():
            times[name].append(seconds(code, folders()))
    return times


def records(quick=False):
    rounds = 3 if quick else ROUNDS
    numba, numpy = FIRST.format("numba"), FIRST.format("numpy")
    with tempfile.TemporaryDirectory() as folder:
        times = in_turns(IMPORTS, lambda: folder, rounds)
        yield record("import", "", "s", times)
        seconds(numba, folder)  # fills the cache
        times = in_turns({"numba": numba, "NumPy": numpy}, lambda: folder, rounds)
        yield record("first record", "n = 3, warm cache", "s", times)
        times = in_turns(
            {"numba": numba}, lambda: tempfile.mkdtemp(dir=folder), (rounds + 1) // 2
        )
        yield record("first record", "n = 3, cold cache", "s", times)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
