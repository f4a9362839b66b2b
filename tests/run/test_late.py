"""Readings that arrive late: each row knows what had arrived by then, and no more.

The oracle filters the record anew for every row, with NaN for what had not arrived.
"""

from dataclasses import replace
from fractions import Fraction

import exact_filter
import generators
import numpy as np
import pandas as pd
import pytest
from generators import holes

import luenberger as lb
from luenberger.recursion import late_step

N = 26


def arrivals(rng, shape, longest=12, late=0.6, never=0.1):
    """Random arrivals, in any order, as row numbers."""
    wait = rng.integers(0, longest, size=shape) * (rng.random(shape) < late)
    arrival = np.arange(float(shape[0]))[:, None] + wait
    arrival[rng.random(shape) < never] = np.inf
    return arrival


def again(plant, y, u, u0, arrival, **options):
    """The filter run again at every row: x (N, n) and P (N, n, n)."""
    found = []
    for k in range(len(y)):
        known = np.where(arrival[: k + 1] <= k, y[: k + 1], np.nan)
        found.append(lb.filter_data(plant, known, u[: k + 1], u0=u0, **options))
    return np.array([one.x[-1] for one in found]), np.array([one.P for one in found])


@pytest.fixture(params=["S = 0", "S", "time-varying", "time-varying, S"])
def case(request):
    rng = np.random.default_rng(17)
    cross = request.param.endswith("S")
    if request.param.startswith("time"):
        plant = generators.varying(rng, 4, 3, N, m=2, cross=cross)
    else:
        plant = generators.plant(rng, 4, 3, m=2, cross=cross)
    y, u, u0 = generators.record(rng, plant, N)
    return plant, holes(rng, y), u, u0, arrivals(rng, y.shape)


@pytest.mark.parametrize("m1", [0, [1], 3])
def test_each_row_is_the_filter_run_again(m1, case):
    plant, y, u, u0, arrival = case
    x, P = again(plant, y, u, u0, arrival, m1=m1)
    run = lb.filter_data(plant, y, u, u0=u0, m1=m1, arrival=arrival, history=True)
    assert generators.relative(run.x, x) < 1e-12
    assert generators.relative(run.P, P) < 1e-12
    std = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    assert generators.relative(run.std, std) < 1e-12


def test_the_last_covariance_and_gains_of_readings_on_time(case):
    plant, y, u, u0, arrival = case
    whole = lb.filter_data(plant, y, u, u0=u0, arrival=arrival, history=True)
    last = lb.filter_data(plant, y, u, u0=u0, arrival=arrival)
    assert generators.relative(last.P, whole.P[-1]) < 1e-13
    assert last.K is None
    on_time = ~np.isnan(y) & (arrival == np.arange(N)[:, None])
    np.testing.assert_array_equal(whole.K.any(axis=1), on_time)


@pytest.mark.parametrize("m1", [0, 1])
def test_on_time_it_is_the_filter_and_never_is_missing(m1, case):
    plant, y, u, u0, _ = case
    now = np.repeat(np.arange(float(N))[:, None], plant.p, axis=1)
    wanted = lb.filter_data(plant, y, u, u0=u0, m1=m1, history=True)
    run = lb.filter_data(plant, y, u, u0=u0, m1=m1, arrival=now, history=True)
    for name in ("x", "P", "K"):
        found = getattr(run, name), getattr(wanted, name)
        assert generators.relative(*found) < 1e-13, name
    np.testing.assert_array_equal(run.orders, wanted.orders)
    for absent in (np.nan, np.inf, 10.0**6):
        late = np.where(now % 3 == 1, absent, now)
        gaps = np.where(now % 3 == 1, np.nan, y)
        wanted = lb.filter_data(plant, gaps, u, u0=u0, m1=m1)
        run = lb.filter_data(plant, y, u, u0=u0, m1=m1, arrival=late)
        assert generators.relative(run.x, wanted.x) < 1e-13


