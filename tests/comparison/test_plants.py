"""Designs on plants that differ from their own: ranges, errors, worst case, choice."""

import dataclasses
from fractions import Fraction as F

import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger import plot
from luenberger.comparison.judge import UNKNOWN


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
    plants = {str(a): scalar(a, Q=Q, R=R) for a in (0.5, 0.75)}
    found = lb.compare(scalar(0.625, Q=Q, R=R), designs, plants=plants)
    assert [*found.plants] == ["nominal", "0.5", "0.75"]
    for one in found:
        for name, case in one.cases.items():
            a = 0.625 if name == "nominal" else float(name)
            k, believed = one.observer.V[0, 0], float(one.name[4:])
            exact = exact_error(believed, k, a, Q, R)
            assert case.covariance[0, 0] == pytest.approx(float(exact), abs=1e-15)
            assert case.sigma[0] == pytest.approx(float(exact) ** 0.5, abs=1e-15)
            own = lb.kalman_filter(found.plants[name]).V[0, 0]
            least = exact_error(a, own, a, Q, R)
            ratio = np.sqrt(float(exact / least)) if least > 1e-12 else 1.0
            assert case.error == pytest.approx(float(ratio), rel=1e-12)


def test_errors_are_those_of_design_and_plant_side_by_side():
    """The covariance of (x, z) from one Lyapunov equation, and Kalman filters' own."""
    designs = {s: lb.kalman_filter(oscillator(s).sampled(0.05)) for s in (0.35, 0.65)}
    plants = lb.vary(oscillator(0.5), {"A[1,1]": "30 %"}, samples=4)
    found = lb.compare(oscillator(0.5).sampled(0.05), designs, plants=plants)
    assert len(found.plants) == 7
    for one in found:
        o = one.observer
        for name, given in plants.items():
            case, plant = one.cases[name], given.sampled(0.05)
            np.testing.assert_array_equal(found.plants[name].A, plant.A)
            n = plant.n
            moves = np.block([[plant.A, np.zeros((n, n))], [o.D @ plant.C, o.F]])
            drives = scipy.linalg.block_diag(plant.Q, o.D @ plant.R @ o.D.T)
            X = scipy.linalg.solve_discrete_lyapunov(moves, drives)
            rows = np.hstack([o.V @ plant.C - o.L, o.P])
            error = rows @ X @ rows.T + o.V @ plant.R @ o.V.T
            np.testing.assert_allclose(case.covariance, error, rtol=1e-8, atol=1e-12)
            own = lb.error_covariance(lb.kalman_filter(plant), plant)
            ratios = np.sqrt(error.diagonal() / own.diagonal())
            assert case.error == pytest.approx(ratios.max(), rel=1e-7)
            np.testing.assert_allclose(case.ratios, ratios, rtol=1e-7)


# -- which plants ----------------------------------------------------------------------


def test_ranges_are_corners_and_draws():
    nominal = oscillator(0.5).sampled(0.05)
    ranges = {"A[1,1]": "0.5 %", "A[0,1]": (0.046, 0.048)}
    found = lb.vary(nominal, ranges, samples=7, seed=3)
    middle = nominal.A[1, 1]
    low, high = middle - abs(middle) * 0.5 / 100, middle + abs(middle) * 0.5 / 100
    values = np.array([(one.A[1, 1], one.A[0, 1]) for one in found.values()])
    corners = [(low, 0.046), (low, 0.048), (high, 0.046), (high, 0.048)]
    assert values[:4].tolist() == [list(one) for one in corners]
    assert ((values[4:] > (low, 0.046)) & (values[4:] < (high, 0.048))).all()
    assert len(values) == 4 + 7
    for name, one in found.items():
        assert one.A[1, 0] == nominal.A[1, 0] and one.Q is not None
        said = [float(part.split(" = ")[1]) for part in name.split(", ")]
        np.testing.assert_allclose(said, [one.A[1, 1], one.A[0, 1]], rtol=1e-9)
    again = lb.vary(nominal, ranges, samples=7, seed=3)
    other = lb.vary(nominal, ranges, samples=7, seed=4)
    assert [*again] == [*found] != [*other] and [*other][:4] == [*found][:4]
    five = {f"A[{i},{j}]": (0.1, 0.2) for i in (0, 1) for j in (0, 1)} | {
        "C[0,1]": (1, 2)
    }
    assert len(lb.vary(nominal, five, samples=3)) == 3
    two = lb.vary(scalar(-0.5), {"A[0,0]": "±20%"}, samples=0)
    assert [one.A[0, 0] for one in two.values()] == [-0.6, -0.4]


def test_a_function_makes_plants_of_its_parameters():
    def made(theta):
        return oscillator(2 * theta[0] * theta[1])

    bounds = {"ratio": (0.04, 0.06), "rate": (4.5, 5.5)}
    found = lb.vary(oscillator(0.5), (made, bounds), samples=3)
    assert len(found) == 4 + 3 and [*found][0] == "ratio = 0.04, rate = 4.5"
    np.testing.assert_array_equal([*found.values()][3].A, made([0.06, 5.5]).A)


