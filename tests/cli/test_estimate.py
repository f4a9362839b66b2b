"""`python -m luenberger estimate`: long files, any columns, and what is refused."""

import dataclasses
import io
import json
import pathlib
import re

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main
from luenberger.formats import csv_table
from luenberger.run import measurements

ROOT = pathlib.Path(__file__).parents[2]
PLANT = lb.Plant(
    [[0.9, 0.5], [0, 0.8]], [[0], [1]], [[1, 0], [1, 1]], E=[[0], [0.5]], dt=0.5,
    Q=np.eye(2) / 4, R=np.eye(2), P0=np.eye(2), x0=[1, 2],
    state_names=["position", "speed"], output_names=["radar", "a, b"],
    input_names=["push"],
)  # fmt: skip
OBSERVER = lb.reduced_order_filter(PLANT, 1)
TIMES = ["2024-01-01T00:00", "2024-01-01 00:00:00.5", '"2024-01-01T00:00:01,0"',
         "20240101T000001.5", "2024-01-01T00:00:02"]  # fmt: skip
Y = np.array([[1.5, 2], [0.1, -3], [1e-3, 7], [2, 0.25], [1 / 3, 1]])
U = np.array([[0], [1], [0.7], [-1], [0.1]])


def table(times=TIMES, y=Y, u=U, header='note,push,time,"a, b",radar'):
    rows = [header]
    for k in range(len(y)):
        rows.append(f"n/a,{u[k, 0]!r},{times[k]},{y[k, 1]!r},{y[k, 0]!r}")
    return "\n".join(rows).replace("np.float64(", "").replace(")", "") + "\n"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    OBSERVER.to_json("observer.json")
    PLANT.to_json("plant.json")
    pathlib.Path("data.csv").write_text(table())
    return tmp_path


@pytest.fixture
def call(here, capfd):
    """Run the command in this process: status, stdout, stderr."""

    def run(*arguments):
        status = main(["estimate", *arguments])
        return status, *capfd.readouterr()

    return run


@pytest.fixture
def smooth(here, capfd):
    def run(*arguments):
        status = main(["filter", *arguments])
        return status, *capfd.readouterr()

    return run


def columns(text):
    """The names, times and numbers of an estimates file, by hand."""
    header, *rows = text.splitlines()
    cut = [row.rsplit(",", header.count(",")) for row in rows]
    return header.split(","), [row[0] for row in cut], np.array(
        [row[1:] for row in cut], dtype=float
    )  # fmt: skip


def test_estimates_are_those_of_the_library_to_the_bit(here, call):
    status, out, err = call("observer.json", "data.csv", "--out", "x.csv")
    assert (status, out) == (0, "x.csv\n") and "5 rows" in err
    names, times, x = columns((here / "x.csv").read_text())
    assert names == ["time", "position", "speed"] and times == TIMES
    np.testing.assert_array_equal(x, lb.estimate(OBSERVER, lb.Record(Y, U)))


def test_with_a_plant_they_are_those_of_the_report(here, call):
    """They start from its x0, carried to the first sample."""
    assert call("observer.json", "data.csv", "--plant", "plant.json", "--out=x")[0] == 0
    _, _, x = columns((here / "x").read_text())
    record = measurements.Measurements(Y, U, np.arange(5.0))
    report = measurements.apply(OBSERVER, (0,), PLANT, record)
    np.testing.assert_array_equal(x, report.x)
    assert np.abs(x - lb.estimate(OBSERVER, lb.Record(Y, U))).max() > 1e-3
    left = np.eye(2) - OBSERVER.V @ PLANT.C  # of the error that x0 has
    first = left @ PLANT.at_first_sample().P0 @ left.T
    first += OBSERVER.V @ PLANT.R @ OBSERVER.V.T
    np.testing.assert_allclose(report.std[0], np.sqrt(first.diagonal()), rtol=1e-12)


def test_without_times_rows_are_counted(here, call, monkeypatch):
    text = table(header='note,push,x,"a, b",radar')
    (here / "data.csv").write_text(text)
    monkeypatch.setattr(
        "luenberger.formats.csv_table.Table.__init__.__defaults__", (30,)
    )
    status, out, _ = call("observer.json", "data.csv", "--out", "-")
    names, times, x = columns(out)
    assert status == 0 and names[0] == "instant"
    assert times == ["1", "2", "3", "4", "5"]
    np.testing.assert_allclose(x, lb.estimate(OBSERVER, lb.Record(Y, U)), rtol=1e-13)


