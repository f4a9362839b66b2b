"""Rows in compiled code from prediction to prediction, where outputs have no noise.

They are held against filters in rational arithmetic, and against NumPy; most run the
generated code as plain Python.
"""

import dataclasses

import exact_filter
import generators
import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger.numeric.factors import EPS
from luenberger.recursion.predicted import by_predictions, predicted
from luenberger.recursion.root_step import Spread
from luenberger.recursion.settings import Settings
from luenberger.recursion.state import start

pytest.importorskip("numba", reason="numba is an optional extra")

nan = float("nan")
KINDS = ["perfect", "one perfect", "one and S", "varying", "varying, S", "now and then"]


def problem(kind, rows=9, seed=4, n=3):
    """A plant with noise in every state, and a record with gaps."""
    rng = np.random.default_rng(seed)
    R = np.diag([0.0, 0.0 if kind in ("perfect", "varying") else 0.25])
    R = np.eye(2) if kind == "varying, S" else R
    S = np.zeros((n, 2))
    if kind.endswith("S"):
        S[:, 1] = rng.normal(size=n) / 8
    H = rng.normal(size=(n, n))
    given = dict(Q=H @ H.T + np.eye(n) / 4, R=R, S=S, P0=np.eye(n), dt=1.0)
    A, C = generators.dynamics(rng, n, 0.9), rng.normal(size=(2, n))
    if kind.startswith("varying"):
        A = A * rng.uniform(0.9, 1.1, (rows + 1, 1, 1))
        C = C * rng.uniform(0.9, 1.1, (rows + 1, 1, 1))
    if kind == "now and then":
        given["R"] = R * (np.arange(rows + 1) % 3 > 0)[:, None, None]
    plant = lb.Plant(A, rng.normal(size=(n, 1)), C, np.ones((2, 1)), **given)
    y, u, u0 = generators.record(rng, plant, rows)
    y[3, 0] = y[5] = y[6, 1] = nan
    return plant, y, u, u0


def in_units(plant, y, states, outputs):
    """The same problem with other units of states and outputs."""
    x, z = np.array(states), np.array(outputs)
    other = dataclasses.replace(
        plant, A=plant.A / x[:, None] * x, B=plant.B / x[:, None],
        C=plant.C / z[:, None] * x, E=plant.E / z[:, None],
        Q=plant.Q / x / x[:, None], R=plant.R / z / z[:, None],
        S=plant.S / x[:, None] / z, P0=plant.P0 / x / x[:, None], x0=plant.x0 / x,
    )  # fmt: skip
    return other, y / z


def run(plant, y, u=None, backend="numba", **more):
    return in_full(plant, y, u, backend=backend, **more)


def agree(found, wanted, tol=1e-11):
    for name in ("x", "P", "std", "K"):
        a, b = getattr(found, name), getattr(wanted, name)
        assert generators.relative(a, b) < tol, name
    np.testing.assert_array_equal(found.P, found.P.mT)


# -- beside rational arithmetic --------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_rows_are_those_of_rationals(kind, form, by_hand):
    plant, y, u, u0 = problem(kind)
    x, P = generators.exact(plant, y, u, u0)
    found = run(plant, y, u, u0=u0)
    assert by_hand == []
    assert generators.relative(found.P, P) < 1e-13
    assert generators.relative(found.x, x) < 1e-13


@pytest.mark.parametrize("kind", KINDS)
def test_units_of_states_and_outputs_cost_no_digits(kind, plain, by_hand):
    plant, y, u, u0 = problem(kind)
    states, outputs = [1e6, 1, 1e-6], [1e-6, 1e6]
    other, z = in_units(plant, y, states, outputs)
    x, P = generators.exact(other, z, u, u0)
    found = run(other, z, u, u0=u0)
    assert by_hand == []
    assert generators.relative(found.x * states, x * states) < 1e-12
    unit = np.outer(states, states)
    assert generators.relative(found.P * unit, P * unit) < 1e-12


@pytest.mark.parametrize("block", range(2))
def test_singular_problems_are_those_of_rationals(block, plain, by_hand):
    """Most rows of these problems are singular; the others are compiled."""
    rows = 0
    for seed in range(block, 80, 2):
        one = exact_filter.problem(seed)
        if not by_predictions(Settings(one.plant, list(one.accurate))):
            continue
        exact = one.exact()
        found = run(one.plant, one.record, m1=list(one.accurate))
        off = max(one.errors(found.x, found.P, exact))
        slack = one.sensitivity(exact) if off > 1e-9 else 0.0
        assert off < 1e-9 + slack + 1e-4 * slack**0.5, (seed, off, one.kinds)
        rows += len(one.record)
    assert 0 < len(by_hand) < rows


