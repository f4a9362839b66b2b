"""Designs on plants that differ from their own: errors, spread, worst case, choice."""

import dataclasses
from fractions import Fraction as F

import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.compare.cases import UNKNOWN

NOMINAL = {"A[0,0]": (0.5, 0.9)}


def scalar(a, b=None, Q=1.0, R=1.0, **more):
    B = None if b is None else [[b]]
    return lb.Plant([[a]], B, [[1]], dt=1.0, Q=[[Q]], R=[[R]], **more)


def filters(*shares, **more):
    return {f"a = {a}": lb.kalman_filter(scalar(a, **more)) for a in shares}


def oscillator(damping):
    return lb.Plant(
        [[0, 1], [-25, -damping]], None, [[1, 0]], Q=np.diag([1e-6, 0.02]), R=[[0.01]]
    )


def exact_error(believed, k, a, q, r):
    """E[e e] of est+ = b (1 - k) est + k y on x+ = a x + w, y = x + v, in fractions."""
    b, k, a, q, r = map(F, (believed, k, a, q, r))
    X = q / (1 - a * a)
    f, g = (1 - k) * b, (1 - k) * (b - a)  # e+ = f e + g x - (1 - k) w + k v
    Y = (g * a * X - (1 - k) * q) / (1 - f * a)  # E[e x]
    driven = g * g * X + 2 * f * g * Y + (1 - k) ** 2 * q + k * k * r
    return driven / (1 - f * f)


@pytest.mark.parametrize("Q, R", [(1.0, 1.0), (1.0, 0.0), (0.25, 2.0), (0.0, 1.0)])
def test_errors_of_scalar_filters_are_those_of_exact_arithmetic(Q, R):
    designs = filters(0.5, 0.75, Q=Q, R=R)
    plants = {str(a): scalar(a, Q=Q, R=R) for a in (0.5, 0.625, 0.75)}
    found = lb.robustness(designs, plants)
    for spread in found:
        for one in spread.cases:
            k, believed = spread.observer.V[0, 0], float(one.design[4:])
            exact = exact_error(believed, k, float(one.plant), Q, R)
            assert one.covariance[0, 0] == pytest.approx(float(exact), abs=1e-15)
            own = lb.kalman_filter(plants[one.plant]).V[0, 0]
            least = exact_error(float(one.plant), own, float(one.plant), Q, R)
            ratio = np.sqrt(float(exact / least)) if least > 1e-12 else 1.0
            assert one.error == pytest.approx(float(ratio), rel=1e-12)


def test_errors_are_those_of_design_and_plant_side_by_side():
    """The covariance of (x, z) from one Lyapunov equation, and Kalman filters' own."""
    designs = {s: lb.kalman_filter(oscillator(s).sampled(0.05)) for s in (0.35, 0.65)}
    ranges = {"A[1,1]": "30 %"}
    found = lb.robustness(designs, oscillator(0.5), ranges=ranges, samples=4)
    assert len(found.plants) == 7
    for spread in found:
        o = spread.observer
        for one, at in zip(spread.cases, found.plants, strict=True):
            plant = oscillator(-one.values["A[1,1]"]).sampled(0.05)
            np.testing.assert_allclose(at.plant.A, plant.A, rtol=1e-13)
            n = plant.n
            moves = np.block([[plant.A, np.zeros((n, n))], [o.D @ plant.C, o.F]])
            drives = scipy.linalg.block_diag(plant.Q, o.D @ plant.R @ o.D.T)
            X = scipy.linalg.solve_discrete_lyapunov(moves, drives)
            rows = np.hstack([o.V @ plant.C - o.L, o.P])
            error = rows @ X @ rows.T + o.V @ plant.R @ o.V.T
            np.testing.assert_allclose(one.covariance, error, rtol=1e-8, atol=1e-12)
            own = lb.error_covariance(lb.kalman_filter(plant), plant)
            ratios = np.sqrt(error.diagonal() / own.diagonal())
            assert one.error == pytest.approx(ratios.max(), rel=1e-7)
            np.testing.assert_allclose(one.sigma**2, error.diagonal(), rtol=1e-8)


# -- which plants


