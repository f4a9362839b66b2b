"""The form of least work is the one that is counted, returned and exported."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis.step_cost import step_cost
from luenberger.compare.cheapest import cheapest
from luenberger.period import hold

K = [[0, 0, 1, 0]]  # the torque in the shaft


def drive():
    """A motor on an elastic shaft: current, speed, torque, speed of the load."""
    A = [[-500, -25, 0, 0], [500, -1, -1e4, 0], [0, 20, 0, -20], [0, 0, 2000, -0.4]]
    plant = lb.Plant(A, [[500], [0], [0], [0]], np.eye(2, 4))
    return lb.Plant(
        *hold(plant.A, plant.B, 1e-3),
        plant.C,
        dt=1e-3,
        Q=np.diag([1e-3, 1e-1, 1e-5, 1]),
        R=np.diag([1e-3, 1e-2]),
    )


@pytest.fixture(scope="module")
def table():
    return lb.compare(drive(), k=K, methods=["fixed-order filter"], orders=[3])


def test_the_torque_in_a_shaft_takes_fewer_multiply_adds(table):
    one = table.find("fixed-order filter", label="order 3 for k x")
    designed = lb.fixed_order_filter(drive(), 3, L=K, starts=12)
    assert lb.multiply_adds(designed) == 23
    assert one.work == 17 and one.form in ("modal, companion blocks", "companion")
    assert one.form in one.note and one.sound


def test_what_is_counted_is_what_is_returned(table):
    for one in table.designs:
        assert (one.work, one.operations, one.bytes) == step_cost(one.observer)
        assert [row["form"] for row in table.rows() if row["label"] == one.label] == [
            one.form
        ]


def test_the_form_estimates_as_the_design_does(table):
    one = table.find("fixed-order filter", label="order 3 for k x")
    assert one.covariance is None and one.disturbed
    designed = lb.fixed_order_filter(drive(), 3, L=K, starts=12)
    for U in (0, [[4.0]]):
        left = lb.error_covariance(one.observer, drive(), U=U)
        wanted = lb.error_covariance(designed, drive(), U=U)
        assert np.allclose(left, wanted, rtol=1e-9)
    assert lb.optimality(one.observer, drive()).worst < 1e-6


def test_a_design_that_no_form_saves_stays_as_it_is():
    plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
                     Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])  # fmt: skip
    kalman = lb.compare(plant).find("Kalman filter")
    assert kalman.form == "as designed" and kalman.note == ""
    assert np.array_equal(kalman.observer.F, lb.kalman_filter(plant).F)


# -- rounding -----------------------------------------------------------------------


def littered(small):
    """A filter of one state and two outputs, and an entry that is almost nothing."""
    return lb.Observer([[0.5]], [[]], [[0.25, small]], [[1]], [[0.5, 0]],
                       T=[[1]], L=[[1]], dt=1.0)  # fmt: skip


def test_what_is_there_is_counted():
    assert lb.multiply_adds(littered(1e-17)) == lb.multiply_adds(littered(0.1)) == 5
    assert lb.multiply_adds(littered(0)) == 4


def test_rounding_is_dropped_only_where_that_is_sound():
    given = littered(1e-17)
    kept, name, cost = cheapest(given, lambda one: False)
    assert kept is given and cost.multiply_adds == 5
    clean, name, cost = cheapest(given, lambda one: True)
    assert (name, cost) == ("as designed", step_cost(clean))
    assert cost.multiply_adds == 4 and clean.D[0, 1] == 0


def test_less_is_dropped_where_more_would_not_be_sound():
    given = lb.Observer([[0.5]], [[]], [[0.25, 1e-12, 1e-17]], [[1]], [[0.5, 0, 0]],
                        T=[[1]], L=[[1]], dt=1.0)  # fmt: skip
    clean, _, cost = cheapest(given, lambda one: one.D[0, 1] != 0)
    assert clean.D.tolist() == [[0.25, 1e-12, 0]] and cost.multiply_adds == 5
