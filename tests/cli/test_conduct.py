"""How every command behaves: statuses, streams, dry runs, signals, names, help."""

import builtins
import collections
import contextlib
import io
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
from interrupts import heeding

import luenberger as lb
from luenberger.cli import COMMANDS, main

PLANTS = pathlib.Path(__file__).parents[2] / "notebooks" / "plants"
NAMES = [*COMMANDS]
CLIMBING = '../../x \N{SNOWMAN} "; rm -rf </script> {0} %s =1+1'


def shorten(path, rows):
    path.write_text("".join(path.read_text().splitlines(keepends=True)[: rows + 1]))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a plant, its record and an observer, as the examples have them."""
    folder = tmp_path_factory.mktemp("made")
    for path in PLANTS.iterdir():
        shutil.copy(path, folder)
    shorten(folder / "ball-and-beam.csv", rows=100)  # no time to compile a fit for it
    plant = lb.Plant.from_json(folder / "tracker.json")
    (folder / "report").mkdir()
    (folder / "report" / "report.html").write_text("an earlier report")
    observer = lb.reduced_order_filter(plant, 1, horizon="steady")
    observer.to_json(folder / "report" / "observer.json")
    return folder


@pytest.fixture
def here(made, tmp_path, monkeypatch):
    """A copy of that folder, which is then the working folder."""
    shutil.copytree(made, tmp_path / "work")
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


@pytest.fixture
def call(capfd):
    """Run a command line in this process: status, stdout, stderr."""

    def run(line):
        try:
            status = main(shlex.split(line) if isinstance(line, str) else line)
        except SystemExit as end:
            status = end.code
        return status, *capfd.readouterr()

    return run


# Whether Python buffers decides where a closed pipe shows.
CLEAN = {
    name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"
}


def process(*arguments, **options):
    """The same in a process of its own."""
    return python("-m", "luenberger", *arguments, **options)


LINES = """
import shlex, sys
from luenberger.cli import main
for line in sys.argv[1:]:
    print(main(shlex.split(line)))
