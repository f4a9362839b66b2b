"""Damage the library one fault at a time, and see whether a test notices.

    .venv/bin/python tests/mutation --faults 40 --seed 1
    .venv/bin/python tests/mutation kernels export --faults 20
    .venv/bin/python tests/mutation numeric/linalg.py:65
    .venv/bin/python tests/mutation --package matrixproof checker

A PLACE is a room, a file, or a line of a file; of a line, every fault is tried.  All
runs in a copy of the tree.  The first run takes as long as the test suite on one core,
to learn which function each test enters; later ones ask again only what has changed.
Stop it with Ctrl-C; --from goes on with the same sample.  A fault survives that none of
the nearest tests notices within --budget seconds: try it again with more of them, by
--only and its number.  It ends with 1 if a fault survived.
"""

import argparse
import gc
import importlib
import io
import os
import random
import sys
import tempfile
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest
from faults import faults
from nearest import OPTIONS, Nearest, collect, pytest_main, test_files
from trees import Child, Tree

ROOMS = "kernels papers numeric certificate recursion analysis run export ledger"
PROOFS = {"derivation"}  # claims are damaged by tests of their own
PRELOAD = "numpy scipy.linalg scipy.optimize scipy.sparse.linalg sympy numba "
PRELOAD += "hypothesis.strategies hypothesis.internal.conjecture.engine"
PATIENCE = 5  # a run may take this many times the seconds that its tests took


@dataclass
class Verdict:
    """How one fault fared: `by` is the test that noticed it, or how the run ended."""

    by: str | None
    ran: int
    near: int


class Chosen:
    """A pytest plugin: the chosen tests only, the quickest first; who failed first."""

    def __init__(self, tests):
        self.tests, self.ran, self.failed = tests, 0, None

    def pytest_collection_modifyitems(self, items):
        items[:] = [one for one in items if one.nodeid in self.tests]
        items.sort(key=lambda one: self.tests[one.nodeid])

    def pytest_collectreport(self, report):
        if report.failed:  # the file cannot be read
            self.failed = self.failed or report.nodeid

    def pytest_runtest_logreport(self, report):
        self.ran += report.when == "call"
        if report.failed:
            self.failed = self.failed or report.nodeid


def run_tests(tree, chosen):
    """(the first test that fails or None, how many ran), in a child."""
    tree.enter()
    ran = 0
    for path, tests in chosen.items():
        plugin = Chosen(tests)
        status = pytest_main(tree, path, plugin, options=["-x"])
        ran += plugin.ran
        if plugin.failed or status == pytest.ExitCode.INTERRUPTED:
            return plugin.failed or path, ran
        if status in (pytest.ExitCode.INTERNAL_ERROR, pytest.ExitCode.USAGE_ERROR):
            return path, ran
    return None, ran


class Mutation:
    """Tries faults in a tree, one after the other."""

    def __init__(self, tree, nearest, budget, patience):
        self.tree, self.nearest = tree, nearest
        self.budget, self.patience, self.sound = budget, patience, {}

    def try_one(self, fault):
        while True:
            chosen, near = self.nearest(fault, self.budget)
            by, ran = self._damaged(fault, chosen)
            if by is None or "::" not in by or self._is_sound(by, chosen):
                return Verdict(by, ran, near)
            self._forget(by)

    def _damaged(self, fault, chosen):
        path = self.tree.root / fault.path
        source, times = path.read_bytes(), path.stat()
        try:
            path.write_bytes(fault.damaged(source))
            os.utime(path, (times.st_atime, times.st_mtime + 3600))  # no old bytecode
            return self._run(chosen)
        finally:
            path.write_bytes(source)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def _run(self, chosen):
        seconds = sum(sum(tests.values()) for tests in chosen.values())
        seconds += sum(self.nearest.collected[path]["seconds"] for path in chosen)
        limit = self.patience + PATIENCE * seconds
        task = lambda: run_tests(self.tree, chosen)  # noqa: E731
        child = Child(task, self.tree.folder, limit).wait()
        return child.result or (child.ended, 0)

    def _is_sound(self, test, chosen):
        """Whether a test passes without a fault, as it must to have noticed one."""
        if test not in self.sound:
            alone = {p: {test: 0.0} for p, tests in chosen.items() if test in tests}
            self.sound[test] = self._run(alone) == (None, 1)
        return self.sound[test]

    def _forget(self, test):
        print(f"{test} fails without a fault: not used", flush=True)
        for answer in self.nearest.collected.values():
            answer["tests"].pop(test, None)


