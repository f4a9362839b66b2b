"""Comparisons that recommend nothing: what is said, shown and weighed instead."""

import dataclasses
import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import luenberger as lb
from luenberger import plot, report
from luenberger.compare import transients
from luenberger.compare.settling import settling_time
from luenberger.show import number

A = [[1, 0.1, 0], [0, 1, 0.1], [0, -0.2, 0.9]]
PLANT = lb.Plant(A, [[0], [0], [1]], [[1, 0, 0]], dt=0.1)
NOISY = dataclasses.replace(PLANT, Q=0.01 * np.eye(3), R=[[0.1]], P0=np.eye(3))


@pytest.fixture(scope="module")
def table():
    return lb.compare(PLANT)


def random_plant(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    return lb.Plant(A, None, rng.normal(size=(1, n)), dt=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_nothing_is_recommended_without_noise(seed):
    """It was the deadbeat observer, with noise gains up to 177."""
    table = lb.compare(random_plant(seed), methods=["deadbeat observer"])
    assert table.chosen is None
    with pytest.raises(lb.DesignError, match=r"without Q and R.*lb\.fit_noise\(plant"):
        table.recommended()


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
        assert "`luenberger fit PLANT.json DATA.csv --out" in second
    else:
        assert "plant.sampled(0.1)" in second and "--sample 0.1" in second
    assert table.chosen is None is table.yardstick and table.ranked == []


def test_a_continuous_plant_with_noise_recommends_no_raw_sensors():
    plant = lb.Plant([[-1.0]], None, [[1.0]], Q=[[1.0]], R=[[1.0]])
    table = lb.compare(plant)
    assert [one.work for one in table.designs] == [0] and table.chosen is None
    sampled = lb.compare(plant.sampled(0.1))
    assert sampled.recommended().trace < 1 > sampled.recommended().work - 10


def test_noise_gain_is_weighed_against_settling(table):
    assert [one.method for one in table.designs] == [
        *["reduced-order observer"] * 3,
        "deadbeat observer",
    ]
    front = table.pareto()
    assert front == sorted(front, key=lambda one: one.settling)
    gains = [one.noise_gain for one in front]
    assert gains == sorted(gains, reverse=True) and len(front) >= 3
    assert front == table.pareto(by="settling") != table.pareto(by="order")
    words = " ".join(table.reasons())
    soon, calm = ([number(one.noise_gain, 4), number(one.settling, 4)]
                  for one in (front[0], front[-1]))  # fmt: skip
    for said in (
        f"The {front[0].title} settles the soonest, within {soon[1]} s; noise gain "
        f"{soon[0]}.",
        f"The {front[-1].title} has the least noise gain, {calm[0]}, and settles "
        f"within {calm[1]} s.",
    ):
        assert said in words
    header = table.table.header
    assert "settling (s)" in header and "error trace" not in header
    assert not table.table.marked and "<b>" not in table.table._repr_html_()


def test_noise_gain_of_k_x_is_counted_alike_for_every_method():
    k = np.array([[0, 0, 2.0]])
    table = lb.compare(PLANT, k=k)
    reduced = table.find("reduced-order observer")
    functional = table.find("functional observer")
    for one in (reduced, functional):
        F, D, P, V = (getattr(one.observer, name) for name in "FDPV")
        assert len(P) == 1
        left = _simulated_gain(F, D, P, V)
        assert one.noise_gain == pytest.approx(left, rel=1e-9)


def _simulated_gain(F, D, P, V):
    """Root of the variance of P z + V v, z+ = F z + D v, of unit white noise: a sum."""
    total, response = (V @ V.T).trace(), D
    for _ in range(3000):
        total += (P @ response @ response.T @ P.T).trace()
        response = F @ response
    return np.sqrt(total)


# -- settling -------------------------------------------------------------------------


def observer(F, dt):
    F = np.atleast_2d(F)
    r, none = len(F), np.zeros((1, 0))
    D, P = np.zeros((r, 1)), np.ones((1, r))
    return lb.Observer(F, D[:, :0], D, P, [[0]], T=P.T, L=[[1]], W=none, dt=dt)


@pytest.mark.parametrize(
    ("F", "dt", "seconds"),
    [
        ([[0.1]], 0.5, 1.0),
        ([[0.0999]], 0.5, 1.0),
        ([[0.1001]], 0.5, 1.5),
        ([[-0.1]], 0.5, 1.0),
        ([[0.5]], 2.0, 14.0),  # 0.5^7 = 0.8 %
        ([[0.0, 1], [0, 0]], 0.5, 1.0),
        ([[0.0, 1], [1e-17, 0]], 0.5, 1.0),  # rounding beside a pole of zero
        ([[0.0, 1, 0], [0, 0, 1], [0, 0, 0]], 0.5, 1.5),
        ([[0.0, 0], [0, 0]], 0.5, 0.5),
        ([[1.0]], 0.5, np.inf),
        ([[-2.0]], 0.0, np.log(100) / 2),
        ([[0.0, 1], [-1, 0]], 0.0, np.inf),
        (np.zeros((0, 0)), 0.5, 0.0),
        (np.zeros((0, 0)), 0.0, 0.0),
    ],
)
def test_settling_is_when_one_percent_is_left(F, dt, seconds):
    assert settling_time(observer(F, dt)) == pytest.approx(seconds, rel=1e-12)


# -- what is shown --------------------------------------------------------------------


def test_the_picture_is_of_noise_gain_and_settling_and_has_no_star(table):
    fig, ax = plt.subplots()
    plot.pareto(table, ax)
    labels = ax.get_legend_handles_labels()[1]
    assert "recommended" not in labels and "front" in labels
    assert ax.get_ylabel() == "noise gain" and "settling time (s)" in ax.get_xlabel()
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines}
    for row, one in zip(drawn["reduced-order observer"], table.designs):
        np.testing.assert_array_equal(row, [one.settling, one.noise_gain])
    assert ax.get_title().startswith("not shown: 1 above")  # the deadbeat observer
    plt.close(fig)


def test_poles_of_every_design_are_shown(table):
    fig, ax = plt.subplots()
    plot.poles(table, ax=ax)
    labels = ax.get_legend_handles_labels()[1]
    assert labels == ["plant", *(one.title for one in table.designs)]
    plt.close(fig)


def test_the_report_says_so_and_has_no_observer(table):
    files = report.files(table)
    assert "Nothing is recommended" in files["report.html"]
    assert "Recommended:" not in files["report.html"]
    assert "observer.json is not written" in files["report.html"]
    assert transients(table)[0] == {}
    assert [*files] == ["designs.csv", "report.html"] and ",no," in files["designs.csv"]
    json.dumps(table.rows(), allow_nan=False)
