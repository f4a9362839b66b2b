"""The smoother of Rauch, Tung and Striebel with so many digits that none matters."""

import mpmath as mp
import numpy as np

DIGITS = 250


def matrix(X):
    return mp.matrix(np.asarray(X, dtype=float).tolist())


def floats(stack):
    return np.array([np.array(X.tolist(), dtype=float) for X in stack])


def smoothed(plant, y):
    """x (N, n), P and lag_one (N, n, n) of a plant with one output and no input."""
    with mp.workdps(DIGITS):
        return _smoothed(plant, y)


def _smoothed(plant, y):
    A, C, Q, R, P = map(matrix, (plant.A, plant.C, plant.Q, plant.R, plant.P0))
    x, rows = matrix(plant.x0[:, None]), []
    for (value,) in y:
        before, (x, P) = (x, P), (A * x, A * P * A.T + Q)
        ahead = x, P
        if not np.isnan(value):
            K = P * C.T / (C * P * C.T + R)[0]
            x, P = x + K * (mp.mpf(float(value)) - (C * x)[0]), P - K * C * P
        rows.append((before, ahead))
    found = [(x, P, None)]
    for (x, P), (x_minus, Omega) in reversed(rows):
        G = P * A.T * Omega**-1
        x_s, P_s, _ = found[-1]
        found[-1] = x_s, P_s, P_s * G.T
        found.append((x + G * (x_s - x_minus), P + G * (P_s - Omega) * G.T, None))
    x, P, U = zip(*found[-2::-1])
    return floats(x)[..., 0], floats(P), floats(U)
