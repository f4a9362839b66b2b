"""The covariance itself, one output at a time, for many states and noisy readings.

Products of matrices go to BLAS, which makes this two to three times as fast as the
factors of `passes` from seven states on.  It is right only while the covariance is
well away from singular, so every reading must have noise, and an elimination tests
every eighth row; where the test fails, the whole record is filtered in factors.

Source: Joseph's form of (27) in Leondes and Novak (1974), for one output.
"""

import numpy as np

from .compiling import Text

EVERY = 8  # rows from one test to the next
CLEAR = 1e-10  # of a variance: a pivot above it leaves six digits


@Text
def definite(P, L):
    """Whether P is, by more than rounding; L is room for an elimination."""
    n = len(P)
    for j in range(n):
        row, d = L[j], P[j, j]
        for k in range(j):
            a, above = P[j, k], L[k]
            for i in range(k):
                a -= row[i] * above[i]
            row[k] = a
        for k in range(j):
            share = row[k] / L[k, k]
            d -= row[k] * share
            row[k] = share
        if not d > CLEAR * P[j, j]:
            return False
        row[j] = d
    return True


@Text
def forward(y, drive, at, maps, z, P, xs, variances, tape):
    """Filter the rows of y as `passes.forward` does, where every reading has noise.

    z (n,) and P (n, n) are the estimate and its covariance; a tape has P as V.
    Returns the first row at which P is not clear of singular, or -1.
    """
    (rows, p), n = y.shape, len(z)
    T, Q, L = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    v, K, s, q = np.zeros(n), np.zeros(n), -1, -1
    B, Bt, C, r = maps.B[0], maps.B[0].T.copy(), maps.C[0], maps.r[0]
    for t in range(rows):
        if at[t] >= 0:
            if at[t] != s:
                s = at[t]
                B, Bt = maps.B[s], maps.B[s].T.copy()
                Q = np.dot(maps.G[s], maps.G[s].T)
            for i in range(n):
                row, a = B[i], drive[t, i]
                for k in range(n):
                    a += row[k] * z[k]
                v[i] = a
            z[:] = v
            np.dot(B, P, T)
            np.dot(T, Bt, P)
            for i in range(n):
                for k in range(n):
                    P[i, k] += Q[i, k]
        if len(tape.ahead):
            tape.ahead[t] = z
        if at[t + 1] != q:
            q = at[t + 1]
            C, r = maps.C[q], maps.r[q]
        for j in range(p):
            nu, pivot = y[t, j], -1.0
            if nu == nu:
                pivot, nu = absorb(P, C[j], r[j], nu, z, v, K)
            if len(tape.pivot):
                tape.pivot[t, j], tape.nu[t, j] = pivot, nu
            if len(tape.K):
                if pivot > 0.0:
                    tape.K[t, j] = v
                else:
                    tape.K[t, j] = 0.0
        if t % EVERY == EVERY - 1 or t == rows - 1:
            if not definite(P, L):
                return t
        if len(tape.z):
            tape.z[t], tape.V[t] = z, P
        xs[t] = z
        for i in range(n):
            variances[t, i] = P[i, i]
    return -1


@Text
def absorb(P, c, r, y, z, v, K):
    """Take in a reading y of c z: the pivot and the innovation; v becomes P c."""
    n, pivot, nu = len(z), r, y
    for i in range(n):
        a = 0.0
        for k in range(n):
            a += P[i, k] * c[k]
        v[i] = a
        pivot += a * c[i]
        nu -= c[i] * z[i]
    share = 1.0 / pivot
    for i in range(n):
        K[i] = v[i] * share
        z[i] += K[i] * nu
    for i in range(n):  # (I - K c') P (I - K c')' + r K K', a row at a time
        k_i = K[i]
        a = -k_i * r
        for k in range(n):
            a += (P[i, k] - k_i * v[k]) * c[k]
        for k in range(n):
            P[i, k] -= k_i * v[k] + a * K[k]
    return pivot, nu
