"""A record in the terms of `passes`: readings with noises of their own, a map a row."""

from __future__ import annotations

from functools import partial
from math import prod
from typing import Any, NamedTuple

import numpy as np

from ..errors import DesignError
from ..kernels.jit import jitted
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..recursion.settings import require_start
from . import digits, passes, quick, scalars, settled, tail, unknown
from .compiling import early, installed
from .maps import Settings, factors
from .passes import FEW, TINY, Maps, State, Tape

MANY = 20_000  # rows that are worth a compilation
WRITING = 600  # rows that take as long in Python as their text takes to write
BACK = "back", "all"  # what is kept of each row for the way back


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
    gap : Gap
        That in which the row is.
    calm : int
        How many complete rows there were since the last gap; -1 where it is settled.
    P : (n, n) ndarray or None
        The covariance, where it was found as such and not in factors.
    clock : object
        What is known of the times of the record.
    awaited : Awaited or None
        The last rows of a record whose readings have arrivals.
    """

    instant: int
    state: State
    seen: np.ndarray
    u: np.ndarray
    gap: digits.Gap
    calm: int = 0
    P: np.ndarray | None = None
    clock: Any = None
    awaited: Any = None


EVERY = slice(None)


class Packed(NamedTuple):
    """Rows as `passes.forward` takes them.

    Attributes
    ----------
    y : (N, p) ndarray
        Readings less E u.
    drive : (N, n) ndarray
        B u of the row before.
    at : (N + 1,) ndarray of int
        The maps of the row before the first one, or -1, and of each row.
    maps : Maps
    mix : (k, p, p) ndarray
        What combines the readings of each map, so that their noises are independent.
    """

    y: np.ndarray
    drive: np.ndarray
    at: np.ndarray
    maps: Maps
    mix: np.ndarray

    def part(self, rows: slice = EVERY) -> tuple[Matrix, Matrix, Vector, Maps]:
        """Combined readings of rows, and what else `passes.forward` takes of them."""
        y, at = self.y[rows], self.at[rows.start or 0 :]
        if np.tril(self.mix, -1).any():
            y = np.array(y)
            passes.mixed(y, at, self.mix)
        return y, self.drive[rows], at, self.maps


class Passage(NamedTuple):
    """What a pass found: estimates and variances (N, n), the tape, where it ended.

    `settled` has the rows from which on there was one gain.
    """

    x: np.ndarray
    variances: np.ndarray
    tape: Tape
    packed: Packed
    end: End
    settled: list[Any]


def begin(settings: Settings, u0: Vector, known: bool = True) -> End:
    """The filter before the first row of a record.

    Without P0 nothing is known of the start, which is refused where it must be known.
    """
    plant = settings.plant
    n, p = plant.n, plant.p
    none = np.zeros(p, dtype=bool)
    if plant.P0 is None and known:
        require_start(plant)
    if settings.first is None:
        nothing = settings.way == "nothing"
        N = n if nothing else settings.at(0, none)[0].B.shape[1]
        z, V, D = np.zeros(N), np.eye(N), np.ones(N)
        if plant.P0 is None:
            D[:n] = unknown.GROWN * unknown.units(plant) ** 2
        else:
            z[:n], (V[:n, :n], D[:n]) = plant.x0, factors(plant.P0)
        settings.first = State(z, V, D, np.zeros((p, N)), np.zeros(p))
    state = State(*(X.copy() for X in settings.first))
    return End(0, state, none, u0, digits.Gap(0, np.zeros(n)))


def packed(
    settings: Settings, end: End, y: Matrix, u: Matrix, versions: Any = None
) -> Packed:
    """The rows of y and u behind `end`; y and `at` may have versions of rows.

    `versions` has the row of each, and which readings it has.
    """
    plant, rows = settings.plant, len(y)
    y = less(y, fed(plant, end.instant, u)) if plant.m else y
    if versions is None:
        of, seen = np.arange(rows), ~np.isnan(y)
    else:
        of, seen = versions
        y = np.where(seen, y[of], np.nan)
    prior = end.instant == 0 and (plant.P0 is None or plant.at_first)
    before = np.concatenate([end.u[None], u[:-1]]) if rows and plant.m else u
    drive = driven(plant, settings.origin, end.instant, before)
    if prior and rows:
        drive[0] = 0.0
    if plant.steps is None:
        # where outputs share no noise, no gap is in what leads to the next row
        first = seen[:1] if settings.way == "nothing" and rows else end.seen[None]
        sets, at = sets_of(np.concatenate([first, seen]))
        found = [settings.at(1, one) for one in sets]
    else:  # a map a row
        at, of = np.arange(len(y) + 1), np.append(0, of + 1)
        found = [
            settings.at(end.instant + int(k), one)
            for k, one in zip(of, [end.seen, *seen])
        ]
    maps, mix = settings.stack(tuple(found))
    if prior:
        at[0] = -1
    return Packed(np.ascontiguousarray(y), drive, at, maps, mix)


def less(y: Matrix, told: Matrix) -> Matrix:
    """y - told, zero where that is rounding: a state that is zero may be known."""
    left = y - told
    left[np.abs(left) <= TINY * (np.abs(y) + np.abs(told))] = 0.0
    return left


def times(X: Matrix, M: Matrix) -> Matrix:
    """X M'; a row has the same bits in any company, unlike those of BLAS."""
    found = np.zeros((*X.shape[:-1], len(M)))
    if X.shape[-1]:
        X, M = (
            np.require(Z, requirements=["C", "W"])
            for Z in (X.reshape(-1, X.shape[-1]), M)
        )
        passes.combine(X, M, found.reshape(len(X), len(M)))
    return found


