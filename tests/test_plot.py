"""Figures: each function draws on the Axes it is given and returns it."""

import base64
import dataclasses
import functools

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

import luenberger as lb  # noqa: E402
from luenberger import plot  # noqa: E402
from luenberger.show import Picture, describe  # noqa: E402

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
QUIET = dataclasses.replace(PLANT, Q=None, R=None)
CONTINUOUS = dataclasses.replace(PLANT, dt=0.0)
DAMPED = dataclasses.replace(PLANT, A=[[0.9, 0.5], [0, 0.5]])
RECORD = np.arange(6) * PLANT.dt, np.ones((6, 2)), np.full((6, 2), 0.1)


@functools.cache
def compared():
    return lb.compare(PLANT)


@functools.cache
def judged():
    return lb.compare(
        DAMPED,
        {"$one": lb.kalman_filter(DAMPED), "two": lb.deadbeat_observer(PLANT)},
        plants=lb.vary(DAMPED, {"A[0,0]": (0.8, 1.1)}, samples=6),
    )


FIGURES = {
    "error_variance": lambda ax: plot.error_variance(
        {"one": COVARIANCES}, PLANT, 0, ax
    ),
    "error_variance of observers": lambda ax: plot.error_variance(
        {"constant": lb.kalman_filter(PLANT), "varying": OBSERVER}, PLANT, 0, ax
    ),
    "error_variance of a comparison": lambda ax: plot.error_variance(compared(), ax=ax),
    "pareto": lambda ax: plot.pareto(compared(), ax),
    "pareto by order": lambda ax: plot.pareto(compared(), ax, by="order"),
    "estimates": lambda ax: plot.estimates(PLANT, *RECORD, NAMES[0], ax, y=np.ones(6)),
    "gains": lambda ax: plot.gains(OBSERVER.V, PLANT, ax),
    "innovations": lambda ax: plot.innovations(PLANT, np.sin(np.arange(40)), ax=ax),
    "gain bars": lambda ax: plot.gains(OBSERVER.V[-1], PLANT, ax),
    "gains of an observer": lambda ax: plot.gains(OBSERVER, PLANT, ax),
    "gains of a comparison": lambda ax: plot.gains(compared(), ax=ax),
    "gains of a functional": lambda ax: plot.gains(
        lb.functional_observer(PLANT, [[1, 1], [0, 1]]), PLANT, ax
    ),
    "robustness": lambda ax: plot.robustness(judged(), ax),
    "robustness of two parameters": lambda ax: plot.robustness(
        lb.compare(
            PLANT,
            {"$x": lb.kalman_filter(PLANT)},
            plants=lb.vary(PLANT, {"A[0,1]": "1 %", "C[0,0]": "2 %"}, samples=5),
        ),
        ax,
    ),
    "poles of a comparison": lambda ax: plot.poles(compared(), ax=ax),
    "poles of an observer": lambda ax: plot.poles(lb.kalman_filter(PLANT), None, ax),
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


def test_front_and_methods_of_a_comparison(ax):
    plot.pareto(compared(), ax)
    drawn = {line.get_label(): line for line in ax.lines}
    front = compared().pareto()
    wanted = [[one.work, one.error] for one in front]
    np.testing.assert_array_equal(drawn.pop("front").get_xydata(), wanted)
    chosen = compared().recommended()
    np.testing.assert_array_equal(
        drawn.pop("recommended").get_xydata(), [[chosen.work, chosen.error]]
    )
    assert set(drawn) == {one.method for one in compared().ranked}
    assert len({line.get_marker() for line in drawn.values()}) == len(drawn)
    assert sum(len(line.get_xdata()) for line in drawn.values()) == len(
        compared().ranked
    )
    plot.pareto(compared(), ax, by="order")
    np.testing.assert_array_equal(ax.lines[-1].get_xdata(), [chosen.order])


def test_curves_of_robustness_are_errors_over_the_parameter(ax):
    assert plot.robustness(judged(), ax).get_xlabel() == "A[0,0]"
    varied = [*judged().plants][1:]
    values = [judged().plants[name].A[0, 0] for name in varied]
    order = np.argsort(values)
    for k, spread in enumerate(judged()):
        curve, marker = ax.lines[2 * k : 2 * k + 2]
        np.testing.assert_allclose(curve.get_xdata(), np.array(values)[order])
        errors = np.array([spread.errors[name] for name in varied])
        errors = np.where(np.isfinite(errors), errors, np.nan)
        np.testing.assert_array_equal(curve.get_ydata(), errors[order])
        np.testing.assert_array_equal(marker.get_ydata(), [np.nanmax(errors)])
        assert (marker.get_markerfacecolor() != "none") == (spread is judged().chosen)
        grows = len(spread.growing)
        assert ("grows on" in marker.get_label()) == (grows > 0)
    assert any(spread.growing for spread in judged())


def test_rows_of_robustness_reach_from_the_least_error_to_the_largest(ax):
    found = lb.compare(
        DAMPED,
        {"one": lb.kalman_filter(DAMPED), "two": lb.deadbeat_observer(PLANT)},
        plants={"b": dataclasses.replace(DAMPED, A=[[0.8, 0.5], [0, 0.4]])},
    )
    plot.robustness(found, ax)
    assert [tick.get_text() for tick in ax.get_yticklabels()] == ["one", "two"]
    for k, spread in enumerate(found):
        line, bar, median, worst = ax.lines[4 * k : 4 * k + 4]
        low, high = sorted(spread.errors.values())
        first = middle = low
        third = high
        np.testing.assert_array_equal(line.get_xdata(), [low, high])
        np.testing.assert_array_equal(bar.get_xdata(), [first, third])
        np.testing.assert_array_equal(median.get_xdata(), [middle])
        np.testing.assert_array_equal(worst.get_xdata(), [high])


def test_errors_far_above_are_counted_and_not_drawn(ax):
    plant = dataclasses.replace(PLANT, Q=1e-8 * PLANT.Q)
    table = lb.compare(plant)
    best = table.yardstick.error
    far = [one for one in table.ranked if one.error > 100 * best]
    assert far and ax.get_title() == ""
    plot.pareto(table, ax)
    assert ax.get_title().startswith(f"not shown: {len(far)} above ")
    highest = max(line.get_ydata().max() for line in ax.lines if len(line.get_ydata()))
    assert highest <= 100 * best


def test_a_comparison_shows_its_plant_and_its_best_designs(ax):
    labels = [line.get_label() for line in plot.poles(compared(), ax=ax).lines[1:]]
    assert labels == ["plant", "recommended"]  # which is the most accurate one too
    table = lb.compare(dataclasses.replace(PLANT, R=[[0.01]]))
    chosen, drawn = table.recommended(), plot.poles(table, ax=ax).lines[-2:]
    assert drawn[1].get_label() == "Kalman filter"
    for line, one in zip(drawn, (chosen, table.yardstick)):
        poles = line.get_xdata() + 1j * line.get_ydata()
        np.testing.assert_allclose(np.sort_complex(poles), one.observer.poles)
    bars = plot.gains(table, ax=plt.figure().gca())
    heights = [bar.get_height() for bar in bars.patches]
    np.testing.assert_array_equal(heights, chosen.observer.V.T.ravel())


def test_observers_start_from_P0(ax):
    observers = {"constant": lb.kalman_filter(PLANT), "varying": OBSERVER}
    plot.error_variance(observers, PLANT, 1, ax, steps=6)
    constant, varying = ax.lines
    np.testing.assert_array_equal(varying.get_ydata(), COVARIANCES[:, 1, 1])
    assert constant.get_ydata()[0] == varying.get_ydata()[0] == PLANT.P0[1, 1]
    assert (constant.get_ydata() >= varying.get_ydata() - 1e-12).all()


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda ax: plot.poles({"one": [0.5]}, None, ax), "give dt"),
        (lambda ax: plot.pareto(lb.compare(CONTINUOUS), ax), r"plant\.sampled"),
        (lambda ax: plot.gains(lb.compare(QUIET), ax=ax), "Nothing is recommended"),
        (lambda ax: plot.error_variance(lb.compare(QUIET), ax=ax), "no curves"),
    ],
    ids=["numbers without dt", "continuous front", "gains without noise", "no curves"],
)
def test_what_cannot_be_drawn_is_said(ax, draw, message):
    with pytest.raises(ValueError, match=message):
        draw(ax)


