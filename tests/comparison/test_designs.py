"""What a comparison tries: every method, every choice, and designs of one's own."""

import itertools
import re

import numpy as np
import pytest

import luenberger as lb
from luenberger.comparison import METHODS
from luenberger.comparison.designs import butterworth, choices, left_out

KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL = METHODS


def diagonal(n, p, **more):
    return lb.Plant(0.5 * np.eye(n), None, np.eye(n)[:p], dt=1.0, **more)


def tracker(**changes):
    given = dict(Q=np.diag([0, 0, 1.0]), R=np.diag([0.25, 4.0]), dt=1.0)
    A = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]]
    return lb.Plant(A, None, np.eye(2, 3), **given | changes)


def test_every_subset_is_tried_up_to_four_outputs_and_few_on_large_plants():
    assert len(choices(50, 4)) == 16 and choices(3, 0) == choices(60, 0) == [()]
    assert choices(50, 5) == [tuple(range(m1)) for m1 in range(6)]
    for p, sizes in (1, [0, 1]), (4, [0, 1, 2, 4]), (6, [0, 1, 2, 4, 6]):
        assert choices(51, p) == [tuple(range(m1)) for m1 in sizes]


@pytest.mark.parametrize(
    ("n", "p", "filters", "fixed"),
    [(50, 4, 30, 3), (51, 4, 6, 3), (200, 1, 2, 0), (101, 5, 8, 0), (100, 5, 8, 3),
     (9, 5, 10, 3), (5, 1, 2, 6), (3, 1, 2, 4), (6, 1, 2, 3)],
)  # fmt: skip
def test_what_is_tried_of_a_plant_of_a_size(n, p, filters, fixed):
    found = lb.candidates(diagonal(n, p), methods=[NOVAK, FIXED])
    methods = [one.method for one in found.values()]
    assert methods.count(NOVAK) == filters and methods.count(FIXED) == fixed
    said = [*left_out(diagonal(n, p))]
    assert any("other outputs" in one for one in said) == (filters < 2 * (2**p - 1))
    assert any("V = 0" in one for one in said) == (n > 5)


def test_orders_that_are_asked_for_are_there_however_large_the_plant():
    methods = [KALMAN, NOVAK, FIXED]
    found = lb.candidates(diagonal(101, 1), orders=[7, 100], methods=methods)
    assert [one.order for one in found.values()] == [100, 100, 7, 100]
    one = lb.candidates(diagonal(4, 1), orders=2, methods=FIXED)
    assert [*one] == [
        "fixed-order filter, order 2",
        "fixed-order filter, order 2, V = 0",
    ]


def test_every_method_is_listed_in_order_and_every_subset_with_both_gains():
    found = [*lb.candidates(tracker()).values()]
    assert [*dict.fromkeys(one.method for one in found)] == [*METHODS]
    listed = [(one.accurate, one.horizon) for one in found if one.method == NOVAK]
    subsets = itertools.product([(0,), (1,), (0, 1)], ["step", "steady"])
    assert listed == [*subsets]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(methods=["Kalman"]), "no method 'Kalman'; there are .*deadbeat"),
        (dict(methods=[]), "none is named; there are"),
        (dict(orders=[4]), "whole numbers from 0 to 3, got 4"),
        (dict(orders=[True]), "whole numbers"),
        (dict(orders=[]), "orders is empty; leave it out"),
        (dict(orders="1"), "whole numbers from 0 to 3, got '1'"),
        (dict(poles="fast"), "poles must be a list of numbers"),
        (dict(poles=[np.nan]), "poles must be a list of finite numbers"),
    ],
)
def test_candidates_that_there_are_not(options, message):
    with pytest.raises(ValueError, match=message):
        lb.candidates(tracker(), **options)


# -- poles where no noise says how fast -----------------------------------------------


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


def test_without_noise_several_speeds_are_tried():
    A, C = [[0, 1], [-4, -1]], [[1, 0]]
    table = lb.compare(lb.Plant(A, [[0], [1]], C), L=[[0, 1], [1, 1]])
    assert [one.method for one in table.designs] == [REDUCED] * 3 + [FUNCTIONAL]
    one, three, ten = table.designs[:3]
    # one Butterworth pole, so many times as far out as the modes, |s| = 2
    assert [d.worst_pole for d in (one, three, ten)] == pytest.approx([-2, -6, -20])
    assert one.label == "Butterworth poles at the rates of the plant"
    assert three.label == "Butterworth poles, 3 times the rates of the plant"
    assert three.noise_gain is None is three.bytes and three.work > 0
    assert "dt = 0" in table.find(KALMAN).refusal
    rest = lb.compare(lb.Plant([[0, 1], [0, 0]], None, C))
    assert [d.worst_pole for d in rest.designs] == pytest.approx([-1 / 3, -1, -10 / 3])


