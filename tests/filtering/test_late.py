"""Readings that arrive late: each row is what a run on all that had arrived finds."""

from dataclasses import replace

import exact_filter
import numpy as np
import pytest

import luenberger as lb
from luenberger.errors import DesignError
from luenberger.filtering import pack
from luenberger.run import filter, live

nan = float("nan")


def one_run_a_row(run, y, due, **more):
    """x and std by definition: run again for each row."""
    found = []
    for k in range(len(y)):
        known = np.where(due[: k + 1] <= k, y[: k + 1], nan)
        cut = {name: X[: k + 1] if np.ndim(X) > 1 else X for name, X in more.items()}
        last = run.run(lb.Record(known, **cut))
        found.append((last.x[-1], last.std[-1], last.P[-1]))
    return [np.array(X) for X in zip(*found)]


def drawn_due(rng, shape):
    """Some on time, some a few rows late, some much, some never."""
    late = rng.choice([0, 0, 1, 2, 3, 9], shape)
    due = (np.arange(shape[0])[:, None] + late).astype(float)
    due[rng.random(shape) < 0.05] = nan
    return due


def a_plant(seed, kind):
    rng = np.random.default_rng(seed)
    n, p, m = rng.integers(1, 5), rng.integers(1, 4), rng.integers(0, 3)
    if kind == "large":
        n, p = 8, 3
    A, C = rng.normal(size=(n, n)), rng.normal(size=(p, n))
    A = 0.95 * A / np.abs(np.linalg.eigvals(A)).max()
    B, E = rng.normal(size=(n, m)), rng.normal(size=(p, m))
    H = rng.normal(size=(n + p, n + p))
    J = H @ H.T
    Q, R, S = J[:n, :n], J[n:, n:], None
    if kind == "shared":
        S = 0.5 * J[:n, n:]
    elif kind == "exact":
        R = np.diag([0.0, *np.ones(p - 1)])
    elif kind == "varying":
        A, R = np.stack([A, 0.8 * A] * 20), np.stack([R, 2 * R] * 20)
    plant = lb.Plant(A, B, C, E, dt=1.0, Q=Q, R=R, S=S, P0=np.eye(n), x0=np.ones(n))
    N = 30
    y, u = rng.normal(size=(N, p)), rng.normal(size=(N, m))
    y[rng.random(y.shape) < 0.15] = nan
    return plant, y, u, drawn_due(rng, y.shape)


KINDS = ("noisy", "shared", "exact", "varying", "large")


@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_each_row_is_a_run_on_what_had_arrived_bit_for_bit(kind, m1):
    for seed in range(6):
        plant, y, u, due = a_plant(seed, kind)
        run = lb.Filter(plant, m1)
        found = run.run(lb.Record(y, u, arrival=due))
        x, std, P = one_run_a_row(run, y, due, u=u)
        if kind != "large":
            assert np.array_equal(found.x, x) and np.array_equal(found.std, std), seed
        close = dict(rtol=1e-9, atol=1e-9)  # many states are done in another form
        np.testing.assert_allclose(found.x, x, **close)
        np.testing.assert_allclose(found.std, std, **close)
        assert np.array_equal(found.P, P)


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_rows_equal_exact_ones(first):
    """Singular Q, R, P0, S, exact and accurate outputs, by rational arithmetic."""
    for seed in range(first, first + 10):
        problem = exact_filter.problem(seed)
        y = problem.record
        due = drawn_due(np.random.default_rng(seed), y.shape)
        found = lb.Filter(problem.plant, problem.accurate).run(
            lb.Record(y, arrival=due)
        )
        for k in range(len(y)):
            here = problem.y[: k + 1]
            part = replace(problem, y=np.where(due[: k + 1] <= k, here, None))
            exact = part.exact()
            x, P = exact_filter.as_floats(exact)
            x[-1], P[-1] = found.x[k], found.P[k]
            x, P = part.errors(x, P, exact)
            slack = part.sensitivity(exact) if max(x, P) > 1e-9 else 0
            assert P <= 1e-9 + slack and x <= 1e-9 + slack + 1e-4 * slack**0.5, seed


