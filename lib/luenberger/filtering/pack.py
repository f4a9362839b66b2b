"""A record in the terms of `passes`: readings with noises of their own, a map a row."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.factors import factor
from ..plant import Plant
from ..recursion.settings import require_start
from . import passes, scalars
from .maps import Settings
from .passes import Maps, State, Tape, gram

FEW = 6  # states at most whose rows are done in scalars
MANY = 20_000  # rows that are worth a compilation


class End(NamedTuple):
    """A filter behind a row of a record: all that the rows to come depend on.

    Attributes
    ----------
    instant : int
        That of the row; 0 before the first.
    state : State
    seen : (p,) ndarray of bool
        Which outputs arrived.
    u : (m,) ndarray
        The input, which acts until the next row.
    """

    instant: int
    state: State
    seen: np.ndarray
    u: np.ndarray


class Packed(NamedTuple):
    """Rows as `passes.forward` takes them.

    Attributes
    ----------
    y : (N, p) ndarray
        Readings less E u, combined where the noises of outputs are correlated.
    drive : (N, n) ndarray
        B u of the row before.
    at : (N + 1,) ndarray of int
        The maps of the row before the first one, or -1, and of each row.
    maps : Maps
    mix : (k, p, p) ndarray
        What combines the readings of each map.
    """

    y: np.ndarray
    drive: np.ndarray
    at: np.ndarray
    maps: Maps
    mix: np.ndarray


class Passage(NamedTuple):
    """What a pass found: estimates and variances (N, n), the tape, where it ended."""

    x: np.ndarray
    variances: np.ndarray
    tape: Tape
    packed: Packed
    end: End


def begin(settings: Settings, u0: Vector) -> End:
    """The filter before the first row of a record."""
    plant = settings.plant
    P0 = require_start(plant)
    n, p = plant.n, plant.p
    N = settings.at(0, np.zeros(p, dtype=bool))[0].B.shape[1]
    H = factor(P0)
    H = np.hstack([H, np.zeros((n, 1))]) if not H.shape[1] else H
    z, V, D = np.zeros(N), np.eye(N), np.ones(N)
    z[:n] = plant.x0
    U, d = np.zeros((n, n)), np.zeros(n)
    ones = np.ones(H.shape[1])
    gram(H, ones, P0.diagonal().copy(), U, d, np.zeros((0, n)), ones.copy())
    V[:n, :n], D[:n] = U, d
    state = State(z, V, D, np.zeros((p, N)), np.zeros(p))
    return End(0, state, np.zeros(p, dtype=bool), u0)


def packed(settings: Settings, end: End, y: Matrix, u: Matrix) -> Packed:
    """The rows of y and u behind `end`."""
    plant, rows = settings.plant, len(y)
    seen = ~np.isnan(y)
    y = y if not plant.m else y - fed(plant, end.instant, u)
    before = np.concatenate([end.u[None], u[:-1]]) if rows else u
    prior = end.instant == 0 and plant.P0_is == "prior"
    drive = _driven(plant, settings.origin, end.instant, before)
    if prior and rows:
        drive[0] = 0.0
    if plant.steps is None:
        found, at, y = _alike(settings, end, y, seen)
    else:
        found, at, y = _each(settings, end, y, seen)
    if prior:
        at[0] = -1
    maps, mix = settings.stack(tuple(found))
    return Packed(np.ascontiguousarray(y), drive, at, maps, mix)


def fed(plant: Plant, instant: int, u: Matrix) -> Matrix:
    """E u of rows behind an instant."""
    if plant.E.ndim == 2:
        return u @ plant.E.T
    at = np.minimum(instant + 1 + np.arange(len(u)), len(plant.E) - 1)
    return np.einsum("tij,tj->ti", plant.E[at], u)


def _driven(plant: Plant, origin: int, instant: int, u: Matrix) -> Matrix:
    """B u that leads to each row behind an instant, u of the rows before."""
    if plant.B.ndim == 2:
        return u @ plant.B.T
    at = np.clip(instant - origin + np.arange(len(u)), 0, len(plant.B) - 1)
    return np.einsum("tij,tj->ti", plant.B[at], u)


def _alike(
    settings: Settings, end: End, y: Matrix, seen: Matrix
) -> tuple[list[Any], Vector, Matrix]:
    """Of a plant that does not change: one map for all rows with the same outputs."""
    code = np.concatenate([end.seen[None], seen]) @ (1 << np.arange(seen.shape[1]))
    _, first, at = np.unique(code, return_index=True, return_inverse=True)
    found, mixed = [], y
    for k, row in enumerate(first):
        pattern = seen[row - 1] if row else end.seen
        found.append(settings.at(1, pattern))
        L = found[-1][1]
        if np.tril(L, -1).any():
            if pattern.all() and seen.all():
                mixed = y @ L.T
                continue
            mixed = y.copy() if mixed is y else mixed
            rows = at[1:] == k
            values = np.where(pattern, y[rows], 0.0) @ L.T
            mixed[rows] = np.where(pattern, values, np.nan)
    return found, at.astype(np.int64), mixed


def _each(
    settings: Settings, end: End, y: Matrix, seen: Matrix
) -> tuple[list[Any], Vector, Matrix]:
    """Of a plant that changes: a map a row."""
    found, mixed = [settings.at(end.instant, end.seen)], y.copy()
    for k, now in enumerate(seen):
        found.append(settings.at(end.instant + 1 + k, now))
        L = found[-1][1]
        mixed[k] = np.where(now, L @ np.where(now, y[k], 0.0), np.nan)
    return found, np.arange(len(y) + 1), mixed


def over(settings: Settings, end: End, y: Matrix, u: Matrix, keep: str = "") -> Passage:
    """Filter rows; what is kept of each is "" (no tape), "readings" or "all"."""
    plant, rows = settings.plant, len(y)
    n, p = plant.n, plant.p
    pack = packed(settings, end, y, u)
    state = State(*(X.copy() for X in end.state))
    N = len(state.z)
    some, all_ = rows * (keep != ""), rows * (keep == "all")
    tape = Tape(
        np.empty((all_, n)), np.empty((all_, N)), np.empty((all_, N, N)),
        np.empty((all_, N)), np.empty((some, p, N)), np.empty((some, p)),
        np.empty((some, p)),
    )  # fmt: skip
    x, variances = np.empty((rows, n)), np.empty((rows, n))
    run = text(settings, pack.maps, rows)
    clash = run(*pack[:-1], state, x, variances, tape)
    if clash >= 0:
        row, j = divmod(int(clash), p)
        _refuse(settings, end.instant + 1 + row, j, ~np.isnan(y[row]))
    last = ~np.isnan(y[-1]) if rows else end.seen
    after = End(end.instant + rows, state, last, u[-1] if rows else end.u)
    return Passage(x, variances, tape, pack, after)


def text(settings: Settings, maps: Maps, rows: int) -> Any:
    """The text that goes over so many rows; for few states all find the same bits."""
    if settings.plant.n > FEW:
        return passes.forward.fast
    if settings.way == "nothing" and (rows >= MANY or scalars.known(maps)):
        return scalars.forward(maps)
    return passes.forward.exact


def _refuse(settings: Settings, instant: int, j: int, seen: Vector) -> None:
    names = settings.plant.output_names
    which = [names[k] for k in range(j + 1) if seen[k]]
    raise DesignError(
        f"at instant {instant} the reading of {names[j]!r} contradicts what is known "
        f"exactly there, by the noise-free outputs {which} or by earlier ones. Give "
        "them noise in R, or raise Q or P0."
    )
