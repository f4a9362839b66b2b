"""What every design goes through at its end, and its limits."""

import numpy as np

from ..certificate import certify
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
    return Observer(
        F=F,
        G=T @ plant.B - D @ plant.E,
        D=D,
        P=P,
        V=V,
        T=T,
        L=np.eye(plant.n),
        W=-V @ plant.E,
        z0=None if np.iscomplexobj(T) else T @ plant.x0,
        dt=plant.dt,
    )


def certified(observer: Observer, plant: Plant, settling: bool = True) -> Observer:
    """Return `observer`, named, if it meets its certificate; the only way out.

    A filter over a few steps need not have settled, so its stability is not asked.
    """
    certify(observer, plant).require(stable=settling)
    return observer.named(plant)
