"""Rows from entries that are chosen freely, and slopes in these entries.

Row i solves x M = -a with x = [f t d], as in `rows_of_T`.  The rows of M that lead its
columns make a triangle X, so that the entries of x that meet the others, r - 1 of them,
are free:

    x_lead X = -a - x_free M_free.

Every solution comes of its own free entries.  As T above enters M, a change of it turns
into one of x: dx M = f dT, which is solved with the same triangle.

Source: papers/van_dooren/derivation/choices.py; remark 2(b) of Van Dooren (1984).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg.lapack import get_lapack_funcs

from ...numeric import Matrix, Vector
from ...numeric.staircase_form import Staircase
from .rows_of_T import Rows, solve_rows


@dataclass(frozen=True, eq=False)
class Step:
    """How one row was solved, on the columns from `start` on."""

    i: int
    start: int
    pair: bool
    lead: Vector  # places in x that lead a column
    free: Vector  # the other places
    X: Matrix  # the leading rows of M
    M_free: Matrix  # its other rows
    x: Vector


def solved(
    form: Staircase, poles: Vector, pairs: Vector, free: list[Vector]
) -> tuple[Rows, list[Step]]:
    """The rows with these free entries, one vector a row or pair; and how."""
    steps: list[Step] = []

    def solve(rows: Rows, i: int, f: complex, pair: bool = False) -> tuple[Vector, Any]:
        step = _step(rows, i, f, pair, free[len(steps)])
        steps.append(step)
        if step.start < rows.start(i):
            return step.x[1:], step.x[0]
        return step.x, step.x.dtype.type(0)

    return solve_rows(form, poles, pairs, solve), steps


def _step(rows: Rows, i: int, f: complex, pair: bool, chosen: Vector) -> Step:
    n, leads, s = rows.n, rows.form.leads, _start(rows, i)
    lead, free = places(rows.form, i, s)
    kind = np.result_type(rows.G, type(f))
    X = np.empty((n - s, n - s), kind)
    X[: i - s], X[i - s :] = -rows.T[s:i, s:], rows.pivots[i:, s:]
    inside = np.flatnonzero(leads[i:] < n)
    X[i - s + inside, leads[i:][inside] - s] -= f
    M_free = rows.G[free + 1 + s, s:].astype(kind)
    inside = np.flatnonzero(free + 1 < n - s)
    M_free[inside, free[inside] + 1] -= f
    rest = -rows.G[i, s:].astype(kind)
    rest[i - s] += f
    x = np.empty(n - s + rows.r - 1, kind)
    x[free] = chosen
    (trtrs,) = get_lapack_funcs(("trtrs",), (X,))
    # the transpose of a C-ordered triangle is what LAPACK wants, without a copy
    x[lead], _ = trtrs(X.T, rest - chosen @ M_free, lower=1)
    return Step(i, s, pair, lead, free, X, M_free, x)


def _start(rows: Rows, i: int) -> int:
    """First column that is not zero in row i of F, or of what rows below reach."""
    return max(rows.start(i) - 1, 0)


def places(form: Staircase, i: int, start: int) -> tuple[Vector, Vector]:
    """Where x of row i has entries that lead a column, and where free ones."""
    lead = np.concatenate([np.arange(i - start), form.leads[i:] - 1 - start])
    others = np.ones(len(form.A) - start + form.rank - 1, bool)
    others[lead] = False
    return lead, np.flatnonzero(others)


def entries(rows: Rows, pairs: Vector) -> list[tuple[Vector, Vector]]:
    """x of every row or pair, and its free entries."""
    found, i = [], 0
    while i < rows.size:
        s = _start(rows, i)
        x = _x(rows, i, s)
        if pairs[i]:
            x = x + 1j * _size(rows, i) * _x(rows, i + 1, s, i)
        _, free = places(rows.form, i, s)
        found.append((x, np.ascontiguousarray(x[free])))
        i += 1 + bool(pairs[i])
    return found


def _x(rows: Rows, row: int, s: int, i: int | None = None) -> Vector:
    i = row if i is None else i
    return np.concatenate([rows.F[row, s:i], rows.T[row, i + 1 :], rows.D[row]])


def _size(rows: Rows, i: int) -> float:
    """What the second row of a pair was divided by."""
    return float(np.sqrt(np.abs(rows.F[i, i + 1] / rows.F[i + 1, i])))


def slopes(rows: Rows, steps: list[Step], slope: Matrix) -> list[Vector]:
    """The gradient in the free entries, from that in the rows of T.

    A row that is only made longer counts for nothing: what depends on lengths of rows
    has another gradient where a pair is rescaled.
    """
    slope, n, found = slope.copy(), rows.n, []
    for step in reversed(steps):
        i, s = step.i, step.start
        in_x = np.zeros_like(step.x)
        in_x[i - s : n - s - 1] = slope[i, i + 1 :]
        if step.pair:
            in_x[i - s : n - s - 1] += 1j * slope[i + 1, i + 1 :] / _size(rows, i)
        (trtrs,) = get_lapack_funcs(("trtrs",), (step.X,))
        z, _ = trtrs(step.X.T, in_x[step.lead].conj(), lower=1, trans=1)
        found.append(in_x[step.free] - z.conj() @ step.M_free.conj().T)
        above = np.outer(step.x[: i - s], z).conj()
        slope[s:i, s:] += above if np.iscomplexobj(slope) else above.real
    return found[::-1]
