"""The form of least work is the one that is counted, returned and exported."""

import dataclasses

import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis.step_cost import step_cost
from luenberger.compare.cheapest import Rounded, cheapest
from luenberger.compare.rounding import records, rounding
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


@pytest.fixture(scope="module")
def designed():
    return lb.fixed_order_filter(drive(), 3, L=K, starts=12)


def test_the_torque_in_a_shaft_takes_fewer_multiply_adds(table, designed):
    one = table.find("fixed-order filter", label="order 3 for k x")
    assert lb.export.multiply_adds(designed) == 23
    assert one.work == 17 and one.form in ("modal, companion blocks", "companion")
    assert one.form in one.note and one.sound


def test_what_is_counted_is_what_is_returned(table):
    for one in table.designs:
        assert (one.work, one.operations, one.bytes) == step_cost(one.observer)
        assert [row["form"] for row in table.rows() if row["label"] == one.label] == [
            one.form
        ]


def test_the_form_estimates_as_the_design_does(table, designed):
    one = table.find("fixed-order filter", label="order 3 for k x")
    assert one.covariance is None and one.disturbed
    for U in (0, [[4.0]]):
        left = lb.error_covariance(one.observer, drive().with_input(U))
        wanted = lb.error_covariance(designed, drive().with_input(U))
        assert np.allclose(left, wanted, rtol=1e-9)
    assert lb.optimality(one.observer, drive()).worst < 1e-6


def test_a_design_that_no_form_saves_stays_as_it_is():
    plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
                     Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])  # fmt: skip
    kalman = lb.compare(plant, methods="Kalman filter").designs[0]
    assert kalman.form == "as designed" and kalman.note == ""
    assert np.array_equal(kalman.observer.F, lb.kalman_filter(plant).F)


# -- rounding -----------------------------------------------------------------------


def littered(small):
    """A filter of one state and two outputs, and an entry that is almost nothing."""
    return lb.Observer([[0.5]], [[]], [[0.25, small]], [[1]], [[0.5, 0]],
                       T=[[1]], L=[[1]], dt=1.0)  # fmt: skip


def test_what_is_there_is_counted():
    assert (
        lb.export.multiply_adds(littered(1e-17))
        == lb.export.multiply_adds(littered(0.1))
        == 5
    )
    assert lb.export.multiply_adds(littered(0)) == 4


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


# -- digits -------------------------------------------------------------------------


def shaft():
    """Two speeds and a torque, a thousand samples a second; one speed is read."""
    A = [[-5, 5, -100], [1.25, -1.25, 25], [60, -60, 0]]
    given = dict(Q=np.diag([0.5, 4, 0.01]), R=[[1e-3]], P0=np.eye(3))
    return lb.Plant(A, [[50], [0], [0]], [[1, 0, 0]], **given).sampled(1e-3)


def in_c(observer, plant, dtype="float"):
    """Root mean square of what C in float leaves, over that of the estimates."""
    try:
        given = dict(dtype=dtype, steps=500, within=0)  # noise alone, as in records
        found = lb.export.rounding_error(observer, plant, **given)
    except RuntimeError:
        pytest.skip("no C compiler")
    run = lb.simulate(plant, observer, 499, seed=8)
    return found.rms / np.sqrt((run.w_hat**2).mean(axis=0))


def changed(observer, S):
    """The same observer, of the state S z."""
    back = np.linalg.inv(S)
    made = dict(F=S @ observer.F @ back, G=S @ observer.G, D=S @ observer.D)
    return dataclasses.replace(
        observer, **made, P=observer.P @ back, T=S @ observer.T, z0=S @ observer.z0
    )


def test_rounding_found_without_a_compiler_is_that_of_the_compiled_c():
    plant = shaft()
    for L in (None, [[0, 0, 1]]):
        design = lb.reduced_order_filter(plant, 1, L=L, horizon="steady")
        for form in (design, design.modal(), design.modal("companion")):
            found = rounding(form, records(form, plant)[:1], "float")
            seen = in_c(form, plant)
            assert (found < 3 * seen).all() and (seen < 3 * found).all()


def test_in_float_a_form_that_loses_more_than_a_digit_is_passed_over():
    plant = shaft()
    asked = dict(k=[0, 0, 1], methods="Leondes-Novak filter")
    found = lb.compare(plant, dtype="float", **asked).find(
        "Leondes-Novak filter", accurate=(0,), horizon="step"
    )
    design = lb.reduced_order_filter(plant, 1, L=[0, 0, 1])
    light, name, cost = cheapest(design, lambda one: True, "float")
    assert name == "modal, companion blocks" and cost.multiply_adds < found.work
    assert "A lighter form is passed over" in found.note and "float" in found.note
    own = in_c(design, plant)
    assert in_c(found.observer, plant) <= 10 * own < in_c(light, plant)
    double = lb.compare(plant, **asked).find(
        "Leondes-Novak filter", accurate=(0,), horizon="step"
    )
    assert double.work == cost.multiply_adds and "passed over" not in double.note


@pytest.mark.parametrize(
    "near, kept", [(0.1, True), (1e-2, True), (1e-4, False), (1e-8, False)]
)
def test_in_double_a_form_may_lose_what_leaves_nine_digits(near, kept):
    """Nearly dependent coordinates lose twice as many digits as they are near."""
    plant = shaft()
    design = lb.reduced_order_filter(plant, 1, L=[0, 0, 1])
    form = changed(design, np.array([[1, 1], [1, 1 + near]]))
    assert Rounded(design, plant, "double").keeps_digits(form) == kept
    assert not Rounded(design, plant, "float").keeps_digits(form)
    if near > 1e-6:  # below, what is left of the form grows in double as well
        exact, other = (lb.simulate(plant, one, 400, seed=1) for one in (design, form))
        lost = np.abs(other.w_hat - exact.w_hat).max() / np.abs(exact.w_hat).max()
        assert (lost < 1e-9) == kept


@pytest.mark.parametrize("noise", ["noise", "silence", "unknown"])
def test_every_plant_has_a_record_to_measure_on(noise):
    """One of the known input beside it; where Q and R vanish, white readings."""
    given = {
        "noise": dict(Q=np.eye(3), R=[[1.0]]),
        "silence": dict(Q=np.zeros((3, 3)), R=[[0.0]]),
        "unknown": dict(Q=None, R=None, P0=None),
    }[noise]
    plant = dataclasses.replace(shaft(), **given)
    design = lb.reduced_order_observer(plant, [0.5, 0.6])
    known = records(design, plant)
    assert len(known) == 2 and all(y.any() for y, _ in known)
    assert not known[0][1].any() and known[1][1].any()
    own = rounding(design, known, "float")
    assert (1e-9 < own).any() and (own < 1e-4).all()
    bad = changed(design, np.array([[1, 1], [1, 1 + 1e-4]]))
    assert not Rounded(design, plant, "float").keeps_digits(bad)


def test_orders_count_states_that_the_estimate_never_shows():
    """A design of one state is one of order 1, though x1 is read off the output."""
    exact = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0)
    found = lb.compare(exact, k=[1, 0], orders=[1])
    designs = [one for one in found.attempts if not one.refusal]
    assert {one.method for one in designs} == {
        "reduced-order observer",
        "deadbeat observer",
    }
    assert {one.order for one in designs} == {0}
    assert all("1 state that the estimate never shows" in one.note for one in designs)
    [functional] = lb.compare(
        exact, k=[1, 0], orders=[2], methods="functional observer"
    )
    assert functional.order == 2
