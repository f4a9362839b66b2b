"""The texts of `passes` on Fractions, over a drawn problem."""

import numpy as np
from exact_filter import rational, zeros

from luenberger.filtering.passes import Maps, State, Tape, forward

EXACT = forward.on(TINY=0, CLASH=0)


def factored(P):
    """V = U' and D of a covariance of Fractions."""
    n, P, V, D = len(P), P.copy(), rational(np.eye(len(P))), zeros(len(P))
    for j in reversed(range(n)):
        D[j] = P[j, j]
        for i in range(j if D[j] else 0):
            V[j, i] = P[i, j] / D[j]
        P = P - D[j] * np.outer(V[j], V[j])
    return V, D


def passed(problem):
    """Maps, at and tape of a problem, and the first reading that contradicts."""
    m = problem.model
    n, p, rows = len(m.A), len(m.C), len(problem.y)
    N = n + n + p
    V, d = factored(np.block([[m.Q, m.S], [m.S.T, m.R]]))
    B, C = np.hstack([m.A, V.T[:n]]), np.hstack([m.C, V.T[n:]])
    none = zeros(1, n, 0)
    maps = Maps(B[None], B[None], none, none, none, C[None], zeros(1, p), d[None])
    state = State(
        np.concatenate([m.x0, zeros(n + p)]), rational(np.eye(N)),
        np.concatenate([zeros(n), d]), zeros(p, N), zeros(p),
    )  # fmt: skip
    state.V[:n, :n], state.D[:n] = factored(m.P0)
    y = np.where(problem.y == None, float("nan"), problem.y)  # noqa: E711
    tape = Tape(*(zeros(*s) for s in [(rows, n), (rows, N), (rows, N, N), (rows, N),
                (rows, p, N), (rows, p), (rows, p)]))  # fmt: skip
    at = np.zeros(rows + 1, dtype=int)
    clash = EXACT(
        y, zeros(rows, n), at, maps, state, zeros(rows, n), zeros(rows, n), tape
    )
    return maps, at, tape, clash
