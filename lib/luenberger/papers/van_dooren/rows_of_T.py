"""One row of T A - F T = D C at a time, in staircase coordinates.

Row i of the unknown T, F, D solves x' M_i = -af_i', (18)-(20), where

    M_i = [-T_i; (A_U - f I)[i+1:]; -C_U]   and   x' = [f_i'  t_i'  d_i'].

Columns before the first one that A_U[i+1:] reaches meet T_i alone, so f_i' has at
most r entries that are not zero and the work is on the n - i columns that remain.
A conjugate pair a +- jb of a real plant is one row with f = a + jb: its real and
imaginary parts are the two rows, because T_i, A_U and C_U are real.

Source: Van Dooren (1984), section 3; the pair as one complex row is our own.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg
from scipy.linalg.lapack import get_lapack_funcs

from ...errors import DesignError
from ...numeric import Matrix, Vector
from ...numeric.staircase_form import Staircase

Solve = Callable[..., tuple[Vector, Any]]  # x, and f_i at the known column
PANEL = 32  # columns triangularised at a time
WIDE = 1e4  # how far tau may be from 1 before its row is rescaled
FIRM = 1e-3  # least entry of a tall block's foot, beside its least singular value
LOOSE = 1e-8  # weight of t_{i+1} in the solutions of M_i, above which it is free


class Rows:
    """The rows found so far: T (n - r, n), F (n - r, n - r), D (n - r, r).

    Parameters
    ----------
    form : Staircase
    solve : callable
        `minimum_norm` or `back_substitution`.
    """

    def __init__(self, form: Staircase, solve: Solve) -> None:
        self.form, self.solve = form, solve
        n, r = len(form.A), form.rank
        self.n, self.r, self.size, self.multiply_adds = n, r, n - r, 0
        self.G = np.vstack([form.A, -form.C[:r]])
        kind = self.G.dtype
        self.T = np.zeros((n - r, n), kind)
        self.F = np.zeros((n - r, n - r), kind)
        self.D = np.zeros((n - r, r), kind)
        self.pivots = np.ascontiguousarray(self.G[form.leads])

    def start(self, i: int) -> int:
        """First column that rows i + 1, ... of A_U reach."""
        return int(np.searchsorted(self.form.leads, i + 1))

    def add(self, i: int, f: complex) -> None:
        """Row i with the pole f."""
        x, known = self.solve(self, i, f)
        self.T[i, i], self.F[i, i] = 1, f
        self._store(i, i, x, known)

    def add_pair(self, i: int, f: complex) -> None:
        """Rows i and i + 1 of a real plant with the poles f = a + jb and a - jb."""
        x, known = self.solve(self, i, f, pair=True)
        tau = x[i - self.start(i)].imag
        size = abs(tau) if not 1 / WIDE <= abs(tau) <= WIDE else 1.0
        if not 0 < size < np.inf:
            raise DesignError(
                f"the pair {f.real:.6g} +- {abs(f.imag):.6g}j cannot be given to rows "
                f"{i} and {i + 1}: the second would not depend on a new state, as far "
                "as the arithmetic can tell. Change the order of the poles, or scale "
                "the states."
            )
        a, b = f.real, f.imag
        self.T[i, i] = 1
        self._store(i, i, x.real, known.real)
        self._store(i + 1, i, x.imag / size, known.imag / size)
        self.F[i : i + 2, i : i + 2] = [[a, -b * size], [b / size, a]]

    def _store(self, row: int, i: int, x: Vector, known: complex) -> None:
        s, n = self.start(i), self.n
        if s:
            self.F[row, s - 1] = known
        self.F[row, s:i] = x[: i - s]
        self.T[row, i + 1 :] = x[i - s : n - s - 1]
        self.D[row] = x[n - s - 1 :]

    def right_side(self, i: int, f: complex) -> tuple[complex, Vector]:
        """f_i at the one known column s - 1, and what is left of -af_i' beyond it."""
        s = self.start(i)
        b = -self.G[i, s:].astype(np.result_type(self.G, type(f)))
        b[i - s] += f
        known = b.dtype.type(0)
        if s:
            known = known + self.G[i, s - 1] / self.T[s - 1, s - 1]
            b += known * self.T[s - 1, s:]
        return known, b

    def shifted(self, start: int, stop: int, first: int, f: complex) -> Matrix:
        """Rows start:stop of [A_U - f I; -C_U], from column `first` on."""
        block = self.G[start:stop, first:].astype(np.result_type(self.G, type(f)))
        diagonal = np.arange(max(start, first), min(stop, self.n))
        block[diagonal - start, diagonal - first] -= f
        return block


def solve_rows(form: Staircase, poles: Vector, pairs: Vector, solve: Solve) -> Rows:
    """T_U, F, D of (10), row by row."""
    rows = Rows(form, solve)
    i = 0
    while i < rows.size:
        if pairs[i]:
            rows.add_pair(i, complex(poles[i]))
            i += 2
        else:
            real = not np.iscomplexobj(rows.G)
            rows.add(i, float(poles[i].real) if real else complex(poles[i]))
            i += 1
    return rows