"""


def python(*arguments, **options):
    options = dict(capture_output=True, text=True, timeout=120, env=CLEAN) | options
    return subprocess.run([sys.executable, *arguments], **options)


def contents(folder):
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file()
    }


# -- help -----------------------------------------------------------------------------


def examples(name):
    from luenberger.cli import parser

    actions = parser()._subparsers._group_actions[0].choices
    head = "  luenberger "
    lines = actions[name].format_help().splitlines()
    return [line.removeprefix(head) for line in lines if line.startswith(head)]


EXAMPLES = [line for name in NAMES for line in examples(name)]
SLOW = {"design tracker.json --out report --data tracker.csv"}  # in test_design.py


@pytest.mark.parametrize("name", NAMES)
def test_help_has_examples_and_says_what_is_written(call, name):
    status, out, err = call(f"{name} --help")
    assert (status, err) == (0, "") and "\nexamples:\n" in out
    assert any(one in out for one in ("--dry-run", "--out FILE", "Writes nothing."))
    assert len(examples(name)) >= 2


@pytest.mark.parametrize("line", [line for line in EXAMPLES if line not in SLOW])
def test_examples_run(here, call, line):
    status, out, err = call(line)
    assert status == 0 and out, err


def test_slow_examples_exist():
    assert set(EXAMPLES) > SLOW


def test_help_names_every_command_and_status(call, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")  # argparse fills lines as wide as the terminal
    status, out, _ = call("--help")
    assert status == 0 and set(NAMES) <= set(re.findall(r"^    (\S+)", out, re.M))
    assert all(f"\n  {code:<5}" in out for code in (0, 1, 2, 130))


def test_help_is_as_quick_as_the_library():
    """It imports next to nothing that `import luenberger` does not."""
    code = (
        "import sys, luenberger; before = set(sys.modules)\n"
        "from luenberger.cli import parser; parser().format_help()\n"
        "print(*sorted(set(sys.modules) - before))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    new = run.stdout.split()
    ours = [name for name in new if name.startswith("luenberger.")]
    assert ours == ["luenberger.cli"]
    assert len(new) - len(ours) < 10, new


def test_version(call):
    from importlib.metadata import version

    assert call("--version") == (0, f"luenberger {version('luenberger')}\n", "")


def test_the_guide_lists_every_command():
    page = PLANTS.parent / "pages" / "guide" / "command-line.md"
    text = page.read_text(encoding="utf-8")
    assert [name for name in NAMES if f"\n| `{name}" not in text] == []


# -- statuses -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("check absent.json", "absent.json: No such file"),
        ("check report", "report"),
        ("check tracker.csv", "tracker.csv: not a JSON file"),
        ("check report/observer.json", "does not hold a plant"),
        ("compare tracker.json --k=1,2", "L must be"),
        ("compare tracker.json --k=one", "no estimate or state 'one'; there are"),
        ("compare tracker.json --k=1,nan,2", "L has entries that are not finite"),
        ("compare tracker.json --orders=7", "from 0 to 3, got 7"),
        ("compare tracker.json --orders=0", "no design exists"),
        ("compare tracker.json --csv report", "report is a folder"),
        ("compare tracker.json --csv no/such.csv", "no/such.csv: there is no folder"),
        ("compare tracker.json --csv ./tracker.json", "would replace tracker.json"),
        ("export tracker.json --c tracker.csv/a --dry-run", "tracker.csv is a file"),
        ("design tracker.json --out tracker.csv/r --dry-run", "tracker.csv is a file"),
        (
            "estimate report/observer.json tracker.csv --out tracker.csv/e",
            "tracker.csv/e: there is no folder",
        ),
        ("export tracker.json --c c --m1 speed", "'speed' is not an output"),
        ("export tracker.json --c c --m1 3", "between 0 and p = 2, got 3"),
        ("export report/observer.json --c tracker.csv", "tracker.csv is a file"),
        ("export report/observer.json --c c --m1 1", "go with a plant"),
        ("check tracker.json --sample 0.1", "dt = 1, it is discrete already"),
        ("ledger --paper Kalman", "no paper is called 'Kalman'"),
        ("ledger --paper an", "more than one paper"),
        ("ledger --paper=", "no paper is called ''"),
        ("ledger --html no/such.html --paper hsia", "no/such.html: there is no f"),
        ("ledger --html report --dry-run", "report is a folder"),
        ("design tracker.json --out tracker.csv", "tracker.csv is a file"),
        ("estimate tracker.json tracker.csv --out e.csv", "does not hold an observer"),
    ],
    ids=lambda value: value if " " in value and "--" in value else "",
)
def test_refused_with_one_line_and_status_1(here, call, line, why):
    before = contents(here)
    status, out, err = call(line)
    assert status == 1 and out == "", (status, out)
    *said, message = err.splitlines()
    assert message.startswith("luenberger: ") and why in message
    assert "Traceback" not in err and len(said) <= 1
    assert contents(here) == before


@pytest.mark.parametrize(
    "line",
    [
        "",
        "destroy",
        "check",
        "check a.json b.json",
        "check tracker.json --jso",
        "compare tracker.json --k=1,0,0;a=0,1,0",
        "compare tracker.json --k=a=0,1,0;a=1,0,0",
        "compare tracker.json --k=;",
        "compare tracker.json --csv a.csv --json",
        "export report/observer.json",
        "ledger --coq a --html a.html",
        "ledger --html a.html --json",
        "ledger --html a.html --misprints",
        "ledger --prove --json",
        "design tracker.json",
        "design tracker.json --out=",
        "check ''",
        "compare tracker.json --k=1_0,0,0",
        "compare tracker.json --csv=",
        "compare tracker.json --csv=folder/",
        "export report/observer.json --c=",
        "export '' --c c",
        "estimate '' tracker.csv --out e.csv",
        "estimate report/observer.json '' --out e.csv",
        "estimate report/observer.json tracker.csv --out=",
        "estimate report/observer.json tracker.csv --out=folder/",
        "ledger --coq=",
        "ledger --html=",
        "check tracker.json --sample 0",
        "check tracker.json --sample 1_0",
        "check tracker.json --sample nan",
        "estimate report/observer.json tracker.csv --out e.csv --sample 1",
        "export report/observer.json --c c --sample 1",
        "filter tracker.json tracker.csv --out e.csv --smooth --lag 1",
        "check tracker.json --k 1",
        "estimate report/observer.json tracker.csv",
    ],
)
def test_wrong_usage_has_status_2(here, call, line):
    status, out, err = call(line)
    assert status == 2 and out == "" and "usage: luenberger" in err


@pytest.mark.parametrize("command", ["check", "export --c c"])
def test_numbers_that_overflow_are_a_refusal_in_one_line(here, call, command):
    lb.Plant(np.full((3, 3), 1e308), None, np.eye(3), dt=1.0, Q=np.eye(3), R=np.eye(3),
             P0=np.eye(3)).to_json(here / "p.json")  # fmt: skip
    before = contents(here)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # would be lines on stderr
        status, out, err = call(f"{command} p.json")
    assert (status, out) == (1, "") and err.count("\n") == 1
    assert contents(here) == before
    assert "the numbers are too large or too unlike to compute with" in err


def test_main_prints_to_whatever_stands_for_stdout(here):
    """As a notebook's stream does, which has no bytes beneath."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["check", "tracker.json"]) == 0
    assert "steady filter  exists" in out.getvalue()


