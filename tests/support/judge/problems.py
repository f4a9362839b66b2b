"""Random problems in Fractions, of all the kinds that hurt; a seed says which one."""

from dataclasses import dataclass, replace
from fractions import Fraction

import exact_filter
import numpy as np
from exact_filter import rational, zeros

SEVERAL = "A B C E W H".split()


@dataclass(frozen=True)
class Problem:
    """x+ = A x + B u + W e,  y = C x + E u + H e, with e independent and of variance 1.

    A to H are lists, one for each instant 0 .. N; row k of y is instant k + 1.
    x = x0 + start e0 is the state at instant 0, or at instant 1 where `prior`.
    """

    A: list
    B: list
    C: list
    E: list
    W: list
    H: list
    start: np.ndarray
    x0: np.ndarray
    prior: bool
    u: np.ndarray  # (N + 1, m), of which the first is u0
    y: np.ndarray  # (N, p), None where not measured
    unit: np.ndarray  # (n,) in which the states are small numbers
    accurate: tuple = ()  # outputs that are taken at their word
    arrival: np.ndarray | None = None  # (N, p) rows
    unknown: bool = False  # also: the likelihood if nothing is known of the start
    varying: bool = False
    product: bool = False  # floats as people compute them: 3 * .1 for 0.3
    kinds: tuple = ()

    @property
    def record(self):
        """y as floats, in which NaN was not measured."""
        found = [[np.nan if v is None else float(v) for v in row] for row in self.y]
        return np.array(found).reshape(self.y.shape)

    def plain(self, X):
        """Fractions as the floats that somebody would write."""
        if self.product and X.size:
            return np.array([float(v * 10) * 0.1 for v in X.flat]).reshape(X.shape)
        return X.astype(float)

    def matrices(self):
        """A, B, C, E, and Q, R, S, P0, x0, prior by name, as floats."""
        W, H = self.W, self.H
        several = [getattr(self, name) for name in "ABCE"] + [
            [X @ Y.T for X, Y in zip(*pair)] for pair in ((W, W), (H, H), (W, H))
        ]
        A, B, C, E, Q, R, S = (
            np.array([self.plain(X) for X in all_]) if self.varying
            else self.plain(all_[0])
            for all_ in several
        )  # fmt: skip
        given = dict(Q=Q, R=R, S=S if "S" in self.kinds else None)
        P0 = self.plain(self.start @ self.start.T)
        given |= dict(P0=P0, x0=self.plain(self.x0), prior=self.prior)
        return (A, B, C, E), given

    def damaged(self, rng):
        """The same with one reading changed by a part of its output's largest."""
        at = np.argwhere(self.y != None)  # noqa: E711, entry by entry
        if not len(at):
            return self
        y, (k, j) = self.y.copy(), at[rng.integers(len(at))]
        largest = max(abs(v) for v in y[:, j] if v is not None)
        y[k, j] += Fraction(int(rng.integers(1, 50)), 100) * (largest or 1)
        return replace(self, y=y, arrival=None)

    def shaken(self, by):
        """The same with a little more noise: by (N + 1, n) deviations at each instant.

        What this moves, rounding moves too, in any filter that rounds.
        """
        W = [np.hstack([X, rational(np.diag(d))]) for X, d in zip(self.W, by)]
        H = [np.hstack([X, zeros(*X.shape[:1], len(by[0]))]) for X in self.H]
        start = np.hstack([self.start, rational(np.diag(by[0]))])
        return replace(self, W=W, H=H, start=start)