def minimum_norm(
    rows: Rows, i: int, f: complex, pair: bool = False
) -> tuple[Vector, Any]:
    """The solution of least norm, by a QR factorisation that sweeps the columns, (21).

    A panel of columns reaches r - 1 rows beyond itself.  These are carried into the
    next panel, so M_i is never formed.  Where a pair leaves tau = t_{i+1,i+1} free it
    is set to 1, as the paper does; where the stair is one wide, tau = b / X.
    """
    s, r = rows.start(i), rows.r
    if r == 1:  # M_i is square: there is one solution only
        return back_substitution(rows, i, f, pair)
    known, b = rows.right_side(i, f)
    w, factors = _sweep(rows, i, f, b)
    x = _unsweep(w, factors, np.zeros(r - 1, b.dtype))
    if pair and rows.form.leads[i] > i + 1:
        free = _outside(factors, i - s, r - 1)
        weight = float(np.vdot(free, free).real)  # |projection of e_tau|^2
        gap = 1 - x[i - s].imag
        if weight > LOOSE**2 and weight > LOOSE * gap**2 / (1 + np.vdot(x, x).real):
            none = [np.zeros_like(part) for part in w]
            x = x + 1j * gap / weight * _unsweep(none, factors, free)
    return x, known


def _sweep(
    rows: Rows, i: int, f: complex, b: Vector
) -> tuple[list[Vector], list[Matrix]]:
    """Solve R' w = b panel by panel.  Returns w and the Q of every panel."""
    n, r, s = rows.n, rows.r, rows.start(i)
    above = i - s  # rows of T among those carried into the first panel
    row = i + r - above
    carry = np.empty((r - 1, n - s), b.dtype)
    carry[:above] = -rows.T[s:i, s:]
    carry[above:] = rows.shifted(i + 1, row, s, f)
    (trtrs,) = get_lapack_funcs(("trtrs",), (b,))
    w, factors, at, width = [], [], 0, max(PANEL, r)
    while at < n - s:
        k = min(width, n - s - at)
        X = np.concatenate([carry, rows.shifted(row, row + k, s + at, f)])
        R, Q = _factor(X[:, :k])
        part, _ = trtrs(R, b[at : at + k], trans=1)
        rest = Q.conj().T @ X[:, k:]
        b[at + k :] -= part @ rest[:k]
        carry = rest[k:]
        rows.multiply_adds += Q.size * rest.shape[1] + X[:, :k].size * k
        w.append(part)
        factors.append(Q)
        at, row = at + k, row + k
    return w, factors


def _factor(X: Matrix) -> tuple[Matrix, Matrix]:
    """Square R and full Q of a tall panel."""
    geqrf, orgqr = get_lapack_funcs(("geqrf", "orgqr"), (X,))
    packed, scales, _, _ = geqrf(X)
    m, k = X.shape
    full = np.zeros((m, m), X.dtype, order="F")
    full[:, :k] = packed
    Q, _, _ = orgqr(full, np.concatenate([scales, np.zeros(m - k, X.dtype)]))
    return packed[:k], Q


def _unsweep(w: list[Vector], factors: list[Matrix], tail: Vector) -> Vector:
    """Compute x = conj(Q) [w; tail] from the last panel back to the first."""
    pieces, kept = [], len(tail)
    for part, Q in zip(reversed(w), reversed(factors)):
        both = Q.conj() @ np.concatenate([part, tail])
        tail = both[:kept]
        pieces.append(both[kept:])
    return np.concatenate([tail, *reversed(pieces)])


def _outside(factors: list[Matrix], unit: int, kept: int) -> Vector:
    """Components of e_unit outside the range of M_i; unit <= r - 1 is in panel one."""
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


def back_substitution(
    rows: Rows, i: int, f: complex, pair: bool = False
) -> tuple[Vector, Any]:
    """One solution, with zeros where the echelon form has no leading row, 2(b)."""
    n, r, s, leads = rows.n, rows.r, rows.start(i), rows.form.leads
    known, b = rows.right_side(i, f)
    x = np.zeros(n - s + r - 1, b.dtype)
    if pair and leads[i] > i + 1:
        x[i - s] = 1j  # tau is free: 1
        b -= 1j * rows.shifted(i + 1, i + 2, s, f)[0]
    (trtrs,) = get_lapack_funcs(("trtrs",), (b,))
    if i > s:
        above, _ = trtrs(-rows.T[s:i, s:i].astype(b.dtype), b[: i - s], trans=1)
        x[: i - s] = above
        b[i - s :] += above @ rows.T[s:i, i:]
    triangle = rows.pivots[i:, i:].astype(b.dtype)
    lead = leads[i:]
    inside = np.flatnonzero(lead < n)
    triangle[inside, lead[inside] - i] -= f
    # the transpose of a C-ordered triangle is what LAPACK wants, without a copy
    t, _ = trtrs(triangle.T, b[i - s :], lower=1)
    x[i - s + lead - i - 1] = t
    rows.multiply_adds += (n - i) ** 2 // 2 + (i - s) * (n - i)
    return x, known
