"""Stable members of affine families, against roots, grids and other tests."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest
import scipy.linalg

from luenberger.numeric import rationals
from luenberger.papers.moore.stable_polynomials import (
    _mean,
    decide,
    is_stable,
    one_signed,
    radius,
    search,
    to_disc,
    to_half_plane,
)

both_times = pytest.mark.parametrize("discrete", [False, True], ids=["s", "z"])


def fractions(values):
    values = np.asarray(values)
    out = rationals.zeros(*values.shape)
    out.flat = [Fraction(int(x)) for x in values.flat]
    return out


def jury(beta):
    """Schur's test by Jury's table, ascending coefficients; the second method."""
    beta = list(beta)
    while len(beta) > 1:
        first, last = beta[0], beta[-1]
        if not abs(first) < abs(last):
            return False
        beta = [
            last * b - first * c
            for b, c in zip(beta[1:], beta[::-1][1:])  # degree falls by one
        ]
    return True


def family(a, discrete):
    """The polynomials with a h = 0, h their coefficients in the half plane."""
    maps = to_half_plane(np.eye(a.shape[-1]), discrete)
    return np.linalg.solve(maps, scipy.linalg.null_space(np.atleast_2d(a)))


def members(basis, rng, count):
    """Monic members of a family, far and near."""
    y = rng.standard_normal((basis.shape[1], count)) * 10 ** rng.uniform(-1, 2, count)
    found = basis @ y
    return (found / found[-1]).T


def with_radius(beta, discrete):
    return radius(np.roots(beta[::-1]), discrete)


@both_times
def test_exact_stability_is_that_of_the_roots(discrete):
    rng, seen = np.random.default_rng(4), set()
    for k in range(300):
        r = rng.integers(1, 6)
        beta = np.r_[rng.integers(-3, 8, r), rng.integers(2, 9)]
        if k % 2:  # real roots, most of them stable
            factors = [[rng.integers(1, 4), rng.integers(3, 6)] for _ in range(r)]
            beta = np.array([1])
            for factor in factors:
                beta = np.convolve(beta, factor)
        size = with_radius(beta.astype(float), discrete)
        if abs(size - 1) > 1e-6:
            stable = is_stable(fractions(beta), discrete)
            assert stable == (size < 1) == is_stable(beta.astype(float), discrete)
            seen.add((int(r), stable))
    assert len(seen) == 10  # both answers at every degree


def test_schur_by_routh_is_schur_by_jury():
    rng, seen = np.random.default_rng(5), set()
    for _ in range(400):
        beta = fractions(np.r_[rng.integers(-4, 5, rng.integers(1, 6)), 4])
        seen.add(is_stable(beta, True))
        assert is_stable(beta, True) == jury(beta)
    assert seen == {False, True}


@pytest.mark.parametrize(
    ("beta", "discrete"),
    [
        ([0, 1, 1], False),  # s (s + 1)
        ([1, 0, 1], False),  # +- i
        ([1, 1, 1, 1], False),  # (s + 1)(s^2 + 1)
        ([-1, 0, 1], True),  # (z - 1)(z + 1)
        ([1, 1, 1], True),  # on the circle
    ],
)
@pytest.mark.parametrize("kind", [fractions, lambda b: np.array(b, float)])
def test_the_boundary_is_not_stable(beta, discrete, kind):
    assert not is_stable(kind(beta), discrete)
    assert not decide(kind(beta)[:, None], discrete).stable


@both_times
def test_both_maps_keep_the_polynomial(discrete):
    beta = np.array([[2.0, -1.0, 0.5, 1.0]]).T
    w = 0.3 + 0.2j
    zeta = (1 + w) / (1 - w)
    s = zeta if discrete else w
    value = np.polyval(beta[::-1, 0], s)
    half = np.polyval(to_half_plane(beta, discrete)[::-1, 0], w)
    disc = np.polyval(to_disc(beta, discrete)[::-1, 0], zeta)
    assert np.isclose(half, value * ((1 - w) ** 3 if discrete else 1))
    assert np.isclose(disc, value * (1 if discrete else (zeta + 1) ** 3))


@both_times
@pytest.mark.parametrize("r", [1, 2])
def test_orders_one_and_two_against_a_grid(discrete, r):
    """Existence and least radius of lines of polynomials, by brute force."""
    rng, answers = np.random.default_rng(6), []
    for _ in range(6):
        basis = family(rng.standard_normal(r + 1), discrete)
        found = decide(basis, discrete)
        y0 = basis.T @ np.eye(r + 1)[-1]
        y0 = y0 / (basis[-1] @ y0)
        line = scipy.linalg.null_space(basis[-1:])
        points = [basis @ y0] if r == 1 else []
        for c in np.tan(np.linspace(-1.5707, 1.5707, 1501)) if r == 2 else ():
            points.append(basis @ (y0 + line[:, 0] * c))
        least = min(with_radius(beta, discrete) for beta in points)
        answers.append(found.stable)
        assert found.stable == (least < 1)
        if found.stable:
            assert radius(found.roots, discrete) <= least + 1e-9
            assert radius(found.roots, discrete) >= least - 0.03
    assert set(answers) == {False, True}


@both_times
@pytest.mark.parametrize("r", [2, 3, 5])
def test_one_equation_is_solved_at_its_optimum(discrete, r):
    rng, stable = np.random.default_rng(r), 0
    for _ in range(2):
        a = rng.standard_normal(r + 1) / [comb(r, j) for j in range(r + 1)]
        basis = family(a, discrete)
        found = decide(basis, discrete)
        searched = radius(search(basis, discrete), discrete)
        assert found.decided == "exact"
        assert found.stable == ((a > 0).any() and (a < 0).any())
        if not found.stable:
            assert searched > 1 - 1e-9
            continue
        stable += 1
        rho = radius(found.roots, discrete)
        assert searched >= rho - 1e-9  # no descent gets below
        assert searched - rho < 0.1 * (1 - rho)  # and the search gets near
        beta = np.poly(found.roots)[::-1].real
        off = a @ to_half_plane(beta[:, None], discrete)[:, 0]
        assert abs(off) < 1e-9 * np.abs(a).max() * np.abs(beta).sum()
    assert stable


@both_times
def test_a_proof_of_none_is_never_contradicted(discrete):
    rng, count = np.random.default_rng(8), 0
    for _ in range(20):
        a = rng.standard_normal((2, 5)) + rng.choice([0, 0.7])
        if one_signed(a):
            count += 1
            basis = family(a, discrete)
            assert decide(basis, discrete).decided == "sign condition"
            for beta in members(basis, rng, 100):
                assert with_radius(beta, discrete) > 1 - 1e-9
            if count == 1:
                assert radius(search(basis, discrete), discrete) > 1 - 1e-9
    assert count > 3


def test_a_combination_of_rows_is_found_and_proved_exactly():
    rows = fractions([[1, -1, 0, 3, 1], [0, 2, 1, -2, 1]])  # the sum is positive
    assert one_signed(rows)
    assert one_signed(fractions([[0, 1, 0, 2, 0], [1, -1, 1, -1, 1]]))  # one row is
    assert not one_signed(fractions([[1, -1, 0, 3, 1], [0, 2, 1, -2, -9]]))


@pytest.mark.parametrize("exact", [True, False])
def test_a_combination_with_a_small_entry_of_the_other_sign_proves_nothing(exact):
    """a, b with 4 b >= a have 2 a < 9 b, to 1e-10; HiGHS drops so small an entry."""
    rows = fractions([[-(10**9), 2, 0], [4 * 10**9, -9, 10**10]])
    assert not one_signed(rows if exact else rows.astype(float))


def test_search_alone_says_so():
    # s^3 + c s^2 + s + c + 1: all positive, but c * 1 > c + 1 never holds (Routh)
    basis = fractions([[1, 1], [1, 0], [0, 1], [1, 0]])
    for one in (basis, basis.astype(float)):
        found = decide(one, False)
        assert (found.decided, found.stable) == ("search", False)
    basis = family(np.array([[1.0, -1, 0, 0], [0, 1, -1, 0]]), True)
    assert decide(basis, True).decided == "search" and decide(basis, True).stable


@both_times
def test_exact_families_give_simple_exact_answers(discrete):
    rng, kinds = np.random.default_rng(9), set()
    for _ in range(24):
        r = int(rng.integers(1, 5))
        basis = fractions(rng.integers(-3, 4, (r + 1, rng.integers(1, r + 2))))
        basis[-1, 0] = Fraction(1)
        if len(rationals.reduced(basis)[1]) < basis.shape[1]:
            continue
        found, floats = decide(basis, discrete), decide(basis.astype(float), discrete)
        assert found.stable == floats.stable
        kinds.add((found.stable, found.decided))
        if found.stable:
            assert found.beta.dtype == object and found.beta[-1] == 1
            assert is_stable(found.beta, discrete)
            both = np.column_stack([basis, found.beta])
            assert len(rationals.reduced(both)[1]) == basis.shape[1]
            best = radius(floats.roots, discrete)
            assert radius(found.roots, discrete) < 0.8 * best + 0.2 + 1e-6
    assert (True, "exact") in kinds and (False, "exact") in kinds


def test_exact_null_space_and_echelon():
    M = fractions([[1, 2, 3, 4], [2, 4, 6, 9], [3, 6, 9, 13]])
    echelon, pivots = rationals.reduced(M)
    assert pivots == [0, 3] and echelon.tolist() == [[1, 2, 3, 0], [0, 0, 0, 1]]
    N = rationals.null_space(M)
    assert N.shape == (4, 2) and not (M @ N).any()
    assert rationals.null_space(rationals.zeros(0, 3)).tolist() == np.eye(3).tolist()


@pytest.mark.parametrize("power", [2, 20])
def test_the_mean_of_the_roots_moves_as_its_gradient_says(power):
    g0, weight = np.array([0.1, -0.3, 0.2, 1.0]), np.array([3.0, 0.5, 2.0, 1.0])
    Z = np.array([[1.0, 0.2], [0.5, -1.0], [0.3, 0.7], [0.0, 0.0]])
    c, h = np.array([0.4, -0.2]), 1e-6

    def mean(c):
        return _mean(c, g0, Z, weight, power)

    wanted = [(mean(c + s)[0] - mean(c - s)[0]) / (2 * h) for s in h * np.eye(2)]
    np.testing.assert_allclose(mean(c)[1], wanted, rtol=1e-6)


def test_roots_that_coincide_give_a_gradient_that_is_finite():
    g0, Z = np.array([0.25, -1.0, 1.0]), np.eye(3, 1)
    value, gradient = _mean(np.zeros(1), g0, Z, np.ones(3), 2)
    assert np.isfinite(value) and np.isfinite(gradient).all()