def test_a_missing_package_is_a_refusal(here, call, monkeypatch):
    monkeypatch.setitem(sys.modules, "latex2mathml.converter", None)
    status, out, err = call("ledger --paper hsia --html page.html")
    assert status == 1 and out == "" and "latex2mathml" in err
    assert not (here / "page.html").exists()


# -- dry runs -------------------------------------------------------------------------

WRITING = [
    "compare tracker.json --orders=1 --csv designs.csv",
    "ledger --paper hsia --html page.html",
    "export report/observer.json --c firmware --plant tracker.json",
    "export tracker.json --c . --name filter",
    "export tracker.json --c . --name filter --dtype float",
]


@pytest.mark.parametrize("line", WRITING)
def test_a_dry_run_writes_nothing_and_names_what_a_run_writes(here, call, line):
    before = contents(here)
    status, planned, err = call(f"{line} --dry-run")
    assert status == 0 and err.endswith("dry run: nothing was written\n")
    assert contents(here) == before and not (here / "firmware").exists()
    status, out, err = call(line)
    assert status == 0 and "dry run" not in err
    new = sorted(set(contents(here)) - set(before))
    assert out == planned and sorted(map(os.path.normpath, out.splitlines())) == new


READING = [
    "check tracker.json",
    "compare tracker.json --orders 1",
    "design tracker.json --out r --dry-run",
    "estimate report/observer.json tracker.csv --plant tracker.json --out -",
    "export tracker.json --c firmware",
    "export report/observer.json --plant tracker.json --c firmware",
]


@pytest.mark.parametrize("line", READING)
def test_a_file_is_read_once(here, call, monkeypatch, line):
    """It may change while the command runs."""
    opened, usual = collections.Counter(), open

    def counting(path, *arguments, **options):
        opened[str(path)] += 1
        return usual(path, *arguments, **options)

    for module in (builtins, io):
        monkeypatch.setattr(module, "open", counting)
    assert call(line)[0] == 0
    named = [word for word in shlex.split(line) if word.endswith((".json", ".csv"))]
    assert [opened[path] for path in named] == [1] * len(named)


def test_a_dry_run_refuses_what_the_run_would(here, call):
    (here / "mine.h").write_text("not ours")
    line = "export report/observer.json --c . --name mine"
    for more in ("", " --dry-run"):
        status, out, err = call(line + more)
        assert (status, out) == (1, "") and "not written by this library" in err


# -- output ---------------------------------------------------------------------------

JSON = [
    "check tracker.json --json",
    "compare tracker.json --k=1,0,0 --orders=1 --json",
    "ledger --paper moore --json",
    "ledger --misprints --json",
]


def refuse(constant):
    raise AssertionError(f"{constant} is not JSON")


@pytest.mark.parametrize("line", JSON)
def test_json_is_one_document_of_ascii(here, call, line):
    status, out, err = call(line)
    found = json.loads(out, parse_constant=refuse)
    assert (status, err) == (0, "") and isinstance(found, dict) and out.isascii()


