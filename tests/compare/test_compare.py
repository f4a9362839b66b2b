"""One plant under every method: complete, open about refusals, sound in its advice."""

import dataclasses
import itertools
import json
import re

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.analysis.mean_square import equivalent_noise
from luenberger.analysis.step_cost import step_cost
from luenberger.compare import METHODS, from_start, transients
from luenberger.compare.measure import noise_gain
from luenberger.compare.methods import _not_tried, _too_many, choices
from luenberger.compare.question import Question, butterworth
from luenberger.export import to_c
from luenberger.show import Prose, Table, array

FILTERS = ["Kalman filter", "Leondes-Novak filter"]


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


def stable(**changes):
    given = dict(dt=1.0, Q=np.diag([1.0, 0.5, 0.2]), R=[[0.1]], P0=np.eye(3))
    A = [[0.8, 0.2, 0], [0, 0.6, 0.3], [0.1, 0, 0.5]]
    B = changes.pop("B", None)
    return lb.Plant(A, B, [[1, 0, 0]], **(given | changes))


def novak(table, accurate, horizon):
    return table.find("Leondes-Novak filter", accurate=accurate, horizon=horizon)


@pytest.fixture(scope="module")
def table():
    return lb.compare(tracker())


@pytest.fixture(scope="module")
def smooth():
    return lb.compare(stable())


K = np.array([[1.0, -1, 0]])


@pytest.fixture(scope="module")
def of_k():
    return lb.compare(stable(), k=K)


# -- what is tried ------------------------------------------------------------------


def test_every_subset_is_tried_up_to_four_outputs():
    assert len(choices(50, 4)) == 16 and choices(3, 0) == choices(60, 0) == [()]
    assert choices(50, 5) == [tuple(range(m1)) for m1 in range(6)]


def test_large_plants_try_few_sets_of_outputs():
    for p, sizes in (1, [0, 1]), (4, [0, 1, 2, 4]), (6, [0, 1, 2, 4, 6]):
        assert choices(51, p) == [tuple(range(m1)) for m1 in sizes]


def planned(n, p, orders=None):
    """What would be tried on a plant of this size; and the reasons for what is not."""
    plant = lb.Plant(0.5 * np.eye(n), None, np.eye(n)[:p], dt=1.0)
    asked = Question(plant, orders=orders)
    for method in ("Leondes-Novak filter", "fixed-order filter"):
        for plan in METHODS[method](asked):
            reason = ""
            if getattr(plan.design, "func", None) in (_not_tried, _too_many):
                with pytest.raises(lb.DesignError, match="^not tried.*plant, ") as told:
                    plan.design()
                reason = str(told.value)
            yield plan, reason


@pytest.mark.parametrize(
    ("n", "p", "filters", "fixed"),
    [
        (50, 4, 30, 3),
        (51, 4, 6, 3),
        (200, 1, 2, 0),
        (101, 5, 8, 0),
        (9, 5, 10, 8),
        (10, 8, 16, 3),
    ],
)
def test_what_is_not_tried_is_listed_and_says_what_makes_it(n, p, filters, fixed):
    tried = [plan.method for plan, reason in planned(n, p) if not reason]
    assert tried.count("Leondes-Novak filter") == filters
    assert tried.count("fixed-order filter") == fixed
    left = [plan.label for plan, reason in planned(n, p) if reason]
    assert ("other outputs taken as accurate" in left) == (filters < 2 * (2**p - 1))
    assert f"order {n - 1}" in left or fixed == n - 1


def test_orders_that_are_asked_for_are_tried_however_large_the_plant():
    assert [p.label for p, why in planned(101, 1, (7,)) if why] == [
        "every order, V = 0"
    ]


def test_every_method_is_listed_and_every_subset_with_both_gains(table):
    assert [*dict.fromkeys(one.method for one in table)] == [*METHODS]
    tried = [one for one in table if one.method == "Leondes-Novak filter"]
    listed = [(one.accurate, one.horizon) for one in tried]
    subsets = itertools.product([(0,), (1,), (0, 1)], ["step", "steady"])
    assert listed == [*subsets] and not any(one.refusal for one in tried)