def test_a_picture_is_described_in_words(ax):
    shown = Picture(plot.pareto(compared(), ax).figure, "Designs by error and work.")
    data, look = shown._repr_mimebundle_()
    assert base64.b64decode(data["image/png"]).startswith(b"\x89PNG")
    assert look["image/png"]["alt"] == data["text/plain"] == repr(shown)
    assert shown.alt.startswith("Designs by error and work.\n") and len(shown.alt) > 90
    assert not plt.fignum_exists(ax.figure.number)  # shown once, not twice


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


@pytest.mark.parametrize("level", [0.25, 0.0])
def test_level_error_variances_stay_clear_of_the_frame(level):
    """Curves between 0.21 and 0.25: a margin of their span would hide the upper one."""
    plant = lb.Plant([[1.0]], None, [[1.0]], dt=1.0)
    shown = {"level": np.full((4, 1, 1), level), "falls": np.full((4, 1, 1), level)}
    shown["falls"][1:] *= 0.84
    ax = plot.error_variance(shown, plant, ax=plt.figure().subplots())
    bottom, top = ax.get_ylim()
    assert bottom == 0 and top >= max(1.04 * level, 0.1)
    plt.close("all")


def test_a_signal_of_a_diagram_ends_at_the_edge_of_its_block(ax):
    blocks = {"plant": (0, 0), "y": (1, 0, ""), "sum": (1, -1, "+")}
    arrows = [((-1, 0), "plant", "u"), ("plant", "y"), ("y", "sum")]
    plot.block_diagram(blocks, arrows, ax, apart=["plant"])
    words = describe(ax.figure).splitlines()
    assert 'rectangle "plant": grey 90 %; x -0.425 to 0.425, y -0.25 to 0.25' in words
    assert 'arrow "plant, u": black; (-1, 0) to (-0.425, 0)' in words
    assert 'arrow "plant to y": black; (0.425, 0) to (1, 0)' in words
    assert 'arrow "y to sum": black; (1, 0) to (1, -0.85)' in words


