"""What `check` finds of a plant: modes that no noise moves, also where they repeat."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.report import plant_facts

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
            found = plant_facts._undriven(plant)
            found = sorted((complex(z["real"], z["imag"]) for z in found), key=np.angle)
            wanted = sorted(modes, key=np.angle)
            np.testing.assert_allclose(found, wanted, atol=1e-9, err_msg=str(seed))
