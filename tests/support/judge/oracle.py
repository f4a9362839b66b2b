"""Estimates and densities by elimination in one joint covariance of a whole record.

All states and readings of a record are combinations of independent sources, so their
joint covariance is one matrix of Fractions.  Eliminating a reading from it conditions
the others on that reading.  No recursion of covariances, no gain, no tolerance; whole
numbers by Bareiss, whose divisions leave no remainder.
"""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from exact_filter import J_of, gamma_of, solve, zeros
from exact_smoother import product


class Answer(NamedTuple):
    """Rows (N, n) and (N, n, n) of floats, the likelihood, and what is contradicted.

    `likelihood` is (value, what its terms add up to, how far rounding may move it);
    `first` is the first row that contradicts the ones before, with the exact size of
    what is left there beside what the reading is made of, or None.
    """

    x: np.ndarray
    P: np.ndarray
    smooth_x: np.ndarray
    smooth_P: np.ndarray
    terms: list
    determined: tuple  # readings (row, output) that earlier ones determine
    first: tuple | None
    gram: np.ndarray | None


def sources(p):
    """x (N, n, s) as combinations of sources, and the mean of each without readings."""
    N, q, r = len(p.y), p.W[0].shape[1], p.start.shape[1]
    X, mean = np.hstack([p.start, zeros(len(p.x0), (N + 1) * q)]), p.x0
    rows, means = [], []
    for k in range(N):
        if k or not p.prior:
            X = product(p.A[k], X) if X.size else X
            X[:, slot(r, q, k)] = X[:, slot(r, q, k)] + p.W[k]
            mean = p.A[k] @ mean + p.B[k] @ p.u[k]
        rows.append(X.copy())
        means.append(mean)
    return rows, means


def slot(r, q, k):
    return slice(r + k * q, r + (k + 1) * q)


def reading(p, X, k):
    """The outputs of row k as combinations of sources."""
    Y = product(p.C[k + 1], X) if X.size else p.C[k + 1] @ X
    at = slot(p.start.shape[1], p.W[0].shape[1], k + 1)
    Y[:, at] = Y[:, at] + p.H[k + 1]
    return Y


def in_order(p):
    """The readings (row, output) in the order in which they become known."""
    at = [tuple(map(int, one)) for one in np.argwhere(p.y != None)]  # noqa: E711
    late = p.arrival
    return at if late is None else sorted(at, key=lambda one: (late[one], *one))


def whole(M):
    """Rows of Fractions as whole numbers, and what each row was multiplied by."""
    by = [math.lcm(*(v.denominator for v in row)) for row in M]
    return np.array([[int(v * d) for v in row] for row, d in zip(M, by)], object), by


def answer(p, skip=(), start=False):
    """The `Answer` to a problem; readings in `skip` are left out.

    With `start` nothing is known of the state of the first row: its mean is unknown,
    in columns beside the readings, and `gram` says what the record tells of it.
    """
    (N, _), n = p.y.shape, len(p.x0)
    rows, means = sources(p)
    order = in_order(p)
    shown = {k: reading(p, X, k) for k, X in enumerate(rows)}
    known = [p.C[k + 1] @ means[k] + p.E[k + 1] @ p.u[k + 1] for k in range(N)]
    left = [p.y[k, j] - known[k][j] for k, j in order]
    L = np.array([shown[k][j] for k, j in order] + [x for X in rows for x in X], object)
    L, by = whole(L.reshape(len(order) + N * n, -1))
    states = len(order)
    beside = [[v] for v in left] + [[Fraction(0)]] * (N * n)
    if start:  # the sources of the start, of variance 1, are the columns of its mean
        beside = [[*b, *(Fraction(v, d) for v in row[:n])] for b, row, d in
                  zip(beside, L, by)]  # fmt: skip
    border = len(beside[0])
    G = np.array([[v * d for v in b] for b, d in zip(beside, by)], object)
    G, of = whole(G.T)
    size = len(L)
    M = np.zeros((size + border, size + border), dtype=object)
    M[:size, :size] = L @ L.T
    M[:size, size:], M[size:, :size] = G.T, G
    by, last = by + of, 1  # an entry stands for M / (last * by * by)
    x, P = [], []
    terms, determined, first = [], [], None

    def moments(k):
        here = [states + k * n + i for i in range(n)]
        down = [Fraction(-M[i, size], last * by[i] * by[size]) for i in here]
        x = [float(a + b) for a, b in zip(means[k], down)]
        P = [[M[i, j] / (last * by[i] * by[j]) for j in here] for i in here]
        return x, P

    todo = list(enumerate(order))
    for k in range(N):
        while todo and (p.arrival is None or p.arrival[todo[0][1]] <= k):
            i, (row, j) = todo[0]
            if row > k:
                break
            todo.pop(0)
            if (row, j) in skip:
                continue
            if M[i, i] == 0:
                determined.append((row, j))
                gap = Fraction(M[i, size], last * by[i] * by[size])
                if gap and first is None:
                    first = row, j, abs(float(gap))
                continue
            s = Fraction(M[i, i], last * by[i] ** 2)
            nu = Fraction(M[i, size], last * by[i] * by[size])
            terms.append((row, j, s, nu))
            M, last = (M * M[i, i] - np.outer(M[:, i], M[i])) // last, M[i, i]
        for rows_, one in zip((x, P), moments(k)):
            rows_.append(one)
    ends = [moments(k) for k in range(N)]
    smooth = [np.array(part, float) for part in zip(*ends)]
    gram = None
    if start:
        scale = np.array(by[size:], dtype=object)
        scale = last * np.outer(scale, scale)
        gram = np.array([Fraction(-v, w) for v, w in zip(M[size:, size:].flat,
                        scale.flat)], object).reshape(border, border)  # fmt: skip
    return Answer(
        np.array(x), np.array(P, float), *smooth, terms, tuple(determined), first, gram
    )


