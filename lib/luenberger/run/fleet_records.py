"""Many records of one plant as arrays that were checked, a block of them at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..formats import dataframes
from ..numeric import Matrix
from ..numeric.linalg import finite
from . import chunks

ALONE = "one by one, with y[k], all records that are refused can be found"

Three = np.ndarray[tuple[int, int, int], np.dtype[Any]]  # an array (M, N, p)
Many = Three | Sequence[Matrix] | Sequence[Sequence[Sequence[float]]]


def many(y: Any) -> bool:
    """Whether y holds many records: an array (M, N, p), or a list of records (N, p)."""
    axes, one = 0, y
    while isinstance(one, list | tuple) and len(one):
        axes, one = axes + 1, one[0]
    if dataframes.is_table(one):
        return axes > 0
    return axes + getattr(one, "ndim", 0) >= 3


@dataclass(frozen=True, eq=False)
class Records:
    """Records (M, N, p) of one plant, which are read as they are asked for.

    Attributes
    ----------
    y : (M, N, p) array
        As it was given, NaN where a record has ended; an array on disk stays there.
    u : (M, N, m) or (N, m) array
        Inputs of each record, or of all.
    missing : bool
        Whether outputs may be missing before a record has ended.
    """

    y: Any
    u: Any
    missing: bool = True

    @classmethod
    def of(cls, y: Any, u: Any, p: int, m: int, missing: bool = True) -> Records:
        """The records, if their shapes are those of p outputs and m inputs.

        Raises
        ------
        ValueError
            If sizes disagree; it names the record.
        """
        lengths = None
        if isinstance(y, list | tuple):
            y = [_record("y", k, one, p) for k, one in enumerate(y)]
            lengths = [len(one) for one in y]
            y = padded(y, np.nan)
        if y.ndim != 3 or y.shape[2] != p:
            raise ValueError(
                f"y must be (N, {p}), or (M, N, {p}) for many records, got {y.shape}"
            )
        M, N, _ = y.shape
        if u is None or (isinstance(u, int | float) and u == 0):
            return cls(y, np.zeros((N, m)), missing)
        if isinstance(u, list | tuple) and many(u):
            u = _inputs(u, m, lengths or [N] * M)
        u = u if hasattr(u, "ndim") else chunks.real("u", u, "an array of numbers")
        if tuple(u.shape) not in ((M, N, m), (N, m)):
            raise ValueError(
                f"u must be ({M}, {N}, {m}), or ({N}, {m}) for all records, got "
                f"{u.shape}"
            )
        return cls(y, u, missing)

    def __len__(self) -> int:
        return len(self.y)

    @cached_property
    def complete(self) -> bool:
        """Whether they are in memory and nothing is missing; False may be wrong."""
        return (
            type(self.y) is type(self.u) is np.ndarray
            and self.y.dtype == self.u.dtype == float
            and finite(self.u)
            and complete(self.y)
        )

    @property
    def rows(self) -> int:
        """N, of each record."""
        return int(self.y.shape[1])

    def part(self, begin: int, end: int) -> tuple[Matrix, Matrix]:
        """y (k, N, p) and u, (k, N, m) or (N, m), of some records, as they came."""
        u = self.u[begin:end] if self.u.ndim == 3 else self.u
        wanted = "an array of numbers"
        return chunks.real("y", self.y[begin:end], wanted), chunks.real("u", u, wanted)

    def block(self, begin: int, end: int) -> tuple[Matrix, Matrix]:
        """The same, checked; see `require`."""
        y, u = self.part(begin, end)
        require(y, u, begin, self.missing)
        return y, u


def complete(y: Matrix) -> bool:
    """Whether records have no gaps, as a quick look tells; False may be wrong."""
    return not np.isnan(y[:1]).any() and finite(y)  # gaps are often in all


def require(y: Matrix, u: Matrix, begin: int, missing: bool) -> bool:
    """Whether nothing is missing; False may be wrong.

    Raises
    ------
    ValueError
        Naming the record, counted from `begin`, and the row of what is no number.
    """
    if u.size and not finite(u):
        _require("u", ~np.isfinite(u), "missing or not finite", begin)
    if complete(y):
        return True
    _require("y", np.isinf(y), "infinite", begin)
    if not missing:
        gaps = np.isnan(y) & ~ended(y)[..., None]
        what = "missing before the end (filter_data takes gaps)"
        _require("y", gaps, what, begin)
    return False


def ended(y: Matrix) -> Matrix:
    """Where records (M, N, p) have ended, (M, N): nothing is measured from there on."""
    absent = np.isnan(y).all(axis=2) & (y.shape[2] > 0)
    behind = np.logical_and.accumulate(absent[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(behind)


def padded(records: Sequence[Matrix], value: float) -> Matrix:
    """Records (N, p) of several lengths as (M, N, p), `value` behind their ends."""
    rows = max((len(one) for one in records), default=0)
    width = records[0].shape[1] if records else 0
    out = np.full((len(records), rows, width), value)
    for one, place in zip(records, out):
        place[: len(one)] = one
    return out


def _record(name: str, k: int, value: Any, width: int) -> Matrix:
    """Record k of a list."""
    if dataframes.is_table(value):
        raise ValueError(
            f"record {k} of {name} is a table, and many records are one array: give "
            f"{name}=[table[columns].to_numpy() for table in {name}]"
        )
    found = chunks.real(f"record {k} of {name}", value, "an array of numbers")
    if found.ndim != 2 or found.shape[1] != width:
        raise ValueError(
            f"record {k} of {name} must be (N, {width}), got {found.shape}"
        )
    return found


def _inputs(u: Sequence[Any], m: int, lengths: Sequence[int]) -> Matrix:
    """Inputs of each record, zero behind its end."""
    if len(u) != len(lengths):
        raise ValueError(f"y has {len(lengths)} records but u has {len(u)}")
    found = [_record("u", k, one, m) for k, one in enumerate(u)]
    for k, (one, rows) in enumerate(zip(found, lengths)):
        if len(one) != rows:
            raise ValueError(f"record {k}: y has {rows} rows but u has {len(one)}")
    return padded(found, 0.0)


def _require(name: str, bad: Matrix, what: str, begin: int) -> None:
    """ValueError naming the first bad record, counted from `begin`, and its row."""
    if bad.any():
        *record, row, _ = np.argwhere(bad)[0].tolist()
        where = f"record {begin + record[0]}, row {row}" if record else f"row {row}"
        raise ValueError(f"{name} in {where} is {what}")


def parts(total: int, size: int) -> Iterator[tuple[int, int]]:
    """(begin, end) of parts of so many records; one part of none, if there are none."""
    for begin in range(0, max(total, 1), size):
        yield begin, min(begin + size, total)
