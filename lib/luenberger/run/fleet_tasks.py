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
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import DesignError, short
from ..formats import array_files
from ..numeric import Matrix
from .executor import in_order
from .fleet_records import ALONE, Records, parts, require

BLOCK = 64  # records that run side by side
TASKS = 64  # parts that a cluster is given, unless the caller says how many records
EACH = 4  # parts for each worker, where their number is known: some take longer
NUMBERS = 4_000_000  # of a part at most, as far as blocks allow
NEAR = 1_000_000  # of a part that a function reads at once, near the processor
AHEAD = 64  # parts that a cluster has at a time
Arrays = Mapping[str, np.ndarray]
Into = str | Path | Callable[[int, Any], object]


class Task(Protocol):
    """What is done with some records; it can be pickled."""

    def room(self, M: int, N: int, complete: bool = False) -> Arrays:
        """Arrays for what is found in M records of N rows, nothing missing or not."""

    def __call__(
        self, first: int, y: Matrix, u: Matrix, out: Arrays, complete: bool
    ) -> None:
        """Write to `out` what is found in records, which are numbered from `first`.

        If they are `complete`, nothing is missing; else something may be.
        """

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
    reuse : bool
        Whether a function gets the same arrays for one part after the other.
    """

    executor: Any = None
    chunk: Any = None
    into: Any = None
    reuse: bool = False

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
        if not isinstance(self.reuse, bool):
            raise ValueError(f"reuse must be True or False, got {short(self.reuse)}")
        if self.reuse and not (callable(self.into) and self.here):
            raise ValueError(
                "reuse=True is for into=FUNCTION, which gets the same arrays for one "
                "part after the other, and for parts that are filtered here or on an "
                "executor of threads"
            )

    def size(self, records: Records, numbers: int) -> int:
        """Records of a part, where a row takes so many numbers."""
        total = len(records)
        if self.chunk is not None:
            return -(-self.chunk // BLOCK) * BLOCK
        if self.executor is None and self.into is None:
            return max(total, 1)
        most = NEAR if callable(self.into) and self.here else NUMBERS
        fit = most // max(numbers * records.rows * BLOCK, 1)
        if self.executor is None:
            return max(fit, 1) * BLOCK
        workers = getattr(self.executor, "_max_workers", None)
        blocks = -(-total // (BLOCK * (EACH * workers if workers else TASKS)))
        return max(min(blocks, fit), 1) * BLOCK

    @property
    def here(self) -> bool:
        """Whether tasks write to the memory of this process."""
        return self.executor is None or isinstance(self.executor, ThreadPoolExecutor)

    @property
    def ahead(self) -> int:
        """How many parts wait to be done, or for those before them, at most."""
        if self.executor is None:
            return 0
        return 2 * int(getattr(self.executor, "_max_workers", AHEAD // 2))


class _Job(NamedTuple):
    """One part: records y with inputs u, the first of them numbered `first`.

    They are looked at, unless all are `known` to be numbers; `missing` tells whether
    some may be missing.  What is found goes to `out`, or to arrays of its own.
    `leaves` tells whether these leave the process, or the library.
    """

    task: Task
    first: int
    y: np.ndarray
    u: np.ndarray
    known: bool
    missing: bool
    out: Arrays | None
    leaves: bool


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
    size = where.size(records, numbers)
    into, total = where.into, len(records)
    whole, room, known = None, None, False
    if where.here and into is None:
        known = records.complete
        whole = task.room(total, records.rows, known)
        room = partial(_part, whole)
    elif where.reuse:
        room = _again(task, size, records.rows, where.ahead + 1)
    leaves = not (where.here and (into is None or callable(into)))
    jobs = _jobs(task, records, size, room, known, leaves)
    found = in_order(_do, jobs, where.executor, where.ahead)
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


Room = Callable[[int, int], Arrays]  # for the records begin to end, asked in order


def _part(whole: Arrays, begin: int, end: int) -> Arrays:
    return {name: X[begin:end] for name, X in whole.items()}


def _again(task: Task, size: int, rows: int, count: int) -> Room:
    """Room for `count` parts at a time, one after the other, and then again."""
    rooms: list[Arrays] = []

    def room(begin: int, end: int) -> Arrays:
        k = begin // size
        if k < count:
            rooms.append(task.room(end - begin, rows))
        return _part(rooms[k % count], 0, end - begin)

    return room


def _jobs(
    task: Task, records: Records, size: int, room: Room | None, known: bool,
    leaves: bool,
) -> Iterator[_Job]:  # fmt: skip
    """Parts of the records, each with its room, if that is there."""
    for begin, end in parts(len(records), size):
        y, u = records.part(begin, end)
        out = room and room(begin, end)
        yield _Job(task, begin, y, u, known, records.missing, out, leaves)


def _do(job: _Job) -> tuple[int, Arrays]:
    """One part, perhaps in another process."""
    task, first, y, u, known, missing, out, leaves = job
    complete = known or require(y, u, first, missing)
    if out is None:
        out = task.room(*y.shape[:2])
    try:
        task(first, y, u, out, complete)
    except DesignError as error:
        if str(error).startswith("record "):  # and not of the plant
            raise DesignError(f"{error} ({ALONE})") from error
        raise
    return first, task.leaves(out) if leaves else out


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