def test_ranges_are_the_nominal_plant_corners_and_draws():
    nominal = oscillator(0.5).sampled(0.05)
    ranges = {"A[1,1]": "0.5 %", "A[0,1]": (0.046, 0.048)}
    designs = [lb.kalman_filter(nominal)]
    found = lb.robustness(designs, nominal, ranges=ranges, samples=7, seed=3)
    middle = nominal.A[1, 1]
    low, high = middle - abs(middle) * 0.5 / 100, middle + abs(middle) * 0.5 / 100
    names = [one.name for one in found.plants]
    assert names[0] == "nominal" and len(set(names)) == 1 + 4 + 7
    corners = [tuple(one.values.values()) for one in found.plants[1:5]]
    assert corners == [(low, 0.046), (low, 0.048), (high, 0.046), (high, 0.048)]
    assert [one.drawn for one in found.plants] == 5 * [False] + 7 * [True]
    for one in found.plants:
        assert one.plant.A[1, 1] == one.values["A[1,1]"]
        assert one.plant.A[0, 1] == one.values["A[0,1]"]
        assert one.plant.A[1, 0] == nominal.A[1, 0]
    drawn = np.array([list(one.values.values()) for one in found.plants[5:]])
    assert ((drawn > (low, 0.046)) & (drawn < (high, 0.048))).all()
    again = lb.robustness(designs, nominal, ranges=ranges, samples=7, seed=3)
    other = lb.robustness(designs, nominal, ranges=ranges, samples=7, seed=4)
    assert (again.errors == found.errors).all()
    assert (other.errors[:, :5] == found.errors[:, :5]).all()
    assert (other.errors[:, 5:] != found.errors[:, 5:]).all()


def test_a_percentage_of_a_negative_entry_rises():
    found = lb.robustness(
        filters(-0.7), scalar(-0.5), ranges={"A[0,0]": "±20%"}, samples=0
    )
    values = [one.values["A[0,0]"] for one in found.plants]
    np.testing.assert_allclose(values, [-0.5, -0.6, -0.4])


def test_a_function_makes_plants_of_its_parameters():
    def made(theta):
        return oscillator(2 * theta[0] * theta[1])

    bounds = {"ratio": (0.04, 0.06), "rate": (4.5, 5.5)}
    designs = {"one": lb.kalman_filter(oscillator(0.5).sampled(0.05))}
    found = lb.robustness(designs, oscillator(0.5), ranges=(made, bounds), samples=3)
    assert len(found.plants) == 1 + 4 + 3
    for one in found.plants[1:]:
        wanted = made(np.array(list(one.values.values()))).sampled(0.05)
        np.testing.assert_array_equal(one.plant.A, wanted.A)
    assert not found.plants[0].values


def test_continuous_plants_are_sampled_as_the_designs_are():
    designs = {"one": lb.kalman_filter(oscillator(0.5).sampled(0.05))}
    given = {"a": oscillator(0.4), "b": oscillator(0.6)}
    sampled = {name: plant.sampled(0.05) for name, plant in given.items()}
    one, other = (lb.robustness(designs, plants) for plants in (given, sampled))
    assert (one.errors == other.errors).all()


def test_plants_of_a_list_have_names():
    plants = [scalar(0.5), scalar(0.6, name="warm")]
    found = lb.robustness(list(filters(0.5).values()), plants)
    assert [one.name for one in found.plants] == ["plant 1", "warm"]
    assert [one.name for one in found] == ["design 1"]
    assert found.find("design 1", "warm").error > 1
    with pytest.raises(KeyError, match="cold"):
        found.find("design 1", "cold")


