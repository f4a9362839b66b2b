"""A measured ball on a beam: its velocity, which no sensor reads.

The plant gives no noises; the record does.
"""

from pathlib import Path

import numpy as np
import pandas as pd

import luenberger as lb

PLANTS = Path(__file__).parents[2] / "notebooks" / "plants"

record = pd.read_csv(PLANTS / "ball-and-beam.csv", index_col="time")
given = lb.Plant.from_json(PLANTS / "ball-and-beam.json").sampled(0.1)
fit = lb.fit_noise(given, record, Q=[[0.005], [0.1]])  # noise is an acceleration
design = lb.compare(fit.plant).recommended()
velocity = lb.estimate(design.observer, record)["velocity (m/s)"]

# -- the same numbers from the plant at work

claimed = lb.error_covariance(design.observer, fit.plant)
true = lb.monte_carlo(fit.plant, design.observer, runs=2000, steps=60, seed=1)
np.testing.assert_allclose(true.covariance[-1, 1, 1], claimed[1, 1], rtol=0.15)

# the real ball is not quite this plant, and the test of the innovations says so
assert not fit.whiteness.white and abs(fit.whiteness.autocorrelation).max() < 0.2
np.testing.assert_allclose(fit.whiteness.variance, 1, atol=0.1)

# the velocity adds up to the position that was measured: 0.1 s times its sum
moved = record["ball position (m)"].diff()[20:]
left = moved - 0.1 * velocity.shift()[20:]
assert left.std() < 0.5 * moved.std()