def all_places(tree, wanted):
    """Lists of faults, one for each place that `wanted` names; else for all."""
    found = []
    for path in sorted(tree.package.rglob("*.py")):
        inside = path.relative_to(tree.package)
        lines = [_line_of(one, inside) for one in wanted] if wanted else [0]
        if not any(line is not None for line in lines):
            continue
        if PROOFS & set(inside.parts) and "algebra" not in inside.parts:
            continue
        source = path.read_bytes()
        for place in faults(path.relative_to(tree.root).as_posix(), source):
            if any(line in (0, place[0].line) for line in lines):
                found.append(place)
    return found


def _line_of(wanted, path):
    """The line that is meant in a file, 0 for the whole file, None for another file."""
    name, _, line = wanted.partition(":")
    whole = path.as_posix()
    inside = name.removesuffix(".py") in path.with_suffix("").parts
    if inside or f"/{whole}".endswith(f"/{name}"):
        return int(line or 0)
    return None


def sample(places, number, seed, whole):
    """`number` faults of different places, or every fault of few places."""
    draw = random.Random(seed)
    if whole:
        return [one for place in places for one in place]
    return [draw.choice(p) for p in draw.sample(places, min(number, len(places)))]


def arguments(argv):
    parser = argparse.ArgumentParser(
        "tests/mutation",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    add = parser.add_argument
    add("places", nargs="*", metavar="PLACE", help="what to damage")
    add("--faults", type=int, default=40, help="how many (40)")
    add("--seed", type=int, default=1, help="of the sample (1)")
    add("--from", type=int, default=1, dest="first", help="the first to try (1)")
    add(
        "--only", type=int, nargs="+", metavar="NUMBER", help="of the sample, no others"
    )
    add("--part", default="1/1", help="1/2 and 2/2 share a sample between two commands")
    add("--tests", nargs="+", metavar="FILE", help="run no tests but those of these")
    add("--budget", type=float, default=30, help="seconds of tests for a fault (30)")
    add("--patience", type=float, default=60, help="seconds more, until it hangs (60)")
    add("--fresh", action="store_true", help="learn anew what the tests enter")
    add("--repository", type=Path, default=Path(__file__).parents[2])
    add("--package", default="luenberger")
    add("--preload", default=PRELOAD, help=argparse.SUPPRESS)
    return parser.parse_args(argv)


def preload(names, folder):
    """Import here what every child needs: it is forked with all of it."""
    for name in names:
        with suppress(ImportError):
            importlib.import_module(name)
    nothing = folder / "test_nothing.py"
    nothing.write_text("def test_nothing():\n    pass\n")
    with redirect_stdout(io.StringIO()):  # pytest and its plugins
        pytest.main([*OPTIONS, "--rootdir", str(folder), str(nothing)])
    gc.freeze()  # else every child goes through all of it


def main(argv=None):
    asked = arguments(argv)
    with tempfile.TemporaryDirectory(prefix="mutation-") as folder:
        preload(asked.preload.split(), Path(folder))
        tree = Tree(asked.repository, Path(folder), asked.package)
        rooms = ROOMS.split() if asked.package == "luenberger" else []
        places = all_places(tree, asked.places or rooms)
        if not places:
            raise SystemExit(f"nothing to damage in {' '.join(asked.places)}")
        whole = any(":" in one for one in asked.places)
        chosen = sample(places, asked.faults, asked.seed, whole)
        say = lambda text: print(text, file=sys.stderr, flush=True)  # noqa: E731
        nearest = Nearest(
            tree, collect(tree, test_files(tree, asked.tests), asked.fresh, say)
        )
        mutation = Mutation(tree, nearest, asked.budget, asked.patience)
        part, parts = map(int, asked.part.split("/"))
        numbered = list(enumerate(chosen, 1))[asked.first - 1 :]
        if asked.only:
            numbered = [one for one in numbered if one[0] in asked.only]
        numbered = numbered[part - 1 :: parts]
        survivors = report(tree, numbered, mutation.try_one, len(places))
    return 1 if survivors else 0


def report(tree, numbered, try_one, places):
    """Try them, say how each fared, and return how many survived."""
    tried = hung = survived = 0
    try:
        for number, fault in numbered:
            verdict = try_one(fault)
            tried, hung = tried + 1, hung + (verdict.by == "hung")
            place = f"{number:4} {fault.path}:{fault.line} {fault.where or fault.name}"
            if verdict.by:
                print(f"{place}: {verdict.by}", flush=True)
                continue
            survived += 1
            old, new = fault.shown((tree.root / fault.path).read_bytes())
            print(f"{place}: SURVIVED {verdict.ran} of {verdict.near} tests near it")
            print(f"     - {old}\n     + {new}", flush=True)
    except KeyboardInterrupt:
        print(f"interrupted; --from {number} goes on")
    if tried:
        share = 100 * (tried - survived) / tried
        print(
            f"noticed {tried - survived} of {tried} ({share:.0f} %), {hung} of them "
            f"because tests hung; drawn from {places} places"
        )
    return survived
