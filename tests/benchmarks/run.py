"""Twelve rows of work beside other libraries and C: one run, ratios within a round.

    python tests/benchmarks/run.py                     all, into the README beside it
    python tests/benchmarks/run.py --only smoothing    these rows, printed only
    python tests/benchmarks/run.py --quick             short records, printed only

Nobody is timed who does not compute the same.  The contestants of a row take turns in
one process with one thread; processor time counts, so that a busy machine counts less.
"""

import argparse
import ctypes
import os
import re
import sys
import tempfile
import time
from functools import partial
from importlib.metadata import version
from pathlib import Path
from platform import machine, python_version
from subprocess import run as shell

for threads in ("OMP", "OPENBLAS", "NUMBA"):  # before NumPy is loaded
    os.environ[f"{threads}_NUM_THREADS"] = "1"
HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.append(str(HERE.parent / "support"))

import numpy as np  # noqa: E402
import peers  # noqa: E402
from judge.checkout import alone  # noqa: E402
from judge.timed import device, library, plant, record, simulated  # noqa: E402

import luenberger as lb  # noqa: E402

US = "luenberger"
COLUMNS = (
    US, "no cache", "exported C", "C by hand", "statsmodels", "FilterPy", "simdkalman",
)  # fmt: skip
PEERS = "numpy", "numba", "statsmodels", "filterpy", "simdkalman"
UNITS = {"ns": 1e9, "µs": 1e6, "ms": 1e3, "s": 1.0}


# -- our side: all calls of the library -----------------------------------------------


def filtered(one, y):
    return lb.Filter(one).run(y).x


def smoothed(one, y):
    return lb.Filter(one).smooth(y).x


def likelihood(one, y):
    return lb.Filter(one).log_likelihood(y)


def fitted(one, y):
    """The log likelihood that is reached."""
    return lb.fit_noise(one, y, Q="diagonal").log_likelihood


def errors(one, runs, steps):
    """Covariances of the errors and their standard errors, without instant 0."""
    observer = lb.kalman_filter(one, steps=steps)
    found = lb.monte_carlo(one, observer, runs=runs, steps=steps, seed=1)
    return found.covariance[1:], found.standard_error[1:]


FIRST = f"""
import sys
import numpy as np
A, C, y = np.triu(np.ones((3, 3))), np.eye(2, 3), np.zeros((1000, 2))
noises = dict(Q=np.diag([0.0, 0, 1]), R=np.diag([0.25, 4]), P0=np.eye(3))
sys.path.append({str(HERE)!r})
"""
OURS = """
import luenberger as lb
lb.Filter(lb.Plant(A, None, C, dt=1.0, **noises)).run(y)
"""
THEIRS = """
import peers
from types import SimpleNamespace
peers.{}(SimpleNamespace(A=A, C=C, **noises), y)
"""


# -- C --------------------------------------------------------------------------------


def by_hand(one, y):
    """`by_hand.c`, compiled for one size; it makes no tests of its data."""
    sizes = f"-DN={one.n}", f"-DP={one.p}"
    code = library(HERE / "by_hand.c", flags=sizes).filter
    found = np.empty((len(y), one.n))

    def over():
        x, P = np.zeros(one.n), one.P0.copy()
        arrays = one.A, one.C, one.Q, one.R, x, P, y, found
        code(*(ctypes.c_void_p(a.ctypes.data) for a in arrays), ctypes.c_long(len(y)))
        return found

    return over


COMPILED = {"exported C": device, "C by hand": by_hand}


# -- rows: {contestant: (a call, how much work it is)} --------------------------------


def same(who, found, wanted):
    if not np.abs(found - wanted).max() <= 1e-8 * np.abs(wanted).max():
        raise SystemExit(f"{who} computes something else; nothing was timed")


