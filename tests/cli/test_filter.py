"""`python -m luenberger filter`: a record with gaps, rates, dates, of any length."""

import dataclasses
import pathlib
import re

import numpy as np
import pandas as pd
import pytest

import luenberger as lb
from luenberger.cli import main

MOTOR = lb.Plant(
    [[0, 1], [-2, -0.5]], [[0], [1]], np.eye(2), Q=np.diag([0, 0.3]),
    R=np.diag([0.01, 0.04]), P0=np.eye(2), x0=[0.5, -1],
    state_names=["angle", "speed"], output_names=["encoder", "tacho"],
    input_names=["voltage"],
)  # fmt: skip
EVEN = MOTOR.sampled(0.1)
START = np.datetime64("2026-01-05T10:00:00")


def record(rows=300, seed=3):
    """Two sensors with rates of their own that drop out, at uneven dates."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.integers(20, 180, rows)).astype("timedelta64[ms]")
    frame = pd.DataFrame(
        rng.normal(size=(rows, 3)), START + t, ["encoder", "tacho", "voltage"]
    )
    frame.loc[np.arange(rows) % 5 != 0, "tacho"] = np.nan
    frame.loc[rng.random(rows) < 0.2, "encoder"] = np.nan
    return frame.rename_axis("time")


@pytest.fixture
def call(tmp_path, monkeypatch, capfd):
    """Run the command in this process: status, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    MOTOR.to_json("motor.json")
    EVEN.to_json("even.json")
    frame = record()
    frame.assign(note="n/a").to_csv("data.csv")
    frame.set_axis(pd.Index(np.arange(1, 301) / 10, name="time")).to_csv("even.csv")

    def run(line):
        status = main(["filter", *line.split()])
        return status, *capfd.readouterr()

    return run


def numbers(path="x.csv"):
    """The times as text, the states and their one sigmas."""
    found = pd.read_csv(path, index_col=0)
    assert list(found) == ["angle", "angle_sigma", "speed", "speed_sigma"]
    return list(found.index), found.to_numpy()[:, ::2], found.to_numpy()[:, 1::2]


@pytest.fixture(params=[1 << 18, 499], ids=["one piece", "many pieces"])
def piece(request, monkeypatch):
    monkeypatch.setattr(
        "luenberger.formats.csv_table.Table.__init__.__defaults__", (request.param,)
    )


