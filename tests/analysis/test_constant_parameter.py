"""White noise for a parameter that is wrong for good: the factor, by other means."""

import dataclasses
import functools
from fractions import Fraction as F

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis.constant_parameter import white_noise_factor


def oscillator(damping):
    A, Q = [[0, 1], [-25, -damping]], np.diag([1e-6, 0.02])
    return lb.Plant(A, None, [[1, 0]], Q=Q, R=[[0.01]]).sampled(0.05)


def both_effects(observer, plant, A1, s):
    """What +-s in the place of the parameter adds to the cost, and what noise adds."""
    none = np.zeros_like(plant.C)
    true = [dataclasses.replace(plant, A=plant.A + t * A1) for t in (s, -s)]
    noisy = dataclasses.replace(plant, multiplicative=[(s * A1, none)])
    before = lb.error_covariance(observer, plant).trace()
    two = [lb.error_covariance(observer, one).trace() for one in true]
    return np.mean(two) - before, lb.error_covariance(observer, noisy).trace() - before


def cases():
    rng = np.random.default_rng(8)
    plant = oscillator(0.5)
    slope = (oscillator(0.5001).A - oscillator(0.4999).A) / 2e-4
    yield "oscillator", lb.kalman_filter(plant), plant, slope, 0.02
    for k, design in enumerate(
        [lb.kalman_filter, lambda p: lb.reduced_order_filter(p, 1),
         lambda p: lb.fixed_order_filter(p, 1)]
    ):  # fmt: skip
        plant = generators.plant(rng, 3, 1, m=0)
        A = plant.A * 0.8 / np.abs(np.linalg.eigvals(plant.A)).max()
        plant = dataclasses.replace(plant, A=A)
        yield f"drawn {k}", design(plant), plant, rng.normal(size=(3, 3)), 0.004


@functools.cache
def known():
    return {name: given for name, *given in cases()}


@pytest.mark.parametrize("name", ["oscillator", "drawn 0", "drawn 1", "drawn 2"])
def test_noise_that_is_stronger_by_the_factor_costs_the_same(name):
    """What differs is of second order: a fourth of it where the parameter is halved."""
    observer, plant, A1, s = known()[name]
    factor = white_noise_factor(observer, plant, A1)
    off = []
    for one in (s, s / 2):
        constant, white = both_effects(observer, plant, A1, one)
        off.append(constant / white / factor - 1)
    assert abs(off[1]) < 0.05 and off[0] / off[1] == pytest.approx(4, rel=0.2)


def exact_factor(a, k, q, r):
    """That of a scalar plant and a filter with the gain k, in rational arithmetic.

    e+ = (1 - k) (a e - theta x - w) + k v and x+ = (a + theta) x + w; the moments of
    (x, e) for any theta, and theta^2 in them from three values.
    """
    a, k, q, r = map(F, (a, k, q, r))
    step = F(1, 10**9)

    def constant(t):
        p, f, g = a + t, (1 - k) * a, -(1 - k) * t
        X = q / (1 - p * p)
        Y = (p * g * X - (1 - k) * q) / (1 - p * f)
        more = g * g * X + 2 * f * g * Y + (1 - k) ** 2 * q + k * k * r
        return more / (1 - f * f)

    def white(s2):
        f = (1 - k) * a
        X = q / (1 - a * a - s2)
        return ((1 - k) ** 2 * (s2 * X + q) + k * k * r) / (1 - f * f)

    none = constant(F(0))
    two = (constant(step) + constant(-step)) / 2 - none
    return two / (white(step**2) - none)


@pytest.mark.parametrize("a", [0.5, 0.875, -0.75])
@pytest.mark.parametrize("R", [4.0, 0.25])
def test_the_factor_of_a_scalar_plant_in_rational_arithmetic(a, R):
    plant = lb.Plant([[a]], None, [[1]], dt=1.0, Q=[[1]], R=[[R]])
    observer = lb.kalman_filter(plant)
    exact = exact_factor(a, observer.V[0, 0], 1, R)
    found = white_noise_factor(observer, plant, [[1]])
    assert found == pytest.approx(float(exact), rel=1e-12)


def test_units_weights_and_the_size_of_the_parameter():
    observer, plant, A1, _ = known()["oscillator"]
    factor = white_noise_factor(observer, plant, A1)
    assert 25 < factor < 40  # both remember for long
    assert white_noise_factor(observer, plant, 1e6 * A1) == pytest.approx(factor)
    weighed = [
        white_noise_factor(observer, plant, A1, weight=np.diag(d))
        for d in ([1, 0], [0, 1], [1, 1])
    ]
    assert weighed[2] == pytest.approx(factor)
    assert min(weighed[:2]) < factor < max(weighed[:2])


def test_what_has_no_factor_is_refused():
    observer, plant, A1, _ = known()["oscillator"]
    with pytest.raises(lb.DesignError, match="does not move the error"):
        white_noise_factor(observer, plant, 0 * A1)
    with pytest.raises(ValueError, match="A1 must be 2 x 2"):
        white_noise_factor(observer, plant, [[1]])
    quiet = dataclasses.replace(plant, Q=None)
    with pytest.raises(lb.DesignError, match="needs both noise"):
        white_noise_factor(observer, quiet, A1)
    noisy = dataclasses.replace(plant, multiplicative=[(A1, 0 * plant.C)])
    with pytest.raises(lb.DesignError, match="without multiplicative noise"):
        white_noise_factor(observer, noisy, A1)
    cart = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]])
    with pytest.raises(lb.DesignError, match="the mode 1 on or outside.*lb.compare"):
        white_noise_factor(lb.kalman_filter(cart), cart, np.eye(2))
