"""The filter and Rauch, Tung and Striebel's smoother with 250 digits: none matters."""

import mpmath as mp
import numpy as np

DIGITS = 250


def matrix(X):
    return mp.matrix(np.asarray(X, dtype=float).tolist())


def floats(stack):
    return np.array([np.array(X.tolist(), dtype=float) for X in stack])


def smoothed(plant, y):
    """x (N, n), P and lag_one (N, n, n) of a plant whose input is zero."""
    with mp.workdps(DIGITS):
        return _smoothed(plant, y)


def _smoothed(plant, y):
    A, Q, P = map(matrix, (plant.A, plant.Q, plant.P0))
    x, rows = matrix(plant.x0[:, None]), []
    for row in y:
        before, ahead = (x, P), (A * x, A * P * A.T + Q)
        x, P = _read(plant, *ahead, row)
        rows.append((before, ahead))
    found = [(x, P, None)]
    for (x, P), (x_minus, Omega) in reversed(rows):
        G = P * A.T * Omega**-1
        x_s, P_s, _ = found[-1]
        found[-1] = x_s, P_s, P_s * G.T
        found.append((x + G * (x_s - x_minus), P + G * (P_s - Omega) * G.T, None))
    x, P, U = zip(*found[-2::-1])
    return floats(x)[..., 0], floats(P), floats(U)


def filtered(plant, y):
    """x (N, n) and P (N, n, n) of a plant whose input is zero; NaN was not measured."""
    with mp.workdps(DIGITS):
        x, P = zip(*_filtered(plant, y))
        return floats(x)[..., 0], floats(P)


def _filtered(plant, y):
    A, Q, P = map(matrix, (plant.A, plant.Q, plant.P0))
    x = matrix(plant.x0[:, None])
    for row in y:
        x, P = _read(plant, A * x, A * P * A.T + Q, row)
        yield x, P


def _read(plant, x, P, row):
    """What the outputs of a row that were measured make of a prediction."""
    seen = np.flatnonzero(~np.isnan(row))
    if not len(seen):
        return x, P
    C, R = matrix(plant.C[seen]), matrix(plant.R[np.ix_(seen, seen)])
    K = P * C.T * (C * P * C.T + R) ** -1
    return x + K * (matrix(row[seen, None]) - C * x), P - K * C * P
