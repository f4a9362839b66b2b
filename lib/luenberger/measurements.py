"""Recorded measurements and inputs as CSV, and estimates written back as CSV."""

import csv
from dataclasses import dataclass

import numpy as np

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
                f"{path}, line {k}: {len(row)} cells, but {len(header)} columns are named"
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


def write(file, plant, time, x, std):
    """Write estimates (N, n) and their one-sigma bounds (N, n) to an open file."""
    out = csv.writer(file, lineterminator="\n")
    out.writerow(
        ["time", *(s for name in plant.state_names for s in (name, f"{name}_sigma"))]
    )
    for t, estimate, sigma in zip(time, x, std):
        pairs = np.stack([estimate, sigma], axis=1).ravel()
        out.writerow([repr(float(value)) for value in (t, *pairs)])