QUESTIONS = [
    ("Are Q and R known,\nor is there a record?", "no", "choose the poles"),
    (
        "Is a reading much better\nthan its prediction?",
        "yes",
        "read the front:\nthe exact designs",
    ),
    ("Is the plant stable?", "no", "Kalman filter"),
]


@pytest.fixture
def chart():
    fig, ax = plt.subplots(figsize=(4.8, 0.75 * 4), layout="constrained")
    yield plot.decision_chart(QUESTIONS, "fixed-order filter", ax)
    plt.close(fig)


def test_a_decision_chart_leads_by_one_answer_aside_and_by_the_other_down(chart):
    words = describe(chart.figure).splitlines()
    assert 'arrow "no": black; (2.15, 0) to (2.52, 0)' in words
    assert 'arrow "yes": black; (1.08, -0.27) to (1.08, -0.48)' in words
    assert 'arrow "yes": black; (2.15, -0.75) to (2.52, -0.75)' in words
    assert 'arrow "no": black; (1.08, -1.02) to (1.08, -1.32)' in words
    assert 'arrow "yes": black; (1.08, -1.68) to (1.08, -2.07)' in words
    numbers = [text for text in chart.texts if text.get_text().isdigit()]
    advice = {box.get_label(): box for box in chart.patches}
    for k, text in enumerate([*(one[2] for one in QUESTIONS), "fixed-order filter"]):
        box, number = advice[text], numbers[k]
        assert number.get_text() == f"{k + 1}"
        middle = box.get_x(), box.get_y() + box.get_height() / 2
        np.testing.assert_allclose(number.get_position(), middle, atol=1e-12)


