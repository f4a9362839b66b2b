"""How long a comparison's time axis is."""

import numpy as np
import pytest

from luenberger.comparison.transients import settling


@pytest.mark.parametrize("radius", [0.75, 0.9, 0.95, 0.99])
def test_variances_have_died_away_when_the_axis_ends_and_not_a_step_before(radius):
    """An error that decays as r^k has a variance that decays as r^2k."""
    steps = settling(radius)
    assert radius ** (2 * steps) <= 1e-3 < radius ** (2 * (steps - 1))


@pytest.mark.parametrize(
    ("radius", "steps"),
    [
        (0.0, 10),
        (0.5, 10),  # 5 would do
        (np.exp(np.log(1e-3) / 20), 10),
        (np.exp(np.log(1e-3) / 21), 11),
        (np.exp(np.log(1e-3) / 799), 400),
        (0.9999, 400),
        (1.0, 10),  # it never dies away
        (1.5, 10),
    ],
)
def test_axis_has_at_least_ten_steps_and_at_most_four_hundred(radius, steps):
    assert settling(radius) == steps