def test_many_pieces_are_one_record(here, call, monkeypatch):
    rng = np.random.default_rng(8)
    y, u = rng.normal(size=(2000, 2)), rng.normal(size=(2000, 1))
    times = [f"{k / 2}" for k in range(2000)]
    (here / "data.csv").write_text(table(times, y, u))
    assert call("observer.json", "data.csv", "--out", "whole")[0] == 0
    monkeypatch.setattr(
        "luenberger.formats.csv_table.Table.__init__.__defaults__", (999,)
    )
    assert call("observer.json", "data.csv", "--out", "pieces")[0] == 0
    one, other = (columns((here / n).read_text()) for n in ("whole", "pieces"))
    assert one[:2] == other[:2] and one[1] == times
    np.testing.assert_allclose(one[2], other[2], rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        one[2], lb.estimate(OBSERVER, lb.Record(y, u)), rtol=0, atol=1e-13
    )


def test_a_filter_over_steps_starts_from_the_plant(here, call):
    filter = lb.reduced_order_filter(PLANT, 1, steps=5)
    filter.to_json("observer.json")
    assert call("observer.json", "data.csv", "--out=x", "--plant=plant.json")[0] == 0
    _, _, x = columns((here / "x").read_text())
    np.testing.assert_array_equal(x, lb.estimate(filter, lb.Record(Y, U), x0=PLANT.x0))
    times = [f"{k / 2}" for k in range(10)]
    text = table(times=times, y=np.vstack([Y, Y]), u=np.vstack([U, U]))
    (here / "data.csv").write_text(text)
    status, _, err = call("observer.json", "data.csv", "--out", "x2")
    assert status == 1 and "y has 10 rows, the filter was designed for 5" in err


def test_an_observer_without_names_takes_them_from_the_plant_or_numbers(here, call):
    data = json.loads((here / "observer.json").read_text())
    data = {key: value for key, value in data.items() if not key.endswith("_names")}
    (here / "observer.json").write_text(json.dumps(data))
    status, _, err = call("observer.json", "data.csv", "--out", "-")
    assert status == 1 and "lacks the columns ['y1', 'y2', 'u1']" in err
    assert call("observer.json", "data.csv", "--plant=plant.json", "--out=x")[0] == 0
    assert columns((here / "x").read_text())[0] == ["time", "position", "speed"]
    (here / "data.csv").write_text("u1,y2,y1\n0,2,1.5\n")
    status, out, _ = call("observer.json", "data.csv", "--out", "-")
    assert status == 0 and columns(out)[0] == ["instant", "x1", "x2"]


def test_standard_input(here, call, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(open("data.csv", "rb")))
    status, out, _ = call("observer.json", "-", "--out", "-")
    assert status == 0 and columns(out)[1] == TIMES


def test_the_same_run_writes_the_same_bytes(here, call):
    for name in ("one", "other"):
        assert call("observer.json", "data.csv", "--out", name)[0] == 0
    assert (here / "one").read_bytes() == (here / "other").read_bytes()


# ------------------------------------------------------------------- what is refused


def changed(old, new):
    assert old in table()
    return table().replace(old, new, 1)


REFUSED = {
    "missing measurement": (
        changed("0.25,2.0", "0.25,"),
        r"data\.csv, line 5: 'radar' was not measured, .* cannot leave .* lb.Filter",
    ),
    "missing input": (changed("n/a,-1.0", "n/a,"), r"line 5: 'push' is '', not a num"),
    "text": (changed("0.25", "fast"), "line 5: 'a, b' is 'fast', not a number"),
    "column missing": (changed("push", "pull"), r"lacks the columns \['push'\]"),
    "column twice": (changed("note", "radar"), r"\['radar'\] occur more than once"),
    "no rows": ('push,"a, b",radar\n', "column names but no measurements"),
}


@pytest.mark.parametrize(("text", "pattern"), REFUSED.values(), ids=REFUSED)
def test_refused_data_leave_the_earlier_file(here, call, text, pattern):
    (here / "data.csv").write_text(text)
    (here / "x.csv").write_text("earlier")
    before = sorted(here.iterdir())
    status, out, err = call("observer.json", "data.csv", "--out", "x.csv")
    assert (status, out) == (1, "") and len(err.splitlines()) == 1
    assert err.startswith("luenberger: data.csv")
    assert re.search(pattern, err), err
    assert (here / "x.csv").read_text() == "earlier"
    assert sorted(here.iterdir()) == before