BAD = {
    "a plant alone": (dict(plants=scalar(0.5)), "ranges="),
    "no plants": (dict(plants=[]), "empty"),
    "no list": (dict(plants=3), "dict or a list"),
    "two of a name": (dict(plants=2 * [scalar(0.5, name="a")]), "two plants have one"),
    "of other size": (dict(plants={"x": oscillator(1).sampled(1)}), "plant 'x': "),
    "of another period": (
        dict(plants={"x": dataclasses.replace(scalar(0.5), dt=2.0)}),
        "plant 'x': .*dt",
    ),
    "without noise": (
        dict(plants={"x": lb.Plant([[0.5]], None, [[1]], dt=1.0)}),
        "plant 'x': it needs both .* Q and R; lb.fit_noise",
    ),
    "no entry": (dict(ranges={"Q[0,0]": (1, 2)}), r"'Q\[0,0\]'.* cannot be varied"),
    "no such entry": (dict(ranges={"A[0,3]": (1, 2)}), r"no A\[0,3\]: A is 1 x 1"),
    "no ranges": (dict(ranges={}), "ranges must be"),
    "a number": (dict(ranges={"A[0,0]": 0.3}), r"must be \(low, high\).*got 0.3"),
    "falling": (dict(ranges={"A[0,0]": (0.9, 0.5)}), "rise from low to high"),
    "not finite": (dict(ranges={"A[0,0]": (0.5, np.nan)}), "rise from low to high"),
    "no percentage": (dict(ranges={"A[0,0]": "0.3"}), "'30 %' of the nominal"),
    "nothing": (dict(ranges={"A[0,0]": "0 %"}), "'30 %' of the nominal"),
    "of zero": (
        dict(plants=scalar(0.0), ranges={"A[0,0]": "30 %"}),
        r"A\[0,0\] is 0 in the nominal plant",
    ),
    "of a function": (
        dict(ranges=(lambda x: scalar(x[0]), {"a": "30 %"})),
        "has no nominal value",
    ),
    "samples": (dict(ranges=NOMINAL, samples=-1), "samples must be a whole number"),
    "seed": (dict(ranges=NOMINAL, seed=0.5), "seed must be a whole number"),
    "scale": (dict(ranges=NOMINAL, scale=[0.0]), "scale"),
    "over time": (
        dict(observers={"it": lb.kalman_filter(scalar(0.5, P0=[[1]]), steps=3)}),
        "design 'it' varies over time",
    ),
    "no design": (dict(observers={}), "observers is empty"),
    "an observer alone": (
        dict(observers=lb.kalman_filter(scalar(0.5))),
        r"one observer alone; give a list, \[observer\]",
    ),
    "no observer": (dict(observers={"it": scalar(0.5)}), r"observers\['it'\]"),
}


@pytest.mark.parametrize("more, match", BAD.values(), ids=BAD)
def test_what_is_no_question_is_refused(more, match):
    given = dict(observers=filters(0.5), plants=scalar(0.5)) | more
    if not {"plants", "ranges"} & set(more):
        given["ranges"] = NOMINAL
    if "U" in more:
        given["observers"] = {"it": lb.kalman_filter(more["plants"][0])}
    with pytest.raises(ValueError, match=match):
        lb.robustness(**given)


# -- spread, worst case, choice


@pytest.fixture(scope="module")
def found():
    return lb.robustness(filters(0.5, 0.7, 0.9), scalar(0.7), ranges=NOMINAL)


def test_the_spread_is_of_plants_that_were_drawn_and_its_ends_of_all(found):
    for spread in found:
        errors = np.array([one.error for one in spread.cases])
        low, *middle, high = spread.quartiles
        assert (low, high) == (errors.min(), errors.max())
        drawn = np.sort(errors[3:])
        assert middle == [drawn[24], drawn[49], drawn[74]]  # of 100
        assert spread.worst is spread.cases[int(errors.argmax())]
        assert found.worst[spread.name] is spread.worst
        assert spread.nominal.plant == "nominal"
    assert found.errors.shape == (3, 103)
    listed = lb.robustness(filters(0.5), [scalar(a) for a in (0.5, 0.6, 0.7)])
    np.testing.assert_array_equal(listed.spreads[0].quartiles[2], listed.errors[0, 1])


def test_the_minimax_choice_is_the_least_of_the_largest_errors(found):
    largest = found.errors.max(axis=1)
    chosen = found.recommended()
    assert chosen is found.chosen is found.ranked[0]
    assert chosen is found.spreads[int(largest.argmin())]
    assert chosen.name != "a = 0.7"  # a pole nearer to 1 is the safer one
    said = found.reasons()
    assert "103 plants: the nominal one, 2 corners" in said[0] and "seed 0" in said[0]
    assert f"The worst case of {chosen.name} is the least" in said[1]
    assert "On the nominal plant a = 0.7 is the most accurate: 0.00 %" in said[2]
    assert "The worst case of a = 0.7 is" in said[3]


def test_among_equal_worst_cases_the_least_work_is_taken():
    plant = oscillator(0.5).sampled(0.05)
    light = lb.kalman_filter(plant)
    S, o = np.array([[1.0, 0.5], [0.25, 1.0]]), light
    turned = dict(F=S @ o.F @ np.linalg.inv(S), D=S @ o.D, P=o.P @ np.linalg.inv(S))
    heavy = dataclasses.replace(o, **turned, T=S @ o.T)
    assert lb.export.multiply_adds(light) < lb.export.multiply_adds(heavy)
    found = lb.robustness({"heavy": heavy, "light": light}, {"a": plant})
    assert found.recommended().name == "light"
    raw = {"raw": lb.deadbeat_observer(scalar(0.5))}
    near = lb.robustness(filters(0.5, 0.6) | raw, [scalar(0.5), scalar(0.6)])
    assert near.recommended().name != "raw" == near.recommended(tolerance=1.0).name
    with pytest.raises(ValueError, match="tolerance"):
        near.recommended(-1)


