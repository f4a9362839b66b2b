"""Exponentials of one matrix over many times, and the periods made of them."""

import mpmath
import numpy as np
import pytest

import luenberger as lb
from luenberger import period
from luenberger.period import series, squared, squarings

TIMES = np.array([0.5001, 0.625, 0.9, 1.0])


def exactly(M, t):
    with mpmath.workdps(60):
        found = mpmath.expm(mpmath.matrix(M.tolist()) * mpmath.mpf(t))
        return np.array(found.tolist(), dtype=float)


def off(found, exact):
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("size", [1e-9, 0.3, 1.0, 40.0])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_exponentials_are_those_of_sixty_digits(n, size):
    M = np.random.default_rng(n).normal(size=(n, n))
    M *= size / np.abs(M).sum(axis=0).max()
    count = squarings(M)
    found = squared(series(M / 2**count, TIMES), count)
    for t, one in zip(TIMES, found):
        assert off(one, exactly(M, t)) < 1e-15 * 2**count * (n + 2)


def test_a_block_above_may_be_of_any_size():
    """It is integrated: what is left out of the series is judged beside it."""
    A, Q = np.array([[-0.4, 0.6], [0.3, -0.2]]), 1e12 * np.eye(2)
    M = np.block([[-A, Q], [np.zeros((2, 2)), A.T]])
    for t, one in zip(TIMES, series(M, TIMES)):
        exact = exactly(M, t)
        assert off(one[:2, 2:], exact[:2, 2:]) < 1e-15
        assert off(one[2:, 2:], exact[2:, 2:]) < 1e-15


def integrated(A, Q, t, digits):
    """Van Loan's Q of one period; e^(-A t) takes as many digits as it grows by."""
    n = len(A)
    with mpmath.workdps(digits):
        M = np.block([[-A, Q], [np.zeros((n, n)), A.T]])
        E = mpmath.expm(mpmath.matrix(M.tolist()) * mpmath.mpf(t))
        return np.array((E[n:, n:].T * E[:n, n:]).tolist(), dtype=float)


@pytest.mark.parametrize("rate", [0.0, 0.5, 30.0, 300.0])
def test_periods_of_a_stiff_plant(rate):
    """Between two powers of two, and across; a fast state beside a slow one."""
    A = np.array([[0, 1, 0], [-1, -0.2, 1], [0, 0, -rate]])
    B, Q = np.array([[0.0], [1.0], [2.0]]), np.diag([0.0, 0.1, 2.0])
    T = np.array([0.13, 0.2, 0.26, 1.7])
    for t, A_i, B_i, Q_i in zip(T, *period.over_periods(A, B, Q, T)):
        held = exactly(np.block([[A, B], [np.zeros((1, 4))]]), t)
        assert off(A_i, held[:3, :3]) < 3e-13
        assert off(B_i, held[:3, 3:]) < 3e-13
        assert off(Q_i, integrated(A, Q, t, 60 + int(rate * t))) < 3e-13


def test_blocks_of_periods_are_the_same_bits(monkeypatch):
    plant = lb.Plant(
        [[0, 1], [-4, -30]], [[0], [1]], [[1, 0]], Q=np.diag([0.0, 2]), R=[[1]]
    )
    T = np.random.default_rng(3).uniform(0.02, 2, 200)
    whole = lb.sampling.discretise(plant, T)
    monkeypatch.setattr(period, "TOGETHER", 7)
    parts = lb.sampling.discretise(plant, T)
    for name in "ABQ":
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
