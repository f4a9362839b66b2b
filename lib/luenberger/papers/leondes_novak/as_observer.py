"""A gain of the filter written as an `Observer`: (9)-(15), (24), (25)."""

from typing import Any

import numpy as np

from ... import kernels
from ...numeric import Matrix
from ...observer import Observer
from ...plant import Plant
from ...recursion.settings import Setting
from .derivation import exact_gain, observer_matrices


def with_gain(plant: Plant, now: Setting, K: Matrix) -> Observer:
    """The Observer with this constant gain."""
    return with_gains(plant, now._asdict() | {"As": now.As, "K": K})


def with_gains(plant: Plant, have: dict[str, Any]) -> Observer:
    """The Observer with the gain K, or a stack of them, a row for each instant."""
    Phat, first = have["Phat"], {}
    K = kernels.run(exact_gain, have, "V", stacks=True)["V"]
    have = have | {"K": K}
    have["T_next"] = T = kernels.run(observer_matrices, have, "T", stacks=True)["T"]
    if T.ndim == 3:
        A, B, _ = plant.first_step()
        have["T_next"] = np.concatenate([T[1:], T[-1:]])
        first = dict(T0=T[0] @ A, G0=T[0] @ B)
    return Observer(
        **kernels.run(observer_matrices, have, *"FDGW", stacks=True),
        P=Phat,
        V=K,
        T=T,
        L=np.eye(plant.n),
        z0=first.get("T0", T) @ plant.x0,
        dt=plant.dt,
        **first,
    )