@pytest.mark.parametrize("m1", [0, 1])
def test_a_row_knows_nothing_that_arrives_later(m1, case):
    """Not a bit of it: later readings are changed, and earlier rows stay."""
    plant, y, u, u0, arrival = case
    run = lb.filter_data(plant, y, u, u0=u0, m1=m1, arrival=arrival)
    other = np.where(arrival > 12, y + 100, y)
    changed = lb.filter_data(plant, other, u, u0=u0, m1=m1, arrival=arrival)
    np.testing.assert_array_equal(changed.x[:13], run.x[:13])
    assert np.abs(changed.x[13:] - run.x[13:]).max() > 1


@pytest.mark.parametrize("m1", [0, 1])
def test_chunks_are_the_whole(m1, case):
    plant, y, u, u0, arrival = case
    ends = [0, 1, 7, 7, 20, N]
    parts = [slice(a, b) for a, b in zip(ends, ends[1:])]
    whole = lb.filter_data(plant, y, u, u0=u0, m1=m1, arrival=arrival, history=True)
    chunks = lb.filter_data(
        plant, (y[s] for s in parts), (u[s] for s in parts), u0=u0, m1=m1,
        arrival=(arrival[s] for s in parts), history=True,
    )  # fmt: skip
    for part, found in zip(parts, chunks, strict=True):
        np.testing.assert_allclose(found.x, whole.x[part], rtol=0, atol=1e-13)
        np.testing.assert_allclose(found.P, whole.P[part], rtol=0, atol=1e-13)
        np.testing.assert_array_equal(found.orders, whole.orders[part])


def test_a_covariance_has_the_readings_that_are_awaited_and_no_more(monkeypatch):
    """Memory is flat: on a long record nothing piles up."""
    rng = np.random.default_rng(2)
    plant = generators.plant(rng, 3, 2, cross=True)
    y, u, u0 = generators.record(rng, plant, 400)
    arrival = np.arange(400.0)[:, None] + [5, 0]
    arrival[::3, 1] = np.nan
    sizes, step = [], late_step.step

    def counted(settings, state, row):
        state, K = step(settings, state, row)
        sizes.append(len(state.xi))
        assert state.spread.Sigma.shape == (len(state.xi), len(state.xi))
        return state, K

    monkeypatch.setattr(late_step, "step", counted)
    lb.filter_data(plant, y, u, u0=u0, arrival=arrival)
    # one reading that never arrives stays for a row, since S tells of its noise
    assert set(sizes[10:-10]) == {3 + 5, 3 + 5 + 1}


# -- rational arithmetic ---------------------------------------------------------------


def exact_again(model, y, arrival, prior=False):
    """The same in Fractions, for any covariances."""
    found = exact_filter.Exact([], [], [])
    for k in range(len(y)):
        known = exact_filter.rational(np.zeros(y[: k + 1].shape))
        known[:] = y[: k + 1]
        known[arrival[: k + 1] > k] = None
        one = exact_filter.run(model, known, prior=prior)
        for name in ("x", "P"):
            getattr(found, name).append(getattr(one, name)[-1])
        found.gaps.append(max(one.gaps))
    return found


SEEDS, BLOCKS = 80, 2


@pytest.mark.parametrize("block", range(BLOCKS))
def test_singular_problems_are_right(block):
    """R, Q and P0 of every rank, S, gaps, units from 1e-6 to 1e6, any order.

    Records fit the model exactly, so nothing may be refused.
    """
    for seed in range(block, SEEDS, BLOCKS):
        problem = replace(exact_filter.problem(seed), accurate=())
        rng = np.random.default_rng(seed + 10**6)
        steps = len(problem.y)
        arrival = arrivals(rng, problem.y.shape, longest=steps, never=0)
        wanted = exact_again(problem.model, problem.y, arrival)
        run = lb.filter_data(
            problem.plant, problem.record, arrival=arrival, history=True
        )
        errors = problem.errors(run.x, run.P, wanted)
        assert max(errors) < 1e-9, (seed, problem.kinds)


