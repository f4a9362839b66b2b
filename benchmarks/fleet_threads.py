"""Many records on one thread and on two, by the clock.

What is compared is time on the wall, as threads share no processor time; so nothing
else may run on the machine, and it needs two cores.  "to a function" are parts that a
function gets in memory that is used again.

Run:  OMP_NUM_THREADS=1 python benchmarks/fleet_threads.py [--quick]
"""

import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from common import line, plant, record
from fleet import SIZES, cases, latest

import luenberger as lb

RECORDS, ROUNDS = 8192, 9


def records(quick=False):
    """One row a size and kind, nanoseconds a step of one record."""
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(2) as two:
        pools = {"two threads": two, "one thread": one}
        for n, p in SIZES:
            model = plant(n, p)
            for kind, y in cases(model, RECORDS // 8 if quick else RECORDS):
                for where in ("", ", to a function"):
                    runs = {
                        name: lambda y=y, pool=pool, where=where, model=model: run(
                            model, y, pool, where
                        )
                        for name, pool in pools.items()
                    }
                    times = by_the_clock(runs, 3 if quick else ROUNDS, y[..., 0].size)
                    case = f"n = {n}, p = {p}"
                    yield record(f"on threads{where}, {kind}", case, "ns", times, 1e9)


def run(model, y, executor, where):
    how = dict(backend="numba", executor=executor)
    if where:
        latest(model, y, **how)
    else:
        lb.filter_data(model, y, **how)


def by_the_clock(runs, rounds, work):
    """Seconds of each contestant in each round; the second of two in a row counts."""
    times = {name: [] for name in runs}
    for _ in range(rounds):
        for name, once in runs.items():
            once()
            begin = time.perf_counter()
            once()
            times[name].append((time.perf_counter() - begin) / work)
    return {name: np.array(found) for name, found in times.items()}


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