def test_every_order_is_tried_with_and_without_feedthrough(smooth):
    fixed = [one for one in smooth.designs if one.method == "fixed-order filter"]
    assert [one.order for one in fixed] == [1, 1, 2, 2]
    assert [bool(one.observer.V.any()) for one in fixed] == [True, False] * 2


def test_what_would_take_long_is_not_tried_and_said_so():
    n = 11
    A = np.diag(np.linspace(0.1, 0.9, n))
    plant = lb.Plant(A, None, np.ones((1, n)), dt=1.0, Q=np.eye(n), R=[[1]])
    table = lb.compare(plant, methods=[*FILTERS[:1], "fixed-order filter"])
    untried = [one for one in table.refused if "not tried" in one.refusal]
    assert [one.order for one in untried] == [*range(4, 11), None]
    assert "fixed_order_filter(plant, order)" in untried[0].refusal
    assert "feedthrough=False" in untried[-1].refusal
    asked = lb.compare(plant, methods=["fixed-order filter"], orders=[4])
    assert [one.order for one in asked.designs] == [4]


def test_only_what_was_asked_for(table):
    some = lb.compare(tracker(), methods=reversed(FILTERS), orders=[2, 3])
    assert [one.method for one in some] == [FILTERS[0], *FILTERS[1:] * 4]
    assert {one.order for one in some} == {2, 3}
    one = lb.compare(tracker(), methods="deadbeat observer")
    assert [a.method for a in one] == ["deadbeat observer"]
    assert one.yardstick is one.recommended()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(methods=["Kalman"]), "no method 'Kalman'; there are .*deadbeat"),
        (dict(orders=[4]), "whole numbers from 0 to 3, got 4"),
        (dict(orders=[True]), "whole numbers"),
        (dict(k=[1, 2]), "k must be 1 x 3, got 1 x 2"),
        (dict(orders=[]), "orders is empty; leave it out"),
        (dict(orders="1"), "whole numbers from 0 to 3, got '1'"),
        (dict(methods=[]), "methods is empty; leave it out"),
        (dict(k=[]), "k has no rows"),
        (dict(k={}), "k has no rows"),
        (dict(k={"a": [1, 2, 3], "b": [1]}), "k must be rows of 3 numbers each"),
        (dict(k=[np.nan, 0, 0]), r"k\[0, 0\] is nan"),
        (dict(k="speed"), "no estimate or state 'speed'; there are"),
        (dict(poles="fast"), "poles must be a list of numbers"),
        (dict(poles=[np.nan]), "poles must be a list of finite numbers"),
    ],
)
def test_questions_that_make_no_sense(options, message):
    with pytest.raises(ValueError, match=message):
        lb.compare(tracker(), **options)


def test_a_plant_is_asked_for():
    with pytest.raises(TypeError, match="plant must be a Plant, got an Observer"):
        lb.compare(lb.kalman_filter(tracker()))


# -- figures ------------------------------------------------------------------------


def test_numbers_are_those_of_the_library(table):
    plant = tracker()
    one = novak(table, (0,), "steady")
    observer = lb.reduced_order_filter(plant, [0], horizon="steady")
    np.testing.assert_array_equal(one.observer.V, observer.V)
    assert one.trace == np.trace(lb.error_covariance(observer, plant))
    np.testing.assert_array_equal(one.variances, np.diagonal(one.covariance))
    assert one.order == observer.order == 2
    assert one.work == lb.export.multiply_adds(observer)
    assert one.cond == lb.certify(observer, plant).cond
    assert one.certificate.worst == lb.certify(observer, plant).worst
    assert one.worst_pole == np.abs(observer.poles).max()


def test_fixed_order_filters_carry_their_optimality(smooth):
    one = smooth.find("fixed-order filter", order=2)
    assert one.optimality.worst < 1e-8 and one.sound and not one.exact
    assert one.optimality.cost == pytest.approx(one.trace, rel=1e-9)
    assert one.cond is None


