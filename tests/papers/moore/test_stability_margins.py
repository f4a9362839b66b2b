"""What rounding may be in a coefficient, a radius or a sign: inside and outside."""

from fractions import Fraction

import numpy as np
import pytest

from luenberger.papers.moore import stable_polynomials
from luenberger.papers.moore.stable_polynomials import is_stable, radius


def ascending(*roots):
    return np.poly(roots)[::-1].astype(float)


@pytest.mark.parametrize(("least", "stable"), [(1.2e-13, True), (0.8e-13, False)])
@pytest.mark.parametrize("size", [1.0, 2.0**40])
def test_a_coefficient_that_is_rounding_is_not_positive(least, stable, size):
    """s^2 + s + e, and s^2 + e s + 1, of floats; of Fractions any e > 0 will do."""
    for beta in ([least, 1.0, 1.0], [1.0, least, 1.0]):
        assert is_stable(size * np.array(beta), False) is stable
        exactly = np.array([Fraction(x) for x in beta], dtype=object)
        assert is_stable(exactly, False) and is_stable(-exactly, False)
        exactly[exactly == Fraction(least)] = Fraction(0)
        assert not is_stable(exactly, False)


@pytest.mark.parametrize("roots", [[-1, -2, -3], [-1, 2, -3], [-0.1, -5, 0.1], [1, 2]])
@pytest.mark.parametrize("discrete", [False, True])
def test_routh_agrees_with_the_roots(roots, discrete):
    roots = np.array(roots) * (0.4 if discrete else 1.0)
    inside = (np.abs(roots) < 1) if discrete else (roots < 0)
    assert is_stable(ascending(*roots), discrete) == inside.all()


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(("short", "stable"), [(1.1e-9, True), (0.9e-9, False)])
def test_a_radius_next_to_one_is_on_the_boundary(short, stable, discrete):
    """zeta = 1 - e is z, or s = (zeta - 1) / (zeta + 1), about -e / 2."""
    zeta = 1 - short
    root = zeta if discrete else (zeta - 1) / (zeta + 1)
    assert radius(np.array([root]), discrete) == pytest.approx(zeta, abs=1e-15)
    found = stable_polynomials.decide(ascending(root)[:, None], discrete)
    assert found.stable is stable and found.decided == "exact"
    roots = np.array([root, root])
    basis = np.array([[1.0, 0], [0, 1], [0, 0]])
    assert stable_polynomials._rounded("exact", roots, basis, discrete).stable is stable


@pytest.mark.parametrize(("part", "signs"), [(1.1e-11, 2), (0.9e-11, 1)])
def test_a_sign_of_rounding_is_none(part, signs):
    """An entry counts with its binomial, as in (1 + w)^r: the middle of three twice."""
    assert stable_polynomials._signs(np.array([1.0, 0.0, -part])) == signs
    assert stable_polynomials._signs(np.array([-1.0, part / 2, -0.5])) == signs
    assert stable_polynomials._signs(np.array([Fraction(1), Fraction(-1, 10**30)])) == 2
    assert stable_polynomials._signs(np.array([Fraction(0), Fraction(0)])) == 0


@pytest.mark.parametrize(("part", "found"), [(0.9e-11, [1.0]), (1.2e-11, None)])
def test_a_root_at_one_is_the_boundary_itself(part, found):
    """f(1) beside the sum of its terms; 2 - 2 q has its root at one."""
    f = np.array([2.0, -2.0 + 4 * part])
    assert (stable_polynomials._beyond_one(f) == [1.0]) is (found is not None)


@pytest.mark.parametrize(("lead", "degree"), [(1.1e-11, 2), (0.9e-11, 1)])
def test_a_leading_coefficient_of_rounding_lowers_the_degree(lead, degree):
    """(q - 2)(1 + e q) has its second root at -1 / e, too far to be meant: e q^2."""
    roots = stable_polynomials._beyond_one(np.array([-3.0, 1.0, -lead * 3.0]))
    assert len(roots) == degree and min(roots) == pytest.approx(3.0, rel=1e-6)


@pytest.mark.parametrize(("imaginary", "count"), [(0.5e-9, 2), (2e-9, 0)])
def test_a_pair_of_roots_next_to_the_real_line_is_real(imaginary, count, monkeypatch):
    pair = 3 * np.array([1 + 1j * imaginary, 1 - 1j * imaginary])
    monkeypatch.setattr(stable_polynomials.np, "roots", lambda f: pair)
    assert len(stable_polynomials._beyond_one(np.array([9.0, -6.0, 1.0]))) == count
