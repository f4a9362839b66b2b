"""Many records in parts: here or on an executor, into memory, a file or a function.

Where a record is filtered, and beside which, leaves no trace in its bits; see `fleets`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..errors import DesignError, short
from ..formats import array_files
from ..numeric import Matrix
from .executor import in_order
from .fleet_records import ALONE, Records, parts

BLOCK = 64  # records that run side by side
TASKS = 64  # parts that a cluster is given, unless the caller says how many records
EACH = 4  # parts for each worker, where their number is known: some take longer
NUMBERS = 4_000_000  # of a part at most, as far as blocks allow
AHEAD = 64  # parts that a cluster has at a time
Arrays = Mapping[str, np.ndarray]
Into = str | Path | Callable[[int, Any], object]


class Task(Protocol):
    """What is done with some records; it can be pickled."""

    def room(self, M: int, N: int, complete: bool = False) -> Arrays:
        """Arrays for what is found in M records of N rows, nothing missing or not."""

    def __call__(self, first: int, y: Matrix, u: Matrix, out: Arrays) -> None:
        """Write to `out` what is found in records, which are numbered from `first`."""

    def leaves(self, found: Arrays) -> Arrays:
        """What of that goes to another process, to a file or a function."""


@dataclass(frozen=True)
class Where:
    """Where records are filtered, how many at a time, and where results go.

    Attributes
    ----------
    executor : concurrent.futures.Executor or None
    chunk : int or None
        Records of a task, rounded up to blocks of 64.
    into : path, callable or None
    """

    executor: Any = None
    chunk: Any = None
    into: Any = None

    def require_none(self) -> None:
        """ValueError if something was asked for that is for many records."""
        for name in ("executor", "chunk", "into"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name} is for many records, (M, N, p), and y is one")

    def __post_init__(self) -> None:
        chunk = self.chunk
        whole = isinstance(chunk, int | np.integer) and not isinstance(chunk, bool)
        if chunk is not None and (not whole or chunk < 1):
            raise ValueError(f"chunk must be a number of records, got {short(chunk)}")
        if self.into is not None and not callable(self.into):
            try:
                array_files.require_name("into", self.into)
            except TypeError:
                raise ValueError(
                    "into must be a function of (first, found), or the path of a file, "
                    f"got {short(self.into)}"
                ) from None

    def size(self, records: Records, numbers: int) -> int:
        """Records of a part, where a row takes so many numbers."""
        total = len(records)
        if self.chunk is not None:
            return -(-self.chunk // BLOCK) * BLOCK
        if self.executor is None and self.into is None:
            return max(total, 1)
        fit = NUMBERS // max(numbers * records.rows * BLOCK, 1)
        workers = getattr(self.executor, "_max_workers", None)
        blocks = -(-total // (BLOCK * (EACH * workers if workers else TASKS)))
        return max(min(blocks, fit), 1) * BLOCK

    @property
    def shares(self) -> bool:
        """Whether tasks write to the memory of this process."""
        here = self.executor is None or isinstance(self.executor, ThreadPoolExecutor)
        return here and self.into is None


def run(
    task: Task,
    records: Records,
    where: Where,
    kind: Callable[..., Any],
    columns: Mapping[str, list[str]],
    numbers: int,
) -> Any:
    """What `task` finds in records: as a `kind`, or None where it went elsewhere.

    ``columns`` are the names of the columns of each array in a table, and `numbers`
    how many numbers there are in a row of a record with its results.
    """
    ahead = 2 * getattr(where.executor, "_max_workers", AHEAD // 2)
    size = where.size(records, numbers)
    into, total = where.into, len(records)
    whole = None
    if where.shares:
        whole = task.room(total, records.rows, records.complete)
    found = in_order(_do, _jobs(task, records, size, whole), where.executor, ahead)
    with ExitStack() as stack:
        stack.enter_context(closing(found))
        if whole is not None:
            deque(found, maxlen=0)
            return kind(**whole)
        if into is None:
            return kind(**_together(found, total))
        if callable(into):
            put = partial(_handed, into, kind)
        elif str(into).endswith(".npz"):
            put = stack.enter_context(array_files.npz(into, total))
        else:
            put = stack.enter_context(array_files.parquet(into, columns))
        for first, arrays in found:
            put(first, arrays)
    return None


def _jobs(
    task: Task, records: Records, size: int, whole: Arrays | None
) -> Iterator[tuple]:
    """Parts of the records, each with its part of `whole`, if that is there."""
    for begin, end in parts(len(records), size):
        some = whole and {name: X[begin:end] for name, X in whole.items()}
        yield task, begin, *records.block(begin, end), some


def _do(job: tuple[Task, int, Matrix, Matrix, Arrays | None]) -> tuple[int, Arrays]:
    """One part, perhaps in another process."""
    task, first, y, u, out = job
    stays = out is not None
    out = out if stays else task.room(*y.shape[:2])
    try:
        task(first, y, u, out)
    except DesignError as error:
        if str(error).startswith("record "):  # and not of the plant
            raise DesignError(f"{error} ({ALONE})") from error
        raise
    return first, out if stays else task.leaves(out)


def _handed(
    into: Callable, kind: Callable[..., Any], first: int, found: Arrays
) -> None:
    into(first, kind(**found))


def _together(found: Iterator[tuple[int, Arrays]], total: int) -> Arrays:
    """All parts as one; of a single one, itself."""
    out: dict[str, np.ndarray] = {}
    for first, arrays in found:
        for name, X in arrays.items():
            if len(X) == total:
                out[name] = X
                continue
            if name not in out:
                out[name] = np.empty((total, *X.shape[1:]))
            out[name][first : first + len(X)] = X
    return out
