"""Instants of a record: held against dt, or where a continuous plant is sampled."""

import dataclasses
from datetime import datetime

import numpy as np
import pandas as pd
import pytest
from in_parts import in_parts

import luenberger as lb
from luenberger.formats import csv_table
from luenberger.run import measurements, tables
from luenberger.run.clock import periods

BALL = lb.Plant(
    [[0, 1], [0, 0]], [[0], [4.5]], [[1, 0]], Q=np.diag([0, 0.3]), R=[[0.01]],
    P0=np.eye(2), state_names=["position", "speed"], input_names=["angle"],
    output_names=["radar"],
)  # fmt: skip
EVEN = BALL.sampled(0.1)
START = np.datetime64("2026-01-05T10:00:00")


def record(t, seed=4):
    rng = np.random.default_rng(seed)
    return pd.DataFrame(rng.normal(size=(len(t), 2)), columns=["radar", "angle"])


def by_hand(t, frame, first):
    """The textbook filter, with the exact matrices of each period."""
    x, P, before, u = np.zeros(2), np.eye(2), t[0] - first, 0.0
    found = []
    for now, (y, angle) in zip(t, frame.to_numpy()):
        T, q = now - before, 0.3
        A = np.array([[1, T], [0, 1]])
        x = A @ x + 4.5 * np.array([T**2 / 2, T]) * u
        Q = q * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
        P = A @ P @ A.T + Q
        K = P[:, 0] / (P[0, 0] + 0.01)
        x, P = x + K * (y - x[0]), P - np.outer(K, P[0])
        before, u = now, angle
        found.append(x)
    return np.array(found)


UNEVEN = np.array([0.3, 0.35, 1.0, 1.2, 5.3, 5.4])


def dated(frame, t, zone=None):
    milliseconds = np.round(1000 * t).astype("timedelta64[ms]")
    frame.index = pd.DatetimeIndex(START + milliseconds, tz=zone)
    return frame