def test_an_error_that_grows_is_said_by_name():
    plants = {str(a): scalar(a) for a in (0.5, 0.9, 1.1)}
    found = lb.robustness(filters(0.5, 1.1), plants)
    first = found.spreads[0]
    assert [one.plant for one in first.growing] == [
        "1.1"
    ] and first.worst.error == np.inf
    assert "mode 1.1 on or outside" in first.worst.refusal
    assert "Give steps" not in first.worst.refusal
    assert first.worst.covariance is None and np.isfinite(first.quartiles[:3]).all()
    assert found.find("a = 1.1", "1.1").error == pytest.approx(1.0)
    assert found.recommended().name == "a = 1.1"
    said = " ".join(found.reasons())
    assert "The error of a = 0.5 grows on 1 plant, such as 1.1: no steady state" in said
    assert found.rows()[2]["error"] is None and "mode 1.1" in found.rows()[2]["refusal"]
    none = lb.robustness(filters(0.5), plants)
    assert none.chosen is None
    assert "no design is safe on every plant" in " ".join(none.reasons())
    with pytest.raises(lb.DesignError, match="a = 0.5 on 1.1, no steady state"):
        none.recommended()


def test_where_no_kalman_filter_is_the_most_accurate_design_is_the_measure():
    """Two states, the second unseen and at rest on the circle: no steady filter."""
    given = dict(dt=1.0, Q=np.diag([1.0, 1.0]), R=[[1.0]])
    deaf = lb.Plant(np.diag([0.5, 1.0]), None, [[1, 0]], **given)
    with pytest.raises(lb.DesignError):
        lb.kalman_filter(deaf)
    made = [
        lb.Observer([[0.5 * (1 - k)]], [[]], [[0.5 * (1 - k) * k]], [[1.0]], [[k]],
                    T=[[1 - k, 0]], L=[[1, 0]], dt=1.0)
        for k in (0.4, 0.6)
    ]  # fmt: skip
    found = lb.robustness(made, {"deaf": deaf})
    assert found.errors.min() == 1 < found.errors.max() < 1.2


# -- the known input


def test_where_the_input_disturbs_an_estimate_its_level_must_be_known():
    driven = {f"{b}": scalar(0.5, b) for b in (1.0, 1.1)}
    designs = {
        "filter": lb.kalman_filter(driven["1.0"]),
        "raw": lb.deadbeat_observer(driven["1.0"]),
    }
    found = lb.robustness(designs, driven)
    assert found.find("filter", "1.1").refusal == UNKNOWN
    assert found.find("filter", "1.1").error is None
    assert found.find("filter", "1.0").error == pytest.approx(1)
    assert found.spreads[0].worst is found.spreads[0].quartiles is None
    assert found.recommended().name == "raw"
    assert "Not weighed: filter" in " ".join(found.reasons())
    assert np.isnan(found.errors[0, 1])
    told = {name: one.with_input([2.0]) for name, one in driven.items()}
    told = lb.robustness(designs, told)
    one = told.find("filter", "1.1")
    F, V = designs["filter"].F[0, 0], designs["filter"].V[0, 0]
    bias = -(1 - V) * 0.1 * 2.0 / (1 - F)
    assert one.bias == pytest.approx(bias)
    spread = lb.error_covariance(designs["filter"], driven["1.0"])[0, 0]
    assert one.covariance[0, 0] == pytest.approx(bias**2 + spread)


# -- what is judged, and how it shows


def test_a_comparison_brings_its_designs_and_its_question():
    plant = oscillator(0.5).sampled(0.05)
    table = lb.compare(plant, k=[0, 1], methods=["Kalman filter", "fixed-order filter"])
    found = lb.robustness(table, oscillator(0.5), ranges={"A[1,1]": "30 %"}, samples=0)
    assert [one.name for one in found] == [one.title for one in table.designs]
    assert [one.work for one in found] == [one.work for one in table.designs]
    for spread, one in zip(found, table.designs, strict=True):
        assert spread.nominal.covariance[0, 0] == pytest.approx(one.error_of_k)
        assert spread.nominal.error == pytest.approx(one.worst_ratio)
    scaled = lb.compare(plant, scale=[1, 10], methods=["Kalman filter"])
    found = lb.robustness(scaled, oscillator(0.5), ranges={"A[1,1]": "30 %"}, samples=0)
    assert found.spreads[0].nominal.error == pytest.approx(scaled.yardstick.error)
    assert "in the given scale" in " ".join(found.reasons())


