"""The filter of a plant, as a value: what it finds in a record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import index
from typing import Any

import numpy as np

from ..arguments import expect
from ..errors import SAMPLE, DesignError, short
from ..filtering import likelihood
from ..filtering.likelihood import Score
from ..filtering.maps import Settings
from ..filtering.pack import End, Passage, begin, first_rows, matrices, over
from ..filtering.unknown import is_open
from ..formats import dataframes
from ..numeric import Matrix
from ..plant import Plant
from ..recursion.settings import accurate_outputs
from ..show.blocks import counted, html
from ..show.numbers import number
from ..show.tables import Table
from . import fleet, late
from .clock import require_instants
from .discretise import discretise
from .live import LiveFilter
from .record import Record, Rows

Outputs = int | Sequence[int | str]  # how many, or which
FIRST = 64  # at most that are asked at once what they tell of a start
ROWS = 1 << 10  # of a plant that changes, whose matrices are held at once


@dataclass(frozen=True, eq=False, repr=False)
class Filtered:
    """What `Filter.run` found; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray or pandas.DataFrame
        Estimates of the state, each using y up to and including its row.
    std : (N, n) ndarray or pandas.DataFrame
        Their one-sigma errors, square roots of the diagonals of P.
    end : End
        The filter behind the last row: ``run(more, start=found.end)`` goes on there.
    settled_at : (k,) ndarray of int
        The rows from which on there is one gain, until other outputs arrive: the
        covariance P of a plant that does not change is within e = 1e-11 of the steady
        one, (1 - e) Sigma <= P <= (1 + e) Sigma, and stays there.  The gain differs by
        at most 2 e in these units, and an estimate by at most 1e-8 of its deviations,
        for innovations whose normalised length is one.  With more than six states e
        may be 1e-9, which is rounding, and 1e-8 is then 1e-6.  P and K are those of the
        full recursion.  It is looked for behind 512, 1024, 2048, ... complete rows.
    names : tuple of str
        Those of the states.
    """

    x: Any
    std: Any
    end: End
    settled_at: np.ndarray
    _again: Any
    names: Sequence[str] = ()

    def __repr__(self) -> str:
        return f"{self._head()}\n{self._table()}"

    def _repr_html_(self) -> str:
        return html(self._head(), {}, self._table())

    def _head(self) -> str:
        if not self._many():
            return f"Filtered: {counted(len(self.x), 'row')}; at the last one"
        return f"Filtered: {counted(len(self.x), 'record')}; at the end of the first"

    def _many(self) -> bool:
        return isinstance(self.x, list) or np.ndim(self.x) == 3

    def _table(self) -> Table:
        """The last estimate of each state with its error."""
        found = (X[0] if self._many() else X for X in (self.x, self.std))
        last = (np.asarray(X)[-1:].ravel() for X in found)
        rows = zip(self.names, *last)
        cells = [[name, number(x, 4), number(std, 4)] for name, x, std in rows]
        return Table(["", "estimate", "one sigma"], cells)

    @cached_property
    def P(self) -> np.ndarray:
        """Error covariances (N, n, n), found in a second pass when first read."""
        return self._again()[0]

    @cached_property
    def K(self) -> np.ndarray:
        """Gains (N, n, p), zero for outputs that did not arrive."""
        return self._again()[1]


@dataclass(frozen=True)
class Filter:
    """The filter of least error variance of a noisy plant, over records.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> found = lb.Filter(plant).run([[2], [float("nan")], [2]])
    >>> found.x[:, 0].round(4), found.std[:, 0].round(4)
    (array([1.    , 1.    , 1.3333]), array([0.7071, 0.7071, 0.5774]))

    Parameters
    ----------
    plant : Plant
        With Q, R and P0.  A continuous one is sampled at each record's instants.
    m1 : int or sequence, default 0
        Accurate outputs, as in `reduced_order_filter`; 0 is the Kalman filter.
    weight : (n, n) array_like or "canonical", optional
        As in `reduced_order_filter`.

    Raises
    ------
    DesignError
        If the plant lacks Q or R, or accurate outputs are dependent.
    """

    plant: Plant
    m1: Outputs = 0
    weight: Any = None

    def __post_init__(self) -> None:
        expect(plant=self.plant)
        if self.plant.dt > 0:
            self.settings  # noqa: B018  refuse now what no record can mend

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.plant, self.m1, self.weight)

    @cached_property
    def settings(self) -> Settings:
        """The matrices of its rows, of a discrete plant.

        The Kalman filter's are kept with the plant, which never changes.
        """
        if self.m1 or self.weight is not None:
            return Settings(self.plant, self.m1, self.weight)
        known = vars(self.plant)
        if "_filter" not in known:
            known["_filter"] = Settings(self.plant)
        found: Settings = known["_filter"]
        return found

    def run(self, record: Any, start: End | None = None) -> Filtered:
        """Filter a record in one pass; NaN means not measured.

        Parameters
        ----------
        record : Record, or what one is made of
            Of many records (M, N, p), or of a list of them, x and std are (M, N, n);
            they are lists where records are tables or have several lengths.  What is
            found of a record hangs on no other one, so parts of them may be filtered
            on any executor: ``executor.map(filter.run, record.split(256))``.
        start : End, or as many as there are records, optional
            Where an earlier part of the same run ended.
        """
        record = Record.of(record)
        if record.many:
            return Filtered(*fleet.found(self, record, start))
        found = self.over(record.on(self.plant, start), start)
        if record.index is None:
            return found
        names = self.plant.state_names
        x, std = (
            dataframes.framed(X, names, record.index) for X in (found.x, found.std)
        )
        return replace(found, x=x, std=std)

    def over(self, rows: Rows, start: End | None = None) -> Filtered:
        """The same of rows that are arrays already."""
        windows = list(self._passed(rows, start))
        x, std = (
            parts[0] if len(parts) == 1 else np.concatenate(parts)
            for parts in zip(*((one.x, one.variances) for one in windows))
        )
        np.sqrt(std, out=std)
        first = np.cumsum([0, *(len(one.x) for one in windows)])
        settled = [k + row for k, one in zip(first, windows) for row in one.settled]
        end = windows[-1].end._replace(clock=rows.clock)
        again = partial(self.matrices, rows, start)
        at = np.array(settled, dtype=np.int64)
        return Filtered(x, std, end, at, again, self.plant.state_names)

    def smooth(self, record: Any, lag: int | None = None) -> Any:
        """Estimate the states of a record from all of it; NaN means not measured.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
        >>> found = lb.Filter(plant).smooth([[2], [float("nan")], [2]])
        >>> found.x[:, 0].round(4), found.std[:, 0].round(4)
        (array([1.3333, 1.3333, 1.3333]), array([0.5774, 0.5774, 0.5774]))

        Of all estimates that are linear in the record, these have the least
        covariance.  With accurate outputs they are the best ones that show exactly
        what these show at their own rows.  Without P0 nothing is known of the start;
        the standard deviation of what the record does not determine is inf.

        Parameters
        ----------
        record : Record, or what one is made of
            Of many runs each is smoothed by itself.
        lag : int, optional
            Row k uses measurements up to row k + lag, and near the end as many as there
            are; 0 is the filter.  Default: all rows, before and after.  It takes the
            time of so many rows for each row.

        Returns
        -------
        Smoothed, or a list of Smoothed for many runs

        Raises
        ------
        DesignError
            As from `run`.
        ValueError
            If the record does not fit the plant, or the lag is no whole number that is
            0 or more.

        References
        ----------
        H. E. Rauch, F. Tung and C. T. Striebel, "Maximum likelihood estimates of linear
        dynamic systems", AIAA Journal 3 (1965) 1445-1450;
        smoothing/derivation/next_state.py.
        A. E. Bryson and M. Frazier, "Smoothing for linear and nonlinear dynamic
        systems", Wright-Patterson AFB, TDR-63-119 (1963);
        smoothing/derivation/adjoint.py.
        """
        from .smoothed import over  # which needs a filter

        record = Record.of(record)
        lag = None if lag is None else whole("lag", lag)
        runs = record.each() if record.many else [record]
        found = [over(self, one.on(self.plant), lag, one.index) for one in runs]
        return found if record.many else found[0]

    def live(self, horizon: int = 0, u0: Any = None) -> LiveFilter:
        """The filter at work, which gets readings as they come.

        The reading of the first instant comes one instant late:

        >>> import luenberger as lb
        >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
        >>> now = lb.Filter(plant).live(horizon=1)
        >>> x, sigma = now.measure([float("nan")])
        >>> now.advance()
        >>> x, sigma = now.measure([2.0])
        >>> x, sigma = now.arrived(0, age=1, value=2.0)
        >>> x.round(4), sigma.round(4)
        (array([1.3333]), array([0.5774]))

        Parameters
        ----------
        horizon : int, default 0
            How many instants back a reading may come late; it holds as many states.
        u0 : (m,) array_like, optional
            The input that acted until the first measurement, default zero.

        Returns
        -------
        LiveFilter

        Raises
        ------
        DesignError
            If the plant is continuous.
        """
        if self.plant.dt == 0:
            raise DesignError(
                "a filter at work needs a sampling period, and the plant is continuous "
                f"(dt = 0): {SAMPLE}, and Filter(plant.sampled(0.1)).live() its filter"
            )
        return LiveFilter(self.plant, self.settings, whole("horizon", horizon), u0)

    def log_likelihood(self, record: Any) -> float:
        """The logarithm of the likelihood of a record; of many, of all together.

        Two measurements of a number of variance 3, with noise of variance 1: they have
        the covariance [[4, 3], [3, 4]], whose determinant is 7.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[3]])
        >>> round(lb.Filter(plant).log_likelihood([[0], [0]]), 4)
        -2.8108

        It is the density of y, given u, of a plant with Gaussian noises and a Gaussian
        start: the product of the densities of the innovations.  With nu an innovation
        and M its variance, output by output,
        ``-1/2 sum (log(2 pi M) + nu^2 / M)``.

        A reading that the readings before determine has no density of its own; the
        likelihood is the density of the others, in the units of y.

        Without P0 nothing is known of the state x[1] at the first row.  The density is
        then integrated over x[1]: it is the limit of
        ``log density + 1/2 log det(2 pi P0)`` as P0 grows, up to a factor that depends
        on A and C alone the density of what the record shows beside its start.
        statsmodels counts n more factors (2 pi)^(-1/2).

        Raises
        ------
        DesignError
            If an accurate output has noise, so that the filter is not the one whose
            innovations are white; if noise-free outputs contradict each other or a
            state known exactly; if there is no P0 and the record does not determine
            the state.

        References
        ----------
        Schweppe, "Evaluation of likelihood functions for Gaussian signals", IEEE Trans.
        Inf. Theory 11 (1965) 61-70; de Jong, "The diffuse Kalman filter", Ann. Statist.
        19 (1991) 1073-1083; identification/derivation/likelihood.py;
        identification/derivation/unknown_start.py.
        """
        record = Record.of(record)
        if record.many:
            return sum(map(self.log_likelihood, record.each()))
        return likelihood.value(self.passed(record, "values"), self.plant)

    def score(self, record: Any) -> Score:
        """The gradient of `log_likelihood` in Q, R and S, by one pass back.

        References
        ----------
        Koopman and Shephard, "Exact score for time series models in state space form",
        Biometrika 79 (1992) 823-826; identification/derivation/score.py.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[3]])
        >>> lb.Filter(plant).score([[0], [0]]).R.round(4)
        array([[-0.5714]])
        """
        record = Record.of(record)
        if record.many:
            found = [self.score(one) for one in record.each()]
            return Score(*(sum(getattr(one, k) for one in found) for k in "QRS"))
        return likelihood.score(self.passed(record, "readings"), self.plant)

    def innovations(self, record: Any) -> Any:
        """What each reading adds to those before it, in units of its deviation.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[3]])
        >>> lb.Filter(plant).innovations([[2], [float("nan")]])
        array([[ 1.],
               [nan]])

        If the plant is right, with its Q and R, they are uncorrelated and of variance
        one: `whiteness` tests that.  Those of one instant come in the order of the
        outputs.

        Returns
        -------
        (N, p) ndarray or pandas.DataFrame
            NaN where nothing was measured, where the readings before determine it, and
            where a start of which nothing is known leaves it open.
        """
        record = Record.of(record)
        found = likelihood.normalised(self.passed(record, "values"))
        return dataframes.framed(found, self.plant.output_names, record.index)

    def passed(self, record: Record | Rows, keep: str) -> list[Passage]:
        """What the Kalman filter keeps of one record, for its likelihood."""
        for k in accurate_outputs(self.plant, self.m1):
            if np.any(self.plant.R[..., k, k]):
                raise DesignError(
                    f"the output {self.plant.output_names[k]!r} is noisy, so a filter "
                    "that treats it as exact leaves innovations that are not white, "
                    "and their densities do not multiply to a likelihood. Use m1=0, or "
                    "give the output no noise in R."
                )
        rows = record if isinstance(record, Rows) else record.on(self.plant)
        one = Filter(self.plant) if self.m1 else self
        return list(one._windows(rows, None, keep))

    def _passed(self, rows: Rows, start: End | None, keep: str = "") -> Any:
        """Passage by passage, each row with what had arrived by then."""
        if rows.due is not None:
            return late.windows(self._at, rows, start, self._size(rows), keep)
        late.require_none_awaited(start)
        return self._windows(rows, start, keep)

    def _windows(self, rows: Rows, start: End | None, keep: str = "") -> Any:
        """Passage by passage over the rows."""
        end = start
        for part, settings in self.parts(rows, 0 if start is None else start.instant):
            if end is None:
                end = begin(settings, rows.u0, known=False)
            k, stop = part.start, min(part.stop, len(rows.y))
            while is_open(end.state) and k < stop:
                some = slice(k, min(k + FIRST, stop))
                one = first_rows(settings, end, rows.y[some], rows.u[some], keep)
                k, end = k + len(one.x), one.end
                yield one
            if k < stop or not len(rows.y):
                rest = slice(k, stop)
                one = over(settings, end, rows.y[rest], rows.u[rest], keep)
                end = one.end
                yield one

    def parts(self, rows: Rows, instant: int = 0) -> Iterator[tuple[slice, Settings]]:
        """Rows behind an instant that are done at once, with their settings."""
        size = self._size(rows)
        for k in range(0, max(len(rows.y), 1), size):
            part = slice(k, k + size)
            yield part, self._at(rows, part, instant + k)

    def _size(self, rows: Rows) -> int:
        """How many rows are done at once."""
        whole = self.plant.steps is None and rows.periods is None
        return max(len(rows.y), 1) if whole else ROWS

    def _at(self, rows: Rows, part: slice, instant: int) -> Settings:
        """The settings of some rows."""
        if rows.periods is None:
            require_instants(self.plant, instant + len(rows.y[part]))
            return self.settings
        steps = rows.periods[part]
        if not len(steps):
            steps = np.ones(1)  # of no rows
        if (steps == steps[0]).all():
            return Settings(self.plant.sampled(float(steps[0])), self.m1, self.weight)
        return Settings(discretise(self.plant, steps), self.m1, self.weight, instant)

    def matrices(self, rows: Rows, start: End | None) -> tuple[Matrix, Matrix]:
        """Covariances and gains of all rows."""
        passed = self._passed(rows, start, "all")
        P, K = zip(*map(matrices, passed))
        return np.concatenate(P), np.concatenate(K)


def whole(name: str, value: Any) -> int:
    """The value as an int, if it is a number of rows."""
    try:
        rows = -1 if isinstance(value, (bool, np.bool_)) else index(value)
    except TypeError:
        rows = -1
    if rows < 0:
        raise ValueError(
            f"{name} must be a number of rows, 0 or more, got {short(value)}"
        )
    return rows