BAD = {
    "no entry": ({"Q[0,0]": (1, 2)}, r"'Q\[0,0\]'.* cannot be varied"),
    "no such entry": ({"A[0,3]": (1, 2)}, r"no A\[0,3\]: A is 1 x 1"),
    "no ranges": ({}, "ranges must be"),
    "a number": ({"A[0,0]": 0.3}, r"must be \(low, high\).*got 0.3"),
    "falling": ({"A[0,0]": (0.9, 0.5)}, "finite and rising"),
    "not finite": ({"A[0,0]": (0.5, np.nan)}, "finite and rising"),
    "no percentage": ({"A[0,0]": "0.3"}, "'30 %' of the nominal"),
    "nothing": ({"A[0,0]": "0 %"}, "'30 %' of the nominal"),
    "of zero": ({"C[0,0]": "30 %"}, r"C\[0,0\] is 0 in the nominal plant"),
    "of a function": ((lambda x: scalar(x[0]), {"a": "30 %"}), "has no nominal value"),
}


@pytest.mark.parametrize(("ranges", "match"), BAD.values(), ids=BAD)
def test_what_is_no_range_is_refused(ranges, match):
    plant = dataclasses.replace(scalar(0.5), C=[[0.0]])
    with pytest.raises(ValueError, match=match):
        lb.vary(plant, ranges)


def test_what_else_vary_refuses():
    ranges = {"A[0,0]": (0.5, 0.9)}
    with pytest.raises(ValueError, match="samples must be a whole number"):
        lb.vary(scalar(0.5), ranges, samples=-1)
    with pytest.raises(ValueError, match="seed must be a whole number"):
        lb.vary(scalar(0.5), ranges, seed=0.5)
    with pytest.raises(TypeError, match="plant must be a Plant, got a list"):
        lb.vary([scalar(0.5)], ranges)
    with pytest.raises(ValueError, match="constant plant, not one over time"):
        lb.vary(lb.Plant([[[0.5]]] * 2, None, [[1]], dt=1.0), ranges)