def test_a_state_that_is_read_off_has_no_variance(plain, by_hand):
    """Not the rounding of a difference, which is 1e-8 of a standard deviation."""
    plant, y, u, u0 = problem("perfect")
    C = np.array([[3.0, 0, 0], [0, 0.1, 0]])
    plant = dataclasses.replace(plant, C=C, A=plant.A * 0.1, E=np.zeros((2, 1)))
    found = run(plant, np.round(y, 1), u, u0=u0)
    assert by_hand == []
    assert found.std[:3, :2].max() < 1e-14
    np.testing.assert_allclose(found.x[:3, :2] @ C[:, :2].T, np.round(y[:3], 1))


@pytest.mark.parametrize("kind", KINDS)
def test_readings_of_zero(kind, plain, by_hand):
    """No reading has a size, and the state starts at zero."""
    plant, y, u, _ = problem(kind)
    plant = dataclasses.replace(plant, x0=np.zeros(3))
    found, wanted = (
        run(plant, 0 * y, 0 * u, backend) for backend in ("numba", "numpy")
    )
    assert by_hand == list(range(9))  # those of NumPy
    np.testing.assert_array_equal(found.x, np.zeros((9, 3)))
    for name in ("P", "std", "K"):
        assert generators.relative(getattr(found, name), getattr(wanted, name)) < 1e-12


# -- beside NumPy ----------------------------------------------------------------------


@pytest.mark.parametrize("m1", [[0], [0, 1], ["y1"]], ids=str)
@pytest.mark.parametrize("kind", ["perfect", "varying"])
def test_accurate_outputs_without_noise(kind, m1, form, by_hand):
    """The gain that treats them as exact is the Kalman filter's."""
    plant, y, u, u0 = problem(kind, rows=25)
    wanted = run(plant, y, u, "numpy", u0=u0, m1=m1)
    by_hand.clear()
    found = run(plant, y, u, u0=u0, m1=m1)
    assert by_hand == []
    agree(found, wanted)


@pytest.mark.parametrize("kind", ["one perfect", "varying, S"])
def test_accurate_outputs_with_noise_take_the_other_way(kind, plain):
    plant, y, u, u0 = problem(kind, rows=12)
    assert not by_predictions(Settings(plant, [1]))
    agree(run(plant, y, u, u0=u0, m1=[1]), run(plant, y, u, "numpy", u0=u0, m1=[1]))


def test_rows_whose_prediction_is_singular_are_numpys(form, by_hand):
    """No noise drives a state for a while, and an exact reading tells it."""
    plant, *_ = problem("perfect", rows=60)
    Q = np.ones((61, 1, 1)) * plant.Q
    Q[20:24, 0], Q[20:24, :, 0] = 0, 0
    A = np.diag([0.9, 0.5, 0.8])
    plant = dataclasses.replace(plant, A=A, C=np.eye(3)[:2], Q=Q, S=None)
    y, u, u0 = generators.record(np.random.default_rng(0), plant, 60)
    y[::7, 1] = nan
    wanted = run(plant, y, u, "numpy", u0=u0)
    by_hand.clear()
    agree(run(plant, y, u, u0=u0), wanted)
    assert by_hand[0] < 21 < len(by_hand) + 18 < 50


@pytest.mark.parametrize("small", [1e-6, 1e-3])
def test_what_is_small_beside_what_it_is_made_of_keeps_its_digits(small, form, by_hand):
    """One direction of the state is hardly driven: few digits are left in a sum."""
    plant, *_ = problem("perfect", rows=40)
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    Q = turn @ np.diag([small**2, 1, 1]) @ turn.T
    A, C = turn @ np.diag([0.9, 0.5, 0.8]) @ turn.T, (turn @ np.eye(3)[:, :2]).T
    Q, A = Q + Q.T, A
    plant = dataclasses.replace(plant, A=A, C=C, Q=Q / 2, S=None)
    y, u, u0 = generators.record(rng, plant, 40)
    y[::7, 1] = nan
    wanted = run(plant, y, u, "numpy", u0=u0)
    by_hand.clear()
    found = run(plant, y, u, u0=u0)
    assert (len(by_hand) > 30) == (small < 1e-5)
    agree(found, wanted, 1e-9)


