"""Many records of one plant: side by side where that is faster, else in turn.

What is found of a record hangs on it alone, to the last bit, and not on the records
beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..numeric import Matrix, Vector
from . import digits, lanes
from .compiling import installed
from .maps import Settings
from .pack import (
    FEW,
    MANY,
    End,
    Packed,
    Passage,
    combined,
    driven,
    fed,
    gains,
    less,
    over,
    packed,
)
from .passes import State
from .scalars import sizes

OUTPUTS = 4  # at most, of which all sets are told apart in lanes
AS_IS = np.zeros((0, 0, 0, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0, 0, 0))
BLOCK = 64  # records in a product, always: products of one size have the same bits
Found = tuple[np.ndarray, np.ndarray, Sequence[End]]  # estimates, variances, ends


@dataclass(frozen=True, eq=False)
class Ends(Sequence[End]):
    """The filters of records behind one instant; what is None is that of `like`."""

    like: End
    z: np.ndarray
    V: np.ndarray | None = None
    D: np.ndarray | None = None
    seen: np.ndarray | None = None
    u: np.ndarray | None = None  # (1, m) if it is the same for all
    begun: np.ndarray | None = None
    least: np.ndarray | None = None
    clocks: Sequence[Any] | None = None

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[i] for i in range(len(self))[k]]
        own = {name: getattr(self, name) for name in ("z", "V", "D")}
        state = {name: X[k] for name, X in own.items() if X is not None}
        more = {} if self.seen is None else {"seen": self.seen[k]}
        if self.u is not None:
            more["u"] = self.u[k if len(self.u) > 1 else 0]
        if self.begun is not None and self.least is not None:
            more["gap"] = digits.Gap(int(self.begun[k]), self.least[k])
        if self.clocks is not None:
            more["clock"] = self.clocks[k]
        return self.like._replace(state=self.like.state._replace(**state), **more)


def begun(end: End, M: int) -> Ends:
    """So many records that begin with the same."""
    return Ends(end, np.broadcast_to(end.state.z, (M, len(end.state.z))))


def clocked(ends: Sequence[End], clocks: Sequence[Any]) -> Sequence[End]:
    """The same, each with its clock."""
    if isinstance(ends, Ends):
        return replace(ends, clocks=clocks)
    return [end._replace(clock=clock) for end, clock in zip(ends, clocks)]


def stacked(ends: Sequence[End]) -> Ends:
    """The same with a stack of each part."""
    if not isinstance(ends, Ends):
        own = [(*end.state[:3], end.seen, end.u, *end.gap) for end in ends]
        parts: Any = [np.array(X) for X in zip(*own)]
        return Ends(ends[0], *parts)
    like = ends.like
    held: dict[str, Any] = dict(
        V=like.state.V, D=like.state.D, begun=like.gap[0], least=like.gap[1]
    )
    held = {name: X for name, X in held.items() if getattr(ends, name) is None}
    for name, X in held.items():
        held[name] = np.repeat(np.array(X)[None], len(ends), 0)
    return replace(ends, u=like.u[None] if ends.u is None else ends.u, **held)


def alike(
    settings: Settings, ends: Sequence[End], y: Matrix, u: Matrix, names: Vector
) -> Found:
    """Filter records y (M, N, p) in which nothing is missing.

    They begin with the same covariance, so the gains of the first are those of all;
    variances are (1, N, n).  u (1 or M, N, m) may be the same for all.
    """
    M, rows, few = len(y), y.shape[1], settings.plant.n <= FEW
    with of_record(names[0]):
        one = over(settings, ends[0], y[0], u[0], "readings")
    pack, tape = one.packed, one.tape
    few &= settings.way == "nothing"
    if not (tape.pivot > 0).all() or (few and not _fast(M * rows)):
        x, _, after = each(settings, ends, y, u, names)
        return x, one.variances[None], after
    begin = stacked(ends)
    y, drive = _beside(settings, begin, y, u)
    y = combined(pack.mix[pack.at[1:]], y)
    z, x = np.array(begin.z), np.empty((M, rows, settings.plant.n))
    if few:
        state, none = _state(z), np.zeros((0, 0, 0))
        run = lanes.over(sizes(pack.maps), True)
        run(
            y, drive, pack.at, pack.maps, AS_IS, state, x, none, tape.K, tape.pivot,
            np.zeros(0, dtype=np.int64),
        )  # fmt: skip
    else:
        K = gains(one)
        for k in range(0, M, BLOCK):
            some = slice(k, k + BLOCK)
            acts = drive if len(drive) == 1 else drive[some]
            _products(one, K, y[some], acts, z[some], x[some])
    return x, one.variances[None], Ends(one.end, z, u=u[:, -1] if rows else begin.u)


def _products(
    one: Passage, K: Matrix, y: Matrix, drive: Matrix, z: Matrix, x: Matrix
) -> None:
    """Some records, with the gains K of `one`; z becomes what they end with."""
    at, maps = one.packed.at, one.packed.maps
    some, n = len(y), x.shape[2]
    ys, acts, now = (np.zeros((*X.shape[1:], BLOCK)) for X in (y, drive, z))
    for X, own in ((ys, y), (acts, drive), (now, z)):
        X[..., :some] = np.moveaxis(own, 0, -1)
    for t, k in enumerate(at[1:]):
        if at[t] >= 0:
            ahead = maps.M[at[t]] @ now + acts[t]
            now = np.zeros_like(now)
            now[:n] = ahead
        now = now + K[t] @ (ys[t] - maps.C[k] @ now)
        pushed = now[:n] + maps.O[k] @ now[n:] if maps.O.shape[2] else now[:n]
        x[:, t] = pushed[:, :some].T
    z[:] = now[:, :some].T


def with_gaps(
    settings: Settings, ends: Sequence[End], y: Matrix, u: Matrix, names: Vector
) -> Found:
    """Filter records y (M, N, p), each with gaps of its own; see `alike`."""
    plant, (M, rows, p) = settings.plant, y.shape
    like = ends[0]
    pack = packed(settings, like, np.zeros((rows, p)), np.zeros((rows, plant.m)))
    few = settings.way == "nothing" and plant.n <= FEW and p <= OUTPUTS
    if not few or not _fast(M * rows):
        return each(settings, ends, y, u, names)
    begin = stacked(ends)
    seen = ~np.isnan(y[:, -1]) if rows else begin.seen
    mixed = bool(np.tril(pack.mix, -1).any())
    told, maps = AS_IS, pack.maps
    if mixed:
        told = _by_pattern(settings, pack, like.instant, ~np.isnan(y))
        maps = maps._replace(C=told[0].reshape(-1, p, plant.n))
    raw, (y, drive) = y, _beside(settings, begin, y, u)
    state = _state(*(np.array(X) for X in (begin.z, begin.V, begin.D)))
    x, variances = np.empty((2, M, rows, plant.n))  # one piece of memory is quicker
    clash, none = np.full(M, -1), (np.zeros((0, 0, 0)), np.zeros((0, 0)))
    size = sizes(maps)
    size = size._replace(noisy=size.noisy and bool((told[1] > 0).all()))
    run = lanes.over(size, False, mixed)
    run(y, drive, pack.at, maps, told, state, x, variances, *none, clash)
    begun, least = np.array(begin.begun), np.array(begin.least)
    rows_ = np.empty(M, dtype=np.int64)
    always = bool(settings.unseen_growth)
    told = (
        raw,
        always,
        digits.calm(variances, least[begun > 0]),
        variances,
        like.instant + 1,
    )
    digits.some_grown(*told, begun, least, rows_)
    wrong = np.flatnonzero((clash >= 0) | (rows_ >= 0))
    for k in wrong:  # by itself, to be refused; or its states are independent
        with of_record(names[k]):
            one = over(
                settings, begin[k], raw[k], u[k if len(u) > 1 else 0], "readings"
            )
        begun[k], least[k] = one.end.gap
    last = u[:, -1] if rows else begin.u
    end = like._replace(instant=like.instant + rows)
    return x, variances, Ends(end, state.z, state.V, state.D, seen, last, begun, least)


def _by_pattern(
    settings: Settings, pack: Packed, instant: int, seen: Matrix
) -> tuple[Matrix, ...]:
    """C, r and what mixes readings, of each row for each set that arrives."""
    k, p, n = pack.maps.C.shape
    sets = 1 << np.arange(p)[::-1]
    every = settings.plant.steps is None  # few sets, so it is not asked which occur
    codes: Any = range(1 << p) if every else (seen @ sets)[..., None] & -sets
    C, r = np.zeros((k, 1 << p, p, n)), np.ones((k, 1 << p, p))
    mix = np.tile(np.eye(p), (k, 1 << p, 1, 1))
    for i in range(k):
        # of a plant that changes, those that occur, and those up to each output of them
        for code in codes if every else np.unique(codes[:, pack.at[1:] == i]):
            maps, mix[i, code] = settings.at(instant + i, (code & sets) > 0)
            C[i, code], r[i, code] = maps.C, maps.r
    return C, r, mix


def each(
    settings: Settings, ends: Sequence[End], y: Matrix, u: Matrix, names: Vector
) -> Found:
    """Filter records one after the other."""
    found = []
    for k, own in enumerate(y):
        with of_record(names[k]):
            u_k = u[k if len(u) > 1 else 0]
            one = over(settings, ends[k], own, u_k, "readings")  # in full
            found.append((one.x, one.variances, one.end))
    x, variances, after = zip(*found)
    return np.stack(x), np.stack(variances), list(after)


def _beside(
    settings: Settings, begin: Ends, y: Matrix, u: Matrix
) -> tuple[Matrix, Matrix]:
    """y - E u, and B u of the rows before; (1, N, n) if it is the same for all."""
    plant, instant = settings.plant, begin.like.instant
    if not plant.m or not y.shape[1]:
        return np.ascontiguousarray(y), np.zeros((1, y.shape[1], plant.n))
    assert begin.u is not None
    M = max(len(u), len(begin.u))
    first = np.broadcast_to(begin.u[:, None], (M, 1, plant.m))
    before = np.concatenate([first, np.broadcast_to(u, (M, *u.shape[1:]))[:, :-1]], 1)
    drive = driven(plant, settings.origin, instant, before)
    if instant == 0 and plant.at_first:
        drive[:, 0] = 0.0
    return less(y, fed(plant, instant, u)), drive


def _state(z: Matrix, V: Matrix | None = None, D: Matrix | None = None) -> State:
    """Stacks of z, V and D; what is not needed is empty."""
    three, two = np.zeros((0, 0, 0)), np.zeros((0, 0))
    return State(z, three if V is None else V, two if D is None else D, three, two)


def _fast(rows: int) -> bool:
    """Whether so many rows are worth a compilation, where there is a compiler."""
    return installed() and rows >= MANY


@contextmanager
def of_record(name: Any) -> Iterator[None]:
    """Say which record is refused."""
    try:
        yield
    except ValueError as error:
        raise type(error)(f"record {name}: {error}") from error