class Drawing(exact_filter.Making):
    """Small numbers with coincidences: see `exact_filter.Making`."""

    def drawn(self):
        rng = self.rng
        lost = self.chance("long gap", 0.06)
        if lost:
            self.n, self.p, self.tenths = min(self.n, 2), 1, False
        n, p = self.n, self.p
        m = int(self.chance("inputs", 0.25))
        N = int(rng.integers(8, 14)) if lost else int(rng.integers(2, 7))
        varying = self.chance("varying", 0.2)
        A, B = self.numbers(n, n), self.numbers(n, m)
        C, E = self.numbers(p, n), self.numbers(p, m)
        if not self.tenths:
            A = A / int(rng.choice([1, 1, 2, 4]))
        if lost or self.chance("unstable", 0.2):
            A = A * 2
        start = self.root(n, "P0")
        if start.size and n > 1:
            h = start[:, 0]
            if self.chance("A annihilates P0", 0.4):
                self.annihilate(A, h)
            if self.chance("C annihilates P0", 0.2):
                self.annihilate(C, A @ h if rng.random() < 0.5 else h)
        W, H = self.noises()
        parts = [[X] * (N + 1) for X in (A, B, C, E, W, H)]
        if varying:
            parts = [[self.another(X) for X in all_] for all_ in parts]
        x0 = self.numbers(n) * int(self.chance("x0", 0.5))
        unit, of = np.array([Fraction(1)] * n), np.array([Fraction(1)] * p)
        if self.chance("units 2^-30 to 2^30", 0.25):
            unit, of = (
                np.array([Fraction(2) ** int(e) for e in rng.integers(-30, 31, size)])
                for size in (n, p)
            )
        left = unit[:, None], unit[:, None], of[:, None], of[:, None]
        left += unit[:, None], of[:, None]
        right = unit, Fraction(1), unit, Fraction(1), Fraction(1), Fraction(1)
        parts = [[a * X / b for X in all_] for a, all_, b in zip(left, parts, right)]
        start, x0 = unit[:, None] * start, unit * x0
        prior = self.chance("P0 of the first row", 0.3)
        given = Problem(
            *parts, start, x0, prior, self.numbers(N + 1, m), np.zeros((N, p)), unit,
            varying=varying, product=self.tenths and rng.random() < 0.5,
        )  # fmt: skip
        given = replace(given, y=self.sample(given, lost))
        if (unit == 1).all() and not varying and self.chance("m1", 0.25):
            given = replace(given, accurate=self.independent(C))
        elif not lost and self.chance("late", 0.1):
            late = rng.integers(0, 3, given.y.shape)
            given = replace(given, arrival=np.arange(N)[:, None] + late)
        unknown = self.chance("unknown start", 0.25)
        return replace(given, unknown=unknown, kinds=tuple(self.kinds) or ("plain",))

    def noises(self):
        """W and H: factors of [[Q, S], [S', R]] of any rank."""
        rng, n, p = self.rng, self.n, self.p
        if self.chance("S", 0.25):
            joint = self.root(n + p, "joint noise")
            return joint[:n], joint[n:]
        G, V = self.root(n, "Q"), self.root(p, "R")
        if not V.size and self.chance("R > 0", 0.6):
            self.kinds = [kind for kind in self.kinds if kind != "R = 0"]
            V = rational(np.eye(p)) * Fraction(1, int(10 ** rng.integers(0, 5)))
        return np.hstack([G, zeros(n, V.shape[1])]), np.hstack([zeros(p, len(G.T)), V])

    def another(self, X):
        """What X is at another instant: the same, or twice or half of some columns."""
        return X * self.rng.choice([1, 1, 2], X.shape[1]) / int(self.rng.choice([1, 2]))

    def sample(self, given, lost):
        """Readings of the model itself, with gaps."""
        rng, N = self.rng, len(given.y)
        x = given.x0 + given.start @ self.numbers(given.start.shape[1])
        e, y = self.numbers(given.W[0].shape[1]), np.empty(given.y.shape, dtype=object)
        gaps = not lost and self.chance("gaps", 0.5)
        for k in range(N):
            if k or not given.prior:
                x = given.A[k] @ x + given.B[k] @ given.u[k] + given.W[k] @ e
            e = self.numbers(len(e))
            y[k] = given.C[k + 1] @ x + given.E[k + 1] @ given.u[k + 1]
            y[k] = y[k] + given.H[k + 1] @ e
            y[k, (rng.random(self.p) < 0.4) & gaps] = None
        if lost:
            y[2 : int(rng.integers(4, N))] = None
        return y


def problem(seed):
    """The problem of a seed."""
    return Drawing(np.random.default_rng([32, seed])).drawn()
