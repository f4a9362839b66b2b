"""The filter in rational arithmetic, and random singular problems to hold it against.

`run` is the Kalman filter, or Leondes and Novak's filter with accurate outputs, for
any covariances: no pseudo-inverse, no tolerance, no opinion on what is nearly zero.
Matrices are object arrays of Fractions; floats are taken as they are, bit for bit.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

import luenberger as lb


def rational(X):
    """X as an object array of Fractions, exactly."""
    X = np.asarray(X)
    out = np.empty(X.shape, dtype=object)
    out.flat = [Fraction(float(v)) if X.dtype != object else v for v in X.flat]
    return out


def zeros(*shape):
    return rational(np.zeros(shape))


def solve(M, N):
    """Some X with X M = N for symmetric M, and columns that span the null space of M.

    Gauss and Jordan, with free variables set to zero.  Raises if there is no X.
    """
    p, rows = len(M), len(N)
    work, pivots = np.hstack([M, N.T]), []
    for col in range(p):
        done = len(pivots)
        row = next((k for k in range(done, p) if work[k, col] != 0), None)
        if row is None:
            continue
        work[[done, row]] = work[[row, done]]
        work[done] = work[done] / work[done, col]
        for k in range(p):
            if k != done and work[k, col] != 0:
                work[k] = work[k] - work[k, col] * work[done]
        pivots.append(col)
    assert not work[len(pivots) :, p:].any(), "the rows of N are not in the range of M"
    X, free = zeros(rows, p), [k for k in range(p) if k not in pivots]
    X[:, pivots] = work[: len(pivots), p:].T
    null = zeros(p, len(free))
    for j, col in enumerate(free):
        null[col, j] = Fraction(1)
        null[pivots, j] = -work[: len(pivots), col]
    return X, null


class Model(NamedTuple):
    """A constant plant in Fractions; S may not be None here."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    E: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    S: np.ndarray
    P0: np.ndarray
    x0: np.ndarray


def model(plant):
    """The model that the floats of a constant `plant` say."""
    now = plant.at(0)
    S = np.zeros((plant.n, plant.p)) if now.S is None else now.S
    return Model(*map(rational, (*now[:6], S, plant.P0, plant.x0)))


@dataclass
class Exact:
    """Estimates (N, n), covariances (N, n, n), and the largest contradiction by row.

    Row k is instant k + 1; the lists are of object arrays, `gaps` of Fractions.
    """

    x: list
    P: list
    gaps: list


def run(plant, y, u=None, u0=None, accurate=(), prior=False):
    """Filter the rows of y; NaN (or None) in y was not measured.

    Parameters
    ----------
    plant : Plant or Model
    y : (N, p) of floats or Fractions
    u, u0 : (N, m), (m,), default zero
    accurate : tuple of int
        Outputs that are treated as exact.
    prior : bool
        Whether x0, P0 are those of instant 1 (a Plant says it itself).

    Returns
    -------
    Exact
        Where `gaps` is not zero a noise-free combination of outputs contradicts the
        others, or what is known exactly; it is left out then.
    """
    if not isinstance(plant, Model):
        prior = plant.at_first
        plant = model(plant)
    A, B, C, E, Q, R, S, P, x = plant
    n, m = B.shape
    u = zeros(len(y), m) if u is None else rational(u)
    before = zeros(m) if u0 is None else rational(u0)
    J, seen, rho = zeros(n, 0), np.zeros(len(C), dtype=bool), zeros(0)
    found = Exact([], [], [])
    for k, row in enumerate(y):
        if k or not prior:
            As = A - J @ C[seen]
            P = As @ P @ As.T + Q - J @ S[:, seen].T
            x = A @ x + B @ before + J @ rho
        seen = np.array([not (v is None or v != v) for v in row], dtype=bool)
        Ck, Rk = C[seen], R[np.ix_(seen, seen)]
        innovation = rational(row[seen]) - E[seen] @ u[k] - Ck @ x
        M = Ck @ P @ Ck.T + Rk
        K, null = solve(M, P @ Ck.T)
        gap = null.T @ innovation
        Gamma = gamma_of(Ck, np.isin(np.flatnonzero(seen), accurate))
        K = K + Gamma - Gamma @ (Ck @ K)
        x = x + K @ innovation
        Y = rational(np.eye(n)) - K @ Ck
        P = Y @ P @ Y.T + K @ Rk @ K.T
        rho, J = rational(row[seen]) - E[seen] @ u[k] - Ck @ x, J_of(S[:, seen], Rk)
        before = u[k]
        found.x.append(x)
        found.P.append(P)
        found.gaps.append(max(map(abs, gap), default=Fraction(0)))
    return found