def test_designs_of_unlike_questions_are_refused():
    plant = oscillator(0.5).sampled(0.05)
    given = [lb.kalman_filter(plant), lb.functional_observer(plant, [[0, 1]])]
    with pytest.raises(ValueError, match="'design 2' has another L.*k="):
        lb.robustness(given, [plant])
    of_k = lb.robustness(given, [plant], k=[0, 1])
    assert len(of_k) == 2
    wanted = lb.error_covariance(given[0], plant)[1, 1]
    assert of_k.ranked[0].cases[0].covariance[0, 0] == pytest.approx(wanted)
    with pytest.raises(ValueError, match="'design 2' has another L: .* x or k x"):
        lb.robustness(given, [plant], k=[1, 0])


@pytest.fixture
def named():
    """A plant whose states have names, an estimate of its own, and its filter."""
    names = dict(state_names=["place (m)", "speed (m/s)"])
    pull = dict(estimates={"pull (N)": [25, 0.5]})
    plant = dataclasses.replace(oscillator(0.5), **names, **pull).sampled(0.05)
    return plant, lb.kalman_filter(plant)


@pytest.mark.parametrize(
    "k, rows, called",
    [
        ("speed (m/s)", [[0, 1]], ("speed (m/s)",)),
        ("pull (N)", [[25, 0.5]], ("pull (N)",)),
        (["pull (N)", "place (m)"], [[25, 0.5], [1, 0]], ("pull (N)", "place (m)")),
        ({"twice (m)": [2, 0]}, [[2, 0]], ("twice (m)",)),
        ([1, 1], [[1, 1]], ("row 1 of k x",)),
        (None, np.eye(2), ("place (m)", "speed (m/s)")),
    ],
    ids=["a state", "an estimate", "both", "by name", "a row", "the state"],
)
def test_what_is_judged_is_named_as_elsewhere(named, k, rows, called):
    plant, design = named
    others = {str(s): oscillator(s).sampled(0.05) for s in (0.4, 0.6)}
    given = {"first": plant} | others  # names are those of the first
    found = lb.robustness({"it": design}, given, k=k)
    assert found.estimates == called and found.whole == (k is None)
    Sigma = lb.error_covariance(design, others["0.6"])
    rows = np.array(rows)
    wanted = rows @ Sigma @ rows.T
    np.testing.assert_allclose(found.find("it", "0.6").covariance, wanted, rtol=1e-12)
    said = " ".join(found.reasons())
    if len(called) == 1:
        assert f"the standard deviation of {called[0]} is " in said
    else:
        assert ("no state has" if k is None else "no estimate has") in said


def test_names_come_from_designs_and_comparisons(named):
    plant, design = named
    torque = design.combined({"torque (Nm)": [3, 0]})
    assert lb.robustness([torque], [plant]).estimates == ("torque (Nm)",)
    assert lb.robustness([design], [plant], k=[3, 0]).estimates == ("row 1 of k x",)
    both = [design, torque]
    assert lb.robustness(both, [plant], k=[3, 0]).estimates == ("torque (Nm)",)
    table = lb.compare(plant, methods="Kalman filter")
    assert lb.robustness(table, [plant]).estimates == ("pull (N)",)
    with pytest.raises(
        ValueError, match=r"estimate or state 'pul'; there are \['place"
    ):
        lb.robustness([design], [plant], k="pul")
    with pytest.raises(ValueError, match="k must be 1 x 2, got 1 x 3"):
        lb.robustness([design], [plant], k=[1, 0, 0])


def test_the_table_in_a_review(found):
    assert found.table.header[3:] == [
        *["nominal", "least", "lower quartile", "median", "upper quartile"],
        *["worst", "worst on"],
    ]
    (marked,) = found.table.marked
    assert found.table.rows[marked][0] == found.recommended().name
    assert found.table.rows[1][3] == "0.00 %"
    assert f"**{found.recommended().name}**" in found.to_markdown()
    assert r"A{[}0,0{]} = 0.9" in found.to_latex()
    assert "<b>" in found._repr_html_() and "worst on" in repr(found)
    frame = found.to_frame()
    assert len(frame) == 3 * 103
    of_one = frame[frame.design == "a = 0.9"]
    np.testing.assert_array_equal(of_one.error, found.errors[2])
    assert set(of_one["A[0,0]"]) >= {0.5, 0.7, 0.9}
