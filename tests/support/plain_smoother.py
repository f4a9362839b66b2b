"""Expectation and maximisation of Q and R: slow, obvious, and never less likely.

One round smooths the states, forward and backward as in the textbook, and takes the
mean squares of the noises that they leave (Shumway and Stoffer, 1982).
"""

import dataclasses

import numpy as np


def filtered(plant, y):
    A, C, Q, R = plant.A, plant.C, plant.Q, plant.R
    x, P = A @ plant.x0, A @ plant.P0 @ A.T + Q
    rows = []
    for one in y:
        K = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
        after, left = x + K @ (one - C @ x), P - K @ C @ P
        rows.append((x, P, after, left))
        x, P = A @ after, A @ left @ A.T + Q
    return rows


def smoothed(plant, y):
    """Means, covariances, and covariances of each state with the next."""
    rows, A = filtered(plant, y), plant.A
    x, P, cross = [rows[-1][2]], [rows[-1][3]], []
    for k in range(len(rows) - 2, -1, -1):
        _, _, after, left = rows[k]
        ahead, spread = rows[k + 1][:2]
        J = left @ A.T @ np.linalg.inv(spread)
        cross.insert(0, J @ P[0])
        x.insert(0, after + J @ (x[0] - ahead))
        P.insert(0, left + J @ (P[0] - spread) @ J.T)
    return np.array(x), np.array(P), np.array(cross)


def improved(plant, y, diagonal=False):
    """The plant with the Q and R of one round; of the steps between readings."""
    x, P, cross = smoothed(plant, y)
    A, C = plant.A, plant.C
    w = x[1:] - x[:-1] @ A.T
    Q = w.T @ w + P[1:].sum(0) + A @ P[:-1].sum(0) @ A.T
    half = A @ cross.sum(0)
    Q = (Q - half - half.T) / len(w)
    v = y - x @ C.T
    R = (v.T @ v + C @ P.sum(0) @ C.T) / len(v)
    if diagonal:
        Q, R = (np.diag(X.diagonal()) for X in (Q, R))
    return dataclasses.replace(plant, Q=Q, R=R)
