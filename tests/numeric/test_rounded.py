"""Matrices that bound their rounding, against exact rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

from luenberger.numeric.more_digits import Wide
from luenberger.numeric.rounded import Rounded, solve_right, symmetrise

DIGITS = {Rounded: 1e-9, Wide: 1e-20}  # what is lost at most in these, beside the sizes


def rational(X):
    return np.vectorize(lambda v: Fraction(float(v)), otypes=[object])(X)


def exact(X):
    """The value itself, as a matrix of Fractions."""
    return rational(X.value) + (rational(X.rest) if isinstance(X, Wide) else 0)


def divided(B, M):
    """B M^-1 of Fractions."""
    M, B = M.copy(), B.copy()
    for k in range(len(M)):
        B[:, k], M[:, k] = B[:, k] / M[k, k], M[:, k] / M[k, k]
        for j in set(range(len(M))) - {k}:
            B[:, j], M[:, j] = B[:, j] - B[:, k] * M[k, j], M[:, j] - M[:, k] * M[k, j]
    return B


@pytest.fixture(params=[1, 2, 5, 9])
def pair(request):
    """Matrices of entries from 1e-8 to 1e8, and a covariance."""
    rng, n = np.random.default_rng(request.param), request.param
    A, B = (
        rng.normal(size=(n, n)) * 10.0 ** rng.integers(-8, 8, size=(n, n))
        for _ in range(2)
    )
    G = rng.normal(size=(n, n))
    return A, B, G @ G.T + 1e-3 * np.eye(n)


def within(found, wanted, digits):
    off = np.abs(exact(found) - wanted)
    assert (off <= rational(found.off)).all()
    assert found.off.max() <= DIGITS[digits] * np.abs(found.value).max()
    return off


@pytest.mark.parametrize("digits", [Rounded, Wide])
def test_sums_and_products_are_within_their_bounds(pair, digits):
    A, B, _ = pair
    a, b = digits.of(A), digits.of(B)
    product = rational(A) @ rational(B)
    some = within(a.dot(b), product, digits)
    chain = (a.dot(b) + A).dot((A - a.dot(b)).T)
    wanted = (product + rational(A)) @ (rational(A) - product).T
    more = within(chain, wanted, digits)
    assert len(A) == 1 or some.any() or more.any()  # the bounds are not of nothing


def test_a_sum_counts_its_own_rounding(pair):
    """Of terms that are taken for exact, with a rest each."""
    rng = np.random.default_rng(7)
    none = np.zeros_like(pair[0])
    X, Y = (Wide(Z, none, 1e-17 * Z * rng.normal(size=Z.shape)) for Z in pair[:2])
    found = X + Y
    off = np.abs(exact(found) - (exact(X) + exact(Y)))
    assert off.any() and (off <= rational(found.off)).all()


@pytest.mark.parametrize("digits", [Rounded, Wide])
def test_solutions_are_within_their_bounds(pair, digits):
    _, B, M = pair
    found = solve_right(digits.of(B), symmetrise(digits.of(M)))
    within(found, divided(rational(B), (rational(M) + rational(M).T) / 2), digits)


@pytest.mark.parametrize("digits", [Rounded, Wide])
def test_errors_that_are_handed_on_stay_in_the_bound(pair, digits):
    """A factor that is off makes a product that is off by as much as that allows."""
    A, B, M = pair
    off = 1e-6 * np.abs(A)
    rough = digits(A + off, 1.000001 * off)
    for found, wanted in (
        (rough.dot(digits.of(B)), rational(A) @ rational(B)),
        (digits.of(B).dot(rough), rational(B) @ rational(A)),
        (rough + B, rational(A) + rational(B)),
    ):
        assert (np.abs(exact(found) - wanted) <= rational(found.off)).all()
    lent = 1e-9 * np.eye(len(M))
    found = solve_right(digits.of(B), digits(M + lent, 1.000001 * lent))
    wanted = divided(rational(B), rational(M))
    assert (np.abs(exact(found) - wanted) <= rational(found.off)).all()
    assert (found.off <= 1e-3 * np.abs(found.value).max()).all()


@pytest.mark.parametrize("digits", [Rounded, Wide])
def test_an_inverse_without_digits_is_bounded_by_nothing(digits):
    M = np.array([[1.0, 1.0], [1.0, 1.0 + 2e-16]])
    with np.errstate(all="ignore"):
        assert np.isinf(solve_right(digits.of(np.eye(2)), digits.of(M)).off).all()


def test_what_floats_lose_twice_the_digits_keep():
    A, B = np.array([[1e16, 1.0, -1e16]]), np.ones((3, 1))
    assert abs(Rounded.of(A).dot(Rounded.of(B)).off[0, 0]) > 1
    found = Wide.of(A).dot(Wide.of(B)).beside(np.zeros((1, 1)))
    assert found.value[0, 0] == 1 and found.off[0, 0] < 1e-9