@pytest.mark.parametrize("size", [1, 4, 13])
@pytest.mark.parametrize("kind", KINDS)
def test_parts_of_a_record_are_the_record_bit_for_bit(kind, size):
    plant, y, u, due = a_plant(2, kind)
    run, end, parts = lb.Filter(plant), None, []
    whole = run.run(lb.Record(y, u, arrival=due, u0=np.ones(plant.m)))
    for part in lb.Record(y, u, arrival=due, u0=np.ones(plant.m)).split(size):
        parts.append(run.run(part, start=end))
        end = parts[-1].end
    for name in ("x", "std", "P", "K"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(joined, getattr(whole, name)), name


def test_a_part_without_arrivals_goes_on_where_none_is_awaited():
    plant, y, u, due = a_plant(1, "noisy")
    run = lb.Filter(plant)
    some = due[:15] + 20.0 * (np.arange(15) == 14)[:, None]
    awaits = run.run(lb.Record(y[:15], u[:15], arrival=some)).end
    with pytest.raises(ValueError, match="of the part before are still awaited"):
        run.run(lb.Record(y[15:], u[15:]), start=awaits)
    on_time = np.repeat(np.arange(15.0)[:, None], plant.p, axis=1)
    begun = run.run(lb.Record(y[:15], u[:15], arrival=on_time)).end
    found = run.run(lb.Record(y[15:], u[15:]), start=begun)
    assert np.array_equal(found.x, run.run(lb.Record(y, u)).x[15:])


def test_a_continuous_plant_at_uneven_rows():
    rng = np.random.default_rng(5)
    plant = lb.Plant([[0, 1], [0, -1]], None, np.eye(2), Q=np.eye(2), R=np.eye(2),
                     P0=np.eye(2))  # fmt: skip
    t, y = np.cumsum(rng.choice([0.1, 0.2, 0.5], 40)), rng.normal(size=(40, 2))
    due, run = drawn_due(rng, y.shape), lb.Filter(plant)
    found = run.run(lb.Record(y, time=t, arrival=due))
    for k in range(3, 40):
        known = np.where(due[: k + 1] <= k, y[: k + 1], nan)
        last = run.run(lb.Record(known, time=t[: k + 1]))
        assert np.allclose(found.x[k], last.x[-1], rtol=0, atol=1e-13)
        assert np.allclose(found.P[k], last.P[-1], rtol=0, atol=1e-13)


def test_windows_of_a_plant_that_changes_are_the_record(monkeypatch):
    plant, y, u, due = a_plant(4, "varying")
    whole = lb.Filter(plant).run(lb.Record(y, u, arrival=due))
    monkeypatch.setattr(filter, "ROWS", 7)
    parts = lb.Filter(plant).run(lb.Record(y, u, arrival=due))
    for name in ("x", "std", "P", "K"):
        assert np.array_equal(getattr(parts, name), getattr(whole, name)), name


def test_a_long_record_forgets_what_nothing_late_can_change():
    """Only the last rows are near; of 900 rows most are put away three times."""
    rng = np.random.default_rng(5)
    plant = lb.Plant([[0.9]], None, [[1]], dt=1.0, Q=[[1]], R=[[2]], P0=[[3]])
    y, rows = rng.normal(size=(900, 1)), np.arange(900)[:, None]
    due = rows + rng.choice([0, 0, 0, 0, 2, 5], (900, 1))
    found = lb.Filter(plant).run(lb.Record(y, arrival=due))
    for k in (100, 215, 433, 640, 866, 899):
        known = np.where(due <= k, y, nan)[: k + 1]
        last = lb.Filter(plant).run(known)
        np.testing.assert_array_equal(found.x[k], last.x[-1])
        np.testing.assert_array_equal(found.std[k], last.std[-1])


def test_gains_are_those_of_the_readings_that_are_on_time():
    plant, y, u, due = a_plant(0, "noisy")
    late = due > np.arange(len(y))[:, None]
    found = lb.Filter(plant).run(lb.Record(y, u, arrival=due))
    assert not found.K.transpose(0, 2, 1)[late | np.isnan(due) | np.isnan(y)].any()


def test_a_record_of_no_rows():
    plant, y, u, due = a_plant(0, "noisy")
    found = lb.Filter(plant).run(lb.Record(y[:0], u[:0], arrival=due[:0]))
    assert found.x.shape == (0, plant.n) and found.end.instant == 0


def exact_walk():
    """A number that does not change, read without noise by two outputs."""
    return lb.Plant([[1]], None, [[1], [1]], dt=1.0, Q=[[0]], R=np.zeros((2, 2)),
                    P0=[[1]], output_names=["a", "b"])  # fmt: skip


def test_a_late_reading_that_contradicts_is_named_with_its_instant():
    y, due = [[1, nan], [1, nan], [nan, 2], [nan, nan]], np.full((4, 2), 3.0)
    with pytest.raises(DesignError, match=r"at instant 3 the reading of 'b' contra"):
        lb.Filter(exact_walk()).run(lb.Record(y, arrival=due))
    with pytest.raises(DesignError, match=r"by the noise-free outputs \['b'\] or by"):
        lb.Filter(exact_walk()).run(lb.Record(y, arrival=due))
    y, due = [[nan, 1], *[[1, 1]] * 3, [1, 2]], np.arange(5.0)[:, None] + [[0, 0]]
    due[0] = 1  # at rows behind it nothing is late
    with pytest.raises(DesignError, match=r"at instant 5 .* outputs \['a', 'b'\] or"):
        lb.Filter(exact_walk()).run(lb.Record(y, arrival=due))
    now = lb.Filter(exact_walk()).live(horizon=3)
    for _ in range(3):
        x, _ = now.measure([1, nan])
        now.advance()
    with pytest.raises(DesignError, match=r"at instant 4 the reading of 'b'"):
        now.measure([nan, 2])
    now.measure([nan, 1])  # the instant is as if it had not been measured
    with pytest.raises(DesignError, match=r"at instant 3 the reading of 'b'"):
        now.arrived("b", 1, 2.0)
    x, sigma = now.arrived("b", 1, 1.0)
    assert x == 1 and sigma == 0 and now.instant == 4


@pytest.mark.parametrize("kind", ["noisy", "exact", "varying"])
def test_scalars_find_the_bits_of_the_loops(monkeypatch, kind):
    plant, y, u, due = a_plant(3, kind)
    loops = lb.Filter(plant).run(lb.Record(y, u, arrival=due))
    monkeypatch.setattr(pack, "MANY", 1)
    scalars = lb.Filter(plant).run(lb.Record(y, u, arrival=due))
    for name in ("x", "std", "P", "K"):
        assert np.array_equal(getattr(loops, name), getattr(scalars, name)), name


def at_work(now, plant, y, u, due):
    """x and std of a record, handed in as it comes."""
    found, direct = [], plant.E.any()
    for k in range(len(y)):
        on_time = np.where(due[k] == k, y[k], nan)
        last = now.measure(on_time, u[k]) if direct else now.measure(on_time)
        late = np.argwhere((due[:k] == k) & ~np.isnan(y[:k]))
        for i, j in np.random.default_rng(k).permutation(late).tolist():
            last = now.arrived(plant.output_names[j], k - i, y[i, j])
        found.append(last)
        now.advance() if direct or not plant.m else now.advance(u[k])
    return [np.array(X) for X in zip(*found)]


@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_live_is_the_record_bit_for_bit(monkeypatch, kind, m1):
    monkeypatch.setattr(live, "ROOM", 2)  # rows are moved to the front often
    for seed in range(6):
        plant, y, u, due = a_plant(seed, kind)
        if seed % 2:
            plant = replace(plant, E=None)
        run = lb.Filter(plant, m1)
        now = run.live(horizon=9, u0=np.ones(plant.m))
        x, std = at_work(now, plant, y, u, due)
        found = run.run(lb.Record(y, u, arrival=due, u0=np.ones(plant.m)))
        assert np.array_equal(found.x, x) and np.array_equal(found.std, std), seed
        assert now.instant == len(y)


def number():
    return lb.Plant([[1]], [[1]], [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]],
                    output_names=["gps"])  # fmt: skip


