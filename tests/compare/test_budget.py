"""A budget: the most accurate design within it, the next one beyond, or a refusal."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import luenberger as lb
from luenberger import plot, report
from luenberger.cli import main
from luenberger.compare import METHODS


def tracker():
    A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], np.eye(2, 3)
    return lb.Plant(A, None, C, Q=np.diag([0, 0, 1.0]), R=np.diag([0.25, 4.0]),
                    P0=np.eye(3), dt=1.0)  # fmt: skip


@pytest.fixture(scope="module")
def table():
    return lb.compare(tracker())


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

    def fit(one):
        return all(costs(one)[name] <= most for name, most in limits.items())

    fits = [one for one in table.designs if fit(one)]
    assert chosen in fits
    least = min(one.error for one in fits)
    assert chosen.error <= least * (1 + 1e-4)
    equal = [one for one in fits if one.error <= least * (1 + 1e-9)]
    mean = min(one.mean_ratio for one in equal) * (1 + 1e-4)
    assert chosen.mean_ratio <= mean
    alike = [one for one in fits if one.error <= least * (1 + 1e-4)]
    assert chosen.work == min(one.work for one in alike if one.mean_ratio <= mean)
    assert under.chosen is chosen and limits.items() <= vars(under.budget).items()


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


def test_of_equal_errors_the_least_work_is_taken():
    """Perfect sensors of the whole state: every design knows it, one copies it."""
    plant = lb.Plant([[0.5, 0], [0, 0.5]], None, np.eye(2), dt=1.0, Q=np.eye(2),
                     R=np.zeros((2, 2)))  # fmt: skip
    table = lb.compare(plant, budget=dict(multiply_adds=50))
    assert table.recommended().work == min(one.work for one in table.designs) == 0
    assert table.next_beyond() is None
    assert table.within(multiply_adds=0, states=0, bytes=0).recommended().work == 0


def test_reasons_say_the_budget_what_is_needed_and_what_more_buys(table):
    said = " ".join(table.within(multiply_adds=12, bytes=60).reasons())
    assert "the most accurate design within the budget of 12 multiply-adds and " in said
    assert "It needs 4 multiply-adds, 1 observer state and 32 bytes." in said
    assert "The next one beyond the budget is the Leondes-Novak filter, y1" in said
    assert "for 2 multiply-adds and 52 bytes more, the standard deviation of" in said
    whole = " ".join(table.within(multiply_adds=24).reasons())
    assert "most accurate design of all. More would buy nothing" in whole
    last = " ".join(table.within(states=2).reasons())
    assert "for 1 observer state more, it is the most accurate of all." in last


def test_nothing_within_the_budget_is_refused_with_what_would_do(table):
    small = table.within(multiply_adds=3, bytes=32)
    with pytest.raises(
        lb.DesignError, match="budget of 3 multiply-adds and 32 bytes"
    ) as told:
        small.recommended()
    assert "needs 4 multiply-adds, 1 observer state and 32 bytes" in str(told.value)
    assert "1 multiply-add more than there is" in str(told.value)
    assert small.chosen is None and " ".join(small.reasons()) == str(told.value)
    assert "observer.json" not in report.files(small)
    assert not any(row["recommended"] or row["within_budget"] for row in small.rows())
    assert "No observer is recommended" in report.files(small)["report.html"]


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
    ],
)
def test_what_is_no_budget_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        lb.compare(tracker(), budget=given)


def test_without_a_budget_nothing_changes(table):
    assert table.budget is None and table.next_beyond() is None
    assert table.within(states=1).within().recommended() is table.recommended()
    assert "budget" not in table.table.header
    assert {row["within_budget"] for row in table.rows()} == {None}


def test_no_work_is_spent_on_an_error_that_is_alike():
    """A fixed-order filter is better by 1e-7, and twice the work."""
    plant = lb.Plant([[-1, 20], [-2, -50]], [[0], [100]], [[1, 0]], Q=1e-2 * np.eye(2),
                     R=[[1e-4]]).sampled(0.01)  # fmt: skip
    table = lb.compare(plant.with_input([[25.0]]), budget=dict(states=1))
    least = min(one.error for one in table.ranked if one.order == 1)
    chosen = table.recommended()
    assert least < chosen.error * (1 - 1e-9) and chosen.error < least * (1 + 1e-6)
    best = next(one for one in table.ranked if one.error == least)
    assert chosen.work < best.work


def test_the_table_marks_what_is_over(table):
    shown = table.within(multiply_adds=14, states=2).table
    marks = [row[shown.header.index("budget")] for row in shown.rows]
    assert marks[0] == "beyond"
    assert set(marks[1:]) == {"within"}


def test_float_counts_half_the_bytes_and_the_same_work(table):
    narrow = lb.compare(tracker(), dtype="float", budget=dict(bytes=60))
    assert "bytes (float)" in narrow.table.header
    assert [2 * one.bytes for one in narrow.designs] == [
        one.bytes for one in table.designs
    ]
    assert narrow.recommended().order == 2
    assert table.within(bytes=60).recommended().order == 1
    with pytest.raises(ValueError, match="must be 'double' or 'float', got 'half'"):
        lb.compare(tracker(), dtype="half")


def test_the_picture_has_the_limit_and_pales_what_is_beyond(table):
    under = table.within(multiply_adds=12, bytes=60)
    ax = plot.pareto(under, plt.figure().gca())
    (line,) = [one for one in ax.lines if one.get_label() == "budget"]
    assert set(line.get_xdata()) == {12}
    pale = [x for one in ax.lines if one.get_alpha() == 0.35 for x in one.get_xdata()]
    assert sorted(pale) == sorted(one.work for one in table.designs if one.work > 12)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert set(labels) <= {*METHODS, "front", "budget", "recommended"}
    assert "paler: beyond 12 multiply-adds and 60 bytes" in ax.get_title()
    ax = plot.pareto(under, plt.figure().gca(), by="order")
    assert not [one for one in ax.lines if one.get_label() == "budget"]
    plt.close("all")


def test_a_far_design_is_drawn_when_the_budget_leaves_no_other():
    plant = lb.Plant([[1, 1], [0, 1]], None, np.eye(2), dt=1.0,
                     Q=np.diag([1e-12, 1e-12]), R=np.diag([1e-9, 1]))  # fmt: skip
    table = lb.compare(plant)
    last = min(table.designs, key=lambda one: one.work)
    under = table.within(multiply_adds=last.work)
    assert under.recommended().error > 100
    ax = plot.pareto(under, plt.figure().gca())
    (star,) = [one for one in ax.lines if one.get_label() == "recommended"]
    assert list(star.get_ydata()) == [under.recommended().error]
    plt.close("all")


def run(*given, capsys):
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main([*map(str, given)]))
    return ended.value.code, *capsys.readouterr()


def test_the_command_takes_a_budget(tmp_path, capsys):
    path = tmp_path / "plant.json"
    tracker().to_json(path)
    given = ("--budget", "states=2,bytes=60", "--dtype=float", "--json")
    code, out, _ = run("compare", path, *given, capsys=capsys)
    data = json.loads(out)
    (row,) = [one for one in data["designs"] if one["recommended"]]
    assert (code or 0, row["order"], row["bytes"]) == (0, 2, 56)
    assert any("next one beyond the budget" in one for one in data["reasons"])
    code, out, _ = run("compare", path, "--budget", "multiply_adds=1", capsys=capsys)
    assert (code or 0) == 0 and "No design is within the budget" in out
    for wrong in ("states", "states=two", "states=1,states=2", "ram=1", "states=-1"):
        code, _, err = run("compare", path, "--budget", wrong, capsys=capsys)
        assert code == 2 and "--budget" in err
