"""What every design goes through at its end, and its limits."""

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike

from ..certificate import certify, residuals
from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.combinations import combinations
from ..numeric.detectability import hidden_modes
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


def certified(
    observer: Observer,
    plant: Plant,
    settling: bool = True,
    L: ArrayLike | None = None,
    called: tuple[str, ...] | None = None,
) -> Observer:
    """Return `observer`, named, if it meets its certificate; the only way out.

    A filter over a few steps need not have settled, so its stability is not asked.
    With L it is the observer of these combinations of what it estimates, `called` so.
    """
    observer = observer if L is None else observer.combined(L)
    if called is not None:
        observer = dataclasses.replace(observer, estimates=called)
    certify(observer, plant).require(stable=settling)
    return observer.named(plant)


@contextmanager
def of_what_is_needed(
    plant: Plant, L: ArrayLike | None, least: float = 0.0
) -> Iterator[None]:
    """Say of a refusal for modes that no output sees whether L x has any of them.

    An observer of the state must follow them, but one of L x need not.  Modes below
    `least` do not count.
    """
    try:
        yield
    except DesignError as error:
        if L is None or plant.steps is not None:
            raise
        rows = combinations("L", L, plant.n, field=complex)
        hidden = hidden_modes(plant.A, plant.C, least)
        both = hidden_modes(plant.A, np.vstack([plant.C, rows]), least)
        if not hidden or len(both) < len(hidden):
            raise
        raise DesignError(
            f"{error} Designs of the state estimate L x as a part of it. L x has none "
            "of what is hidden here: functional_observer(plant, L) estimates it alone."
        ) from None