def test_default_poles_are_those_of_the_best_minimal_filter():
    table = lb.compare(tracker())
    reduced = table.find(REDUCED)
    minimal = table.find(NOVAK, accurate=(0, 1), horizon="steady")
    np.testing.assert_allclose(reduced.observer.poles, minimal.observer.poles)
    assert reduced.label == "poles of the minimal-order filter"
    given = lb.candidates(tracker(), poles=[0.25], methods=REDUCED)
    (one,) = lb.compare(tracker(), given).designs
    assert one.worst_pole == 0.25 and one.label == "poles as given"


# -- what is designed -----------------------------------------------------------------


def test_without_L_the_functional_observer_says_what_it_lacks():
    assert (
        "it needs L, the combinations" in lb.compare(tracker()).find(FUNCTIONAL).refusal
    )


def test_where_no_gain_is_best_for_L_x_that_for_the_state_is_tried():
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = [[0.9, 0.5], [-0.1, 0.8]], [[0.7, 0.3], [0, 0.6]]
    C = [[1, 0, 0.0, 0], [0, 0, 1, 1]]
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(4), R=np.diag([1.0, 2]))
    table = lb.compare(plant, lb.candidates(plant, methods=NOVAK), L=[0, 1, 0, 1])
    one = table.find(NOVAK, accurate=(1,), horizon="steady")
    assert "best one for the whole state" in one.note and one.trace < 3.2


def test_sizes_weigh_the_rows_of_L_x():
    A = [[0.8, 0.2, 0], [0, 0.6, 0.3], [0.1, 0, 0.5]]
    plant = lb.Plant(
        A, None, [[1, 0, 0]], dt=1.0, Q=np.diag([1.0, 0.5, 0.2]), R=[[0.1]]
    )
    L, scale = np.array([[1.0, -1, 0], [0, 0, 1]]), [1.0, 1e-3]
    table = lb.compare(plant, lb.candidates(plant, methods=NOVAK), L=L, scale=scale)
    given = dict(weight=L.T @ np.diag([1, 1e6]) @ L, horizon="steady", L=L)
    (one,) = [one for one in table.designs if one.horizon == "steady"]
    own = lb.reduced_order_filter(plant, one.accurate, **given)
    left = lb.error_covariance(own, plant)
    np.testing.assert_allclose(one.covariance, left, rtol=1e-9)


NOISY = [(0.3 * np.eye(3), np.zeros((1, 3))), (np.zeros((3, 3)), [[0.5, 0, 0]])]


def test_multiplicative_noise_is_known_to_all():
    """Filters for the equivalent noise; errors on the plant itself, moments by hand."""
    from luenberger.analysis.mean_square import equivalent_noise

    A = [[0.8, 0.2, 0], [0, 0.6, 0.3], [0.1, 0, 0.5]]
    given = dict(dt=1.0, Q=np.diag([1.0, 0.5, 0.2]), R=[[0.1]])
    plant = lb.Plant(A, None, [[1, 0, 0]], **given, multiplicative=NOISY)
    table = lb.compare(plant, lb.candidates(plant, methods=[KALMAN, NOVAK, FIXED]))
    _, Q, S, R = equivalent_noise(plant)
    plain = lb.Plant(A, None, [[1, 0, 0]], dt=1.0, Q=Q, R=R, S=S)
    same = lb.compare(plain, lb.candidates(plain, methods=[KALMAN, NOVAK]))
    for one, other in zip(table, same):
        assert one.trace == pytest.approx(other.trace, rel=1e-9)
        assert one.noise_gain < other.noise_gain  # v without what C's noise adds
        assert "additive noise of the same" in one.note
    assert not table.refused and "additive noise" in " ".join(table.reasons(0))
    strong = [(np.eye(3), np.zeros((1, 3)))]
    plant = lb.Plant(A, None, [[1, 0, 0]], **given, multiplicative=strong)
    with pytest.raises(lb.DesignError, match="not mean-square stable"):
        lb.compare(plant)


# -- designs of one's own -------------------------------------------------------------


def test_observers_and_functions_are_designs_by_name():
    plant = tracker()
    kalman = lb.kalman_filter(plant)
    mine = {"made": kalman, "function": lb.kalman_filter, "raw": lb.deadbeat_observer}
    found = lb.compare(plant, mine)
    assert [one.title for one in found] == ["made, order 3", "function, order 3",
                                            "raw, order 1"]  # fmt: skip
    assert found.find("made").observer is kalman
    assert found.find("function").error == 1 < found.find("raw").error
    assert "which" not in found.table.header and "Kalman filter" in found.reasons()[0]
    assert [one.name for one in lb.compare(plant, [kalman])] == ["design 1"]
    later = {"later": lambda plant: lb.functional_observer(plant, [0, 0, 1])}
    one = lb.compare(plant, later | {"all": kalman}, L=[0, 0, 1])
    assert one.find("all").covariance.shape == one.find("later").covariance.shape


