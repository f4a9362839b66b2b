"""What do uneven instants cost, where each row of a record has a period of its own?

`sampling.discretise`, beside SciPy's `expm` of the same stacks, which takes one matrix
after the other; and `filter_data` of such a record, with a fifth of the readings
missing and without, beside the filter of the sampled plant.

Run:  OMP_NUM_THREADS=1 python benchmarks/uneven.py [--quick]
"""

import sys

import numpy as np
import scipy.linalg
from common import in_turns, line, plant, record, same

import luenberger as lb
from luenberger.numeric.linalg import symmetrise

SIZES = [(3, 2, 20_000), (6, 3, 10_000), (10, 4, 5_000)]
ROUNDS = 7


def continuous(n, p):
    """A stable plant with an input, whose rates are about one."""
    given, B = plant(n, p), np.ones((n, 1))
    return lb.Plant(given.A - np.eye(n), B, given.C, Q=given.Q, R=given.R, P0=given.P0)


def one_by_one(plant, T):
    """Van Loan's exponentials by SciPy; norms are small, so nothing is doubled."""
    n = plant.n
    held = np.block([[plant.A, plant.B], [np.zeros((1, n + 1))]])
    block = np.block([[-plant.A, plant.Q], [np.zeros((n, n)), plant.A.T]])
    A = scipy.linalg.expm(held * T[:, None, None])
    E = scipy.linalg.expm(block * T[:, None, None])
    return A[:, :n, :n], symmetrise(E[:, n:, n:].mT @ E[:, :n, n:])


def records(quick=False):
    """Two rows a size, microseconds a period, or a row of the record."""
    for n, p, rows in SIZES[: 2 if quick else None]:
        one, rng = continuous(n, p), np.random.default_rng(1)
        rounds = 3 if quick else ROUNDS
        t = np.cumsum(rng.uniform(0.02, 0.1, rows))
        T = np.diff(t, prepend=0.0)
        found = lb.sampling.discretise(one, T)
        for ours, theirs in zip((found.A[:-1], found.Q[:-1]), one_by_one(one, T)):
            same("discretise", ours, theirs)
        calls = {
            "NumPy": lambda one=one, T=T: lb.sampling.discretise(one, T),
            "SciPy": lambda one=one, T=T: one_by_one(one, T),
        }
        work = dict.fromkeys(calls, rows)
        times = in_turns(calls, rounds, work)
        yield record("uneven periods", f"n = {n}", "us", times, 1e6)
        yield filtered(one, found, t, rounds, f"n = {n}, p = {p}")


def filtered(one, sampled, t, rounds, case):
    """Records at uneven instants, compiled."""
    rng = np.random.default_rng(2)
    y = rng.normal(size=(len(t), one.p))
    gaps = np.where(rng.random(y.shape) < 0.2, np.nan, y)

    def run(plant, y, **options):
        return lambda: lb.filter_data(plant, y, backend="numba", **options)

    calls = {
        "numba": run(one, gaps, time=t),
        "no gaps": run(one, y, time=t),
        "sampled before, gaps": run(sampled, gaps),
        "sampled before, no gaps": run(sampled, y),
    }
    for call in calls.values():
        call()
    times = in_turns(calls, rounds, dict.fromkeys(calls, len(t)))
    return record("uneven record", case, "us", times, 1e6)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
