"""The way back over a record that was filtered: what later rows say of each row.

Where every reading has noise, a vector and a matrix go from row to row (Bryson and
Frazier); elsewhere each row has its share of the next state, in factors (Rauch, Tung
and Striebel).  One of the two is chosen for a whole record.

Source: smoothing/derivation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix, Vector
from ..numeric.linalg import solve_right
from . import passes
from .maps import Settings
from .pack import Passage, fed
from .passes import Maps, State, Tape

# What part of an innovation's variance a reading's own noise must have.  Problem 104 of
# tests/support/exact_filter.py has 4e-5; P - P Theta P has four digits left there.
NOISY = 1e-4


class Passed(NamedTuple):
    """A record that was filtered, windows of rows joined.

    Attributes
    ----------
    at, drive, maps, tape
        As in `pack.Packed` and `passes.Tape`.
    noisy : bool
        Whether every reading has enough noise for the way back by innovations.
    """

    at: np.ndarray
    drive: np.ndarray
    maps: Maps
    tape: Tape
    noisy: bool

    @classmethod
    def of(cls, windows: list[Passage], way: str) -> Passed:
        """The windows of one record; `way` is that of its settings."""
        first, *more = windows
        at, drive, maps, tape = (
            first.packed.at, first.packed.drive, first.packed.maps, first.tape,
        )  # fmt: skip
        if more:
            sizes = np.cumsum([len(one.packed.maps.C) for one in windows])
            shifted = [at, *(one.packed.at + k for one, k in zip(more, sizes))]
            joins = [one[:-1] for one in shifted[:-1]]  # the next one has that row too
            at = np.concatenate([*joins, shifted[-1]])
            drive = np.concatenate([one.packed.drive for one in windows])
            tape = Tape(*map(np.concatenate, zip(*(one.tape for one in windows))))
            wide = max(one.packed.maps.G.shape[2] for one in windows)
            parts = (_as_wide(one.packed.maps, wide) for one in windows)
            maps = Maps(*map(np.concatenate, zip(*parts)))
        noisy = way == "nothing" and _noisy(maps.r, at, tape.pivot)
        return cls(at, drive, maps, tape, noisy)

    def rows(self, first: int, end: int) -> Passed:
        """Some of its rows; estimates are copied, so that they can be overwritten."""
        part = slice(first, end)
        tape = Tape(*(X[part] for X in self.tape))
        if not self.noisy:
            z, V, D = tape.z.copy(), tape.V.copy(), tape.D.copy()
            tape = tape._replace(z=z, V=V, D=D)
        at = self.at[first : end + 1]
        return self._replace(at=at, drive=self.drive[part], tape=tape)

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


def _noisy(r: Matrix, at: Vector, pivot: Matrix) -> bool:
    """Whether readings have noise; the pivot of what did not arrive is below zero."""
    r = r if len(r) == 1 else r[at[1:]]
    return bool((r > NOISY * pivot).all())


def smoothed(passed: Passed, lag: int | None, whole: bool) -> Back:
    """All rows, with all later rows or as many as the lag; P where `whole`."""
    rows = len(passed.tape.z)
    if lag is None or lag >= rows - 1:
        return _way_back(passed, whole)
    ends = (min(k + lag + 1, rows) for k in range(rows))
    found = (_way_back(passed.rows(k, end), whole) for k, end in enumerate(ends))
    return Back(*(np.concatenate([X[:1] for X in part]) for part in zip(*found)))


def _way_back(passed: Passed, whole: bool) -> Back:
    at, drive, maps, tape, noisy = passed
    (rows, N), n = tape.z.shape, maps.B.shape[1]
    if noisy:
        z, variances, w = _empty(rows, N), _empty(rows, n), _empty(rows, n)
        P, no, none = _empty(rows * whole, n, n), _empty(0, n), _empty(0, n, n)
        passes.backward.fast(at, maps, tape, no, none, no, no, z, variances, P, w)
        return Back(z, variances, P, w)
    passes.rts(at, maps, tape, _empty(0, n, n))
    z, V = tape.z, tape.V[:, :, :n]
    variances = np.einsum("tka,tk,tka->ta", V, tape.D, V)
    P = spread(V, tape.D) if whole else _empty(0, n, n)
    return Back(z, variances, P, _residual(maps, at, drive, z))


def _empty(*shape: int) -> np.ndarray:
    return np.empty(shape)


def spread(V: Matrix, D: Matrix) -> Matrix:
    """The covariances of factors."""
    return np.swapaxes(V, 1, 2) @ (D[:, :, None] * V)


def _residual(maps: Maps, at: Vector, drive: Matrix, z: Matrix) -> Matrix:
    """What the noises beside a state, and the next state, show of the process noise."""
    n = maps.B.shape[1]
    M = maps.M[at[1:]]
    w = np.einsum("tab,tb->ta", M[:, :, n:], z[:, n:])
    if maps.G.shape[2]:
        w[:-1] += z[1:, :n] - np.einsum("tab,tb->ta", M[:-1], z[:-1]) - drive[1:]
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
    passes.rts(at, maps, tape, found)
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
        code = ~np.isnan(self.y) @ (1 << np.arange(self.y.shape[1]))
        return [rows[code == one] for one in np.unique(code)]

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
