"""The way back over a record that was filtered: what later rows say of each row.

A vector and a matrix go from row to row (Bryson and Frazier), as long as what they are
subtracted from keeps its digits; from there on, and where outputs share noises, each
row has its share of the next state, in factors (Rauch, Tung and Striebel).

Source: smoothing/derivation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix, Vector
from ..numeric.linalg import solve_right
from . import passes, unknown
from .maps import Settings
from .pack import Passage, fed, loops, sets_of, text
from .passes import Maps, State, Tape
from .unknown import LARGE


class Passed(NamedTuple):
    """A record that was filtered, windows of rows joined.

    Attributes
    ----------
    settings : Settings
        Those of its first rows.
    at, drive, maps, tape
        As in `pack.Packed` and `passes.Tape`.
    variances : (N, n) ndarray
    """

    settings: Settings
    at: np.ndarray
    drive: np.ndarray
    maps: Maps
    tape: Tape
    variances: np.ndarray

    @classmethod
    def of(cls, windows: list[Passage], settings: Settings) -> Passed:
        """The windows of one record, the first of which has these settings."""
        if len(windows) == 1:
            (one,) = windows
            pack = one.packed
            given = pack.at, pack.drive, pack.maps, one.tape, one.variances
            return cls(settings, *given)
        sizes = np.cumsum([0, *(len(one.packed.maps.C) for one in windows[:-1])])
        shifted = [one.packed.at + k for one, k in zip(windows, sizes)]
        shifted[0][0] = windows[0].packed.at[0]  # perhaps -1
        joins = [one[:-1] for one in shifted[:-1]]  # the next one has that row too
        at = np.concatenate([*joins, shifted[-1]])
        drive, variances = (
            np.concatenate([getattr(part, k) for part in parts])
            for k, parts in (
                ("drive", [one.packed for one in windows]),
                ("variances", windows),
            )
        )
        tapes = [one.tape for one in windows]
        if not all(len(one.D) == len(one.z) for one in tapes):
            tapes = [in_full(one) for one in tapes]
        tape = Tape(*map(np.concatenate, zip(*tapes)))
        wide = max(one.packed.maps.G.shape[2] for one in windows)
        parts = (_as_wide(one.packed.maps, wide) for one in windows)
        maps = Maps(*map(np.concatenate, zip(*parts)))
        return cls(settings, at, drive, maps, tape, variances)

    def rows(self, first: int, end: int) -> Passed:
        """Some of its rows, copied, so that they can be overwritten."""
        part = slice(first, end)
        tape = Tape(*(X[part].copy() for X in self.tape))
        at = self.at[first : end + 1]
        return self._replace(
            at=at, drive=self.drive[part], tape=tape, variances=self.variances[part]
        )

    def copied(self) -> Passed:
        """The same; the way back over it leaves this one as it is."""
        return self.rows(0, len(self.tape.z))


class Back(NamedTuple):
    """Rows that are smoothed.

    Attributes
    ----------
    z : (N, n + q) ndarray
        The states and the noises beside them.
    variances : (N, n) ndarray
    P : (N, n, n) ndarray
        No rows where it was not wanted.
    w : (N, n) ndarray
        The process noise that leads from each row to the next one.
    """

    z: np.ndarray
    variances: np.ndarray
    P: np.ndarray
    w: np.ndarray


def _as_wide(maps: Maps, wide: int) -> Maps:
    """The same with zeros beside G."""
    more = wide - maps.G.shape[2]
    return maps._replace(G=np.pad(maps.G, ((0, 0), (0, 0), (0, more))))


def in_full(tape: Tape) -> Tape:
    """The same with covariances in place of their factors."""
    if len(tape.D) < len(tape.z):
        return tape
    return tape._replace(V=spread(tape.V, tape.D), D=tape.D[:0])


def smoothed(passed: Passed, lag: int | None, whole: bool) -> Back:
    """All rows, with all later rows or as many as the lag; P where `whole`."""
    rows = len(passed.tape.z)
    if lag is None or lag >= rows - 1:
        return _way_back(passed, whole)
    ends = (min(k + lag + 1, rows) for k in range(rows))
    found = (_way_back(passed.rows(k, end), whole) for k, end in enumerate(ends))
    return Back(*(np.concatenate([X[:1] for X in part]) for part in zip(*found)))


def _way_back(passed: Passed, whole: bool) -> Back:
    """What is found of the tape's rows, which it overwrites."""
    settings, at, drive, maps, tape, variances = passed
    rows, n = len(tape.z), maps.B.shape[1]
    z, P = tape.z, np.empty((rows * whole, n, n))
    w = tape.D if tape.D.shape == (rows, n) else np.empty((rows, n))
    first = rows  # of those that are smoothed by innovations
    opened = _open(tape)
    if settings.way == "nothing" and not opened:
        before = np.zeros((2, 2, n, n))
        run = loops("backward", n) if whole else text("backward", settings, maps, rows)
        first = 1 + int(run(at, maps, tape, z, variances, P, w, before))
        if not first:
            return Back(z, variances, P, w)
        tape = _factors(tape, first, *before[first % 2])
        ahead = np.einsum(
            "tab,tb->ta", maps.M[at[1 : len(tape.z)]], z[: len(tape.z) - 1]
        )
        tape = tape._replace(
            ahead=np.concatenate([z[:1], ahead + drive[1 : len(tape.z)]])
        )
    at = at[: len(tape.z) + 1]
    _through_next(at, maps, tape, np.empty((0, n, n)))
    V, D = tape.V[:first, :, :n], tape.D[:first]
    variances[:first] = np.einsum("tka,tk,tka->ta", V, D, V)
    if whole:
        P[:first] = spread(V, D)
    w[:first] = _residual(maps, at, drive, tape.z)[:first]
    if opened:
        variances[variances > LARGE] = np.inf
        P[np.abs(P) > LARGE] *= np.inf
    return Back(z, variances, P, w)


