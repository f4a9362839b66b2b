"""Densities of records in rational arithmetic, and models of statsmodels to compare."""

from fractions import Fraction

import numpy as np
import sympy as sp
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


def exact_moments(plant, y, u, u0, move=None, start=None):
    """The covariance of a record, entry by entry, and the record less its mean.

    `move` is {name: direction}: all moves with a symbol t.  `start` are symbols for
    the mean of the start.
    """
    t = sp.Symbol("t")
    N, (n, p, m) = len(y), (plant.n, plant.p, plant.m)

    def matrix(name, i, size):
        X = getattr(plant, name)
        X = np.zeros(size) if X is None else X[i] if X.ndim == 3 else X
        found = sp.Matrix(*size, [sp.Rational(Fraction(v)) for v in X.ravel()])
        if move and name in move:
            D = move[name][i] if np.ndim(move[name]) == 3 else move[name]
            found += t * sp.Matrix(*size, [sp.Rational(Fraction(v)) for v in D.ravel()])
        return found

    sizes = dict(A=(n, n), B=(n, m), C=(p, n), E=(p, m), Q=(n, n), R=(p, p), S=(n, p))
    mean, V = matrix("x0", 0, (n, 1)), matrix("P0", 0, (n, n))
    mean = sp.Matrix(start) if start else mean
    inputs = np.vstack([[u0], u])
    rows = sp.zeros(0, n)  # of the outputs so far, cross covariances with the state
    means, joint, values = [], sp.zeros(0, 0), []
    for i in range(N + 1):
        now = {k: matrix(k, i, size) for k, size in sizes.items()}
        ui = sp.Matrix(m, 1, [sp.Rational(Fraction(v)) for v in inputs[i]])
        after = rows * now["A"].T
        if i:
            seen = [k for k in range(p) if not np.isnan(y[i - 1, k])]
            C, E = now["C"][seen, :], now["E"][seen, :]
            R, S = now["R"][seen, seen], now["S"][:, seen]
            cross = rows * C.T
            joint = sp.Matrix(
                sp.BlockMatrix([[joint, cross], [cross.T, C * V * C.T + R]])
            )
            means += list(C * mean + E * ui)
            values += [sp.Rational(Fraction(v)) for v in y[i - 1, seen]]
            after = after.col_join(C * V * now["A"].T + S.T)
        rows = after
        if plant.P0_is == "prior" and i == 0:
            rows = sp.zeros(0, n)
            continue
        mean = now["A"] * mean + now["B"] * ui
        V = now["A"] * V * now["A"].T + now["Q"]
    return joint, sp.Matrix(values) - sp.Matrix(means)


def free_entries(V, d):
    """Those that the ones before do not determine; the others must agree with them."""
    free = []
    for k in range(len(d)):
        if V[[*free, k], [*free, k]].det() != 0:
            free.append(k)
        else:
            share = V[k, free] * V[free, free].inv() if free else sp.zeros(1, 0)
            assert not free or (share * d[free, :])[0] == d[k]
    return free


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
        given |= dict(P0_is="prior")
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
