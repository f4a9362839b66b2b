"""`Plant.sampled`: the discrete plant of a continuous one, against exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.signal

import luenberger as lb


def ball(**changes):
    """Position and velocity of a ball on a beam, in metres and radians."""
    given = dict(Q=np.diag([0, 1.5]), R=[[0.25]], P0=np.eye(2), input_names=["angle"])
    return lb.Plant([[0, 1], [0, 0]], [[0], [4.5]], [[1, 0]], **(given | changes))


def damped(seed=3, n=4, m=2, p=2):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) - 2 * np.eye(n)
    G = rng.normal(size=(n, 2))
    return lb.Plant(
        A, rng.normal(size=(n, m)), rng.normal(size=(p, n)), rng.normal(size=(p, m)),
        Q=G @ G.T, R=np.eye(p),
    )  # fmt: skip


@pytest.mark.parametrize("power", [-40, -3, 0, 40])
def test_a_double_integrator_is_that_of_exact_fractions(power):
    """In any unit of time: A, B and a rank-one intensity, term by term."""
    dt = Fraction(1, 8) * Fraction(2) ** power
    found = ball().sampled(float(dt))
    A = [[1, dt], [0, 1]]
    B = [[Fraction(9, 4) * dt**2], [Fraction(9, 2) * dt]]
    q = Fraction(3, 2)
    Q = [[q * dt**3 / 3, q * dt**2 / 2], [q * dt**2 / 2, q * dt]]
    for got, exact in ((found.A, A), (found.B, B), (found.Q, Q)):
        np.testing.assert_allclose(got, np.array(exact, float), rtol=1e-14)
    assert found.dt == float(dt) and (found.R == 0.25).all() and found.exact is None


def test_inputs_are_held_as_scipy_holds_them():
    plant = damped()
    A, B, C, E, _ = scipy.signal.cont2discrete(
        (plant.A, plant.B, plant.C, plant.E), 0.3, method="zoh"
    )
    found = plant.sampled(0.3)
    np.testing.assert_allclose(found.A, A, rtol=1e-12)
    np.testing.assert_allclose(found.B, B, rtol=1e-12)
    np.testing.assert_array_equal(found.C, C)
    np.testing.assert_array_equal(found.E, E)


def test_one_period_is_a_row_of_uneven_ones():
    plant = damped()
    uneven = lb.sampling.discretise(plant, [0.3, 0.7]).at(0)
    found = plant.sampled(0.3)
    assert found.steps is None
    for name in "ABQ":
        np.testing.assert_array_equal(getattr(found, name), getattr(uneven, name))


def test_what_is_not_of_time_stays():
    plant = ball(x0=[1, 2], at_first=True, name="ball", description="on a beam")
    found = plant.sampled(0.5)
    names = "name description at_first state_names input_names output_names"
    for name in names.split():
        assert getattr(found, name) == getattr(plant, name)
    np.testing.assert_array_equal(found.x0, [1, 2])
    np.testing.assert_array_equal(found.P0, np.eye(2))


@pytest.mark.parametrize("lacking", ["Q", "R", "QR", ""])
def test_noise_that_is_not_given_stays_away(lacking):
    found = ball(**dict.fromkeys(lacking)).sampled(0.1)
    assert [name for name in "QR" if getattr(found, name) is None] == [*lacking]


def test_no_noise_and_perfect_sensors_are_noise_too():
    found = ball(Q=np.zeros((2, 2)), R=[[0]], S=np.zeros((2, 1))).sampled(0.1)
    assert not found.Q.any() and not found.R.any() and found.S is None


def test_two_samples_of_half_the_period_are_one():
    whole, half = damped().sampled(0.4), damped().sampled(0.2)
    A, B, Q = half.A, half.B, half.Q
    np.testing.assert_allclose(A @ A, whole.A, rtol=1e-12)
    np.testing.assert_allclose(A @ B + B, whole.B, rtol=1e-12)
    np.testing.assert_allclose(A @ Q @ A.T + Q, whole.Q, rtol=1e-10)


REFUSED = {
    "discrete": (lambda: ball(dt=0.1).sampled(0.1), "dt = 0.1, it is discrete already"),
    "zero": (lambda: ball().sampled(0), "must be positive, got 0 s"),
    "negative": (lambda: ball().sampled(-0.1), "a period in seconds, got -0.1"),
    "not a number": (lambda: ball().sampled(np.nan), "a period in seconds, got nan"),
    "text": (lambda: ball().sampled("0.1"), "a period in seconds, got '0.1'"),
    "periods": (lambda: ball().sampled([0.1, 0.2]), "a period in seconds"),
    "S": (
        lambda: ball(Q=np.eye(2), S=[[0.1], [0.1]]).sampled(0.1),
        "has S, .* Leave S out",
    ),
    "multiplicative": (
        lambda: ball(multiplicative=[(np.eye(2), [[0, 0]])]).sampled(0.1),
        "multiplicative noise is not discretised",
    ),
    "varying": (lambda: lb.Plant([[[1]]], None, [[1]]).sampled(1), "only constant"),
    "complex": (lambda: lb.Plant([[1j]], None, [[1]]).sampled(1), "real plants"),
    "growing": (
        lambda: lb.Plant([[800]], None, [[1]]).sampled(1),
        "beyond what floats",
    ),
}


@pytest.mark.parametrize(("make", "message"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_sampled(make, message):
    with pytest.raises(ValueError, match=message):
        make()


ASKING = {
    "kalman": lambda plant, _: lb.kalman_filter(plant),
    "record": lambda plant, _: lb.Filter(plant).run([[1.0]]),
    "deadbeat": lambda plant, _: lb.deadbeat_observer(plant),
    "covariance": lambda plant, observer: lb.error_covariance(observer, plant),
    "optimality": lambda plant, observer: lb.optimality(observer, plant),
    "runs": lambda plant, observer: lb.monte_carlo(
        plant, observer, runs=2, steps=2, seed=1
    ),
    "estimate": lambda _, observer: lb.estimate(observer, [[1.0]]),
    "C": lambda _, observer: lb.export.to_c(observer, "nowhere"),
}


@pytest.mark.parametrize("ask", ASKING.values(), ids=ASKING)
def test_what_needs_samples_says_what_makes_them(ask):
    plant = ball()
    observer = lb.reduced_order_observer(plant, [-1])
    with pytest.raises(ValueError, match=r"plant\.sampled\(0\.1\)"):
        ask(plant, observer)