def test_sensors_that_are_nearly_the_same_keep_their_digits(plain, by_hand):
    """What the second adds has few digits left in a covariance of both."""
    plant, *_ = problem("perfect", rows=40)
    plant = dataclasses.replace(plant, C=np.array([[1.0, 0, 1], [1, 3e-5, 1]]))
    y, u, u0 = generators.record(np.random.default_rng(0), plant, 40)
    y[5:9, 0] = nan
    wanted = run(plant, y, u, "numpy", u0=u0)
    by_hand.clear()
    agree(run(plant, y, u, u0=u0), wanted, 1e-9)
    assert 20 < len(by_hand) < 40


def test_one_thing_read_twice_is_numpys(plain, by_hand):
    plant, y, u, u0 = problem("varying", rows=60)
    C = plant.C.copy()
    C[31::10, 1] = 2 * C[31::10, 0]
    plant = dataclasses.replace(plant, C=C, E=np.zeros((2, 1)))
    y[30::10, 1] = 2 * y[30::10, 0]
    wanted = run(plant, y, u, "numpy", u0=u0)
    by_hand.clear()
    agree(run(plant, y, u, u0=u0), wanted)
    assert by_hand[0] == 30 and 3 <= len(by_hand) < 24
    y[40, 1] += 0.5
    for backend in ("numpy", "numba"):
        with pytest.raises(lb.DesignError, match=r"instant 41 .*by 0\.25"):
            run(plant, y, u, backend, u0=u0)


@pytest.mark.parametrize("options", [dict(m1=2), dict(weight="canonical")], ids=str)
def test_accurate_outputs_that_depend_on_each_other_are_refused(options, plain):
    plant, y, u, u0 = problem("perfect")
    C = plant.C.copy()
    C[1] = C[0]
    y[3:, 1] = nan  # they arrive together in the first rows only
    many = dataclasses.replace(plant, C=C * np.ones((10, 1, 1)))
    for one in (dataclasses.replace(plant, C=C), many):
        for backend in ("numpy", "numba"):
            with pytest.raises(lb.DesignError, match="dependent"):
                run(one, y, u, backend, u0=u0, **options)


def test_what_may_be_refused_in_a_later_row_is_looked_for_in_each(plain):
    """The outputs are dependent for the weight, and the innovations are not."""
    C = np.ones((10, 2, 2)) * np.eye(2)
    C[6, 1] = [1, 1e-11]
    large = np.diag([1, 1e22])
    plant = lb.Plant(
        np.eye(2) / 2, None, C, dt=1.0, Q=large, R=np.zeros((2, 2)), P0=large
    )
    y = np.ones((9, 2))
    assert np.isfinite(run(plant, y, m1=2).x).all()  # dependent in no other units
    for backend in ("numpy", "numba"):
        assert np.isfinite(run(plant, y, backend=backend).x).all()
        for one in (plant, dataclasses.replace(plant, C=C[6])):
            y[[0, 8], 1] = nan
            with pytest.raises(lb.DesignError, match="independent"):
                run(one, y, backend=backend, weight="canonical")


@pytest.mark.parametrize("options", [dict(m1=2), dict(weight="canonical")], ids=str)
def test_outputs_that_never_arrive_together_may_depend_on_each_other(options, plain):
    plant, y, u, u0 = problem("perfect")
    plant = dataclasses.replace(plant, C=plant.C[[0, 0]])
    y[::2, 0], y[1::2, 1] = nan, nan
    agree(
        run(plant, y, u, u0=u0, **options), run(plant, y, u, "numpy", u0=u0, **options)
    )


def together(rows=8, still=4):
    """States that noise moves together; one output is a difference of two of them.

    Nothing drives them before the row `still`, which tells them exactly.
    """
    rng = np.random.default_rng(412)
    Q = np.ones((4, 4)) + 1e-4 * np.diag(rng.uniform(0.5, 2, 4))
    one = np.array([5e-3, 0, 1, 0])
    Q = (Q + np.outer(one, one)) * np.ones((rows + 1, 1, 1))
    Q[still] = 0
    C = rng.normal(size=(3, 4))
    C[0] = [1, -1, 0, 0]
    plant = lb.Plant(
        generators.dynamics(rng, 4, 0.7), rng.normal(size=(4, 1)), C, np.zeros((3, 1)),
        Q=Q, R=np.diag([0, 4e-12, 0]), P0=np.eye(4), dt=1.0,
    )  # fmt: skip
    return plant, *generators.record(rng, plant, rows)


