"""Filters at work: a reading, then the input that acts until the next."""

from __future__ import annotations

from functools import partial
from math import isfinite, isinf
from typing import Any

import numpy as np

from ..at_work import Turns
from ..errors import DesignError, few, short
from ..filtering import digits, unknown
from ..filtering.maps import Settings
from ..filtering.pack import begin, blank, driven, fed, less, loops, refuse, times
from ..filtering.passes import TINY, Maps, Tape
from ..filtering.unknown import LARGE
from ..formats import dataframes
from ..numeric import Matrix, Vector
from ..plant import Plant
from . import checked
from .clock import require_instants

ROOM = 50  # rows beside those that are asked for again


class LiveFilter(Turns):
    """A filter that gets readings as they come; `Filter.live` makes it.

    At each instant call `measure`, `arrived` for each earlier reading that has come
    since, and `advance`.

    Attributes
    ----------
    instant : int
        That of the last measurement; 0 before the first.
    """

    def __init__(self, plant: Plant, settings: Settings, horizon: int, u0: Any) -> None:
        super().__init__(plant.m, bool(np.any(plant.E)))
        if u0 is not None:
            u0 = dataframes.entries("u0", u0, plant.input_names)
            self._u = checked.single("u0", u0, plant.m)
        self._plant, self._settings, self._horizon = plant, settings, horizon
        self._varies, self._names = plant.steps is not None, list(plant.output_names)
        columns = ([] if self._varies else list(X.T.copy()) for X in (plant.B, plant.E))
        self._B, self._E = columns
        end = begin(settings, self._u, known=False)
        self._state, n, p, N = end.state, plant.n, plant.p, len(end.state.z)
        size = 2 * (horizon + 1) + ROOM
        self._y, self._lift = np.full((size, p), np.nan), np.zeros((size, p))
        self._mixed, self._drive = np.empty((size, p)), np.zeros((size, n))
        self._x, self._variances = np.empty((size, n)), np.empty((size, n))
        tape = self._tape = blank(size, size, n, N, p)._replace(ahead=np.empty((0, n)))
        tape.z[0], tape.V[0], tape.D[0] = self._state[:3]
        tape.K[0], tape.pivot[0] = 0.0, -1.0
        maps = settings.at(0, end.seen)[0]
        self._maps = Maps(*(np.zeros((size, *X.shape)) for X in maps))
        self._found: list[Any] = [None] * size  # what the maps of a row are made of
        self._known: dict[bytes, Any] = {}  # of a plant that does not change
        self._at = np.arange(size)
        self._row = 0  # of the last instant; row 0 is instant 0
        self._none = digits.Gap(0, np.zeros(n))
        self._gaps = [self._none] * size  # in which the rows are
        self._always = bool(settings.unseen_growth)
        self._tell(0)
        if plant.at_first or plant.P0 is None:
            self._at[0] = -1
        self._all = (
            self._mixed, self._drive, self._at, self._maps, self._state, self._x,
            self._variances, tape,
        )  # fmt: skip
        self._resumed = loops("resumed", n)

    def measure(self, y: Any, u: Any = None) -> tuple[Vector, Vector]:
        """The estimate and its sigma, with the readings of the next instant.

        Parameters
        ----------
        y : (p,) array_like
            NaN where nothing was measured, and where it is not here yet.
        u : (m,) array_like, optional
            The input of this instant, where it acts on these readings (E).

        Returns
        -------
        x, sigma : (n,) ndarray

        Raises
        ------
        ValueError
            If the last instant was not advanced, or sizes disagree.
        DesignError
            If a reading contradicts what is known exactly, or an unstable mode has
            grown so far in a gap that digits are lost, as `Filter.run` says it.  The
            instant is as if it had not been measured.
        """
        u, plant = self._next(u), self._plant
        y = np.asarray(y, dtype=float)
        if y.shape != (len(self._names),) or any(map(isinf, y.tolist())):
            raise ValueError(
                f"y must be {len(self._names)} numbers or NaN, got {short(y)}"
            )
        if self._varies:
            require_instants(plant, self.instant + 1)
        if self._row + 1 == len(self._y):
            self._move()
        k = self._row + 1
        if len(self._u):
            self._drive[k] = (
                driven(plant, 0, self.instant, self._u[None])[0]
                if self._varies
                else _combined(self._B, self._u)
            )
        if u is not None:
            self._lift[k] = (
                fed(plant, self.instant, u[None])[0]
                if self._varies
                else _combined(self._E, u)
            )
            y = less(y, self._lift[k])
        self._y[k] = y
        self._row, self.instant = k, self.instant + 1
        self._tell(k)
        try:
            found = self._run(k)
        except DesignError:
            self._row, self.instant = k - 1, self.instant - 1
            raise
        self._done(u)
        return found

    def arrived(
        self, output: int | str, age: int, value: float
    ) -> tuple[Vector, Vector]:
        """The estimate and its sigma, with a reading that has come only now.

        Parameters
        ----------
        output : int or str
            Number or name of the output.
        age : int
            How many instants before the present one the reading was taken.
        value : float

        Returns
        -------
        x, sigma : (n,) ndarray
            At the present instant, as if the reading had been there in time.

        Raises
        ------
        ValueError
            If the present instant is not measured, or the reading was there before or
            is older than the horizon or the first instant.
        DesignError
            If the reading contradicts what is known exactly; it is left out.
        """
        if not self._measured:
            raise ValueError(
                f"ages count from an instant that was measured: call measure(y) of "
                f"instant {self.instant + 1} before arrived, and advance after it"
            )
        names = self._names
        j: Any = names.index(output) if output in names else output
        if j not in range(len(names)):
            raise ValueError(f"there is no output {short(output)}, but {few(names)}")
        if age not in range(self._horizon + 1):
            raise ValueError(
                f"age is a number of instants, at most horizon={self._horizon}, got "
                f"{age!r}: make the filter with live(horizon=...) for older readings"
            )
        if age >= self.instant:
            raise ValueError(f"instant {self.instant} has none {age} before it")
        if not isfinite(value):
            raise ValueError(f"value must be a finite number, got {value!r}")
        k = self._row - age
        if self._y[k, j] == self._y[k, j]:
            raise ValueError(
                f"the reading of {names[j]!r} at instant {self.instant - age} was "
                "there before; a reading is handed in once"
            )
        try:
            lift = float(self._lift[k, j])
            reading = value - lift
            near = abs(reading) <= TINY * (abs(value) + abs(lift))
            return self._again(k, j, 0.0 if near else reading)
        except DesignError:
            self._again(k, j, np.nan)
            raise

    def _again(self, k: int, j: int, reading: float) -> tuple[Vector, Vector]:
        """Filter again from row k, with a reading of output j."""
        self._y[k, j] = reading
        self._tell(k)
        return self._run(k)

    def _run(self, k: int) -> tuple[Vector, Vector]:
        """Filter the rows from k on."""
        first, clash = k, -1
        if self._plant.P0 is None:  # until all is known of the state
            first, clash = self._open_rows(k)
        if clash < 0 and first <= self._row:
            clash = self._resumed(*self._all, first, self._row + 1)
            clash += (first - k) * self._plant.p if clash >= 0 else 0
        if clash >= 0:
            row, j = divmod(int(clash), self._plant.p)
            seen, instant = ~np.isnan(self._y[k + row]), self.instant - self._row + k
            refuse(self._settings, instant + row, j, seen)
        self._gaps[k : self._row + 1] = [self._none] * (self._row + 1 - k)
        lacking = any(self._found[i][2] for i in range(first, self._row + 1))
        if lacking or self._always or self._gaps[first - 1].instant:
            self._follow(first)
        variances = self._variances[self._row]
        if self._plant.P0 is None:
            variances = np.where(variances > LARGE, np.inf, variances)
        return self._x[self._row].copy(), np.sqrt(variances)

    def _open_rows(self, k: int) -> tuple[int, int]:
        """Filter the rows from k on behind which nothing is known of a part.

        Returns the first that is left, and what `passes.forward` does.
        """
        before, rows = slice(k - 1, self._row + 1), slice(k, self._row + 1)
        loops("taken", self._plant.n)(self._tape, k - 1, self._state)
        done, clash = unknown.forward(
            self._mixed[rows], self._drive[rows], self._at[before], self._maps,
            self._state, self._x[rows], self._variances[rows],
            Tape(self._tape.ahead, *(X[rows] for X in self._tape[1:])),
        )  # fmt: skip
        return k + done, clash

    def _follow(self, k: int) -> None:
        """Refuse a gap, in the rows from k on, in which digits are lost."""
        for i in range(k, self._row + 1):
            y, variances = self._y[i : i + 1], self._variances[i : i + 1]
            instant, find = self.instant - self._row + i, partial(self._covariance, i)
            self._gaps[i] = digits.followed(
                self._settings, self._gaps[i - 1], y, variances, instant, find
            )

    def _covariance(self, k: int, _: int) -> Matrix:
        """That of the plant's states in row k."""
        V = self._tape.V[k, :, : self._plant.n]
        return (V.T * self._tape.D[k]) @ V

    def _tell(self, k: int) -> None:
        """The maps of row k, and its readings in their terms."""
        y = self._y[k]
        seen = y == y
        key = seen.tobytes()
        if self._varies or key not in self._known:
            maps, L = self._settings.at(self.instant - self._row + k, seen)
            mix = None if L is self._settings.as_is else L
            self._known[key] = maps, mix, not seen.all()
        found = self._known[key]
        if found is not self._found[k]:
            self._found[k] = found
            for X, one in zip(self._maps, found[0]):
                X[k] = one
        if found[1] is None:
            self._mixed[k] = y
        else:
            mixed = times(np.where(seen, y, 0.0)[None], found[1])[0]
            self._mixed[k] = np.where(seen, mixed, np.nan)

    def _move(self) -> None:
        """Take the last rows to the front."""
        keep = self._horizon + 1
        stacks = self._y, self._lift, self._mixed, self._drive, self._x, self._variances
        for X in (*stacks, self._found, self._gaps, *self._maps, *self._tape[1:]):
            X[:keep] = X[-keep:]
        self._at[0], self._row = 0, keep - 1


def _combined(columns: list[Vector], u: Vector) -> Vector:
    """What `times` makes of one row."""
    found: Any = 0.0
    for column, value in zip(columns, u.tolist()):
        found = found + column * value
    return found
