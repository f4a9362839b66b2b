"""The states of an observer that its estimate never shows, left out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..numeric import Matrix, Vector
from ..numeric.balance import power_of_two
from ..numeric.linalg import eigenvalues
from ..numeric.staircase_form import climb
from .system import Change, System

ROUNDING = 1e-12  # of a state's size: what it shows less of is rounding


def as_moved(system: System) -> System:
    """The system in units in which inputs move every state as far.

    What one state then shows beside another is what it has to say.
    """
    F, N, P, units = system
    rate = np.abs(eigenvalues(F)).max(initial=0.0) or 1.0
    moved = [N]
    for _ in F[1:]:
        moved.append(F @ moved[-1] / rate)
    reach = np.abs(moved).max(axis=(0, 2), initial=0.0)
    size = power_of_two(np.where((reach > 0) & np.isfinite(reach), reach, 1.0))
    return System(F / size[:, None] * size, N / size[:, None], P * size, units * size)


def shown_changes(system: System) -> Iterator[Change]:
    """Coordinates of what the estimate shows, where that is not all.

    First the states from which entries of F and P lead to it, which stay as they are;
    then directions in all of the states.
    """
    F, _, P, units = system
    seen = _led_to(F, P)
    if not seen.all():
        pick = np.eye(len(F))[seen]
        yield Change(pick * units, (pick / units).T)
    climbed, _, _ = climb(F, P, ROUNDING)
    if climbed.hidden > np.count_nonzero(~seen):
        back = climbed.U[:, climbed.hidden :]
        yield Change(back.T, back)


def _led_to(F: Matrix, P: Matrix) -> Vector:
    """Which states the estimate sees, directly or through others."""
    leads = np.abs(F) > ROUNDING * np.abs(F).max(initial=0.0)
    shows = np.abs(P) > ROUNDING * np.abs(P).max(axis=1, initial=0.0)[:, None]
    seen, more = np.zeros(len(F), dtype=bool), shows.any(axis=0)
    while (more & ~seen).any():
        seen |= more
        more = leads[seen].any(axis=0)
    return seen