def gamma_of(C, accurate):
    """C1' (C1 C1')^-1 in the columns of the accurate outputs."""
    C1, Gamma = C[accurate], zeros(*C.T.shape)
    found, null = solve(C1 @ C1.T, C1.T)
    assert not null.size
    Gamma[:, accurate] = found
    return Gamma


def J_of(S, R):
    """J R = S of least norm, outputs at unit variance (derivations/decorrelation)."""
    scale = np.array([1 / v if v else Fraction(1) for v in R.diagonal()], dtype=object)
    scaled = scale[:, None] * R
    return solve(R @ scaled, S)[0] @ scaled.T


def as_floats(found):
    """x (N, n) and P (N, n, n) of an `Exact` as floats."""
    return (np.array([v.astype(float) for v in part]) for part in (found.x, found.P))


@dataclass
class Problem:
    """A plant in floats, the same in Fractions, and a record that fits it exactly."""

    plant: lb.Plant
    model: Model
    y: np.ndarray  # (N, p) of Fractions, None where not measured
    accurate: tuple
    kinds: tuple

    @property
    def record(self):
        """y as floats."""
        return np.array(
            [[np.nan if v is None else float(v) for v in row] for row in self.y]
        ).reshape(self.y.shape)

    def exact(self):
        """The exact estimates."""
        return run(self.model, self.y, accurate=self.accurate)

    def damaged(self, rng):
        """The same with one reading changed by a part of its output's largest."""
        at = np.argwhere(self.y != None)  # noqa: E711, entry by entry
        y = self.y.copy()
        if len(at):
            k, j = at[rng.integers(len(at))]
            largest = max(abs(v) for v in y[:, j] if v is not None)
            y[k, j] += Fraction(int(rng.integers(1, 50)), 100) * largest
        return replace(self, y=y)

    def sensitivity(self, found):
        """How far P moves where P0 grows by 1e-20 of what it is, in each state.

        A state that is known exactly may have an error that grows 200 times a step:
        then rounding becomes a variance too, in any filter that rounds.
        """
        size = (self.plant.P0 + self.plant.Q).diagonal()
        size = np.where(size > 0, size, max(size.max(), 1e-12))
        more = rational(1e-20 * np.diag(size))
        more = self.model._replace(P0=self.model.P0 + more)
        moved = run(more, self.y, accurate=self.accurate)
        return self.errors(*as_floats(moved), found)[1]

    def errors(self, x, P, found):
        """Largest errors of x and P, beside what they were made of.

        The scale of a state is the largest number that went into it.
        """
        want_x, want_P = as_floats(found)
        A, P0, Q = (np.abs(getattr(self.plant, k)) for k in ("A", "P0", "Q"))
        std = np.sqrt(np.maximum(np.diagonal(want_P, axis1=1, axis2=2), 0)).max(axis=0)
        start = np.sqrt(P0.diagonal())
        driven = np.sqrt(Q.diagonal())
        std = np.maximum(std, start) + driven
        std = np.maximum(std, A @ std)
        mean = np.maximum(np.abs(want_x).max(axis=0), np.abs(self.plant.x0))
        mean = np.maximum(mean, A @ mean) + std
        std = np.where(std > 0, std, 1.0)
        mean = np.where(mean > 0, mean, 1.0)
        return np.abs((x - want_x) / mean).max(), np.abs(
            (P - want_P) / np.outer(std, std)
        ).max()


def problem(seed):
    """One random singular problem; the seed says which."""
    return Making(np.random.default_rng(seed)).problem()


