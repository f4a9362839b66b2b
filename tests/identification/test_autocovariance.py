"""Autocovariances of innovations, and the noises that they tell."""

import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.identification import autocovariance
from luenberger.identification.forms import form_of

A = np.array([[0.9, 0.3, 0], [-0.2, 0.8, 0.1], [0, 0, 0.7]])
C = np.array([[1.0, 0, 0], [0, 0, 1]])
Q, R = np.diag([0.5, 0.2, 1]), np.array([[1, 0.2], [0.2, 0.3]])
PLANT = lb.Plant(A, None, C, dt=1.0)


def noisy(rng, rows, A=A, C=C, Q=Q, R=R):
    n, p = len(A), len(C)
    w, v = (
        rng.normal(size=(rows, k)) @ scipy.linalg.sqrtm(X) for k, X in ((n, Q), (p, R))
    )
    x, y = np.zeros(n), []
    for k in range(rows):
        y.append(C @ x + v[k])
        x = A @ x + w[k]
    return np.array(y)


def exact(gain, S, lags):
    """E[nu_k nu_0'] from a joint covariance that is summed term by term."""
    A_L = A - gain @ C
    P = sum(
        np.linalg.matrix_power(A_L, k)
        @ (Q - S @ gain.T - gain @ S.T + gain @ R @ gain.T)
        @ np.linalg.matrix_power(A_L, k).T
        for k in range(300)
    )
    found = [C @ P @ C.T + R]
    for k in range(1, lags):
        power = np.linalg.matrix_power(A_L, k - 1)
        found.append(C @ power @ (A_L @ P @ C.T + S - gain @ R))
    return np.array(found)


@pytest.mark.parametrize("cross", [0.0, 0.3])
def test_the_model_is_what_a_sum_of_all_terms_gives(cross):
    gain = autocovariance.gain_for(PLANT, np.eye(3), np.eye(2))
    S = cross * np.ones((3, 2))
    found = autocovariance._autocovariances(PLANT, gain, Q[None], R[None], S[None], 5)
    np.testing.assert_allclose(found[0], exact(gain, S, 5), rtol=1e-10, atol=1e-13)


def test_innovations_of_any_start_are_those_of_the_right_one():
    """What the unknown start adds is taken off, also of a mode that grows."""
    grows = lb.Plant([[1.2]], [[1.0]], [[1.0]], [[0.5]], dt=1.0)
    gain = autocovariance.gain_for(grows, np.eye(1), np.eye(1))
    u = np.sin(np.arange(60.0))[:, None]
    x, y = 1000.0, []
    for one in u[:, 0]:
        y.append([x + 0.5 * one])
        x = 1.2 * x + one
    found = autocovariance.left(grows, gain, np.array(y), u)
    assert np.abs(found).max() < 1e-9 * np.abs(y).max()


@pytest.mark.parametrize("kind", ["full", "diagonal"])
def test_noises_are_found_again(kind):
    y = noisy(np.random.default_rng(5), 20_000)
    gain = autocovariance.gain_for(PLANT, np.eye(3), np.eye(2))
    size = np.sqrt((autocovariance.left(PLANT, gain, y, y[:, :0]) ** 2).mean(axis=0))
    forms = [
        form_of("Q", "diagonal", 3, None, None, np.ones(3)),
        form_of("R", kind, 2, None, None, size),
    ]
    theta = np.concatenate(
        [forms[0].at(np.eye(3), np.ones(3)), forms[1].at(np.eye(2), np.ones(2))]
    )
    given = [(y[:12_000], np.zeros((12_000, 0))), (y[12_000:], np.zeros((8_000, 0)))]
    units = np.ones(3), np.ones(2)
    found = autocovariance.by_autocovariances(
        PLANT, forms, units, None, theta, gain, given
    )
    errors = np.sqrt(found.spread(found.theta).diagonal())[:3]
    assert (np.abs(np.exp(2 * found.theta[:3]) - Q.diagonal()) < 3 * errors).all()
    assert (errors < 0.2 * Q.diagonal()).all()


def test_a_search_that_begins_at_rounding_noise_goes_as_far():
    """SciPy's first step is as long as the vector that it begins with."""
    forms = [form_of(x, "diagonal", 1, None, None, np.ones(1)) for x in "QR"]
    H = np.array([[1.0, 2.0], [0.5, -1.0], [0.3, 0.1]])
    data = autocovariance.Moments(H @ [4.0, 0.25], H, 100)
    for start in (0.0, 1e-16, -1e-12):
        begin = np.full(2, start)
        units = np.ones(1), np.ones(1)
        found = autocovariance.Fit(data, forms, units, begin).least().theta
        np.testing.assert_allclose(found, np.log([2, 0.5]), rtol=1e-6)