def refuses(plant):
    raise lb.DesignError("not today")


WRONG = {
    "one alone": (lb.kalman_filter(tracker()), r"one observer alone; give a list"),
    "a number": (3, "must be a dict, by name"),
    "nothing": ({}, "designs is empty"),
    "no design": ({"it": 3}, "'it' must be an Observer or a function"),
    "no observer": ({"it": lambda plant: 3}, "'it' must return an Observer, got 3"),
    "over time": (
        {"it": lb.kalman_filter(tracker(P0=np.eye(3)), steps=3)},
        "'it' varies over time",
    ),
    "unlike ones": (
        {"x": lb.kalman_filter(tracker()),
         "L x": lb.kalman_filter(tracker(), L=[1, 0, 0])},
        "'L x' estimates other combinations.*L=",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("designs", "message"), WRONG.values(), ids=WRONG)
def test_what_is_no_design_is_refused(designs, message):
    with pytest.raises((ValueError, TypeError), match=message):
        lb.compare(tracker(), designs)


def test_own_designs_that_are_refused_are_listed():
    """So that a sweep over plants goes on."""
    other = lb.kalman_filter(diagonal(1, 1, Q=[[1]], R=[[1]]))
    found = lb.compare(tracker(), {"it": refuses, "other": other})
    assert [one.refusal for one in found] == [
        "not today",
        "it is of a plant with 1 states, not 3",
    ]
    assert found.designs == [] and found.chosen is None is found.yardstick
    assert found.reasons() == ["Nothing is recommended: every design is refused."]
    assert len(found.to_rows()) == 2 and "not today" in repr(found)


def test_a_fault_in_a_design_ends_the_comparison():
    def broken(plant):
        raise ZeroDivisionError("in the design itself")

    with pytest.raises(ZeroDivisionError, match="in the design"):
        lb.compare(tracker(), {"bad": broken})


def test_refused_designs_are_listed_with_their_reasons():
    """One output twice: both cannot be taken as accurate, the rest goes on."""
    plant = lb.Plant(tracker().A, None, [[1, 0, 0], [1, 0, 0]], dt=1.0,
                     Q=np.diag([0, 0, 1.0]), R=np.eye(2),
                     output_names=["radar", "doppler"])  # fmt: skip
    found = lb.compare(plant)
    both = [one for one in found.refused if one.accurate == (0, 1)]
    assert len(both) == 2 and all("radar" in one.refusal for one in both)
    reduced = found.find(REDUCED)
    assert reduced.order == 2 and reduced.label.startswith("Butterworth poles, 3")
    rows = [row[:2] for row in found.refusals.rows]
    assert [FIXED, "order 1, and 3 more"] in rows
    assert len(found) == len(found.designs) + len(found.refused)


def test_warnings_become_notes(recwarn):
    """Outputs that are all but one and the same: the estimate loses digits."""
    plant = lb.Plant(tracker().A, None, [[1, 0, 0], [1, 1e-11, 0]], dt=1.0)
    found = lb.compare(plant, lb.candidates(plant, methods=DEADBEAT))
    assert re.search(r"cond\(\[T; C\]\) = 2\.\de\+11.* digits", found.designs[0].note)
    assert not recwarn.list


@pytest.mark.parametrize(
    ("A", "why"),
    [(0.5 + 0.1j, "complex plant .* without noise"), ([[[0.5]]] * 3, "varies over")],
    ids=["complex with noise", "time-varying"],
)
def test_a_plant_that_no_table_is_for_is_refused_for_that(A, why):
    plant = lb.Plant(A if np.ndim(A) else [[A]], None, [[1]], Q=[[1]], R=[[1]], dt=1.0)
    with pytest.raises(lb.DesignError, match=why):
        lb.compare(plant)


def test_every_design_refused_is_an_error():
    """Position is not measured: nothing certain can be said of it."""
    plant = tracker()
    blind = lb.Plant(
        plant.A, None, [[0, 1, 0], [0, 0, 1]], dt=1.0, Q=plant.Q, R=plant.R
    )
    with pytest.raises(lb.DesignError, match="no design exists.*detect"):
        lb.compare(blind)
    with pytest.raises(TypeError, match="plant must be a Plant, got an Observer"):
        lb.compare(lb.kalman_filter(plant))
