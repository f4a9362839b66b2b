"""Recorded measurements as CSV, the estimates made from them, and these as CSV."""

import csv
import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from ..analysis.error_covariance import error_covariance
from ..analysis.known_input import Statistics
from ..at_work import start
from ..errors import few, short
from ..formats.csv_reader import Table, separator
from ..formats.json_files import opened
from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from .clock import Column
from .estimate import estimated
from .filter import Filter
from .record import Record

TIME = ("time", "t", "instant")  # a first column of such a name holds instants


@dataclass(frozen=True, eq=False)
class Measurements:
    """A record: row k is instant k + 1, the k-th sample after the initial condition.

    Attributes
    ----------
    y : (N, p) ndarray
        Measurements; NaN where a channel was not measured.
    u : (N, m) ndarray
        Known inputs.
    time : (N,) ndarray
        Seconds: the record's own time column, dates from the first on; without one,
        dt times the instants 1 .. N.
    stamps : tuple of str
        The time column as it stands in the file; empty without one.
    """

    y: np.ndarray
    u: np.ndarray
    time: np.ndarray
    stamps: tuple[str, ...] = ()

    def of(self, plant: Plant, row: Vector) -> Vector | None:
        """The record of an output that is this very combination of states, or None."""
        for k in range(plant.p):
            if np.array_equal(plant.C[k], row) and not plant.E[k].any():
                return self.y[:, k]
        return None

    @property
    def missing(self) -> int:
        """How many single measurements are missing."""
        return int(np.isnan(self.y).sum())


def read(path: str | Path, plant: Plant) -> Measurements:
    """Read a CSV file whose columns are named after the plant's outputs and inputs.

    The columns may come in any order, a column `time`, `t` or `instant` beside them.
    An empty cell or `nan` in an output column means that it was not measured.  Times
    are seconds or dates, or numbers of samples in a column `instant`; they must agree
    with a discrete plant's dt.

    Raises
    ------
    ValueError
        Naming the line and the column that are not as they should be.
    """
    outputs, inputs = plant.output_names, plant.input_names
    with opened(path) as file:
        table = Table(file, path)
        clock = time_column(table, outputs, inputs)
        parts = list(table.rows([*outputs, *inputs], outputs, clock))
    values = np.concatenate([part.values for part in parts])
    stamps = tuple(text for part in parts for text in part.carried)
    lines = [line for part in parts for line in part.lines]
    if clock is None:
        time = _rounded((plant.dt or 1.0) * np.arange(1, len(values) + 1))
    else:
        at = [f"{path}, line {line}" for line in lines].__getitem__
        time = Column(clock, plant).seconds(stamps, at)
    return Measurements(values[:, : plant.p], values[:, plant.p :], time, stamps)


def _rounded(time: Vector) -> Vector:
    """Multiples of a period without the rounding of the product: 0.3, not 0.30...04."""
    return np.array([float(f"{t:.15g}") for t in time])


def time_column(
    table: Table, outputs: Sequence[str], inputs: Sequence[str], others: bool = False
) -> str | None:
    """The name of a table's time column, or None.

    Blanks around a name do not count, in the plant as in the table.

    Raises
    ------
    ValueError
        Unless the outputs and the inputs are columns, and, but for `others`, there
        are no more.
    """
    where, header = table.where, table.header
    wanted = [name.strip() for name in (*outputs, *inputs)]
    if shared := _repeated(wanted):
        raise ValueError(
            f"{where}: {few(shared)} each name more than one output or input, so a "
            "column does not say which it is; rename one in the plant"
        )
    if twice := _repeated(header):
        raise ValueError(f"{where}: the columns {few(twice)} occur more than once")
    time = next((n for n in header if n.lower() in TIME and n not in wanted), None)
    given = dict.fromkeys(name for name in header if name != time)
    known = dict.fromkeys(given if others else wanted)
    lacking = [name for name in wanted if name not in given]
    foreign = [name for name in given if name not in known]
    _require_columns(table, wanted, lacking, foreign)
    return time


def _require_columns(
    table: Table, wanted: Sequence[str], lacking: Sequence[str], foreign: Sequence[str]
) -> None:
    """Raise if columns are lacking, or some are not known."""
    marks = separator(table.header)
    if lacking and marks:
        raise ValueError(
            f"{table.where}: {marks} separate the columns, and commas should; numbers "
            "have a decimal point"
        )
    parts = [f"lacks the columns {few(lacking)}"] * bool(lacking)
    parts += [f"has the unknown columns {few(foreign)}"] * bool(foreign)
    if parts:
        raise ValueError(
            f"{table.where} {' and '.join(parts)}; outputs and inputs are {few(wanted)}"
        )


