"""Sums of the sizes of all powers are bounds, and not far above, in any units."""

from fractions import Fraction

import numpy as np
import pytest

from luenberger.numeric.power_sums import power_sums, proved


def exactly(F, P, B, X, terms):
    """Sums and largest sizes of so many powers, in fractions, as floats from above."""

    def table(M):
        found = np.empty(M.shape, object)
        found.flat = [Fraction(x) for x in M.flat]
        return found

    F, P, B, X = map(table, (F, P, B, X))
    moved, first = B, X
    found = [np.abs(B), np.abs(P @ B), np.abs(X), np.abs(P @ X)]
    for _ in range(terms):
        moved, first = F @ moved, F @ first
        found[0] = found[0] + np.abs(moved)
        found[1] = found[1] + np.abs(P @ moved)
        found[2] = np.maximum(found[2], np.abs(first))
        found[3] = np.maximum(found[3], np.abs(P @ first))
    return found


CASES = {
    "fast": ([[0.5, 0.25], [-0.25, 0.125]], 40),
    "turns": ([[0.75, 0.5], [-0.5, 0.75]], 100),
    "a push of 1e6 first": ([[0.5, 2.0**20], [0.0, 0.5]], 60),
    "units far apart": ([[0.5, 2.0**40], [2.0**-42, 0.25]], 120),
    "ends": ([[0.0, 8.0, 3.0], [0.0, 0.0, -4.0], [0.0, 0.0, 0.0]], 4),
    "no states": (np.zeros((0, 0)), 2),
}


@pytest.mark.parametrize("F, terms", CASES.values(), ids=CASES)
def test_sums_are_bounds_and_not_far_above(F, terms):
    F = np.asarray(F, float)
    rng = np.random.default_rng(5)
    P, B, X = (
        rng.integers(-8, 9, s) / 8 for s in ((2, len(F)), (len(F), 3), (len(F), 1))
    )
    found, wanted = power_sums(F, P, B, X), exactly(F, P, B, X, terms)
    assert found is not None
    for bound, exact in zip(found, wanted, strict=True):
        some = [(float(a), b) for a, b in zip(exact.flat, bound.flat)]
        assert all(b >= Fraction(a) for a, (_, b) in zip(exact.flat, some))
        assert all(b <= 1.01 * a for a, b in some)


def test_rounding_of_powers_is_counted(monkeypatch):
    """Powers that are computed with an error in each, as if digits were few."""
    from luenberger.numeric import power_sums as module

    F, one = np.array([[0.9]]), np.eye(1)
    exact = power_sums(F, one, one, one).sums[0, 0]
    monkeypatch.setattr(module, "EPS", 1e-4)
    assert exact == pytest.approx(10, rel=1e-3)
    assert power_sums(F, one, one, one).sums[0, 0] > 10 * (1 + 1e-3)


@pytest.mark.parametrize("pole", [1.0, 1.01, -1.5])
def test_what_does_not_decay_has_no_bound(pole, monkeypatch):
    from luenberger.numeric import power_sums as module

    monkeypatch.setattr(module, "MOST", 200)
    one = np.eye(1)
    assert power_sums(np.array([[pole]]), one, one, one) is None


def test_what_is_cut_short_is_still_a_bound(monkeypatch):
    from luenberger.numeric import power_sums as module

    monkeypatch.setattr(module, "MOST", 3)
    one = np.eye(1)
    found = power_sums(np.array([[0.5]]), one, -one, one)
    assert 2 <= found.sums[0, 0] <= 2.001 and 2 <= found.seen[0, 0] <= 2.001
    turns = np.array([[0.0, 4.0], [0.125, 0.0]])
    found = power_sums(turns, np.eye(2), np.eye(2), np.eye(2))
    assert (found.sums >= [[2.0, 8.0], [0.25, 2.0]]).all()


def test_a_bound_that_refers_to_itself_is_tried():
    T, b = np.array([[0.5, 0.25], [0.0, 0.5]]), np.array([[1.0], [2.0]])
    x = proved(T, b)
    assert (x >= b + T @ x).all()
    np.testing.assert_allclose(x, [[4.0], [4.0]], rtol=1e-6)
    assert proved(np.eye(2), b) is None and proved(2 * T, b) is None