@pytest.mark.parametrize("method", METHODS)
def test_work_is_that_of_the_exported_source(smooth, of_k, method, tmp_path):
    """Products and sums are counted in the text of the C, not by our own count."""
    table = of_k if method == "functional observer" else smooth
    assert table.find(method)
    for one in table.designs:
        if one.method == method:
            source, _ = to_c(one.observer, tmp_path)
            text = source.read_text().partition("_estimate(")[2].partition("#ifdef")[0]
            sums = re.findall(r"const double \w+ = ([^[;]+);", text)
            terms = sum(1 + s.count(" + ") + s.count(" - ") for s in sums)
            numbers = sum(s.count(" * ") for s in sums)
            assert one.work == terms == lb.export.multiply_adds(one.observer)
            assert one.bytes == 8 * (numbers + one.order)


def test_a_long_and_dense_observer_is_counted_as_loops():
    rng = np.random.default_rng(8)
    F = 0.1 * rng.standard_normal((20, 20)) / 20
    F[0, 0] = 0
    zero = np.zeros((20, 0))
    D, eye = rng.standard_normal((20, 1)), np.eye(20)
    observer = lb.Observer(F, zero, D, eye, 0 * D, eye, eye, dt=1.0)
    cost = step_cost(observer)
    assert cost.multiply_adds == 20 * 20 + 20  # F z and D y; P z is a copy
    assert lb.export.multiply_adds(observer) == cost.multiply_adds
    assert cost.bytes >= 8 * (20 + 20 * 20)


def test_rounding_is_not_work(table):
    """The best minimal observer takes no acceleration from the position: 0, not 1e-14.

    What is left: the next z and the acceleration, each from z and from the doppler.
    """
    best = novak(table, (0, 1), "steady")
    np.testing.assert_allclose(best.observer.V[2, 0], 0, atol=1e-10)
    assert best.work == lb.export.multiply_adds(best.observer) == 4


def test_noise_gain_is_what_v_alone_does(smooth):
    """A long simulation without w, of the exact ones; and by hand."""
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[4]])
    observer = lb.Observer([[0.5]], [[]], [[1]], [[0.5]], [[0.25]], [[1]], [[1]], dt=1)
    # V^2 R + P^2 X, X = D^2 R / (1 - F^2): the certificate plays no part
    by_hand = np.sqrt(0.25**2 * 4 + 0.5**2 * 4 / (1 - 0.25))
    assert noise_gain(observer, plant) == pytest.approx(by_hand, rel=1e-12)
    kalman = smooth.find("Kalman filter")
    assert kalman.noise_gain**2 < kalman.trace
    quiet = lb.Plant(stable().A, None, stable().C, dt=1.0)
    unit = lb.compare(quiet, methods="deadbeat observer").designs[0]
    same = smooth.find("deadbeat observer")
    assert unit.noise_gain * np.sqrt(0.1) == pytest.approx(same.noise_gain, rel=1e-9)


def test_kalman_filter_is_the_yardstick_and_nothing_beats_it(table, smooth):
    for one in (table, smooth):
        assert one.yardstick.method == "Kalman filter"
        assert one.excess(one.yardstick) == 0
        assert all(d.error >= one.yardstick.error * (1 - 1e-9) for d in one.ranked)


def test_best_constant_gain_is_never_worse(table):
    for accurate in [(0,), (1,), (0, 1)]:
        step, steady = (novak(table, accurate, h) for h in ("step", "steady"))
        assert steady.trace <= step.trace * (1 + 1e-9)


def test_the_same_every_time(table):
    again = lb.compare(tracker())
    assert again.rows() == table.rows() and repr(again) == repr(table)


# -- plants of other kinds ----------------------------------------------------------


def test_continuous_plant():
    A, C = [[0, 1], [-4, -1]], [[1, 0]]
    table = lb.compare(lb.Plant(A, [[0], [1]], C), k=[[0, 1], [1, 1]])
    assert [one.method for one in table.designs] == [
        *["reduced-order observer"] * 3,
        "functional observer",
    ]
    reduced = table.designs[1]
    # one Butterworth pole, three times as far out as the modes, |s| = 2
    assert reduced.worst_pole == pytest.approx(-6)
    assert reduced.label == "Butterworth poles, 3 times the rates of the plant"
    assert reduced.noise_gain is None is reduced.bytes and reduced.work > 0
    assert "dt = 0" in table.find("Kalman filter").refusal


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("dt", [0.0, 0.5])
def test_default_poles_lie_on_a_stable_circle(dt, count):
    rates = np.array([-0.5, -2.0, 0, -1])  # geometric mean 1, the one at rest left out
    A = np.diag(np.exp(rates * dt) if dt else rates)
    poles = np.array(butterworth(lb.Plant(A, None, np.ones((1, 4)), dt=dt), count))
    s = np.log(poles) / dt if dt else poles
    np.testing.assert_allclose(np.abs(s), 3, rtol=1e-9)
    assert (s.real < 0).all() and len(s) == count
    np.testing.assert_allclose(np.sort_complex(s), np.sort_complex(s.conj()))


