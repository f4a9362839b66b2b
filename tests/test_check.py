"""What `check` finds of a plant: modes that no noise moves, also where they repeat."""

import dataclasses

import numpy as np
import pytest

import luenberger as lb
from luenberger import check

TURN = np.array([[0.6, -0.8], [0.8, 0.6]])  # exp(+-j 0.927)
MOTIONS = {
    "velocity": (np.array([[1.0, 1], [0, 1]]), [1]),
    "acceleration": (np.array([[1.0, 1, 0], [0, 1, 1], [0, 0, 1]]), [1]),
    "two constants": (np.eye(2), [1]),
    "alternating": (np.array([[-1.0, 1], [0, -1]]), [-1]),
    "resonance": (np.kron(np.eye(2), TURN) + np.eye(4, k=2), [0.6 - 0.8j, 0.6 + 0.8j]),
    "two of them": (np.diag([1.0, -1]), [-1, 1]),
    "none on the circle": (np.diag([1 - 1e-5, 0.5]), []),
}


@pytest.mark.parametrize("motion, modes", MOTIONS.values(), ids=MOTIONS.keys())
def test_an_undriven_mode_is_listed_once(motion, modes):
    """Rounding scatters a repeated one by 1e-8: it was missed, or there twice."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        k = len(motion)
        A = np.zeros((k + 2, k + 2))
        A[:k, :k], A[k:, k:] = motion, rng.uniform(-0.6, 0.6, (2, 2))
        A[k:, :k], noise = rng.standard_normal((2, k)), np.zeros((k + 2, 1))
        noise[k:] = rng.standard_normal((2, 1))
        W = np.linalg.qr(rng.standard_normal(A.shape))[0]
        for turn, units in ((np.eye(k + 2), 1), (W, 1), (W, 4.0 ** np.arange(k + 2))):
            A1 = turn.T @ A @ turn / np.reshape(units, (-1, 1)) * units
            G = (turn.T @ noise).T / units
            plant = lb.Plant(
                A1, None, np.eye(k + 2), dt=1.0, Q=G.T @ G, R=np.eye(k + 2)
            )
            found = check._undriven(plant)
            found = sorted((complex(z["real"], z["imag"]) for z in found), key=np.angle)
            wanted = sorted(modes, key=np.angle)
            np.testing.assert_allclose(found, wanted, atol=1e-9, err_msg=str(seed))


MOTOR = lb.Plant(
    [[0.9, 0], [0, 0.5]], [[1], [0]], [[0, 2], [1, -1]], E=[[0], [0.5]], dt=0.1,
    Q=np.diag([0.04, 0]), R=np.diag([0.25, 1]), state_names=["speed (m/s)", "current"],
    input_names=["volts"], output_names=["shunt (V)", "mixed (K)"],
)  # fmt: skip


def said(plant):
    return [text for _, text in check.lines(check.examine(plant))]


def test_what_a_plant_means_is_said_in_its_units():
    text = said(MOTOR)
    assert "speed (m/s): pushed a step by 0.2 m/s" in text
    assert "current: no noise" in text
    assert "shunt (V): reads 2 current; one sigma 0.5 V" in text
    mixed = "mixed (K): reads speed (m/s) - current + 0.5 volts; one sigma 1 K"
    assert mixed in text
    turned = dataclasses.replace(MOTOR, C=-MOTOR.C)
    assert "shunt (V): reads -2 current; one sigma 0.5 V" in said(turned)
    falls = [-0.1 / np.log(mode) for mode in (0.5, 0.9)]
    assert "; ".join(f"falls in {one:.3g} s" for one in falls) in text
    assert "discrete, dt = 0.1 s" in text


def test_times_of_oscillations_and_of_growth_are_in_seconds():
    turning = lb.Plant([[-1, 2], [-2, -1]], None, [[1, 0]])
    assert f"falls in 1 s, period {np.pi:.3g} s" in said(turning)
    swinging = dataclasses.replace(MOTOR, A=[[0.6, -0.6], [0.6, 0.6]])
    falls, period = 0.1 / -np.log(0.6 * np.sqrt(2)), 0.1 * 8
    assert f"falls in {falls:.3g} s, period {period:.3g} s" in said(swinging)
    resting = dataclasses.replace(MOTOR, A=[[1 - 1e-13, 0], [0, 1 + 1e-13]])
    assert not any("falls" in one or "grows" in one for one in said(resting))
    growing = dataclasses.replace(MOTOR, A=[[1.1, 0], [0, 1]])
    assert f"grows in {0.1 / np.log(1.1):.3g} s" in said(growing)


@pytest.mark.parametrize(
    ("A", "dt", "looks"),
    [
        ([[-0.0005, 0.001], [0.002, -0.0157]], 1.0, "A looks continuous"),
        ([[0.984, 0], [0, 0.5]], 0.0, "A looks discrete"),
        ([[-0.5, 0], [0, 0.5]], 1.0, None),
        ([[-1, 0], [0, -2]], 0.0, None),
        ([[1.5, 0], [0, -2]], 0.0, None),
    ],
)
def test_time_that_looks_wrong_is_pointed_out(A, dt, looks):
    found = check.examine(lb.Plant(A, None, [[1, 0]], dt=dt))["suspicions"]
    assert [one[: len(looks)] for one in found] == [looks] if looks else found == []