@pytest.mark.parametrize("noise", [0, 1e-8, 1])
@pytest.mark.parametrize("start", [0, 1, 1e8])
def test_a_late_channel_beside_rational_arithmetic(noise, start):
    """Without noise, from a start that is known, or that is not known at all."""
    rng = np.random.default_rng(5)
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0], [0, 1]], dt=1.0, Q=np.diag([0, 0.25]),
        R=np.diag([noise, 4]), P0=start * np.eye(2),
    )  # fmt: skip
    y, _, _ = generators.record(rng, plant, 12)
    arrival = np.arange(12.0)[:, None] + [4, 0]
    model = exact_filter.model(plant)
    wanted = exact_again(model, exact_filter.rational(y), arrival)
    x, P = exact_filter.as_floats(wanted)
    run = lb.filter_data(plant, y, arrival=arrival, history=True)
    scale = np.sqrt(np.diagonal(P, axis1=1, axis2=2)).max(axis=0)
    assert np.abs((run.P - P) / np.outer(scale, scale)).max() < 1e-12
    assert np.abs(run.x - x).max() < 1e-9 * np.abs(x).max()
    tail = np.abs(run.P[6:] - P[6:]).max() / np.abs(P[6:]).max()
    assert tail < 1e-12 * max(start, 1) ** 0.5


def variance_after(P, R, when):
    """Of a number that stays, read at once by one output and late by another."""
    plant = lb.Plant([[1]], None, [[1], [1]], dt=1.0, Q=[[0]], R=np.diag(R), P0=[[P]])
    y, arrival = np.array([[0.0, 0], [np.nan, np.nan]]), np.array([when, [1, 1]])
    run = lb.filter_data(plant, y, arrival=arrival, history=True)
    exact = [
        1
        / (Fraction(1) / P + sum(1 / Fraction(r) for r, at in zip(R, when) if at <= k))
        for k in range(2)
    ]
    return [abs(Fraction(float(one[0, 0])) / e - 1) for one, e in zip(run.P, exact)]


@pytest.mark.parametrize(
    "P, R, when",
    [
        (2**30, [1.25, 3], [1, 1]),  # noise that is small beside what is not known
        (2**30, [1.25, 3], [0, 1]),
        (2**20, [1.25, 3], [1, 0]),
        (3, [2.0**-28, 5], [1, 0]),  # or a precise reading, late
        (3, [5, 2.0**-28], [0, 1]),
    ],
)
def test_digits_are_kept_where_a_covariance_would_lose_them(P, R, when):
    """The variance that is left is right itself, not only beside the one before."""
    assert max(variance_after(P, R, when)) < 1e-11


@pytest.mark.parametrize(
    "arrival",
    [
        [[2, 0], [1, 4], [5, 3], [3, 5], [4, 4], [5, 5]],  # one instant, two rows
        [[5, 5], [5, 4], [4, 5], [4, 3], [4, 4], [5, 5]],  # the newest first
        [[5, 5], [5, 5], [5, 5], [5, 5], [5, 5], [5, 5]],  # all at once
    ],
    ids=["apart", "backwards", "at once"],
)
@pytest.mark.parametrize("cross", [False, True])
def test_any_order_of_arrival(arrival, cross):
    plant = generators.plant(np.random.default_rng(3), 3, 2, m=0, cross=cross)
    y, _, _ = generators.record(np.random.default_rng(4), plant, 6)
    arrival = np.array(arrival, dtype=float)
    model = exact_filter.model(plant)
    wanted = exact_again(model, exact_filter.rational(y), arrival)
    run = lb.filter_data(plant, y, arrival=arrival, history=True)
    for found, exact in zip((run.x, run.P), exact_filter.as_floats(wanted)):
        assert generators.relative(found, exact) < 1e-13


@pytest.mark.parametrize("power", [-40, 40])
@pytest.mark.parametrize("noise", [0, 1])
def test_units_are_free(power, noise):
    """A state and an output in a unit 2^40 times as large or as small."""
    rng = np.random.default_rng(8)
    given = generators.plant(rng, 3, 2, m=0, cross=False)
    given = replace(given, R=noise * given.R)
    y, _, _ = generators.record(rng, given, 20)
    unit, scale = np.array([2.0**power, 1, 1]), np.array([1, 2.0**-power])
    both, outer = np.outer(unit, 1 / unit), np.outer(unit, unit)
    plant = lb.Plant(
        given.A * both, None, scale[:, None] * given.C / unit, dt=1.0,
        Q=given.Q * outer, R=given.R * np.outer(scale, scale), P0=given.P0 * outer,
        x0=given.x0 * unit,
    )  # fmt: skip
    arrival = arrivals(rng, y.shape, longest=6, never=0)
    wanted = lb.filter_data(given, y, arrival=arrival, history=True)
    run = lb.filter_data(plant, y * scale, arrival=arrival, history=True)
    assert generators.relative(run.x / unit, wanted.x) < 1e-12
    assert generators.relative(run.P / outer, wanted.P) < 1e-12