def test_integrators_get_default_poles_too():
    plant = lb.Plant([[0, 1], [0, 0]], None, [[1, 0]])
    assert [one.worst_pole for one in lb.compare(plant).designs] == pytest.approx(
        [-1 / 3, -1, -10 / 3]
    )


def test_default_poles_are_those_of_the_best_minimal_filter(table):
    reduced, minimal = (
        table.find("reduced-order observer"),
        novak(table, (0, 1), "steady"),
    )
    np.testing.assert_allclose(reduced.observer.poles, minimal.observer.poles)
    assert reduced.label == "poles of the minimal-order filter"
    given = lb.compare(tracker(), poles=[0.25], methods="reduced-order observer")
    assert given.designs[0].worst_pole == 0.25
    assert given.designs[0].label == "poles as given"


NOISY = [(0.3 * np.eye(3), np.zeros((1, 3))), (np.zeros((3, 3)), [[0.5, 0, 0]])]


def test_multiplicative_noise_is_known_to_all():
    """Filters for the equivalent noise; errors on the plant itself, moments by hand."""
    plant = stable(multiplicative=NOISY)
    table = lb.compare(plant, methods=[*FILTERS, "fixed-order filter"])
    _, Q, S, R = equivalent_noise(plant)
    same = lb.compare(stable(Q=Q, R=R, S=S), methods=FILTERS)
    for one, other in zip(table, same):
        assert one.trace == pytest.approx(other.trace, rel=1e-9)
        assert one.noise_gain < other.noise_gain  # v without what C's noise adds
        assert "additive noise of the same" in one.note
    assert not table.refused
    assert "additive noise" in table.reasons(0)[2]


def test_multiplicative_noise_too_strong_is_a_refusal():
    plant = stable(multiplicative=[(np.eye(3), np.zeros((1, 3)))])
    with pytest.raises(lb.DesignError, match="not mean-square stable"):
        lb.compare(plant)
    silent = stable(Q=None, R=None, multiplicative=plant.multiplicative)
    assert lb.compare(silent, methods="deadbeat observer").designs[0].noise_gain > 0


def test_a_known_input_hides_errors_until_it_has_statistics():
    plant = stable(B=[[1], [0], [0]])
    asked = dict(methods=["Kalman filter", "fixed-order filter"], orders=[1, 3])
    quiet, driven = (lb.compare(one, **asked) for one in (stable(), plant))
    one = driven.find("fixed-order filter", order=1)
    assert one.disturbed and one.trace is None and "u = 0" in one.note
    assert one not in driven.eligible and one not in driven.pareto()
    assert quiet.recommended() is quiet.find("fixed-order filter", order=1)
    assert driven.recommended(tolerance=10).exact
    words = "Not weighed: 2 designs whose estimate the known input disturbs"
    assert words in " ".join(driven.reasons())
    assert "Not weighed" not in " ".join(quiet.reasons())
    told = lb.compare(plant.with_input([[4.0]]), **asked)
    one = told.find("fixed-order filter", order=1)
    assert one.disturbed and one.note == "" and one in told.eligible
    wanted = lb.error_covariance(one.observer, plant.with_input([[4.0]])).trace()
    assert one.trace == pytest.approx(wanted, rel=1e-9)
    alone = lb.compare(plant, methods="fixed-order filter", orders=[1])
    assert alone.yardstick is None and "with_input(U)" in " ".join(alone.reasons())


