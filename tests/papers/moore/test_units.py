"""Units play no part in an observer of k x: the same in any, and as exactly judged."""

from fractions import Fraction

import numpy as np
import pytest

import luenberger as lb


def drawn(rng):
    """A plant of small integers with what makes rounding decide, and a functional."""
    n, p = rng.integers(2, 6), rng.integers(1, 3)
    A, half = rng.integers(-3, 4, (n, n)), n // 2
    match rng.integers(4):
        case 0:
            A = np.diag(A.diagonal())
        case 1:
            A = np.triu(A)
        case 2:  # two parts that only meet in an output
            A[:half, half:] = A[half:, :half] = 0
        case 3:
            A[rng.random((n, n)) < 0.5] = 0
    C, k = rng.integers(-2, 3, (p, n)), rng.integers(-2, 3, n)
    C[rng.random((p, n)) < 0.4], k[rng.random(n) < 0.3] = 0, 0
    return A, C, k, float(rng.integers(2))


def designed(A, C, k, dt):
    """The observer, or None where there is none."""
    try:
        return lb.functional_observer(lb.Plant(A, None, C, dt=dt), k)
    except lb.DesignError:
        return None


def test_an_observer_of_k_x_is_the_same_in_any_units():
    """The least order, the poles and L, up to 2^40; and that of exact rationals."""
    found = 0
    for seed in range(80):
        rng = np.random.default_rng([7, seed])
        A, C, k, dt = drawn(rng)
        x, y = (2.0 ** rng.integers(-40, 41, size) for size in C.shape[::-1])
        exact = designed(*(np.vectorize(Fraction, [object])(X) for X in (A, C, k)), dt)
        one = designed(A * 1.0, C * 1.0, k * 1.0, dt)
        other = designed(A / x[:, None] * x, C / y[:, None] * x, k * x, dt)
        order = None if exact is None else exact.order
        for float_one in (one, other):
            assert (None if float_one is None else float_one.order) == order, seed
        if one is not None:
            found += 1
            np.testing.assert_allclose(other.poles, one.poles, rtol=1e-9, err_msg=seed)
            assert (other.L == k * x).all()
    assert 32 < found < 70


@pytest.mark.parametrize("units", [(1.0, 1.0), (2.0**-20, 2.0**30)])
def test_an_integrator_that_no_output_shows_is_not_dropped(units):
    plant = lb.Plant(np.diag([0.0, -1.0]), None, [[0, units[1]]])
    with pytest.raises(lb.DesignError, match=r"mode\(s\) 0 do not decay"):
        lb.functional_observer(plant, units)
