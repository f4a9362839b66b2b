"""What is known behind rows with one gain, of a random walk whose filter is exact."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion.held import Behind
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled import ball, distance, near
from luenberger.recursion.settled_rows import OneGain
from luenberger.recursion.state import start, step

Q, R = 0.01, 1.0
WALK = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[Q]], R=[[R]], P0=[[5.0]])


def update(Omega):
    """The covariance of the next prediction."""
    return Omega * R / (Omega + R) + Q


def settled(tolerance=1e-2):
    """The state from which on there is one gain, and the gain."""
    settings, none = Settings(WALK, 0), np.zeros(0)
    state = start(settings, WALK.x0, none)
    for _ in range(100):
        state = step(settings, state, np.zeros(1), none).state
        at, _ = near(state.setting, state.spread, tolerance)
        made = at and ball(at, tolerance)[0]
        if made is not None:
            return state, OneGain(state.setting, made, state.seen, False)
    raise AssertionError("it did not settle")


@pytest.mark.parametrize("rows", [1, 3, 10, 100])
@pytest.mark.parametrize("g", [0.0, 0.02, 0.1])
def test_the_ratio_behind_a_stretch_holds(rows, g):
    """The recursion begins with (1 + g) times as much, or so many times less."""
    state, gain = settled()
    own = distance(state, gain.ball, 0.5)
    held, alone = gain.ball.held(own + g * (1 + own)), gain.ball.held(own)
    stretch = gain.begin(state, held, alone, Behind(g, 0.0))._replace(rows=rows)
    found, stays = stretch.behind.g, gain.ball.Sigma.item() + Q
    for begun in (1 + g, 1 / (1 + g)):
        Omega = (state.Sigma.item() + Q) * begun
        for _ in range(rows):
            Omega = update(Omega)
        assert max(Omega / stays, stays / Omega) - 1 <= found
    assert found <= 0.02 + 2.5 * g


@pytest.mark.parametrize("rows", [1, 5, 20])
def test_predictions_drift_by_no_more_than_is_known(rows):
    """Of two filters, which begin alike but for the ratio of their covariances."""
    rng, g = np.random.default_rng(rows), 0.05
    Omega, other, x, z, s = 0.1, 0.1 * (1 + g), 0.0, 0.0, 0.0
    for y in 2 * rng.standard_normal(rows) + 3:
        s = max(s, abs(y - x) / (Omega + R) ** 0.5, abs(y - z) / (other + R) ** 0.5)
        x, z = x + Omega / (Omega + R) * (y - x), z + other / (other + R) * (y - z)
        Omega, other = update(Omega), update(other)
    apart = abs(x - z) / min(Omega, other) ** 0.5
    found = Behind(g, 0.0).after(rows, s)
    assert 0 < apart <= found.drift and found.g == g
    assert Behind(g, 1.0).after(rows, 0.0).drift >= 1.0


def test_rounding_counts():
    """Of an estimate, in the prediction behind it; of an innovation, in its length."""
    _, gain = settled()
    rounding, deviation = np.array([1e-3]), gain.ball.Omega.item() ** 0.5
    found = gain.ball.held().driven(0.0, 0.0, rounding)
    assert 1e-3 <= found * deviation * (1 + 1e-9) < 1.1e-3
    far = np.array([1e8, 1e8, 0.0])  # x and y, and innovations that seem to be zero
    assert gain.sizes(far)[0] >= np.finfo(float).eps * 1e8
