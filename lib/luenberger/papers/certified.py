"""What every design goes through at its end, and its limits."""

import numpy as np

from ..certificate import certify, residuals
from ..numeric import Matrix
from ..observer import Observer
from ..plant import Plant

CONDITION_WARNING = 1e10
LOST_TOL = 1e-4  # |P T + V C - I| above it: the estimate has no trustworthy digits


def state_observer(
    plant: Plant, F: Matrix, D: Matrix, T: Matrix, P: Matrix, V: Matrix
) -> Observer:
    """The observer of the whole state with these matrices.

    The known input enters by G = T B - D E and W = -V E, and z starts from T x0.
    """
    A, B, C, E, L = plant.A, plant.B, plant.C, plant.E, np.eye(plant.n)
    _, G, _, W = residuals(A, B, C, E, L, F, 0, D, P, V, 0, T, T)
    return Observer(
        F=F,
        G=G,
        D=D,
        P=P,
        V=V,
        T=T,
        L=L,
        W=0.0 - W,
        z0=None if np.iscomplexobj(T) else T @ plant.x0,
        dt=plant.dt,
    )


def certified(observer: Observer, plant: Plant, settling: bool = True) -> Observer:
    """Return `observer`, named, if it meets its certificate; the only way out.

    A filter over a few steps need not have settled, so its stability is not asked.
    """
    certify(observer, plant).require(stable=settling)
    return observer.named(plant)
