"""What a comparison says of designs that it did not try."""

import numpy as np
import pytest

import luenberger as lb

METHODS = ["Kalman filter", "Leondes-Novak filter", "fixed-order filter"]


def chain(n, p=1):
    A = np.diag(np.linspace(0.1, 0.9, n)) + np.diag(np.full(n - 1, 0.8), 1)
    C = np.eye(p, n)
    return lb.Plant(A, None, C, dt=1.0, Q=np.eye(n), R=np.eye(p))


@pytest.fixture(scope="module")
def large():
    return lb.compare(chain(12), methods=METHODS)


@pytest.fixture(scope="module")
def small():
    return lb.compare(chain(3), methods=METHODS)


def test_the_orders_that_were_not_tried_are_named(large):
    said = " ".join(large.reasons())
    assert "fixed-order filters of orders 4 to 11; fixed-order filters, every" in said
    assert "One of them may be lighter, or more accurate." in said


def test_claims_hold_among_those_tried(large):
    said = large.reasons()
    assert "among the designs tried " in said[0]
    for sentence in said:
        if "the best" in sentence and "fewer observer states" in sentence:
            assert sentence.startswith("With fewer observer states the best of those")
    least = min(one.work for one in large.designs)
    within = large.within(multiply_adds=least + 1)
    words = " ".join(within.reasons())
    assert "the most accurate design of those tried within the budget" in words
    assert "The next one of those tried beyond the budget is the" in words
    assert "orders 4 to 11" in words
    nothing = " ".join(large.within(multiply_adds=0).reasons())
    assert "No design that was tried is within the budget" in nothing
    assert "What comes nearest of those tried is the" in nothing
    assert "orders 4 to 11" in nothing
    whole = " ".join(large.within(multiply_adds=10**6).reasons())
    assert "It is the most accurate design of all." in whole  # a Kalman filter
    assert "no design of those tried beyond the budget" in whole


def test_the_most_accurate_of_those_tried_is_not_called_that_of_all():
    table = lb.compare(chain(12), methods=["fixed-order filter"])
    said = " ".join(table.within(multiply_adds=10**6).reasons())
    assert "It is the most accurate design of those tried." in said


def test_where_all_were_tried_nothing_is_held_back(small):
    for table in (small, small.within(multiply_adds=8), small.within(multiply_adds=0)):
        assert "tried" not in " ".join(table.reasons())


def test_other_things_that_are_left_out_are_named():
    said = " ".join(lb.compare(chain(6), methods=METHODS).reasons())
    assert "takes a while: fixed-order filters, every order, V = 0. One" in said
    outputs = lb.compare(chain(6, 5), methods=METHODS[:2])
    said = " ".join(outputs.reasons())
    assert "while: Leondes-Novak filters, other outputs taken as accurate. One" in said


@pytest.mark.parametrize("orders, words", [([3], "order 3"), ([3, 4, 5], "3 to 5")])
def test_orders_in_words(orders, words):
    from luenberger.compare.untried import _span

    assert words in _span(orders)
    assert _span([3, 5, 9]) == "orders 3, 5 and 9"