def test_calls_out_of_order_are_refused_with_what_to_call():
    now = lb.Filter(number()).live(horizon=2)
    with pytest.raises(ValueError, match="instant 1 was not measured: call measure"):
        now.advance()
    with pytest.raises(ValueError, match=r"call measure\(y\) of instant 1 before arr"):
        now.arrived("gps", 0, 1.0)
    now.measure([nan])
    with pytest.raises(ValueError, match="instant 1 was measured already: call adv"):
        now.measure([1.0])
    now.advance([1.0])
    with pytest.raises(ValueError, match=r"call measure\(y\) of instant 2 before arr"):
        now.arrived("gps", 0, 1.0)
    with pytest.raises(ValueError, match="instant 2 was not measured"):
        now.advance()


@pytest.mark.parametrize(
    "given, says",
    [
        (("radar", 1, 1.0), "no output 'radar', but"),
        ((1, 1, 1.0), "no output 1, but"),
        (("gps", 3, 1.0), "at most horizon=2, got 3"),
        (("gps", -1, 1.0), "at most horizon=2, got -1"),
        (("gps", 2, 1.0), "instant 2 has none 2 before it"),
        (("gps", 1, nan), "value must be a finite number"),
        (("gps", 0, 1.0), "of 'gps' at instant 2 was there before"),
    ],
)
def test_readings_that_cannot_arrive_are_refused(given, says):
    now = lb.Filter(number()).live(horizon=2)
    now.measure([nan])
    now.advance()
    before = now.measure([1.0])
    with pytest.raises(ValueError, match=says):
        now.arrived(*given)
    x, sigma = now.arrived("gps", 1, 3.0)
    assert sigma < before[1]
    with pytest.raises(ValueError, match="at instant 1 was there before"):
        now.arrived("gps", 1, 3.0)


