"""`python -m luenberger filter --arrival`: readings that a file says are late."""

import numpy as np
import pandas as pd
import pytest

import luenberger as lb
from luenberger.cli import main
from luenberger.formats import csv_table

N = 400
PLANT = lb.Plant(
    [[1, 0.1], [0, 1]], None, np.eye(2), dt=0.1, Q=np.diag([0, 0.1]),
    R=np.diag([1, 0.25]), P0=np.eye(2), state_names=["position", "speed"],
    output_names=["satellite", "wheel"],
)  # fmt: skip


@pytest.fixture
def frame():
    """Positions that arrive half a second late, of which some never do."""
    y = np.random.default_rng(3).normal(size=(N, 2))
    time = np.arange(1, N + 1) / 10
    frame = pd.DataFrame(y, pd.Index(time, name="time"), ["satellite", "wheel"])
    frame["known"] = time + 0.45
    frame.loc[time[50:60], "known"] = np.nan
    frame.iloc[20:30, 1] = np.nan
    return frame


@pytest.fixture
def call(tmp_path, monkeypatch, capfd, frame):
    """Run the command in this process: status, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    PLANT.to_json("plant.json")
    frame.to_csv("data.csv")

    def run(options, out="x.csv"):
        line = f"filter plant.json data.csv {options} --out {out}"
        try:
            status = main(line.split())
        except SystemExit as end:  # options that do not go together
            status = end.code
        return status, *capfd.readouterr()

    return run


LATE = "--arrival satellite=known"


@pytest.mark.parametrize("piece", [csv_table.PIECE, 1000])
def test_it_is_the_filter_of_a_record(call, frame, piece, monkeypatch):
    monkeypatch.setattr(csv_table.Table.__init__, "__defaults__", (piece,))
    status, _, problem = call(LATE)
    assert status == 0, problem
    found = pd.read_csv("x.csv", index_col=0)
    wanted = lb.Filter(PLANT).run(lb.Record(frame, arrival={"satellite": "known"}))
    states = ["position", "speed"]
    np.testing.assert_allclose(found[states], wanted.x, rtol=0, atol=1e-12)
    sigmas = [f"{name}_sigma" for name in states]
    np.testing.assert_allclose(found[sigmas], wanted.std, rtol=0, atol=1e-12)


def test_rows_are_counted_from_one_where_there_are_no_times(call, frame):
    rows = np.arange(1.0, N + 1)
    frame["known"] = np.where(np.isnan(frame["known"]), np.nan, rows + 5)
    frame.to_csv("data.csv", index=False)
    status, _, problem = call(LATE)
    assert status == 0, problem
    arrival = np.column_stack([frame["known"] - 1, rows - 1])
    y = frame[["satellite", "wheel"]].to_numpy()
    wanted = lb.Filter(PLANT).run(lb.Record(y, arrival=arrival))
    found = pd.read_csv("x.csv", index_col=0)
    np.testing.assert_allclose(found["position"], wanted.x[:, 0], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (f"{LATE} --lag 3", "does not go with --lag"),
        ("--arrival satellite", "give OUTPUT=COLUMN"),
        ("--arrival camera=known", "--arrival has ['camera']; outputs are"),
        ("--arrival wheel=heard", "the columns ['heard'] of arrivals"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(call, options, said):
    status, _, problem = call(options)
    assert status and said in problem


@pytest.fixture
def dated(frame):
    """The same with dates in both columns."""
    since = pd.Timestamp("2026-01-05")
    known = since + pd.to_timedelta(frame["known"].round(3), unit="s")
    dates = since + pd.to_timedelta(frame.index.to_numpy().round(3), unit="s")
    return frame.assign(known=known).set_axis(dates.rename("time"))


@pytest.mark.parametrize("piece", [csv_table.PIECE, 1000])
def test_dates_are_taken_as_numbers_are(call, dated, piece, monkeypatch):
    """Through every piece of the file they count from the first of all."""
    monkeypatch.setattr(csv_table.Table.__init__, "__defaults__", (piece,))
    assert call(LATE)[0] == 0
    wanted = pd.read_csv("x.csv", index_col=0).to_numpy()
    dated.to_csv("data.csv", date_format="%Y-%m-%dT%H:%M:%S.%f")
    status, _, problem = call(LATE)
    assert status == 0, problem
    found = pd.read_csv("x.csv", index_col=0)
    np.testing.assert_array_equal(found, wanted)
    assert found.index[0] == "2026-01-05T00:00:00.100000"


@pytest.mark.parametrize(
    ("kind", "cell", "said"),
    [
        ("dated", "2026-01-05T00:00:00.5", "before the reading was measured at 2026"),
        ("dated", "3.5", "'known' is '3.5', which is not a date"),
        ("dated", "2026-01-05T00:00:01Z", "which is not a date, or lacks the zone of"),
        ("dated", "soon", "'known' is 'soon', which is not a date"),
        ("frame", 0.5, "'known' is 0.5, before the reading was measured at 0.8"),
        ("frame", "2026-01-05T00:00:01", "'2026-01-05T00:00:01', which is not a num"),
        ("frame", "soon", "'known' is 'soon', which is not a number"),
        ("frame", "inf", "'known' is 'inf', which is not a number"),
    ],
)
def test_an_arrival_that_does_not_fit_is_refused_by_line(
    call, request, kind, cell, said
):
    frame = request.getfixturevalue(kind)
    known = frame["known"]
    known = known.dt.strftime("%Y-%m-%dT%H:%M:%S.%f") if kind == "dated" else known
    frame["known"] = known.astype(object)
    frame.iloc[7, 2] = cell
    frame.to_csv("data.csv", date_format="%Y-%m-%dT%H:%M:%S.%f")
    status, _, problem = call(LATE)
    assert status and "line 9: 'known' is" in problem and said in problem


def test_a_column_of_dates_beside_numbers_is_refused(call, frame, dated):
    frame.assign(known=dated["known"].to_numpy()).to_csv("data.csv")
    status, _, problem = call(LATE)
    assert status and "line 2: 'known' is" in problem and "not a number" in problem


@pytest.mark.parametrize("piece", [csv_table.PIECE, 1000])
def test_continuous_plants_are_sampled_at_the_rows(call, frame, piece, monkeypatch):
    monkeypatch.setattr(csv_table.Table.__init__, "__defaults__", (piece,))
    motor = lb.Plant(
        [[0, 1], [0, 0]], None, np.eye(2), Q=np.eye(2), R=np.eye(2), P0=np.eye(2),
        output_names=["satellite", "wheel"],
    )  # fmt: skip
    motor.to_json("plant.json")
    frame = frame.drop(frame.index[100:110])
    frame.to_csv("data.csv")
    status, _, problem = call(LATE)
    assert status == 0, problem
    record = lb.Record(frame, arrival={"satellite": "known"})
    wanted = lb.Filter(motor).run(record).x
    found = pd.read_csv("x.csv")[list(motor.state_names)].to_numpy()
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
    assert call(f"{LATE} --sample 0.1")[0] == 1  # its rows are not 0.1 s apart


@pytest.mark.parametrize("dates", [False, True])
def test_arrivals_that_rounding_puts_behind_a_row_are_at_it(dates, call, frame):
    time = np.arange(1, N + 1) * 0.1
    known = time + 0.3
    assert (known[:-3] > time[3:]).any()
    if dates:
        start = pd.Timestamp("2026-01-05T10:00:00")
        pair = (start + pd.to_timedelta(one, unit="s") for one in (time, known))
        time, known = (one.round("us") for one in pair)
        known = known + pd.Timedelta("1us")
    texts = [str(one) for one in time], [str(one) for one in known]
    frame.index = pd.Index(texts[0], name="time")
    frame["known"] = texts[1]
    frame.to_csv("data.csv")
    status, _, err = call(LATE)
    assert status == 0, err
    rows = np.arange(N)[:, None] + [[3, 0]]
    expected = lb.Filter(PLANT).run(
        lb.Record(frame[list(PLANT.output_names)].to_numpy(), arrival=rows)
    )
    found = pd.read_csv("x.csv")[list(PLANT.state_names)].to_numpy()
    assert np.abs(found - expected.x).max() < 1e-12
