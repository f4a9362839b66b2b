"""Many records of one plant: read, put together as they can be filtered, and told."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..filtering import many
from ..filtering.many import of_record
from ..filtering.pack import End, begin
from ..formats import dataframes
from ..numeric import Matrix, Vector
from ..plant import Plant
from . import checked
from .record import Record, Rows


class Group(NamedTuple):
    """Records that are filtered together.

    Attributes
    ----------
    names : (M,) ndarray of int
        Their numbers among all records.
    rows : Rows
        With y (M, N, p), u (M, N, m) or (1, N, m), which is that of each, and a
        sequence of clocks.
    starts : sequence of End, or None
        What they go on from; all are of one instant.
    whole : bool
        Whether nothing is missing, and all begin with the same covariance.
    """

    names: np.ndarray
    rows: Rows
    starts: Sequence[End] | None
    whole: bool


class Gathered(Sequence[Any]):
    """The items of groups, by the numbers of their records."""

    def __init__(self, names: Sequence[Vector], parts: Sequence[Sequence[Any]]) -> None:
        self.parts = parts
        count = sum(map(len, names))
        self.part, self.place = np.empty((2, count), dtype=np.int64)
        for k, which in enumerate(names):
            self.part[which], self.place[which] = k, np.arange(len(which))

    def __len__(self) -> int:
        return len(self.part)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[i] for i in range(len(self))[k]]
        return self.parts[self.part[k]][int(self.place[k])]


def found(of: Any, record: Record, starts: Any) -> tuple[Any, ...]:
    """Estimates, deviations, ends, no settled rows, what finds P and K, and names.

    `of` is the `Filter`.
    """
    all_ = groups(of.plant, record, starts)
    parts: list[Any] = [_together(of, one) for one in all_]
    names = [one.names for one in all_]
    told = (_told(record, of.plant, names, [part[k] for part in parts]) for k in (0, 1))
    ends = Gathered(names, [part[2] for part in parts])
    again = partial(_matrices, of, record, starts)
    return *told, ends, np.zeros(0, dtype=np.int64), again, of.plant.state_names


def _together(of: Any, group: Group) -> tuple[Matrix, Matrix, Sequence[End]]:
    """Estimates, deviations and ends of records that are filtered together."""
    names, rows, ends, whole = group
    M, first = len(names), rows._replace(y=rows.y[0])
    if of.plant.P0 is None:  # each record tells of its own start
        u = np.broadcast_to(rows.u, (M, *rows.u.shape[1:]))
        each = [
            of.over(rows._replace(y=rows.y[k], u=u[k]), ends and ends[k])
            for k in range(M)
        ]
        x, std = (np.stack([getattr(one, k) for one in each]) for k in ("x", "std"))
        return x, std, many.clocked([one.end for one in each], rows.clock)
    run = many.alike if whole else many.with_gaps
    xs, variances = [], []
    for part, settings in of.parts(first, 0 if ends is None else ends[0].instant):
        if ends is None:
            ends = many.begun(begin(settings, rows.u0), M)
        x, v, ends = run(settings, ends, rows.y[:, part], rows.u[:, part], names)
        xs.append(x)
        variances.append(v)
    assert ends is not None
    x, v = (X[0] if len(X) == 1 else np.concatenate(X, 1) for X in (xs, variances))
    std = np.sqrt(v, out=v)
    std = np.broadcast_to(std, x.shape) if len(std) < M else std
    return x, std, many.clocked(ends, rows.clock)


def _matrices(of: Any, record: Record, starts: Any) -> tuple[Any, Any]:
    """Covariances and gains of each record; those of `whole` ones are found once."""
    every: list[Any] = [None] * len(record)
    for names, rows, ends, whole in groups(of.plant, record, starts):
        for k, name in enumerate(names):
            if whole and k:
                every[name] = every[names[0]]
                continue
            u = rows.u[k if len(rows.u) > 1 else 0]
            one = rows._replace(y=rows.y[k], u=u, clock=rows.clock[k])
            every[name] = of.matrices(one, None if ends is None else ends[k])
    P, K = ([pair[k] for pair in every] for k in (0, 1))
    same = len({X.shape for X in P}) == 1
    return (np.stack(P), np.stack(K)) if same else (P, K)


def _told(
    record: Record, plant: Plant, names: list[Vector], parts: list[Matrix]
) -> Any:
    """What was found of each record: an array (M, N, n), or a list."""
    found: Any = Gathered(names, list[Any](parts))
    if len({len(record), *map(len, parts)}) == 1:
        found = parts[0]
    elif len({X.shape[1:] for X in parts}) == 1:
        found = np.empty((len(record), *parts[0].shape[1:]))
        for which, X in zip(names, parts):
            found[which] = X
    ours = isinstance(record.y, list | tuple)
    if not ours or not any(map(dataframes.is_table, record.y)):
        return found if isinstance(found, np.ndarray) else [*found]
    return [
        dataframes.framed(X, plant.state_names, one.index)
        for X, one in zip(found, record.each())
    ]


def groups(plant: Plant, record: Record, starts: Any) -> list[Group]:
    """The records of one `Record`, as they are filtered together.

    Which group a record comes to does not change what is found of it.
    """
    if starts is not None and (isinstance(starts, End) or len(starts) != len(record)):
        raise ValueError(
            f"there are {len(record)} records, so start must be as many: the `end` of "
            "what was found in their earlier rows"
        )
    if not len(record):
        raise ValueError("y holds no record")
    if record.arrival is not None:
        raise ValueError(
            "arrival is for one record, and y holds many: filter the records that "
            "have late readings one by one"
        )
    found = []
    for names, rows in _stacks(plant, record, starts):
        whole = np.isfinite(rows.y).reshape(len(names), -1).all(axis=1)
        if not whole.all():
            _finite("y", np.isinf(rows.y), "infinite")
        kinds = dict[Any, list[int]]()  # of what those have in common
        for k, complete in enumerate(whole.tolist()):
            begun = () if starts is None else _begun(starts[names[k]], complete)
            kinds.setdefault((complete, *begun), []).append(k)
        for (complete, *_), some in kinds.items():
            which, part = names, rows
            if len(some) < len(names):
                u = rows.u[some] if len(rows.u) == len(names) else rows.u
                clocks = [rows.clock[k] for k in some]
                which = names[some]
                part = rows._replace(y=rows.y[some], u=u, clock=clocks)
            ends = None if starts is None else [starts[k] for k in which]
            found.append(Group(which, part, ends, complete))
    return found


def _begun(end: End, complete: bool) -> tuple[Any, ...]:
    """What those that are filtered together begin with."""
    parts = (*end.state[1:], end.seen, *end.gap, *(() if end.P is None else (end.P,)))
    own = [np.asarray(X).tobytes() for X in parts] if complete else []
    return end.instant, end.P is None, *own


def _stacks(plant: Plant, record: Record, starts: Any) -> Iterator[tuple[Vector, Rows]]:
    """Records of one length and with one clock, and their numbers."""
    if not isinstance(record.y, list | tuple):
        y, u = stack_of(record, plant.p, plant.m)
        one = Record(np.zeros(y.shape[1:]), None, record.time, None, record.u0)
        rows = one.on(plant, None if starts is None else starts[0])
        yield np.arange(len(y)), rows._replace(y=y, u=u, clock=[rows.clock] * len(y))
        return
    kinds = dict[Any, list[tuple[int, Rows]]]()
    for k, one in enumerate(record.each()):
        with of_record(k):
            rows = one.on(plant, None if starts is None else starts[k])
        clock = None if rows.periods is None else rows.periods.tobytes()
        kinds.setdefault((len(rows.y), clock), []).append((k, rows))
    for some in kinds.values():
        names, all_ = zip(*some)
        y, u = (np.stack([getattr(rows, X) for rows in all_]) for X in "yu")
        clocks = [rows.clock for rows in all_]
        yield np.array(names), all_[0]._replace(y=y, u=u, clock=clocks)


def stack_of(record: Record, p: int, m: int) -> tuple[Matrix, Matrix]:
    """y (M, N, p), and u (M, N, m) or, that of all records, (1, N, m)."""
    y = checked.real("y", record.y, "an array of numbers")
    M, N, width = y.shape
    if width != p:
        raise ValueError(
            f"y must be (N, {p}), or (M, N, {p}) for many records, got {y.shape}"
        )
    if record.u is None or (np.ndim(record.u) == 0 and record.u == 0):
        return y, np.zeros((1, N, m))
    u = checked.real("u", record.u, "an array of numbers")
    if u.shape not in ((M, N, m), (N, m)):
        raise ValueError(
            f"u must be ({M}, {N}, {m}), or ({N}, {m}) for all records, got {u.shape}"
        )
    u = u if u.ndim == 3 else u[None]
    _finite("u", ~np.isfinite(u), "missing or not finite")
    return y, u


def _finite(name: str, bad: Matrix, what: str) -> None:
    """ValueError naming the record and the row of what is bad."""
    for k, row, _ in np.argwhere(bad)[:1] if bad.any() else ():
        raise ValueError(f"{name} is {what} in record {k}, row {row}")
