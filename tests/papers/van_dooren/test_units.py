"""Units of states, outputs and time play no part in the observer of the whole state."""

import warnings

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

import luenberger as lb
from luenberger.numeric.staircase_form import staircase

METHODS = ("minimum-norm", "back-substitution")


def drawn(rng):
    """Small integers with what makes rounding decide: zeros, a chain, a singular A."""
    n = int(rng.integers(2, 7))
    p = int(rng.integers(1, min(n, 4)))
    A = rng.integers(-3, 4, (n, n)) / 4
    match rng.integers(4):
        case 0:
            A = np.triu(A)
        case 1:
            A[rng.random((n, n)) < 0.5] = 0
        case 2:
            A = np.diag(rng.integers(1, 4, n - 1) / 1.0, 1) + np.diag(A.diagonal())
        case 3:
            A[:, rng.integers(n)] = 0
    C = rng.integers(-2, 3, (p, n)) * (rng.random((p, n)) < 0.6) * 1.0
    order = rng.permutation(n)
    return A[np.ix_(order, order)], C[:, order], float(rng.integers(2))


def designed(A, C, dt, poles, method):
    """The observer, or the kind of refusal; without a word on digits."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            plant = lb.Plant(A, None, C, dt=dt)
            return lb.reduced_order_observer(plant, poles, method=method)
        except lb.DesignError as refusal:
            return str(refusal)[:14]


def first_of_its_part(A, C):
    """For each state the first of those that it is connected with."""
    links = np.block([[A != 0, (C != 0).T], [C != 0, np.eye(len(C))]])
    _, part = connected_components(links, directed=False)
    return np.array([np.argmax(part == mine) for mine in part[: len(A)]])


@pytest.mark.parametrize("method", METHODS)
def test_a_plant_in_other_units_has_the_same_observer_in_them(method):
    """Every bit of it, for units up to 2^40; two of three had been refused."""
    found = 0
    for seed in range(40):
        rng = np.random.default_rng([5, seed])
        A, C, dt = drawn(rng)
        order = len(A) - np.linalg.matrix_rank(C)
        poles = (rng.integers(1, 7, order) - (0 if dt else 7)) / 8
        one = designed(A, C, dt, poles, method)
        x, y = (2.0 ** rng.integers(-40, 41, size) for size in C.shape[::-1])
        x /= x[first_of_its_part(A, C)]  # whose unit is the observer's
        rate = 1.0 if dt else 2.0 ** rng.integers(-40, 41)
        A, C, poles = A * rate * x / x[:, None], C * x / y[:, None], poles * rate
        plant = lb.Plant(A, None, C, dt=dt)
        other = designed(A, C, dt, poles, method)
        if isinstance(one, str):
            assert other == one == "not observable"[:14], seed
            continue
        found += 1
        assert lb.certify(other, plant).worst < 1e-14, seed  # in any unit of time
        for name, left, right in (
            ("F", rate, 1), ("T", 1, x), ("D", rate, y), ("P", 1 / x[:, None], 1),
            ("V", 1 / x[:, None], y),
        ):  # fmt: skip
            wanted = left * getattr(one, name) * right
            np.testing.assert_array_equal(getattr(other, name), wanted, (seed, name))
    assert found > 20


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("link", [1.0, 1e-11, 1e-60, 1e80])
def test_a_weak_link_costs_no_digits_of_T(method, link):
    """A unit of the second state; 8 of 16 digits were left for 1e-11."""
    plant = lb.Plant([[-1, link], [0, -2]], None, [[1, 0]])
    observer = designed(plant.A, plant.C, 0, [-5], method)
    t1, t2 = observer.T[0]
    assert t1 * link == pytest.approx(-3 * t2, rel=1e-15)  # column 2 of T A = F T + D C
    assert observer.D[0, 0] == pytest.approx(4 * t1, rel=1e-15)  # column 1
    np.testing.assert_allclose(observer.V[:, 0], [1, 3 / link], rtol=1e-15)
    assert lb.certify(observer, plant).worst < 1e-15


def test_the_units_given_are_those_of_the_paper():
    """The row of least norm (21) in the user's coordinates, and in no other."""
    A, C = np.array([[0.0, 1, 0], [-64, -1, 64], [0, 1, -2]]), np.eye(3)[[0, 2]]
    form = staircase(A, C)
    shifted = form.A + 5 * np.eye(3)
    M = np.vstack([shifted[1:], -form.C])
    best = np.linalg.lstsq(M.T, -shifted[0])[0]
    plant = lb.Plant(A, None, C)
    for units, same in (("given", True), ("even", False)):
        T = lb.reduced_order_observer(plant, [-5], units=units).T @ form.U
        assert np.allclose(T[0, 1:] / T[0, 0], best[:2]) == same
    with pytest.raises(ValueError, match="units must be 'even' or 'given', got 'SI'"):
        lb.reduced_order_observer(plant, [-5], units="SI")
