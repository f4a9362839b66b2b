"""Rows with a gain that has settled: within their bound, whatever the chunks are."""

from dataclasses import replace
from decimal import Decimal
from functools import partial

import generators
import numpy as np
import pytest
from bounds_of_settling import of_plant

import luenberger as lb
from luenberger.numeric.rounded import Rounded
from luenberger.recursion import settled_pass
from luenberger.recursion.innovations import largest
from luenberger.recursion.measure import Measure
from luenberger.recursion.root_step import Spread
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled import ball, near
from luenberger.recursion.state import start, step

filtered = partial(lb.filter_data, backend="numpy")  # which looks after a few rows
SLOW = lb.Plant([[1.0]], None, [[1]], dt=1.0, Q=[[0.01]], R=[[1]], P0=[[1]])
SCALAR = lb.Plant([[1.0]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[100]])


@pytest.fixture(params=["S = 0", "S"])
def case(request):
    rng = np.random.default_rng(12)
    plant = generators.plant(rng, 3, 2, m=2, cross=request.param == "S")
    return plant, *generators.record(rng, plant, 300)[:2]


@pytest.mark.parametrize("settle, least", [(1e-9, 7), (1e-4, 10), (0.5, 10)])
def test_settled_rows_are_within_their_bound(settle, least):
    """A few of the thousand plants of `python tests/support/bounds_of_settling.py`."""
    found = [one for seed in range(12) if (one := of_plant(seed, settle)) is not None]
    assert len(found) >= least
    assert all(max(x, P) <= bound for bound, x, P in found)


def test_rounding_of_the_gain_is_in_the_bound():
    """Two outputs that nearly agree: their innovations are hundreds of units long."""
    bound, x, _ = of_plant(467)
    assert 1e-12 < x <= bound < 1e-8


@pytest.mark.parametrize("settle", [0.5, 1e-2, 1e-4])
def test_the_ball_holds_the_limit_and_is_not_much_larger(settle):
    """Of a random walk the limit is known: Omega^2 = Omega + 1 for Q = R = 1."""
    run = filtered(SCALAR, np.zeros((60, 1)), settle=settle, history=True)
    (row,) = run.settled_at
    limit = (np.sqrt(5) - 1) / 2
    off = run.P[row, 0, 0] / limit - 1
    assert 0 < off <= run.settle_bound < 40 * off


def size_of(ball):
    """H of one state, in the units of Omega."""
    return (ball.unit[0] * ball.H.root[0, 0]) ** 2


def from_variance(Sigma):
    """The ball that is found one step on, and the distance of the limit from it."""
    at, _ = near(Settings(SLOW, 0).at(2), Spread.of(np.array([[Sigma]])), 100.0)
    found, _ = ball(at, 100.0)
    held = found.held()
    q = Decimal(0.01)  # Omega^2 = q Omega + q, for R = 1
    limit = (q + (q * q + 4 * q).sqrt()) / 2
    return held, float(abs(Decimal(float(found.Omega[0, 0])) - limit))


@pytest.mark.parametrize("Sigma", [0.085, 0.0945, 0.0956, 0.1, 0.105])
def test_the_ball_of_a_slow_filter_holds_its_limit(Sigma):
    """From above the gain is too large, and the rest is more than it says itself."""
    found, off = from_variance(Sigma)
    assert off <= found.t * size_of(found.ball) < 4 * off


def test_the_ball_counts_rounding_where_a_step_changes_nothing():
    Sigma = np.float64(0.1)
    for _ in range(400):
        Omega = Sigma + 0.01
        Sigma = (1 - Omega / (Omega + 1)) ** 2 * Omega + (Omega / (Omega + 1)) ** 2
    found, off = from_variance(Sigma)
    assert 0 < off <= found.t * size_of(found.ball) < 1e-12


def test_the_ball_counts_what_its_prediction_lacks():
    at = from_variance(0.1)[0].ball
    lacks = abs(Decimal(0.1) + Decimal(0.01) - Decimal(at.Omega.item()))
    assert 0 < lacks <= at.off * size_of(at) < 1e-15


def test_rounding_of_a_row_is_carried_to_the_next():
    """Estimates are apart by that of their own row, and at least that of the last."""
    found, _ = from_variance(0.1)
    rounding = np.array([1e-3])
    at = found.ball
    carried = at.reach * at.length(at.moves @ rounding)
    own = rounding / np.sqrt(at.Sigma.diagonal())
    assert (carried > 0).all()
    D = found.drift(0.0, rounding)
    assert (found.apart(0.0, D, rounding) >= (own + carried) * (1 - 1e-9)).all()
    assert found.drift(0.0, 0.0, 1e-3) >= 1e-3