def test_one_functional_of_the_state(of_k):
    table = of_k
    flat = lb.compare(stable(), k=K[0], methods="Kalman filter")
    np.testing.assert_array_equal(flat.k, table.k)
    kalman, moore = table.find("Kalman filter"), table.find("functional observer")
    whole = lb.error_covariance(lb.kalman_filter(stable()), stable())
    by_hand = (K @ whole @ K.T).item()
    assert kalman.error_of_k == pytest.approx(by_hand, rel=1e-12)
    assert kalman.error == pytest.approx(1, rel=1e-12)
    assert moore.error == pytest.approx(np.sqrt(moore.covariance.item() / by_hand))
    assert moore.error_of_k == moore.covariance.item() and moore.trace is None
    observer = lb.functional_observer(stable(), K)
    assert moore.order == observer.order and not moore.observer.V.any()
    fixed = table.find("fixed-order filter", order=1)
    assert fixed.observer.P.shape == (1, 1) and fixed.label == "order 1 for k x"
    assert fixed.error >= 1 - 1e-9
    assert "standard deviation of k x" in table.reasons()[0]
    header = ["sigma of k x", "above the best", "worst pole"]
    assert table.table.header[3:6] == header


def test_the_error_of_k_x_is_a_deviation_as_the_percentage_beside_it_is_of_one():
    table = lb.compare(stable(), k={"speed (m/s)": K[0]})
    assert table.table.header[3:5] == ["sigma of speed (m/s)", "above the best"]
    best = np.sqrt(table.find("Kalman filter").error_of_k)
    seen = set()
    for cells in table.table.rows:
        sigma, above = float(cells[3]), float(cells[4].split()[0])
        seen.add(above)
        assert 100 * (sigma / best - 1) == pytest.approx(above, abs=0.02)
        same = [one for one in table.designs if one.label == cells[1]]
        assert any(sigma == pytest.approx(np.sqrt(one.error_of_k), rel=1e-4)
                   for one in same)  # fmt: skip
    assert len(seen) > 2


def test_every_method_is_counted_for_k_x_alone(of_k, smooth):
    """One row of P, V and W: fewer products, bytes and noise than for the state."""
    assert {one.observer.L.shape for one in of_k.designs} == {(1, 3)}
    for one in of_k.designs:
        if one.method == "functional observer" or one.optimality is not None:
            continue
        other = smooth.find(one.method, label=one.label)
        assert one.work < other.work and one.bytes < other.bytes
        if one.horizon != "steady":
            same = other.observer.combined(K)
            left = lb.error_covariance(same, stable()).item()
            assert one.error_of_k == pytest.approx(left, rel=1e-9)
        else:
            left = (K @ other.covariance @ K.T).item()
            assert one.error_of_k <= left * (1 + 1e-9)


def test_sizes_weigh_the_rows_of_k_x():
    k, scale = np.array([[1.0, -1, 0], [0, 0, 1]]), [1.0, 1e-3]
    table = lb.compare(stable(), k=k, scale=scale, methods=["Leondes-Novak filter"])
    weight = k.T @ np.diag([1, 1e6]) @ k
    for one in table.designs:
        if one.horizon == "steady":
            given = dict(weight=weight, horizon="steady", L=k)
            own = lb.reduced_order_filter(stable(), one.accurate, **given)
            left = lb.error_covariance(own, stable())
            np.testing.assert_allclose(one.covariance, left, rtol=1e-9)


def test_where_no_gain_is_best_for_k_x_that_for_the_state_is_tried():
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = [[0.9, 0.5], [-0.1, 0.8]], [[0.7, 0.3], [0, 0.6]]
    C = [[1, 0, 0.0, 0], [0, 0, 1, 1]]
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(4), R=np.diag([1.0, 2]))
    table = lb.compare(plant, k=[0, 1, 0, 1], methods="Leondes-Novak filter")
    one = table.find("Leondes-Novak filter", accurate=(1,), horizon="steady")
    assert "best one for the whole state" in one.note and one.error_of_k < 3.2


def test_without_k_the_functional_observer_says_what_it_lacks(table):
    assert "it needs k, the combination" in table.find("functional observer").refusal


