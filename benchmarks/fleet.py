"""Many records of one plant, beside simdkalman, which filters many series at once.

Once without gaps, where all records share a covariance, and once with one row in twenty
missing, where each has its own: simdkalman drops a row if one entry is missing.  Ours
is timed as `filter_data` is called: y comes a record after the other, is copied into
panels, and the results are copied back.  "numba" returns new arrays.  "to a function"
hands parts of the records to a function, in memory that is used again, and the function
keeps the last estimate of each record.  "panels" is the compiled code alone with these
copies, into memory that has been written before; "no copies" is the same code, which
copies only the first rows.

Run:  OMP_NUM_THREADS=1 python benchmarks/fleet.py [--quick]
"""

import re
import sys

import numpy as np
import simdkalman
from common import first_prior, in_turns, line, plant, record, same

import luenberger as lb
from luenberger.fleets import filter_block, given_gain, own_gain
from luenberger.fleets.fleet import Fleet
from luenberger.kernels import cache
from luenberger.kernels.panels import in_panels
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled_pass import SettledPass

SIZES = [(3, 2), (6, 3)]
RECORDS, ROWS, PEER_ROWS, ROUNDS = 2048, 250, 25, 7


def peer(plant, y):
    """simdkalman, from our start carried to the first sample."""
    model = simdkalman.KalmanFilter(
        state_transition=plant.A, process_noise=plant.Q, observation_model=plant.C,
        observation_noise=plant.R,
    )  # fmt: skip
    found = model.compute(
        y, 0, initial_value=np.zeros(plant.n), initial_covariance=first_prior(plant),
        smoothed=False, filtered=True, states=True, observations=False,
    )  # fmt: skip
    return found.filtered.states.mean


def ours(plant, y, backend):
    return lb.filter_data(plant, y, backend=backend).x


def latest(plant, y, **how):
    """The last estimate of each record, from parts that a function gets."""
    found = np.empty((len(y), plant.n))

    def keep(first, part):
        found[first : first + len(part)] = part.x[:, -1]

    lb.filter_data(plant, y, into=keep, reuse=True, **how)
    return found


def panels(plant, y, gaps):
    """The compiled code alone: with its copies, and without; arrays are there."""
    way = SettledPass(Settings(plant, 0), None)
    fleet, calls = Fleet(way, np.zeros(0), y.shape[1], compile=True), []

    def noted(*asked):
        run = in_panels(*asked)

        def over(**arrays):
            calls.append((run, arrays))
            run(**arrays)

        return over

    module = own_gain if gaps else given_gain
    module.in_panels = noted
    filter_block(fleet, y, np.zeros((*y.shape[:2], 0)))
    module.in_panels = in_panels
    run, arrays = calls[-1]
    bare = without(run)
    return lambda: run(**arrays), lambda: bare(arrays)


def without(run):
    """The same code, which copies nothing but the first rows."""
    text = re.sub(r"( to_(lanes|rows)\()", r" if first == 0:\1", run.source)
    bare = cache.compiled(text, run.types, exact=True)
    return lambda arrays: bare(*(arrays[name] for name in run.names))


def cases(one, records):
    """(name, records) without gaps and with gaps in each."""
    rng = np.random.default_rng(1)
    y = rng.normal(size=(records, ROWS, one.p))
    yield "no gaps", y
    yield "gaps", np.where(rng.random((*y.shape[:2], 1)) < 0.05, np.nan, y)


def records(quick=False):
    """One row a size and kind, nanoseconds a step of one record."""
    for n, p in SIZES:
        one = plant(n, p)
        for kind, y in cases(one, RECORDS // 8 if quick else RECORDS):
            some = np.ascontiguousarray(y[:, :PEER_ROWS])
            theirs = peer(one, some[:40])
            same("numba", ours(one, some[:40], "numba"), theirs)
            mine = latest(one, some[:40], backend="numba")
            same("to a function", mine, theirs[:, -1])
            copied, bare = panels(one, y, kind == "gaps")
            runs = {
                "numba": lambda Y=y, one=one: ours(one, Y, "numba"),
                "to a function": lambda Y=y, one=one: latest(one, Y, backend="numba"),
                "panels": copied,
                "panels, no copies": bare,
                "simdkalman": lambda Y=some, one=one: peer(one, Y),
            }
            work = dict.fromkeys(runs, y[..., 0].size)
            work["simdkalman"] = some[..., 0].size
            times = in_turns(runs, 3 if quick else ROUNDS, work)
            yield record(f"many records, {kind}", f"n = {n}, p = {p}", "ns", times, 1e9)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
