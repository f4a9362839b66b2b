"""Tests that pass at a terminal also pass elsewhere: part of the suite, elsewhere.

Where signals are ignored, files made for nobody or for everybody, no home, another
language, clock and width of the terminal, in another order and without root's powers.
"""

import os
import pathlib
import subprocess
import sys
from importlib.metadata import version

import pytest

import luenberger as lb

TESTS = pathlib.Path(__file__).parent
CONDUCT = "cli/test_conduct.py"
# first what a shell does, then the tests in the order that is given
ELSEWHERE = """
import os, signal, sys
for name in {ignored}:
    signal.signal(getattr(signal, name), signal.SIG_IGN)
os.umask({umask})
import pytest
class Order:
    def pytest_collection_modifyitems(self, items):
        items.sort(key=lambda one: one.nodeid, reverse={reverse})
options = ["-q", "-p", "no:cacheprovider", "--color=no", "-o", "addopts="]
options += ["--import-mode=importlib", "-p", "collecting"]
sys.exit(pytest.main([*options, *sys.argv[1:]], plugins=[Order()]))
"""
ALONE = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # no notebooks, no workers
PLACES = {
    "a job in the background": (
        ["formats/test_writing.py::test_permissions",
         f"{CONDUCT}::test_help_names_every_command_and_status",
         f"{CONDUCT}::test_interrupted_while_writing_leaves_the_old_file"],
        dict(ignored=["SIGINT", "SIGHUP", "SIGPIPE"], umask=0o077, reverse=False),
        dict(LC_ALL="C", TZ="Asia/Kolkata", COLUMNS="20", LINES="5", TERM="dumb",
             PYTHONUNBUFFERED="1", PYTHONHASHSEED="1"),
    ),
    "a machine of others": (
        ["kernels/test_kept.py::test_the_second_time_nothing_is_compiled",
         "cli/test_estimate.py::test_many_pieces_are_one_record",
         "formats/test_writing.py::test_permissions"],
        dict(ignored=["SIGTERM"], umask=0, reverse=True),
        dict(LC_ALL="de_DE.UTF-8", TZ="ABC+12:34:56", COLUMNS="500", NO_COLOR="1",
             HOME="/dev/null/home", PYTHONIOENCODING="ascii", PYTHONHASHSEED="2"),
    ),
}  # fmt: skip


@pytest.mark.skipif(os.name == "nt", reason="signals and umask are POSIX's")
@pytest.mark.parametrize(("tests", "shell", "environment"), PLACES.values(), ids=PLACES)
def test_some_of_the_suite_passes_elsewhere(tmp_path, tests, shell, environment):
    ours = ("HOME", "LANG", "LANGUAGE", "PYTEST_ADDOPTS")
    kept = [n for n in os.environ if n not in ours and not n.startswith("LC_")]
    run = subprocess.run(
        [sys.executable, "-c", ELSEWHERE.format(**shell), "--basetemp", tmp_path / "b"]
        + [TESTS / line for line in tests],
        cwd=TESTS.parent,
        env={name: os.environ[name] for name in kept} | environment | ALONE,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert " passed" in run.stdout or "[100%]" in run.stdout


def test_the_package_says_its_version():
    assert lb.__version__ == version("luenberger")
