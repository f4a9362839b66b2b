"""When two minima are one, and which directions are too weak to count."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg

from luenberger.papers.haddad_bernstein import search as search

POLES = np.array([0.5, -0.3, 0.8, 0.1])
ANGLES = 0.3, 1.1, 2.3  # rad a sample, at which frequency responses are compared


def frame(c, d=0.0, cost=1.0, flat=False):
    """A stand-in for a minimum: z+ = diag(POLES) z + 1 y, w^ = c z + d y."""
    r = len(POLES)
    have = dict(Ae=np.diag(POLES), Be=np.ones((r, 1)))
    have |= dict(Ce=np.reshape(c, (1, r)), De=np.array([[d]]))
    point, target = SimpleNamespace(cost=cost, have=have), SimpleNamespace(scale=2.0)
    return SimpleNamespace(point=point, target=target, is_flat=flat, r=r)


ONE = [1.0, 0.4, -0.2, 0.7]


def responses(z):
    """Rows of the response at z as a function of (c, d), real and imaginary parts."""
    row = np.append(1 / (z - POLES), 1.0)
    return np.array([row.real, row.imag])


@pytest.mark.parametrize(
    "points",
    [
        *([np.exp(1j * a), np.exp(1j * b)] for a, b in combinations(ANGLES, 2)),
        np.exp(ANGLES),  # of the real axis, where a response is no frequency response
    ],
)
def test_filters_that_agree_at_some_points_only_are_two(points):
    rows = np.vstack([responses(z) for z in points])
    beside = scipy.linalg.null_space(rows[np.abs(rows).max(axis=1) > 0])[:, 0]
    other = frame(ONE + 5 * beside[:-1], 5 * beside[-1])
    assert not search._same(frame(ONE), other)


@pytest.mark.parametrize(("gap", "same"), [(0.9e-4, True), (1.1e-4, False)])
def test_responses_within_1e_4_are_one_minimum(gap, same):
    size = np.linalg.norm(search._response(frame(ONE)))
    d = gap * size / np.sqrt(len(ANGLES))  # a feedthrough d adds d to each response
    assert bool(search._same(frame(ONE), frame(ONE, d))) is same


@pytest.mark.parametrize(
    ("gap", "flat", "same"),
    [
        (0.9e-10, (True, True), True),
        (1.1e-10, (True, True), False),
        (0.9e-10, (True, False), False),
        (0.9e-10, (False, True), False),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_flat_minima_of_equal_cost_lie_in_one_valley(gap, flat, same, sign):
    """Costs are compared beside the scale of the problem, here 2."""
    one = frame(ONE, cost=3.0, flat=flat[0])
    other = frame(np.negative(ONE), cost=3.0 + 2 * sign * gap, flat=flat[1])
    assert bool(search._same(one, other)) is same


def directions(strength, power):
    """Of a target whose Kalman filter has these strengths: A = 0, C = 0, Kq = I."""
    n = len(strength)
    matrices = dict(A=np.zeros((n, n)), C=np.zeros((n, n)), L=np.diag(strength))
    target = SimpleNamespace(matrices=matrices, Kq=np.eye(n), power=power)
    return search.directions(target)


@pytest.mark.parametrize(
    ("strength", "power", "count"),
    [
        ([1.0, 1.1e-8], 1.0, 2),  # beside the strongest direction
        ([1.0, 0.9e-8], 1.0, 1),
        ([1.1e-15, 1.1e-15], 1.0, 2),  # beside the estimate, when all are weak
        ([0.9e-15, 0.9e-15], 1.0, 0),
        ([0.9e-15, 0.9e-15], 0.25, 2),  # which has half the size here
    ],
)
def test_directions_too_weak_to_change_the_cost_are_none(strength, power, count):
    found = directions(strength, power)
    assert found.strength.tolist() == pytest.approx(strength[:count], rel=1e-9, abs=0)
    np.testing.assert_allclose(found.read @ found.lift, np.eye(count), atol=1e-12)


@pytest.mark.parametrize(("order", "ahead"), [(1, 8), (5, 8), (6, 9), (8, 11)])
def test_first_starts_are_chosen_from_the_strongest_directions(order, ahead):
    """From eight of them, or from three more than the order."""
    strength = np.geomspace(1, 0.5, 14)
    chosen = search._choices(strength, order, 10_000)
    assert max(max(one) for one in chosen) == ahead - 1
    assert chosen[0] == tuple(range(order))
    squares = [(strength[list(one)] ** 2).sum() for one in chosen]
    assert squares == sorted(squares, reverse=True)