def test_an_exact_fixed_order_filter_is_free_of_known_inputs():
    """Two outputs with one noise: the Kalman filter needs one state, and loses none."""
    plant = lb.Plant(
        [[0.9, 0.1], [0, 0.8]],
        [[0], [1]],
        [[1, 0], [1, 1]],
        Q=np.eye(2),
        R=np.ones((2, 2)),
        dt=1.0,
    )
    table = lb.compare(plant)
    one, held = (
        table.find("fixed-order filter", order=1, label=f"order 1{held}")
        for held in ("", ", V = 0")
    )
    assert one.exact and not one.disturbed and one.note == ""
    assert held.disturbed and "u = 0" in held.note
    assert one in table.eligible and held not in table.eligible
    assert table.recommended() is one
    said = " ".join(table.reasons())
    assert "u = 0" not in said and "not exact" not in said


@pytest.mark.parametrize(
    ("A", "q", "k", "error"),
    [
        ([[0.9, 0.1], [0, 0.8]], [0, 0], None, 0),
        ([[0.9, 0.1], [0, 0.8]], [1, 0], [0, 1], 0),
        ([[1.2, 0.1], [0, 0.8]], [0, 0], None, (1.44 - 1) / 1.44),
        ([[0.9, 0.0], [0, 0.8]], [1e-60, 0], None, 1e-60 / 0.19),
    ],
    ids=["nothing driven", "k x not driven", "grows undriven", "hardly driven"],
)
def test_what_nothing_drives_is_known_without_error(A, q, k, error):
    plant = lb.Plant(A, None, [[1.0, 0]], Q=np.diag(q), R=[[1.0]], dt=1.0)
    table = lb.compare(plant, k=k, methods=[*FILTERS, "deadbeat observer"])
    found = table.find("Kalman filter").judged.sum()
    assert found == 0 if error == 0 else found == pytest.approx(error, rel=0.3, abs=0)
    if error == 0:
        worst = table.find("deadbeat observer")
        assert worst.judged.sum() > 1 and table.excess(worst) == np.inf
        assert k or "is not zero, and that of the Kalman" in table.reasons()[-1]
        assert "unbounded" in repr(table)


def test_order_zero():
    """Every state measured: no poles, and a matrix product is all there is."""
    plant = lb.Plant([[0.5]], None, [[1.0]], Q=[[1.0]], R=[[0.0]], dt=1.0)
    table = lb.compare(plant)
    assert table.yardstick.trace == pytest.approx(0, abs=1e-15)
    assert table.recommended().order == 0 and table.recommended().work == 0
    assert table.recommended().worst_pole == 0
    json.dumps(table.rows(), allow_nan=False)
    for show in (repr, lambda one: one.reasons(), report.page):
        assert "nan" not in repr(show(table))
    still = lb.compare(lb.Plant([[-1.0]], None, [[1.0]]))
    (one,) = still.designs
    assert one.worst_pole == -np.inf and one.settling == 0
    assert still.rows()[still.attempts.index(one)]["worst_pole"] is None


ODD = {
    "complex": (
        lb.Plant([[0.5, 1], [0, 0.3j]], None, [[1, 0]], dt=1.0),
        [*["reduced-order observer"] * 3, "deadbeat observer"],
    ),
    "no outputs": (
        lb.Plant([[0.5]], None, np.zeros((0, 1)), dt=1.0, Q=[[1]], R=np.zeros((0, 0))),
        ["Kalman filter"],
    ),
    "feedthrough": (
        lb.Plant([[0.5]], [[1]], [[1]], [[2]], dt=1.0, Q=[[1]], R=[[1]]),
        [*FILTERS, FILTERS[1], "reduced-order observer", "deadbeat observer"],
    ),
}


@pytest.mark.parametrize(("plant", "methods"), ODD.values(), ids=ODD)
def test_odd_plants_get_what_applies(plant, methods):
    found = lb.compare(plant)
    assert [one.method for one in found.designs] == methods
    assert all(one.refusal for one in found.refused) and found.reasons()
    json.dumps(found.rows(), allow_nan=False)


# -- what to take -------------------------------------------------------------------


@pytest.mark.parametrize("by", ["work", "order", "settling"])
def test_front_falls_and_is_not_beaten(table, smooth, by):
    for one in (table, smooth):
        front = one.pareto(by=by)
        cost = [getattr(d, by) for d in front]
        assert cost == sorted(set(cost)) and len(front) >= 2
        for d in front:
            rivals = [r for r in one.ranked if getattr(r, by) <= getattr(d, by)]
            assert d.error <= min(r.error for r in rivals) * (1 + 1e-9)