def log(v):
    """The logarithm of a positive Fraction of any size."""
    return math.log(v.numerator) - math.log(v.denominator)


def likelihood(found):
    """The log density, and what its terms are in size."""
    parts = [(log(s) + math.log(2 * math.pi), float(nu * nu / s))
             for *_, s, nu in found.terms]  # fmt: skip
    return -sum(map(sum, parts)) / 2, sum(abs(a) + b for a, b in parts) / 2


def integrated(found):
    """The same, integrated over a start of which nothing is known; None if it is not
    determined."""
    value, size = likelihood(found)
    T, det = found.gram.copy(), Fraction(1)
    for k in reversed(range(1, len(T))):
        if T[k, k] == 0:
            return None
        det *= T[k, k]
        T[:k, :k] = T[:k, :k] - np.outer(T[:k, k], T[k, :k]) / T[k, k]
    n, fitted = len(T) - 1, float(found.gram[0, 0] - T[0, 0])
    more = (fitted + n * math.log(2 * math.pi) - log(det)) / 2
    return value + more, size + abs(more)


def accurate(p):
    """x, P, first of the filter that takes some outputs at their word, as `Answer` has.

    Its error is a combination of sources, row by row: the gain is that of least squares
    from these, Gamma and J are as the paper defines them.
    """
    rows, _ = sources(p)
    n, (N, _) = len(p.x0), p.y.shape
    r, q = p.start.shape[1], p.W[0].shape[1]
    off, x = zeros(*rows[0].shape), p.x0
    off[:, :r] = p.start
    J, seen, rho = zeros(n, 0), [], zeros(0)
    found, first = ([], []), None
    for k in range(N):
        if k or not p.prior:
            noise = J @ p.H[k][seen]
            off = p.A[k] @ off - J @ (p.C[k][seen] @ off)
            off[:, slot(r, q, k)] = off[:, slot(r, q, k)] + p.W[k] - noise
            x = p.A[k] @ x + p.B[k] @ p.u[k] + J @ rho
        seen = [j for j, v in enumerate(p.y[k]) if v is not None]
        C, H = p.C[k + 1][seen], p.H[k + 1][seen]
        known = p.y[k, seen] - p.E[k + 1][seen] @ p.u[k + 1]
        Z = C @ off
        Z[:, slot(r, q, k + 1)] = Z[:, slot(r, q, k + 1)] + H
        K, null = solve(Z @ Z.T, off @ Z.T)
        gaps = [abs(float(v)) for v in null.T @ (known - C @ x)]
        if first is None and max(gaps, default=0):
            first = k, seen[int(np.argmax(null[:, np.argmax(gaps)] != 0))], max(gaps)
        Gamma = gamma_of(C, np.isin(seen, p.accurate))
        K = K + Gamma - Gamma @ (C @ K)
        off, x = off - K @ Z, x + K @ (known - C @ x)
        rho, J = known - C @ x, J_of(p.W[k + 1] @ H.T, H @ H.T)
        found[0].append(x.astype(float))
        found[1].append((off @ off.T).astype(float))
    return np.array(found[0]), np.array(found[1]), first
