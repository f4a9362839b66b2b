"""Every benchmark in one run: results.json and the tables of both READMEs.

    python benchmarks/run.py                everything, about half an hour
    python benchmarks/run.py staircase      this one anew; the others as they are stored
    python benchmarks/run.py --quick        small sizes, few rounds, printed only

Contestants take turns in one process with one thread, and what is compared is
processor time.  `results.json` holds every median with its ratio to ours in the same
round (quartiles), the versions of all peers, and the targets.
"""

import argparse
import json
import os
import re
import shutil
import sys
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from platform import machine, python_version
from subprocess import run

os.environ["OMP_NUM_THREADS"] = "1"  # before NumPy is loaded

HERE = Path(__file__).parent
RESULTS = HERE / "results.json"
SCRIPTS = (
    "first_call", "filter_step", "constant_gain", "c_export", "monte_carlo",
    "staircase", "optimal_projection", "noise_fit", "slingen", "uneven",
    "fleet", "fleet_threads", "settled_filter", "likelihood",
    "known_state",
)  # fmt: skip
OWN_TABLES = (
    "uneven", "settled_filter", "likelihood", "known_state", "slingen",
    "fleet_threads",
)  # fmt: skip
PEERS = (
    "numpy", "scipy", "numba", "statsmodels", "filterpy", "pykalman", "simdkalman",
    "control", "slycot",
)  # fmt: skip
COLUMNS = (
    "numba", "to a function", "panels", "NumPy", "exported C", "C by hand",
    "statsmodels", "FilterPy", "pykalman", "simdkalman", "python-control", "SciPy",
)  # fmt: skip
SMALL, TEN = "filter step, n = 3, p = 2", "filter step, n = 10, p = 4"
WIDE = "exported C beside SLinGen, n = p = "
GENERATED = (
    (4, "exported C", 0.9), (12, "exported C", 0.9), (20, "exported C", 1.25),
    (28, "exported C", 1.25), (52, "exported C", 1.25),
    *((n, "exported C, 512 bits", 0.9) for n in (4, 12, 20, 28, 52)),
)  # fmt: skip
FLEET, BARE, PARTS = "many records, ", "panels, no copies", "to a function"
SIZES = "n = 3, p = 2", "n = 10, p = 4", "n = 30, p = 6", "n = 100, p = 10"
SETTLED = (
    ("n = 3, p = 2, 1000000 rows", 50), ("n = 10, p = 4, 300000 rows", 50),
    ("n = 10, p = 4, 1000000 rows", 50), ("n = 30, p = 6, 100000 rows", 30),
    ("n = 100, p = 10, 40000 rows", 8),
)  # fmt: skip
HARDEST = (
    "n = 6, p = 4, 50000 rows", "n = 6, p = 1, 10000 rows", "n = 10, p = 1, 2000 rows",
)  # fmt: skip
FLEETS = (
    ("no gaps, n = 3, p = 2", 250), ("gaps, n = 3, p = 2", 80),
    ("no gaps, n = 6, p = 3", 150), ("gaps, n = 6, p = 3", 20),
)  # fmt: skip
TARGETS = (  # row; over / under; asked
    (SMALL, "statsmodels", "numba", "at least", 100),
    (SMALL, "FilterPy", "numba", "at least", 1500),
    (SMALL, "numba", "C by hand", "at most", 1.5),
    (TEN, "statsmodels", "numba", "at least", 5),
    (TEN, "numba", "C by hand", "at most", 1.6),
    ("filter step, n = 30, p = 6", "statsmodels", "numba", "at least", 2),
    ("filter step, n = 100, p = 10", "statsmodels", "numba", "at least", 2),
    *((f"filter step, {k}", "numba", "exported C", "at most", 2) for k in SIZES),
    ("Monte Carlo of 10000 runs, n = 3, p = 2", "simdkalman", "numba", "at least", 20),
    ("Monte Carlo, kernels alone, n = 3, p = 2", "simdkalman", "numba", "at least", 20),
    ("exported C, filter, n = 3, p = 2", "exported C", "C by hand", "at most", 1.2),
    ("exported C, filter, n = 10, p = 4", "exported C", "C by hand", "at most", 1.2),
    *((f"{WIDE}{n}", who, "SLinGen", "at most", ask) for n, who, ask in GENERATED),
    ("fit of noise, 10000 rows, n = 3, p = 1", "statsmodels", "numba", "at least", 10),
    ("fit of noise, 10000 rows, n = 3, p = 2", "statsmodels", "numba", "at least", 10),
    ("first record, n = 3, warm cache", "numba", None, "at most", 1.5),
    ("import", "NumPy", "SciPy", "at most", 1.3),
    *((f"{FLEET}{k}", "simdkalman", "numba", "at least", ask) for k, ask in FLEETS),
    *((f"{FLEET}{k}", "simdkalman", PARTS, "at least", ask) for k, ask in FLEETS),
    *((f"{FLEET}{k}", "simdkalman", BARE, "at least", ask) for k, ask in FLEETS),
    *(
        (f"on threads{to}, {k}", "one thread", "two threads", "at least", 1.7)
        for to in ("", ", to a function")
        for k, _ in FLEETS
    ),
    *(
        (f"settled filter, {k}", peer, "numba", "at least", ask)
        for k, ask in SETTLED
        for peer in ("statsmodels", "statsmodels, lean")
    ),
    *(
        (f"likelihood, {k}, gaps, unknown start", "gradient", "filter", "at most", 3)
        for k in HARDEST
    ),
    *(
        (f"a known state, {way}, {k}", "known", "none", "at most", 1.2)
        for k in SIZES[:3]
        for way in ("numba", "exported C")
    ),
    *(
        (f"a known state, numba, {k}", kind, "none", "at most", 1.2)
        for kind in ("exact", "told", "silent")
        for k in SIZES[:3]
    ),
)


