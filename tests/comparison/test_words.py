"""Why a design is recommended or none is: every claim holds of what is in the table."""

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest

import luenberger as lb
from luenberger import plot, report
from luenberger.comparison import METHODS
from luenberger.comparison.transients import from_start, transients
from luenberger.show import number

KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL = METHODS


def tracker(**changes):
    A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], np.eye(2, 3)
    given = dict(Q=np.diag([0, 0, 1.0]), R=np.diag([0.25, 4.0]), P0=np.eye(3), dt=1.0)
    names = dict(state_names=["position", "velocity", "acceleration"],
                 output_names=["radar", "doppler"])  # fmt: skip
    return lb.Plant(A, None, C, **given | names | changes)


def stable(B=None, **changes):
    A = [[0.8, 0.2, 0], [0, 0.6, 0.3], [0.1, 0, 0.5]]
    given = dict(dt=1.0, Q=np.diag([1.0, 0.5, 0.2]), R=[[0.1]], P0=np.eye(3))
    return lb.Plant(A, B, [[1, 0, 0]], **given | changes)


@pytest.fixture(scope="module")
def table():
    return lb.compare(tracker())


def test_recommendation_in_words(table):
    chosen, best = table.recommended(), table.yardstick
    text = " ".join(report.page(table).split())
    title = "Leondes-Novak filter, radar taken as accurate, best constant gain, order 2"
    assert f"Recommended: {title}." in text
    assert "more than 10 % above that of the Kalman filter" in text
    assert f"{chosen.work} multiply-adds a step instead of {best.work}" in text
    assert "the standard deviation of position is 8.34 % above" in text
    assert "order 1: the standard deviation of velocity is 148.13 % above" in text
    assert "more than 1000 % above" in table.reasons(10)[0]
    assert "It is the most accurate design of all" in table.reasons(0)[1]


def test_reasons_say_the_budget_what_is_needed_and_what_more_buys(table):
    said = " ".join(table.within(multiply_adds=12, bytes=60).reasons())
    budget = (
        "the most accurate design in the table within the budget of 12 multiply-adds"
    )
    assert budget in said
    assert "It needs 4 multiply-adds, 1 observer state and 32 bytes." in said
    assert "in the table beyond the budget is the Leondes-Novak filter, radar" in said
    assert "for 2 multiply-adds and 52 bytes more, the standard deviation of" in said
    whole = " ".join(table.within(multiply_adds=24).reasons())
    assert "most accurate design of all. More would buy nothing" in whole
    last = " ".join(table.within(states=2).reasons())
    assert "for 1 observer state more, it is the most accurate of all." in last


def test_what_is_left_out_is_named():
    n = 6
    A = np.diag(np.linspace(0.1, 0.9, n)) + np.diag(np.full(n - 1, 0.8), 1)
    plant = lb.Plant(A, None, np.eye(5, n), dt=1.0, Q=np.eye(n), R=np.eye(5))
    said = " ".join(lb.compare(plant).reasons())
    assert (
        "Not tried, as it takes a while: Leondes-Novak filters that take other" in said
    )
    assert "accurate and fixed-order filters with V = 0. One of them may be" in said
    assert "Not tried" not in " ".join(lb.compare(stable()).reasons())
    mine = lb.candidates(plant, methods=KALMAN)
    assert "Not tried" not in " ".join(lb.compare(plant, mine).reasons())


# -- the known input -------------------------------------------------------------------


def test_a_known_input_hides_errors_until_something_is_said_of_it():
    plant = stable(B=[[1], [0], [0]])
    some = lb.candidates(plant, methods=[KALMAN, FIXED], orders=[1, 3])
    quiet, driven = (lb.compare(one, some) for one in (stable(), plant))
    one = driven.find(FIXED, order=1)
    assert one.disturbed and one.error is None and "u = 0" in one.note
    assert one not in driven.eligible and one not in driven.pareto()
    assert quiet.recommended() is quiet.find(FIXED, order=1)
    assert driven.recommended(tolerance=10).exact
    words = "Not weighed: 2 designs whose estimate the known input disturbs"
    assert words in " ".join(driven.reasons())
    assert "Not weighed" not in " ".join(quiet.reasons())
    alone = lb.compare(plant, lb.candidates(plant, methods=FIXED, orders=1))
    assert alone.yardstick is None and alone.chosen is None
    assert "Say what the known input is like" in " ".join(alone.reasons())


@pytest.mark.parametrize(
    ("U", "said"),
    [
        ([[4.0]], "white noise, of the standard deviation u1 = 2."),
        (
            [3.0],
            "constant for ever from before the start, at u1 = 3: one that switches",
        ),
        (0, "a known input that is always zero."),
        (
            lb.Plant([[0.9]], None, [[1]], dt=1.0, Q=[[2.0]], R=[[0.0]]),
            "a known input that a model of 1 state drives.",
        ),
    ],
    ids=["white", "level", "zero", "model"],
)
def test_errors_count_what_is_said_of_the_input(U, said):
    plant = stable(B=[[1], [0], [0]]).with_input(U)
    some = lb.candidates(plant, methods=[KALMAN, FIXED], orders=[1, 3])
    told = lb.compare(plant, some)
    one = told.find(FIXED, order=1)
    assert one.disturbed and one.note == "" and one in told.eligible
    wanted = lb.error_covariance(one.observer, plant).trace()
    assert one.trace == pytest.approx(wanted, rel=1e-9)
    assert said in " ".join(told.reasons())


