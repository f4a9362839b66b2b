"""Scales of states and outputs: the unit of time plays no part in them."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.numeric import independent_rows


def chain(units):
    """A chain of four states in unlike units, seen at its end."""
    A = np.eye(4, k=1) + np.diag([0.1, 0.2, 0.3, 0.4])
    return A / units[:, None] * units, np.eye(1, 4) * units


@pytest.mark.parametrize("rate", [2.0**-12, 2.0**10])
def test_another_unit_of_time_leaves_the_scales(rate):
    A, C = chain(np.array([1.0, 1e3, 1e-2, 1e6]))
    np.testing.assert_array_equal(
        independent_rows._seen(rate * A, C), independent_rows._seen(A, C)
    )
    plant, faster = (lb.Plant(X, None, C) for X in (A, rate * A))
    for one, two in zip(
        independent_rows.scaled(plant.A, plant.C)[:2],
        independent_rows.scaled(faster.A, faster.C)[:2],
    ):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("units", [[1, 1, 1, 1], [1, 2.0**20, 2.0**-9, 2.0**30]])
def test_scaled_states_are_the_same_in_all_units(units):
    """x / d does not depend on the units of x, but for a factor of two for each."""
    A, C = chain(np.array(units, float))
    found = independent_rows._seen(A, C) * units
    plain = independent_rows._seen(*chain(np.ones(4)))
    assert np.abs(np.log2(found / plain)).max() <= 1


@pytest.mark.parametrize("weak, other", [(2e-4, False), (1e-5, True), (1e-20, True)])
def test_other_units_are_asked_for_where_a_stair_is_small(weak, other):
    """Just outside the limit, just inside, and so small that it is not seen at all."""
    d = independent_rows.scaled(np.array([[0.5, weak], [0, 0.25]]), np.eye(2)[:1])[0]
    assert d[0] == 1 and (d[1] > 1) == other
