"""`python -m luenberger design`: what it writes, and what it leaves when it fails."""

import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest
from interrupts import sigint  # noqa: F401  a fixture

import luenberger as lb
from luenberger.commands import design, main
from luenberger.compare import METHODS

ROOT = pathlib.Path(__file__).parents[2]
PLANTS = ROOT / "notebooks" / "plants"
FILES = {"design.ipynb", "report.html", "observer.json", "designs.csv", "plant.json"}
WITH_DATA = FILES | {"data.csv", "estimates.csv"}


def command(*arguments, cwd, **options):
    return subprocess.run(
        [sys.executable, "-m", "luenberger", "design", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=120,
        **options,
    )


@pytest.fixture
def inside(monkeypatch, capfd, forked_kernels):
    """The same command without a process of its own, and its kernel is a fork."""

    def run(*arguments, cwd):
        monkeypatch.chdir(cwd)
        status = main(["design", *map(str, arguments)])
        return subprocess.CompletedProcess(arguments, status, *capfd.readouterr())

    return run


def contents(folder):
    """Every file below a folder and what is in it."""
    return {p: p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


WATCH = """
import os, sys

def watch(event, arguments):
    if event == "open" and str(arguments[0]).endswith(".json") and arguments[1] == "r":
        log = os.open(os.environ["OPENED"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(log, f"{arguments[0]}\\n".encode())
        os.close(log)

sys.addaudithook(watch)
"""


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    """A folder with a finished report on the tracker, and what the command said.

    Every process of Python notes which JSON it reads.
    """
    site, here = map(tmp_path_factory.mktemp, ("site", "command"))
    (site / "sitecustomize.py").write_text(WATCH)
    watched = os.environ | {"PYTHONPATH": str(site), "OPENED": str(site / "opened")}
    given = ("--out=a/report", "--data", PLANTS / "tracker.csv")
    run = command(PLANTS / "tracker.json", *given, cwd=here, env=watched)
    assert run.returncode == 0, run.stderr
    run.opened = (site / "opened").read_text().splitlines()
    return here, run


def test_the_plant_is_read_once_and_its_copy_once(reported):
    """The file may change meanwhile; the report's notebook reads what was checked."""
    here, run = reported
    assert run.opened.count(str(PLANTS / "tracker.json")) == 1
    assert [name for name in run.opened if name.endswith("plant.json")] == [
        "plant.json"
    ]
    copy = here / "a/report/plant.json"
    assert copy.read_bytes() == (PLANTS / "tracker.json").read_bytes()


def test_files_and_nothing_else(reported):
    here, run = reported
    found = {str(path.relative_to(here)) for path in here.rglob("*") if path.is_file()}
    assert found == {f"a/report/{name}" for name in WITH_DATA}
    assert set(run.stdout.split()) == found and run.stdout.endswith("report.html\n")


def test_progress_counts_every_step(reported):
    _, run = reported
    steps = re.findall(r"^step (\d+) of (\d+): .+$", run.stderr, re.M)
    last = int(steps[-1][1])
    assert [int(step) for step, _ in steps] == list(range(1, last + 1))


def test_observer_is_certified_and_as_accurate_as_its_table_says(reported):
    here, _ = reported
    plant = lb.Plant.from_json(PLANTS / "tracker.json")
    observer = lb.Observer.from_json(here / "a/report/observer.json")
    lb.certify(observer, plant).require()
    with open(here / "a/report/designs.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["accurate"] for row in rows][:2] == ["", "radar position (m)"]
    trace = np.trace(lb.error_covariance(observer, plant))
    (chosen,) = [row for row in rows if row["recommended"] == "yes"]
    assert float(chosen["error_trace"]) == pytest.approx(trace, rel=1e-12)
    assert int(chosen["order"]) == observer.order == 2
    assert float(chosen["excess"]) < 0.1
    assert {row["method"] for row in rows} == set(METHODS)
    refused = [row for row in rows if row["refusal"]]
    assert refused and all(row["error_trace"] == "" for row in refused)


def test_estimates_are_those_of_the_observer(reported):
    here, _ = reported
    plant = lb.Plant.from_json(PLANTS / "tracker.json")
    with open(here / "a/report/estimates.csv", newline="") as file:
        header, *rows = list(csv.reader(file))
    names = [name for s in plant.state_names for name in (s, f"{s}_sigma")]
    assert header == ["time", *names]
    values = np.array(rows, dtype=float)
    y = np.loadtxt(PLANTS / "tracker.csv", delimiter=",", skiprows=1)[:, 1:]
    observer = lb.Observer.from_json(here / "a/report/observer.json")
    x = lb.estimate(observer, y, x0=plant.A @ plant.x0)
    np.testing.assert_allclose(values[:, 1::2], x, rtol=1e-12)
    steady = np.sqrt(np.diag(lb.error_covariance(observer, plant)))
    np.testing.assert_allclose(values[-1, 2::2], steady, rtol=1e-6)
    assert values[0, 4] > steady[1]  # larger at the start, where P0 counts


def test_page_asks_nothing_of_the_network(reported):
    here, _ = reported
    page = (here / "a/report/report.html").read_text(encoding="utf-8")
    links = re.findall(
        r"(?:src|href|action|data|poster)\s*=\s*[\"']?([^\"'\s>]{1,30})", page
    )
    assert links and all(link.startswith("data:image/png") for link in links)
    assert not re.search(r"<script|<link|<iframe|@import|url\(", page)
    addresses = set(re.findall(r"https?://[^\s\"'<]+", page))
    assert addresses <= {"http://www.w3.org/1998/Math/MathML"}
    assert "default-src 'none'" in page
    assert page.count("<math") >= 5 and "$" not in re.sub(r"<[^>]*>", "", page)


def test_page_says_what_was_asked_and_what_to_take(reported):
    here, _ = reported
    page = (here / "a/report/report.html").read_text(encoding="utf-8")
    assert "<h1>Velocity-aided tracker</h1>" in page
    name = "Leondes-Novak filter, radar position (m) taken as accurate"
    assert f"Recommended: {name}, best constant gain, order 2." in page
    assert "the fixed-order filter is for stable plants" in page
    assert "Out[" not in page and "assert" not in page
    described = [
        words for _, words in re.findall(r"<img alt=(['\"])(.+?)\1", page, re.S)
    ]
    assert page.count("<img") == 5 == len(described)
    assert "star marks the recommended Leondes-Novak filter" in described[0]
    assert "Estimates of 3 states at " in described[3]


def test_plant_without_noise_is_reported_on(inside, tmp_path):
    """No observer is recommended, nor run; those of an earlier run do not stay.

    The record is too short to tell the noise.
    """
    (tmp_path / "plant.json").write_text(edited(Q=None, R=None))
    rows = (PLANTS / "tracker.csv").read_text().splitlines(keepends=True)
    (tmp_path / "short.csv").write_text("".join(rows[:4]))
    (tmp_path / "r").mkdir()
    for name in FILES | WITH_DATA:
        (tmp_path / "r" / name).write_text("of an earlier run")
    given = ("--out", "r", "--data", "short.csv")
    dry = inside("plant.json", *given, "--dry-run", cwd=tmp_path)
    run = inside("plant.json", *given, cwd=tmp_path)
    assert run.returncode == 0 and run.stdout == dry.stdout
    assert (
        "Q and R cannot be fitted to the record: the record is too short" in run.stderr
    )
    assert "observer.json is not written: nothing is recommended" in run.stderr
    page = (tmp_path / "r/report.html").read_text(encoding="utf-8")
    assert "Recommended:" not in page and "lb.fit_noise(plant, y)" in page
    assert "Noise gain against settling time, " in page and "nan" not in page
    assert "3 samples. No estimates, as no observer is recommended." in page
    left = WITH_DATA - {"observer.json", "estimates.csv"}
    assert {path.name for path in (tmp_path / "r").iterdir()} == left


def test_noises_that_were_fitted_are_tested_once(inside, tmp_path):
    """The description and the last section have one probability, as fitted."""
    rng, A, x, rows = np.random.default_rng(3), np.array([[1, 1], [0, 0.6]]), 0, []
    x = np.zeros(2)
    for _ in range(120):
        x = A @ x + rng.normal(size=2) * [0.2, 0.5]
        rows.append(str(x[0] + rng.normal()))
    lb.Plant(A, None, [[1, 0]], dt=1.0).to_json(tmp_path / "plant.json")
    (tmp_path / "data.csv").write_text("y1\n" + "\n".join(rows) + "\n")
    run = inside("plant.json", "--out", "r", "--data", "data.csv", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    asked = json.loads((tmp_path / "r/question.json").read_text())
    assert asked == {"fitted": 2}  # two variances of Q; that of R is the innovation's
    page = (tmp_path / "r/report.html").read_text(encoding="utf-8")
    said = re.findall(r"(?:are|are not) white: the sum[^;]*;", page)
    assert len(said) == 2 and len(set(said)) == 1
    assert "where 18 is expected" in said[0] and said[0] in run.stderr


def test_notebook_names_no_machine(reported):
    here, _ = reported
    notebook = json.loads((here / "a/report/design.ipynb").read_text(encoding="utf-8"))
    text = json.dumps(notebook)
    assert str(here) not in text and sys.prefix not in text
    counts = [c["execution_count"] for c in notebook["cells"] if "outputs" in c]
    assert counts == list(range(1, len(counts) + 1))


def edited(**changes):
    """The tracker's JSON with some keys changed; None leaves a key out."""
    data = json.loads((PLANTS / "tracker.json").read_text(encoding="utf-8")) | changes
    return json.dumps({key: value for key, value in data.items() if value is not None})


HEADER = "radar position (m),radar velocity (m/s)"
BAD_PLANTS = {
    "not JSON": ("{", "not a JSON file"),
    "not finite": (edited().replace("37.5", "NaN").replace("0.5", "NaN"), "NaN"),
    "not a number": (edited(A=[["__import__('os')"]]), "A must be"),
    "asymmetric R": (edited(R=[[1, 2], [0, 1]]), "R must be symmetric"),
    "unknown key": (edited(exec="1"), "exec"),
}
BAD_DATA = {
    "empty": ("", "empty"),
    "no rows": (HEADER, "no measurements"),
    "wrong columns": ("time,position\n1,2\n", "lacks the columns"),
    "column twice": (f"{HEADER},{HEADER}\n1,2,3,4\n", "more than once"),
    "ragged": (f"{HEADER}\n1,2\n1\n", "line 3: 1 cells"),
    "text": (f"{HEADER}\n1,2\n1,fast\n", "line 3: 'radar velocity .*'fast'"),
    "infinite": (f"{HEADER}\n1,inf\n", "line 2"),
    "underscored": (f"{HEADER}\n1,1_0\n", "line 2"),
    "binary": ("\x00\xff", "CSV|columns|NUL"),
}


def refused(run, pattern):
    """Status 1, one readable message, no traceback."""
    assert run.returncode == 1, run.stderr
    message = run.stderr.strip().splitlines()[-1]
    assert message.startswith("luenberger: ") and re.search(pattern, run.stderr)
    assert "Traceback" not in run.stderr and run.stdout == ""


@pytest.mark.parametrize(("text", "pattern"), BAD_PLANTS.values(), ids=BAD_PLANTS)
def test_refused_plant_leaves_the_earlier_report(
    reported, inside, tmp_path, text, pattern
):
    here, _ = reported
    (tmp_path / "plant.json").write_text(text)
    before = contents(here)
    refused(inside(tmp_path / "plant.json", "--out", "a/report", cwd=here), pattern)
    assert contents(here) == before


def test_plant_without_any_filter_is_refused_from_within_the_notebook(
    reported, inside, tmp_path
):
    """Position is not measured: nothing certain can be said of it."""
    here, _ = reported
    (tmp_path / "plant.json").write_text(edited(C=[[0, 1, 0], [0, 0, 1]]))
    before = contents(here)
    run = inside(tmp_path / "plant.json", "--out", "a/report", cwd=here)
    refused(run, "DesignError: no exact filter of any order exists: ")
    assert contents(here) == before and len(list(here.iterdir())) == 1


@pytest.mark.parametrize(("text", "pattern"), BAD_DATA.values(), ids=BAD_DATA)
def test_refused_data_leaves_the_earlier_report(
    reported, inside, tmp_path, text, pattern
):
    here, _ = reported
    (tmp_path / "data.csv").write_text(text, encoding="latin-1")
    before = contents(here)
    given = ("--data", tmp_path / "data.csv", "--out", "a/report")
    refused(inside(PLANTS / "tracker.json", *given, cwd=here), pattern)
    assert contents(here) == before


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        (("absent.json", "--out", "r"), "absent.json: No such file"),
        ((PLANTS / "tracker.json", "--out", "file"), "file is a file"),
        ((PLANTS / "tracker.json", "--out", "file/r"), "file"),
        ((PLANTS / "tracker.json", "--out", "mine"), "mine holds plant.json"),
        ((PLANTS / "tracker.json", "--out", "r", "--data", "absent.csv"), "absent.csv"),
    ],
    ids=["no plant", "out is a file", "out below a file", "out is in use", "no data"],
)
def test_refused_arguments_leave_everything_alone(inside, tmp_path, arguments, pattern):
    (tmp_path / "file").write_text("kept")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "plant.json").write_text("kept")
    before = contents(tmp_path)
    refused(inside(*arguments, cwd=tmp_path), pattern)
    assert contents(tmp_path) == before and not (tmp_path / "r").exists()


@pytest.mark.parametrize(
    "record, pattern",
    [
        ("y1\n1\n2\n3\n", "has no column of times; --sample DT says how many"),
        ("t,y1\n0,1\n1,2\n3,3\n", "3 rows of .* at no constant period, 1 to 2 s"),
    ],
    ids=["no times", "uneven"],
)
def test_a_continuous_plant_needs_the_period_of_the_record(
    inside, tmp_path, record, pattern
):
    (tmp_path / "data.csv").write_text(record)
    plant = lb.Plant([[-1]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    plant.to_json(tmp_path / "plant.json")
    given = ("plant.json", "--data", "data.csv", "--out", "r")
    refused(inside(*given, cwd=tmp_path), pattern)
    assert not (tmp_path / "r").exists()


def test_a_dry_run_names_what_a_run_writes(reported, inside, tmp_path):
    _, run = reported
    given = (PLANTS / "tracker.json", "--out", "a/report", "--dry-run")
    dry = inside(*given, "--data", PLANTS / "tracker.csv", cwd=tmp_path)
    assert dry.returncode == 0 and dry.stdout == run.stdout
    without = inside(*given, cwd=tmp_path).stdout.split()
    assert {pathlib.Path(name).name for name in without} == FILES
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("sigint")
@pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's")
def test_interrupted_run_leaves_nothing(inside, monkeypatch, tmp_path):
    beside = []  # the working folder, next to the one to come

    def interrupting(step, steps, title):
        if step == 2:
            beside.extend(tmp_path.iterdir())
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(design, "_show_progress", interrupting)
    run = inside(PLANTS / "tracker.json", "--out", "r", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (130, "") and "interrupted" in run.stderr
    assert beside and list(tmp_path.iterdir()) == []


def test_a_second_report_on_a_combination_of_the_states(reported, inside, tmp_path):
    """The earlier report is replaced, where nothing of the old question stays.

    With readings missing, so that the filter of all states stands in for an observer.
    Names are text, not markup.
    """
    here, _ = reported
    shutil.copytree(here / "a", tmp_path / "a")
    (tmp_path / "a/report/question.json").write_text("{}")  # of another budget
    rows = (PLANTS / "tracker.csv").read_text().splitlines()[:12]
    rows[4] = rows[4].rpartition(",")[0] + ","
    rows[5] = "5,NaN,NaN"
    (tmp_path / "data.csv").write_text("\n".join(rows))
    names = ["<img src=x onerror=1>", "$x$", "[a](javascript:1)"]
    plant = edited(name="</title><script>alert(1)</script>", state_names=names)
    (tmp_path / "plant.json").write_text(plant)
    given = ("--out", "a/report", "--data", "data.csv", "--k", "climb (m/s)=1,2,1")
    run = inside("plant.json", *given, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    made = tmp_path / "a/report"
    assert {p.name for p in made.iterdir()} == WITH_DATA
    plant, row = lb.Plant.from_json(made / "plant.json"), [1.0, 2, 1]
    assert {k: v.tolist() for k, v in plant.estimates.items()} == {"climb (m/s)": row}
    observer = lb.Observer.from_json(made / "observer.json")
    assert observer.estimate_names == ("climb (m/s)",)
    header, *lines = (made / "estimates.csv").read_text().splitlines()
    assert header == "time,climb (m/s),climb (m/s)_sigma"
    y = np.genfromtxt(rows[1:], delimiter=",")[:, 1:3]
    done = lb.Filter(plant, lb.compare(plant).chosen.accurate).run(y)
    found = np.array([line.split(",")[1:] for line in lines], float)
    np.testing.assert_allclose(found[:, 0], done.x @ row, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1] ** 2, row @ done.P @ row, rtol=1e-9)
    assert found[4, 1] > 1.05 * found[3, 1]  # nothing measured
    page = (made / "report.html").read_text(encoding="utf-8")
    assert "3 of 22 measurements are missing" in page
    assert "Estimates of 1 estimate at 11 samples" in page
    assert "&lt;script&gt;alert(1)" in page and "&lt;img src=x onerror=1" in page
    assert not re.search(r"<script|<img src=x|href=.javascript", page)
