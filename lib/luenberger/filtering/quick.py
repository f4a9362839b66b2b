"""The covariance itself, one output at a time, for many states and noisy readings.

Products of matrices go to BLAS, which makes this two to three times as fast as the
factors of `passes` from seven states on.  It is right only while the covariance is
well away from singular, so every reading must have noise, and not much less than what
it tells of; an elimination tests every eighth row.  Where a test fails, the whole
record is filtered in factors.

P stays symmetric to the last bit: what is not symmetric in it grows as an unstable
plant does, and no reading makes it smaller.

Source: (27) in Leondes and Novak (1974) at its least, for one output.
"""

import numpy as np

from .compiling import Text

EVERY = 8  # rows from one test to the next
CLEAR = 1e-10  # of a variance: what is left of it, if it is more, has six digits


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
def forward(y, drive, at, maps, Q, z, P, xs, variances, tape):
    """Filter the rows of y as `passes.forward` does, where every reading has noise.

    Q (k, n, n) is G G' of the maps; z (n,) and P (n, n) are the estimate and its
    covariance; a tape has P as V.  Returns the first row at which P is not clear of
    singular, or -1.
    """
    (rows, p), n = y.shape, len(z)
    T, L, v, w = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n), np.zeros(n)
    B, Bt, C, r, s, q = maps.B[0], maps.B[0].T.copy(), maps.C[0], maps.r[0], 0, -1
    for t in range(rows):
        if at[t] >= 0:
            if at[t] != s:
                s = at[t]
                B, Bt = maps.B[s], maps.B[s].T.copy()
            for i in range(n):
                row, a = B[i], drive[t, i]
                for k in range(n):
                    a += row[k] * z[k]
                v[i] = a
            z[:] = v
            np.dot(B, P, T)
            np.dot(T, Bt, P)
            for i in range(n):
                for k in range(i + 1):
                    P[i, k] += Q[s, i, k]
                    P[k, i] = P[i, k]
        if len(tape.ahead):
            tape.ahead[t] = z
        if at[t + 1] != q:
            q = at[t + 1]
            C, r = maps.C[q], maps.r[q]
        for j in range(p):
            nu, pivot = y[t, j], -1.0
            if nu == nu:
                pivot, nu = absorb(P, C[j], r[j], nu, z, v, w)
                if not r[j] > CLEAR * pivot:
                    return t
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
        for i in range(n):
            xs[t, i], variances[t, i] = z[i], P[i, i]
    return -1


@Text
def absorb(P, c, r, y, z, v, w):
    """Take in a reading y of c z: the pivot and the innovation; v becomes P c."""
    n, pivot, nu = len(z), r, y
    for i in range(n):
        row, a = P[i], 0.0
        for k in range(n):
            a += row[k] * c[k]
        v[i] = a
        pivot += a * c[i]
        nu -= c[i] * z[i]
    root = 1.0 / np.sqrt(pivot)
    move = nu * root
    for i in range(n):
        w[i] = v[i] * root
        z[i] += w[i] * move
    for i in range(n):
        row, a = P[i], w[i]
        for k in range(n):
            row[k] -= a * w[k]
    return pivot, nu
