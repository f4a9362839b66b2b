"""The same observer from rows of T that D drives to zero, a step at a time.

A chain of factors is short to derive, but it finds all of D from its very last row,
in which what is done early is multiplied by a high power of A, so that digits cancel.
Here a row t of T and the one after it, t_next, are seen as a state and the next,

    t (A - a I) = t_next + d C,                               for a real pole a,
    t ((A - a I)^2 + b^2 I) = t_next + d C + d' C (A - a I),  for a pair a +- b i,

and d as an input that has to bring t from k to zero in as many steps as there are
factors.  Backward from S = {0}, the rows from which the last steps can do so are

    S_before = {t : the left-hand side lies in S + span(C), or span(C, C (A - a I))},

each an orthonormal basis.  Forward from k, the row is split into one in S and an input
by least squares: no step needs more than the sizes at hand.
"""

import numpy as np
import scipy.linalg

from ...numeric import Matrix, Vector
from .companion_chain import Chain

RANK_TOL = 1e-13  # a pivot this small beside the largest is zero


def driven(A: Matrix, C: Matrix, k: Vector, poles: Vector) -> Chain:
    """A `Chain` with these poles, pairs side by side, that with b > 0 first.

    Every row of T but zero ones has length one.  Where no observer has these poles
    it is one of the nearest row to k.
    """
    factors = [_Factor(A, C, pole) for pole in poles if pole.imag >= 0]
    spaces = [np.zeros((0, len(A)))]
    for factor in factors[::-1]:
        spaces.append(factor.before(spaces[-1]))
    *later, first = spaces
    T, D = list[Vector](), list[Vector]()
    F = np.zeros((len(poles), len(poles)))
    t, size = _unit((k @ first.T) @ first)
    P = np.r_[size, np.zeros(len(poles))][None, : len(poles)]
    for factor, space in zip(factors, later[::-1]):
        rows, inputs, block, t = factor.step(t, space)
        here, after = len(T), len(T) + len(rows)
        F[here:after, here:after] = block
        t, size = _unit(t)
        F[after - 1, after : after + 1] = size
        T, D = T + rows, D + inputs
    return Chain(F, np.array(D), np.array(T), P)


class _Factor:
    """One real pole a or one pair a +- b i: how a row of T is led to the next."""

    def __init__(self, A: Matrix, C: Matrix, pole: complex) -> None:
        self.C, self.a, self.b = C, pole.real, pole.imag
        self.Z = A - self.a * np.eye(len(A))
        self.q, inputs = self.Z, C
        if self.b:
            self.q = self.Z @ self.Z + self.b**2 * np.eye(len(A))
            inputs = np.vstack([C, C @ self.Z])
        size = np.linalg.norm(inputs, axis=1)
        self.size = np.where(size > 0, size, 1.0)
        self.inputs = inputs / self.size[:, None]

    def before(self, space: Matrix) -> Matrix:
        """S_before, from S."""
        Q, rank = pivoted(np.vstack([space, self.inputs]).T)
        Q, rank = pivoted(self.q @ Q[:, rank:])
        return Q[:, rank:].T

    def step(
        self, t: Vector, space: Matrix
    ) -> tuple[list[Vector], list[Vector], list[list[float]], Vector]:
        """Rows of T, rows of D, the block of F, and the row after these."""
        both, y = np.vstack([space, self.inputs]), t @ self.q
        x = scipy.linalg.lstsq(both.T, y, cond=RANK_TOL, lapack_driver="gelsy")[0]
        after = x[: len(space)] @ space
        d = (x[len(space) :] / self.size).reshape(-1, len(self.C))
        if not self.b:
            return [t], [d[0]], [[self.a]], after
        u, size = _unit(t @ self.Z - d[1] @ self.C)
        size = size if size > 0 else 1.0
        block = [[self.a, size], [-(self.b**2) / size, self.a]]
        return [t, u], [d[1], d[0] / size], block, after / size


def pivoted(M: Matrix, tol: float = RANK_TOL) -> tuple[Matrix, int]:
    """An orthonormal basis whose first columns span those of M, and their number."""
    if not M.shape[1]:
        return np.eye(len(M)), 0
    Q, R, _ = scipy.linalg.qr(M, pivoting=True)
    size = np.abs(np.diagonal(R))
    return Q, int((size > tol * size[0]).sum())


def _unit(row: Vector) -> tuple[Vector, float]:
    size = float(np.linalg.norm(row))
    return (row / size if size > 0 else row), size