def by_rows(M: Matrix, first: int, X: Matrix) -> Matrix:
    """M x of each row, as `times`; of a stack each row has its own, from `first` on."""
    if M.ndim == 2:
        return times(X, M)
    M = M[np.clip(first + np.arange(X.shape[-2]), 0, len(M) - 1)]
    found = np.zeros((*X.shape[:-1], M.shape[1]))
    for j in range(M.shape[2]):
        found += M[:, :, j] * X[..., j, None]
    return found


def fed(plant: Plant, instant: int, u: Matrix) -> Matrix:
    """E u of rows behind an instant; of many records (M, N, m) too."""
    return by_rows(plant.E, instant + 1, u)


def driven(plant: Plant, origin: int, instant: int, u: Matrix) -> Matrix:
    """B u that leads to each row behind an instant, u of the rows before; as `fed`."""
    return by_rows(plant.B, instant - origin, u)


def sets_of(seen: Matrix) -> tuple[Matrix, Vector]:
    """The sets of outputs that arrive in rows, and the number of that of each row."""
    if seen[1:].all():
        at = np.full(len(seen), 0 if seen[:1].all() else 1)
        at[:1] = 0
        return seen[: at.max(initial=0) + 1], at
    first, *more = np.packbits(seen, axis=1).T  # bytes are sorted quickly
    _, rows, at = np.unique(first, return_index=True, return_inverse=True)
    for byte in more:
        _, rows, at = np.unique(256 * at + byte, return_index=True, return_inverse=True)
    return seen[rows], at.astype(np.int64, copy=False)


def blank(
    rows: int, read: int, n: int, N: int, p: int, told: int | None = None
) -> Tape:
    """A tape of so many rows, of so many whose readings are kept, with gains or not."""
    told = read if told is None else told
    shapes = (rows, n), (rows, N, N), (told, p, N), (read, p), (read, p)
    room, parts, k = np.empty(sum(map(prod, shapes))), [], 0  # sooner had than many
    for shape in shapes:
        parts.append(room[k : k + prod(shape)].reshape(shape))
        k += prod(shape)
    ahead, V, K, pivot, nu = parts
    return Tape(ahead, np.empty((rows, N)), V, np.empty((rows, N)), K, pivot, nu)


def _room(settings: Settings, end: End, rows: int, keep: str) -> Tape:
    """A tape for what is kept of rows."""
    all_ = rows * (keep in BACK)
    told = rows * (keep in ("readings", "settled", *BACK))
    sizes = settings.plant.n, len(end.state.z), settings.plant.p
    room = blank(all_, rows * (keep != ""), *sizes, told)
    return room._replace(ahead=room.ahead[: len(room.z) * (keep == "all")])


def first_rows(
    settings: Settings, end: End, y: Matrix, u: Matrix, keep: str = ""
) -> Passage:
    """As `over`, of the rows until something is known of the whole state."""
    rows, n = len(y), settings.plant.n
    pack = packed(settings, end, y, u)
    state = State(*(X.copy() for X in end.state))
    tape = _room(settings, end, rows, keep)
    x, variances = np.empty((2, rows, n))
    done, clash = unknown.forward(*pack.part(), state, x, variances, tape)
    if clash >= 0:
        row, j = divmod(clash, settings.plant.p)
        refuse(settings, end.instant + 1 + row, j, ~np.isnan(y[row]))
    variances[variances > unknown.LARGE] = np.inf
    at = pack.at[: done + 1]
    pack = pack._replace(y=pack.y[:done], drive=pack.drive[:done], at=at)
    tape, instant = Tape(*(X[:done] for X in tape)), end.instant + done
    gap = digits.Gap(0, np.zeros(n))
    after = End(instant, state, ~np.isnan(y[done - 1]), u[done - 1], gap)
    return Passage(x[:done], variances[:done], tape, pack, after, [])