# -- contradictions --------------------------------------------------------------------


def perfect(P0=1):
    """A position that stays, and two outputs without noise, of which one is late."""
    return lb.Plant(
        [[1]], None, [[1], [2]], dt=1.0, Q=[[0]], R=np.zeros((2, 2)), P0=[[P0]],
        output_names=["ruler", "camera"],
    )  # fmt: skip


@pytest.mark.parametrize("P0", [0, 1])
def test_a_late_perfect_reading_that_contradicts_is_refused_by_name(P0):
    y = np.array([[3.0, 6.0], [3.0, 6.0], [3.0, 6.0]]) if P0 else np.zeros((3, 2))
    arrival = np.array([[0.0, 2], [1, 1], [2, 2]])
    run = lb.filter_data(perfect(P0), y, arrival=arrival)
    np.testing.assert_allclose(run.x[:, 0], 3 if P0 else 0, atol=1e-12)
    assert np.abs(run.std).max() < 1e-12
    y[0, 1] += 0.5
    with pytest.raises(lb.DesignError, match="camera of instant 1.* contradict") as got:
        lb.filter_data(perfect(P0), y, arrival=arrival)
    assert "at instant 3" in str(got.value)


# -- tables ----------------------------------------------------------------------------


@pytest.fixture
def table():
    """A position from a satellite, two and a half seconds late, and an odometer."""
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, np.eye(2), dt=1.0, Q=0.1 * np.eye(2), R=np.eye(2),
        P0=np.eye(2), output_names=["gps", "odometer"],
    )  # fmt: skip
    y = np.random.default_rng(0).normal(size=(10, 2))
    when = pd.date_range("2026-03-01", periods=10, freq="1s")
    frame = pd.DataFrame(y, index=when, columns=["gps", "odometer"])
    frame["known"] = when + pd.Timedelta("2.5s")
    wanted = lb.filter_data(plant, y, arrival=np.arange(10.0)[:, None] + [3, 0])
    return plant, frame, wanted.x


def test_columns_of_times(table):
    plant, frame, wanted = table
    for arrival in ({"gps": "known"}, frame[["known"]].set_axis(["gps"], axis=1)):
        found = lb.filter_data(plant, frame, arrival=arrival).x
        pd.testing.assert_index_equal(found.index, frame.index)
        np.testing.assert_array_equal(found, wanted)
    zone = frame.tz_localize("Europe/Vienna")
    zone["known"] = zone["known"].dt.tz_localize("Europe/Vienna")
    found = lb.filter_data(plant, zone, arrival={"gps": "known"}).x
    np.testing.assert_array_equal(found, wanted)
    rows = frame.reset_index(drop=True).assign(known=np.arange(10) + 2.2)
    found = lb.filter_data(plant, rows, arrival={"gps": "known"}).x
    np.testing.assert_array_equal(found, wanted)


def test_a_time_that_is_missing_is_never(table):
    plant, frame, _ = table
    gaps = frame.copy()
    gaps.loc[frame.index[2:5], "known"] = pd.NaT
    wanted = frame.copy()
    wanted.loc[frame.index[2:5], "gps"] = np.nan
    found = lb.filter_data(plant, gaps, arrival={"gps": "known"}).x
    missing = lb.filter_data(plant, wanted, arrival={"gps": "known"}).x
    pd.testing.assert_frame_equal(found, missing)


def test_chunks_of_a_table(table):
    plant, frame, wanted = table
    chunks = (frame.iloc[k : k + 3] for k in range(0, 10, 3))
    found = lb.filter_data(plant, chunks, arrival={"gps": "known"})
    np.testing.assert_allclose(pd.concat([f.x for f in found]), wanted, atol=1e-14)


# -- refusals --------------------------------------------------------------------------


def changed(arrival, row, output, value):
    arrival = arrival.copy()
    arrival[row, output] = value
    return arrival