SHORT = (  # rows of the table in the README of the repository
    "first record, n = 3, warm cache", SMALL, TEN, "exported C, filter, n = 3, p = 2",
    "Monte Carlo of 10000 runs, n = 3, p = 2", "fit of noise, 10000 rows, n = 3, p = 2",
)  # fmt: skip


def name(one):
    return ", ".join(filter(None, (one["row"], one["case"])))


def versions():
    found = {peer: version(peer) for peer in PEERS} | {"python": python_version()}
    if shutil.which("gcc"):
        gcc = run(["gcc", "-dumpfullversion"], capture_output=True, text=True)
        found["gcc"] = gcc.stdout.strip()
    return found | {"machine": machine()}


def checked(records):
    """The targets, each with what was found; medians over medians."""
    by_name = {name(one): one["contestants"] for one in records}
    for row, over, under, bound, asked in TARGETS:
        who = by_name.get(row, {})
        if not {over, under or over} <= set(who):
            continue
        found = who[over]["median"] / (who[under]["median"] if under else 1)
        met = found >= asked if bound == "at least" else found <= asked
        over = f"{over} / {under}" if under else f"{over}, seconds"
        yield {
            "row": row, "ratio": over, "asked": f"{bound} {asked}",
            "found": float(f"{found:.3g}"), "met": met,
        }  # fmt: skip


def rounded(value):
    """Two digits, three from 100 on, never with an exponent."""
    if value >= 100:
        return f"{float(f'{value:.3g}'):.0f}"
    return f"{float(f'{value:.2g}'):.12g}"


def cell(one, column):
    """The time of ours in bold; of others the ratio to it and its quartiles."""
    who = one["contestants"].get(column)
    if who is None:
        return ""
    if column == next(iter(one["contestants"])):
        return f"**{rounded(who['median'])} {one['unit']}**"
    low, middle, high = map(rounded, who["ratios"])
    return middle if low == high else f"{middle} ({low}-{high})"


def table(records, columns=COLUMNS):
    there = {who for one in records for who in one["contestants"]}
    columns = [column for column in columns if column in there]
    rows = [["", *columns], ["---"] * (len(columns) + 1)]
    rows += [[name(one), *(cell(one, c) for c in columns)] for one in records]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def own(records):
    """The table of one script, whose contestants are no peers but ways to do it."""
    columns = dict.fromkeys(who for one in records for who in one["contestants"])
    return table(records, tuple(columns))


def targets(found):
    rows = [["asked for", "", "asked", "found", "met"], ["---"] * 5]
    for one in found:
        met = "yes" if one["met"] else "no"
        rows.append(
            [one["row"], one["ratio"], one["asked"], f"{one['found']:.3g}", met]
        )
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def put(path, mark, text):
    """Replace what stands between two comments."""
    given = path.read_text(encoding="utf-8")
    pattern = rf"(<!-- {mark} -->\n).*?(<!-- end -->)"
    new, count = re.subn(
        pattern, lambda m: f"{m[1]}{text}\n{m[2]}", given, count=1, flags=re.S
    )
    if not count:
        raise SystemExit(f"{path.name} has no <!-- {mark} --> and <!-- end -->")
    path.write_text(new, encoding="utf-8")


def measured(script, quick, kernels):
    line = import_module("common").line
    found = []
    more = {"kernels": kernels} if script == "slingen" else {}
    for one in import_module(script).records(quick, **more):
        found.append(one)
        print(line(one), flush=True)
    return found


def stored(now):
    """What was measured before, with the same versions of everything."""
    if not RESULTS.exists():
        return {}
    before = json.loads(RESULTS.read_text(encoding="utf-8"))
    return before["records"] if before["versions"] == now else {}


def write(now, by_script):
    """The results, and the tables in both READMEs."""
    ordered = {script: by_script[script] for script in SCRIPTS if script in by_script}
    records = [one for found in ordered.values() for one in found]
    found = list(checked(records))
    what = {"versions": now, "targets": found, "records": ordered}
    RESULTS.write_text(json.dumps(what, indent=1) + "\n", encoding="utf-8")
    beside = [
        one for script, ones in ordered.items() if script not in OWN_TABLES
        for one in ones
    ]  # fmt: skip
    put(HERE / "README.md", "speed", table(beside))
    for script in filter(ordered.get, OWN_TABLES):
        put(HERE / "README.md", script, own(ordered[script]))
    put(HERE / "README.md", "targets", targets(found))
    short = [one for one in records if name(one) in SHORT]
    put(HERE.parent / "README.md", "speed", table(short))


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--kernels", type=Path, help="SLinGen's, see slingen.py")
    parser.add_argument("scripts", nargs="*", default=SCRIPTS, metavar="SCRIPT")
    given = parser.parse_args(arguments)
    if unknown := set(given.scripts) - set(SCRIPTS):
        parser.error(f"no script {unknown.pop()!r}; there are {', '.join(SCRIPTS)}")
    now, records = versions(), []
    for script in given.scripts:
        records += (found := measured(script, given.quick, given.kernels))
        if given.quick:
            print(f"\n{own(found)}\n")
        if not given.quick:  # what is measured is kept if a later script fails
            write(now, stored(now) | {script: found})
    print(f"\n{targets(checked(records))}")


if __name__ == "__main__":
    main(sys.argv[1:])
