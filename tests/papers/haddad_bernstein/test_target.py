"""The problem that the fixed-order search solves: what it is measured by."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.papers.haddad_bernstein.assembly import observer_of
from luenberger.papers.haddad_bernstein.descent import evaluate
from luenberger.papers.haddad_bernstein.target import prediction, target

A = np.array([[0.8, 0.3, 0.0], [-0.2, 0.7, 0.1], [0.0, 0.4, 0.5]])
L = np.array([[1.0, -2.0, 0.5], [0.0, 3.0, 1.0]])
WEIGHT = np.array([[2.0, 0.7], [0.7, 1.5]])


@pytest.mark.parametrize("units", [[1, 1, 1], [1e3, 1, 1e-4]])
def test_power_is_what_the_estimate_weighs_were_its_states_independent(units):
    """tr(W L diag(var x) L') in any units, the states' correlation left out."""
    U = np.diag(units)
    Q = np.diag([0.3, 0.1, 0.7])
    plant = lb.Plant(U @ A @ np.linalg.inv(U), None, [[1, 0, 0]] @ np.linalg.inv(U),
                     dt=1.0, Q=U @ Q @ U, R=[[0.5]])  # fmt: skip
    X = scipy.linalg.solve_discrete_lyapunov(A, Q)
    found = target(prediction(plant, L @ np.linalg.inv(U), WEIGHT, True))
    wanted = np.trace(WEIGHT @ L @ np.diag(X.diagonal()) @ L.T)
    assert found.power == pytest.approx(wanted, rel=1e-9)


def test_scale_is_the_mean_square_of_what_the_kalman_filter_estimates():
    """tr(W L (X - Omega) L'): the state's covariance less the prediction error's."""
    plant = lb.Plant(
        A, None, [[1, 0, 0]], dt=1.0, Q=np.diag([0.3, 0.1, 0.7]), R=[[0.5]]
    )
    X = scipy.linalg.solve_discrete_lyapunov(A, plant.Q)
    Omega = scipy.linalg.solve_discrete_are(A.T, plant.C.T, plant.Q, plant.R)
    found = target(prediction(plant, L, WEIGHT, False))
    wanted = np.trace(WEIGHT @ L @ (X - Omega) @ L.T)
    assert found.scale == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("feedthrough", [True, False])
def test_a_whitened_estimator_costs_the_excess(
    feedthrough,
):
    """Innovations of unit covariance and a weight of one are another way to say it."""
    rng = np.random.default_rng(6)
    A, C, L = rng.normal(size=(4, 4)), rng.normal(size=(2, 4)), rng.normal(size=(2, 4))
    noise, weight = rng.normal(size=(6, 6)), rng.normal(size=(2, 2))
    noise, weight = noise @ noise.T, weight @ weight.T
    plant = lb.Plant(
        A / np.linalg.norm(A, 2), None, C, dt=1.0,
        Q=noise[:4, :4], S=noise[:4, 4:], R=noise[4:, 4:],
    )  # fmt: skip
    whole = prediction(plant, L, weight, feedthrough)
    sought = target(whole)
    point = evaluate(sought, np.array([[0.5, 0.2], [-0.3, 0.4]]), np.eye(2))
    observer = observer_of(plant, whole, sought, SimpleNamespace(point=point))
    found = lb.optimality(observer, plant, weight=weight, feedthrough=feedthrough)
    assert found.cost == pytest.approx(whole.cost + point.cost, rel=1e-9)
