"""Densities of records in rational arithmetic, and models of statsmodels to compare."""

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from exact_filter import rational, zeros
from exact_smoother import product
from statsmodels.tsa.statespace.mlemodel import MLEModel

import luenberger as lb

nan = float("nan")


def nile():
    import statsmodels.datasets.nile as data

    return data.load_pandas().data["volume"].to_numpy(float)


def beside_noises(plant, y):
    """statsmodels' model of a plant, whose noises are states: it has no S itself."""
    n, p, I, O = plant.n, plant.p, np.eye, np.zeros
    Q, R, S = plant.at(0).covariances()
    model = MLEModel(y, k_states=2 * n + p, k_posdef=n + p)
    model["design"] = np.hstack([plant.C, I(p), O((p, n))])
    move = np.hstack([plant.A, O((n, p)), I(n)])
    model["transition"] = np.vstack([move, O((n + p, 2 * n + p))])
    turned = np.block([[O((p, n)), I(p)], [I(n), O((n, p))]])
    model["selection"] = np.vstack([O((n, n + p)), turned])
    model["state_cov"] = np.block([[Q, S], [S.T, R]])
    model.ssm.tolerance = 0
    start = O(2 * n + p), O((2 * n + p, 2 * n + p))
    start[1][n:, n:] = np.block([[R, S.T], [S, Q]])
    return model, start


class Moved(NamedTuple):
    """A matrix of Fractions, and its slope along the way in which a plant moves."""

    X: np.ndarray
    dX: np.ndarray

    @property
    def T(self):
        return Moved(self.X.T, self.dX.T)

    def __matmul__(self, other):
        X, dX = self
        slope = product(dX, other.X) + product(X, other.dX)
        return Moved(product(X, other.X), slope)

    def __add__(self, other):
        return Moved(self.X + other.X, self.dX + other.dX)

    def part(self, *index):
        return Moved(*(Z[np.ix_(*index)] for Z in self))


def stacked(blocks):
    """A matrix of blocks."""
    return Moved(
        *(np.block([[one[k] for one in row] for row in blocks]) for k in (0, 1))
    )


def exact_moments(plant, y, u, u0, move=None, start=False):
    """The covariance of a record, entry by entry, and the record less its mean.

    `move` is {name: direction}, along which both have slopes.  With `start` the mean
    of the start is unknown, and columns beside the record say what it does.
    """
    N, (n, p, m), move = len(y), (plant.n, plant.p, plant.m), move or {}

    def matrix(name, i, size):
        X = getattr(plant, name)
        X = np.zeros(size) if X is None else X[i] if X.ndim == 3 else X
        D = move.get(name, np.zeros(size))
        D = D[i] if np.ndim(D) == 3 else D
        return Moved(*(rational(Z).reshape(size) for Z in (X, D)))

    def alone(X):
        """What does not hang on the start."""
        X = np.hstack([X, np.zeros((len(X), n * start))])
        return Moved(rational(X), zeros(*X.shape))

    sizes = dict(A=(n, n), B=(n, m), C=(p, n), E=(p, m), Q=(n, n), R=(p, p), S=(n, p))
    mean, V = matrix("x0", 0, (n, 1)), matrix("P0", 0, (n, n))
    if start:
        mean = alone(np.zeros((n, 1)))
        mean.X[:, 1:] = rational(np.eye(n))
    inputs = np.vstack([[u0], u])
    none = Moved(zeros(0, n), zeros(0, n))
    rows = none  # of the outputs so far, cross covariances with the state
    joint, left = Moved(zeros(0, 0), zeros(0, 0)), []
    for i in range(N + 1):
        now = {k: matrix(k, i, size) for k, size in sizes.items()}
        ui = alone(inputs[i][:, None])
        after = rows @ now["A"].T
        if i:
            seen = np.flatnonzero(~np.isnan(y[i - 1]))
            C, E = now["C"].part(seen, range(n)), now["E"].part(seen, range(m))
            R, S = now["R"].part(seen, seen), now["S"].part(range(n), seen)
            cross = rows @ C.T
            joint = stacked([[joint, cross], [cross.T, C @ V @ C.T + R]])
            expected = C @ mean + E @ ui
            values = alone(y[i - 1, seen][:, None])
            left.append([Moved(values.X - expected.X, -expected.dX)])
            after = stacked([[after], [C @ V @ now["A"].T + S.T]])
        rows = after
        if plant.at_first and i == 0:
            rows = none
            continue
        mean = now["A"] @ mean + now["B"] @ ui
        V = now["A"] @ V @ now["A"].T + now["Q"]
    return joint, stacked(left)


