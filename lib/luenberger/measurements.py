"""Recorded measurements as CSV, the estimates made from them, and these as CSV."""

import csv
import dataclasses
from dataclasses import dataclass

import numpy as np

from .analysis import error_covariance
from .filtering import filter_data
from .recorded import estimate

TIME = ("time", "t", "instant")  # a first column of this name is only carried along


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
        The record's own time column, or the instants 1 .. N.
    """

    y: np.ndarray
    u: np.ndarray
    time: np.ndarray

    def of(self, plant, state):
        """The record of an output that is this very state, or None."""
        for k in range(plant.p):
            unit = np.arange(plant.n) == state
            if np.array_equal(plant.C[k], unit) and not plant.E[k].any():
                return self.y[:, k]
        return None

    @property
    def missing(self):
        """How many single measurements are missing."""
        return int(np.isnan(self.y).sum())


def read(path, plant):
    """Read a CSV file whose columns are named after the plant's outputs and inputs.

    The columns may come in any order, a column `time`, `t` or `instant` beside them.
    An empty cell or `nan` in an output column means that it was not measured.

    Raises
    ------
    ValueError
        Naming the line and the column that are not as they should be.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            lines = [(k, row) for k, row in _numbered(file) if any(map(str.strip, row))]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: not a CSV file: {error}") from None
    if not lines:
        raise ValueError(f"{path}: the file is empty")
    header = [cell.strip() for cell in lines[0][1]]
    time = _check_header(path, header, plant)
    if len(lines) == 1:
        raise ValueError(f"{path}: there are column names but no measurements")
    columns = {name: [] for name in header}
    for k, row in lines[1:]:
        if len(row) != len(header):
            raise ValueError(
                f"{path}, line {k}: {len(row)} cells, but the header names "
                f"{len(header)} columns"
            )
        for name, cell in zip(header, row):
            may_miss = name in plant.output_names
            columns[name].append(_cell(path, k, name, cell.strip(), may_miss))
    count = len(lines) - 1
    return Measurements(
        y=_stack(columns, plant.output_names, count),
        u=_stack(columns, plant.input_names, count),
        time=np.array(columns[time]) if time else np.arange(1.0, count + 1),
    )


def _numbered(file):
    reader = csv.reader(file, strict=True)
    for row in reader:
        yield reader.line_num, row


def _check_header(path, header, plant):
    """Return the name of the time column, if any; raise unless the rest is right."""
    wanted = [*plant.output_names, *plant.input_names]
    shared = sorted(set(plant.output_names) & set(plant.input_names))
    if shared:
        raise ValueError(
            f"{path}: {shared} name both an output and an input of the plant, so a "
            "column does not say which it is; rename one in the plant"
        )
    time = next((n for n in header if n.lower() in TIME and n not in wanted), None)
    given = [name for name in header if name != time]
    if len(set(header)) != len(header):
        twice = sorted({name for name in header if header.count(name) > 1})
        raise ValueError(f"{path}: the columns {twice} occur more than once")
    if set(given) != set(wanted):
        lacking = [name for name in wanted if name not in given]
        foreign = [name for name in given if name not in wanted]
        parts = [f"lacks the columns {lacking}"] * bool(lacking)
        parts += [f"has the unknown columns {foreign}"] * bool(foreign)
        raise ValueError(
            f"{path} {' and '.join(parts)}; the plant's outputs and inputs are {wanted}"
        )
    return time


def _cell(path, line, name, text, may_miss):
    if may_miss and text.lower() in ("", "nan"):
        return np.nan
    try:
        value = float(text)
    except ValueError:
        value = None
    if value is None or "_" in text or not np.isfinite(value):
        raise ValueError(f"{path}, line {line}: {name!r} is {text!r}, not a number")
    return value


def _stack(columns, names, count):
    return np.array([columns[name] for name in names]).reshape(-1, count).T


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates (N, n) and their one-sigma bounds (N, n), and how they were made."""

    time: np.ndarray
    x: np.ndarray
    std: np.ndarray
    how: str


def apply(observer, accurate, plant, data):
    """Estimate every state from a record.

    A complete record is run through the observer itself.  Where measurements are
    missing its constant gain is of no use, and the time-varying filter with the same
    accurate outputs takes its place.

    Parameters
    ----------
    observer : Observer
        Constant, an estimate of all states (L = I).
    accurate : tuple of int
        The outputs it takes as accurate.
    plant : Plant
    data : Measurements
    """
    if data.missing:
        done = filter_data(plant, data.y, data.u, m1=accurate)
        how = (
            f"{data.missing} of {data.y.size} measurements are missing, so the "
            "estimates come from the time-varying filter with the same accurate "
            "outputs, which leaves out what was not measured; not from observer.json."
        )
        return Estimates(data.time, done.x, done.std, how)
    here = first_sample(plant)
    x = estimate(observer, data.y, data.u, x0=here.x0)
    if plant.P0 is None:
        covariance = error_covariance(observer, plant)[None]
        how = (
            "the plant gives no P0, so the one-sigma bounds are those of steady state."
        )
    else:
        covariance = covariance_from_start(observer, plant, len(data.y))
        how = "the one-sigma bounds start from the plant's P0."
    variance = np.diagonal(covariance, axis1=1, axis2=2)
    std = np.broadcast_to(np.sqrt(np.maximum(variance, 0)), x.shape)
    how = "The estimates are those of observer.json; " + how
    return Estimates(data.time, x, std, how)


def covariance_from_start(observer, plant, samples):
    """Error covariance of a constant observer at instants 1 .. samples.

    It starts from T times the expected state of the first sample.
    """
    here = first_sample(plant)
    begun = dataclasses.replace(observer, z0=observer.T @ here.x0)
    return error_covariance(begun, here, steps=samples - 1)


def first_sample(plant):
    """The plant with x0 and P0 carried to the first sample, before it is used."""
    A, _, Q = plant.first_step()
    P0 = None if plant.P0 is None else A @ plant.P0 @ A.T + Q
    return dataclasses.replace(plant, x0=A @ plant.x0, P0=P0, P0_is="prior")


def write(file, plant, estimates):
    """Write estimates to an open file: time, then each state and its one sigma."""
    out = csv.writer(file, lineterminator="\n")
    out.writerow(
        ["time", *(s for name in plant.state_names for s in (name, f"{name}_sigma"))]
    )
    for t, x, std in zip(estimates.time, estimates.x, estimates.std):
        pairs = np.stack([x, std], axis=1).ravel()
        out.writerow([repr(float(value)) for value in (t, *pairs)])
