"""The torque of a shaft between motor and load, in at most 30 multiply-adds a step.

The motor's speed is read a thousand times a second, and its current is known.
"""

import numpy as np

import luenberger as lb

J_MOTOR, J_LOAD, STIFF, DAMP = 0.01, 0.04, 60.0, 0.05
A = [
    [-DAMP / J_MOTOR, DAMP / J_MOTOR, -1 / J_MOTOR],
    [DAMP / J_LOAD, -DAMP / J_LOAD, 1 / J_LOAD],
    [STIFF, -STIFF, 0],
]
drive = lb.Plant(
    A, [[0.5 / J_MOTOR], [0], [0]], [[1, 0, 0]], Q=np.diag([0.5, 4, 0.01]),
    R=[[1e-3]], P0=np.diag([1, 1, 1]),
    state_names=["motor speed (rad/s)", "load speed (rad/s)", "torque (Nm)"],
    input_names=["current (A)"], output_names=["speed (rad/s)"],
).sampled(1e-3)  # fmt: skip
table = lb.compare(drive, L="torque (Nm)", budget=dict(multiply_adds=30))
design = table.recommended()

# -- the same numbers from the plant at work

assert design.observer.estimate_names == ("torque (Nm)",)
assert design.work == lb.export.multiply_adds(design.observer) <= 30
true = lb.monte_carlo(drive, design.observer, runs=1500, steps=400, seed=2)
np.testing.assert_allclose(true.covariance[-1], design.trace, rtol=0.15)
current = 20 * np.sign(np.sin(np.arange(20_001) / 50))[:, None]  # A, back and forth
driven = lb.simulate(drive, design.observer, 20_000, u=current, seed=3)
assert np.ptp(driven.w_hat) > 10  # Nm: the estimate is driven, its error is not
errors = driven.error[400:] ** 2
np.testing.assert_allclose(errors.mean(), design.trace, rtol=0.15)
assert design.error <= 1.1 * table.yardstick.error
