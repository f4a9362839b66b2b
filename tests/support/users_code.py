"""What mypy makes of a user's code: `.ci/run` has it checked with the library."""

from typing import assert_type

import numpy as np
from matplotlib.axes import Axes

import luenberger as lb


def never_run() -> None:
    plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]])
    observer = lb.reduced_order_filter(plant, m1=1)
    y = np.zeros((3, 1))
    assert_type(plant.B, np.ndarray)  # None was given; it has no columns
    assert_type(plant.P0, np.ndarray | None)
    assert_type(lb.certify(observer, plant).worst, float)
    assert_type(lb.simulate(plant, observer, 5, x0=[1, 2]).error, np.ndarray)
    assert_type(lb.estimate(observer, [[1], [2]]), np.ndarray)
    assert_type(lb.plot.panels(2), list[Axes])
    assert_type(lb.Filter(plant).log_likelihood([y, y]), float)
    lb.reduced_order_filter(plant, steps="ten")  # type: ignore[call-arg, arg-type]
    lb.kalman_fliter(plant)  # type: ignore[attr-defined]
