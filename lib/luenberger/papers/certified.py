"""What every design goes through at its end, and its limits."""

from ..certificate import certify
from ..observer import Observer
from ..plant import Plant

CONDITION_WARNING = 1e10
LOST_TOL = 1e-4  # |P T + V C - I| above it: the estimate has no trustworthy digits


def certified(
    observer: Observer, plant: Plant, settling: bool = True, tol: float = 1e-9
) -> Observer:
    """Return `observer`, named, if it meets its certificate; the only way out.

    A filter over a few steps need not have settled, so its stability is not asked.
    """
    certify(observer, plant).require(tol, stable=settling)
    return observer.named(plant)