KINDS = {
    "index of seconds": lambda f, t: f.set_axis(t),
    "index called time": lambda f, t: f.set_axis(pd.Index(t, name="time")),
    "dates": dated,
    "dates with a zone": lambda f, t: dated(f, t, "Asia/Tokyo"),
    "durations": lambda f, t: f.set_axis(pd.to_timedelta(t, unit="s")),
    "column": lambda f, t: f.assign(time=t),
    "column of dates": lambda f, t: f.assign(
        t=START + (1000 * t).round().astype("m8[ms]")
    ),
    "column of text": lambda f, t: f.assign(
        Time=[str(START + np.timedelta64(round(1000 * one), "ms")) for one in t]
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_continuous_plant_is_sampled_at_the_records_instants(kind):
    frame = record(UNEVEN)
    expected = by_hand(UNEVEN, frame, 0.05)
    given = kind(frame.copy(), UNEVEN)
    found = lb.Filter(BALL).run(given)
    np.testing.assert_allclose(found.x.to_numpy(), expected, rtol=1e-9)
    assert found.x.index.equals(given.index)


@pytest.mark.parametrize(
    "time",
    [UNEVEN, list(UNEVEN), START + (1000 * UNEVEN).round().astype("m8[ms]"),
     [str(one) for one in UNEVEN]],
)  # fmt: skip
def test_instants_may_be_given_beside_arrays(time):
    frame = record(UNEVEN)
    y, u = frame[["radar"]].to_numpy(), frame[["angle"]].to_numpy()
    found = lb.Filter(BALL).run(lb.Record(y, u, time=time))
    np.testing.assert_allclose(found.x, by_hand(UNEVEN, frame, 0.05), rtol=1e-9)


def test_even_instants_are_the_plant_of_one_period():
    """0.1 s, whatever rounding is in the differences of the stamps."""
    t = np.arange(3, 103) / 10
    frame = record(t)
    same = lb.Filter(EVEN).run(frame)
    found = lb.Filter(BALL).run(frame.assign(time=t))
    np.testing.assert_array_equal(found.x.to_numpy(), same.x.to_numpy())
    assert set(periods(t)) == {0.1} and set(periods(1e9 + t)) == {0.1}
    assert set(periods(np.array([0, 1, 2.5, 3.5]))) == {1.0, 1.5}


def test_a_prior_needs_no_period_before_the_first_row():
    prior = dataclasses.replace(BALL, at_first=True)
    y = record(UNEVEN)[["radar"]].to_numpy()
    one = lb.Filter(prior).run(lb.Record(y, time=UNEVEN))
    assert one.P[0, 0, 0] == pytest.approx(1 / 101)  # 1 with a reading of 0.01


def test_missing_rows_are_longer_periods():
    """A record with rows left out is filtered like one with empty rows there."""
    t = np.arange(1, 31) / 10
    frame = record(t).assign(angle=0.0, time=t)
    keep = np.r_[0:10, 17, 20:30]
    left_out = lb.Filter(BALL).run(frame.iloc[keep])
    empty = frame.copy()
    empty.loc[~empty.index.isin(keep), "radar"] = np.nan
    every = lb.Filter(BALL).run(empty)
    for name in ("x", "std"):
        one, other = getattr(left_out, name), getattr(every, name).iloc[keep]
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


EVERY = np.arange(50) / 10


def changed(k, by):
    t = EVERY.copy()
    t[k:] += by
    return t


CONTRADICTING = {
    "a jump": (changed(20, 4.1), "^row 20: its time is 4.2 s after .* dt = 0.1 s"),
    "a second": (EVERY * 10, "^row 1: its time is 1 s after"),
    "twice": (changed(7, -0.1), "^row 7: its time is .* after"),
    "back": (EVERY[::-1], "^row 1: its time is -0.1 s after"),
    "a slow clock": (EVERY * 1.04, r"^row 13: it is .* s after the first row"),
    "missing": (np.where(EVERY == 3, np.nan, EVERY), "^row 30: its time is missing"),
}


@pytest.mark.parametrize(("t", "message"), CONTRADICTING.values(), ids=CONTRADICTING)
def test_stamps_that_contradict_dt_are_refused(t, message):
    frame = record(t)
    observer = lb.kalman_filter(EVEN).named(EVEN)
    for run in (lambda *a, **o: lb.Filter(EVEN).run(lb.Record(*a, **o)),
                lambda *a, **o: lb.estimate(observer, lb.Record(*a, **o))):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            run(frame.assign(time=t))
        run(frame.assign(time=t), time="rows")


def test_jitter_and_rounded_stamps_are_in_step():
    t = EVERY + np.random.default_rng(1).uniform(-0.02, 0.02, 50)
    for stamps in (t, EVERY.round(1), EVERY * 1.005, 5 + EVERY):
        lb.Filter(EVEN).run(lb.Record(record(t), time=stamps))


@pytest.mark.parametrize(
    "index", [None, [*range(5, 55)], [f"row {k}" for k in range(50)]]
)
def test_row_numbers_and_labels_are_no_stamps(index):
    frame = record(EVERY)
    frame.index = pd.RangeIndex(50) if index is None else index
    lb.Filter(EVEN).run(frame)


def stamps(t):
    return [str(START + np.timedelta64(round(1000 * one), "ms")) for one in t]


TEXTS = {
    "text": list,
    "strings": lambda t: pd.array(t, "string"),
    "Series of objects": lambda t: pd.Series(t, dtype=object),
    "datetimes": lambda t: pd.Index([*map(datetime.fromisoformat, t)], dtype=object),
    "a name": lambda t: pd.Index(t, name="taken"),
}


@pytest.mark.parametrize("kind", TEXTS.values(), ids=TEXTS)
def test_an_index_of_text_that_holds_dates_is_held_against_dt(kind):
    """As the reader of CSV files does, also where a cell is no date."""
    even, late = stamps(EVERY), stamps(changed(20, 4.1))
    frame = record(EVERY)
    found = lb.Filter(EVEN).run(frame.set_axis(kind(even)))
    np.testing.assert_array_equal(found.x, lb.Filter(EVEN).run(frame).x)
    uneven = frame.set_axis(kind(late))
    for y, u in ((uneven, None), (uneven["radar"], 0)):
        with pytest.raises(ValueError, match="^row 20: its time is 4.2 s after"):
            lb.Filter(EVEN).run(lb.Record(y, u))
        lb.Filter(EVEN).run(lb.Record(y, u, time="rows"))
    sampled = lb.Filter(BALL).run(frame.set_axis(kind(even)))
    np.testing.assert_allclose(sampled.x, found.x, rtol=1e-9)


@pytest.mark.parametrize(
    ("row", "text", "message"),
    [
        (0, "abc", "^row 0: the time is 'abc', not a number of seconds nor a date"),
        (7, "abc", "^row 7: the time is 'abc', not a date, as in the rows before"),
        (7, "3.5", "^row 7: the time is '3.5', not a date"),
        (7, "2026-01-05T10:00:00.7Z", "^row 7: .* with a zone, where .* have none"),
    ],
)
def test_an_index_of_dates_with_one_odd_cell_is_refused(row, text, message):
    index = stamps(EVERY)
    index[row] = text
    with pytest.raises(ValueError, match=message):
        lb.Filter(EVEN).run(record(EVERY).set_axis(index))


def test_a_column_of_times_goes_before_labels_that_are_dates():
    frame = record(EVERY).assign(time=EVERY).set_axis(["2026-01-05"] * 50)
    lb.Filter(EVEN).run(frame)
    with pytest.raises(ValueError, match="^row 1: its time is 0 s after"):
        lb.Filter(EVEN).run(frame.drop(columns="time"))
    numbers = frame.drop(columns="time").set_axis(pd.RangeIndex(50, name="Time"))
    with pytest.raises(ValueError, match="^row 1: its time is 1 s after"):
        lb.Filter(EVEN).run(numbers)
    lb.Filter(EVEN).run(lb.Record(numbers, time="rows"))


def test_a_row_is_named_by_its_number_in_the_record():
    back = [*EVERY[:30], *EVERY[20:40]]
    parts = [record(EVERY).set_axis(back)[k : k + 10] for k in range(0, 50, 10)]
    with pytest.raises(ValueError, match="^row 30: .*times must grow"):
        list(in_parts(lb.Filter(BALL), parts))
    t = changed(25, 1.0)
    for frame in (record(t).assign(time=t), dated(record(t), t)):
        found = in_parts(lb.Filter(EVEN), [frame[:25], frame[25:]])
        next(found)
        with pytest.raises(ValueError, match="^row 25: its time is 1.1 s after"):
            next(found)


REFUSED = {
    "no instants": (dict(), "so the record must say when"),
    "row numbers": (dict(time="rows"), "so the record must say when"),
    "too few": (dict(time=EVERY[:-1]), "time must have 50 instants, got"),
    "no word": (dict(time="index"), "must be instants or 'rows'"),
    "still": (dict(time=np.minimum(EVERY, 3)), "^row 31: .*times must grow"),
    "text": (
        dict(time=["1", *["noon"] * 49]),
        "^row 1: the time is 'noon', not a number",
    ),
}


@pytest.mark.parametrize(("given", "message"), REFUSED.values(), ids=REFUSED)
def test_instants_that_a_continuous_plant_cannot_be_sampled_at(given, message):
    with pytest.raises(ValueError, match=message):
        lb.Filter(BALL).run(lb.Record(record(EVERY), **given))


def test_one_row_has_no_period():
    with pytest.raises(ValueError, match="one row has no sampling period"):
        lb.Filter(BALL).run(lb.Record([[1.0]], time=[0.0]))


def test_no_input_is_asked_for():
    frame = record(EVERY)[["radar"]]
    with pytest.raises(ValueError, match="no column 'angle'.*u=0 says that no known"):
        lb.Filter(EVEN).run(frame)
    one = lb.Filter(EVEN).run(lb.Record(frame, 0))
    same = lb.Filter(EVEN).run(frame.to_numpy())
    np.testing.assert_array_equal(one.x, same.x)
    chunks = [lb.Record(frame[:20], 0), lb.Record(frame[20:], 0)]
    parts = [part.x for part in in_parts(lb.Filter(EVEN), chunks)]
    np.testing.assert_array_equal(np.concatenate(parts), same.x)


@pytest.mark.parametrize("sizes", [[2, *[1] * 48], [0, 2, 1, 0, 28, 19], [50]])
def test_chunks_of_a_continuous_plants_record_are_one_record(sizes):
    rng = np.random.default_rng(2)
    t = np.round(np.cumsum(rng.uniform(0.02, 0.3, 50)), 4)
    frame = record(t).set_axis(t)
    frame.loc[rng.random(50) < 0.3, "radar"] = np.nan
    whole = lb.Filter(BALL).run(frame)
    edges = np.cumsum(sizes)[:-1]
    y, u = frame[["radar"]].to_numpy(), frame[["angle"]].to_numpy()
    arrays = zip(*(np.split(X, edges) for X in (y, u, t)))
    for records in (
        [frame[a:b] for a, b in zip([0, *edges], [*edges, 50])],
        [lb.Record(*one) for one in arrays],
    ):
        parts = list(in_parts(lb.Filter(BALL), records))
        assert [len(part.x) for part in parts] == sizes
        for name in ("x", "std", "P", "K"):
            joined = np.concatenate([getattr(part, name) for part in parts])
            np.testing.assert_allclose(
                joined, getattr(whole, name), rtol=1e-10, atol=1e-13
            )


def test_stretches_of_a_long_record_are_one_record(monkeypatch):
    """With gaps, even and uneven stretches of it."""
    rng = np.random.default_rng(2)
    t = np.cumsum(np.r_[np.full(40, 0.1), rng.uniform(0.02, 0.3, 60)])
    frame = record(t).set_axis(t)
    frame.loc[rng.random(100) < 0.3, "radar"] = np.nan
    whole = lb.Filter(BALL).run(frame)
    monkeypatch.setattr("luenberger.run.filter.ROWS", 16)
    parts = lb.Filter(BALL).run(frame)
    np.testing.assert_allclose(parts.x, whole.x, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(parts.std, whole.std, rtol=1e-10)


def test_a_period_is_the_same_alone_and_among_others():
    rng = np.random.default_rng(5)
    T = np.round(10.0 ** rng.uniform(-3, 2, 40), 5)
    together = lb.sampling.discretise(BALL, T)
    for k, one in enumerate(map(BALL.sampled, T)):
        for name in "ABQ":
            found = getattr(together, name)[k]
            np.testing.assert_array_equal(found, getattr(one, name), name)


# -- files ----------------------------------------------------------------------------


def written(folder, stamps, name="time"):
    rows = [f"{stamp},{k % 7},0" for k, stamp in enumerate(stamps)]
    path = folder / "data.csv"
    path.write_text("\n".join([f"{name},radar,angle", *rows]))
    return path


@pytest.mark.parametrize(
    ("name", "stamps", "time"),
    [
        ("time", ["5", "5.1", "5.2"], [5, 5.1, 5.2]),
        ("t", ["2026-01-05 10:00:00", "2026-01-05 10:00:00.1", "2026-01-05 10:00:00.2"],
         [0, 0.1, 0.2]),
        ("Time", ["2026-01-05T23:59:59.9Z", "2026-01-06T00:00Z",
                  "2026-01-06T00:00:00.1Z"], [0, 0.1, 0.2]),
        ("instant", ["7", "8", "9"], [0.7, 0.8, 0.9]),
    ],
)  # fmt: skip
def test_a_files_times_are_seconds_dates_or_instants(tmp_path, name, stamps, time):
    found = measurements.read(written(tmp_path, stamps, name), EVEN)
    np.testing.assert_allclose(found.time, time, rtol=1e-12)
    assert found.stamps == tuple(stamps)


@pytest.mark.parametrize(
    ("name", "stamps", "message"),
    [
        ("time", ["0", "0.1", "4.2"], "line 4: its time is 4.1 s after"),
        ("time", ["0", "1", "2"], "line 3: its time is 1 s after"),
        ("instant", ["1", "2", "4"], "line 4: its time is 0.2 s after"),
        ("time", ["0", "0.1", "noon"], "line 4: 'time' is 'noon', not a number"),
        ("time", ["0", "0.1", ""], "line 4: 'time' is '', not a number"),
        ("time", ["0", "0.1", "nan"], "line 4: 'time' is 'nan', not a number"),
        (
            "time",
            ["2026-01-05", "2026-01-06", "3"],
            "line 3: its|line 4: 'time' is '3'",
        ),
        ("time", ["2026-01-05", "2026-01-05T00:00:00Z"], "line 3: .* with a zone"),
        ("time", ["2026-01-05T00:00:00Z", "2026-01-05"], "line 3: .* with no zone"),
        ("t", ["abc", "0", "0.1"], "line 2: 't' is 'abc', not a number of seconds nor"),
        ("T", ["12:00:05", "12:00:05.1"], "line 2: 'T' is '12:00:05', not a number"),
        ("time", ["01/07/2026 12:00:00", "01/07/2026 12:00:05"], "line 2: .* 10:00:00"),
        ("time", ["2026-07-01", "12:00"], "line 3: 'time' is '12:00', not a date"),
        ("time", ["0", "2026-01-05"], "line 3: .*2026-01-05', not a number of seconds"),
        ("time", ["", "", ""], "line 2: 'time' is '', not a number"),
        ("instant", ["1", "b"], "line 3: 'instant' is 'b', not a number"),
    ],
)
def test_a_files_times_that_contradict_dt(tmp_path, name, stamps, message):
    """In the record of a report, of the command `filter` and of `estimate`."""
    path = written(tmp_path, stamps, name)
    message = message.replace("10:00:00", "a date such as 2026-01-05T10:00:00")
    observer = lb.kalman_filter(EVEN).named(EVEN)
    for run in (
        lambda table: measurements.read(path, EVEN),
        lambda table: [*tables.filtered(EVEN, table)[1]],
        lambda table: [*tables.estimates(observer, table)[1]],
    ):
        with open(path, "rb") as file, pytest.raises(ValueError, match=message):
            run(csv_table.Table(file, path))


@pytest.mark.parametrize("size", [10, 80])
def test_an_odd_cell_of_a_later_piece_is_refused(tmp_path, size):
    """Pieces of one line and of some; labels under another name are let be."""
    times = [f"{k / 10}" for k in range(20)]
    times[17] = "abc"
    for name in ("time", "label"):
        path = written(tmp_path, times, name)
        with open(path, "rb") as file:
            rows = tables.filtered(EVEN, csv_table.Table(file, path, size))[1]
            if name == "label":
                assert sum(len(x) for _, x in rows) == 20
                continue
            with pytest.raises(ValueError, match="line 19: 'time' is 'abc', .* label"):
                list(rows)


def test_without_a_column_rows_are_dt_apart(tmp_path):
    path = tmp_path / "data.csv"
    path.write_text("radar,angle\n1,0\n2,0\n3,0\n")
    assert measurements.read(path, EVEN).time.tolist() == [0.1, 0.2, 0.3]
