"""Smoothing as one batch of least squares, in rational arithmetic.

Every state and every measurement of a record is a sum of sources: the start, and the
noises.  Given the measurements, a source has a mean and a covariance, by one solve.
No recursion, no pseudo-inverse, no tolerance.
"""

from fractions import Fraction
from math import lcm

import numpy as np
from exact_filter import model, rational, solve, zeros


def product(*matrices):
    """The product of matrices of Fractions, found in whole numbers, which are fast."""
    found, below = None, 1
    for X in matrices:
        shared = lcm(*(v.denominator for v in X.flat))
        whole = np.empty(X.shape, dtype=object)
        whole.flat = [v.numerator * (shared // v.denominator) for v in X.flat]
        found, below = whole if found is None else found @ whole, below * shared
    out = np.empty(found.shape, dtype=object)
    out.flat = [Fraction(v, below) for v in found.flat]
    return out


class Batch:
    """Means and covariances of states and noises given some of the measurements.

    `y` has (N, p) floats or Fractions, NaN or None where not measured.
    """

    def __init__(self, plant, y, u=None, u0=None):
        self.plant, self.model = plant, model(plant)
        A, B, C, E, Q, R, S, P0, x0 = self.model
        n, m = B.shape
        self.N, self.n, self.p = len(y), n, len(C)
        u = zeros(self.N, m) if u is None else rational(u)
        u = np.vstack([zeros(1, m) if u0 is None else rational(u0)[None], u])
        size = n + (self.N + 1) * n + self.N * self.p
        self.cov = zeros(size, size)
        self.cov[:n, :n] = P0
        for k in range(self.N + 1):
            self.cov[self.w(k), self.w(k)] = Q
        for k in range(1, self.N + 1):
            self.cov[self.v(k), self.v(k)] = R
            self.cov[self.w(k), self.v(k)] = S
            self.cov[self.v(k), self.w(k)] = S.T
        unit = rational(np.eye(size))
        self.X, self.mean, self.shown, self.left, self.at = [unit[:n]], [x0], [], [], []
        self.known = {}
        for k in range(1, self.N + 1):
            self.move(A, B, u[k - 1], unit, k)
            Y = C @ self.X[k] + unit[self.v(k)]
            for j, value in enumerate(y[k - 1]):
                if not (value is None or value != value):
                    self.shown.append(Y[j])
                    known = C[j] @ self.mean[k] + E[j] @ u[k]
                    self.left.append(rational(value)[()] - known)
                    self.at.append(k)

    def move(self, A, B, u, unit, k):
        """The state at k; a prior of the first sample does not move to it."""
        if k == 1 and self.plant.at_first:
            self.X.append(self.X[0])
            self.mean.append(self.mean[0])
        else:
            self.X.append(A @ self.X[-1] + unit[self.w(k - 1)])
            self.mean.append(A @ self.mean[-1] + B @ u)

    def w(self, k):
        return slice(self.n * (k + 1), self.n * (k + 2))

    def v(self, k):
        start = self.n * (self.N + 2) + (k - 1) * self.p
        return slice(start, start + self.p)

    def given(self, until):
        """Mean and covariance of the sources, from measurements up to an instant."""
        if until not in self.known:
            self.known[until] = self.solved(until)
        return self.known[until]

    def solved(self, until):
        """The same, worked out."""
        Y = [row for row, k in zip(self.shown, self.at) if k <= until]
        if not Y:
            return zeros(len(self.cov)), self.cov
        Y = np.array(Y, dtype=object)
        left = np.array(self.left[: len(Y)], dtype=object)
        gain, null = solve(product(Y, self.cov, Y.T), product(self.cov, Y.T))
        assert not (null.T @ left).any(), "the record contradicts itself"
        return gain @ left, self.cov - product(gain, Y, self.cov)

    def smooth(self, lag=None):
        """x, P, lag_one, w, v as `Filter.smooth` finds them, of Fractions."""
        found = [[] for _ in range(5)]
        for k in range(1, self.N + 1):
            until = self.N if lag is None else min(k + lag, self.N)
            s, cov = self.given(until)
            X, n = self.X[k], self.n
            two = np.vstack([X, self.X[k - 1]])
            P = product(X, cov, two.T)  # and the covariance with the state before
            parts = self.mean[k] + X @ s, P[:, :n], P[:, n:]
            for rows, one in zip(found, (*parts, s[self.w(k)], s[self.v(k)])):
                rows.append(one)
        return tuple(np.array(rows, dtype=object) for rows in found)


def record(plant, N, rng, holes=0.0):
    """A record (N, p) of Fractions that the plant can show, None where not measured.

    The sources are combinations of whole numbers, so that noise-free outputs agree.
    """
    A, B, C, E, Q, R, S, P0, x0 = model(plant)
    joint = np.block([[Q, S], [S.T, R]])

    def draw(cov):
        return cov @ rational(rng.integers(-2, 3, len(cov)))

    x, y = x0 + draw(P0), []
    if not plant.at_first:
        x = A @ x + draw(joint)[: plant.n]
    for _ in range(N):
        noise = draw(joint)
        y.append(C @ x + noise[plant.n :])
        x = A @ x + noise[: plant.n]
    y = np.array(y, dtype=object).reshape(N, plant.p)
    y[rng.random(y.shape) < holes] = None
    return y


def floats(X):
    """Fractions as floats, None as NaN."""
    return np.array([np.nan if v is None else float(v) for v in X.flat]).reshape(
        X.shape
    )


def near(found, wanted, rtol, scale=None):
    """Whether floats are within rtol of Fractions, beside the largest of a matrix."""
    wanted = floats(wanted)
    size = np.abs(wanted).max(initial=0) if scale is None else scale
    return bool(np.abs(found - wanted).max(initial=0) <= rtol * max(size, 1e-300))


ONE = Fraction(1)