@pytest.mark.parametrize(
    "options, says",
    [
        (dict(horizon=-1), "horizon must be a number of rows"),
        (dict(horizon=True), "horizon must be a number of rows"),
        (dict(u0=[1, 2]), "u0 must be 1 finite"),
    ],
)
def test_options_of_a_live_filter_are_looked_at(options, says):
    with pytest.raises(ValueError, match=says):
        lb.Filter(number()).live(**options)


def test_a_continuous_plant_is_sampled_first():
    plant = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    with pytest.raises(DesignError, match=r"Filter\(plant.sampled\(0.1\)\).live\(\)"):
        lb.Filter(plant).live()
    assert lb.Filter(plant.sampled(0.1)).live().instant == 0


@pytest.mark.parametrize("y", [[1, 2], 1.0, [np.inf]])
def test_readings_of_another_kind_are_refused(y):
    with pytest.raises(ValueError, match="y must be 1 numbers or NaN"):
        lb.Filter(number()).live().measure(y)


def test_an_input_that_acts_on_its_own_readings_comes_with_them():
    plant = replace(number(), E=[[1]])
    now = lb.Filter(plant).live()
    with pytest.raises(ValueError, match=r"measure\(y, u\), then advance\(\)"):
        now.measure([1.0])
    now.measure([1.0], [2.0])
    with pytest.raises(ValueError, match=r"call advance\(\) without it"):
        now.advance([2.0])
    now.advance()
    with pytest.raises(ValueError, match="u has entries that are not finite"):
        now.measure([1.0], [nan])


# -- observers at work -----------------------------------------------------------------


@pytest.mark.parametrize("feedthrough", [False, True])
@pytest.mark.parametrize("steps", [None, 30])
def test_an_observer_at_work_estimates_as_over_the_record(feedthrough, steps):
    rng = np.random.default_rng(1)
    plant = lb.Plant([[1, 0.1], [0, 0.9]], [[0], [1]], [[1, 0]],
                     [[0.5]] if feedthrough else None, dt=0.1, Q=np.eye(2), R=[[1]],
                     P0=np.eye(2))  # fmt: skip
    observer = lb.reduced_order_filter(plant, 0, steps=steps)
    y, u = rng.normal(size=(30, 1)), rng.normal(size=(30, 1))
    wanted = lb.estimate(observer, lb.Record(y, u), x0=[1, 2])
    now, found = observer.live(x0=[1, 2]), []
    for k in range(30):
        found.append(now.measure(y[k], *([u[k]] if feedthrough else [])))
        now.advance(*([] if feedthrough else [u[k]]))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
    if steps:
        with pytest.raises(ValueError, match="designed for 30 rows, and all were"):
            now.measure([1.0], [1.0])


def test_an_observer_at_work_takes_whole_readings_in_order():
    now = lb.kalman_filter(replace(number(), Q=[[1]])).live()
    with pytest.raises(ValueError, match=r"Filter\(plant\).live\(\)"):
        now.measure([nan])
    with pytest.raises(ValueError, match="instant 1 was not measured"):
        now.advance()
    now.measure([1.0])
    with pytest.raises(ValueError, match="call advance"):
        now.measure([1.0])
    continuous = lb.Observer([[-1]], [[]], [[1]], [[1]], [[0]], T=[[1]], L=[[1]])
    with pytest.raises(ValueError, match="needs a sampling period"):
        continuous.live()


@pytest.mark.parametrize("m1", [0, 1])
def test_a_start_at_work_may_be_unknown(m1):
    """Bit for bit what a record finds, also with a reading that comes late."""
    rng = np.random.default_rng(4)
    A, C = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(3), R=np.eye(2))
    y = rng.normal(size=(9, 2))
    y[[0, 2, 4], [0, 0, 1]] = np.nan
    one = lb.Filter(plant, m1)
    wanted, now, late = one.run(y), one.live(horizon=3), y[1, 1]
    assert np.isinf(wanted.std[0]).any() and np.isfinite(wanted.std[-1]).all()
    for k, row in enumerate(y):
        x, sigma = now.measure(np.where([False, k == 1], np.nan, row))
        if k == 3:
            x, sigma = now.arrived(1, 2, late)
        if k not in (1, 2):
            np.testing.assert_allclose(x, wanted.x[k], rtol=1e-12)
            np.testing.assert_allclose(sigma, wanted.std[k], rtol=1e-12)
        now.advance()
