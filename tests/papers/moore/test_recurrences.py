"""Which coefficients of a recurrence are zero: cases just inside and just outside."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import luenberger as lb
from luenberger.papers.moore.recurrences import Admissible, OverFloats, time_scale

A = np.array([[0.1, 0.7, 0.0], [0.3, 0.2, 0.0], [0.1, 0.0, 0.6]])


def seen_first(k, size=2, **options):
    """k x of the first `size` states from the first of them; A is not exact."""
    A_ = A[:size, :size] * np.pi / 3
    return OverFloats(lb.Plant(A_, None, np.eye(1, size), **options), np.array(k))


@pytest.mark.parametrize(("leading", "admitted"), [(1.2e-11, True), (0.8e-11, False)])
def test_a_leading_coefficient_that_is_rounding_lowers_no_order(leading, admitted):
    """k = [1, e]: beta_0 k N + beta_1 k A N = 0 has beta_1 / beta_0 = -e / (k A N).

    With e = 0 no observer of order 1 exists; with a small e its pole is at about 1 / e.
    """

    def part(e):  # of the leading coefficient in rows of length one
        one = seen_first([1.0, e])
        size = np.linalg.norm(one.powers[:2], axis=1)
        u = (one.powers[:2] / size[:, None] @ one.unseen(1))[:, 0]
        return abs(u[0]) / np.linalg.norm(u)

    e = leading / part(1e-6) * 1e-6
    assert part(e) == pytest.approx(leading, rel=1e-3, abs=0)
    basis = seen_first([1.0, e]).basis(1)
    assert (basis is not None) is admitted
    if admitted:
        pole = -basis[0, 0] / basis[1, 0]
        assert abs(pole) > 1e9


@pytest.mark.parametrize(("seen", "free"), [(1.1e-12, 1), (0.9e-12, 2)])
def test_a_functional_of_the_outputs_but_for_rounding_admits_every_polynomial(
    seen, free
):
    """x3 is not seen, and decays by itself; k x has next to nothing of it.

    Counted, its mode must be a root, which leaves one coefficient of two.  In turned
    coordinates: as a state it would have a unit of its own, and count.
    """
    turn = np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0]
    plant = lb.Plant(turn @ A @ turn.T * np.pi / 3, None, np.eye(1, 3) @ turn.T, dt=1.0)

    def functional(e):
        return OverFloats(plant, turn @ [0.4, 1.0, e])

    def weight(e):
        one = functional(e)
        size = np.linalg.norm(one.powers[:3], axis=1)
        rows = one.powers[:3] / size[:, None] @ one.unseen(2)
        return np.linalg.svd(rows, compute_uv=False)[0]

    e = seen / weight(1e-6) * 1e-6
    found = functional(e).basis(2)
    assert found.shape[1] - 1 == free


@pytest.mark.parametrize(
    ("A", "scale"),
    [
        (np.diag([-1.0, -1.1e-6]), 2.0**-10),  # both rates: their mean is 2^-9.9
        (np.diag([-1.0, -0.9e-6]), 1.0),  # beside 1 rad/s that one is zero
        (np.array([[0, 1], [-(1.2e-7**2), 0]]), 2.0**-23),
        (np.array([[0, 1], [-(0.8e-7**2), 0]]), 1.0),  # rounding of a double zero
        (np.zeros((2, 2)), 1.0),
        (np.diag([-4.0, -16.0]), 8.0),
        (np.diag([-3.0, 3.0]), 4.0),  # 2^1.58
    ],
)
def test_time_scale_is_the_mean_of_the_rates_that_are_not_zero(A, scale):
    assert time_scale(A) == scale
    if A.any():  # and goes with the unit of time
        assert time_scale(2.0**30 * A) in (2.0**30 * scale, 1.0)
        assert time_scale(2.0**30 * A) != 1.0 or scale == 1.0


@pytest.mark.parametrize(
    ("kappa", "one_sign"),
    [
        ([2.0, -1.8e-11], True),
        ([2.0, -2.2e-11], False),
        ([-2.0, 1.8e-11], True),
        ([-2.0, 2.2e-11], False),
        ([2.0, 1.0], True),
        ([2.0, -1.0], False),
        ([Fraction(2), Fraction(-1, 10**20)], False),  # exact numbers have no rounding
        ([Fraction(2), Fraction(0)], True),
    ],
)
def test_signs_of_kappa(kappa, one_sign):
    """Moore: where they agree, no continuous observer is smaller than the plant."""
    exactly = isinstance(kappa[0], Fraction)
    kappa = np.array(kappa, dtype=object if exactly else float)
    one = SimpleNamespace(kappa=kappa, discrete=False, exactly=exactly)
    assert Admissible.kappa_has_one_sign(one) is one_sign
    one.discrete = True
    assert not Admissible.kappa_has_one_sign(one)
