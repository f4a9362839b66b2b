"""How long a new process waits: imports, and the first record with a warm cache.

Processor time of the new process, which is what it takes on a machine with nothing
else to do.

Run:  OMP_NUM_THREADS=1 python benchmarks/first_call.py
"""

import os
import statistics
import subprocess
import sys
import tempfile

ROUNDS = 7
FIRST = (
    "import numpy as np, luenberger as lb\n"
    "A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], [[1, 0, 0], [0, 1, 0]]\n"
    "plant = lb.Plant(A, None, C, dt=1.0, Q=np.diag([0.0, 0, 1]),\n"
    "                 R=np.diag([0.25, 4]), P0=np.eye(3))\n"
    "lb.filter_data(plant, np.zeros((1000, 2)), backend={!r})\n"
)
CASES = {
    "import scipy.linalg, scipy.signal": "import scipy.linalg, scipy.signal",
    "import luenberger": "import luenberger",
    "import numba": "import numba",
    "first record, numpy": FIRST.format("numpy"),
    "first record, numba, warm": FIRST.format("numba"),
}


def seconds(code, folder):
    environment = os.environ | {"LUENBERGER_CACHE": folder}
    before = os.times()
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    after = os.times()
    user = after.children_user - before.children_user
    return user + after.children_system - before.children_system


def main():
    with tempfile.TemporaryDirectory() as folder:
        cold = seconds(FIRST.format("numba"), folder)
        print(f"{cold:6.2f} s  first record, numba, cold cache (once)")
        times = {name: [] for name in CASES}
        for _ in range(ROUNDS):
            for name, code in CASES.items():
                times[name].append(seconds(code, folder))
    for name, all_ in times.items():
        print(f"{statistics.median(all_):6.2f} s  {name}")


if __name__ == "__main__":
    main()
