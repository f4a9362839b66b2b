"""A figure in words: they hold what is drawn, and every damage changes them."""

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.patches import Ellipse, FancyArrowPatch

from luenberger import show

T = np.linspace(0, 4, 9)


def drawn():
    """Two panels with one of everything that the notebooks draw."""
    figure, (left, right) = plt.subplots(1, 2)
    left.axhspan(-0.5, 0.5, color="0.85", label="one sigma")
    left.plot(T, np.exp(-T), "o-", color="#0072B2", label="velocity error")
    left.plot(T, np.exp(-2 * T), "s--", color="#D55E00", label="position error")
    left.fill_between(T, 0, np.exp(-T), color="#009E73", alpha=0.2, label="gap")
    left.axhline(0.25, color="k", ls=":", label="floor")
    left.axvline(2.0, color="0.5")
    left.set(xlabel="time (s)", ylabel="error (m)", title="Errors", xlim=(0, 4))
    left.annotate("settled", (3, 0.05), (2.5, 0.6), arrowprops={"arrowstyle": "->"})
    left.annotate("", (2, 0.2), (0, 0), arrowprops={"arrowstyle": "->"})
    left.legend()
    right.bar([0, 1, 2], [3.0, 2.0, 1.0], color="#CC79A7", label="gain")
    right.set_xticks([0, 1, 2], ["a", "b", "c"])
    right.scatter([0.5, 1.5], [1.0, 2.5], color="#E69F00", label="samples")
    right.add_patch(Ellipse((1, 1), 0.5, 1.0, label="ellipse"))
    right.add_patch(FancyArrowPatch((0, 0), (1, 1)))
    right.vlines([0.2, 0.4], 0, 1, color="k")
    return figure


def curve(figure, k=0):
    return [one for one in figure.axes[0].lines if len(one.get_xdata()) > 2][k]


def move_a_point(figure):
    y = curve(figure).get_ydata().copy()
    y[4] += 0.2
    curve(figure).set_ydata(y)


def swap(figure):
    lines = curve(figure), curve(figure, 1)
    values = [one.get_ydata().copy() for one in lines]
    for line, other in zip(lines, reversed(values)):
        line.set_ydata(other)


def reorder(figure):
    figure.axes[0].lines[0].set_label("position error")
    figure.axes[0].lines[1].set_label("velocity error")


def empty(figure):
    curve(figure).set_data([], [])


def hide(figure):
    curve(figure, 1).set_visible(False)


def shape(figure, kind):
    (found,) = (one for one in figure.axes[1].patches if isinstance(one, kind))
    return found


DAMAGES = {
    "a point": move_a_point,
    "one step late": lambda f: curve(f).set_xdata(T + 0.5),
    "swapped": swap,
    "labels swapped": reorder,
    "empty": empty,
    "hidden": hide,
    "colour": lambda f: curve(f).set_color("#D55E00"),
    "dashes": lambda f: curve(f).set_linestyle(":"),
    "marker": lambda f: curve(f).set_marker("^"),
    "open marker": lambda f: curve(f).set_markerfacecolor("none"),
    "label of a curve": lambda f: curve(f).set_label("speed error"),
    "label of an axis": lambda f: f.axes[0].set_xlabel("time (min)"),
    "no label": lambda f: f.axes[0].set_ylabel(""),
    "title": lambda f: f.axes[0].set_title("Gains"),
    "limits": lambda f: f.axes[0].set_ylim(0.1, 0.9),
    "turned round": lambda f: f.axes[0].invert_yaxis(),
    "scale": lambda f: f.axes[0].set_yscale("log"),
    "level": lambda f: f.axes[0].lines[2].set_ydata([0.3, 0.3]),
    "upright": lambda f: f.axes[0].lines[3].set_xdata([2.5, 2.5]),
    "legend": lambda f: f.axes[0].get_legend().remove(),
    "band": lambda f: f.axes[0].patches[0].set_height(2.0),
    "area": lambda f: f.axes[0].collections[0].set_alpha(0.5),
    "note": lambda f: f.axes[0].texts[0].set_text("moving"),
    "place of a note": lambda f: f.axes[0].texts[0].set_position((1.5, 0.6)),
    "end of an arrow": lambda f: setattr(f.axes[0].texts[0], "xy", (1, 0.05)),
    "end of a bare arrow": lambda f: setattr(f.axes[0].texts[1], "xy", (1, 0.1)),
    "bar": lambda f: f.axes[1].containers[0].patches[1].set_height(2.5),
    "name of a bar": lambda f: f.axes[1].set_xticks([0, 1, 2], ["a", "c", "b"]),
    "points": lambda f: f.axes[1].collections[0].set_offsets([[0.5, 1], [1.5, 2]]),
    "ellipse": lambda f: shape(f, Ellipse).set_width(0.8),
    "arrow": lambda f: shape(f, FancyArrowPatch).set_positions((0, 0), (2, 1)),
    "panels": lambda f: f.axes[1].remove(),
    "heading": lambda f: f.suptitle("Two panels"),
}


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def undamaged():
    """What is drawn, in words."""
    return show.describe(drawn())


