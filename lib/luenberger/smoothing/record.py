"""A record that is read from front to back, and smoothed as far as it goes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from .. import kernels
from ..formats import dataframes
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.growth import Gap, passed, require_digits
from ..recursion.root_step import Spread, first_move
from ..recursion.settings import Settings, require_start
from ..recursion.state import State, start
from ..run import chunks
from ..run.clock import require_instants
from ..run.filter_data import Outputs
from ..run.sampled_pass import window
from ..run.timed import Timed
from .backward import by_next_state, known, root, smoothed
from .carried import Back, Ways
from .finish import both_noises, pushed, pushed_neighbours, residuals, ways
from .forward import KEPT, Kept
from .windows import lagged


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What `smooth` returns; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray or pandas.DataFrame
        Estimates of the state, from the whole record or up to the lag.
    std : (N, n) ndarray or pandas.DataFrame
        Their one-sigma errors, square roots of the diagonal of P.
    P : (N, n, n) ndarray
        Covariances of their errors e, which are estimate less state.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    _noises: Callable[[], tuple[Any, Any]] = field(repr=False)
    _neighbours: Callable[[], np.ndarray] = field(repr=False)

    @property
    def w(self) -> np.ndarray:
        """E[w | y], the process noise that leads from a row to the next one, (N, n).

        It is found when first read, with `v`.
        """
        return self._both[0]

    @property
    def v(self) -> np.ndarray:
        """E[v | y], the measurement noise of each row, (N, p).

        Also of outputs that are missing, as far as others tell of it.
        """
        return self._both[1]

    @cached_property
    def _both(self) -> tuple[Any, Any]:
        return self._noises()

    @cached_property
    def lag_one(self) -> np.ndarray:
        """The covariance E[e_k e_{k-1}'] of row k with the row before, (N, n, n).

        It is found when first read: another pass of the filter, and the way back.

        The first row is with the state at instant 0, or, if P0 is the prior of the
        first sample, with itself.  For a fixed lag either error is that of its own row.
        """
        return self._neighbours()


class Smoother:
    """A record that is read from front to back, and smoothed as far as it goes.

    What is kept between two blocks is the row before those that wait, and these.
    """

    def __init__(
        self, plant: Plant, m1: Outputs, lag: int | None, weight: Any, backend: str
    ) -> None:
        self.plant, self.lag, self.backend = plant, lag, backend
        self.m1, self.weight = m1, weight
        self.periods = np.empty(0)  # of a continuous plant: those to the rows kept
        if plant.dt > 0:  # else they come with the rows
            self.accurate = Settings(plant, m1, weight)
            self.settings = Settings(plant, 0)
            self.run = Pass(self.settings)
        kernels.runs_compiled(backend, 0)  # refuse a backend now, not at the first rows

    def begin(self, u0: Matrix) -> None:
        """Before the first row."""
        plant = self.plant
        self.state = start(self, plant.x0, u0)
        self.kept = Kept.empty(0, plant)
        self.y, self.u = np.empty((0, plant.p)), np.empty((0, plant.m))
        self.index: Any = None
        self.gap: Gap | None = None  # that the last row is in
        self.first, self.done = 1, 0  # instant of the first row, rows that were given

    def read(self, y: Any, u: Any) -> None:
        """Filter the next rows, and keep them."""
        plant = self.plant
        if isinstance(y, Timed):
            self._sample(y.periods)
            y = y.y
        columns = (plant.p, plant.output_names), (plant.m, plant.input_names)
        values, inputs = chunks.arrays(y, u, *columns, missing=True)
        last = self.state.instant + len(values)
        require_instants(plant, last)
        ready = partial(self.run.at_hand, self.state, values, loops=KEPT)
        self.fast = kernels.runs_compiled(self.backend, last, ready=ready)
        self.before = self.state
        new, self.state = self._filtered(self.state, values, inputs)
        self._require_digits(new, values, inputs)
        self.kept = self.kept.before(new) if len(self.kept) else new
        self.y = np.concatenate([self.y, values])
        self.u = np.concatenate([self.u, inputs])
        self.index = dataframes.joined(self.index, y)

    def _require_digits(self, new: Kept, y: Matrix, u: Matrix) -> None:
        """Refuse readings that come where states have grown too far together."""
        kept = self.fast, new.Sigma
        rows = passed(self.run, self.before, y, u, new.variances, *kept)
        self.gap = require_digits(self.gap, rows)

    def _filtered(self, state: State, y: Matrix, u: Matrix) -> tuple[Kept, State]:
        new = Kept.empty(len(y), self.plant)
        state = self.run.into(new, state, y, u, self.fast, KEPT)
        missing = np.isnan(y)
        if missing.any():
            new.forget(missing)
        return new, state

    def _sample(self, periods: Vector) -> None:
        """The plant at the rows that are kept and at those to which `periods` lead."""
        self.periods = np.concatenate([self.periods, periods])
        known = self.periods if len(self.periods) else np.ones(1)  # no rows: any
        begin = self.first - 1
        self.settings = window(self.plant, known, 0, None, begin)
        self.accurate = window(self.plant, known, self.m1, self.weight, begin)
        self.run, self.state = Pass(self.settings), self.state.under(self.settings)

    def step(self, _: Any, y: Any, u: Any) -> tuple[None, Smoothed]:
        """Read a chunk; give the rows whose lag has passed."""
        self.read(y, u)
        return None, self.rows(last=False)

    def over(self, blocks: Iterator[Smoothed]) -> Iterator[Smoothed]:
        """The blocks, and then the rows that are left."""
        yield from blocks
        yield self.rows(last=True)

    def rows(self, last: bool) -> Smoothed:
        """Smooth the rows that wait no more, and forget them but for one."""
        N, lag = len(self.kept), self.lag
        wait = 0 if last or lag is None else min(lag + 1, N)
        ready, old = max(N - wait, self.done), self.done
        seen = ~np.isnan(self.y)
        leads = ways(self.settings, self.first, seen)
        if lag is None:
            back = smoothed(self.kept, leads, self.fast, neighbours=False)
        else:
            back = lagged(self.kept, leads, lag, ready)
            if not old and ready:
                self._first(self.kept, back)
        found = self._finished(back, leads, seen, ready, old)
        if lag is not None:
            self._forget(ready)
        return found

    def _finished(
        self, back: Back, leads: Ways, seen: Matrix, ready: int, old: int
    ) -> Smoothed:
        """The rows from `old` on, with their noises and accurate outputs met."""
        plant, first, seen = self.plant, self.first, seen[:ready]
        settings, accurate = self.settings, self.accurate  # the next rows have others
        y, u, lamda, x = self.y[:ready], self.u[:ready], back.lamda, back.x
        index = None if self.index is None else self.index[old:ready]

        def noises() -> tuple[Any, Any]:
            rho = residuals(settings, first, seen, y, u, x)
            found = both_noises(settings, first, seen, lamda[1:], rho)
            names = plant.state_names, plant.output_names
            w, v = (dataframes.framed(X[old:], N, index) for X, N in zip(found, names))
            return w, v

        U = back.U
        meets = bool(accurate.accurate)
        if meets:
            rho = residuals(settings, first, seen, y, u, x)
            back = pushed(accurate, first, seen, back, rho)

        def neighbours() -> Matrix:
            found = self._all_neighbours(leads) if U is None else U
            if meets:
                found = pushed_neighbours(accurate, first, seen, found)
            return found[old:]

        P = back.Sigma[old:ready]
        shown, sigma = (
            dataframes.framed(X, plant.state_names, index)
            for X in (back.x[old:ready], back.std(slice(old, ready)))
        )
        return Smoothed(shown, sigma, P, noises, neighbours)

    def _all_neighbours(self, leads: Ways) -> Matrix:
        """E[e_k e_{k-1}'] of a whole record: all of it once more."""
        kept, _ = self._filtered(self.before, self.y, self.u)
        back = smoothed(kept, leads, self.fast, neighbours=True)
        assert back.U is not None
        if len(kept):
            self._first(kept, back)
        return back.U[: len(kept)]

    def _first(self, kept: Kept, back: Back) -> None:
        """Put E[e_1 e_0'], of the first row and the state before the record."""
        assert back.U is not None
        P0, x0 = Spread.of(require_start(self.plant)), self.plant.x0
        prediction = kept.x[0] - kept.K[0] @ kept.innovation[0]
        carried = known(back.x[0], root(back.Sigma[0]))
        move = first_move(self.settings.plant)
        back.U[0] = by_next_state(move, P0, x0, prediction, carried)[1]["U_next"]

    def _forget(self, ready: int) -> None:
        """Keep the row before those that wait, and these."""
        gone = max(ready - 1, 0)
        self.periods = self.periods[gone:]
        self.kept, self.first, self.done = (
            self.kept.since(gone),
            self.first + gone,
            ready - gone,
        )
        self.y, self.u = self.y[gone:], self.u[gone:]
        self.index = None if self.index is None else self.index[gone:]
