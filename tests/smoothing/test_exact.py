"""`smooth` beside batch least squares in rational arithmetic."""

from functools import cache

import numpy as np
import pytest
from exact_smoother import Batch, floats, near, record

import luenberger as lb

NAMES = "x P lag_one w v".split()


def plants():
    """Singular in every way: start, plant, process, sensors; correlated; by name."""
    A, C = [[1, 1], [-0.5, 0.25]], [[1, 0], [1, 1]]
    Q, R, P0 = [[2, 1], [1, 1]], [[1, 0.5], [0.5, 2]], [[3, 1], [1, 2]]
    zero = np.zeros((2, 2))
    usual = dict(Q=Q, R=R, P0=P0)
    root = np.array([[1, 0, 1], [0, 1, 1], [1, 1, 0], [0, 1, -1.0]])
    joint = root @ root.T
    linked = dict(Q=joint[:2, :2], R=joint[2:, 2:], S=joint[:2, 2:])
    return {
        "usual": (A, C, usual),
        "prior": (A, C, usual | dict(at_first=True, x0=[1, -2])),
        "start known": (A, C, usual | dict(P0=zero, x0=[1, 2])),
        "start known in part": (A, C, usual | dict(P0=[[1, 2], [2, 4]])),
        "no process noise": (A, C, usual | dict(Q=zero)),
        "process noise of rank one": (
            A, C[:1], dict(Q=[[1, 2], [2, 4]], R=[[1]], P0=P0),
        ),
        "singular A": ([[1, 2], [0.5, 1]], C, usual),
        "A is zero": (zero, C, usual),
        "shift": (
            [[0.5, 0], [1, 0]], [[0, 1]], dict(Q=[[1, 0], [0, 0]], R=[[1]], P0=P0),
        ),
        "one perfect sensor": (A, C, usual | dict(R=[[0, 0], [0, 1]])),
        "perfect sensors": (A, C, usual | dict(R=zero)),
        "one output, perfect": (A, C[:1], dict(Q=Q, R=[[0]], P0=P0)),
        "perfect and doubled": (A, [[1, 0], [2, 0]], usual | dict(R=zero)),
        "all perfect, no noise": (A, C[:1], dict(Q=zero, R=[[0]], P0=P0)),
        "correlated": (A, C, dict(P0=P0, **linked)),
        "correlated, start known": (A, C, dict(P0=zero, **linked)),
        "known from the next sample": (
            [[1, 1], [0, 1]], [[1, 0]], dict(Q=zero, R=[[0]], P0=np.eye(2)),
        ),
        "no output": (A, np.zeros((0, 2)), dict(Q=Q, R=np.zeros((0, 0)), P0=P0)),
    }  # fmt: skip


PLANTS = plants()


@cache
def made(name, holes, N=5):
    """A plant, its record, and what batch least squares says of it."""
    A, C, noise = PLANTS[name]
    plant = lb.Plant(A, None, C, dt=1.0, **noise)
    y = record(plant, N, np.random.default_rng(0), holes)
    return plant, floats(y), Batch(plant, y)


def hold(found, wanted, plant, rtol=2e-12):
    size = max(np.abs(floats(wanted[1])).max(initial=0), np.abs(plant.P0).max())
    assert near(found.x, wanted[0], rtol, max(np.abs(floats(wanted[0])).max(), 1))
    assert near(found.P, wanted[1], rtol, size)
    assert near(found.lag_one, wanted[2], rtol, size)
    assert near(found.w, wanted[3], rtol, max(np.abs(floats(wanted[0])).max(), 1))
    assert near(found.v, wanted[4], rtol, max(np.abs(floats(wanted[0])).max(), 1))


@pytest.mark.parametrize("holes", [0, 0.4])
@pytest.mark.parametrize("name", PLANTS)
def test_every_singular_case(name, holes):
    plant, y, batch = made(name, holes)
    hold(lb.smooth(plant, y), batch.smooth(), plant)


@pytest.mark.parametrize("lag", [0, 1, 2, 3, 7])
@pytest.mark.parametrize("name", PLANTS)
def test_every_lag(name, lag):
    plant, y, batch = made(name, 0.2)
    hold(lb.smooth(plant, y, lag=lag), batch.smooth(lag), plant)