WRONG = {
    "a list": ([scalar(0.5)], "plants must be a dict of plants by name"),
    "a plant alone": (scalar(0.5), "plants must be a dict"),
    "another thing": ({"x": np.eye(2)}, r"plants\['x'\] must be a Plant"),
    "of other size": ({"x": oscillator(1).sampled(1)}, "'x': it has 2 states"),
    "of another period": (
        {"x": dataclasses.replace(scalar(0.5), dt=2.0)}, "'x': .*dt = 2 s",
    ),
    "without noise": (
        {"x": lb.Plant([[0.5]], None, [[1]], dt=1.0)},
        "'x': it needs both .* Q and R; lb.fit_noise",
    ),
    "of that name": ({"nominal": scalar(0.5)}, "cannot be called 'nominal'"),
    "over time": (
        {"x": lb.Plant([[[0.5]]] * 2, None, [[1]], dt=1.0)}, "constant and real",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("plants", "match"), WRONG.values(), ids=WRONG)
def test_plants_that_no_design_is_judged_on(plants, match):
    with pytest.raises(ValueError, match=match):
        lb.compare(scalar(0.5), filters(0.5), plants=plants)
    bare = lb.Plant([[0.5]], None, [[1]], dt=1.0)
    with pytest.raises(lb.DesignError, match="nominal plant must have"):
        lb.compare(bare, filters(0.5), plants={"x": scalar(0.5)})


# -- worst case and choice -------------------------------------------------------------


@pytest.fixture(scope="module")
def found():
    plants = lb.vary(scalar(0.7), {"A[0,0]": (0.5, 0.9)})
    return lb.compare(scalar(0.7), filters(0.5, 0.7, 0.9), plants=plants)


def test_the_error_of_a_design_is_that_on_its_worst_plant(found):
    for one in found:
        errors = one.errors
        assert len(errors) == 103 and one.error == max(errors.values())
        assert errors[one.worst_on] == one.error
        assert one.cases[one.worst_on].error == one.error
    chosen = found.recommended(0)
    assert chosen.error == min(one.error for one in found)
    assert chosen.name != "a = 0.7"  # a pole nearer to 1 is the safer one
    assert found.recommended(1000) is chosen  # all are as much work
    said = found.reasons()
    assert "judged on 103 plants, the nominal one among them" in said[0]
    assert "beside that of the plant's own Kalman filter" in said[1] or (
        "standard deviation of x1" in said[1]
    )
    assert "It is the most accurate design in the table" in " ".join(said)


def test_the_table_shows_nominal_median_and_worst(found):
    shown = found.table
    assert shown.header == ["method", "order", "nominal", "median", "worst", "worst on",
                            "multiply-adds", "bytes"]  # fmt: skip
    for cells, one in zip(shown.rows, found):
        errors = np.sort([*one.errors.values()])
        wanted = one.nominal.error, errors[51], errors[-1]
        for cell, error in zip(cells[2:5], wanted):
            assert float(cell.split()[0]) == pytest.approx(100 * (error - 1), abs=0.006)
        assert cells[5] == one.worst_on
    rows = found.to_cases()
    assert len(rows) == 3 * 103 and {row["plant"] for row in rows} == {*found.plants}
    assert rows[3]["error"] == found.every[0].errors[rows[3]["plant"]]
    assert found.to_rows()[0]["worst_on"] == found.every[0].worst_on


def test_among_near_worst_cases_the_least_work_is_taken():
    raw = {"raw": lb.deadbeat_observer(scalar(0.5))}
    near = lb.compare(scalar(0.5), filters(0.5, 0.6) | raw, plants={"b": scalar(0.6)})
    assert near.recommended(0).name != "raw" == near.recommended(1.0).name
    assert "raw" not in near.reasons(0)[1]


def test_an_error_that_grows_is_said_by_name():
    plants = {str(a): scalar(a) for a in (0.9, 1.1)}
    found = lb.compare(scalar(0.5), filters(0.5, 1.1), plants=plants)
    first = found.find("a = 0.5")
    assert first.growing == ["1.1"] and first.error == np.inf
    case = first.cases["1.1"]
    assert "mode 1.1 on or outside" in case.refusal and case.covariance is None
    assert "Give steps" not in case.refusal and np.isfinite(first.errors["0.9"])
    assert found.find("a = 1.1").cases["1.1"].error == pytest.approx(1.0)
    assert found.recommended().name == "a = 1.1" and "unbounded" in repr(found)
    said = " ".join(found.reasons())
    assert "The error of a = 0.5 grows on 1 plant, such as 1.1: no steady state" in said
    row = next(r for r in found.to_cases() if r["plant"] == "1.1")
    assert row["error"] is None and "mode 1.1" in row["refusal"]
    none = lb.compare(scalar(0.5), filters(0.5), plants=plants)
    assert none.chosen is None
    assert "no design is safe on every plant" in " ".join(none.reasons())
    with pytest.raises(lb.DesignError, match="a = 0.5 on 1.1, no steady state"):
        none.recommended()
    assert "no steady state" in lb.compare(scalar(1.1), filters(0.5)).every[0].refusal


def test_where_the_input_disturbs_an_estimate_it_must_be_known():
    other, nominal = {"1.1": scalar(0.5, 1.1)}, scalar(0.5, 1.0)
    designs = {
        "filter": lb.kalman_filter(nominal),
        "raw": lb.deadbeat_observer(nominal),
    }
    found = lb.compare(nominal, designs, plants=other)
    one = found.find("filter")
    assert one.cases["1.1"].refusal == UNKNOWN and one.cases["1.1"].error is None
    assert one.nominal.error == pytest.approx(1) and one.error is None is one.worst_on
    assert found.recommended().name == "raw" and "not known" in repr(found)
    assert "Not weighed: 1 design " in " ".join(found.reasons())
    nominal = nominal.with_input([2.0])
    told = lb.compare(nominal, designs, plants=other).find("filter").cases["1.1"]
    F, V = one.observer.F[0, 0], one.observer.V[0, 0]
    bias = -(1 - V) * 0.1 * 2.0 / (1 - F)
    spread = lb.error_covariance(one.observer, nominal)[0, 0]
    assert told.covariance[0, 0] == pytest.approx(bias**2 + spread)


def test_designs_of_a_question_are_judged_on_it():
    plant = oscillator(0.5).sampled(0.05)
    some = lb.candidates(plant, methods=["Kalman filter", "fixed-order filter"])
    table = lb.compare(plant, some, L=[0, 1])
    plants = lb.vary(oscillator(0.5), {"A[1,1]": "30 %"}, samples=0)
    found = lb.compare(plant, some, L=[0, 1], plants=plants)
    for one, other in zip(table, found, strict=True):
        assert (
            one.title == other.title
            and one.errors["nominal"] == other.errors["nominal"]
        )
    scaled = lb.compare(plant, some, scale=[1, 10], plants=plants)
    for one in scaled:
        size = np.sqrt(np.mean((one.cases[one.worst_on].sigma / [1, 10]) ** 2))
        assert one.error == pytest.approx(size)
    assert "in the given scale" in " ".join(scaled.reasons())


# -- the picture -----------------------------------------------------------------------


def test_the_picture_of_one_parameter_is_a_curve_for_each_design(found):
    ax = plot.robustness(found, plt.figure().gca())
    assert ax.get_xlabel() == "A[0,0]" and len(ax.lines) == 6
    x, y = ax.lines[0].get_data()
    assert len(x) == 102 and (np.diff(x) >= 0).all()
    assert max(y) == pytest.approx(found.every[0].error)
    plt.close("all")


def test_the_picture_of_a_list_has_a_row_for_each_design(found):
    plants = {"cold": scalar(0.5), "warm": scalar(0.9)}
    listed = lb.compare(scalar(0.7), filters(0.5, 0.9), plants=plants)
    ax = plot.robustness(listed, plt.figure().gca())
    assert [one.get_text() for one in ax.get_yticklabels()] == ["a = 0.5", "a = 0.9"]
    low, high = ax.lines[0].get_xdata()
    errors = listed.every[0].errors.values()
    assert (low, high) == (min(errors), max(errors))
    plt.close("all")
