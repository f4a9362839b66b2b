"""The rules of the descent, each with a case just inside and one just outside."""

from types import SimpleNamespace

import numpy as np
import pytest

import luenberger as lb
from luenberger.papers.haddad_bernstein import descent as descent
from luenberger.papers.haddad_bernstein.descent import Frame


def frame(values, slope=(0.0, 0.0), left=1.0, scale=1.0):
    """A stand-in with curvatures `values`, and a gradient in the same coordinates."""
    return SimpleNamespace(
        target=SimpleNamespace(scale=scale), values=np.array(values, float),
        slope=np.array(slope, float), left=left,
    )  # fmt: skip


@pytest.mark.parametrize("scale", [1.0, 1e3])
@pytest.mark.parametrize(
    ("values", "slope", "left", "minimum"),
    [
        ([-0.9e-9, 1], 0, 1, True),  # curvature: 1e-9 of the largest is rounding
        ([-1.1e-9, 1], 0, 1, False),
        ([-1.1e-9, -2], 0, 1, True),  # the largest in magnitude
        ([0.5, 1], 0.9e-9, 1, True),  # gradient, beside the scale of the cost
        ([0.5, 1], 1.1e-9, 1, False),
        ([0.5, 1], 1, 0.9e-14, True),  # or what is left to win
        ([0.5, 1], 1, 1.1e-14, False),
    ],
)
def test_where_a_minimum_is(values, slope, left, minimum, scale):
    one = frame(values, (slope * scale, 0), left * scale, scale)
    assert bool(Frame.is_minimum.fget(one)) is minimum


@pytest.mark.parametrize(("least", "flat"), [(0.9e-7, True), (1.1e-7, False)])
def test_where_a_minimum_is_one_of_many(least, flat):
    assert bool(Frame.is_flat.fget(frame([least, 1]))) is flat
    assert bool(Frame.is_flat.fget(frame([3 * least, 3]))) is flat
    assert Frame.is_flat.fget(frame([0, 0]))


def test_what_is_left_is_that_of_the_parabola():
    """f = sum s x + v x^2 / 2 has its minimum -sum s^2 / (2 v) below."""
    one = frame([2.0, 8.0], [3.0, 4.0])
    assert Frame.left.fget(one) == pytest.approx(9 / 4 + 16 / 16)
    level = frame([0.0, 1.0], [1e-10, 0.0])  # no curvature counts as 1e-14
    assert Frame.left.fget(level) == pytest.approx(0.5e-20 / 1e-14)


@pytest.mark.parametrize("reach", [0.1, 10.0])
@pytest.mark.parametrize("values", [[0.5, 2.0], [-0.3, 2.0], [-3.0, -1.0]])
def test_step_is_the_best_within_reach(values, reach):
    """No better one among many on a grid of the disc."""
    one = frame(values, [0.3, -0.4])
    step = Frame.step(one, reach)
    assert np.linalg.norm(step) <= reach * (1 + 1e-9)
    fall = Frame.model(one, step)
    angle, length = np.meshgrid(
        np.linspace(0, 2 * np.pi, 721), np.linspace(0, reach, 201)
    )
    x, y = length * np.cos(angle), length * np.sin(angle)
    model = -(0.3 * x - 0.4 * y + 0.5 * (values[0] * x**2 + values[1] * y**2))
    assert fall >= model.max() * (1 - 1e-12)
    assert fall == pytest.approx(model.max(), rel=1e-3)


@pytest.mark.parametrize(("curvature", "edge"), [(-1.1e-9, True), (-0.9e-9, False)])
def test_step_goes_to_the_edge_where_the_cost_curves_down(curvature, edge):
    """At a saddle the gradient says nothing of the way down."""
    step = Frame.step(frame([curvature, 1.0], [0.0, 0.1]), 0.5)
    length = np.linalg.norm(step)
    assert length == pytest.approx(0.5 if edge else 0.1)
    assert step[1] == pytest.approx(-0.1, rel=1e-6)


class Scripted:
    """A frame of which each step keeps a given part of what it promises."""

    def __init__(self, kept, length=1.0, scale=0.0):
        self.kept, self.length = kept, length
        self.target, self.point = (
            SimpleNamespace(scale=scale),
            SimpleNamespace(cost=5.0),
        )
        self.reaches = []

    def step(self, reach):
        self.reaches.append(reach)
        return np.array([self.length * reach])

    def model(self, step):
        return 1.0

    def moved(self, step):
        return np.zeros((1, 1)), None


@pytest.fixture
def move(monkeypatch):
    def carried_out(frame, reach):
        cost = SimpleNamespace(cost=5.0 - frame.kept)
        monkeypatch.setattr(descent, "evaluate", lambda *_: cost)
        monkeypatch.setattr(descent, "Frame", lambda *_: "moved")
        return descent._move(frame, reach)

    return carried_out


@pytest.mark.parametrize(
    ("kept", "length", "reach", "then"),
    [
        (0.76, 1.0, 0.3, 0.6),  # a good model, used to its edge: further
        (0.74, 1.0, 0.3, 0.3),
        (0.76, 0.91, 0.3, 0.6),
        (0.76, 0.89, 0.3, 0.3),
        (0.76, 1.0, 1.5, 2.0),  # never beyond 2: all filters are that close
        (0.26, 1.0, 0.3, 0.3),
        (0.24, 1.0, 0.3, 0.075),  # a bad model: a quarter
        (0.24, 0.5, 0.3, 0.0375),  # of the step, if that was shorter
        (1.1e-4, 1.0, 0.4, 0.1),  # but any fall is taken
    ],
)
def test_reach_follows_how_good_the_model_was(move, kept, length, reach, then):
    frame, reached = move(Scripted(kept, length), reach)
    assert frame == "moved" and reached == pytest.approx(then)


@pytest.mark.parametrize("kept", [0.9e-4, 0.0, -3.0])
def test_a_step_without_a_fall_is_shortened_until_it_is_rounding(move, kept):
    frame = Scripted(kept)
    with pytest.raises(lb.CertificateError, match="falls no further"):
        move(frame, 1.0)
    quarters = 0.25 ** np.arange(len(frame.reaches))
    assert frame.reaches == pytest.approx(quarters, rel=1e-9, abs=0)
    assert frame.reaches[-1] > 1e-12 >= 0.25 * frame.reaches[-1]


def test_rounding_of_the_cost_does_not_refuse_a_step(move):
    """A cost of scale 1 is known to 1e-13: a rise by that much may be none."""
    frame = Scripted(-0.9e-13, scale=1.0)
    frame.model = lambda step: 1e-13
    assert move(frame, 1e-11)[0] == "moved"
    frame.kept = -1.1e-13
    with pytest.raises(lb.CertificateError, match="falls no further"):
        move(frame, 1e-11)


def test_a_descent_that_never_ends_is_ended(monkeypatch):
    moves = []
    monkeypatch.setattr(
        descent, "Frame", lambda *_: SimpleNamespace(is_minimum=len(moves) >= 300)
    )
    monkeypatch.setattr(descent, "_polished", lambda frame: "minimum")

    def move(frame, reach):
        moves.append(reach)
        return descent.Frame(), reach

    monkeypatch.setattr(descent, "_move", move)
    with pytest.raises(lb.CertificateError, match="no minimum after 300 moves"):
        descent.descend(None, None, None)
    assert len(moves) == 300