def test_an_exact_fixed_order_filter_is_free_of_known_inputs():
    """Two outputs with one noise: the Kalman filter needs one state, and loses none."""
    plant = lb.Plant([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0], [1, 1]],
                     Q=np.eye(2), R=np.ones((2, 2)), dt=1.0)  # fmt: skip
    table = lb.compare(plant)
    one, held = (table.find(FIXED, label=f"order 1{held}") for held in ("", ", V = 0"))
    assert one.exact and not one.disturbed and one.note == ""
    assert held.disturbed and "u = 0" in held.note
    assert one in table.eligible and held not in table.eligible
    said = " ".join(table.reasons())
    assert "u = 0" not in said and "not exact" not in said


# -- nothing is recommended ------------------------------------------------------------

A = [[1, 0.1, 0], [0, 1, 0.1], [0, -0.2, 0.9]]
BARE = lb.Plant(A, [[0], [0], [1]], [[1, 0, 0]], dt=0.1)
NOISY = dataclasses.replace(BARE, Q=0.01 * np.eye(3), R=[[0.1]], P0=np.eye(3))


@pytest.fixture(scope="module")
def bare():
    return lb.compare(BARE)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (dict(Q=None), "without Q, the"),
        (dict(R=None), "without R, the"),
        (dict(Q=None, R=None), "without Q and R, the"),
        (dict(dt=0.0), "in continuous time"),
    ],
)
def test_reasons_say_what_is_missing_and_what_gives_it(changes, said):
    table = lb.compare(dataclasses.replace(NOISY, **changes))
    first, second, *_ = table.reasons()
    assert first.startswith("Nothing is recommended") and said in first
    if table.plant.dt:
        assert "lb.fit_noise(plant, y)" in second
        assert "`python -m luenberger fit PLANT.json DATA.csv --out" in second
        with pytest.raises(lb.DesignError, match=r"without .*lb\.fit_noise\(plant"):
            table.recommended()
    else:
        assert "plant.sampled(0.1)" in second and "--sample 0.1" in second
    assert table.chosen is None is table.yardstick and table.ranked == []


def test_noise_gain_is_weighed_against_settling(bare):
    front = bare.pareto()
    assert front == sorted(front, key=lambda one: one.settling)
    gains = [one.noise_gain for one in front]
    assert gains == sorted(gains, reverse=True) and len(front) >= 3
    assert front == bare.pareto(by="settling") != bare.pareto(by="order")
    words = " ".join(bare.reasons())
    soon, calm = ([number(one.noise_gain, 4), number(one.settling, 4)]
                  for one in (front[0], front[-1]))  # fmt: skip
    assert (
        f"The {front[0].title} settles the soonest, within {soon[1]} s; noise gain "
        f"{soon[0]}."
    ) in words
    assert (
        f"The {front[-1].title} has the least noise gain, {calm[0]}, and settles "
        f"within {calm[1]} s."
    ) in words
    assert "settling (s)" in bare.table.header
    assert not bare.table.marked and "<b>" not in bare.table._repr_html_()


def test_the_report_says_so_and_has_no_observer(bare):
    files = report.files(bare)
    assert "Nothing is recommended" in files["report.html"]
    assert "Recommended:" not in files["report.html"]
    assert "observer.json is not written" in files["report.html"]
    assert transients(bare)[0] == {}
    assert [*files] == ["designs.csv", "report.html"] and ",no," in files["designs.csv"]


def test_the_picture_is_of_noise_gain_and_settling_and_has_no_star(bare):
    fig, ax = plt.subplots()
    plot.pareto(bare, ax)
    labels = ax.get_legend_handles_labels()[1]
    assert "recommended" not in labels and "front" in labels
    assert ax.get_ylabel() == "noise gain" and "settling time (s)" in ax.get_xlabel()
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines}
    for row, one in zip(drawn[REDUCED], bare.designs):
        np.testing.assert_array_equal(row, [one.settling, one.noise_gain])
    assert ax.get_title().startswith("not shown: 1 above")  # the deadbeat observer
    plt.close(fig)


# -- from the start on -----------------------------------------------------------------


def test_transients_begin_at_P0_and_end_at_the_steady_errors(table):
    curves, remarks = transients(table)
    chosen = table.recommended()
    assert [*curves] == ["Kalman filter", "recommended, gains of each instant",
                         "recommended, constant gain"]  # fmt: skip
    for one, last in zip(curves.values(), (table.yardstick, chosen, chosen)):
        np.testing.assert_allclose(one[0], np.eye(3))
        np.testing.assert_allclose(one[-1], last.covariance, rtol=0.1, atol=0.1)
    assert remarks[0].endswith("steps from P0.")
    smooth = lb.compare(stable())
    shown = from_start({"one": smooth.find(FIXED).observer}, stable())
    np.testing.assert_allclose(shown["one"][-1], smooth.find(FIXED).covariance, 0.05)


@pytest.mark.parametrize(
    ("changes", "words"), [(dict(P0=None), "no P0"), (dict(Q=None), "Without noise")]
)
def test_transients_that_are_not_there_say_so(changes, words):
    curves, remarks = transients(lb.compare(tracker(**changes)))
    assert curves == {} and words in remarks[0]
    small = lb.compare(tracker()).within(multiply_adds=0)
    assert "No design is within the budget" in transients(small)[1][0]
