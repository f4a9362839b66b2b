"""What is recommended: by the rule, within a budget, on the front, of more orders."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import luenberger as lb
from luenberger import plot, report
from luenberger.comparison import METHODS, Budget, Case, Comparison, Design

KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL = METHODS


def tracker(**changes):
    A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], np.eye(2, 3)
    given = dict(Q=np.diag([0, 0, 1.0]), R=np.diag([0.25, 4.0]), P0=np.eye(3), dt=1.0)
    return lb.Plant(A, None, C, **given | changes)


@pytest.fixture(scope="module")
def table():
    return lb.compare(tracker())


def fake(name, error, work=1, mean=None, method=NOVAK):
    """A design that is known by its figures."""

    class Fake(Design):
        error = property(lambda self: vars(self)["of"][0])
        mean_ratio = property(lambda self: vars(self)["of"][1])
        work = property(lambda self: vars(self)["of"][2])

    one = Fake(method, name, order=work, cases={"nominal": Case(error=error)})
    vars(one)["of"] = error, error if mean is None else mean, work
    return one


def of(*designs, **more):
    plant = tracker()
    return Comparison(plant, designs, {"nominal": plant}, **more)


# -- the rule --------------------------------------------------------------------------


@pytest.mark.parametrize(("tolerance", "order"), [(0, 3), (0.08, 3), (0.1, 2), (10, 1)])
def test_recommendation_follows_its_rule(table, tolerance, order):
    chosen = table.recommended(tolerance)
    assert chosen.order == order and table.excess(chosen) <= tolerance
    lighter = [one for one in table.designs if one.work < chosen.work]
    assert all(table.excess(one) > tolerance for one in lighter)


@pytest.mark.parametrize("tolerance", [-0.1, np.nan])
def test_tolerances_that_no_design_meets(table, tolerance):
    with pytest.raises(ValueError, match="tolerance must not be negative"):
        table.recommended(tolerance)


def test_kalman_filter_is_the_yardstick_and_nothing_beats_it(table):
    assert table.yardstick.method == KALMAN and table.excess(table.yardstick) == 0
    assert all(d.error >= table.yardstick.error * (1 - 1e-9) for d in table.ranked)
    for accurate in [(0,), (1,), (0, 1)]:
        step, steady = (
            table.find(NOVAK, accurate=accurate, horizon=h) for h in ("step", "steady")
        )
        assert steady.trace <= step.trace * (1 + 1e-9)


@pytest.mark.parametrize("size", [1.0, 1e-30])
@pytest.mark.parametrize(("part", "equal"), [(0.9e-9, True), (1.1e-9, False)])
def test_errors_that_differ_by_rounding_are_equal(part, equal, size):
    """Of two equal ones the first is taken; against the yardstick it costs nothing."""
    first, second = fake("a", size * (1 + part), mean=1), fake("b", size, mean=1)
    both = of(first, second)
    assert (both.recommended() is both.yardstick is first) is equal
    assert both.pareto() == both.pareto("order") == [first if equal else second]
    wanted = 0.0 if equal else pytest.approx(part, rel=1e-5, abs=0)
    assert of(second, fake("c", 2 * size), first).excess(first) == wanted


@pytest.mark.parametrize(("part", "worth_it"), [(0.9e-9, False), (1.1e-9, True)])
def test_what_costs_more_is_on_the_front_if_it_is_better_than_by_rounding(
    part, worth_it
):
    cheap, dear = fake("cheap", 1.0), fake("dear", 1 - part, work=2)
    assert of(cheap, dear).pareto() == [cheap, dear][: 1 + worth_it]


def test_equal_errors_leave_it_to_the_mean_and_equal_work_to_the_error():
    worse, better = fake("a", 1.2, mean=1.2), fake("b", 1.2, mean=1.1)
    assert of(worse, better).pareto() == [better]
    assert (
        of(fake("a", 1.09), fake("b", 1.05), fake("c", 1.0, 9)).recommended().label
        == "b"
    )
    assert of(fake("k", 1.0, method=KALMAN), fake("a", 1.0)).yardstick.method == KALMAN
    assert of(fake("a", 1.0), fake("k", 1.5, method=KALMAN)).yardstick.label == "a"


@pytest.mark.parametrize("by", ["work", "order", "settling"])
def test_front_falls_and_is_not_beaten(table, by):
    front = table.pareto(by=by)
    cost = [getattr(d, by) for d in front]
    assert cost == sorted(set(cost)) and len(front) >= 2
    for d in front:
        rivals = [r for r in table.ranked if getattr(r, by) <= getattr(d, by)]
        assert d.error <= min(r.error for r in rivals) * (1 + 1e-9)


def test_front_by_something_else_is_refused(table):
    with pytest.raises(ValueError, match="'order' or 'settling', got 'bytes'"):
        table.pareto(by="bytes")


# -- a budget --------------------------------------------------------------------------

BUDGETS = [
    dict(multiply_adds=14),
    dict(multiply_adds=13.5),
    dict(states=1),
    dict(bytes=40),
    dict(multiply_adds=4),
    dict(multiply_adds=20, states=2, bytes=112),
    dict(multiply_adds=1000),
]


def costs(one):
    return dict(multiply_adds=one.work, states=one.order, bytes=one.bytes)


@pytest.mark.parametrize("limits", BUDGETS, ids=str)
def test_no_design_within_the_budget_is_more_accurate(table, limits):
    under = table.within(**limits)
    chosen = under.recommended()
    fits = [
        one
        for one in table.designs
        if all(costs(one)[name] <= most for name, most in limits.items())
    ]
    assert chosen in fits and under.chosen is chosen
    least = min(one.error for one in fits)
    assert chosen.error <= least * (1 + 1e-4)
    alike = [one for one in fits if one.error <= least * (1 + 1e-4)]
    mean = min(o.mean_ratio for o in fits if o.error <= least * (1 + 1e-9)) * (1 + 1e-4)
    assert chosen.work == min(one.work for one in alike if one.mean_ratio <= mean)


@pytest.mark.parametrize("limits", BUDGETS, ids=str)
def test_the_next_one_beyond_is_more_accurate_for_the_least_more(table, limits):
    under = table.within(**limits)
    chosen, beyond = under.recommended(), under.next_beyond()

    def over(one):
        return max(costs(one)[name] / most for name, most in limits.items())

    better = [one for one in table.designs if over(one) > 1]
    better = [one for one in better if one.error < chosen.error * (1 - 1e-4)]
    assert (beyond is None) == (not better)
    if better:
        assert beyond in better and over(beyond) == min(map(over, better))


def test_no_work_is_spent_on_an_error_that_is_alike():
    heavy, light = fake("heavy", 1.1, 9), fake("light", 1.1 * (1 + 0.9e-4), 4)
    least = fake("kalman", 1.0, 30)
    assert of(heavy, light, least, budget=Budget(states=9)).recommended() is light
    worse = fake("light", 1.1 * (1 + 1.1e-4), 4)
    assert of(heavy, worse, least, budget=Budget(states=9)).recommended() is heavy


def test_nothing_within_the_budget_is_refused_with_what_would_do(table):
    small = table.within(multiply_adds=3, bytes=32)
    match = "within the budget of 3 multiply-adds and 32 bytes"
    with pytest.raises(lb.DesignError, match=match) as told:
        small.recommended()
    assert "needs 4 multiply-adds, 1 observer state and 32 bytes" in str(told.value)
    assert "1 multiply-add more than there is" in str(told.value)
    assert small.chosen is None and " ".join(small.reasons()) == str(told.value)
    files = report.files(small)
    assert "observer.json" not in files
    assert "No observer is recommended" in files["report.html"]
    assert not any(r["recommended"] or r["within_budget"] for r in small.to_rows())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "dict with one or more of multiply_adds, states, bytes"),
        (30, "dict with one or more"),
        (dict(ram=400), "no 'ram'"),
        (dict(states=-1), "states must be a number that is not negative, got -1"),
        (dict(states=True), "states must be a number.*True"),
        (dict(bytes=np.nan), "bytes must be a number.*nan"),
        (dict(bytes=np.inf), "leave out what does not matter"),
        (dict(bytes="400"), "bytes must be a number"),
        (dict(dtype="half"), "must be 'double' or 'float', got 'half'"),
    ],
)
def test_what_is_no_budget_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        lb.compare(tracker(), budget=given)


def test_without_a_budget_nothing_changes(table):
    assert not table.budget.limits and table.next_beyond() is None
    assert table.within(states=1).within().recommended() is table.recommended()
    assert "budget" not in table.table.header
    assert {row["within_budget"] for row in table.to_rows()} == {None}
    shown = table.within(multiply_adds=14, states=2).table
    marks = [row[shown.header.index("budget")] for row in shown.rows]
    assert marks[0] == "beyond" and set(marks[1:]) == {"within"}


def test_the_picture_has_the_limit_and_pales_what_is_beyond(table):
    under = table.within(multiply_adds=12, bytes=60)
    ax = plot.pareto(under, plt.figure().gca())
    (line,) = [one for one in ax.lines if one.get_label() == "budget"]
    assert set(line.get_xdata()) == {12}
    pale = [x for one in ax.lines if one.get_alpha() == 0.35 for x in one.get_xdata()]
    assert sorted(pale) == sorted(one.work for one in table.designs if one.work > 12)
    assert "paler: beyond 12 multiply-adds and 60 bytes" in ax.get_title()
    ax = plot.pareto(under, plt.figure().gca(), by="order")
    assert not [one for one in ax.lines if one.get_label() == "budget"]
    plt.close("all")


# -- fixed orders above the first few --------------------------------------------------


def building():
    """Outdoors and a row of 39 rooms, heat goes from one to the next; two of them."""
    n, A = 40, np.eye(40)
    for k in range(1, n):
        A[k, k - 1] += 0.3
        A[k, k] -= 0.302
        if k + 1 < n:
            A[k, k + 1] += 0.3
            A[k, k] -= 0.3
    A[0] = 0.98 * np.eye(n)[0]
    Q = np.diag([1.0] + [1e-6] * (n - 1))
    plant = lb.Plant(A, None, np.eye(n)[[0, 12, 39]], Q=Q, dt=600.0,
                     R=np.diag([0.01, 0.25, 0.25]))  # fmt: skip
    return plant, np.eye(n)[[3, 8]]


def test_a_building_of_forty_states_gets_the_order_that_is_enough():
    """By the rule order 8, 54 multiply-adds; orders up to 7 lose more than 10 %."""
    plant, L = building()
    some = lb.comparison.designs
    quick = {
        n: c for n, c in lb.candidates(plant).items() if c.method in (KALMAN, FIXED)
    }
    asked = some.Question(plant, L)
    first = lb.compare(plant, quick, L=L)
    assert not first.searched and first.recommended().method == KALMAN
    found = lb.comparison._with_more(first, asked, L)
    chosen = found.recommended()
    assert (chosen.order, chosen.work) == (8, 54) and found.excess(chosen) < 0.02
    seven = found.find(FIXED, order=7)
    assert found.excess(seven) > 0.1 and 4 not in found.searched
    assert [one.order for one in found if one.method == FIXED] == sorted(
        [1, 2, 3, *found.searched]
    )
    assert "Of the fixed orders above the first few, 6, 7, 8" in " ".join(
        found.reasons()
    )
    poor = first.within(multiply_adds=57)
    within = lb.comparison._with_more(poor, asked, L)
    assert within.recommended().work == 54 and max(within.searched) == 8
    few = lb.comparison._with_more(first.within(states=5), asked, L)
    assert few.recommended().order == 5 == max(few.searched)
    assert not lb.comparison._with_more(first.within(states=3), asked, L).searched
    enough = first.within(multiply_adds=1000)
    assert not lb.comparison._with_more(enough, asked, L).searched