def test_inputs_and_feedthrough():
    rng = np.random.default_rng(4)
    plant = lb.Plant(
        [[1, 1], [-0.5, 0.25]], [[1], [2]], [[1, 0]], [[3]], dt=1.0,
        Q=np.eye(2), R=[[1]], P0=np.eye(2), x0=[1, 1],
    )  # fmt: skip
    y, u, u0 = rng.integers(-9, 9, (5, 1)), rng.integers(-9, 9, (5, 1)), [7]
    wanted = Batch(plant, y, u, u0).smooth()
    hold(lb.smooth(plant, y, u, u0=u0), wanted, plant)


@pytest.mark.parametrize("start", [1e6, 1e12, 1e18])
@pytest.mark.parametrize("lag", [None, 4])
def test_a_vague_start_costs_no_digits(start, lag):
    """P is 1e-18 of what it is the rest of; a difference would be noise."""
    A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], [[1, 0, 0]]
    plant = lb.Plant(
        A, None, C, dt=1.0, Q=np.diag([0, 0, 1.0]), R=[[1]], P0=start * np.eye(3)
    )
    y = np.random.default_rng(1).integers(-9, 9, (7, 1))
    wanted, found = Batch(plant, y).smooth(lag), lb.smooth(plant, y, lag=lag)
    want = floats(wanted[1])
    scale = np.sqrt(np.einsum("kii->ki", want))
    unit = scale[:, :, None] * scale[:, None]
    rough = 1e-15 * np.sqrt(start) + 1e-8
    assert np.abs((found.P - want) / unit).max() < rough
    assert np.abs((found.x - floats(wanted[0])) / scale).max() < rough


def test_an_unstable_plant_through_a_gap():
    """Sigma grows to 1e12 in the gap, and later rows take it back."""
    plant = lb.Plant([[16.0]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    y = np.full((9, 1), None, dtype=object)
    y[[0, 1, 7, 8], 0] = [1, 16, 16**7, 16**8]
    wanted, found = Batch(plant, y).smooth(), lb.smooth(plant, floats(y))
    np.testing.assert_allclose(found.P, floats(wanted[1]), rtol=1e-9)
    np.testing.assert_allclose(found.lag_one, floats(wanted[2]), rtol=1e-8)
    np.testing.assert_allclose(found.x, floats(wanted[0]), rtol=1e-9)
    np.testing.assert_allclose(found.w, floats(wanted[3]), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_unstable_modes_that_are_not_the_states(seed):
    """The same where every state is a mixture of what grows and what does not."""
    rng = np.random.default_rng(seed)
    mix = np.array(
        [[1, 1, 0], [1, 2, 1], [0, 1, 2.0]]
    )  # so is its inverse, of integers
    A = mix @ np.diag([4, 0.5, -2]) @ np.linalg.inv(mix).round()
    plant = lb.Plant(
        A, None, rng.integers(-2, 3, (2, 3)), dt=1.0, Q=np.eye(3), R=np.eye(2),
        P0=np.eye(3),
    )  # fmt: skip
    y = record(plant, 6, rng)
    y[1:5] = None
    wanted = Batch(plant, y).smooth()
    for found in lb.smooth(plant, floats(y)), lb.smooth(plant, floats(y), lag=5):
        want = floats(wanted[1])
        scale = np.sqrt(np.einsum("kii->ki", want))
        unit = scale[:, :, None] * scale[:, None]
        assert np.abs((found.P - want) / unit).max() < 1e-7
        lag_one = np.abs(found.lag_one - floats(wanted[2]))
        assert (lag_one[1:] / np.sqrt(unit[1:] * unit[:-1])).max() < 1e-6


@pytest.mark.parametrize("power", [-40, 40])
@pytest.mark.parametrize("name", ["usual", "one perfect sensor", "start known in part"])
def test_units_move_nothing_but_the_exponent(name, power):
    A, C, noise = PLANTS[name]
    y = made(name, 0.3)[1]
    unit = np.diag([2.0**power, 1.0])
    back = np.linalg.inv(unit)
    plant = lb.Plant(A, None, C, dt=1.0, **noise)
    other = lb.Plant(
        unit @ A @ back, None, C @ back, dt=1.0, R=noise["R"],
        Q=unit @ noise["Q"] @ unit, P0=unit @ noise["P0"] @ unit,
    )  # fmt: skip
    one, two = lb.smooth(plant, y), lb.smooth(other, y)
    np.testing.assert_allclose(two.x @ back, one.x, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(back @ two.P @ back, one.P, rtol=1e-9, atol=1e-13)
