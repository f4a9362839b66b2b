"""The best constant gain: of the true error, and only where the search arrived."""

import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.recursion import best_constant_gain, steady_gain
from luenberger.recursion.settings import setting


def correlated():
    """A plant whose process and measurement noise have much in common."""
    A = [[0.5, 1.1, 0.0], [-0.9, 0.3, 0.8], [0.2, -0.6, 0.9]]
    half = np.diag([0.3, 0.1, 0.1, 1.2, 1.5])
    half[3, :3], half[4, :3] = [0.5, 0.2, 0.0], [0.0, 0.3, 0.2]
    noise = half @ half.T
    Q, S, R = noise[:3, :3], noise[:3, 3:], noise[3:, 3:]
    return lb.Plant(A, None, np.eye(2, 3), dt=1.0, Q=Q, S=S, R=R)


def error_trace(plant, K):
    """tr E[e e'] of x^ = x^- + K (y - C x^-), x^-+ = A x^ + J (y - C x^), J = S R^-1.

    e+ = (I - K C)((A - J C) e + w - J v) - K v+, with w and v of one instant and v+ of
    the next side by side, and SciPy's Lyapunov equation.
    """
    p, J = plant.p, plant.S @ np.linalg.inv(plant.R)
    left = np.eye(plant.n) - K @ plant.C
    joint = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
    noise = scipy.linalg.block_diag(joint, plant.R)
    push = np.hstack([left, -left @ J, -K])
    Phi = left @ (plant.A - J @ plant.C)
    Sigma = scipy.linalg.solve_discrete_lyapunov(Phi, push @ noise @ push.T)
    assert push.shape == (plant.n, plant.n + 2 * p)
    return np.trace(Sigma)


def test_correlated_noises_count_in_the_best_constant_gain():
    plant = correlated()
    best = lb.reduced_order_filter(plant, 1, horizon="steady").V
    step = lb.reduced_order_filter(plant, 1).V
    least = error_trace(plant, best)
    assert least < 0.99 * error_trace(plant, step)
    rng = np.random.default_rng(0)
    for _ in range(5):  # gains with C1 x^ = y1: rows 2 and 3 are free
        d = np.vstack([np.zeros(2), rng.normal(size=(2, 2))])
        beside = [error_trace(plant, best + h * d) for h in (-1e-3, 1e-3)]
        curvature = (sum(beside) - 2 * least) / 2
        assert curvature > 0
        # of a parabola about its lowest point: both sides are as high
        assert abs(beside[0] - beside[1]) < 0.02 * curvature


@pytest.mark.parametrize(("residual", "arrived"), [(0.9e-9, True), (1.1e-9, False)])
def test_a_search_that_stalls_is_believed_below_1e_9(monkeypatch, residual, arrived):
    """The relative gradient that is left decides, and nothing else does here."""
    monkeypatch.setattr(
        best_constant_gain, "_descent", lambda now, K, *_: (residual, K)
    )
    design = lambda: lb.reduced_order_filter(correlated(), 1, horizon="steady")  # noqa: E731
    if arrived:
        assert lb.certify(design(), correlated()).stable
    else:
        with pytest.raises(lb.CertificateError, match=r"residual stays at 1\.1e-09"):
            design()


@pytest.mark.parametrize("size", [2.0**-200, 2.0**200])
def test_strength_of_all_noise_does_not_end_the_recursion(size):
    """Sigma for size Q and size R is size Sigma, to the last bit."""
    plain = correlated()
    other = lb.Plant(plain.A, None, plain.C, dt=1.0, Q=size * plain.Q, R=size * plain.R,
                     S=size * plain.S)  # fmt: skip
    one, two = (setting(plant, [0]) for plant in (plain, other))
    start = np.eye(3)
    found = (
        steady_gain._recur(one, start, 60),
        steady_gain._recur(two, size * start, 60),
    )
    np.testing.assert_array_equal(found[0] * size, found[1])
    assert not np.array_equal(found[0], steady_gain._recur(one, start, 5))