def test_every_text_of_a_decision_chart_has_room_in_its_box(chart):
    chart.figure.draw_without_rendering()
    whole = chart.figure.bbox
    boxes = {
        one.get_label(): one.get_window_extent()
        for one in chart.patches
        if one.get_label() not in ("yes", "no")
    }
    texts = {one.get_text(): one.get_window_extent() for one in chart.texts}
    for label, box in boxes.items():
        text = texts[label]
        assert whole.x0 <= box.x0 < text.x0 and text.x1 < box.x1 <= whole.x1
        assert whole.y0 <= box.y0 < text.y0 and text.y1 < box.y1 <= whole.y1
        others = [one for other, one in texts.items() if other != label]
        assert not any(text.overlaps(other) for other in others)
    for k in "1234":
        assert not any(boxes[k].overlaps(texts[one]) for one in texts if one != k)
    rectangles = [box for label, box in boxes.items() if not label.isdigit()]
    for k, one in enumerate(rectangles):
        assert not any(one.overlaps(other) for other in rectangles[k + 1 :])
    for answer in (one for one in chart.texts if one.get_text() in ("yes", "no")):
        words = answer.get_window_extent()
        assert not any(words.overlaps(box) for box in boxes.values())
        ways = [one for one in chart.patches if one.get_label() == answer.get_text()]
        ways = [one.get_path().get_extents() for one in ways]
        (x, y), aside = answer.get_position(), answer.get_ha() == "center"
        near = [one for one in ways if abs(one.x0 + one.width / 2 - x) < 0.1]
        near = [one for one in near if abs(one.y0 + one.height / 2 - y) < 0.1]
        assert len(near) == 1
        assert y > near[0].y1 if aside else x > near[0].x1


@pytest.mark.parametrize(
    ("questions", "message"),
    [
        ([], "at least one question"),
        ([("Is it stable?", "perhaps", "wait")], "'perhaps' after 'Is it stable"),
        ([("1\n2\n3", "no", "wait")], "at most two lines of 24 letters"),
        ([("?" * 25, "no", "wait")], "at most two lines of 24 letters"),
        ([("Is it stable?", "no", "?" * 19)], "at most two lines of 18 letters"),
    ],
)
def test_a_decision_chart_refuses_what_it_has_no_room_for(ax, questions, message):
    with pytest.raises(ValueError, match=message):
        plot.decision_chart(questions, "last", ax)


def test_gains_have_a_panel_for_each_unit():
    names = dict(
        state_names=["position (m)", "speed (m/s)"],
        output_names=["radar (m)", "wheel (m/s)"],
    )
    plant = lb.Plant(PLANT.A, None, np.eye(2), dt=0.5, **names)
    K = np.array([[1.0, 2.0], [3.0, 4.0]])
    wanted = {
        "gain": {"position from radar": 1.0, "speed from wheel": 4.0},
        "gain (m per m/s)": {"position from wheel": 2.0},
        "gain (m/s per m)": {"speed from radar": 3.0},
    }
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    assert plot.gains(np.stack([K, K]), plant, ax) is ax
    panels = [one for one in fig.axes if one is not beside]
    drawn = {one.get_ylabel(): one.lines for one in panels}
    assert {
        label: {line.get_label(): line.get_ydata()[-1] for line in lines}
        for label, lines in drawn.items()
    } == wanted
    assert [one.get_title() for one in panels[1:]] == [
        "position from wheel", "speed from radar",
    ]  # fmt: skip
    fig.canvas.draw()
    right = beside.get_position().x0
    assert all(one.get_position().x1 < right for one in panels)
    plt.close(fig)
    fig, ax = plt.subplots()
    plot.gains(K, plant, ax)
    bars = {one.get_ylabel(): [b.get_height() for b in one.patches] for one in fig.axes}
    assert bars == {label: list(gains.values()) for label, gains in wanted.items()}
    plt.close(fig)
    alone = plt.figure().add_axes((0.1, 0.1, 0.8, 0.8))  # which is in no grid
    assert len(plot.gains(K, plant, alone).patches) == 4
    assert alone.get_ylabel() == "gain (units of state per output)"
    plt.close(alone.figure)


def test_a_unit_without_gains_has_no_panel():
    given = dict(state_names=["a (m)", "b (K)"], output_names=["y (m)", "t (K)"])
    plant = lb.Plant(np.eye(2) / 2, None, np.eye(2), dt=1.0, **given)
    for K in (np.array([[0.5, 0.0], [0.2, 0.3]]), np.zeros((2, 2))):
        figure = plt.figure()
        plot.gains(K, plant, figure.add_subplot())
        labels = [one.get_ylabel() for one in figure.axes]
        assert labels == ["gain", "gain (K per m)"][: 1 + K.any()]
        plt.close(figure)
