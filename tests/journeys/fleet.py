"""Thousands of devices of one kind, each with a record of its own.

Any executor of `concurrent.futures`, or a Dask client, filters parts of them.  Run with
a number of devices, such as 5000, to see how long it takes; the test takes 40.
"""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import luenberger as lb

DEVICES = int(sys.argv[1]) if len(sys.argv) > 1 else 40
ROWS = 200
plant = lb.Plant(
    [[1, 0.1], [0, 1]], None, [[1, 0]], dt=0.1, Q=np.diag([1e-4, 1e-2]), R=[[0.04]],
    P0=np.eye(2), state_names=["level", "slope"], output_names=["sensor"],
)  # fmt: skip


def record(device: int) -> tuple[np.ndarray, np.ndarray]:
    """States and readings of a device, of which a tenth is missing."""
    rng = np.random.default_rng([5, device])
    x, states = rng.normal(size=2), np.empty((ROWS, 2))
    noise = rng.normal(size=(ROWS, 2)) * np.sqrt(np.diag(plant.Q))
    for k in range(ROWS):
        states[k] = x = plant.A @ x + noise[k]
    y = states[:, :1] + 0.2 * rng.normal(size=(ROWS, 1))
    y[rng.random(ROWS) < 0.1] = np.nan
    return states, y


states, y = map(np.stack, zip(*map(record, range(DEVICES))))
run, parts = lb.Filter(plant), lb.Record(y).split(64)
with ThreadPoolExecutor() as executor:
    found = [(part.x, part.std) for part in executor.map(run.run, parts)]
x, std = map(np.concatenate, zip(*found))

# -- the same numbers from the plant at work

share = ((x - states)[:, 50:] / std[:, 50:]) ** 2
np.testing.assert_allclose(share.mean(axis=(0, 1)), 1, atol=0.25)
