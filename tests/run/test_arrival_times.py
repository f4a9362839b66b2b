"""Arrival times that rounding puts behind their rows: they are at them."""

import numpy as np
import pandas as pd
import pytest

import luenberger as lb

N = 300
GRIDS = {"hundredths": 0.01, "tenths": 0.1, "thirds": 1 / 3, "video": 1 / 60}


def walk(dt):
    return lb.Plant(
        [[1]], None, [[1]], dt=dt, Q=[[1e-2]], R=[[1]], P0=[[100]], output_names=["g"]
    )


def frame(index, known, seed=0):
    y = np.random.default_rng(seed).normal(size=len(index))
    return pd.DataFrame({"g": y, "known": known}, index=pd.Index(index, name="t"))


def estimates(plant, table, arrival, **more):
    return lb.Filter(plant).run(lb.Record(table, arrival=arrival, **more)).x


def by_rows(plant, table, lag):
    rows = np.arange(len(table), dtype=float)[:, None] + lag
    return estimates(plant, table[["g"]].to_numpy(), rows)


def times(kind, dt, start):
    """Times of rows as people make them, and what adds seconds to them."""
    seconds = start + dt * np.arange(1, N + 1)
    if kind == "sums":
        return start + np.cumsum(np.full(N, dt)), lambda t, late: t + late
    if kind == "floats":
        return seconds, lambda t, late: t + late
    dates = pd.to_datetime(1e9 * seconds).round(kind).as_unit(kind)
    return dates, lambda t, late: t + pd.Timedelta(seconds=late).round(kind)


@pytest.mark.parametrize("lag", [0, 1, 2, 7, 30])
@pytest.mark.parametrize("grid", GRIDS)
def test_a_lag_of_whole_steps_is_as_many_rows(grid, lag):
    dt = GRIDS[grid]
    wanted = by_rows(walk(dt), frame(range(N), 0), lag)
    for kind in ("floats", "sums", "ns", "us", "ms"):
        if (kind, grid) == ("ms", "video"):
            continue  # a millisecond is a sixteenth of a step: not rounding
        for start in (0.0, 1.7e9):
            t, after = times(kind, dt, start)
            table = frame(t, after(t, lag * dt))
            found = estimates(walk(dt), table, {"g": "known"}).to_numpy()
            assert np.array_equal(found, wanted), (kind, start)


@pytest.mark.parametrize("kind", ["floats", "ns", "us"])
@pytest.mark.parametrize("dt", GRIDS.values())
def test_a_reading_that_is_later_waits_for_the_next_row(dt, kind):
    t, after = times(kind, dt, 0.0)
    table = frame(t, after(t, 3 * dt + 0.02 * dt))
    found = estimates(walk(dt), table, {"g": "known"}).to_numpy()
    assert np.array_equal(found, by_rows(walk(dt), table, 4))


def test_latency_that_is_no_rounding_is_not_forgiven():
    t = 1.0 + np.arange(40.0)
    dates = pd.to_datetime(1e9 * t)
    for index, late in ((t, 1e-5), (dates, pd.Timedelta("20us"))):
        table = frame(index, index + late)
        found = estimates(walk(1.0), table, {"g": "known"}).to_numpy()
        assert np.array_equal(found, by_rows(walk(1.0), table, 1))


def test_dates_whose_last_digit_is_a_whole_step():
    dates = pd.date_range("2026-01-05", periods=40, freq="s").as_unit("s")
    table = frame(dates, dates + pd.Timedelta("1s"))
    found = estimates(walk(1.0), table, {"g": "known"}).to_numpy()
    assert np.array_equal(found, by_rows(walk(1.0), table, 1))


@pytest.mark.parametrize("size", [1, 7])
def test_chunks_see_the_same_rows(size):
    for kind in ("floats", "ns"):
        t, after = times(kind, 0.01, 0.0)
        table = frame(t, after(t, 0.3))
        run, end, parts = lb.Filter(walk(0.01)), None, []
        for part in lb.Record(table, arrival={"g": "known"}).split(size):
            found = run.run(part, start=end)
            end = found.end
            parts.append(found.x.to_numpy())
        x = np.concatenate(parts)
        assert np.array_equal(x, by_rows(walk(0.01), table, 30))


def test_an_arrival_before_its_row_by_rounding_is_on_time():
    t = 0.1 * np.arange(1, 41)
    table = frame(t, np.nextafter(t, 0))
    found = estimates(walk(0.1), table, {"g": "known"}).to_numpy()
    assert np.array_equal(found, by_rows(walk(0.1), table, 0))
    table["known"] = t - 1e-3
    with pytest.raises(ValueError, match="before it was measured"):
        estimates(walk(0.1), table, {"g": "known"})


def test_readings_that_never_arrive_still_never_do():
    dates = pd.to_datetime(1e7 * np.arange(1, 41))
    known = pd.Series(dates + pd.Timedelta("30ms"))
    known[::3] = pd.NaT
    table = frame(dates, known.to_numpy())
    found = estimates(walk(0.01), table, {"g": "known"}).to_numpy()
    rows = np.arange(40.0)[:, None] + 3
    rows[::3] = np.nan
    expected = estimates(walk(0.01), table[["g"]].to_numpy(), rows)
    assert np.array_equal(found, expected)


def test_a_continuous_plant_at_uneven_rows():
    plant = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[9]], output_names=["g"])
    steps = np.random.default_rng(3).choice([0.1, 0.2, 0.7], 60)
    t = np.cumsum(steps)
    known = np.append(t[2:], [np.nan] * 2) * (1 + 2e-16)
    table = frame(t, known)
    found = estimates(plant, table, {"g": "known"}).to_numpy()
    rows = np.arange(60.0)[:, None] + 2
    rows[-2:] = np.nan
    y = table[["g"]].to_numpy()
    expected = estimates(plant, y, rows, time=t)
    assert np.array_equal(found, expected)