def test_the_same_figure_reads_the_same(undamaged):
    figure = drawn()
    assert show.describe(figure) == show.describe(figure) == undamaged


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_figure_reads_differently(undamaged, damage):
    figure = drawn()
    damage(figure)
    assert show.describe(figure) != undamaged


def test_words_say_what_is_drawn():
    lines = show.describe(drawn()).splitlines()
    assert lines[0] == "Panel 1 of 2"
    assert lines[2] == "x: time (s), 0 to 4; y: error (m), -0.575 to 1.08"
    assert lines[3] == (
        'curve "velocity error": blue, solid, circles; 9 points, x 0 to 4, '
        "y 1 to 0.0183, least 0.0183, greatest 1, mean 0.279"
    )
    for line in (
        'level "floor": black, dotted; y 0.25',
        "upright without label: grey 50 %, solid; x 2",
        'rectangle "one sigma": grey 85 %; y -0.5 to 0.5',
        'text "settled" at (2.5, 0.6), arrow to (3, 0.05)',
        "legend: one sigma, velocity error, position error, gap, floor",
        "x: no label, -0.54 to 2.54 with ticks a, b, c; y: no label, 0 to 3.15",
        'bars "gain": purple; 3, 2, 1',
        'ellipse "ellipse": #1f77b4; x 0.75 to 1.25, y 0.5 to 1.5',
        "arrow without label: #1f77b4; (0, 0) to (1, 1)",
    ):
        assert line in lines


def test_rounding_is_not_described():
    """Points that only rounding tells from 0, and numbers that end in 5."""
    figure, noisy = plt.subplots()
    noisy.plot([0, 1, 2], [1.0, 3e-16, 0.3125])
    other, clean = plt.subplots()
    clean.plot([0, 1, 2], [1.0, 0.0, 0.3125 * (1 - 1e-15)])
    assert show.describe(figure) == show.describe(other)


def test_a_curve_of_rounding_errors_is_described_by_its_look():
    """How rounding grows differs between machines: neither sizes nor range are told."""
    words = []
    for growth in (2, 3):
        figure, ax = plt.subplots()
        ax.plot(growth ** np.arange(growth * 20), gid="rounding", label="error")
        words.append(show.describe(figure))
    assert words[0] == words[1]
    assert "error" in words[0] and "y: no label, as far as curves go" in words[0]


def test_missing_values_and_dates():
    figure, ax = plt.subplots()
    ax.plot(np.array(["2026-01-01", "2026-01-03"], "datetime64[D]"), [1.0, np.nan])
    words = show.describe(figure)
    assert "2 points (1 missing), x 2026-01-01 00:00:00 to 2026-01-03 00:" in words


def test_the_order_of_points_without_a_line_is_not_seen():
    """Poles come in any order that LAPACK likes."""
    words = []
    for values in ([1.0, 2.0, 4.0], [4.0, 1.0, 2.0]):
        figure, ax = plt.subplots()
        ax.plot(values, values, "o", ls="")
        words.append(show.describe(figure))
    assert words[0] == words[1]


def test_names_of_the_user_are_no_mathematics():
    figure, ax = plt.subplots()
    ax.plot([1, 2], label=r"\$\frac")
    ax.set(xlabel=r"pole scale $s$ (rad/s)", ylabel=r"$\beta_1$")
    words = show.describe(figure)
    assert r'"$\frac"' in words and "x: pole scale s (rad/s)" in words
    assert "y: beta_1" in words


def test_a_terminal_gets_the_words(capsys):
    figure = drawn()
    words = show.describe(figure)
    show.show(figure, "Errors fall.")
    assert capsys.readouterr().out == f"Errors fall.\n{words}\n"
    assert not plt.fignum_exists(figure.number)  # or a notebook would show it twice


def test_a_notebook_gets_the_picture_with_its_words(monkeypatch):
    import IPython

    shown = []
    monkeypatch.setattr(IPython, "get_ipython", lambda: object())
    monkeypatch.setattr(
        IPython.display, "display", lambda one, **how: shown.append(one)
    )
    show.show(drawn(), "Errors fall.")
    data, look = shown[0]._repr_mimebundle_()
    assert data["text/plain"] == look["image/png"]["alt"] == shown[0].alt
    assert data["text/plain"].startswith("Errors fall.\nPanel 1 of 2")
    assert shown[1]["text/markdown"] == "*Errors fall.*"  # the caption below it
