"""The likelihood of a record from a filter that has settled, and its gradient.

What is left out is at most the square of what is left of the start at the end of the
record, once for each row; a record is long enough where that is below rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..plant import Plant
from ..plant.instant import Instant
from ..recursion.state import flat
from .derivation import carried_on, settled_score, told_of_start
from .score import Adjoint, Sums, at_start
from .settled import FADED, Settled, Start, known_start, settle, unknown_start

CARRIED = kernels.Recursion(
    carried_on,
    carried=(("z_next", "z"),),
    rows=(("g", "gs", 0),),
    written=(("zs", "z_next", "vector"),),
)


def carried(f: Matrix, g: Matrix, z: Vector, fast: bool) -> Matrix:
    """Rows z, f z + g[0], f (f z + g[0]) + g[1], ...: (N + 1, n)."""
    N, n = g.shape
    if not fast:
        return doubled(f, np.concatenate([z[None], g]))
    out = np.empty((N + 1, n))
    out[0] = z
    nothing = np.zeros(1, dtype=np.int64)
    kernel = kernels.over_record(CARRIED, (("n", n),), (), frozenset())
    kernel(
        f=flat(np.ascontiguousarray(f)[None]), gs=np.ascontiguousarray(g), z=z.copy(),
        zs=out[1:], start=0, stop=N, now=nothing, before=nothing,
        good=np.ones(1, dtype=bool), keep=False,
    )  # fmt: skip
    return out


def doubled(f: Matrix, rows: Matrix) -> Matrix:
    """The same in NumPy: each row takes up twice as many of those before it."""
    power, step = f, 1
    while step < len(rows) and np.abs(power).max(initial=0) > FADED**2:
        rows = np.concatenate([rows[:step], rows[step:] + rows[:-step] @ power.T])
        power, step = power @ power, 2 * step
    return rows


class Rows(NamedTuple):
    """One record under a settled filter, with the best value of its start.

    Attributes
    ----------
    x : (N + 1, n) ndarray
        Predictions.
    e : (N, p) ndarray
        Weighed innovations.
    eta : (n,) ndarray
        Gradient in the first prediction.
    square : float
        The exponent.
    """

    x: np.ndarray
    e: np.ndarray
    eta: np.ndarray
    square: float


class Evaluator:
    """Likelihoods of the same records under one plant after another.

    The gain that settled last begins the search for the next.

    Parameters
    ----------
    records : list of (y, u, u0)
        Arrays; without NaN, or nothing is found.
    fast : bool
        Whether the rows run in compiled code.
    """

    def __init__(self, records: Sequence[tuple[Matrix, Matrix, Vector]], fast: bool):
        self.records, self.fast = records, fast
        self.complete = not any(np.isnan(y).any() for y, *_ in records)
        self.gain: Matrix | None = None

    def __call__(
        self, now: Instant, start: Plant | None, wanted: tuple[str, ...] = ()
    ) -> tuple[float, Matrices] | None:
        """The logarithm of the likelihood, and gradients in the matrices of `wanted`.

        None where a record is too short, has gaps, or the filter does not settle.

        Parameters
        ----------
        now : Instant
        start : Plant or None
            Who says how a record begins; None is an unknown start.
        wanted : tuple of str
            Of "A", ..., "S", and for a start that is known "x0" and "P0".
        """
        one = self._settled(now)
        if one is None or one.least > min(len(y) for y, *_ in self.records):
            return None
        total, found = 0.0, dict[str, np.ndarray]()
        for y, u, u0 in self.records:
            begin = unknown_start(one) if start is None else known_start(start, one, u0)
            if begin is None:
                return None
            rows = over(now, one, begin, y, u, self.fast)
            total += value(one, begin, rows)
            if wanted:
                more = score(now, one, begin, rows, u, wanted, self.fast)
                if start is not None:
                    more = _with_start(start, one, begin, rows, u0, more)
                found = {k: found.get(k, 0) + X for k, X in more.items()}
        return float(total), {name: found[name] for name in wanted}

    def _settled(self, now: Instant) -> Settled | None:
        one = None
        if self.complete and self.gain is not None:
            one = settle(now, self.gain)
        if self.complete and one is None:
            one = settle(now)
        if one is not None:
            self.gain = one.G
        return one


def over(
    now: Instant, one: Settled, begin: Start, y: Matrix, u: Matrix, fast: bool
) -> Rows:
    """Two passes: over the rows that show the start, and from its best value."""
    shown = y - u @ now.E.T if now.E.any() else y
    g = shown @ one.G.T
    if now.B.any():
        g += u @ now.B.T
    first = slice(0, one.fades)

    x = carried(one.F, g[first], begin.mean, fast)
    e = (shown[first] - x[:-1] @ now.C.T) @ one.W
    told = carried(one.F.T, (e @ now.C)[::-1], np.zeros(len(one.F)), fast)[-1]
    delta, eta = begin.weight @ told, begin.held @ told
    x = carried(one.F, g, begin.mean + delta, fast)
    nu = shown - x[:-1] @ now.C.T
    e = nu @ one.W
    return Rows(x, e, eta, float(np.vdot(e, nu) + delta @ eta))


def value(one: Settled, begin: Start, rows: Rows) -> float:
    """The logarithm of the likelihood of one record."""
    N, p = rows.e.shape
    count = N * p - begin.free
    exponent = rows.square + N * one.log_det + begin.constant
    return -0.5 * float(count * np.log(2 * np.pi) + exponent)


def score(
    now: Instant, one: Settled, begin: Start, rows: Rows, u: Matrix,
    wanted: tuple[str, ...], fast: bool,
) -> Matrices:  # fmt: skip
    """Gradients in the matrices of the plant, as if the first prediction were fixed."""
    N, n = len(rows.e), len(one.F)
    e = np.ascontiguousarray(rows.e[::-1])
    eta_next = carried(one.F.T, e @ now.C, np.zeros(n), fast)[:-1]
    h = e - eta_next @ one.G
    parts = [eta_next, h]
    if set(wanted) & {"A", "C"}:
        parts.append(rows.x[:-1][::-1])
    if set(wanted) & {"B", "E"}:
        parts.append(u[::-1])
    both = np.concatenate(parts, axis=1)
    J = both[:, : n + h.shape[1]].T @ both
    s, h_ = slice(0, n), slice(n, n + h.shape[1])
    x_ = slice(h_.stop, h_.stop + n)
    have = dict(J_ee=J[s, s], J_eh=J[s, h_], J_hh=J[h_, h_])
    have |= dict(J_ex=J[s, x_], J_hx=J[h_, x_], A=now.A, C=now.C)
    have |= dict(Omega=one.Omega, G=one.G, F=one.F, V=one.V, Pi=one.Pi)
    have |= dict(Pi_all=N * one.Pi, W_all=N * one.W, Pi_2=one.back(one.Pi))
    have |= dict(Y=one.forward(begin.weight))
    outputs = [f"g{name}" for name in "ACQRS" if name in wanted]
    found = kernels.run(settled_score, have, *outputs)
    found = {name[1:]: found[name] for name in outputs}
    last = slice(J.shape[1] - u.shape[1], None)
    return found | {
        name: J[at, last] for name, at in (("B", s), ("E", h_)) if name in wanted
    }


def _with_start(
    plant: Plant, one: Settled, begin: Start, rows: Rows, u0: Vector, found: Matrices
) -> Matrices:
    """The gradients of a start that is known as well; it moves the first prediction."""
    told = kernels.compiled(told_of_start)(Pi=one.Pi, T_1=begin.weight)
    sums = Sums(plant)
    start = at_start(plant, Adjoint(rows.eta[:, None], told["Pi_1"]), u0, sums)
    led = {name: X + sums.found.get(name, 0) for name, X in found.items()}
    return led | start