class Making:
    """Small numbers, tenths or integers, with the coincidences that hurt."""

    def __init__(self, rng):
        self.rng = rng
        self.n, self.p = int(rng.integers(1, 5)), int(rng.integers(1, 4))
        self.tenths = rng.random() < 0.6
        self.kinds = []

    def numbers(self, *shape, low=-5, high=6):
        X = rational(self.rng.integers(low, high, size=shape).astype(float))
        return X / 10 if self.tenths else X

    def chance(self, kind, odds):
        hit = self.rng.random() < odds
        self.kinds += [kind] * hit
        return hit

    def root(self, rows, kind):
        """A factor of a covariance: none, rank one, some rank, or full."""
        columns = int(self.rng.integers(0, rows + 1))
        if self.chance(f"{kind} = 0", 0.3):
            columns = 0
        elif self.chance(f"{kind} of rank one", 0.4):
            columns = 1
        return self.numbers(rows, columns, low=-3, high=4)

    def problem(self):
        rng, n, p = self.rng, self.n, self.p
        A, C = self.numbers(n, n), self.numbers(p, n)
        if not self.tenths:
            A = A / rng.choice([1, 1, 2, 4])
        if self.chance("unstable", 0.2):
            A = A * 2
        start = self.root(n, "P0")
        if start.size and n > 1:
            h = start[:, 0]
            if self.chance("a row of A annihilates P0", 0.6):
                self.annihilate(A, h)
            if self.chance("a row of C annihilates P0", 0.3):
                self.annihilate(C, A @ h if rng.random() < 0.5 else h)
        joint = self.root(n + p, "joint noise") if self.chance("S", 0.3) else None
        if joint is not None:
            drive, H = joint[:n], joint[n:]
        else:
            G, V = self.root(n, "Q"), self.root(p, "R")
            drive = np.hstack([G, zeros(n, V.shape[1])])
            H = np.hstack([zeros(p, G.shape[1]), V])
            if self.chance("R > 0", 0.4):
                more = rational(np.eye(p)) * Fraction(1, int(10 ** rng.integers(0, 5)))
                H = np.hstack([H, more])
                drive = np.hstack([drive, zeros(n, p)])
        x0 = self.numbers(n) * int(self.chance("x0", 0.5))
        unit = [Fraction(1)] * n
        units = self.chance("units", 0.3)
        if units:
            unit = [Fraction(10) ** int(k) for k in rng.integers(-6, 7, size=n)]
        unit = np.array(unit, dtype=object)
        A, C = unit[:, None] * A / unit, C / unit
        start, drive, x0 = unit[:, None] * start, unit[:, None] * drive, unit * x0
        y = self.record(A, C, start, drive, H, x0)
        given = Model(
            A, zeros(n, 0), C, zeros(p, 0), drive @ drive.T, H @ H.T, drive @ H.T,
            start @ start.T, x0,
        )  # fmt: skip
        accurate = ()
        if not units and self.chance("accurate outputs", 0.3):
            accurate = self.independent(C)
        return Problem(self.plant(given), given, y, accurate, tuple(self.kinds))

    def annihilate(self, X, h):
        """Change a row of X so that it maps h to zero."""
        at = np.flatnonzero([v != 0 for v in h])
        if len(at):
            i, j = self.rng.integers(len(X)), at[-1]
            X[i, j] = -sum(X[i, k] * h[k] for k in range(len(h)) if k != j) / h[j]

    def independent(self, C):
        for size in range(min(len(C), self.n), 0, -1):
            if not solve(C[:size] @ C[:size].T, zeros(0, size))[1].size:
                return tuple(range(size))
        return ()

    def record(self, A, C, start, drive, H, x0):
        """Samples of the model itself, with gaps."""
        rng, steps = self.rng, int(self.rng.integers(2, 8))
        x, noise = x0 + start @ self.numbers(start.shape[1]), None
        y, gaps = np.empty((steps, self.p), dtype=object), self.chance("gaps", 0.5)
        for k in range(steps):
            noise = self.numbers(drive.shape[1]) if noise is None else noise
            x = A @ x + drive @ noise
            noise = self.numbers(drive.shape[1])  # with S it drives x as well
            y[k] = C @ x + H @ noise
            if gaps:
                y[k][rng.random(self.p) < 0.4] = None
        return y

    def plant(self, given):
        """The model in floats; tenths as people write them, 3 * .1 and 0.3."""
        product = self.tenths and self.rng.random() < 0.5

        def floats(X):
            if product and X.size:
                return np.array([float(v * 10) * 0.1 for v in X.flat]).reshape(X.shape)
            return X.astype(float)

        A, B, C, E, Q, R, S, P0, x0 = (floats(X) for X in given)
        return lb.Plant(
            A, None, C, dt=1.0, Q=_even(Q), R=_even(R), S=S, P0=_even(P0), x0=x0
        )


def _even(X):
    return (X + X.T) / 2
