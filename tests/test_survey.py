"""The survey behind the report: complete, open about refusals, sound in its advice."""

import itertools

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.show import Prose, Table, array
from luenberger.survey import choices, survey


def tracker(**changes):
    given = dict(
        Q=np.diag([0, 0, 1.0]),
        R=np.diag([0.25, 4.0]),
        dt=1.0,
        P0=np.eye(3),
        state_names=["position", "velocity", "acceleration"],
        output_names=["radar", "doppler"],
    )
    A = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]]
    C = [[1, 0, 0], [0, 1, 0]]
    return lb.Plant(A, None, C, **(given | changes))


@pytest.fixture(scope="module")
def table():
    return survey(tracker())


def test_every_subset_is_tried_up_to_four_outputs():
    assert len(choices(4)) == 16 and choices(0) == [()]
    assert choices(5) == [tuple(range(m1)) for m1 in range(6)]


def test_every_attempt_is_listed_with_both_gains(table):
    listed = {(one.accurate, one.horizon) for one in table.attempts}
    reduced = itertools.product([(0,), (1,), (0, 1)], ["step", "steady"])
    assert listed == {((), "step"), *reduced} and not table.refused


def test_numbers_are_those_of_the_library(table):
    plant = tracker()
    one = table.find([0], "steady")
    observer = lb.reduced_order_filter(plant, [0], horizon="steady")
    np.testing.assert_array_equal(one.observer.V, observer.V)
    assert one.trace == np.trace(lb.error_covariance(observer, plant))
    assert one.order == observer.order == 2
    assert one.work == lb.multiply_adds(observer)


def test_kalman_filter_is_the_yardstick_and_nothing_beats_it(table):
    assert table.yardstick.accurate == () and table.excess(table.yardstick) == 0
    assert all(table.excess(one) >= 0 for one in table.designs)


def test_best_constant_gain_is_never_worse(table):
    for accurate in [(0,), (1,), (0, 1)]:
        step, steady = (table.find(accurate, h) for h in ("step", "steady"))
        assert steady.trace <= step.trace * (1 + 1e-9)


def test_front_falls_with_order_and_is_not_beaten(table):
    front = table.pareto()
    assert [one.order for one in front] == [1, 2, 3]
    for one in front:
        rivals = [r for r in table.designs if r.order <= one.order]
        assert one.trace <= min(r.trace for r in rivals) * (1 + 1e-9)


@pytest.mark.parametrize(("tolerance", "order"), [(0, 3), (0.05, 2), (10, 1)])
def test_recommendation_follows_its_rule(table, tolerance, order):
    chosen = table.recommended(tolerance)
    assert chosen.order == order and table.excess(chosen) <= tolerance
    lighter = [one for one in table.designs if one.work < chosen.work]
    assert all(table.excess(one) > tolerance for one in lighter)


def test_refused_design_is_listed_with_its_reason():
    """One output twice: both cannot be taken as accurate, the rest goes on."""
    found = survey(_with_outputs([[1, 0, 0], [1, 0, 0]]))
    both = [one for one in found.refused if one.accurate == (0, 1)]
    assert len(both) == 2 and all("radar" in one.refusal for one in both)
    assert len(found.designs) == 5
    assert "radar" in repr(report.refusals(found))
    assert repr(report.designs(found)).count("refused") == 2


def _with_outputs(C):
    plant = tracker()
    names = dict(state_names=plant.state_names, output_names=plant.output_names)
    return lb.Plant(plant.A, None, C, Q=plant.Q, R=plant.R, dt=1.0, **names)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (dict(R=None), "no R"),
        (dict(Q=None), "no Q"),
        (dict(dt=0.0), "discrete time"),
    ],
)
def test_nothing_to_survey_is_an_error(changes, reason):
    with pytest.raises(lb.DesignError, match=f"no exact filter of any order.*{reason}"):
        survey(tracker(**changes))


def test_perfect_knowledge_has_no_infinite_percentages():
    """A zero error trace: nothing can be compared with it, and nothing divides."""
    plant = lb.Plant([[0.5]], None, [[1.0]], Q=[[1.0]], R=[[0.0]], dt=1.0)
    found = survey(plant)
    assert found.yardstick.trace == pytest.approx(0, abs=1e-15)
    assert found.recommended().order == 0
    for show in (report.designs, report.recommendation, report.state_errors):
        assert "nan" not in repr(show(found))


def test_recommendation_in_words(table):
    text = repr(report.recommendation(table))
    chosen, best = table.recommended(), table.yardstick
    assert f"radar taken as accurate, order {chosen.order}" in text
    assert "at most 5 % above" in text
    assert f"{chosen.work} multiply-adds a step instead of {best.work}" in text
    assert "The state that loses most is position" in text


def test_transients_begin_at_P0_and_end_in_the_steady_state(table):
    curves, remarks = report.transients(table)
    assert len(curves) == 3 and "steps from P0" in repr(remarks)
    for covariance in curves.values():
        np.testing.assert_array_equal(covariance[0], tracker().P0)
    constant = curves["recommended, constant gain"]
    steady = table.recommended().covariance
    np.testing.assert_allclose(constant[-1], steady, rtol=0.02)
    optimal = curves["Kalman filter"]
    assert (np.trace(constant - optimal, axis1=1, axis2=2) > -1e-12).all()


def test_transients_without_P0_say_so():
    curves, remarks = report.transients(survey(tracker(P0=None)))
    assert curves == {} and "no P0" in repr(remarks)


def test_matrices_carry_names_and_leave_out_zeros(table):
    chosen = table.recommended()
    tables = report.matrices(chosen, tracker())
    assert [t.header[0][0] for t in tables] == ["F", "D", "P", "V"]  # no input: no G, W
    assert tables[-1].header[1:] == ["radar", "doppler"]
    assert [row[0] for row in tables[-1].rows] == list(tracker().state_names)


def test_names_of_a_user_are_text_and_not_markup():
    hostile = "<img src=//evil.example/x onerror=alert(1)> $x$ *a*"
    for shown in (Table([hostile], [[hostile]]), Prose(hostile, heading=hostile)):
        assert "<img" not in shown._repr_html_() and "&lt;img" in shown._repr_html_()


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ([[1, 1e-17], [-0.0, 2 / 3]], "[1         0]\n[0  0.666667]"),
        ([1e-20, 3e-20], "[1e-20  3e-20]"),  # small, but not beside anything larger
        ([1 + 1e-17j, 0.5j], "[1  0+0.5j]"),
        ([np.nan, np.inf], "[nan  inf]"),
        (np.zeros((0, 2)), "empty, 0 x 2"),
    ],
)
def test_printing_shows_no_noise(value, text):
    assert array(value) == text


def test_rounding_is_not_work(table):
    """The best minimal observer takes no acceleration from the position: 0, not 1e-14.

    What is left: the next z and the acceleration, each from z and from the doppler.
    """
    best = table.find([0, 1], "steady").observer
    np.testing.assert_allclose(best.V[2, 0], 0, atol=1e-10)
    assert lb.multiply_adds(best) == 4
