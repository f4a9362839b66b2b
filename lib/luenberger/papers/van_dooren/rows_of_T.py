"""One row of T A - F T = D C at a time, in staircase coordinates.

Row i of the unknown T, F, D solves x' M_i = -af_i', (18)-(20), where

    M_i = [-T_i; (A_U - f I)[i+1:]; -C_U]   and   x' = [f_i'  t_i'  d_i'].

Columns before the last that A_U[i+1:] does not reach meet T_i alone, so f_i' has few
entries that are not zero and the work is on the columns that remain.  A conjugate pair
a +- jb of a real plant is one row with f = a + jb: its real and imaginary parts are the
two rows, because T_i, A_U and C_U are real.

The rows of M_i that lead its columns make a triangle X.  So the entries of x that meet
the others, r - 1 of them, are free, and every solution comes of its own:

    x_lead X = -a - x_free M_free.

Source: Van Dooren (1984), section 3; papers/van_dooren/derivation/choices.py.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from scipy.linalg.lapack import get_lapack_funcs

from ...errors import DesignError
from ...numeric import Matrix, Vector
from ...numeric.staircase_form import Staircase

PANEL = 32  # columns triangularised at a time
WIDE = 1e4  # how far tau may be from 1 before its row is rescaled
FIRM = 1e-3  # least entry of a tall block's foot, beside its least singular value
LOOSE = 1e-8  # weight of t_{i+1} in the solutions of M_i, above which it is free


class Order(NamedTuple):
    """The poles in one order, and where a conjugate pair begins."""

    poles: Vector
    pairs: Vector


class Step(NamedTuple):
    """How a row or a pair was solved; the second row of a pair is Im x / size."""

    i: int
    f: complex
    x: Vector
    size: float | None  # of a single row None


class Rows:
    """The rows found so far: T (n - r, n), F (n - r, n - r), D (n - r, r)."""

    def __init__(self, form: Staircase) -> None:
        self.form, self.steps = form, list[Step]()
        n, r = len(form.A), form.rank
        self.n, self.r, self.size = n, r, n - r
        self.G = np.vstack([form.A, -form.C[:r]])
        kind = self.G.dtype
        self.T = np.zeros((n - r, n), kind)
        self.F = np.zeros((n - r, n - r), kind)
        self.D = np.zeros((n - r, r), kind)

    def start(self, i: int) -> int:
        """First column of row i of F that is not zero, or that rows below reach."""
        return max(int(np.searchsorted(self.form.leads, i + 1)) - 1, 0)

    def M(self, i: int, f: complex) -> Matrix:
        """M_i, from the first column and the first row of T on."""
        s, kind = self.start(i), np.result_type(self.G, type(f))
        M = np.concatenate([-self.T[s:i, s:], self.G[i + 1 :, s:]], dtype=kind)
        k = np.arange(i - s, self.n - 1 - s)
        M[k, k + 1] -= f
        return M

    def right_side(self, i: int, f: complex) -> Vector:
        """-af_i' of (20), from the first column on."""
        s = self.start(i)
        b = -self.G[i, s:].astype(np.result_type(self.G, type(f)))
        b[i - s] += f
        return b

    def places(self, i: int) -> tuple[Vector, Vector]:
        """Which rows of M_i lead a column, and which meet a free entry of x."""
        s = self.start(i)
        lead = np.concatenate([np.arange(i - s), self.form.leads[i:] - 1 - s])
        others = np.ones(self.n - s + self.r - 1, bool)
        others[lead] = False
        return lead, np.flatnonzero(others)

    def free(self, step: Step) -> Vector:
        """The free entries of a row."""
        return step.x[self.places(step.i)[1]]

    def add(self, i: int, f: complex, x: Vector, pair: bool = False) -> None:
        """Row i with the pole f; of a pair a +- jb of a real plant, rows i and i + 1.

        Where the second row of a pair meets its new state far more or less than the
        first, it is divided by that.
        """
        self.T[i, i] = 1
        if not pair:
            self._store(i, i, x)
            self.F[i, i] = f
            self.steps.append(Step(i, f, x, None))
            return
        tau = x[i - self.start(i)].imag
        size = abs(tau) if not 1 / WIDE <= abs(tau) <= WIDE else 1.0
        if not 0 < size < np.inf:
            raise DesignError(
                f"the pair {f.real:.6g} +- {abs(f.imag):.6g}j cannot be given to rows "
                f"{i} and {i + 1}: the second would not depend on a new state, as far "
                "as the arithmetic can tell. Change the order of the poles, or scale "
                "the states."
            )
        self._store(i, i, x.real)
        self._store(i + 1, i, x.imag / size)
        a, b = f.real, f.imag
        self.F[i : i + 2, i : i + 2] = [[a, -b * size], [b / size, a]]
        self.steps.append(Step(i, f, x, size))

    def _store(self, row: int, i: int, x: Vector) -> None:
        s, n = self.start(i), self.n
        self.F[row, s:i] = x[: i - s]
        self.T[row, i + 1 :] = x[i - s : n - s - 1]
        self.D[row] = x[n - s - 1 :]