LATE = np.arange(10.0)[:, None] + [3, 0]
FRAME = {"gps": "known"}
REFUSED = {
    "before": ({"arrival": changed(LATE, 4, 0, 2)}, "'gps' in row 4 arrives at row 2"),
    "minus infinity": ({"arrival": changed(LATE, 4, 0, -np.inf)}, "row 4 arrives at"),
    "half a row": ({"arrival": changed(LATE, 4, 1, 6.5)}, "'odometer' in row 4 has 6"),
    "short": ({"arrival": LATE[:5]}, "10 rows but arrival has 5"),
    "narrow": ({"arrival": LATE[:, :1]}, r"must be \(N, 2\), got \(10, 1\)"),
    "horizon": (
        {"arrival": LATE, "horizon": 2},
        "'gps' in row 0 arrives at row 3, more than horizon=2",
    ),
    "beyond the record": (
        {"arrival": changed(LATE, 9, 1, 99), "horizon": 5},
        "'odometer' in row 9 arrives at row 99",
    ),
    "horizon alone": ({"horizon": 2}, "horizon goes with arrival"),
    "half a horizon": ({"arrival": LATE, "horizon": 2.5}, "number of rows, got 2.5"),
    "no table": ({"arrival": FRAME}, "y must be a DataFrame"),
    "iterator": ({"arrival": iter([LATE])}, "y must be one too"),
    "backend": ({"arrival": LATE, "backend": "C"}, "backend must be"),
}


@pytest.mark.parametrize("options, words", REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(table, options, words):
    plant, frame, _ = table
    with pytest.raises(ValueError, match=words):
        lb.filter_data(plant, frame[["gps", "odometer"]].to_numpy(), **options)


def test_a_table_that_makes_no_sense_is_refused(table):
    plant, frame, _ = table

    def refused(words, frame=frame, arrival=FRAME, **options):
        with pytest.raises(ValueError, match=words):
            lb.filter_data(plant, frame, arrival=arrival, **options)

    refused(r"'gsp'; outputs are \['gps'", arrival={"gsp": "known"})
    refused("no column 'at'", arrival={"gps": "at"})
    early = frame.assign(known=frame.index - pd.Timedelta("1ms"))
    refused("'gps' in row 0 arrives at 2026-02-28.*before it was measured", early)
    refused("holds numbers, but the index of y holds times", frame.assign(known=1.0))
    refused("must grow from row to row", frame.iloc[::-1])
    refused("different rows", arrival=frame[["gps"]].iloc[:-1])
    foreign = frame[["known"]]
    refused("columns .'known'.; outputs are", arrival=foreign)
    refused("'gps' in row 0 has not arrived by row 2, and horizon=2", horizon=2)
    lb.filter_data(plant, frame, arrival=FRAME, horizon=3)


def test_chunks_that_make_no_sense_are_refused(table):
    plant, frame, _ = table
    y = frame[["gps", "odometer"]].to_numpy()
    with pytest.raises(ValueError, match="arrival must be one too"):
        lb.filter_data(plant, iter([y]), arrival=LATE)
    with pytest.raises(ValueError, match="fewer chunks"):
        list(lb.filter_data(plant, iter([y, y]), arrival=iter([LATE])))
    rows = frame.reset_index(drop=True).assign(known=np.arange(10) + 2.0)
    twice = lb.filter_data(plant, iter([rows, rows]), arrival=FRAME)
    with pytest.raises(ValueError, match="row 10 does not come after"):
        list(twice)


def test_a_continuous_plant_in_chunks_names_the_way_out():
    plant = lb.Plant([[-1]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    y, arrival = np.zeros((4, 1)), np.arange(4.0)[:, None]
    with pytest.raises(
        lb.DesignError, match=r"y comes in chunks.*plant\.sampled\(dt\)"
    ):
        lb.filter_data(plant, iter([y]), arrival=iter([arrival]))
    discrete = plant.sampled(0.5)
    found = list(lb.filter_data(discrete, iter([y]), arrival=iter([arrival])))
    whole = lb.filter_data(plant, y, time=0.5 * np.arange(4), arrival=arrival)
    np.testing.assert_allclose(found[0].x, whole.x, rtol=1e-12)
