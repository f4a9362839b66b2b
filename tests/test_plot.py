"""Figures: each function draws on the Axes it is given and returns it."""

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

import luenberger as lb  # noqa: E402
from luenberger import plot  # noqa: E402
from luenberger.survey import survey  # noqa: E402

NAMES = [r"$\frac", "speed_1"]  # not mathematics, though it looks like some
PLANT = lb.Plant(
    [[1, 1], [0, 1]],
    None,
    [[1, 0]],
    dt=0.5,
    Q=[[0.25, 0.5], [0.5, 1]],
    R=[[1]],
    P0=np.eye(2),
    state_names=NAMES,
)
OBSERVER = lb.kalman_filter(PLANT, steps=6)
COVARIANCES = lb.error_covariance(OBSERVER, PLANT, steps=6)
RECORD = np.arange(6) * PLANT.dt, np.ones((6, 2)), np.full((6, 2), 0.1)

FIGURES = {
    "error_variance": lambda ax: plot.error_variance(
        {"one": COVARIANCES}, PLANT, 0, ax
    ),
    "pareto": lambda ax: plot.pareto(survey(PLANT), ax),
    "cost_against_order": lambda ax: plot.cost_against_order(
        {"best": {2: 0.5, 1: 0.7}, r"$\frac": {1: 0.9}}, ax, least=0.4
    ),
    "estimates": lambda ax: plot.estimates(PLANT, *RECORD, NAMES[0], ax, y=np.ones(6)),
    "gains": lambda ax: plot.gains(OBSERVER.V, PLANT, ax),
    "gain bars": lambda ax: plot.gains(OBSERVER.V[-1], PLANT, ax),
    "poles": lambda ax: plot.poles({"observer": [0.5, 0.2 + 0.1j]}, 1.0, ax),
    "continuous poles": lambda ax: plot.poles({"observer": [-1]}, 0.0, ax),
}


@pytest.fixture
def ax():
    fig, ax = plt.subplots()
    yield ax
    plt.close(fig)


@pytest.mark.parametrize("draw", FIGURES.values(), ids=FIGURES)
def test_draws_on_the_axes_given_and_returns_it(ax, draw):
    other = plt.figure()  # the current figure, which must stay empty
    assert draw(ax) is ax and ax.has_data() and not other.axes
    ax.legend()
    ax.figure.canvas.draw()  # names with dollar signs are not taken for formulas
    plt.close(other)


@pytest.mark.parametrize("draw", FIGURES.values(), ids=FIGURES)
def test_draws_on_the_current_axes_without_one(ax, draw):
    plt.sca(ax)
    assert draw(None) is ax


def test_error_variance_shows_the_variance_against_seconds(ax):
    line = plot.error_variance({"one": COVARIANCES}, PLANT, "speed_1", ax).lines[0]
    np.testing.assert_array_equal(line.get_ydata(), COVARIANCES[:, 1, 1])
    np.testing.assert_array_equal(line.get_xdata(), 0.5 * np.arange(7))


def test_cost_is_drawn_in_the_order_of_orders(ax):
    costs = {"best": {3: 0.4, 1: 0.7, 2: 0.5}, "other": {1: 0.9}}
    best, other, least = plot.cost_against_order(costs, ax, least=0.3).lines
    np.testing.assert_array_equal(best.get_xydata(), [[1, 0.7], [2, 0.5], [3, 0.4]])
    assert other.get_marker() != best.get_marker()
    assert set(least.get_ydata()) == {0.3}
    assert len(plot.cost_against_order(costs, ax).lines) == 5


def test_band_is_one_sigma(ax):
    plot.estimates(PLANT, *RECORD, 0, ax)
    low, high = ax.collections[0].get_datalim(ax.transData).intervaly
    assert (low, high) == pytest.approx((0.9, 1.1))


def test_curves_differ_without_colour():
    dashes = [str(plot.style(k)["linestyle"]) for k in range(6)]
    assert len(set(dashes)) == 6 and len(set(plot.MARKERS)) == 6


@pytest.mark.parametrize(("count", "columns"), [(0, 3), (1, 3), (4, 3), (9, 3), (2, 2)])
def test_panels(count, columns):
    panels = plot.panels(count, columns=columns)
    assert len(panels) == count
    plt.close("all")
