"""Answers in rational arithmetic: no rounding, no tolerance, and another way there.

Every oracle reads the floats of a plant and an observer as the fractions that they
are.  What it returns is exact: arrays of Fractions, to be compared with floats by
`off`.  Covariances come from the joint recursion of plant state and observer state,
    [x; z]+ = [[A, 0], [D C, F]] [x; z] + [[I, 0], [0, D]] [w; v],
    e = (V C - L) x + P z + V v,
which needs neither T nor a certificate, and so shares no formula with the library.
The known input is zero throughout.
"""

from fractions import Fraction
from typing import NamedTuple

import mpmath
import numpy as np
from generators import rational

from luenberger.certificate import residuals

# -- linear algebra -------------------------------------------------------------------


def eye(n):
    return rational(np.eye(n))


def zeros(*shape):
    return rational(np.zeros(shape))


def solve(A, B):
    """X with A X = B, by Gauss and Jordan."""
    n = len(A)
    M = np.hstack([A, B])
    for k in range(n):
        pivot = k + next(i for i, a in enumerate(M[k:, k]) if a != 0)
        M[[k, pivot]] = M[[pivot, k]]
        M[k] = M[k] / M[k, k]
        for i in range(n):
            if i != k and M[i, k] != 0:
                M[i] = M[i] - M[i, k] * M[k]
    return M[:, n:]


def stein(maps, N):
    """The symmetric X = sum M X M' + N, as one linear system in its lower half."""
    n = len(N)
    places = [(i, j) for i in range(n) for j in range(i + 1)]
    system = zeros(len(places), len(places))
    for column, (i, j) in enumerate(places):
        unit = zeros(n, n)
        unit[i, j] = unit[j, i] = Fraction(1)
        left = unit - sum(M @ unit @ M.T for M in maps)
        system[:, column] = [left[place] for place in places]
    found = solve(system, np.array([[N[place]] for place in places]))
    X = zeros(n, n)
    for (i, j), value in zip(places, found[:, 0]):
        X[i, j] = X[j, i] = value
    return X


def is_semidefinite(X):
    """Whether a symmetric X has no negative eigenvalue, by L D L'."""
    while len(X):
        pivot, column, rest = X[0, 0], X[1:, 0], X[1:, 1:]
        if pivot < 0 or (pivot == 0 and column.any()):
            return False
        X = rest - np.outer(column, column) / pivot if pivot else rest
    return True


def size(X):
    """Frobenius norm; the square root is the one step that rounds."""
    return float(sum((value * value for value in X.flat), Fraction(0))) ** 0.5


def off(found, exact):
    """How far floats are from an exact matrix, relative to its size.

    0 where both are zero; inf where only the exact one is.
    """
    gap, scale = size(rational(found) - exact), size(exact)
    return gap / scale if scale else (np.inf if gap else 0.0)


def off_units(found, exact):
    """As `off` for a covariance, each entry beside its two standard deviations.

    So a state in metres is judged as one in light years.
    """
    variances = [float(v) for v in exact.diagonal()]
    unit = np.sqrt([v if v > 0 else 1.0 for v in variances])
    gap = (rational(found) - exact).astype(float)
    return float(np.abs(gap / unit / unit[:, None]).max())


# -- certificates ---------------------------------------------------------------------


class Residuals(NamedTuple):
    """Relative residuals of the four equations of an observer, exactly evaluated."""

    dynamics: float  # T+ A - F T - D C
    input: float  # T+ B - G - D E
    output: float  # P T + V C - L
    feedthrough: float  # W + V E


def certificate(observer, plant):
    """The equations of an observer on the floats it has, the worst row of each."""
    o, L = observer, rational(observer.L)
    rows = range(o.steps or 1)
    worst = np.zeros(4)
    for k in rows:
        F, G, D, P, V, W = (rational(X) for X in o.at(k))
        T, T_next = (rational(_row(o.T, i)) for i in (k, min(k + 1, rows[-1])))
        A, B, C, E = (rational(X) for X in plant.at(k + 1)[:4])
        found = residuals(A, B, C, E, L, F, G, D, P, V, W, T, T_next)
        A, B, C, E, F, G, D, P, V, W, T, T_next = (
            size(X) for X in (A, B, C, E, F, G, D, P, V, W, T, T_next)
        )
        terms = (
            T_next * (A + (plant.dt > 0)) + F * T + D * C,
            T_next * B + G + D * E,
            P * T + V * C + size(L),
            W + V * E,
        )
        relative = [size(X) / term if X.any() else 0.0 for X, term in zip(found, terms)]
        worst = np.maximum(worst, relative)
    return Residuals(*worst)


