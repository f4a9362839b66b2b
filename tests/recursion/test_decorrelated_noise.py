"""Process noise that the output tells exactly: w = g v, so q = g^2 r and s = g r.

Then x+ = (a - g c) x + g y is driven by nothing unknown, and q - s^2 / r is zero.  In
floats it is rounding of either sign, which is no noise.
"""

import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion.settings import setting

CASES = [(g, r) for g in (0.1, 0.3, -0.7) for r in (0.1, 0.3, 1.7, 2.3)]


def plant(g, r, left):
    """Scalar, with a - g c = left."""
    return lb.Plant(
        [[left + g]], None, [[1]], dt=1.0, Q=[[g * g * r]], R=[[r]], S=[[g * r]]
    )


def test_rounding_has_both_signs_here():
    signs = {np.sign(g * g * r - (g * r) ** 2 / r) for g, r in CASES}
    assert signs >= {-1.0, 1.0}


@pytest.mark.parametrize(("g", "r"), CASES)
def test_nothing_unknown_drives_the_state(g, r):
    now = setting(plant(g, r, 0.5))
    assert now.Qs[0, 0] == 0 and now.Q[0, 0] == g * g * r
    assert now.As[0, 0] == pytest.approx(0.5) and now.J[0, 0] == pytest.approx(g)


@pytest.mark.parametrize(("g", "r"), CASES)
def test_a_mode_at_one_that_nothing_drives_has_no_steady_filter(g, r):
    """Its error falls as 1 / k and its gain with it; rounding does not stop that."""
    with pytest.raises(lb.DesignError, match="no steady filter: a motion at 1,"):
        lb.kalman_filter(plant(g, r, 1.0))


@pytest.mark.parametrize(("part", "counts"), [(6e-15, True), (3e-15, False)])
def test_what_is_left_of_the_noise_counts_beside_the_noise(part, counts):
    """q = (1 + d) s^2 / r leaves d q: twenty roundings beside q and more are noise."""
    g, r = 0.5, 2.0
    one = lb.Plant([[0.9]], None, [[1]], dt=1.0, Q=[[g * g * r * (1 + part)]], R=[[r]],
                   S=[[g * r]])  # fmt: skip
    left = setting(one).Qs[0, 0]
    assert left == (pytest.approx(part * g * g * r, rel=0.1, abs=0) if counts else 0)
