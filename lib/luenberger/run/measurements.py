"""Recorded measurements as CSV, the estimates made from them, and these as CSV."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from ..analysis.error_covariance import error_covariance
from ..at_work import start
from ..formats.csv_table import Table
from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from . import tables
from .clock import Column
from .estimate import estimated, require_finite
from .filter import Filter
from .record import Record


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
    def record(self) -> Record:
        """The rows alone; their times were checked when the file was read."""
        return Record(self.y, self.u, "rows")

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
    with open(path, "rb") as file:
        table = Table(file, path)
        clock = tables.time_column(table, outputs, inputs)
        parts = list(table.rows([*outputs, *inputs], outputs, clock))
    values = np.concatenate([part.values for part in parts])
    stamps = tuple(text for part in parts for text in part.carried)
    lines = [line for part in parts for line in part.lines]
    if clock is None:
        multiples = (plant.dt or 1.0) * np.arange(1, len(values) + 1)
        # without the rounding of the product: 0.3, not 0.30...04
        time = np.array([float(f"{t:.15g}") for t in multiples])
    else:
        at = [f"{path}, line {line}" for line in lines].__getitem__
        column = Column(clock, plant)
        time = column.seconds(stamps, at)
        if plant.dt > 0:
            column.steps(time, at)
    return Measurements(values[:, : plant.p], values[:, plant.p :], time, stamps)


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
    """
    names, covariance = observer.estimate_names, None
    if data.missing:
        done = Filter(plant, accurate).run(Record(data.y, data.u))
        x, std = done.x, done.std
        if not np.array_equal(observer.L, np.eye(plant.n)):
            x, covariance = x @ observer.L.T, observer.L @ done.P @ observer.L.T
        kind = "filter with the same accurate outputs" if accurate else "Kalman filter"
        how = (
            f"{data.missing} of {data.y.size} measurements are missing, so the "
            f"estimates come from the time-varying {kind}, which leaves out what was "
            "not measured; not from observer.json."
        )
    else:
        begin = 0, start(observer, x0=plant.at_first_sample().x0)
        x, std = estimated(observer, begin, data.y, data.u)[1], None
        how = "The estimates are those of observer.json; "
        if plant.Q is None or plant.R is None:
            how += "without Q and R their bounds are not known."
        elif plant.P0 is None:
            how += (
                "the plant gives no P0, so the one-sigma bounds are those of steady "
                "state."
            )
            covariance = error_covariance(observer, plant)[None]
        else:
            how += "the one-sigma bounds start from the plant's P0."
            covariance = covariance_from_start(observer, plant, len(x))
    require_finite(x, names, lambda k: f"instant {k + 1} of the measurements")
    if covariance is not None:
        variance = np.diagonal(covariance, axis1=1, axis2=2)
        std = np.broadcast_to(np.sqrt(np.maximum(variance, 0)), x.shape)
    return Estimates(data.time, x, std, how, names, data.stamps)


def covariance_from_start(observer: Observer, plant: Plant, samples: int) -> Matrix:
    """Error covariance of a constant observer at instants 1 .. samples.

    It starts from T times the expected state of the first sample, where a known input
    of the plant's U begins.
    """
    here = plant.at_first_sample()
    begun = dataclasses.replace(observer, z0=observer.T @ here.x0)
    return error_covariance(begun, here, steps=samples - 1)


def write(file: TextIO, estimates: Estimates) -> None:
    """Write estimates to an open file: time, then each of them and its one sigma.

    Times are those of the record, as they stand there.  Without bounds there are no
    columns for them.
    """
    names: Sequence[str] = estimates.names
    found = estimates.x
    if estimates.std is not None:
        names, found = tables.with_sigmas(names), tables.paired(found, estimates.std)
    times = estimates.stamps or [repr(float(t)) for t in estimates.time]
    tables.write(file, ["time", *names], [(times, found)])
