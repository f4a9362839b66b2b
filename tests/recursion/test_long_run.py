"""The paper's tracker for 10^6 steps: the one test that takes a minute.

It stands alone so that it runs beside the others.
"""

import numpy as np
import pytest

import luenberger as lb
from luenberger.papers.leondes_novak.design import gains
from luenberger.recursion.settings import Settings

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


@pytest.mark.parametrize("m1, steps", [(0, 10**5), (1, 10**6), (2, 10**5)])
def test_long_run_of_the_paper_tracker(m1, steps):
    """By the kernels of the library, as a design over steps uses them.

    Every covariance is symmetric to the bit, semi-definite to rounding, and, once it
    has settled, the steady one.
    """
    wanted = lb.reduced_order_filter(TRACKER, m1)
    wanted = lb.error_covariance(wanted, TRACKER)
    run = gains(Settings(TRACKER, m1), steps)
    block = np.empty((1000, 3, 3))
    for start in range(0, steps, 1000):
        for k in range(1000):
            _, _, block[k] = next(run)
        assert np.array_equal(block, block.mT)
        assert np.linalg.eigvalsh(block).min() > -1e-15
        if start >= 1000:
            assert np.abs(block - wanted).max() < 1e-12


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