def part(who, y):
    """As much of a record as suits a contestant."""
    if who == "FilterPy":
        return y[: max(len(y) // 50, 200)]
    if who == "simdkalman":
        return y.reshape(-1, 200, y.shape[1])
    return y


def over_rows(runs, n, p, rows, gaps=0.0, exact=False):
    """A random plant and a record of it, for functions of both."""
    one, y = plant(n, p, exact), record(rows, p, gaps)
    found = {}
    for who, run in runs.items():
        start = COMPILED.get(who, partial(partial, run))
        same(who, start(one, y[:200])(), runs[US](one, y[:200]))
        given = part(who, y)
        found[who] = start(one, given), given.size // p
    return found


def calls(runs, count):
    """A record of 200 rows, so often."""
    one, y = plant(3, 2), record(200, 2)
    return {
        who: (lambda run=run: [run(one, y) for _ in range(count)], count)
        for who, run in runs.items()
    }


def fleet(records):
    """Many records of 250 rows; one row in ten is missing, in each another one."""
    one, y = plant(3, 2), record(250 * records, 2)
    y[np.random.default_rng(2).random(len(y)) < 0.1] = np.nan
    y = y.reshape(records, 250, 2)
    runs = {US: filtered, "simdkalman": peers.simdkalman}
    for who, run in runs.items():
        same(who, run(one, y[:8]), filtered(one, y[:8]))
    return {who: (partial(run, one, y), y.size // 2) for who, run in runs.items()}


def fit(rows):
    """statsmodels has to arrive where we do, and may not climb higher."""
    one, y = simulated(rows)
    runs = {US: fitted, "statsmodels": peers.statsmodels_fit}
    ours, theirs = (run(one, y) for run in runs.values())
    if not -1e-3 <= theirs - ours <= 1e-6:
        raise SystemExit(f"the fits end at {ours} and {theirs}; nothing was timed")
    return {who: (partial(run, one, y), 1) for who, run in runs.items()}


def monte_carlo(runs, steps):
    """Covariances of errors that agree within six of their standard errors."""
    one, few = plant(3, 2), min(runs, 1000)  # more do not make the peer faster
    (P, s), (Q, t, _) = errors(one, 500, 20), peers.simdkalman_errors(one, 500, 20)
    if (np.abs(P - Q) > 6 * np.hypot(s, t)).any():
        raise SystemExit("the statistics disagree; nothing was timed")
    return {
        US: (partial(errors, one, runs, steps), runs * steps),
        "simdkalman": (partial(peers.simdkalman_errors, one, few, steps), few * steps),
    }


def processes():
    """New processes: the import of a library and a first record of 1000 rows."""
    start, kept = partial(alone, lib=ROOT / "lib"), tempfile.mkdtemp()
    ours, found = FIRST + OURS, {}
    found[US] = partial(start, ours, cache=kept), 1
    found["no cache"] = (lambda: start(ours, cache=tempfile.mkdtemp()), 1)
    for who in ("statsmodels", "FilterPy", "simdkalman"):
        found[who] = partial(start, FIRST + THEIRS.format(who.lower()), cache=kept), 1
    return found


def rows(short):
    """{name: (unit, what makes its contestants)}; `short` divides lengths by ten."""
    few = 10 if short else 1
    filters = {
        US: filtered, "C by hand": by_hand, "statsmodels": peers.statsmodels,
        "FilterPy": peers.filterpy, "simdkalman": peers.simdkalman,
    }  # fmt: skip
    smoothers = {
        US: smoothed, "statsmodels": peers.statsmodels_smoothed,
        "FilterPy": peers.filterpy_smoothed, "simdkalman": peers.simdkalman_smoothed,
    }  # fmt: skip
    likelihoods = {US: likelihood, "statsmodels": peers.statsmodels_likelihood}
    called = {who: run for who, run in filters.items() if who not in COMPILED}
    gaps = {who: filters[who] for who in (US, "statsmodels")}
    of = partial(partial, over_rows)
    return {
        "filter, n = 3": (
            "ns", of(filters | {"exported C": device}, 3, 2, 200_000 // few)
        ),
        "filter, n = 10": ("ns", of(filters, 10, 4, 40_000 // few)),
        "filter, n = 30": ("ns", of(filters, 30, 6, 6000 // few)),
        "filter, 10 % gaps, n = 3": ("ns", of(gaps, 3, 2, 200_000 // few, 0.1)),
        "filter, one exact output, n = 3": (
            "ns", of(filters, 3, 2, 200_000 // few, exact=True)
        ),
        "smoothing, n = 3": ("ns", of(smoothers, 3, 2, 100_000 // few)),
        "likelihood, n = 3": ("ns", of(likelihoods, 3, 2, 200_000 // few)),
        "fleet with gaps, n = 3": ("ns", partial(fleet, 1000 // few)),
        "Monte Carlo, n = 3": ("ns", partial(monte_carlo, 10_000 // few, 1000 // few)),
        "fit of noise, n = 3": ("ms", partial(fit, 2000)),
        "call on 200 rows, n = 3": ("µs", partial(calls, called, 50)),
        "first record of a process, n = 3": ("s", processes),
    }  # fmt: skip


# -- times and tables -----------------------------------------------------------------


def clock():
    """Processor seconds of this process and of those that it started and has ended."""
    return time.process_time() + sum(os.times()[2:4])


def timed(contestants, rounds):
    """{contestant: seconds per piece of work in each round}.

    Each runs twice in a row, and the second time counts: so nobody pays for memory
    that the one before has given back to the system.
    """
    times = {who: [] for who in contestants}
    for _ in range(rounds):
        for who, (call, work) in contestants.items():
            call()
            start = clock()
            call()
            times[who].append((clock() - start) / work)
    return times


def rounded(value):
    """Two digits, three from 100 on, never with an exponent."""
    if value >= 100:
        return f"{float(f'{value:.3g}'):.0f}"
    return f"{float(f'{value:.2g}'):.12g}"


def cells(times, unit):
    """Our time in bold; of others the median ratio to ours in a round, quartiles."""
    for who in COLUMNS:
        if who == US:
            yield f"**{rounded(np.median(times[US]) * UNITS[unit])} {unit}**"
        elif who in times:
            ratios = np.array(times[who]) / times[US]
            low, middle, high = map(rounded, np.quantile(ratios, [0.25, 0.5, 0.75]))
            yield middle if low == high else f"{middle} ({low}-{high})"
        else:
            yield ""


def table(lines):
    """Markdown of {row: its cells}, without columns that are empty."""
    there = [any(column) for column in zip(*lines.values())]
    head = {"": COLUMNS, "---": ["---"] * len(COLUMNS)}
    return "\n".join(
        f"| {' | '.join([name, *(c for c, some in zip(line, there) if some)])} |"
        for name, line in (head | lines).items()
    )


def versions():
    """One sentence on what ran."""
    command = ["gcc", "-dumpfullversion"]
    gcc = shell(command, capture_output=True, text=True, check=True).stdout.strip()
    used = [f"{peer} {version(peer)}" for peer in PEERS]
    used += [f"Python {python_version()}", f"gcc {gcc}"]
    return f"With {', '.join(used)}, on {machine()}."


def put(path, text):
    """Replace what stands between two comments."""
    given = path.read_text(encoding="utf-8")
    pattern = r"(<!-- speed -->\n).*?(<!-- end -->)"
    new, count = re.subn(pattern, lambda m: f"{m[1]}{text}\n{m[2]}", given, flags=re.S)
    if count != 1:
        raise SystemExit(f"{path} needs one <!-- speed --> and <!-- end -->")
    path.write_text(new, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="short records, printed")
    parser.add_argument("--only", default="", help="rows whose name has these words")
    parser.add_argument("--rounds", type=int, default=9, help="turns of each")
    given = parser.parse_args()
    lines = {}
    with tempfile.TemporaryDirectory() as tempfile.tempdir:
        for name, (unit, made) in rows(given.quick).items():
            if given.only in name:
                lines[name] = list(cells(timed(made(), given.rounds), unit))
                print(name, *filter(None, lines[name]), sep="  ", flush=True)
    if given.quick or given.only:
        print(table(lines))
    else:
        put(HERE / "README.md", f"{table(lines)}\n\n{versions()}")


if __name__ == "__main__":
    main()
