"""What a comparison is asked, and the poles that go with it."""

import dataclasses
import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.mean_square import equivalent_noise
from ..numeric import Vector
from ..numeric.linalg import eigenvalues
from ..numeric.staircase_form import find_in_even_units
from ..papers.leondes_novak.design import reduced_order_filter
from ..plant import Plant
from ..plant.estimates import Combinations
from .attempts import noisy

SPEED = 3.0  # of an observer, beside the plant, where no noise says how fast
SPEEDS = (1.0, SPEED, 10.0)  # where nothing is known of the noise


@dataclass(frozen=True, eq=False)
class Question:
    """What was asked: the plant, and what else was given."""

    plant: Plant
    k: np.ndarray | None = None
    poles: tuple | None = None
    orders: tuple | None = None
    scale: np.ndarray | None = None
    called: tuple[str, ...] | None = None  # the rows of k x

    @property
    def L(self) -> Combinations | None:
        """k with the names of its rows."""
        if self.k is None or self.called is None:
            return self.k
        return dict(zip(self.called, self.k))

    @property
    def weight(self) -> np.ndarray | None:
        """Of the error that filters make least, I or 1 / scale^2."""
        return None if self.scale is None else np.diag(self.scale**-2.0)

    @functools.cached_property
    def additive(self) -> Plant:
        """The plant with additive noises that trouble an estimate as much as its own.

        It is for filters that know no multiplicative noise: (4.4) of Haddad and
        Bernstein; see `mean_square.equivalent_noise`.
        """
        plant = self.plant
        if not plant.multiplicative or not noisy(plant):
            return plant
        _, Q, S, R = equivalent_noise(plant)
        return dataclasses.replace(plant, Q=Q, R=R, S=S, multiplicative=())

    @functools.cached_property
    def note(self) -> str:
        if not self.plant.multiplicative:
            return ""
        return "Designed for additive noise of the same steady covariance."

    @functools.cached_property
    def speed(self) -> tuple[ArrayLike, str]:
        """Poles for a reduced-order observer, and where they are from."""
        plant = self.plant
        if self.poles is not None:
            return self.poles, "poles as given"
        _, form = find_in_even_units(plant.A, plant.C, plant.dt)
        count = plant.n - form.rank
        try:
            minimal = reduced_order_filter(
                self.additive, plant.p, horizon="steady"
            ).poles
        except ValueError:
            minimal = ()
        if len(minimal) == count:
            return minimal, "poles of the minimal-order filter"
        return butterworth(plant, count), _butterworth(SPEED)

    @property
    def speeds(self) -> Iterator[tuple[ArrayLike, str]]:
        """`speed`; and where nothing is known of the noise, several to choose from."""
        plant = self.plant
        if noisy(plant) or self.poles is not None or not len(np.ravel(self.speed[0])):
            yield self.speed
            return
        for times in SPEEDS:
            poles = butterworth(plant, len(np.ravel(self.speed[0])), times)
            yield poles, _butterworth(times)


def _butterworth(times: float) -> str:
    return f"Butterworth poles, {times:g} times the rates of the plant".replace(
        ", 1 times", " at"
    )


def butterworth(plant: Plant, count: int, times: float = SPEED) -> tuple[complex, ...]:
    """Poles on a circle in the left half plane, `times` as far out as the plant's.

    The plant's distance is the geometric mean of its modes' rates, |s|.  In discrete
    time the poles are exp(s dt).
    """
    known = rates(plant)
    unit = 1 / plant.dt if plant.dt > 0 else 1.0
    distance = times * (np.exp(np.log(known).mean()) if len(known) else unit / SPEED)
    angle = np.pi * (2 * np.arange(count // 2) + count + 1) / (2 * max(count, 1))
    upper = distance * np.exp(1j * angle)
    s = np.concatenate([upper, upper.conj(), [-distance] * (count % 2)])
    return tuple(np.exp(s * plant.dt) if plant.dt > 0 else s)


def rates(plant: Plant) -> Vector:
    """How fast the plant's modes are, in rad/s; those that never change left out."""
    poles = eigenvalues(plant.A)
    if plant.dt > 0:
        poles = np.log(poles[poles != 0].astype(complex)) / plant.dt
    return np.abs(poles[poles != 0])