def test_blanks_around_a_name_do_not_count(here, call):
    names = dict(output_names=[" radar", "a, b\u00a0"], input_names=["push "])
    odd = dataclasses.replace(PLANT, **names)
    odd.to_json("plant.json")
    OBSERVER.named(odd).to_json("observer.json")
    call("observer.json", "data.csv", "--plant", "plant.json", "--out", "x")
    _, _, x = columns((here / "x").read_text())
    record = measurements.Measurements(Y, U, np.arange(5.0))
    report = measurements.apply(OBSERVER, (0,), PLANT, record)
    np.testing.assert_allclose(x, report.x, rtol=1e-12)
    text = table(["1", "1.5", "2", "2.5", "3"]).replace("n/a,", "")
    (here / "data.csv").write_text(text.replace("note,", ""))
    found = measurements.read("data.csv", odd)
    np.testing.assert_array_equal(found.y, Y)
    np.testing.assert_array_equal(found.time, [1, 1.5, 2, 2.5, 3])


@pytest.mark.parametrize("other", ["radar ", "radar"])
def test_names_that_are_one_column_are_refused(here, call, other):
    """Two outputs but for blanks, or an output and an input."""
    names = {"input_names" if other == "radar" else "output_names": [other]}
    names.setdefault("output_names", ["radar"])
    plant = lb.Plant([[0.5]], [[1]], [[1]], dt=1, **names)
    if other == "radar ":
        plant = lb.Plant([[0.5]], None, [[1], [2]], dt=1, output_names=["radar", other])
    observer = lb.reduced_order_observer(plant, [])
    observer.to_json("observer.json")
    (here / "data.csv").write_text("radar\n1\n")
    status, _, err = call("observer.json", "data.csv", "--out", "-")
    assert status == 1 and "['radar'] each name more than one output or input" in err


@pytest.mark.parametrize(
    ("change", "pattern"),
    [
        (dict(dt=0.25), "observer has dt=0.5 but the plant dt=0.25"),
        (dict(output_names=["radar", "lidar"]), r"outputs are \['radar', 'a, b'\]"),
        (
            dict(C=[[1, 0]], E=None, R=[[1]], output_names=None),
            r"n, m, p = \(2, 1, 2\)",
        ),
    ],
    ids=["another step", "other names", "other sizes"],
)
def test_a_plant_that_is_not_the_observers_is_refused(here, call, change, pattern):
    dataclasses.replace(PLANT, **change).to_json("plant.json")
    status, _, err = call("observer.json", "data.csv", "--plant=plant.json", "--out=x")
    assert status == 1 and not (here / "x").exists()
    assert re.search(pattern, err), err


@pytest.mark.parametrize("F", [0.5, 2.0], ids=["data too large", "not stable"])
def test_an_estimate_that_overflows_is_refused_with_its_line(here, call, F):
    """Every number of the record is finite, and the estimate is not."""
    observer = lb.Observer([[F]], [[]], [[1]], [[1]], [[10]], T=[[1]], L=[[1]], dt=1)
    observer.to_json("observer.json")
    large = "1e308" if F < 1 else "1"
    (here / "data.csv").write_text("y1\n" + "1\n" * 3 + f"{large}\n" + "1\n" * 1100)
    status, out, err = call("observer.json", "data.csv", "--out", "x.csv")
    line = 5 if F < 1 else 1026  # where z is 2^(line - 2) - 1, beyond floats
    assert (status, out) == (1, "") and not (here / "x.csv").exists()
    assert err.startswith(f"luenberger: data.csv, line {line}: the estimate of 'x1' ov")


def test_an_input_is_not_replaced(here, call):
    before = (here / "data.csv").read_bytes()
    (here / "link").symlink_to("data.csv")
    for out in ("data.csv", "link", "observer.json"):
        status, _, err = call("observer.json", "data.csv", "--out", out)
        assert status == 1 and "which is read" in err
    assert (here / "data.csv").read_bytes() == before


