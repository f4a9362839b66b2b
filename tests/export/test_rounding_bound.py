"""Bounds on rounding hold on a million steps, and exactly, and are not vacuous."""

from fractions import Fraction

import generators
import numpy as np
import pytest
from rounding_runs import PATTERNS, gaps, per_unit

import luenberger as lb
from luenberger.export import rounding_bound, to_c
from luenberger.export.c import limits
from luenberger.export.c.rounding_bound import upward
from luenberger.kernels.c import library
from luenberger.kernels.pieces import pieces
from luenberger.papers.leondes_novak.derivation import observer_step

needs_compiler = pytest.mark.skipif(
    library.compiler() is None, reason="there is no C compiler"
)
STEPS = 1_000_000


def tracker(drive=0.1, **changes):
    given = dict(Q=np.diag([0, drive]), R=[[0.5]], P0=np.eye(2), dt=0.5)
    return lb.Plant([[1, 0.5], [0, 1]], [[0], [1]], [[1, 0]], **given | changes)


OBSERVERS = {
    "Kalman filter, not at zero first": lb.kalman_filter(tracker(x0=[3.0, 1 / 3])),
    "an accurate output": lb.reduced_order_filter(tracker(), 1),
    "slow": lb.kalman_filter(tracker(drive=1e-6)),
    "six states": lb.kalman_filter(generators.plant(np.random.default_rng(3), 6, 3)),
}
DEVICES = {
    "double": dict(dtype="double"),
    "float": dict(dtype="float"),
    "16 bits": dict(dtype="fixed", bits=16),
    "32 bits": dict(dtype="fixed", bits=32),
}


def sizes(observer):
    """Ranges, none of them a number that float or a count has exactly."""
    inputs = {f"u{i + 1}": 1.1 + i for i in range(observer.G.shape[1])}
    return inputs | {f"y{i + 1}": 7.3 * (i + 1) for i in range(observer.D.shape[1])}


