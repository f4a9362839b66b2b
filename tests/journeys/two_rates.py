"""Two sensors with rates of their own that drop out, dates, from the command line.

The record is that of a true plant, whose states are kept aside.  Run with a number of
rows, such as 2000000, to see how long it takes; the test takes 3000.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import luenberger as lb
from luenberger.cli import main

ROWS = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
plant = lb.Plant(
    [[0, 1, 0], [-4, -0.4, 1], [0, 0, -0.1]], None, [[1, 0, 0], [0, 1, 0]],
    Q=np.diag([0, 0.1, 0.05]), R=np.diag([0.01, 0.04]), P0=np.eye(3),
    state_names=["angle", "rate", "torque"], output_names=["encoder", "gyro"],
)  # fmt: skip


def record(rows: int, seed: int) -> tuple[pd.DataFrame, np.ndarray]:
    """Readings 50 to 150 ms apart, and the states behind them."""
    rng = np.random.default_rng(seed)
    steps = rng.integers(50, 150, rows)
    each = {T: plant.sampled(T / 1000) for T in np.unique(steps).tolist()}
    root = {T: np.linalg.cholesky(one.Q) for T, one in each.items()}
    x, states = rng.normal(size=3), np.empty((rows, 3))
    for k, (T, w) in enumerate(zip(steps.tolist(), rng.normal(size=(rows, 3)))):
        states[k] = x = each[T].A @ x + root[T] @ w
    y = states[:, :2] + rng.normal(size=(rows, 2)) * np.sqrt(np.diag(plant.R))
    y[rng.random(rows) < 0.2, 0] = np.nan  # drops out
    y[np.arange(rows) % 5 > 0, 1] = np.nan  # a fifth of the rate
    dates = pd.Timestamp("2026-01-05T10:00") + pd.to_timedelta(steps.cumsum(), "ms")
    return pd.DataFrame(y, dates, plant.output_names).rename_axis("time"), states


with tempfile.TemporaryDirectory() as folder:
    here = Path(folder)
    frame, states = record(ROWS, seed=3)
    plant.to_json(here / "plant.json")
    frame.to_csv(here / "record.csv")
    found = {}
    for name, more in {"filtered": [], "lagged": ["--lag", "20"]}.items():
        files = [str(here / one) for one in ("plant.json", "record.csv")]
        assert main(["filter", *files, "--out", str(here / f"{name}.csv"), *more]) == 0
        found[name] = pd.read_csv(here / f"{name}.csv", index_col="time")

# -- the same numbers from the plant at work

rms = {}
for name, table in found.items():
    assert len(table) == ROWS
    errors = (table[list(plant.state_names)].to_numpy() - states)[100:]
    sigma = table[[f"{one}_sigma" for one in plant.state_names]].to_numpy()[100:]
    np.testing.assert_allclose((errors**2 / sigma**2).mean(axis=0), 1, atol=0.35)
    rms[name] = np.sqrt((errors**2).mean(axis=0))
assert (rms["lagged"] < rms["filtered"]).all()
in_python = lb.Filter(plant).run(frame)
np.testing.assert_allclose(
    found["filtered"]["torque"], in_python.x["torque"], rtol=1e-6
)