def test_front_by_something_else_is_refused(table):
    with pytest.raises(ValueError, match="'order' or 'settling', got 'bytes'"):
        table.pareto(by="bytes")


def test_what_differs_by_rounding_is_equal():
    """With one output both have the same poles, so the same error: the first counts."""
    plant = stable()
    found = lb.compare(plant, methods=[FILTERS[1], "reduced-order observer"])
    steady, reduced = found.attempts[1:]
    assert steady.error == pytest.approx(reduced.error, rel=1e-9)
    for error in (0.5, 1 - 1e-12, 1 + 1e-12):
        other = dataclasses.replace(reduced, covariance=error * steady.covariance)
        both = dataclasses.replace(found, attempts=(steady, other))
        first = other if error == 0.5 else steady
        assert both.pareto() == [first] and both.pareto("order") == [first]
        assert both.recommended() is both.yardstick is first


@pytest.mark.parametrize("tolerance", [-0.1, np.nan])
def test_tolerances_that_no_design_meets(table, tolerance):
    with pytest.raises(ValueError, match="tolerance must not be negative"):
        table.recommended(tolerance)


def test_digits_that_rounding_spoils_are_not_shown():
    """Two sensors of almost the same: the deadbeat observer has cond about 1e11."""
    plant = tracker(R=np.diag([0.25, 4.0]))
    close = lb.Plant(
        plant.A, None, [[1, 0, 0], [1, 1e-11, 0]], dt=1.0, Q=plant.Q, R=plant.R
    )
    found = lb.compare(close, methods=["Kalman filter", "deadbeat observer"])
    _, badly = found.table.rows
    assert re.fullmatch(r"\d(\.\d{1,3})?e\+\d\d", badly[5])


@pytest.mark.parametrize(("tolerance", "order"), [(0, 3), (0.08, 3), (0.1, 2), (10, 1)])
def test_recommendation_follows_its_rule(table, tolerance, order):
    chosen = table.recommended(tolerance)
    assert chosen.order == order and table.excess(chosen) <= tolerance
    lighter = [one for one in table.designs if one.work < chosen.work]
    assert all(table.excess(one) > tolerance for one in lighter)


def test_recommendation_in_words(table):
    chosen, best = table.recommended(), table.yardstick
    text = report.page(table)
    title = "Leondes-Novak filter, radar taken as accurate, best constant gain, order 2"
    assert f"Recommended: {title}." in text
    assert "more than 10 % above that of the Kalman filter" in text
    assert f"{chosen.work} multiply-adds a step instead of {best.work}" in text
    assert "the standard deviation of position is 8.34 % above" in text
    assert "order 1: the standard deviation of velocity is 148.13 % above" in text
    assert "The trace adds variances of all units" in text
    assert "more than 1000 % above" in table.reasons(10)[0]
    assert "It is the most accurate design" in table.reasons(0)[1]


def test_what_is_not_exact_says_so(smooth):
    chosen = smooth.recommended(1.0)
    assert chosen.method == "fixed-order filter"
    assert any("It is not exact" in words for words in smooth.reasons(1.0))


def test_find_says_what_is_not_there(table):
    with pytest.raises(KeyError, match="no 'Kalman filter' with .*'order': 7"):
        table.find("Kalman filter", order=7)


# -- refusals -----------------------------------------------------------------------


def test_refused_design_is_listed_with_its_reason():
    """One output twice: both cannot be taken as accurate, the rest goes on."""
    plant = _with_outputs([[1, 0, 0], [1, 0, 0]])
    found = lb.compare(plant)
    both = [one for one in found.refused if one.accurate == (0, 1)]
    assert len(both) == 2 and all("radar" in one.refusal for one in both)
    assert "radar" in repr(found.refusals) and len(found.designs) == 7
    reduced = found.find("reduced-order observer")
    assert reduced.order == 2 and reduced.label.startswith("Butterworth poles")


def _with_outputs(C):
    plant = tracker()
    names = dict(state_names=plant.state_names, output_names=plant.output_names)
    return lb.Plant(plant.A, None, C, Q=plant.Q, R=plant.R, dt=1.0, **names)