def over(settings: Settings, end: End, y: Matrix, u: Matrix, keep: str = "") -> Passage:
    """Filter rows.

    What is kept of each is "" (no tape), "values" (pivots and innovations), "readings"
    (gains as well), "settled" (these, and where the filter has settled its last gains:
    `Passage.settled` has these rows, without estimates), "back" (all that
    `passes.backward` reads), or "all".
    """
    plant, rows = settings.plant, len(y)
    n, p = plant.n, plant.p
    pack = packed(settings, end, y, u)
    tape = _room(settings, end, rows, keep)
    x, variances = np.empty((rows, n)), np.empty((rows, n))
    x = tape.z if tape.z.shape == x.shape else x
    run = text("forward", settings, pack.maps, rows)
    clash, P = 0, None
    if is_quick(settings, pack.maps, keep):
        state = end.state._replace(z=end.state.z.copy())
        P = covariance(state) if end.P is None else end.P.copy()
        kept = tape._replace(D=tape.D[:0])
        way = _in_covariance(pack, state.z, P, x, variances, kept)
        clash, calm, found = _along(settings, way, pack, end, run, keep, kept)
        if clash < 0:
            state, tape = State(state.z, *factors(P), state.E, state.e), kept
    if P is None or clash >= 0:
        P, state = None, State(*(X.copy() for X in end.state))
        way = _in_factors(run, pack, state, x, variances, tape)
        clash, calm, found = _along(settings, way, pack, end, run, keep, tape)
    row, j = divmod(clash, p) if clash >= 0 else (rows, 0)
    done, instant = slice(row + 1), end.instant + 1
    gap = digits.followed(
        settings, end.gap, y[done], variances[done], instant,
        partial(_covariance_at, run, pack, end.state),
    )  # fmt: skip
    if clash >= 0:
        refuse(settings, instant + row, j, ~np.isnan(y[row]))
    last = ~np.isnan(y[-1]) if rows else end.seen
    u = u[-1] if rows else end.u
    after = End(end.instant + rows, state, last, u, gap, calm, P)
    return Passage(x, variances, tape, pack, after, found)


def _along(
    settings: Settings, way: tail.Way, pack: Packed, end: End, run: Any, keep: str,
    tape: Tape,
) -> tuple[int, int, list[Any]]:  # fmt: skip
    """What `tail.over` finds; what is kept on a tape is the full recursion's."""
    plain = settings.plant.steps is None and settings.way == "nothing"
    if keep == "settled" and plain and (pack.maps.r > 0).all():
        return -1, 0, settled.forward(way, pack, tape)
    if keep or not plain:
        return way.rows(slice(0, len(pack.y))), 0, []
    return tail.over(way, pack, partial(settings.steady, run), end.calm, one_gain)


def _in_factors(
    run: Any, pack: Packed, state: State, x: Matrix, variances: Matrix, tape: Tape
) -> tail.Way:
    def rows(part: slice) -> int:
        rest = x[part], variances[part], settled.part(tape, part)
        return int(run(*pack.part(part), state, *rest))

    def settle(V: Matrix, D: Vector) -> None:
        state.V[:], state.D[:] = V, D

    return tail.Way(rows, lambda: (state.V, state.D), settle, state.z, x, variances)


def _in_covariance(
    pack: Packed, z: Vector, P: Matrix, x: Matrix, variances: Matrix, tape: Tape
) -> tail.Way:
    Q = pack.maps.G @ pack.maps.G.mT

    def rows(part: slice) -> int:
        rest = x[part], variances[part], settled.part(tape, part)
        return int(quick.forward.fast(*pack.part(part), Q, z, P, *rest))

    def settle(V: Matrix, D: Vector) -> None:
        P[:] = (V.T * D) @ V

    eps = tail.ROUNDED
    return tail.Way(rows, lambda: factors(P), settle, z, x, variances, eps)


def _covariance_at(run: Any, pack: Packed, state: State, row: int) -> Matrix:
    """The covariance of one row, found again."""
    n, part = pack.drive.shape[1], slice(0, row + 1)
    state, room = State(*(X.copy() for X in state)), np.empty((2, row + 1, n))
    tape = blank(0, 0, n, len(state.z), pack.y.shape[1])
    _in_factors(run, pack, state, room[0], room[1], tape).rows(part)
    return covariance(state)[:n, :n]


def is_quick(settings: Settings, maps: Maps, keep: str) -> bool:
    """Whether the covariance itself is tried, before factors of it."""
    noisy = settings.way == "nothing" and keep != "all"
    return noisy and settings.plant.n > FEW and bool((maps.r > 0).all())


