"""The paper's tracker for as many steps as anybody likes."""

import itertools

import numpy as np
import pytest

import luenberger as lb
from luenberger.filtering.maps import Settings
from luenberger.filtering.pack import over_steps

# The paper's tracker, (54) to (56): T = 1 s, position to 0.5 m, velocity to 2 m/s,
# acceleration steps of 1 m/s^2; P0 is (58).
TRACKER = lb.Plant(
    [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]],
    None,
    [[1, 0, 0], [0, 1, 0]],
    dt=1.0,
    Q=np.diag([0.0, 0, 1]),
    R=np.diag([0.25, 4]),
    P0=[[0.25, 0.375, 0.25], [0.375, 1.6875, 1.625], [0.25, 1.625, 2.75]],
)


@pytest.mark.parametrize("m1", [0, 1, 2])
def test_long_run_of_the_paper_tracker(m1):
    """By the kernels of the library, as a design over steps uses them.

    Every covariance is symmetric to the bit, semi-definite to rounding, and, once it
    has settled, the steady one.  Early on one comes back to the bit, and what follows
    it follows again: so it is for 10^6 steps as well, which took half a minute.
    """
    wanted = lb.reduced_order_filter(TRACKER, m1)
    wanted = lb.error_covariance(wanted, TRACKER)
    run, _ = over_steps(Settings(TRACKER, m1), 10_000)
    assert np.array_equal(run, run.mT)
    assert np.linalg.eigvalsh(run).min() > -1e-15
    assert np.abs(run[1000:] - wanted).max() < 1e-12
    seen = {}  # the step at which a covariance was there first
    for step, Sigma in enumerate(run):
        first = seen.setdefault(Sigma.tobytes(), step)
        if first < step:
            break
    assert first < step, "none comes back: take 10^6 steps again"
    again = itertools.cycle(run[first:step])
    assert all(np.array_equal(*pair) for pair in zip(run[step:], again))


def test_canary_the_naive_update_explodes_on_the_tracker():
    """Om - K (Om H')', equal on paper, is lost within 200 steps: why Joseph's form.

    If this test fails, NumPy has changed and the reason for the form is gone.
    """
    A, C, Q, R = TRACKER.A, TRACKER.C, TRACKER.Q, TRACKER.R
    Sigma = TRACKER.P0
    largest = 0.0
    for _ in range(200):
        Omega = A @ Sigma @ A.T + Q
        HOmega = Omega @ C.T
        K = np.linalg.solve((C @ HOmega + R).T, HOmega.T).T
        Sigma = Omega - K @ HOmega.T
        largest = max(largest, np.abs(Sigma).max())
        if largest > 1e6:
            break
    assert largest > 1e6