def _repeated(names: Iterable[str]) -> list[str]:
    return sorted(name for name, count in Counter(names).items() if count > 1)


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates (N, q), their one-sigma bounds (N, q) or None, and how it was done."""

    time: np.ndarray
    x: np.ndarray
    std: np.ndarray | None
    how: str
    names: tuple[str, ...]
    stamps: tuple[str, ...] = ()


def apply(
    observer: Observer,
    accurate: Sequence[int],
    plant: Plant,
    data: Measurements,
    U: Statistics | None = None,
) -> Estimates:
    """Estimate from a record what an observer estimates.

    A complete record is run through the observer itself.  Where measurements are
    missing its constant gain is of no use, and the time-varying filter with the same
    accurate outputs takes its place.

    Parameters
    ----------
    observer : Observer
        Constant.
    accurate : tuple of int
        The outputs it takes as accurate.
    plant : Plant
    data : Measurements
    U : (m,) or (m, m) array_like, Plant or 0, optional
        As of `error_covariance`, for the bounds.
    """
    if data.missing:
        return _filtered(observer, accurate, plant, data)
    begin = 0, start(observer, x0=plant.at_first_sample().x0)
    _, x = estimated(observer, begin, data.y, data.u)
    names = observer.estimate_names
    require_finite(x, names, _row)
    how, covariance = "without Q and R their bounds are not known.", None
    if plant.Q is not None and plant.R is not None:
        how, covariance = _bounds(observer, plant, len(x), U)
    how = "The estimates are those of observer.json; " + how
    if covariance is None:
        return Estimates(data.time, x, None, how, names, data.stamps)
    std = np.broadcast_to(_deviations(covariance), x.shape)
    return Estimates(data.time, x, std, how, names, data.stamps)


def _deviations(covariance: Matrix) -> Matrix:
    variance = np.diagonal(covariance, axis1=1, axis2=2)
    return np.sqrt(np.maximum(variance, 0))


def _filtered(
    observer: Observer, accurate: Sequence[int], plant: Plant, data: Measurements
) -> Estimates:
    """The estimates of a record in which measurements are missing."""
    L, whole = observer.L, np.array_equal(observer.L, np.eye(plant.n))
    done = Filter(plant, accurate).run(Record(data.y, data.u))
    x, std = done.x, done.std
    if not whole:
        x, std = x @ L.T, _deviations(L @ done.P @ L.T)
    require_finite(x, observer.estimate_names, _row)
    kind = "filter with the same accurate outputs" if accurate else "Kalman filter"
    how = (
        f"{data.missing} of {data.y.size} measurements are missing, so the "
        f"estimates come from the time-varying {kind}, which leaves out what was "
        "not measured; not from observer.json."
    )
    return Estimates(data.time, x, std, how, observer.estimate_names, data.stamps)


def _bounds(
    observer: Observer, plant: Plant, samples: int, U: Statistics | None
) -> tuple[str, Matrix]:
    """Where the one-sigma bounds start, in words, and the error covariances."""
    if plant.P0 is None:
        how = (
            "the plant gives no P0, so the one-sigma bounds are those of steady state."
        )
        return how, error_covariance(observer, plant, U=U)[None]
    how = "the one-sigma bounds start from the plant's P0."
    return how, covariance_from_start(observer, plant, samples, U)


def _row(k: int) -> str:
    return f"instant {k + 1} of the measurements"


def covariance_from_start(
    observer: Observer, plant: Plant, samples: int, U: Statistics | None = None
) -> Matrix:
    """Error covariance of a constant observer at instants 1 .. samples.

    It starts from T times the expected state of the first sample, where a known input
    of the statistics U begins.
    """
    here = plant.at_first_sample()
    begun = dataclasses.replace(observer, z0=observer.T @ here.x0)
    return error_covariance(begun, here, steps=samples - 1, U=U)


def require_finite(x: Matrix, names: Sequence[str], at: Callable[[int], str]) -> None:
    """Raise unless every estimate is finite; `at(k)` says where row k is."""
    if not np.isfinite(x).all():
        k, j = np.argwhere(~np.isfinite(x))[0]
        raise ValueError(
            f"{at(k)}: the estimate of {short(names[j])} overflows; the measurements "
            "are too large, or the observer is not stable"
        )


def write(file: TextIO, estimates: Estimates) -> None:
    """Write estimates to an open file: time, then each of them and its one sigma.

    Times are those of the record, as they stand there.  Without bounds there are no
    columns for them.
    """
    out, wide = csv.writer(file, lineterminator="\n"), ("", "_sigma")
    if estimates.std is None:
        table, wide = estimates.x, wide[:1]
    else:
        pairs = np.stack([estimates.x, estimates.std], axis=2)
        table = pairs.reshape(len(pairs), -1)
    names = (name + end for name in estimates.names for end in wide)
    out.writerow(["time", *names])
    times = estimates.stamps or [repr(float(t)) for t in estimates.time]
    for time, row in zip(times, table):
        out.writerow([time, *(repr(float(value)) for value in row)])
