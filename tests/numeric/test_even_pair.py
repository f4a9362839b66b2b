"""Units in which a pair is judged: the user's units and unit of time play no part."""

import numpy as np
import pytest

from luenberger.numeric.balance import balanced
from luenberger.numeric.even_pair import even_pair
from luenberger.numeric.independent_rows import default_tol, in_even_units


def drawn(rng, n, p):
    """Small integers, many of them zero, and what hangs on their cycles."""
    A = rng.integers(-3, 4, (n, n)) / 4 * (rng.random((n, n)) < 0.5)
    A[:, rng.integers(n)] = 0
    return A, rng.integers(-2, 3, (p, n)) * (rng.random((p, n)) < 0.7) / 1.0


@pytest.mark.parametrize("dt", [0.0, 1.0])
def test_a_pair_is_the_same_in_all_units(dt):
    """Every bit of A and C; the time unit of a discrete plant is its sample."""
    for seed in range(100):
        rng = np.random.default_rng([3, seed])
        A, C = drawn(rng, *rng.integers(2, 7, 2))
        x, y = (2.0 ** rng.integers(-40, 41, size) for size in C.shape[::-1])
        rate = 1.0 if dt else 2.0 ** rng.integers(-40, 41)
        one = even_pair(A, C, dt)
        other = even_pair(A * rate * x / x[:, None], C * x / y[:, None], dt)
        for name in ("A", "C"):
            found, wanted = getattr(other, name), getattr(one, name)
            np.testing.assert_array_equal(found, wanted, (seed, name))


def test_what_is_moved_and_moves_nothing_has_no_say_in_units():
    """They had drifted to 1e-44, as far as the sweeps went."""
    A = np.array([[0, 0.25, 0.25], [0, 0.75, 0.25], [0, -0.25, 0.25]])
    states, _ = balanced(A, np.array([[1.0, 1, 0]]), 0, 0)
    assert states.max() <= 4 * states.min()
    states, _ = balanced(A.T, np.array([[0.0, 1, 0]]), 0, 0)  # and what nothing moves
    assert states.max() <= 4 * states.min()


def test_a_fast_plant_s_chain_is_measured_by_its_rates():
    pair = even_pair(2.0**40 * np.array([[-1, 2.0**-40], [0, -1]]), np.eye(2)[:1])
    assert pair.rate == 2.0**40 and (pair.A == [[-1, 1], [0, -1]]).all()


def test_a_chain_of_integrators_has_no_rate_but_that_it_is_asked_for():
    A = np.eye(3, k=1) * 2.0**30
    for fastest, rate in ((0.0, 1.0), (5.0, 4.0)):
        pair = even_pair(A, np.eye(3)[:1], fastest=fastest)
        assert pair.rate == rate and (pair.A == np.eye(3, k=1)).all()


@pytest.mark.parametrize("weak, other", [(5.1e-5, False), (3e-5, True), (1e-20, True)])
def test_other_units_are_asked_for_where_a_stair_is_small(weak, other):
    """In a loop: just outside the limit, just inside, and not seen at all."""
    A = np.array([[0.5, weak], [weak, 0.25]])
    pair, found = in_even_units(A, np.eye(2)[:1], 1.0, default_tol(2))
    assert pair.states[0] == 1 and (pair.states[1] > 1) == other
    assert sum(map(len, found)) == 2