Solve = Callable[[Rows, int, Any, bool], Vector]  # x of row i with the pole f


def solve_rows(form: Staircase, order: Order, solve: Solve) -> Rows:
    """T_U, F, D of (10), row by row."""
    rows, i = Rows(form), 0
    while i < rows.size:
        pair = bool(order.pairs[i])
        f = complex(order.poles[i])
        if not pair and np.isrealobj(rows.G):
            f = f.real
        rows.add(i, f, solve(rows, i, f, pair), pair)
        i += 1 + pair
    return rows


def with_entries(chosen: list[Vector]) -> Solve:
    """Rows with these free entries, one vector a row or pair."""

    def solve(rows: Rows, i: int, f: complex, pair: bool) -> Vector:
        return _with_entries(rows, i, f, chosen[len(rows.steps)])

    return solve


def back_substitution(rows: Rows, i: int, f: complex, pair: bool) -> Vector:
    """One solution, with zeros where no row leads, 2(b); a free tau is 1."""
    _, free = rows.places(i)
    chosen = 1j * (free == i - rows.start(i)) if pair else np.zeros(len(free))
    return _with_entries(rows, i, f, chosen)


def _with_entries(rows: Rows, i: int, f: complex, chosen: Vector) -> Vector:
    M, (lead, free) = rows.M(i, f), rows.places(i)
    x = np.empty(len(M), M.dtype)
    x[free] = chosen
    (trtrs,) = get_lapack_funcs(("trtrs",), (M,))
    # the transpose of a C-ordered triangle is what LAPACK wants, without a copy
    x[lead], _ = trtrs(M[lead].T, rows.right_side(i, f) - chosen @ M[free], lower=1)
    return x


def slopes(rows: Rows, slope: Matrix) -> list[Vector]:
    """The gradient in the free entries, from that in the rows of T.

    As T above enters M, a change of it turns into one of x: dx M = f dT. That is solved
    with the same triangle.  A row that is only made longer counts for nothing: what
    depends on lengths of rows has another gradient where a pair is rescaled.
    """
    slope, n, found = slope.copy(), rows.n, []
    for i, f, x, size in reversed(rows.steps):
        s, M, (lead, free) = rows.start(i), rows.M(i, f), rows.places(i)
        in_x = np.zeros_like(x)
        in_x[i - s : n - s - 1] = slope[i, i + 1 :]
        if size is not None:
            in_x[i - s : n - s - 1] += 1j * slope[i + 1, i + 1 :] / size
        (trtrs,) = get_lapack_funcs(("trtrs",), (M,))
        z, _ = trtrs(M[lead].T, in_x[lead].conj(), lower=1, trans=1)
        found.append(in_x[free] - z.conj() @ M[free].conj().T)
        above = np.outer(x[: i - s], z).conj()
        slope[s:i, s:] += above if np.iscomplexobj(slope) else above.real
    return found[::-1]


def minimum_norm(rows: Rows, i: int, f: complex, pair: bool) -> Vector:
    """The solution of least norm, by a QR factorisation that sweeps the columns, (21).

    A panel of columns reaches r - 1 rows beyond itself, which are carried into the
    next panel.  Where a pair leaves tau = t_{i+1,i+1} free it
    is set to 1, as the paper does; where the stair is one wide, tau = b / X.
    """
    s, r = rows.start(i), rows.r
    if r == 1:  # M_i is square: there is one solution only
        return back_substitution(rows, i, f, pair)
    w, factors = _sweep(rows, i, f)
    x = _unsweep(w, factors, np.zeros(r - 1, w[0].dtype))
    if pair and rows.form.leads[i] > i + 1:
        free = _outside(factors, i - s, r - 1)
        weight = float(np.vdot(free, free).real)  # |projection of e_tau|^2
        gap = 1 - x[i - s].imag
        if weight > LOOSE**2 and weight > LOOSE * gap**2 / (1 + np.vdot(x, x).real):
            none = [np.zeros_like(part) for part in w]
            x = x + 1j * gap / weight * _unsweep(none, factors, free)
    return x