def test_equal_reasons_are_told_once(table):
    rows = table.refusals.rows
    assert [row[:2] for row in rows] == [
        ["fixed-order filter", "order 1, and 3 more"],
        ["functional observer", "k x from the fewest states"],
    ]
    assert "for stable plants" in rows[0][2]


def test_every_design_refused_is_an_error():
    """Position is not measured: nothing certain can be said of it."""
    plant = _with_outputs([[0, 1, 0], [0, 0, 1]])
    with pytest.raises(lb.DesignError, match="no exact filter of any order.*detect"):
        lb.compare(plant)
    with pytest.raises(lb.DesignError, match="none has .0,. states"):
        lb.compare(tracker(), methods="Kalman filter", orders=[0])


@pytest.mark.parametrize(
    ("A", "why"),
    [(0.5 + 0.1j, "complex plant .* without noise"), ([[[0.5]]] * 3, "varies over")],
    ids=["complex with noise", "time-varying"],
)
def test_a_plant_that_no_table_is_for_is_refused_for_that(A, why):
    plant = lb.Plant(A if np.ndim(A) else [[A]], None, [[1]], Q=[[1]], R=[[1]], dt=1.0)
    with pytest.raises(lb.DesignError, match=why):
        lb.compare(plant)


def test_warnings_become_notes(recwarn):
    """Outputs that are all but one and the same: the estimate loses digits."""
    C = [[1, 0, 0], [1, 1e-11, 0]]
    plant = lb.Plant(tracker().A, None, C, dt=1.0)
    found = lb.compare(plant, methods="deadbeat observer")
    assert re.search(r"cond.* loses up to 1\d digits", found.designs[0].note)
    assert not recwarn.list


# -- what is shown ------------------------------------------------------------------


def test_rows_are_plain_and_complete(table, smooth):
    for one in (table, smooth, lb.compare(tracker(Q=None, R=None))):
        rows = one.rows()
        text = json.dumps(rows, allow_nan=False)
        assert json.loads(text) == rows and len(rows) == len(one)
        assert len({tuple(row) for row in rows}) == 1
        assert sum(row["recommended"] for row in rows) == (one.chosen is not None)
        assert sum(row["on_front"] for row in rows) == len(one.pareto())
    row = table.rows()[table.attempts.index(table.recommended())]
    assert row["accurate"] == ["radar"] and row["multiply_adds"] == 14
    assert row["error_trace"] == pytest.approx(sum(row["variances"]), rel=1e-12)


def test_table_marks_what_is_recommended(table):
    shown = table.table
    (marked,) = shown.marked
    assert table.designs[marked] is table.recommended()
    assert repr(table).startswith("method") and "why there is none" in repr(table)
    html = table._repr_html_()
    assert html.count("<table>") == 2 and html.count("<b>") == len(shown.header)


def test_transients_begin_at_P0_and_end_in_the_steady_state(table):
    curves, remarks = transients(table)
    assert len(curves) == 3 and "steps from P0" in remarks[0]
    for covariance in curves.values():
        np.testing.assert_array_equal(covariance[0], tracker().P0)
    constant = curves["recommended, constant gain"]
    steady = table.recommended().covariance
    np.testing.assert_allclose(constant[-1], steady, rtol=0.02)
    optimal = curves["Kalman filter"]
    assert (np.trace(constant - optimal, axis1=1, axis2=2) > -1e-12).all()


def test_transients_of_a_fixed_order_filter(smooth):
    shown = from_start({"one": smooth.find("fixed-order filter").observer}, stable())
    last = shown["one"][-1]
    np.testing.assert_allclose(last, smooth.find("fixed-order filter").covariance, 0.05)


@pytest.mark.parametrize(
    ("changes", "words"), [(dict(P0=None), "no P0"), (dict(Q=None), "Without noise")]
)
def test_transients_that_are_not_there_say_so(changes, words):
    curves, remarks = transients(lb.compare(tracker(**changes)))
    assert curves == {} and words in remarks[0]


def test_matrices_carry_names_and_leave_out_zeros(table):
    chosen = table.recommended()
    tables = [*report._matrices(chosen.observer, tracker())]
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