def _open(tape: Tape) -> int:
    """How many rows there are up to the last at which something is not known at all."""
    rows = np.flatnonzero((tape.D > LARGE).any(axis=1))
    return int(rows[-1]) + 1 if len(rows) else 0


def _through_next(at: Vector, maps: Maps, tape: Tape, found: Matrix) -> None:
    """`passes.rts`, by leading terms where something is not known at all."""
    opened = _open(tape)
    part = Tape(*(X[opened:] for X in tape))
    passes.rts(at[opened:], maps, part, found[opened:])
    if opened:
        part = Tape(*(X[: opened + 1] for X in tape))
        unknown.rts(at[: opened + 2], maps, part, found[: opened + 1])


def _factors(tape: Tape, first: int, A: Matrix, S: Matrix) -> Tape:
    """The rows before `first`, and that as it is smoothed by A, in factors."""
    tape = Tape(*(X[: first + 1] for X in tape))
    if len(tape.D):
        known, P = first, S[None][: len(tape.z) - first]
        V, D = tape.V, tape.D.copy()  # it has what was found of noises since
    else:
        known, P, D = 0, tape.V, np.empty(tape.z.shape)
        V = np.empty(P.shape)
    P[first - known :] -= P[first - known :] @ A @ P[first - known :]
    passes.factored(P, V[known:], D[known:])
    return tape._replace(V=V, D=D)


def spread(V: Matrix, D: Matrix) -> Matrix:
    """The covariances of factors."""
    return np.swapaxes(V, 1, 2) @ (D[:, :, None] * V)


def _residual(maps: Maps, at: Vector, drive: Matrix, z: Matrix) -> Matrix:
    """What the noises beside a state, and the next state, show of the process noise."""
    n, rows = maps.B.shape[1], len(z)
    M = maps.M[at[1:]]
    w = np.einsum("tab,tb->ta", M[:, :, n:], z[:, n:])
    if maps.G.shape[2]:
        w[:-1] += z[1:, :n] - np.einsum("tab,tb->ta", M[:-1], z[:-1]) - drive[1:rows]
    return w


def gains(passed: Passed, start: State) -> Matrix:
    """What there is in the error of each row before of the next state's, (N, n, n).

    The first row is that of `start`, unless it is the prior of the first sample.
    """
    at, maps, tape = passed.at, passed.maps, passed.tape
    n = maps.B.shape[1]
    if len(at) > 1 and at[0] >= 0:
        first = dict(z=start.z, V=start.V, D=start.D, ahead=tape.ahead[0])  # z is any
        more = {
            k: np.concatenate([X[None], getattr(tape, k)]) for k, X in first.items()
        }
        at, tape = np.concatenate([at[:1], at]), tape._replace(**more)
    found = np.empty((len(tape.z), n, n))
    _through_next(at, maps, tape, found)
    return found


class Told(NamedTuple):
    """Rows of one window, and what is known of their plant.

    Attributes
    ----------
    settings : Settings
    first : int
        The instant of the first row.
    y, u : (N, p), (N, m) ndarray
    """

    settings: Settings
    first: int
    y: np.ndarray
    u: np.ndarray

    def each(self, name: str) -> Matrix:
        """A matrix of the plant at each row, a stack of it or one for all."""
        X: Matrix = getattr(self.settings.plant, name)
        if X.ndim == 2:
            return X
        rows = np.arange(len(self.y)) + self.first - self.settings.origin
        return X[np.clip(rows, 0, len(X) - 1)]

    def alike(self) -> list[Vector]:
        """Rows at which the same outputs arrived; of a plant that changes, each row."""
        rows = np.arange(len(self.y))
        if self.settings.plant.steps is not None:
            return list(rows[:, None])
        sets, at = sets_of(~np.isnan(self.y))
        return [rows[at == k] for k in range(len(sets))]

    def left(self, x: Matrix) -> Matrix:
        """What estimates leave of the measurements; zero where none arrived."""
        C = self.each("C")
        v = self.y - (x @ C.T if C.ndim == 2 else np.einsum("tij,tj->ti", C, x))
        if self.u.shape[1]:
            v -= fed(self.settings.plant, self.first - 1, self.u)
        return np.where(np.isnan(v), 0.0, v)

    def noises(self, z: Matrix) -> Matrix:
        """The measurement noise of all outputs, as far as those that arrived tell."""
        n, p = self.settings.plant.n, self.settings.plant.p
        v = self.left(z[:, :n])
        for rows in self.alike():
            seen = ~np.isnan(self.y[rows[0]])
            if seen.all():
                continue
            if self.settings.way == "nothing":
                R = self.settings.now(self.first + rows[0]).R
                J = solve_right(R[np.ix_(~seen, seen)], R[np.ix_(seen, seen)])
                v[np.ix_(rows, ~seen)] = v[np.ix_(rows, seen)] @ J.T
            else:
                every = self.settings.at(self.first + rows[0], np.ones(p, dtype=bool))
                v[np.ix_(rows, ~seen)] = z[rows, n:] @ every[0].C[~seen, n:].T
        return v

    def pushes(self) -> Matrix:
        """How the accurate outputs of each row push its estimate, (N, n, p)."""
        plant = self.settings.plant
        found = np.zeros((len(self.y), plant.n, plant.p))
        for rows in self.alike():
            found[rows] = self.settings.push(
                self.first + rows[0], ~np.isnan(self.y[rows[0]])
            )
        return found