def _row(X, k):
    return X if X.ndim == 2 else X[k]


# -- error covariances ----------------------------------------------------------------


class Joint:
    """Plant state and observer state together at one instant, for u = 0."""

    def __init__(self, observer, plant, instant=0, row=0):
        F, _, D, P, V, _ = (rational(X) for X in observer.at(row))
        A, _, C, _, Q, R, S = plant.at(instant)
        S = np.zeros((plant.n, plant.p)) if S is None else S
        A, C, Q, R, S = (rational(X) for X in (A, C, Q, R, S))
        n, r = plant.n, observer.order
        self.map = np.block([[A, zeros(n, r)], [D @ C, F]])
        self.error, self.V, self.R = np.hstack([V @ C - rational(observer.L), P]), V, R
        self.noise = np.block([[Q, S @ D.T], [D @ S.T, D @ R @ D.T]])
        self.also, self.heard = [], []  # what multiplicative noise adds to the two
        for A1, C1 in plant.multiplicative:
            A1, C1 = rational(A1), rational(C1)
            self.also.append(np.hstack([np.vstack([A1, D @ C1]), zeros(n + r, r)]))
            self.heard.append(np.hstack([V @ C1, zeros(len(V), r)]))

    def moved(self, X):
        """E[s s'] one instant later."""
        maps = [self.map, *self.also]
        return sum((M @ X @ M.T for M in maps), self.noise)

    def seen(self, X):
        """E[e e'] where E[s s'] is X."""
        maps = [self.error, *self.heard]
        return sum((M @ X @ M.T for M in maps), self.V @ self.R @ self.V.T)


def steady_moments(observer, plant):
    """E[s s'] of s = [x; z] in the steady state; plant and observer are stable."""
    joint = Joint(observer, plant)
    return stein([joint.map, *joint.also], joint.noise)


def steady_error(observer, plant):
    """E[e e'] in the steady state, of a plant that is stable."""
    return Joint(observer, plant).seen(steady_moments(observer, plant))


def steady_error_alone(observer, plant):
    """E[e e'] in the steady state, of a plant that need not be stable.

    For an observer that meets its equations exactly, in fractions: then the error of z
    obeys eps+ = F eps + D v - T w, e = P eps + V v.
    """
    assert max(certificate(observer, plant)) == 0.0
    F, _, D, P, V, _ = (rational(X) for X in observer.at(0))
    now, T = plant.at(0), rational(observer.T)
    Q, R = rational(now.Q), rational(now.R)
    S = zeros(plant.n, plant.p) if now.S is None else rational(now.S)
    cross = T @ S @ D.T
    X = stein([F], T @ Q @ T.T + D @ R @ D.T - cross - cross.T)
    return P @ X @ P.T + V @ R @ V.T


def error_over(observer, plant, steps):
    """E[e e'] in the rows that `error_covariance` has for `steps`."""
    mean, spread = rational(plant.x0), rational(plant.P0)
    out, rows = [], range(steps + 1)
    if observer.steps is not None:
        L = rational(observer.L)
        out, rows = [L @ spread @ L.T], range(steps)
        if not plant.at_first:
            A, Q = (rational(getattr(plant.at(0), name)) for name in "AQ")
            moment = spread + np.outer(mean, mean)
            for A1, _ in plant.multiplicative:
                Q = Q + rational(A1) @ moment @ rational(A1).T
            mean, spread = A @ mean, A @ spread @ A.T + Q
    start = np.concatenate([mean, rational(observer.z0)])
    X = np.outer(start, start)
    X[: plant.n, : plant.n] += spread
    for k in rows:
        joint = Joint(observer, plant, k + (observer.steps is not None), k)
        out.append(joint.seen(X))
        X = joint.moved(X)
    return out


# -- gains ----------------------------------------------------------------------------


