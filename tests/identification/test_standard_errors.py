"""Standard errors hang on the model, not on the numbers that it is written in."""

import numpy as np
import pytest

import luenberger as lb

A = np.array([[0.8, 0.3], [-0.2, 0.6]])
Q = np.array([[1.0, 0.4], [0.4, 0.8]])
BOTH = lb.Plant(A, None, np.eye(2), dt=1.0, Q=Q, R=0.2 * np.eye(2), P0=np.eye(2))


def record(plant, rows=600, seed=4):
    return lb.simulate(plant, lb.kalman_filter(plant), rows, seed=seed).y


def test_a_sum_of_correlated_numbers_has_the_error_of_the_sum():
    """Q in full, and as G diag(q) G': the same Q, which three numbers q make."""
    y = record(BOTH)
    G = [[1, 0, 1], [0, 1, 1]]
    full, parts = lb.fit_noise(BOTH, y, R=None), lb.fit_noise(BOTH, y, Q=G, R=None)
    np.testing.assert_allclose(parts.plant.Q, full.plant.Q, rtol=1e-3)
    wanted, found = full.standard_errors["Q"], parts.standard_errors["Q"]
    np.testing.assert_allclose(found, wanted, rtol=1e-2)
    assert parts.standard_errors["q[2]"] == pytest.approx(wanted[0, 1], rel=1e-2)
    q = [parts.standard_errors[f"q[{k}]"] for k in range(3)]
    alone = np.hypot(q[0], q[2])  # as if q[0] and q[2] erred independently
    assert abs(alone / wanted[0, 0] - 1) > 0.05


ONE = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=np.diag([0.5, 2]), R=[[1]], P0=np.eye(2))


@pytest.mark.parametrize(
    ("function", "slope"),
    [
        (np.diag, lambda q: 1 + 0 * q),
        (lambda q: np.diag(3 * q), lambda q: 3 + 0 * q),
        (lambda q: np.diag(q**2), lambda q: 2 * q),
    ],
)
def test_a_function_of_numbers_has_the_errors_of_the_entries_it_makes(function, slope):
    y = record(ONE)
    plain = lb.fit_noise(ONE, y, Q="diagonal")
    start = {"Q": [1.0, 1.0]}
    found = lb.fit_noise(ONE, y, Q=function, start=start)
    wanted = plain.standard_errors["Q"].diagonal()
    made = found.standard_errors["Q"].diagonal()
    np.testing.assert_allclose(found.plant.Q, plain.plant.Q, atol=2e-3)
    np.testing.assert_allclose(made, wanted, rtol=2e-2)
    q = np.array([found.parameters[f"q[{k}]"] for k in range(2)])
    error = [found.standard_errors[f"q[{k}]"] for k in range(2)]
    np.testing.assert_allclose(error, wanted / slope(q), rtol=2e-2)
    (R,) = found.standard_errors["R"]
    assert R == pytest.approx(plain.standard_errors["R"][0], rel=2e-2)
