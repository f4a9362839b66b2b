"""From a minimum, or from a projection, to the Observer of the plant."""

import numpy as np

from ...certificate import residuals
from ...kernels import run
from ...numeric import Matrix
from ...observer import Observer
from ...plant import Plant
from .derivation import projection_factors, projection_gains
from .descent import Frame, balancing
from .target import Prediction, Target


def projected(plant: Plant, whole: Prediction, G: Matrix, Gam: Matrix) -> Observer:
    """The Kalman filter with the states Gam x^: (3.10)-(3.13)."""
    have = whole._asdict() | dict(G=G, Gam=Gam)
    return _assembled(plant, whole, have | run(projection_gains, have))


def observer_of(
    plant: Plant, whole: Prediction, sought: Target, frame: Frame
) -> Observer:
    """The estimator for the plant itself, in balanced coordinates."""
    have = frame.point.have
    to, back = balancing(have["Q2"], have["P2"])
    Gam = to @ run(projection_factors, have, "Gam")["Gam"]
    sign = signs(Gam / whole.states)
    to, back = sign * to, back * sign.T
    found = dict(
        Ae=to @ have["Ae"] @ back,
        Be=to @ have["Be"] @ sought.outputs,
        Ce=sought.unweighted @ have["Ce"] @ back,
        De=sought.unweighted @ have["De"] @ sought.outputs + whole.De,
        Gam=sign * Gam,
    )
    return _assembled(plant, whole, found)


def signs(Gam: Matrix) -> Matrix:
    """A column of signs that make the first large entry of each row positive."""
    large = np.abs(Gam) > 0.99 * np.abs(Gam).max(axis=1, keepdims=True)
    first = np.argmax(large, axis=1)
    return np.sign(Gam[np.arange(len(Gam)), first])[:, None]


def _assembled(plant: Plant, whole: Prediction, have: dict[str, Matrix]) -> Observer:
    """The Observer of an estimator, into which the known input enters as in (3.19)."""
    F, D, P, V, T = (have[k] for k in ("Ae", "Be", "Ce", "De", "Gam"))
    T, L = T / whole.states, whole.L / whole.states
    A, B, C, E = plant.A, plant.B, plant.C, plant.E
    _, G, _, W = residuals(A, B, C, E, L, F, 0, D, P, V, 0, T, T)
    observer = Observer(F, G, D, P, V, T, L, 0.0 - W, z0=T @ plant.x0, dt=plant.dt)
    return observer.named(plant)