@needs_compiler
@pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)
@pytest.mark.parametrize("observer", OBSERVERS.values(), ids=OBSERVERS)
def test_a_bound_holds_on_a_million_steps_and_is_not_vacuous(
    observer, device, tmp_path
):
    ranges = sizes(observer)
    bound = rounding_bound(observer, ranges=ranges, **device).largest
    found = gaps(observer, tmp_path, ranges, steps=STEPS // 5 + 1, **device)
    assert list(found) == list(PATTERNS)
    for pattern, (gap, _) in found.items():
        assert (gap <= bound).all(), f"{pattern}: {gap} is beyond {bound}"
    worst = np.max([gap for gap, _ in found.values()], axis=0)
    felt = worst > 0
    assert felt.any() and (bound[felt] <= 100 * worst[felt]).all()


@needs_compiler
def test_exact_estimates_reach_what_is_said_of_their_size(tmp_path):
    """The worst signs drive the first estimate as far as the sum of sizes says."""
    observer = OBSERVERS["an accurate output"]
    ranges, exact = sizes(observer), limits.Exact(observer)
    s = np.array(list(ranges.values()))[:, None]
    device = limits.floating(observer, "double")
    reach = exact.limits(device, observer.z0, s, 0 * s).estimate[:, 0]
    found = gaps(observer, tmp_path, ranges, steps=5000, dtype="double")
    most = np.max([size for _, size in found.values()], axis=0)
    assert (most <= reach).all() and most[0] > 0.99 * reach[0]


# -- exactly ---------------------------------------------------------------------------


def exact_rows(observer, readings):
    """Estimates in fractions."""
    o = observer
    moves = np.hstack([o.F, o.G, o.D]).tolist()
    shows = np.hstack([o.P, o.W, o.V]).tolist()
    z, found = [Fraction(one) for one in o.z0.tolist()], []
    for row in readings:
        s = [*z, *map(Fraction, row)]
        dot = [sum(map(lambda a, b: Fraction(a) * b, w, s)) for w in (*moves, *shows)]
        z = dot[: o.order]
        found.append(dot[o.order :])
    return found


def narrow_rows(observer, readings, order):
    """Estimates in float32, sums added up in any order."""
    o, f = observer, np.float32
    moves = np.hstack([o.F, o.G, o.D]).astype(f)
    shows = np.hstack([o.P, o.W, o.V]).astype(f)
    z, found = o.z0.astype(f), []
    for row in readings:
        s = np.concatenate([z, np.array(row).astype(f)])
        sums = []
        for weights in (*moves, *shows):
            total = f(0)
            for j in order.permutation(len(s)):
                total = f(total + f(weights[j] * s[j]))
            sums.append(total)
        z = np.array(sums[: o.order], f)
        found.append(sums[o.order :])
    return found


@pytest.mark.parametrize("observer", OBSERVERS.values(), ids=OBSERVERS)
def test_any_order_of_a_sum_is_within_the_bound(observer):
    rng, ranges = np.random.default_rng(2), sizes(observer)
    bound = rounding_bound(observer, ranges=ranges).largest
    s = np.array(list(ranges.values()))
    signs = np.where(rng.random((150, len(s))) < 0.5, -1.0, 1.0)
    readings = (s * signs).tolist()
    exact, made = exact_rows(observer, readings), narrow_rows(observer, readings, rng)
    for wanted, got in zip(exact, made, strict=True):
        off = [abs(Fraction(float(a)) - b) for a, b in zip(got, wanted, strict=True)]
        assert all(a <= Fraction(b) for a, b in zip(off, bound.tolist(), strict=True))


def test_a_copy_is_off_by_its_reading_alone():
    """y1 itself: one rounding in float; its half as well; its third takes two more."""
    ones = dict(F=[[0.0]], G=np.zeros((1, 0)), D=[[0.0]], T=[[0.0]], dt=1.0)
    for weight, roundings in ((1.0, 1), (0.5, 1), (1 / 3, 2)):
        observer = lb.Observer(
            ones["F"], ones["G"], ones["D"], [[0.0]], [[weight]],
            T=ones["T"], L=[[weight]], dt=1.0,
        )  # fmt: skip
        found = rounding_bound(observer, ranges={"y1": 1.0}).largest[0]
        own = abs(float(np.float32(weight)) - weight)
        wanted = weight * roundings * 2.0**-24 + own
        assert found == pytest.approx(wanted, rel=2e-3)


def test_rounding_of_a_sum_counts_its_terms():
    """By hand: j roundings move a term by j u / (1 - j u), and a zero is no term."""
    rows = np.array([[0.3, 0.0, 0.7], [0.5, 1.0, 0.25], [0.0, 2.0, 0.0], [0, 0, 0]])
    part, least = limits._sums(rows, "float")
    u = 2.0**-24 * (1 + 2.0**-10)
    assert part.tolist() == [2 * u / (1 - 2 * u), 2 * u / (1 - 2 * u), 0, 0]
    assert least[3] == 0 and (least[:3] > 0).all()


def test_blocks_are_those_of_the_step_that_is_exported():
    """[G, D] and [W, V] beside F and P, as the stage list has them."""
    observer = lb.kalman_filter(generators.plant(np.random.default_rng(4), 3, 2))
    terms = {
        piece.target.name: {tuple(one.name for one in t.factors) for t in piece.terms}
        for piece in pieces(observer_step())
    }
    assert terms == {
        "z_next": {("F", "z"), ("G", "u"), ("D", "y")},
        "w_hat": {("P", "z"), ("W", "u"), ("V", "y")},
    }
    made = limits.blocks(observer)
    assert (made["B"] == np.hstack([observer.G, observer.D])).all()
    assert (made["V"] == np.hstack([observer.W, observer.V])).all()


# -- ranges and words ------------------------------------------------------------------


def test_the_header_says_the_bound_within_ranges_or_for_each_signal(tmp_path):
    observer = lb.kalman_filter(tracker())
    ranges = {"u1": 2.0, "y1": 10.0}
    bound = rounding_bound(observer, ranges=ranges)
    _, header = to_c(observer, tmp_path, dtype="float", ranges=ranges)
    text = header.read_text()
    assert '"u1" is at most 2.0 in size' in text
    for name, value in zip(("x1", "x2"), bound.largest):
        assert f'"{name}": {upward(value)}\n' in text
        assert f"{name}: off by at most {upward(value)}." in bound.sentences
    assert "This holds while |u1| <= 2, |y1| <= 10." in repr(bound)
    _, header = to_c(observer, tmp_path, dtype="float")
    for name, value in zip(("x1", "x2"), bound.largest):
        each = per_unit(header, name)
        total = each[None] + each["u1"] * 2 + each["y1"] * 10
        assert value <= total <= 1.02 * value


def test_ranges_of_measurements_follow_from_the_noises_of_a_stable_plant():
    plant = lb.Plant([[0.5]], [[1.0]], [[2.0]], [[3.0]], dt=1.0, Q=[[3]], R=[[4]])
    observer = lb.kalman_filter(plant)
    found = rounding_bound(observer, plant=plant, ranges={"u1": 1.5})
    sigma = np.sqrt(2 * 2 * 3 / (1 - 0.25) + 4)  # by hand
    size = dict(found.ranges)["y1"]
    assert size == pytest.approx(6 * sigma + 1.5 * (2 / (1 - 0.5) + 3), rel=1e-5)
    assert "'y1' is 6 standard deviations of the plant" in found.source
    assert "is 6 standard deviations" in " ".join(found.notes())
    given = rounding_bound(observer, plant=plant, ranges={"u1": 1.5, "y1": size})
    assert given.source == "" and (given.largest == found.largest).all()


@pytest.mark.parametrize(
    "ranges, plant, message",
    [
        (None, None, "range of 'u1', 'y1' is not known: give ranges"),
        ({"u1": 1.0}, None, "'y1' is not known.*give the plant as well"),
        ({"u1": 1.0}, tracker(), "'y1' is not known.*stable and has Q and R"),
        ({"u": 1.0}, None, "names 'u', which is no input or measurement"),
        ({"u1": 0.0}, None, "range of 'u1' must be a positive number"),
        ({"u1": np.inf}, None, "range of 'u1' must be a positive number"),
        ({"u1": True}, None, "range of 'u1' must be a positive number"),
        ({"u1": "1"}, None, "range of 'u1' must be a positive number"),
    ],
)
def test_ranges_that_are_missing_or_wrong_are_named(ranges, plant, message):
    with pytest.raises(ValueError, match=message):
        rounding_bound(lb.kalman_filter(tracker()), plant=plant, ranges=ranges)


def test_a_name_of_two_signals_is_refused():
    plant = tracker(input_names=["speed"], output_names=["speed"])
    with pytest.raises(ValueError, match="an input and a measurement; name them apart"):
        rounding_bound(lb.kalman_filter(plant), ranges={"speed": 1.0})


def test_an_observer_that_is_too_slow_gets_no_bound(tmp_path, monkeypatch):
    observer = lb.kalman_filter(tracker())
    monkeypatch.setattr(limits, "power_sums", lambda *_: None)
    with pytest.raises(lb.DesignError, match="no bound was proved"):
        rounding_bound(observer, ranges={"u1": 1.0, "y1": 1.0})
    _, header = to_c(observer, tmp_path)
    assert "No bound on rounding was proved" in header.read_text()


def test_bits_go_with_whole_numbers_only():
    observer = lb.kalman_filter(tracker())
    with pytest.raises(ValueError, match="bits goes with dtype='fixed'"):
        rounding_bound(observer, dtype="float", bits=16)
    with pytest.raises(ValueError, match="must be 16 or 32"):
        rounding_bound(observer, dtype="fixed", ranges={"u1": 1.0, "y1": 1.0})


@pytest.mark.parametrize("value", [1e-37, 0.1, 1 / 3, 250.0, 99.95, 123456.0, 7e22])
def test_figures_are_rounded_up(value):
    assert value <= float(upward(value)) <= 1.011 * value
