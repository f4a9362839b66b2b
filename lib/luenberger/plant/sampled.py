"""The fields of the discrete plant that a continuous one is at its samples."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import period
from ..errors import DesignError
from ..numeric import Vector
from ..numeric.validation import sample_time

if TYPE_CHECKING:
    from .plant import Plant


def one_period(plant: "Plant", dt: float) -> dict[str, Any]:
    """A, B, Q, S and dt of the plant sampled every `dt` seconds."""
    _require(plant)
    dt = sample_time(dt)
    if dt == 0:
        raise ValueError("the sampling period must be positive, got 0 s")
    fields = over_periods(plant, np.array([dt]))
    return fields | {k: X[0] for k, X in fields.items() if k in "ABQ"}


def over_periods(plant: "Plant", periods: Vector) -> dict[str, Any]:
    """A, B, Q (a row for each period), S and dt (the mean) of the sampled plant."""
    _require(plant)
    unique, where = np.unique(periods, return_inverse=True)
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        parts = period.over_periods(plant.A, plant.B, plant.Q, unique)
    found: dict[str, Any] = dict(S=None, dt=float(periods.mean()))
    found["U"] = _input(plant.U, unique)
    for name, X in zip("ABQ", parts):
        if X is None:
            continue
        if not (finite := np.isfinite(X).all(axis=(1, 2))).all():
            raise DesignError(
                f"within a period of {unique[np.argmin(finite)]:g} s the plant grows "
                "beyond what floats hold. Take shorter periods."
            )
        found[name] = X[where]
    return found


def _input(U: Any, unique: Vector) -> Any:
    """What is known of the input that is held from each sample to the next."""
    if U is None or isinstance(U, np.ndarray) or U.dt > 0:
        return U  # of samples, as R is
    if len(unique) > 1:
        raise DesignError(
            "a continuous model U of the known input is sampled at even periods only. "
            "Leave U out."
        )
    return U.sampled(float(unique[0]))


def _require(plant: "Plant") -> None:
    if plant.dt != 0:
        raise DesignError(
            f"the plant has dt = {plant.dt:g}, it is discrete already; give the "
            "continuous plant (dt = 0)"
        )
    if plant.steps is not None or plant.is_complex:
        raise DesignError(
            "only constant, real plants can be discretised. Give one A, B, C and E, "
            "and real and imaginary parts as states of their own."
        )
    if plant.S is not None and plant.S.any():
        raise DesignError(
            "the plant has S, but continuous noise w has no covariance with the noise "
            "of a sample. Leave S out."
        )
    if plant.multiplicative:
        raise DesignError(
            "multiplicative noise is not discretised. Leave it out knowingly, with "
            "Plant(..., multiplicative=()), or give the pairs to the discrete plant."
        )