def best_gain(plant, Sigma, accurate=(), weight=None):
    """The gain of least tr(weight Sigma+) after Sigma, with C1 K = [I 0].

    The error before the sample has covariance Omega; the innovation's is invertible.
    """
    A, _, C, _, Q, R, S = plant.at(0)
    S = np.zeros((plant.n, plant.p)) if S is None else S
    A, C, Q, R, S = (rational(X) for X in (A, C, Q, R, S))
    if S.any():
        J = solve(R, S.T).T
        A, Q = A - J @ C, Q - J @ S.T
    Omega = A @ Sigma @ A.T + Q
    K = solve(C @ Omega @ C.T + R, C @ Omega).T
    C1 = C[list(accurate)]
    if len(C1):
        W = eye(plant.n) if weight is None else rational(weight)
        spread = solve(W, C1.T)
        Gamma = solve(C1 @ spread, spread.T).T
        K = K + Gamma @ (eye(plant.p)[list(accurate)] - C1 @ K)
    return K


# -- smoothing ------------------------------------------------------------------------


def smoothed(plant, y, u=None, u0=None):
    """E[x | all of y] and its covariance at every instant 1 .. N of a record.

    Batch least squares: all states and noises of the record are one Gaussian vector,
    and each number that was measured is a combination of them that is known.  A
    measurement of variance zero must agree, and says nothing.
    """
    n, p, N = plant.n, plant.p, len(y)
    u = rational(np.vstack([np.zeros(plant.m) if u0 is None else u0,
                            np.zeros((N, plant.m)) if u is None else u]))  # fmt: skip
    first = 0 if not plant.at_first else 1
    spreads = [rational(plant.P0)]  # of x at the first instant, then of each [w; v]
    for i in range(first, N + 1):
        now = plant.at(i)
        S = np.zeros((n, p)) if now.S is None else now.S
        spreads.append(rational(np.block([[now.Q, S], [S.T, now.R]])))
    ends = np.cumsum([0, *(len(X) for X in spreads)])
    spread = zeros(ends[-1], ends[-1])
    for a, b, X in zip(ends, ends[1:], spreads):
        spread[a:b, a:b] = X
    source = zeros(ends[-1])  # means of the sources
    state, offset = zeros(n, ends[-1]), rational(plant.x0)  # x = state source + offset
    state[:, :n] = eye(n)
    states = []
    for i in range(first, N + 1):
        A, B, C, E = (rational(X) for X in plant.at(i)[:4])
        w, v = np.split(np.arange(ends[i - first + 1], ends[i - first + 2]), [n])
        if i:
            states.append((state, offset))
            for j in np.flatnonzero(~np.isnan(y[i - 1])):
                row = C[j] @ state
                row[v[j]] += 1
                known = rational(y[i - 1][j : j + 1])[0] - C[j] @ offset - E[j] @ u[i]
                gap, told = known - row @ source, spread @ row
                variance = row @ told
                if variance == 0:
                    assert gap == 0, "the record contradicts itself"
                    continue
                source = source + told * (gap / variance)
                spread = spread - np.outer(told, told) / variance
        state, offset = A @ state, A @ offset + B @ u[i]
        state[:, w] += eye(n)
    means = [H @ source + one for H, one in states]
    return np.array(means), np.array([H @ spread @ H.T for H, _ in states])


# -- Riccati equations ----------------------------------------------------------------


def riccati(A, C, Q, R, S=None, digits=60):
    """X = A X A' - (A X C' + S)(C X C' + R)^-1 (A X C' + S)' + Q to many digits.

    By doubling: each step does the work of as many steps of the recursion as all
    before it.  (E. K.-W. Chu et al., Int. J. Control 77 (2004) 767-788.)  R is
    invertible.
    """
    with mpmath.workdps(digits + 20):
        A, C, Q, R = (mpmath.matrix(np.atleast_2d(X).tolist()) for X in (A, C, Q, R))
        S = mpmath.zeros(A.rows, C.rows) if S is None else mpmath.matrix(S.tolist())
        one, back = mpmath.eye(A.rows), R**-1
        A, X, G = (A - S * back * C).T, Q - S * back * S.T, C.T * back * C
        for _ in range(100):
            W = (one + G * X) ** -1
            more = A.T * X * W * A
            A, X, G = A * W * A, X + more, G + A * W * G * A.T
            if mpmath.norm(more) <= mpmath.norm(X) * mpmath.mpf(10) ** -digits:
                return np.array(X.tolist(), dtype=float)
    raise AssertionError("doubling has not settled; is there a stable filter?")
