"""What is known of a plant's known input, as a user states it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import short
from ..numeric import Matrix
from ..numeric.covariances import covariance
from ..numeric.validation import numbers, vector

if TYPE_CHECKING:
    from .plant import Plant

WANTED = (
    "U must be a level for each known input, constant for ever, shape (m,), the "
    "covariance of white inputs, shape (m, m), a Plant whose outputs they are, or 0"
)


def stated(U: Any, m: int, dt: float, plant: type[Plant]) -> Matrix | Plant | None:
    """U as levels (m,), a covariance (m, m) or a plant without input; None for none.

    A model that grows is refused where it is used, as it takes eigenvalues to tell.
    """
    if U is None:
        return None
    if isinstance(U, plant):
        return _model(U, m, dt)
    if isinstance(U, str | Mapping) or hasattr(U, "F"):
        raise ValueError(f"{WANTED}; got {short(U)}")
    X = numbers("U", U)
    if X.ndim == 0 and X == 0:
        X = np.zeros(m)
    if X.ndim not in (1, 2):
        got = f"shape {X.shape}" if X.ndim else f"{X}; one input has the level [{X}]"
        raise ValueError(f"{WANTED}; got {got}")
    return covariance("U", X, m) if X.ndim == 2 else vector("U", X, m)


def _model(model: Plant, m: int, dt: float) -> Plant:
    """A model that fits the plant."""
    if model.m or model.p != m:
        raise ValueError(
            f"the model U of the known input must have no input and {m} outputs, one "
            f"for each input of the plant; it has {model.m} inputs and {model.p} "
            "outputs"
        )
    if dt and model.dt != dt:  # that of a continuous plant may be of its samples
        raise ValueError(
            f"the model U has dt={model.dt:g} but the plant dt={dt:g}; "
            "U.sampled(dt) samples a continuous model"
        )
    if model.steps is not None or model.is_complex or model.multiplicative:
        raise ValueError(
            "the model U of the known input must be constant and real, without "
            "multiplicative noise"
        )
    return model