def test_output_is_the_same_in_every_process(here, call):
    """Whatever order sets have in it."""
    lines = ["compare tracker.json --orders=1", "check reactor.json"]
    run = python("-c", LINES, *lines, env=CLEAN | {"PYTHONHASHSEED": "1"})
    one, other = (call(line)[1] for line in lines)
    assert run.stdout == f"{one}0\n{other}0\n" and one and other


def with_names(here, text, path):
    """The tracker with `text` in every name."""
    data = json.loads((here / "tracker.json").read_text())
    names = dict(name=text, state_names=[f"{text}{k}" for k in range(3)])
    names["output_names"] = [f"{text} out {k}" for k in range(2)]
    (here / path).write_text(json.dumps(data | names))


def test_names_do_not_become_paths(here, call):
    """They are in the JSON of a stranger; the files are those that were asked for."""
    with_names(here, CLIMBING, "odd.json")
    before = set(contents(here.parent))
    lines = ["check odd.json", "check odd.json --json"]
    lines += ["compare odd.json --orders=1", "compare odd.json --orders=1 --csv d.csv"]
    lines += [["export", "odd.json", "--c=c", f"--m1={CLIMBING} out 0"]]
    lines += ["export report/observer.json --plant odd.json --c d"]
    for line in lines:
        assert call(line)[0] == 0
    made = {path for path in contents(here.parent) if path not in before}
    named = {"d.csv", "c/observer.c", "c/observer.h", "d/observer.c", "d/observer.h"}
    assert made == {f"work/{name}" for name in named}


def test_a_terminal_without_unicode(here, call, monkeypatch):
    data = json.loads((here / "tracker.json").read_text())
    data["state_names"] = ["\N{SNOWMAN}", "Straße", "position"]
    (here / "odd.json").write_text(json.dumps(data))
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", terminal)
    assert call("check odd.json")[0] == 0
    printed = terminal.buffer.getvalue().decode("ascii")
    assert "\\u2603, Stra\\xdfe, position" in printed


# -- interrupted ----------------------------------------------------------------------