def covariance(state: State) -> Matrix:
    """U D U'."""
    return np.ascontiguousarray((state.V.T * state.D) @ state.V)


def text(name: str, settings: Settings, maps: Maps, rows: int) -> Any:
    """The text that goes over so many rows; for few states all find the same bits."""
    n, p = settings.plant.n, settings.plant.p
    if n <= FEW and settings.way == "nothing":
        work = (rows + WRITING) * n * n * (n + p) / 8
        if name == "forward" and early(work):
            return scalars.python(maps)
        if rows >= MANY or scalars.known(name, maps):
            return scalars.function(name, maps)
    return loops(name, n)


def one_gain(y: Matrix, J: Matrix) -> Any:
    """The text that goes over rows y with one gain; as `text`."""
    if installed() and len(y) >= MANY and len(J) <= FEW:
        return jitted(scalars.one_gain(len(J), y.shape[1], J.shape[1]))
    return passes.one_gain if len(J) <= FEW else passes.one_gain.fast


def loops(name: str, n: int) -> Any:
    """A text of `passes` for n states, in loops."""
    one = getattr(passes, name)
    return one.fast if n > FEW else one.exact


def refuse(settings: Settings, instant: int, j: int, seen: Vector) -> None:
    names, now = settings.plant.output_names, settings.now(instant)
    noisy = now.covariances()[1].diagonal() > 0
    if settings.way == "nothing":  # else noises of outputs may cancel
        seen = seen & ~noisy
    which = np.flatnonzero(seen[: j + 1])
    by = "outputs, whose noises cancel," if noisy[which].any() else "noise-free outputs"
    grows = np.abs(np.linalg.eigvals(now.A)).max(initial=0) > 1
    raise DesignError(
        f"at instant {instant} the reading of {names[j]!r} contradicts what is known "
        f"exactly there, by the {by} {[names[k] for k in which]} or by earlier ones. "
        "Give them noise in R, or raise Q or P0."
        + " A has an unstable mode: where nothing drives it, rounding grows with it, "
        "and Q must not be 0 there." * bool(grows)
    )


def combined(mix: Matrix, y: Matrix) -> Matrix:
    """Readings (M, N, p) of rows, each combined by its matrix of `mix`."""
    if not np.tril(mix, -1).any():
        return y
    if (mix == mix[0]).all():
        return y @ mix[0].T
    return np.ascontiguousarray((mix @ y[..., None])[..., 0])


def gains(one: Passage) -> Matrix:
    """What each combined reading of a row moves z by, (N, N, p)."""
    tape, (_, _, at, maps, _) = one.tape, one.packed
    share = np.where(tape.pivot > 0, 1 / np.where(tape.pivot > 0, tape.pivot, 1), 0)
    K = np.zeros((*tape.K.shape[::2], tape.K.shape[1]))
    for j in range(K.shape[2]):  # one reading after the other moves the estimate
        k = tape.K[:, j] * share[:, j, None]
        C = maps.C[at[1:], j]
        K -= k[:, :, None] * np.einsum("tk,tkj->tj", C, K)[:, None, :]
        K[:, :, j] += k
    return K


def matrices(one: Passage) -> tuple[Matrix, Matrix]:
    """Covariances (N, n, n) and gains (N, n, p) of a passage with its whole tape."""
    tape, (_, _, at, maps, mix) = one.tape, one.packed
    n = one.x.shape[1]
    share = np.where(tape.pivot > 0, 1 / np.where(tape.pivot > 0, tape.pivot, 1), 0)
    P = np.einsum("tka,tk,tkb->tab", tape.V[:, :, :n], tape.D, tape.V[:, :, :n])
    P[np.abs(P) > unknown.LARGE] *= np.inf
    K = gains(one)
    O = maps.O[at[1:]]  # noqa: E741
    if O.shape[2]:
        pushed = np.einsum("tjk,tnk->tjn", tape.K[:, :, n:], O)
        P = P + np.einsum("tja,tj,tjb->tab", pushed, share, pushed)
        K = K[:, :n] + O @ K[:, n:]
    return 0.5 * (P + P.mT), K[:, :n] @ mix[at[1:]]


def over_steps(settings: Settings, steps: int) -> tuple[Matrix, Matrix]:
    """Covariances and gains of instants 1 .. steps: those of a record of zeros."""
    plant = settings.plant
    y, u = np.zeros((steps, plant.p)), np.zeros((steps, plant.m))
    end = begin(settings, np.zeros(plant.m))
    end.state.z[:] = 0.0  # which agrees with every reading
    return matrices(over(settings, end, y, u, "all"))