def test_a_record_is_filtered_at_its_instants(call, piece):
    status, out, err = call("motor.json data.csv --out x.csv")
    assert (status, out) == (0, "x.csv\n") and "300 rows of ['time', 'angle'" in err
    times, x, std = numbers()
    wanted = lb.Filter(MOTOR).run(record())
    np.testing.assert_allclose(x, wanted.x, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(std, wanted.std, rtol=1e-10)
    text = pathlib.Path("data.csv").read_text().splitlines()[1:]
    assert times == [line.split(",")[0] for line in text]


def test_a_lag_gives_the_smoothed_record(call, piece):
    """They are those of the plant that varies over the whole record."""
    frame = record()
    assert call("motor.json data.csv --lag 7 --out x.csv")[0] == 0
    seconds = (frame.index - frame.index[0]).total_seconds().to_numpy()
    steps = np.diff(seconds).round(3)
    varying = lb.sampling.discretise(MOTOR, np.concatenate([steps[:1], steps]))
    y, u = frame[["encoder", "tacho"]].to_numpy(), frame[["voltage"]].to_numpy()
    wanted = lb.Filter(varying).smooth(lb.Record(y, u), lag=7)
    _, x, std = numbers()
    np.testing.assert_allclose(x, wanted.x, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(std, wanted.std, rtol=1e-9)
    whole = lb.Filter(MOTOR).smooth(frame, lag=7)
    np.testing.assert_allclose(whole.w, wanted.w, rtol=1e-9, atol=1e-11)
    every = lb.Filter(MOTOR).smooth(lb.Record(y, u, time=seconds))
    same = lb.Filter(varying).smooth(lb.Record(y, u))
    np.testing.assert_allclose(every.x, same.x, atol=1e-9)


def test_a_start_may_be_unknown_with_a_lag(call, piece):
    """A few rows are held, and they are those of the whole record."""
    one = dataclasses.replace(MOTOR, P0=None)
    one.to_json("motor.json")
    for lag in (0, 7):
        assert call(f"motor.json data.csv --lag {lag} --out x.csv")[0] == 0
        wanted = lb.Filter(one).smooth(record(), lag=lag)
        _, x, std = numbers()
        np.testing.assert_allclose(x, wanted.x, rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(std, wanted.std, rtol=1e-9)


def test_no_rows_are_no_estimates():
    none = np.zeros((0, 2)), np.zeros((0, 1))
    for found in (
        lb.Filter(MOTOR).run(lb.Record(*none, time=[])),
        lb.Filter(MOTOR).smooth(lb.Record(*none, time=[])),
    ):
        assert found.x.shape == found.std.shape == (0, 2)


def test_a_discrete_plant_keeps_its_period(call):
    assert call("even.json even.csv --out x.csv")[0] == 0
    _, x, _ = numbers()
    wanted = lb.Filter(EVEN).run(record().reset_index(drop=True))
    np.testing.assert_allclose(x, wanted.x, rtol=1e-12)
    status, _, err = call("even.json data.csv --out no.csv")
    assert status == 1 and "data.csv, line 3: " in err and "dt = 0.1 s" in err
    assert "the command `filter`, the continuous plant" in err
    assert not pathlib.Path("no.csv").exists()


def test_rows_without_times_are_a_period_apart(call):
    record().reset_index(drop=True).to_csv("plain.csv", index=False)
    status, _, err = call("motor.json plain.csv --out x.csv")
    assert status == 1 and "plain.csv has no column 'time'" in err
    assert "--sample DT" in err
    assert call("motor.json plain.csv --out x.csv --sample 0.1")[0] == 0
    wanted = lb.Filter(EVEN).run(record().reset_index(drop=True))
    np.testing.assert_allclose(numbers()[1], wanted.x, rtol=1e-12)


def test_a_missing_input_is_zero_only_if_that_is_said(call):
    record().drop(columns="voltage").to_csv("free.csv")
    status, _, err = call("motor.json free.csv --out x.csv")
    assert status == 1 and "lacks the columns ['voltage']" in err
    assert call("motor.json free.csv --out x.csv --undriven")[0] == 0
    np.testing.assert_allclose(
        numbers()[1],
        lb.Filter(MOTOR).run(lb.Record(record(), 0)).x,
        rtol=1e-10,
        atol=1e-12,
    )


def test_estimate_points_to_filter(call, capfd):
    """Where a plant is given, and where a measurement is missing."""
    assert main(["estimate", "motor.json", "data.csv", "--out", "x.csv"]) == 1
    assert "`luenberger filter` takes a plant" in capfd.readouterr().err
    lb.kalman_filter(EVEN).named(EVEN).to_json("observer.json")
    assert main(["estimate", "observer.json", "even.csv", "--out", "x.csv"]) == 1
    assert "`luenberger filter PLANT.json` can" in capfd.readouterr().err


WRONG = {
    "2026-01-05T09:00:00,1,,0": "its time is .* times must grow from row to row",
    "noon,1,,0": "'time' is 'noon', not a date, as in the rows before. Write",
    "2026-01-06T10:00:00,1,,": "'voltage' is '', not a number",
    "2026-01-06T10:00:00,one,,0": "'encoder' is 'one', not a number",
}


@pytest.mark.parametrize(("row", "message"), WRONG.items(), ids=WRONG)
def test_what_is_wrong_is_named_by_its_line(call, row, message):
    with open("data.csv", "w") as file:
        file.write(record(20).to_csv() + row + "\n")
    status, out, err = call("motor.json data.csv --out x.csv")
    assert (status, out) == (1, "") and "data.csv, line 22: " in err
    assert re.search(message, err) and not pathlib.Path("x.csv").exists()


def test_one_row_and_a_plant_without_noise(call):
    record(1).to_csv("one.csv")
    status, _, err = call("motor.json one.csv --out x.csv")
    assert status == 1 and "one row has no sampling period" in err
    dataclasses.replace(MOTOR, Q=None).to_json("motor.json")
    status, _, err = call("motor.json data.csv --out x.csv")
    assert status == 1 and "the plant has no Q" in err


@pytest.mark.parametrize("lag", ["", "--lag 7"])
def test_memory_does_not_grow_with_the_record(call, peaks, lag):
    """More rows take less than the room of one number each."""
    pytest.importorskip("numba", reason="numba is an optional extra")
    for rows in (300, 3000, 9000):
        record(rows).to_csv("long.csv")
        line = f"motor.json long.csv --out x.csv {lag}"
        status, _, err = call(line)
        assert status == 0 and f"{rows} rows" in err
    _, few, many = peaks  # the first loads what compiles
    assert many - few < 8 * 6000
