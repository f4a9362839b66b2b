"""A record smoothed: what later rows say of each row, noises, accurate outputs met."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..filtering import back, pack
from ..filtering.back import Passed, Told
from ..filtering.passes import State
from ..formats import dataframes
from ..numeric import Matrix
from .filter import Filter
from .record import Rows


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What `Filter.smooth` found; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray or pandas.DataFrame
        Estimates of the state, from the whole record or up to the lag.
    std : (N, n) ndarray or pandas.DataFrame
        Their one-sigma errors, square roots of the diagonals of P.
    w : (N, n) ndarray or pandas.DataFrame
        E[w | y], the process noise that leads from a row to the next one.
    index : pandas.Index or None
        That of the record.
    names : tuple of str
        Those of the states.
    """

    x: Any
    std: Any
    w: Any
    index: Any
    names: Sequence[str]
    _work: _Work

    @cached_property
    def P(self) -> np.ndarray:
        """Error covariances (N, n, n), found in a second pass when first read."""
        return self._work.P

    @cached_property
    def v(self) -> Any:
        """E[v | y], the measurement noise of each row, (N, p).

        Also of outputs that are missing, as far as others tell of it.
        """
        return dataframes.framed(
            self._work.v, self._work.filter.plant.output_names, self.index
        )

    @cached_property
    def lag_one(self) -> np.ndarray:
        """The covariance E[e_k e_{k-1}'] of row k with the row before, (N, n, n).

        The errors e are estimate less state.  The first row is with the state at
        instant 0, or, if P0 is the prior of the first sample, with itself.  For a fixed
        lag either error is that of its own row.  It is found when first read.
        """
        return self._work.neighbours()


def over(
    filter: Filter, rows: Rows, lag: int | None = None, index: Any = None
) -> Smoothed:
    """Smooth the rows of one run."""
    work, names = _Work(filter, rows, lag), filter.plant.state_names
    x, std, w = (dataframes.framed(X, names, index) for X in (work.x, work.std, work.w))
    return Smoothed(x, std, w, index, names, work)


class _Work:
    """One record, and what is found of it when it is asked for."""

    def __init__(self, filter: Filter, rows: Rows, lag: int | None) -> None:
        self.filter, self.rows, self.lag = filter, rows, lag
        meets = bool(filter.m1)  # outputs are met when all is smoothed
        self.free = Filter(filter.plant) if meets else filter
        found = back.smoothed(self._passed()[0], lag, whole=meets)
        self.z, self.w, variances = found.z, found.w, found.variances
        self.x = found.z[:, : filter.plant.n]
        if meets:
            self.x, self.P = self._met(found.P)
            variances = np.einsum("kii->ki", self.P)
        self.std = np.maximum(variances, 0.0, out=found.variances)
        np.sqrt(self.std, out=self.std)

    def _passed(self, keep: str = "") -> tuple[Passed, State]:
        """The pass of the Kalman filter with its tape, and the state before it."""
        settings = next(self.free.parts(self.rows))[1]
        start = pack.begin(settings, self.rows.u0, known=False).state
        if not keep:
            plain = settings.way == "nothing" and self.filter.plant.P0 is not None
            keep = "back" if plain else "all"
        windows = [*self.free._windows(self.rows, None, keep)]
        return Passed.of(windows, settings), start

    @cached_property
    def P(self) -> Matrix:
        """Covariances, found in a second pass."""
        return back.smoothed(self._passed()[0], self.lag, whole=True).P

    @property
    def v(self) -> Matrix:
        found = [told.noises(self.z[part]) for part, told in self._told(self.free)]
        return np.concatenate(found)

    def _told(self, of: Filter) -> Iterator[tuple[slice, Told]]:
        """Rows that are done at once, and what is known of them to a filter."""
        y, u = self.rows.y, self.rows.u
        for part, settings in of.parts(self.rows):
            yield part, Told(settings, part.start + 1, y[part], u[part])

    def _met(self, P: Matrix) -> tuple[Matrix, Matrix]:
        """Estimates and covariances, pushed to what the accurate outputs show."""
        x, P = self.x.copy(), P.copy()
        for part, told in self._told(self.filter):
            push, C, R = told.pushes(), told.each("C"), told.each("R")
            x[part] += np.einsum("kij,kj->ki", push, told.left(x[part]))
            unknown = R - C @ P[part] @ np.swapaxes(C, -1, -2)
            P[part] += push @ unknown @ np.swapaxes(push, 1, 2)
        P[np.isnan(P)] = np.inf  # of what the record leaves open
        return x, P

    def neighbours(self) -> Matrix:
        """E[e_k e_{k-1}'] of each row."""
        passed, start = self._passed("all")
        U = back.smoothed(passed.copied(), self.lag, whole=True).P.copy()
        shares = back.gains(passed, start)
        first = int(passed.at[0] < 0)  # the prior of the first sample has none before
        U[first:] = U[first:] @ np.swapaxes(shares[:-1], 1, 2)
        if self.filter.m1:
            told = (told for _, told in self._told(self.filter))
            moved = np.concatenate([one.pushes() @ one.each("C") for one in told])
            U[1:] -= moved[1:] @ U[1:] @ np.swapaxes(moved[:-1], 1, 2)
        return U