def test_sizes_in_units_of_a_covariance():
    """Where H is known: diag(4, 9), in units of which lengths are halves and thirds."""
    H = Measure(np.diag([2.0, 3.0]))
    none, X = np.zeros((2, 2)), np.diag([-8.0, 9.0])
    least = H.size(Rounded(X, none)), H.norm(Rounded(X, none))
    np.testing.assert_allclose([*least, H.length([2.0, 3.0])], [2, 4, 2**0.5], 1e-14)
    assert least[0] >= 2 and least[1] >= 4
    off = np.diag([4.0, 0.0])
    assert H.size(Rounded(X, off)) >= 3 and H.norm(Rounded(X, off)) >= 6
    lost = [[1.0, 0], [1e20, 1.0]]  # of which no inverse has a digit
    assert H.slack < 1 + 1e-14 and Measure(np.array(lost)).slack == np.inf


def test_a_covariance_that_has_settled_to_the_last_bit_is_as_good_as_rounding():
    run = filtered(SCALAR, np.zeros((100, 1)))
    whole = filtered(SCALAR, np.zeros((100, 1)), settle=None)
    assert whole.std[-1] == whole.std[-2]  # one more step adds nothing
    assert run.settle_bound > 1e-16


def require_the_same_bits(plant, y, u, backend):
    """Of a record in chunks of two lengths and of the whole one, which settles."""
    whole = lb.filter_data(plant, y, u, backend=backend)
    full = lb.filter_data(plant, y, u, backend=backend, settle=None)
    assert len(whole.settled_at) == 1 and not np.array_equal(whole.x, full.x)
    assert (np.abs(whole.x - full.x) <= whole.settle_bound * full.std).all()
    for size in (len(y) // 40 + 1, len(y) // 3):
        parts = range(0, len(y), size)
        some = lb.filter_data(
            plant, (y[k : k + size] for k in parts), (u[k : k + size] for k in parts),
            backend=backend,
        )  # fmt: skip
        joined = np.concatenate([part.x for part in some])
        np.testing.assert_array_equal(joined, whole.x)


@pytest.fixture
def soon(monkeypatch):
    """Compiled code looks whether it has settled after a hundred rows of 3 states."""
    monkeypatch.setattr(settled_pass, "CHEAP", 100 * 3**4)


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_chunks_do_not_change_a_bit(case, backend, soon, plain):
    require_the_same_bits(*case, backend)


def test_chunks_of_compiled_code_do_not_change_a_bit():
    """Of many lanes, and with chunks that end where the next lane has begun."""
    rng = np.random.default_rng(12)
    plant = generators.plant(rng, 3, 2, m=1)
    y, u = (np.tile(X, (160, 1)) for X in generators.record(rng, plant, 300)[:2])
    require_the_same_bits(plant, y, u, "numba")


@pytest.mark.parametrize("m1", [0, 1])
def test_after_a_gap_it_settles_again(case, m1):
    plant, y, u = case
    plant, y = replace(plant, R=plant.R * 1e-3, S=None), y.copy()
    y[150, 0] = np.nan
    y[151] = np.nan
    run = filtered(plant, y, u, m1=m1, history=True)
    full = filtered(plant, y, u, m1=m1, history=True, settle=None)
    first, again = run.settled_at
    assert first < 150 and 152 < again
    for k in (first, again):
        np.testing.assert_array_equal(run.K[k], run.K[first])
    assert (np.abs(run.x - full.x) <= run.settle_bound * full.std).all()
    assert (np.abs(run.std - full.std) <= run.settle_bound * full.std).all()
    assert generators.relative(run.P, full.P) < 1e-8
    assert generators.relative(run.K, full.K) < 1e-8


@pytest.mark.parametrize("settle, gaps", [(1e-3, 6), (1e-5, 6), (1e-6, 2)])
def test_rows_behind_gaps_are_within_the_bound(settle, gaps):
    """A third of the plants have accurate outputs; gaps are of one output or of all."""
    found = [of_plant(seed, settle, gaps) for seed in range(60, 68)]
    found = [one for one in found if one is not None]
    assert len(found) >= 5 and all(max(x, P) <= bound for bound, x, P in found)
    used = [max(x, P) / bound for bound, x, P in found]
    assert max(used) > 1e-3 and np.median([bound for bound, _, _ in found]) < 0.1


def test_a_difference_before_a_gap_is_carried_on():
    """Of a random walk that hears nothing more, the difference stays as it is."""
    y = np.random.default_rng(0).standard_normal((70, 1))
    y[40:] = np.nan
    run, full = (filtered(SLOW, y, settle=settle) for settle in (1e-2, None))
    assert len(run.settled_at) == 1 and run.settled_at[0] < 40
    off = (np.abs(run.x - full.x) / full.std)[:, 0]
    assert 1e-6 < off[-1] <= run.settle_bound
    behind = filtered(SLOW, y[:41], settle=1e-2).settle_bound
    before = filtered(SLOW, y[:40], settle=1e-2).settle_bound
    assert before <= behind <= run.settle_bound


@pytest.mark.parametrize("m1", [0, 1])
def test_innovations_of_rows_in_full(case, m1):
    """None is longer than what is found, and that is not much longer."""
    plant, y, u = case
    y = y[:60].copy()
    y[::3, 0], y[::7], y[5:9, 1] = np.nan, np.nan, np.nan
    settings = Settings(plant, m1)
    begin = state = step(settings, start(settings, plant.x0, u[0]), y[1], u[0]).state
    most, xs = 0.0, []
    for row, given in zip(y, u):
        made = step(settings, state, row, given)
        state, nu = made.state, made.innovation
        xs.append(state.x[:, 0])
        if nu.size:
            most = max(most, (nu.T @ np.linalg.solve(made.new["M"], nu)).item())
    found = largest(settings, begin, y, u[:60], np.array(xs))
    assert most**0.5 <= found < 10 * most**0.5


def test_chunks_with_gaps_do_not_change_a_bit(case):
    plant, y, u = case
    y = y.copy()
    y[90, 0], y[170:173], y[175] = np.nan, np.nan, np.nan
    whole = filtered(plant, y, u)
    assert len(whole.settled_at) >= 3
    for size in (7, 80):
        parts = range(0, 300, size)
        given = ([X[k : k + size] for k in parts] for X in (y, u))
        some = list(filtered(plant, *map(iter, given)))
        joined = np.concatenate([part.x for part in some])
        np.testing.assert_array_equal(joined, whole.x)
        assert max(part.settle_bound for part in some) > whole.settle_bound / 10


def test_outputs_that_never_arrive_do_not_matter(case):
    plant, y, u = case
    y = y.copy()
    y[:, 1] = np.nan
    run = filtered(plant, y, u)
    full = filtered(plant, y, u, settle=None)
    assert len(run.settled_at) == 1
    assert (np.abs(run.x - full.x) <= run.settle_bound * full.std).all()


@pytest.mark.parametrize(
    "change",
    [
        dict(R=np.zeros((2, 2)), S=None),
        dict(Q=np.zeros((3, 3)), S=None),
        dict(A=np.eye(3), Q=np.diag([1.0, 0, 0]), S=None),
    ],
)
def test_what_does_not_settle_is_run_in_full(case, change):
    plant, y, u = case
    plant = replace(plant, **change)
    run = filtered(plant, y, u)
    full = filtered(plant, y, u, settle=None)
    assert not len(run.settled_at) and run.settle_bound == 0
    np.testing.assert_array_equal(run.x, full.x)


def test_a_continuous_plant_settles_at_even_instants():
    plant = lb.Plant([[-1.0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    y = np.ones((200, 1))
    even = np.arange(200) * 0.5
    run = filtered(plant, y, time=even)
    full = filtered(plant, y, time=even, settle=None)
    assert len(run.settled_at) == 1
    assert (np.abs(run.x - full.x) <= run.settle_bound * full.std).all()
    uneven = filtered(plant, y, time=even**1.01)
    assert not len(uneven.settled_at)


def test_tables_say_so_too(case):
    pandas = pytest.importorskip("pandas")
    plant, y, u = case
    table = pandas.DataFrame(y, columns=plant.output_names)
    run = filtered(plant, table, u, time="rows")
    assert run.x.attrs["settled_at"] == run.settled_at.tolist() != []
    assert run.std.attrs["settle_bound"] == run.settle_bound > 0


def test_it_settles_unless_it_is_told_not_to(case):
    plant, y, u = case
    found = filtered(plant, y, u)
    same, full = (filtered(plant, y, u, settle=k) for k in (1e-9, None))
    np.testing.assert_array_equal(found.x, same.x)
    assert len(found.settled_at) == 1 and not len(full.settled_at)
    assert found.settle_bound == same.settle_bound > 0 == full.settle_bound


@pytest.mark.parametrize("settle", [0, -1e-9, 1, np.nan, "much", [1e-9, 1]])
def test_a_tolerance_is_a_small_number(settle):
    with pytest.raises(ValueError, match="settle must be a number between 0 and 1"):
        filtered(SCALAR, [[1.0]], settle=settle)


@pytest.mark.parametrize("A", [[[0.5]], [[0.5, 1], [0, 0.8]]])
def test_a_sensor_that_goes_silent_prints_nothing(A, capfd):
    """LAPACK would say on stderr that a matrix of size 0 is wrong."""
    n = len(A)
    plant = lb.Plant(A, None, np.eye(1, n), dt=1.0, Q=np.eye(n), R=[[1]], P0=np.eye(n))
    y = np.ones((200, 1))
    y[60:] = np.nan
    lb.filter_data(plant, y, backend="numpy")
    assert capfd.readouterr() == ("", "")