def test_a_small_difference_of_what_moves_together_keeps_its_digits(form, by_hand):
    """Its variance has few digits left, where its size says that it has all of them."""
    plant, y, u, u0 = together()
    x, P = generators.exact(plant, y, u, u0)
    found = run(plant, y, u, u0=u0)
    assert 0 < len(by_hand) < 8
    slack = 1e-6 * np.sqrt(P.astype(float).diagonal(axis1=1, axis2=2))
    assert (np.abs(found.x - x.astype(float)) < slack + 1e-10).all()


def test_an_output_with_few_digits_is_numpys(plain, by_hand):
    """All pivots of the prediction's covariance have more than its variance has."""
    rng = np.random.default_rng(0)
    lower = np.array([[1, 0, 0], [1, 2.0**-9, 0], [0, 1, 2.0**-9]])
    turn = np.array([[3.0, 1, 0], [0, 5, 1], [1, 0, 7]]) / 7  # rounds all entries
    C = np.array([[1, -1, 2.0**-9]]) @ np.linalg.inv(turn)  # shows 2^-18 of the last
    Q = turn @ lower @ lower.T @ turn.T
    plant = lb.Plant(
        np.zeros((3, 3)), None, C, dt=1.0, Q=(Q + Q.T) / 2, R=[[0]], P0=np.eye(3)
    )
    y = rng.normal(size=(3, 1)) * 2.0**-18
    x, P = generators.exact(plant, y)
    found = run(plant, y)
    assert len(by_hand) == 3
    assert generators.relative(found.x, x) < 1e-4


@pytest.mark.parametrize("form", ["loops"], indirect=True)
@pytest.mark.parametrize("still", range(1, 9))
def test_a_reading_that_was_known_is_noticed_in_each_row(still, form):
    """Between two tests of the prediction's covariance as well."""
    rng, Q = np.random.default_rng(still), np.eye(3) * np.ones((12, 1, 1))
    Q[still] = 0
    A, C = generators.dynamics(rng, 3, 0.9), rng.normal(size=(3, 3))
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=np.zeros((3, 3)), P0=np.eye(3))
    y = rng.normal(size=(11, 3))
    y[still] = nan, nan, C[2] @ A @ np.linalg.solve(C, y[still - 1])
    found, wanted = (run(plant, y, backend=one) for one in ("numba", "numpy"))
    np.testing.assert_allclose(found.x, wanted.x, atol=1e-13)
    np.testing.assert_allclose(found.std, wanted.std, atol=1e-13)
    y[still, 2] += 0.01
    with pytest.raises(lb.DesignError, match=rf"instant {still + 1} .*by 0\.01"):
        run(plant, y)


def test_rounding_that_has_grown_is_not_taken_for_variance():
    """A prediction is used if it is definite beside what it was made of."""
    plant, *_ = problem("perfect")
    settings = Settings(plant, 0)
    begin = start(settings, plant.x0, np.zeros(1))
    half = np.eye(3)
    for size, used in ((1, True), (1e5, True), (1e12, False)):
        spread = Spread(half @ half.T, half, np.diag([(EPS * size) ** 2, 0, 0]))
        assert (predicted(settings, begin._replace(spread=spread)) is None) != used


# -- parts of a record -----------------------------------------------------------------


@pytest.mark.parametrize("kind", ["one perfect", "varying, S"])
def test_chunks_change_no_bit(kind, plain):
    plant, y, u, u0 = problem(kind, rows=40)
    whole = run(plant, y, u, u0=u0)
    for ends in ([1], [7, 8, 30], [8, 18], list(range(1, 40))):
        found = run(plant, y, u, u0=u0, parts=ends)
        for name in ("x", "std", "P", "K"):
            np.testing.assert_array_equal(getattr(found, name), getattr(whole, name))


def test_numba_for_a_thousand_rows(by_hand):
    plant, *_ = problem("one perfect")
    y, u, u0 = generators.record(np.random.default_rng(0), plant, 1_000)
    y[np.random.default_rng(1).random(y.shape) < 0.05] = nan
    found = run(plant, y, u, u0=u0)
    assert by_hand == []
    agree(found, run(plant, y, u, "numpy", u0=u0))
