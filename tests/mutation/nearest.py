"""Which tests come near a fault: those that reach its lines, the quickest first.

The suite runs once, a file at a time, and each file's answer is kept outside the tree
until that file changes.  A stale answer costs time or a test; it cannot make a fault
count as noticed, since the test that notices is tried without the fault as well.
"""

import ast
import hashlib
import json
import os
import re
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from reach import Noting, entered, in_subprocesses, named, runs
from trees import Child

OPTIONS = "-n 0 -q -p no:cacheprovider -m".split() + ["not (browser or course or site)"]
LONGEST = 1200  # seconds that the tests of one file may take
NOTES = (Path(__file__).parent / "reach.py").read_bytes()


class Collector:
    """A pytest plugin: of each test its seconds, whether it passed, what it entered.

    A process that a test starts leaves a file in `folder`.
    """

    def __init__(self, folder):
        self.folder, self.tests, self.fixtures = Path(folder), {}, {}
        self.head, self.began, self.seconds = set(), time.perf_counter(), 0.0

    def take(self):
        found = entered.copy()
        entered.clear()
        for path in self.folder.glob("*.txt"):
            found.update(path.read_text(encoding="utf-8").splitlines())
            path.unlink()
        return found

    def pytest_collection_finish(self):
        self.head = self.take()
        self.seconds = time.perf_counter() - self.began

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef):
        before = entered.copy()
        entered.clear()
        try:
            return (yield)
        finally:
            known = self.fixtures.setdefault(fixturedef, set())
            known |= self.take()
            entered.update(before)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        self.passed, start = True, time.perf_counter()
        result = yield
        found = self.take()
        for definitions in item._fixtureinfo.name2fixturedefs.values():
            for one in definitions:
                found |= self.fixtures.get(one, set())
        seconds = time.perf_counter() - start
        self.tests[item.nodeid] = dict(
            seconds=round(seconds, 3), passed=self.passed, entered=sorted(found)
        )
        return result

    def pytest_runtest_logreport(self, report):
        if report.failed or report.skipped:
            self.passed = False


def pytest_main(tree, path, *plugins, options=()):
    """pytest on one file, in this process, which must be a child."""
    here = ["--rootdir", str(tree.root), "--basetemp", str(tree.folder / "tmp")]
    return pytest.main([*OPTIONS, *here, *options, str(path)], plugins=list(plugins))


def test_files(tree, only=None):
    """Test files and modules with examples, by path in the tree; or those in `only`."""
    if only is not None:
        return [Path(path).as_posix() for path in only]
    own = Path(__file__).parent.name
    found = [p for p in sorted(tree.root.glob("tests/**/test_*.py"))]
    found = [p for p in found if p.parent.name != own]
    for path in sorted(tree.package.rglob("*.py")):
        if b">>> " in path.read_bytes():
            found.append(path)
    return [path.relative_to(tree.root).as_posix() for path in found]


def collect(tree, files, fresh=False, say=print):
    """{test file: {"seconds": of collecting it, "tests": {id: ...}}}, see Collector."""
    found = {}
    for k, path in enumerate(files):
        kept = _kept(tree, path)
        answer = None if fresh else _read(kept, tree)
        if answer is None:
            say(f"running {path}, {k + 1} of {len(files)}")
            task = partial(_collect, tree, path)
            answer = Child(task, tree.folder, LONGEST).wait()
            if answer.result is None:
                say(f"{path} {answer.ended}: its tests are not used")
                continue
            answer = answer.result
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(answer), encoding="utf-8")
        found[path] = answer
    return found


def _collect(tree, path):
    notes = tree.folder / "notes"
    tree.enter(**in_subprocesses(notes, tree.root, tree.package.name))
    Noting(tree.root, tree.package.name).install()
    collector = Collector(notes)
    pytest_main(tree, path, collector)
    names = collector.head.union(*(t["entered"] for t in collector.tests.values()))
    names = sorted(names)
    number = {name: k for k, name in enumerate(names)}
    for test in collector.tests.values():
        test["entered"] = [number[name] for name in test["entered"]]
    head = [number[name] for name in sorted(collector.head)]
    return dict(
        seconds=collector.seconds, names=names, head=head, tests=collector.tests
    )


def _kept(tree, path):
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    text = f"{path}\0{sys.version}\0".encode() + NOTES + (tree.root / path).read_bytes()
    name = hashlib.sha256(text).hexdigest()[:24]
    return Path(base) / "luenberger" / "mutation" / f"{name}.json"


