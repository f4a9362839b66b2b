"""`python -m luenberger design`: what it writes, and what it leaves when it fails."""

import csv
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
from datetime import datetime
from importlib.metadata import version

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main
from luenberger.comparison import METHODS

ROOT = pathlib.Path(__file__).parents[2]
PLANTS = ROOT / "notebooks" / "plants"
FILES = {"report.html", "observer.json", "designs.csv", "plant.json"}
WITH_DATA = FILES | {"data.csv", "estimates.csv"}


@pytest.fixture
def inside(monkeypatch, capfd):
    """The command in this process."""

    def run(*arguments, cwd):
        monkeypatch.chdir(cwd)
        status = main(["design", *map(str, arguments)])
        return subprocess.CompletedProcess(arguments, status, *capfd.readouterr())

    return run


def contents(folder):
    """Every file below a folder and what is in it."""
    return {p: p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    """A folder with a finished report on the tracker, and what the command said."""
    here = tmp_path_factory.mktemp("command")
    line = ["design", PLANTS / "tracker.json", "--out=a/report"]
    run = subprocess.run(
        [sys.executable, "-m", "luenberger", *line, "--data", PLANTS / "tracker.csv"],
        capture_output=True, text=True, cwd=here, timeout=300,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return here, run


def test_what_was_read_is_kept_as_it_was(reported):
    here, _ = reported
    for name, given in (("plant.json", "tracker.json"), ("data.csv", "tracker.csv")):
        assert (here / "a/report" / name).read_bytes() == (PLANTS / given).read_bytes()


def test_files_and_nothing_else(reported):
    here, run = reported
    found = {str(path.relative_to(here)) for path in here.rglob("*") if path.is_file()}
    assert found == {f"a/report/{name}" for name in WITH_DATA}
    assert set(run.stdout.split()) == found and run.stdout.endswith("report.html\n")


def test_observer_is_certified_and_as_accurate_as_its_table_says(reported):
    here, _ = reported
    plant = lb.Plant.from_json(PLANTS / "tracker.json")
    observer = lb.Observer.from_json(here / "a/report/observer.json")
    lb.certify(observer, plant).require()
    with open(here / "a/report/designs.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["accurate"] for row in rows][:2] == ["", "radar position (m)"]
    sigma = np.sqrt(lb.error_covariance(observer, plant).diagonal())
    (chosen,) = [row for row in rows if row["recommended"] == "yes"]
    found = [float(one) for one in chosen["sigma"].split()]
    assert found == pytest.approx(sigma.tolist(), rel=1e-9)
    assert int(chosen["order"]) == observer.order == 2
    assert float(chosen["excess"]) < 0.1
    assert {row["method"] for row in rows} == set(METHODS)
    refused = [row for row in rows if row["refusal"]]
    assert refused and all(row["error"] == "" for row in refused)


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
    assert not re.search(r"https?://", page)
    assert "default-src 'none'" in page and "nan" not in page


def test_page_says_what_was_asked_and_what_to_take(reported):
    here, _ = reported
    page = (here / "a/report/report.html").read_text(encoding="utf-8")
    assert "<h1>Velocity-aided tracker</h1>" in page
    name = "Leondes-Novak filter, radar position (m) taken as accurate"
    assert f"Recommended: {name}, best constant gain, order 2." in page
    assert "the fixed-order filter is for stable plants" in page
    described = re.findall(r'<img alt="([^"]+)"', page)
    assert page.count("<img") == 9 == len(described)
    assert any("recommended" in words for words in described)
    assert sum(words.startswith("Estimates of ") for words in described) == 3
    sigma = np.sqrt(lb.error_covariance(*self_and_plant(here)).diagonal())
    box = page[page.index('<div class="box">') : page.index("</div>")]
    assert f"velocity {sigma[1]:.4g} m/s" in box and "agrees with the model" in box
    assert "Next: <code>luenberger export observer.json" in box
    assert f"luenberger {version('luenberger')}, {datetime.now():%Y-}" in page
    assert f"luenberger design {PLANTS / 'tracker.json'} --out=a/report" in page


def self_and_plant(here):
    observer = lb.Observer.from_json(here / "a/report/observer.json")
    return observer, lb.Plant.from_json(PLANTS / "tracker.json")


def test_the_lines_of_python_on_the_page_run(reported, monkeypatch):
    here, _ = reported
    monkeypatch.chdir(here / "a/report")
    page = pathlib.Path("report.html").read_text(encoding="utf-8")
    [code] = re.findall(r"<pre>(.*?)</pre>", page, re.S)
    names = {}
    exec(html.unescape(code), names)
    assert names["table"].chosen.observer.order == names["observer"].order
    assert len(names["found"].x) == 40


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
    assert "nan" not in page
    assert "3 samples. No estimates, as no observer is recommended." in page
    left = WITH_DATA - {"observer.json", "estimates.csv"}
    assert {path.name for path in (tmp_path / "r").iterdir()} == left


def test_noises_that_were_fitted_are_tested_once(inside, tmp_path):
    """One probability, as fitted, and each number with its error."""
    rng, A, x, rows = np.random.default_rng(3), np.array([[1, 1], [0, 0.6]]), 0, []
    x = np.zeros(2)
    for _ in range(120):
        x = A @ x + rng.normal(size=2) * [0.2, 0.5]
        rows.append(str(x[0] + rng.normal()))
    lb.Plant(A, None, [[1, 0]], dt=1.0).to_json(tmp_path / "plant.json")
    (tmp_path / "data.csv").write_text("y1\n" + "\n".join(rows) + "\n")
    run = inside("plant.json", "--out", "r", "--data", "data.csv", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    page = (tmp_path / "r/report.html").read_text(encoding="utf-8")
    [told] = re.findall(r"(?:are|are not) white: the sum[^;]*;", page)
    assert "where 18 is expected" in told and told in run.stderr
    cells = re.findall(r'data-label="entry">([^<]*)<', page)
    assert cells == ["Q[0,0]", "Q[1,1]", "R[0,0]"]


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
    "binary": ("\x00\xff", "not UTF-8 text"),
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


def test_plant_without_any_filter_is_refused(reported, inside, tmp_path):
    """Position is not measured: nothing certain can be said of it."""
    here, _ = reported
    (tmp_path / "plant.json").write_text(edited(C=[[0, 1, 0], [0, 0, 1]]))
    before = contents(here)
    run = inside(tmp_path / "plant.json", "--out", "a/report", cwd=here)
    refused(run, "no design exists: ")
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


def test_a_second_report_on_a_combination_of_the_states(reported, inside, tmp_path):
    """The earlier report is replaced, where nothing of the old question stays.

    With readings missing, so that the filter of all states stands in for an observer.
    Names are text, not markup.
    """
    here, _ = reported
    shutil.copytree(here / "a", tmp_path / "a")
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
    assert "&lt;script&gt;alert(1)" in page and "&lt;img src=x onerror=1" in page
    assert not re.search(r"<script|<img src=x|href=.javascript", page)