def _sweep(rows: Rows, i: int, f: complex) -> tuple[list[Vector], list[Matrix]]:
    """Solve R' w = b panel by panel.  Returns w and the Q of every panel."""
    M, b, beyond = rows.M(i, f), rows.right_side(i, f), rows.r - 1
    carry, width = M[:beyond], max(PANEL, rows.r)
    geqrf, orgqr, trtrs = get_lapack_funcs(("geqrf", "orgqr", "trtrs"), (M,))
    w, factors = [], []
    for at in range(0, len(b), width):
        k = min(width, len(b) - at)
        X = np.concatenate([carry, M[at + beyond : at + beyond + k, at:]])
        R, scales, _, _ = geqrf(X[:, :k])
        Q = np.zeros((beyond + k, beyond + k), X.dtype, order="F")
        Q[:, :k] = R
        Q, _, _ = orgqr(Q, np.concatenate([scales, np.zeros(beyond, X.dtype)]))
        part, _ = trtrs(R[:k], b[at : at + k], trans=1)
        rest = Q.conj().T @ X[:, k:]
        b[at + k :] -= part @ rest[:k]
        carry = rest[k:]
        w.append(part)
        factors.append(Q)
    return w, factors


def _unsweep(w: list[Vector], factors: list[Matrix], tail: Vector) -> Vector:
    """Compute x = conj(Q) [w; tail] from the last panel back to the first."""
    pieces, kept = [], len(tail)
    for part, Q in zip(reversed(w), reversed(factors)):
        both = Q.conj() @ np.concatenate([part, tail])
        tail = both[:kept]
        pieces.append(both[kept:])
    return np.concatenate([tail, *reversed(pieces)])


def _outside(factors: list[Matrix], unit: int, kept: int) -> Vector:
    """Components of e_unit outside the range of M_i; unit <= r is in panel one."""
    inside = np.zeros(len(factors[0]), complex)
    inside[unit] = 1
    for k, Q in enumerate(factors):
        if k:
            inside = np.concatenate([inside, np.zeros(len(Q) - kept)])
        inside = Q.T @ inside
        inside = inside[len(inside) - kept :]
    return inside


def firm(form: Staircase) -> Staircase:
    """The form itself, or one with (8) as printed where a tall block has no foot.

    Back substitution divides by the leads.  A tall block has full column rank, and
    still the triangle in its last rows can be singular, as when the last output does
    not see a state of the next stair.  Then the stairs are turned from the top, the
    outputs in the end as well, so that every block is [R; 0].
    """
    ends = np.cumsum(form.blocks)
    steps = list(zip(form.blocks, ends, form.blocks[1:]))
    if all(_has_foot(form.A[e : e + below, e - w : e]) for w, e, below in steps):
        return form
    U, A, C, r = form.U.copy(), form.A.copy(), form.C.copy(), form.rank
    for width, end, below in steps:
        here, lower = slice(end - width, end), slice(end, end + below)
        Q, R = scipy.linalg.qr(A[lower, here])
        A[lower, end:] = Q.conj().T @ A[lower, end:]
        A[lower, here] = R
        for X in (A, C, U):
            X[:, lower] = X[:, lower] @ Q
    Q, R = scipy.linalg.qr(C[:, -r:])
    C[:, -r:] = R
    leads = np.concatenate([e + np.arange(w) for w, e in zip(form.blocks, ends)])
    return dataclasses.replace(form, U=U, A=A, C=C, Y=form.Y @ Q, leads=leads)


def _has_foot(block: Matrix) -> bool:
    """Whether the triangle in the last rows of a block is safe to divide by."""
    below, width = block.shape
    if below == width:
        return True
    foot = np.abs(np.diagonal(block[below - width :]))
    return foot.min() > FIRM * np.linalg.svd(block, compute_uv=False)[-1]