def test_an_observer_in_continuous_time_is_refused(here, call):
    dataclasses.replace(OBSERVER, dt=0.0).to_json("observer.json")
    status, _, err = call("observer.json", "data.csv", "--out", "x.csv")
    assert status == 1 and "need a discrete observer; this one has dt = 0" in err


def test_a_time_column_and_an_estimate_of_the_same_name(here, call):
    names = ("position", "time")
    OBSERVER.named(
        lb.Plant(PLANT.A, PLANT.B, PLANT.C, PLANT.E, state_names=names,
                 output_names=PLANT.output_names, input_names=PLANT.input_names)
    ).to_json("observer.json")  # fmt: skip
    status, _, err = call("observer.json", "data.csv", "--out", "-")
    assert status == 1 and "'time' would be the name of two columns" in err


# -------------------------------------------------------------------- how long a file


def test_memory_does_not_grow_with_the_record(call, peaks):
    """More rows take less than the room of one number each."""
    observer = lb.Observer(
        [[0.5]], [[]], [[0.25]], [[1]], [[0]], T=[[1]], L=[[1]], dt=1
    )
    observer.to_json("observer.json")
    for rows in (20_000, 40_000):
        text = "".join(f"{k},{k % 7}\n" for k in range(rows))
        pathlib.Path("long.csv").write_text("time,y1\n" + text)
        status, _, err = call("observer.json", "long.csv", "--out", "x.csv")
        assert status == 0 and f"{rows} rows" in err
    few, many = peaks
    assert many - few < 8 * 20_000


@pytest.mark.parametrize("option, lag", [("--smooth", None), ("--lag 2", 2)])
def test_a_plant_is_smoothed(smooth, here, option, lag):
    """Also where a measurement is missing; with the one sigma of each state."""
    y = Y.copy()
    y[2, 0] = np.nan
    pathlib.Path("data.csv").write_text(table(y=y).replace("nan", ""))
    status, out, err = smooth("plant.json", "data.csv", *option.split(), "--out", "-")
    assert status == 0, err
    head, *rows = out.splitlines()
    assert head == "time,position,position_sigma,speed,speed_sigma"
    found = np.array([row.rsplit(",", 4)[1:] for row in rows], dtype=float)
    wanted = lb.Filter(PLANT).smooth(lb.Record(y, U), lag)
    np.testing.assert_allclose(found[:, ::2], wanted.x, rtol=1e-12)
    np.testing.assert_allclose(found[:, 1::2], wanted.std, rtol=1e-12)
    assert [row.rsplit(",", 4)[0] for row in rows] == TIMES


@pytest.mark.parametrize("option", ["--smooth", "--lag 30"])
def test_a_long_table_is_smoothed_as_it_is(smooth, here, monkeypatch, option):
    rng, rows = np.random.default_rng(3), 300
    y, u = rng.normal(size=(rows, 2)), rng.normal(size=(rows, 1))
    text = table(times=[k / 2 for k in range(rows)], y=y, u=u)
    monkeypatch.setattr(csv_table.Table.__init__, "__defaults__", (len(text) // 3,))
    pathlib.Path("data.csv").write_text(text)
    status, _, err = smooth("plant.json", "data.csv", *option.split(), "--out", "e.csv")
    assert status == 0, err
    found = np.loadtxt("e.csv", delimiter=",", skiprows=1)
    lag = 30 if "lag" in option else None
    wanted = lb.Filter(PLANT).smooth(lb.Record(y, u), lag)
    np.testing.assert_allclose(found[:, 1::2], wanted.x)
    np.testing.assert_array_equal(found[:, 0], np.arange(rows) / 2)


def test_smoothing_takes_a_plant(smooth, here):
    status, _, err = smooth("observer.json", "data.csv", "--smooth", "--out", "e.csv")
    assert status == 1 and "does not hold a plant" in err
    assert not pathlib.Path("e.csv").exists()


@pytest.mark.parametrize(
    "options, message",
    [
        ("--lag=-1", "give a number of rows"),
        ("--lag 1.5", "give a number of rows"),
        ("--smooth --lag 2", "give --lag or --smooth"),
        ("--smooth --arrival radar=time", "does not go with --lag or --smooth"),
    ],
)
def test_wrong_options_of_smoothing(smooth, here, capfd, options, message):
    with pytest.raises(SystemExit, match="2"):
        smooth("plant.json", "data.csv", *options.split(), "--out", "e.csv")
    assert message in capfd.readouterr().err