def _read(kept, tree):
    """What was kept, unless a module that it names has gone since."""
    try:
        answer = json.loads(kept.read_text(encoding="utf-8"))
        modules = {name.partition("::")[0] for name in answer["names"]}
        answer["head"]
    except (OSError, ValueError, KeyError):
        return None
    return answer if all((tree.root / one).exists() for one in modules) else None


class Nearest:
    """The tests for a fault, from what `collect` found."""

    def __init__(self, tree, collected):
        self.tree, self.collected = tree, collected
        self.uses, self.texts = _uses(tree), {}

    def __call__(self, fault, budget):
        """{test file: {test: seconds}}, the nearest file first; and how many in all.

        First come the examples in the file itself, then files that name the function
        or its module, then the others, the quicker ones before; last, tests of files
        that only entered the function while they were read.  They are taken while
        their seconds are in the budget.
        """
        groups = []
        for wanted in self._functions(fault):
            for path, answer in self.collected.items():
                numbers = {k for k, n in enumerate(answer["names"]) if wanted(n)}
                read = not numbers.isdisjoint(answer["head"])
                own, others = {}, {}
                for name, test in answer["tests"].items():
                    if test["passed"] and not numbers.isdisjoint(test["entered"]):
                        own[name] = test["seconds"]
                    elif test["passed"] and read:
                        others[name] = test["seconds"]
                far = (path != fault.path) + (not self._names(path, fault))
                for late, tests in enumerate((own, others)):
                    seconds = sum(tests.values()) + answer["seconds"]
                    groups += [(late, far, seconds, path, tests)] if tests else []
            if groups:
                break
        groups.sort(key=lambda group: group[:4])
        near = sum(len(group[-1]) for group in groups)
        return self._within(groups, budget), near

    def _names(self, path, fault):
        """Whether a test file has the name of the function or of its module."""
        if path not in self.texts:
            text = (self.tree.root / path).read_text(encoding="utf-8")
            self.texts[path] = set(re.findall(r"\w+", text))
        function = fault.where.rpartition(".")[2] or fault.name
        return not self.texts[path].isdisjoint({function, Path(fault.path).stem})

    def _functions(self, fault):
        """Tests of the names of functions, the narrowest first."""
        inside = f"{fault.path}::{fault.where}"
        if fault.name and fault.name in self.uses:
            users = self.uses[fault.name]
            yield lambda name: name in users
        if fault.where:
            run = self._run(fault)
            yield lambda name: name == run
            yield lambda name: name == inside
            yield lambda name: name.startswith(f"{inside}.")
        yield lambda name: name.startswith(f"{fault.path}::")

    def _run(self, fault):
        """The name of the statements that the fault is in, see `reach`."""
        inside, found = f"{fault.path}::{fault.where}", None
        source = ast.parse((self.tree.root / fault.path).read_bytes())
        for where, function in _definitions(source):
            if where == fault.where and function.lineno <= fault.line:
                starts = [one for _, one in runs(function) if one.lineno <= fault.line]
                last = max(starts, key=lambda one: one.lineno, default=None)
                found = named(inside, function, last) if last else found
        return found or inside

    def _within(self, groups, budget):
        taken, left = {}, budget
        for _, _, _, path, tests in groups:
            if path not in taken:
                left -= self.collected[path]["seconds"]
            for name, seconds in sorted(tests.items(), key=lambda pair: pair[1]):
                left -= seconds
                if left < 0 and taken:
                    return taken
                taken.setdefault(path, {})[name] = seconds
        return taken


def _uses(tree):
    """For every name, the functions of the package that read it."""
    uses = {}
    for path in tree.package.rglob("*.py"):
        name = path.relative_to(tree.root).as_posix()
        for where, function in _definitions(ast.parse(path.read_bytes())):
            for node in ast.walk(function):
                if isinstance(node, ast.Name):
                    uses.setdefault(node.id, set()).add(f"{name}::{where}")
                elif isinstance(node, ast.Attribute):
                    uses.setdefault(node.attr, set()).add(f"{name}::{where}")
    return uses


def _definitions(node, where=""):
    for child in ast.iter_child_nodes(node):
        inner = where
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            inner = f"{where}.{child.name}".strip(".")
        if isinstance(child, ast.FunctionDef):
            yield inner, child
        yield from _definitions(child, inner)
