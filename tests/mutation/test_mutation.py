"""The mutation run on a toy: what is noticed, what survives, and what hangs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command import arguments, sample
from faults import faults

HERE = Path(__file__).parent
CORE = """\
\"\"\"A toy, with 1 + 1 in its docstring.\"\"\"

TOL = 1e-9


def near(a, b):
    if a is None:
        raise ValueError(f"a is {a - 1}")
    return abs(a - b) <= TOL


def countdown(n):
    while True:
        n -= 1
        if n == 0:
            break
    return n


def idle(M):
    return M.T @ M


def rest(n):
    if n > 5:
        return n - 5
    return n + 0


KEPT = 1 / 1
"""
TESTS = """\
import subprocess, sys
import pytest
import toy


@pytest.fixture(scope="module")
def counted():
    return toy.countdown(3)


def test_near():
    assert toy.near(1, 1 + 0.9e-9) and not toy.near(1, 1 + 1.1e-9)


def test_counted_in_a_fixture(counted):
    assert counted == 0


def test_counted_again(counted):
    assert counted == 0


def test_elsewhere():
    done = subprocess.run([sys.executable, "-c", "import toy; toy.idle(toy.Unit)"])
    assert done.returncode == 0


def test_rest_of_a_small_number():
    assert toy.rest(2) == 2


def test_rest_of_a_large_number():
    toy.rest(7)


def test_that_fails():
    assert toy.near(1, 2)
"""
UNIT = """\
from .core import countdown, idle, near, rest


class Row:
    def __matmul__(self, other):
        assert other is not self


Unit = Row()
Unit.T = Row()
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    root = tmp_path_factory.mktemp("toy")
    for path, text in {
        "lib/toy/__init__.py": UNIT,
        "lib/toy/core.py": CORE,
        "tests/test_toy.py": TESTS,
        "pyproject.toml": "[tool.pytest]\naddopts = ['--doctest-modules']\n",
    }.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    return root


def run(toy, *places, **options):
    command = [sys.executable, str(HERE), *places, "--repository", str(toy)]
    command += ["--package", "toy", "--preload", "", "--patience", "0.2"]
    command += [f"--{name}={value}" for name, value in options.items()]
    environment = os.environ | {
        "XDG_CACHE_HOME": str(toy / "cache"),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTEST_PLUGINS": "xdist.plugin",  # of -n; a toy needs no other
    }
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert "Traceback" not in done.stderr, done.stderr
    return done


@pytest.fixture(scope="module")
def done(toy):
    """A run that leaves the toy as it was."""
    before = {path: path.read_bytes() for path in toy.rglob("*.py")}
    done = run(toy, *(f"core.py:{line}" for line in (3, 16, 21, 25, 26, 27, 30)))
    assert {path: path.read_bytes() for path in before} == before
    return done


def test_a_run_says_what_was_noticed_and_by_which_test(done):
    said = done.stdout
    assert "core.py:3 TOL: tests/test_toy.py::test_near" in said
    assert "core.py:16 countdown: hung" in said  # the loop that never ends
    assert "core.py:21 idle: tests/test_toy.py::test_elsewhere" in said  # a process
    assert "core.py:21 idle: SURVIVED 1 of 1 tests near it" in said
    assert "     - return M.T @ M\n     + return (M @ M.T)" in said
    assert "that_fails" not in said and done.returncode == 1


def test_only_those_tests_are_near_a_fault_that_reach_its_branch(done):
    said = done.stdout
    assert "core.py:25 rest: SURVIVED 2 of 2 tests near it" in said
    assert "core.py:26 rest: SURVIVED 1 of 1 tests near it" in said
    assert "core.py:27 rest: SURVIVED 1 of 1 tests near it" in said
    assert "core.py:27 rest: tests/test_toy.py::test_rest_of_a_small_number" in said


def test_a_fault_is_noticed_that_no_test_file_can_be_imported_with(done):
    assert "core.py:30 KEPT: tests/test_toy.py\n" in done.stdout
    assert "+ KEPT = (1 * 1)" in done.stdout


def test_numbers_of_the_sample_can_be_tried_again(toy):
    said = run(toy, "core.py:3", "core.py:26", only=3).stdout
    assert (
        said.startswith("   3 ") and "drawn from" in said and said.count("core.py") == 1
    )


def test_the_library_is_damaged_unless_told_otherwise():
    assert (
        arguments([]).repository / "lib" / "luenberger" / "plant" / "plant.py"
    ).exists()


def test_a_sample_is_of_different_places_and_the_same_for_the_same_seed():
    places = faults("core.py", CORE.encode())
    one, two, other = (sample(places, 5, seed, False) for seed in (1, 1, 2))
    assert one == two != other and len(set(one)) == 5
    assert sorted(sample(places, 99, 1, True)) == sorted(sum(places, []))


def test_faults_of_a_line():
    """Signs, bounds and terms; of the words of an error and of a docstring none."""
    source = CORE.encode()
    found = {}
    for place in faults("core.py", source):
        for fault in place:
            old, new = fault.shown(source)
            found.setdefault(old, []).append(new)
    assert found["TOL = 1e-9"] == ["TOL = 1e-06", "TOL = 1e-12"]
    assert found["return abs(a - b) <= TOL"] == [
        "return (abs(a - b) < TOL)",
        "return abs((a + b)) <= TOL",
        "return abs((a)) <= TOL",
        "return abs((-b)) <= TOL",
    ]
    assert found["n -= 1"] == ["pass", "n += 1", "n -= 2", "n -= 0"]
    assert found["break"] == ["pass"]
    assert found["if a is None:"] == ["if not (a is None):", "if (a is not None):"]
    assert found['raise ValueError(f"a is {a - 1}")'] == ["pass"]
    assert not any("toy" in line for line in found)


GENERATOR = """\
def write(to, M, now, k):
    to.set(f"{M}_s", f"{M}[{k + 1}] - s", "-=")
    return [now.Q, now.Qs, k[1:], k if k else None, max(1, k)]
"""


def test_printed_code_letters_and_bounds_are_damaged_too():
    source = GENERATOR.encode()
    new = {f.shown(source)[1] for place in faults("g.py", source) for f in place}
    wanted = ["{M}[{k + 1}] + s", "{M}[{k - 1}] - s", "'+='", "[(now.Qs), now.Qs,"]
    wanted += ["[now.Q, (now.Q),", "k[2:]", "k[0:]", "(None), max", "max(2, k)"]
    for part in wanted:
        assert any(part in line for line in new), (part, new)
    assert not any("max(k, 1)" in line for line in new)  # that is the same
    same = [f for place in faults("g.py", b"f('', '', 1)") for f in place]
    assert [f.shown(b"f('', '', 1)")[1] for f in same] == [
        "pass",
        "f('', '', 2)",
        "f('', '', 0)",
    ]
