"""Errors of states in unlike units: each beside its own, or in a given scale."""

import dataclasses

import numpy as np
import pytest

import luenberger as lb
from luenberger.compare.judge import Judge

A = np.array([[0.9, 0.3, 0], [0, 0.8, 0.2], [0.05, 0, 0.7]])
C = np.array([[1.0, 0, 0], [0, 0, 1.0]])


def oven(units=(1.0, 1.0, 1.0), R=(0.1, 0.05)):
    """Three states, the last one a small current; `units` are those of the states."""
    S = np.asarray(units)
    Q = np.diag([1.0, 0.5, 0.01]) * np.outer(S, S)
    names = ["temperature (K)", "speed (rad/s)", "current (A)"]
    moved = A * S[:, None] / S
    return lb.Plant(moved, None, C / S, dt=1.0, Q=Q, R=np.diag(R), state_names=names)


@pytest.fixture(scope="module")
def table():
    return lb.compare(oven())


def test_ratios_by_hand(table):
    best = np.sqrt(table.yardstick.variances)
    for one in table.ranked:
        by_hand = np.sqrt(one.variances) / best
        np.testing.assert_allclose(one.ratios, by_hand, rtol=1e-12)
        assert one.error == one.worst_ratio == pytest.approx(by_hand.max())
        assert one.mean_ratio == pytest.approx(by_hand.mean())
    assert (table.yardstick.ratios == 1).all()


def test_no_units_of_the_states_decide(table):
    units = 2.0 ** np.array([40, -40, 10])
    other = lb.compare(oven(units), methods=["Kalman filter", "deadbeat observer"])
    for one in other.designs:
        same = table.find(one.method)
        np.testing.assert_allclose(one.ratios, same.ratios, rtol=1e-9)
    scale = np.array([1, 1, 0.01])
    mine, theirs = (
        lb.compare(oven(u), scale=scale * u, methods="Leondes-Novak filter").ranked
        for u in (np.ones(3), units)
    )
    for one, same in zip(mine, theirs, strict=True):
        assert one.error == pytest.approx(same.error, rel=1e-6), one.name


def test_the_trace_would_take_a_design_that_spoils_the_current(table):
    within = [o for o in table.ranked if o.trace <= 1.05 * table.yardstick.trace]
    least = min(within, key=lambda one: one.work)
    assert least.ratios[2] > 1.7  # in amperes the sensor's own error
    chosen = table.recommended()
    assert chosen.worst_ratio <= 1.1 and chosen.work > least.work
    said = " ".join(table.reasons())
    assert "in which no state has a standard deviation more than 10 % above" in said
    assert "The trace adds variances of all units, so it does not decide." in said
    assert table.table.header[3:6] == ["worst state", "mean state", "error trace"]


def test_a_scale_weighs_states_and_designs():
    scale = [1.0, 1.0, 0.01]
    quick = ["Kalman filter", "Leondes-Novak filter", "deadbeat observer"]
    plain, scaled = (
        lb.compare(oven(), scale=one, methods=quick) for one in (1.0, scale)
    )
    fixed, best = (
        lb.compare(oven(), scale=one, methods="fixed-order filter", orders=[1])
        for one in (1.0, scale)
    )
    for one in plain.ranked:
        assert one.error == pytest.approx(np.sqrt(one.trace / 3), rel=1e-12)
    for one in (*plain.ranked, *fixed.ranked):
        table = best if one.method == "fixed-order filter" else scaled
        same = table.find(one.method, label=one.label)
        assert same.error == pytest.approx(
            np.sqrt(np.mean(same.variances / np.square(scale))), rel=1e-12
        )
        if one.method in ("fixed-order filter", "Leondes-Novak filter"):
            mine = np.sqrt(np.mean(one.variances / np.square(scale)))
            if one.horizon != "step":  # that looks one step ahead
                assert same.error <= mine * (1 + 1e-9), one.name
    (one, *_), (same, *_) = fixed.designs, best.designs
    assert same.sound and same.error < 0.97 * np.sqrt(
        np.mean(one.variances / np.square(scale))
    )
    assert "error in the given scale is at most 10 %" in scaled.reasons()[0]
    assert scaled.table.header[3:5] == ["error in scale", "above the best"]


@pytest.mark.parametrize(
    ("scale", "said"),
    [([1, 2], r"shape \(3,\)"), ([1, 0, 1], "all are positive"), (-1, "positive"),
     ([1, np.nan, 1], "not finite")],
)  # fmt: skip
def test_a_scale_that_makes_no_sense(scale, said):
    with pytest.raises(ValueError, match=f"scale .*{said}"):
        lb.compare(oven(), scale=scale)


def test_a_perfect_sensor_leaves_nothing_to_divide_by():
    few = ["Kalman filter", "Leondes-Novak filter"]
    found = lb.compare(oven(R=(0.0, 0.05)), methods=few)
    exact = found.find("Leondes-Novak filter", accurate=(0,), horizon="steady")
    assert exact.ratios[0] == 1 == found.yardstick.ratios[0]
    assert exact.error < 1.0001
    noisy = dataclasses.replace(exact, covariance=exact.covariance + 1e-6 * np.eye(3))
    assert noisy.ratios[0] == np.inf == noisy.error
    rounding = dataclasses.replace(exact, covariance=exact.covariance + 1e-18)
    assert rounding.ratios[0] == 1


def test_without_the_kalman_filter_in_the_table_it_is_still_what_one_is_beside():
    some = lb.compare(oven(), methods=["deadbeat observer"])
    (one,) = some.designs
    best = lb.error_covariance(lb.kalman_filter(oven()), oven()).diagonal()
    np.testing.assert_allclose(one.ratios, np.sqrt(one.variances / best), rtol=1e-9)
    assert some.excess(one) == 0 and some.recommended() is one
    assert "beside that of the Kalman filter, is at most" in some.reasons()[0]


def test_equal_worst_states_leave_it_to_the_mean(table):
    one = table.yardstick
    rest = np.array([1.0, 1.2, 1.0])[:, None] * one.covariance
    worse = dataclasses.replace(one, covariance=1.2 * one.covariance)
    better = dataclasses.replace(one, covariance=rest)
    both = dataclasses.replace(table, attempts=(worse, better))
    assert worse.error == pytest.approx(better.error, rel=1e-12)
    assert both.pareto() == [better]


def test_rows_of_k_are_judged_each_by_itself():
    k = np.array([[1.0, -1, 0], [0, 0, 1000]])
    found = lb.compare(oven(), k=k, methods=["Kalman filter", "deadbeat observer"])
    one = found.find("deadbeat observer")
    left, best = (o.covariance.diagonal() for o in (one, found.yardstick))
    np.testing.assert_allclose(one.ratios, np.sqrt(left / best))
    assert "rows of k x" in " ".join(found.reasons(100))


def test_judge_counts_what_is_below_its_floor_as_zero():
    judge = Judge(np.array([0.0, 4.0]), np.array([1e-14, 1e-14]))
    assert judge.error(np.array([1e-15, 9.0])) == 1.5
    assert judge.error(np.array([1e-13, 9.0])) == np.inf