def free_moments(V, d):
    """The moments of those entries that the ones before do not determine.

    The others must agree with the ones before.
    """
    free, work, left = [], V.X.copy(), d.X[:, :1].copy()
    for k in range(len(work)):
        if work[k, k] == 0:
            assert left[k] == 0
            continue
        free.append(k)
        share = work[k + 1 :, k : k + 1] / work[k, k]
        work[k + 1 :] = work[k + 1 :] - share * work[k]
        left[k + 1 :] = left[k + 1 :] - share * left[k]
    return V.part(free, free), d.part(free, range(len(d.X.T)))


def inverse(V):
    """The inverse of a definite matrix, and its determinant."""
    n, det = len(V), Fraction(1)
    work = np.hstack([V, rational(np.eye(n))])
    for k in range(n):
        det *= work[k, k]
        work[k] = work[k] / work[k, k]
        for j in range(n):
            if j != k:
                work[j] = work[j] - work[j, k] * work[k]
    return work[:, n:], det


def density(V, d):
    """The log density and its slope, of those entries that have a density."""
    (V, dV), (d, dd) = free_moments(V, d)
    W, det = inverse(V)
    e = product(W, d)
    value = -(len(d) * np.log(2 * np.pi) + np.log(float(det))) / 2
    value -= float(product(d.T, e)[0, 0]) / 2
    slope = product(e.T, dV, e)[0, 0] / 2 - (W * dV.T).sum() / 2
    return value, float(slope - product(e.T, dd)[0, 0])


def rational_plant(kind):
    """Small plants of whole numbers, with records."""
    given = dict(dt=1.0, P0=[[2, 1], [1, 3]], x0=[1, -1], Q=[[2, 1], [1, 1]], R=[[1]])
    A, B, C, E = [[1, 1], [0, 0.5]], [[0], [1]], [[1, 0]], [[0.5]]
    if kind == "unstable":
        A = [[2, 1], [-1, 1.5]]
    elif kind == "singular A":
        A = [[0, 1], [0, 0]]
    elif kind == "S":
        given |= dict(S=[[0.5], [0.25]])
    elif kind == "prior":
        given |= dict(at_first=True)
    elif kind == "perfect":
        given |= dict(R=[[0]])
    elif kind in ("two", "gaps", "one perfect", "determined"):
        C, E = [[1, 0], [0.5, 1]], [[0.5], [0]]
        given |= dict(R=[[1, 0.5], [0.5, 2]], S=[[0.5, 0], [0, 0.25]])
        if kind == "one perfect":
            given |= dict(R=[[0, 0], [0, 2]], S=None)
        if kind == "determined":
            C, E = [[1, 0], [2, 0]], [[0.5], [1]]
            given |= dict(R=[[0, 0], [0, 0]], S=None)
    plant = lb.Plant(A, B, C, E, **given)
    y = np.array([[1.0, 2], [0.5, 1], [2, 4], [-1, -2]])[:, : plant.p]
    if kind == "gaps":
        y[[0, 1, 1, 3], [1, 0, 1, 0]] = nan
    return plant, y, np.array([[1.0], [0], [2], [-1]]), np.array([0.5])


KINDS = (
    "plain", "unstable", "singular A", "S", "prior", "perfect", "two", "gaps",
    "one perfect", "determined",
)  # fmt: skip


def direction(plant, name):
    """A direction with small whole numbers in every entry, symmetric where it must."""
    X = getattr(plant, name)
    D = np.arange(1, X.size + 1).reshape(X.shape) % 5 - 1.0
    return D + D.T if name in ("Q", "R", "P0") else D


SCORED = [
    (kind, name)
    for kind in KINDS
    for name in ("A", "B", "C", "E", "Q", "R", "S", "x0", "P0")
    if name != "S" or kind in ("S", "two", "gaps")
    if not (kind == "determined" and name in ("C", "E", "R"))
    if not (kind == "one perfect" and name == "R" or kind == "perfect" and name == "R")
]
