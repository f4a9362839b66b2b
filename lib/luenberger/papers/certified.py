"""What every design goes through at its end, and its limits."""

import dataclasses
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike

from ..certificate import certify, residuals
from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.combinations import combinations
from ..numeric.detectability import hidden_modes
from ..observer import Observer
from ..plant import Plant

CONDITION_WARNING = 1e10
LOST_TOL = 1e-4  # part of the state: an estimate so wrong has no trustworthy digits


def state_observer(
    plant: Plant,
    built: Iterable[Matrix],
    units: Vector,
    advice: str,
    sensitive: float = CONDITION_WARNING,
) -> Observer:
    """The observer of the whole state with these F, D, T, P and V.

    The known input enters by G = T B - D E and W = -V E, and z starts from T x0.
    What has no digits left is refused, and a condition of [T; C] above `sensitive` is
    warned of, both with `advice`.  A residual can be small beside T and P and not
    beside x: that of P T + V C = I and, through P, that of T A - F T = D C are measured
    as the error that they put into the estimate, in even `units` of the states.
    """
    F, D, T, P, V = (X + 0.0 for X in built)  # no -0
    A, B, C, E, L = plant.A, plant.B, plant.C, plant.E, np.eye(plant.n)
    dynamics, G, output, W = residuals(A, B, C, E, L, F, 0, D, P, V, 0, T, T)
    errors = [X / units[:, None] * units for X in (output, P @ dynamics)]
    cond = _condition(np.vstack([T, C]) * units)
    if not all(np.linalg.norm(X) <= LOST_TOL for X in errors):
        raise DesignError(
            f"cond([T; C]) = {cond:.1e}: the pair (A, C) is so close to an "
            f"unobservable one that the estimate would have no correct digit. {advice}"
        )
    if cond > sensitive:
        warnings.warn(
            f"cond([T; C]) = {cond:.1e}, states in even units and rows at unit length: "
            "with these poles the pair (A, C) is close to an unobservable one. The "
            f"estimate can lose {min(np.log10(cond), 16):.0f} digits, and noise of the "
            f"sensors can show much enlarged. {advice}",
            RuntimeWarning,
            stacklevel=3,
        )
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


def _condition(M: Matrix) -> float:
    size = np.linalg.norm(M, axis=1, keepdims=True)
    if not np.isfinite(size).all():
        return np.inf
    M = (M / np.where(size > 0, size, 1))[size[:, 0] > 0]  # no sensor: no row
    return float(np.linalg.cond(M)) if M.size else 1.0


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
