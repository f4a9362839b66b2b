"""Rows with a gain that has settled: within their bound, whatever the chunks are."""

from dataclasses import replace
from decimal import Decimal

import generators
import numpy as np
import pytest
from bounds_of_settling import of_plant

import luenberger as lb
from luenberger.numeric.rounded import Rounded
from luenberger.recursion.measure import Measure
from luenberger.recursion.root_step import Spread
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled import ball

SLOW = lb.Plant([[1.0]], None, [[1]], dt=1.0, Q=[[0.01]], R=[[1]], P0=[[1]])
SCALAR = lb.Plant([[1.0]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[100]])


@pytest.fixture(params=["S = 0", "S"])
def case(request):
    rng = np.random.default_rng(12)
    plant = generators.plant(rng, 3, 2, m=2, cross=request.param == "S")
    return plant, *generators.record(rng, plant, 300)[:2]


@pytest.mark.parametrize("settle, least", [(1e-9, 14), (1e-4, 20), (0.5, 20)])
def test_settled_rows_are_within_their_bound(settle, least):
    """A few of the thousand plants of `python tests/support/bounds_of_settling.py`."""
    found = [one for seed in range(24) if (one := of_plant(seed, settle)) is not None]
    assert len(found) >= least
    assert all(max(x, P) <= bound for bound, x, P in found)


def test_rounding_of_the_gain_is_in_the_bound():
    """Two outputs that nearly agree: their innovations are hundreds of units long."""
    bound, x, _ = of_plant(467)
    assert 1e-12 < x <= bound < 1e-8


@pytest.mark.parametrize("settle", [0.5, 1e-2, 1e-4])
def test_the_ball_holds_the_limit_and_is_not_much_larger(settle):
    """Of a random walk the limit is known: Omega^2 = Omega + 1 for Q = R = 1."""
    run = lb.filter_data(SCALAR, np.zeros((60, 1)), settle=settle, history=True)
    (row,) = run.settled_at
    limit = (np.sqrt(5) - 1) / 2
    off = run.P[row, 0, 0] / limit - 1
    assert 0 < off <= run.settle_bound < 40 * off


def size_of(ball):
    """H of one state, in the units of Omega."""
    return (ball.unit[0] * ball.H.root[0, 0]) ** 2


def from_variance(Sigma):
    """The ball that is found one step on, and the distance of the limit from it."""
    found, _ = ball(Settings(SLOW, 0).at(2), Spread.of(np.array([[Sigma]])), 100.0)
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


def test_rounding_of_a_row_is_carried_to_the_next():
    """Estimates are apart by that of their own row, and at least that of the last."""
    found, _ = from_variance(0.1)
    rounding = np.array([1e-3])
    at = found.ball
    carried = at.reach * at.length(at.ahead @ rounding)
    own = rounding / np.sqrt(at.Sigma.diagonal())
    assert (carried > 0).all()
    assert (found.apart(0.0, rounding) >= (own + carried) * (1 - 1e-9)).all()
    assert (found.apart(0.0, 0.0, 1e-3) >= at.reach * 1e-3 * (1 - 1e-9)).all()


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
    run = lb.filter_data(SCALAR, np.zeros((100, 1)))
    whole = lb.filter_data(SCALAR, np.zeros((100, 1)), settle=None)
    assert whole.std[-1] == whole.std[-2]  # one more step adds nothing
    assert run.settle_bound > 1e-16


@pytest.mark.parametrize("backend, rows", [("numpy", 300), ("numba", 12_000)])
def test_chunks_do_not_change_a_bit(case, backend, rows):
    plant, y, u = case
    y, u = (np.tile(one, (rows // 300, 1)) for one in (y, u))
    whole = lb.filter_data(plant, y, u, backend=backend)
    full = lb.filter_data(plant, y, u, backend=backend, settle=None)
    assert len(whole.settled_at) == 1 and not np.array_equal(whole.x, full.x)
    assert (np.abs(whole.x - full.x) <= whole.settle_bound * full.std).all()
    for size in (rows // 40 + 1, rows // 3):
        parts = range(0, rows, size)
        some = lb.filter_data(
            plant, (y[k : k + size] for k in parts), (u[k : k + size] for k in parts),
            backend=backend,
        )  # fmt: skip
        joined = np.concatenate([part.x for part in some])
        np.testing.assert_array_equal(joined, whole.x)


@pytest.mark.parametrize("m1", [0, 1])
def test_after_a_gap_it_settles_again(case, m1):
    plant, y, u = case
    plant, y = replace(plant, R=plant.R * 1e-3, S=None), y.copy()
    y[150, 0] = np.nan
    y[151] = np.nan
    run = lb.filter_data(plant, y, u, m1=m1, history=True)
    full = lb.filter_data(plant, y, u, m1=m1, history=True, settle=None)
    first, again = run.settled_at
    assert first < 150 and 152 < again
    for k in (first, again):
        np.testing.assert_array_equal(run.K[k], run.K[first])
    assert (np.abs(run.x - full.x) <= 2 * run.settle_bound * full.std).all()
    assert (np.abs(run.std - full.std) <= run.settle_bound * full.std).all()
    assert generators.relative(run.P, full.P) < 1e-8
    assert generators.relative(run.K, full.K) < 1e-8


def test_outputs_that_never_arrive_do_not_matter(case):
    plant, y, u = case
    y = y.copy()
    y[:, 1] = np.nan
    run = lb.filter_data(plant, y, u)
    full = lb.filter_data(plant, y, u, settle=None)
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
    run = lb.filter_data(plant, y, u)
    full = lb.filter_data(plant, y, u, settle=None)
    assert not len(run.settled_at) and run.settle_bound == 0
    np.testing.assert_array_equal(run.x, full.x)


def test_a_continuous_plant_settles_at_even_instants():
    plant = lb.Plant([[-1.0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    y = np.ones((200, 1))
    even = np.arange(200) * 0.5
    run = lb.filter_data(plant, y, time=even)
    full = lb.filter_data(plant, y, time=even, settle=None)
    assert len(run.settled_at) == 1
    assert (np.abs(run.x - full.x) <= run.settle_bound * full.std).all()
    uneven = lb.filter_data(plant, y, time=even**1.01)
    assert not len(uneven.settled_at)


def test_tables_say_so_too(case):
    pandas = pytest.importorskip("pandas")
    plant, y, u = case
    table = pandas.DataFrame(y, columns=plant.output_names)
    run = lb.filter_data(plant, table, u, time="rows")
    assert run.x.attrs["settled_at"] == run.settled_at.tolist() != []
    assert run.std.attrs["settle_bound"] == run.settle_bound > 0


def test_it_settles_unless_it_is_told_not_to(case):
    plant, y, u = case
    found = lb.filter_data(plant, y, u)
    same, full = (lb.filter_data(plant, y, u, settle=k) for k in (1e-9, None))
    np.testing.assert_array_equal(found.x, same.x)
    assert len(found.settled_at) == 1 and not len(full.settled_at)
    assert found.settle_bound == same.settle_bound > 0 == full.settle_bound


@pytest.mark.parametrize("settle", [0, -1e-9, 1, np.nan, "much", [1e-9, 1]])
def test_a_tolerance_is_a_small_number(settle):
    with pytest.raises(ValueError, match="settle must be a number between 0 and 1"):
        lb.filter_data(SCALAR, [[1.0]], settle=settle)