def test_a_process_ends_quietly_at_a_closed_pipe():
    run = subprocess.Popen(
        [sys.executable, "-m", "luenberger", "ledger", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=CLEAN,
    )
    run.stdout.close()
    assert run.stderr.read() == b"" and run.wait(timeout=120) == 141
    run.stderr.close()


def test_interrupted_while_writing_leaves_the_old_file(here):
    (here / "e.csv").write_text("old")
    line = "estimate report/observer.json - --out e.csv"
    before = contents(here)
    run = subprocess.Popen(
        heeding("-m", "luenberger", *line.split()),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    run.stdin.write((here / "tracker.csv").read_text())
    run.stdin.flush()
    while run.poll() is None and not list(here.glob(".luenberger-*")):
        time.sleep(0.01)
    assert run.poll() is None  # it waits for more, its new file beside the old one
    run.send_signal(signal.SIGINT)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 130 and err.endswith("luenberger: interrupted\n")
    assert contents(here) == before


def test_importing_the_library_installs_no_handler():
    code = "import signal; before = signal.getsignal(2); import luenberger.cli\n"
    run = python("-c", code + "assert signal.getsignal(2) is before")
    assert run.returncode == 0, run.stderr


# -- check ----------------------------------------------------------------------------


def plant(A, C, dt=1.0, **noise):
    n, p = len(A), len(C)
    noise = dict(Q=np.eye(n), R=np.eye(p)) | noise
    return lb.Plant(A, None, C, dt=dt, **noise)


A2 = [[0.5, 0.0], [0.0, 2.0]]
J2 = [[[1.0, 1.0], [0.0, 1.0]], [[1.0, 0.0]]]
PLANTS_TO_CHECK = {
    "observable": (
        plant(*J2),
        ["not stable: 1 (2 times)", "  observable; indices 2", "filter  exists"],
    ),
    "unobservable, decays": (
        plant(A2, [[0, 1]]),
        ["not observable; indices 1", "hidden modes   0.5, which decay\n"],
    ),
    "unobservable, does not decay": (
        plant(A2, [[1, 0]]),
        ["hidden modes   2, which do not decay", "steady filter  none: not detectable"],
    ),
    "nothing measured": (
        plant(A2, [[0, 0]]),
        [
            "indices none",
            "hidden modes   0.5, ",
            "hidden modes   2, ",
            "redundant      1",
        ],
    ),
    "no outputs": (
        plant([[0.999, 1], [0, 0.998]], np.zeros((0, 2))),
        ["outputs        none", "hidden modes   0.998, 0.999, which", "filter  exists"],
    ),
    "growing too fast to compute": (
        plant(1e60 * np.array([[1, 2, 0], [0, 1, 1], [1, 0, 1]]), [[1, 0, 0]]),
        ["steady filter  none: the "],
    ),
    "unstable": (plant(A2, [[1, 1]]), ["not stable: 2"]),
    "continuous": (
        lb.Plant([[0, 1], [-1, 0]], [[0], [1]], [[1, 0]]),
        ["continuous (dt = 0)", "modes          0 +- 1j", "not stable: 0 +- 1j"],
    ),
    "noise-free": (
        plant(*J2, Q=[[0, 0], [0, 1]], R=[[0]]),
        ["rank of Q 1 of 2, of R 0 of 1, of [Q S; S' R] 1 of 3", "noise-free     y1"],
    ),
    "correlated": (
        plant([[0.5]], [[1]], Q=[[1]], R=[[1]], S=[[1]]),
        ["of [Q S; S' R] 1 of 2"],
    ),
    "undriven": (
        plant([[1, 0], [0, 0.5]], [[1, 1]], Q=[[0, 0], [0, 1]]),
        ["undriven       1", "steady filter  none: no steady filter: a motion at 1"],
    ),
    "undriven by what is left of w": (
        plant([[2]], [[1]], Q=[[1]], R=[[1]], S=[[1]]),
        ["undriven       1", "steady filter  none: no steady filter"],
    ),
    "mean-square stable": (
        plant([[0.5]], [[1]], multiplicative=[([[0.5]], [[0]])]),
        ["1 pair; mean-square stable, spectral radius 0.5,", "1.73205 times as"],
    ),
    "mean-square unstable by itself": (
        plant([[2]], [[1]], multiplicative=[([[0.5]], [[0]])] * 2),
        [
            "2 pairs; not mean-square stable, ",
            "as A alone\n               is not stable",
        ],
    ),
    "mean-square unstable": (
        plant([[0.5]], [[1]], multiplicative=[([[1.2]], [[0]])]),
        [
            "not mean-square stable, spectral radius 1.69",
            "none: not mean-square stable",
        ],
    ),
    "noise that does not feed back": (
        plant([[0.5]], [[1]], multiplicative=[([[0]], [[1]])]),
        ["up to\n               any factor", "steady filter  exists"],
    ),
    "varies in time": (
        plant(np.array([[[0.5]], [[0.6]]]), [[1]], Q=[[1]], R=[[1]]),
        ["varies over 2 instants", "of one instant say nothing", "filter  none:"],
    ),
    "no noise": (
        lb.Plant(A2, None, [[1, 1]], dt=1.0),
        ["noise          Q or R is not"],
    ),
    "start": (
        plant([[0.5]], [[1]], P0=[[1]], at_first=True),
        ["x0, P0 are of x[1], before y[1]"],
    ),
    "twice": (plant(np.eye(2) / 2, np.eye(2)), ["modes          0.5 (2 times)"]),
    "pair": (
        plant([[0, 1], [-0.5, 0]], [[1, 0]]),
        ["modes          0 +- 0.707107j\n"],
    ),
    "complex": (
        lb.Plant([[0.5j, 0], [0, 0.5]], None, [[1, 1]], dt=1.0),
        ["modes          0+0.5j, 0.5\n", "observable; indices 2", "filter  none:"],
    ),
    "complex, two of one size": (
        lb.Plant(np.diag([0.5j, -0.5j, 2, 1j]), None, np.ones((1, 4)), dt=1.0),
        ["modes          0 +- 0.5j, 0+1j, 2\n"],
    ),
}


@pytest.mark.parametrize(
    ("one", "lines"), PLANTS_TO_CHECK.values(), ids=list(PLANTS_TO_CHECK)
)
def test_check_says_what_a_plant_is_like(tmp_path, call, one, lines):
    one.to_json(tmp_path / "p.json")
    status, out, err = call(["check", str(tmp_path / "p.json")])
    assert (status, err) == (0, "")
    assert all(len(line) < 80 for line in out.splitlines())
    for line in lines:
        assert line in out, out
    assert out.count("hidden modes") == sum("hidden modes" in line for line in lines)
    status, out, _ = call(["check", str(tmp_path / "p.json"), "--json"])
    assert status == 0 and json.loads(out, parse_constant=refuse)["name"] is None


def test_an_overflow_is_no_line_of_numpy_on_stderr(tmp_path, call):
    one = plant([[0.5, 0.1], [0, 0.6]], [[1e300, 0]])
    one.to_json(tmp_path / "p.json")
    for line, said in (("check", "steady filter"), ("compare --orders=1", "Take the ")):
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            status, out, err = call([*line.split(), str(tmp_path / "p.json")])
        assert (status, err, warned) == (0, "", [])
        assert "encountered" not in out and said in out


# -- the others -----------------------------------------------------------------------


def few(plant):
    return lb.compare(plant, lb.candidates(plant, orders=1))


def test_compare_prints_what_the_library_finds(here, call):
    table = few(lb.Plant.from_json("tracker.json"))
    _, out, _ = call("compare tracker.json --orders=1 --json")
    found = json.loads(out)
    assert found["designs"] == table.to_rows() and found["reasons"] == table.reasons()
    _, out, _ = call("compare tracker.json --orders=1")
    starred = [line for line in out.splitlines() if line.startswith("*")]
    assert len(starred) == 1 and table.recommended().label in starred[0]
    assert "the fixed-order filter is for" in out
    assert table.reasons()[0] in " ".join(out.split())


def test_compare_writes_a_line_for_each_design(here, call):
    import csv

    call("compare tracker.json --orders=1 --csv d.csv")
    with open("d.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    found = few(lb.Plant.from_json("tracker.json"))
    assert [row["method"] for row in rows] == [one.method for one in found]
    assert sum(row["recommended"] == "yes" for row in rows) == 1
    errors = [float(row["error"]) for row in rows if row["error"]]
    assert errors == [one.error for one in found.designs]


def test_the_exported_filter_of_a_plant(here, call):
    call('export tracker.json --m1 "radar position (m)" --c by-command')
    plant = lb.Plant.from_json("tracker.json")
    lb.export.to_c(plant, "by-function", m1=["radar position (m)"])
    assert contents(here / "by-command") == contents(here / "by-function")
    call("export tracker.json --m1 2 --c by-command --name two --dtype float")
    lb.export.to_c(plant, "by-function", m1=2, name="two", dtype="float")
    assert contents(here / "by-command") == contents(here / "by-function")


@pytest.mark.parametrize("path", ["tracker.json", "report/observer.json"])
def test_a_file_that_does_not_say_what_it_is_is_known_by_its_keys(here, call, path):
    data = json.loads((here / path).read_text())
    assert data.pop("luenberger")
    (here / "plain.json").write_text(json.dumps(data))
    assert call(f"export {path} --c a")[0] == call("export plain.json --c b")[0] == 0
    assert contents(here / "a") == contents(here / "b")


def test_a_ledger_that_is_not_proved_is_a_refusal(call, monkeypatch):
    from luenberger import ledger

    monkeypatch.setattr(ledger.Entry, "check", lambda entry: ["line 1 does not follow"])
    status, out, err = call("ledger --prove --paper moore")
    assert status == 1 and "15 of the entries are not proved" in err
    assert out.count("not proved: line 1 does not follow") == 15


def test_the_ledger_is_printed_whole(call):
    from luenberger import ledger

    _, out, _ = call("ledger --paper moore")
    text = " ".join(out.split())
    for entry in ledger.entries("moore"):
        assert all(" ".join(str(one).split()) in text for one in entry.says)
        assert f"{entry.number} {entry.level};" in text
    _, out, _ = call("ledger --prove --paper moore")
    assert out.splitlines()[-1].split()[2] == str(ledger.count("moore"))
    _, out, _ = call("ledger --misprints")
    assert out.count("  correct: ") == len(ledger.misprints())
    _, out, _ = call("ledger --json")
    assert len(json.loads(out)["entries"]) == ledger.count()
    _, out, _ = call("ledger --misprints --json --paper hsia")
    assert len(json.loads(out)["misprints"]) == len(ledger.misprints("hsia"))
