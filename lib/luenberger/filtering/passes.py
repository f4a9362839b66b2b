"""The filter over a record and the way back, in factors P = U D U'.

U is upper triangular with ones on its diagonal, D is diagonal and not negative.  A
reading of one output changes D by quotients of sums that are not negative (Bierman);
a prediction orthogonalises rows, from the last one up (Thornton).  So no root is
taken, nothing is inverted, and P cannot become indefinite.  A reading without noise
leaves an exact zero in D: singular covariances, states that are known exactly and
readings that repeat others are no cases of their own.  `V` is U', so that a column of
U is a row in memory.  The same texts run on Fractions, where `TINY` is zero.

The state is z = [x; e]: the plant's state, and those noises of a row that its outputs
share with each other or with the next state.  Where outputs have noises of their own
that drive nothing, there is no e.  With M, B, G, X, O, C and r of `Maps`,

    z+ = [M z + drive; 0],  [x+; e+] has the covariance of [B (z - z^), G g, X ...; e+],

and a reading is y_j = C_j z + a noise of variance r_j.  An accurate output (m1) is met
by x + O e; what that adds to the error is in the columns X of the next prediction.

Source: Bierman (1977), sections V.3 and VI.4; Thornton (1976); Rauch, Tung and
Striebel (1965); Bryson and Frazier (1963).
"""

from typing import NamedTuple

import numpy as np

from .compiling import Text

FEW = 6  # states at most whose rows are done in scalars, sums in their order
TINY = 1e-13  # of what a sum is made of: rounding
ROOM = 200  # rows that are near, beside those that may be asked for again
CLASH = 1e-7  # of what an innovation is made of: more contradicts what is known
LOST = 1e-5  # so that eleven digits are left of what a smoother subtracts


class Maps(NamedTuple):
    """The matrices of rows, a stack of each; N = n + the number of shared noises.

    Attributes
    ----------
    M : (k, n, N) ndarray
        Leads the estimate to the next row.
    B : (k, n, N) ndarray
        Leads its error there.
    G : (k, n, g) ndarray
        A factor of the covariance of the noise that no output shares.
    X, O : (k, n, N - n) ndarray, or (k, n, 0) where there are no accurate outputs
        What the noises e that were told by a row add: to the next prediction, and to
        the estimate of the row.
    C : (k, p, N) ndarray
        Outputs.
    r : (k, p) ndarray
        Variances of their own noises.
    d : (k, N - n) ndarray
        Variances of the noises e.
    """

    M: np.ndarray
    B: np.ndarray
    G: np.ndarray
    X: np.ndarray
    O: np.ndarray  # noqa: E741
    C: np.ndarray
    r: np.ndarray
    d: np.ndarray


class State(NamedTuple):
    """A filter behind a row.

    Attributes
    ----------
    z : (N,) ndarray
    V : (N, N) ndarray
    D : (N,) ndarray
        z and the factors of its covariance.
    E : (p, N) ndarray
    e : (p,) ndarray
        What each reading of the row told of z: the column K, with its weight.
    """

    z: np.ndarray
    V: np.ndarray
    D: np.ndarray
    E: np.ndarray
    e: np.ndarray


class Tape(NamedTuple):
    """What a pass wrote of each row: `State`, and of each reading K, pivot, innovation.

    `ahead` (N, n) is the prediction of each row.  Where nothing was measured the pivot
    is -1.  Parts that are not kept have no rows.
    """

    ahead: np.ndarray
    z: np.ndarray
    V: np.ndarray
    D: np.ndarray
    K: np.ndarray
    pivot: np.ndarray
    nu: np.ndarray


@Text
def clear(value, made):
    """A sum, or zero where it is rounding of what it was made of."""
    return value if abs(value) > TINY * made else 0


@Text
def over(a, b):
    """a / b; 0 where b is."""
    return a / b if b > 0 else 0


@Text
def part(a, b):
    """a / b; 1 where b is 0."""
    return a / b if b > 0 else 1


@Text
def absorb(V, D, c, r, nu, x, K, f):
    """Take in a reading of c x with noise of variance r and innovation nu.

    x, V and D become those after the reading, K becomes P c.  Returns the variance of
    the innovation, 0 where the reading was known before.
    """
    n = len(D)
    for j in range(n):  # f = U' c
        v, a, made = V[j], 0, 0
        for i in range(j + 1):
            a += v[i] * c[i]
            made += abs(v[i] * c[i])
        f[j] = clear(a, made)
    alpha = r
    for j in range(n):
        d = D[j] * f[j]
        K[j] = d
        if d == 0:
            continue
        v, beta = V[j], alpha
        alpha = beta + f[j] * d
        D[j] = D[j] * part(beta, alpha)
        back = over(-f[j], beta)
        for i in range(j):
            u, less = v[i], K[i] * back
            v[i] = clear(u + less, abs(u) + abs(less))
            K[i] += d * u
    move = over(nu, alpha)
    for j in range(n):
        x[j] += K[j] * move
    return alpha


@Text
def whiten(R, C, y, r):
    """Combine readings y of C z so that no two noises are correlated; NaN is none.

    R (p, p), their covariance, is used up; r becomes the variances of the combinations.
    """
    p, n = C.shape
    for j in range(p):
        r[j] = R[j, j]
        if y[j] == y[j]:
            for i in range(j + 1, p):
                a = over(R[i, j], R[j, j])
                y[i] -= a * y[j]
                for k in range(n):
                    C[i, k] -= a * C[j, k]
                for k in range(j + 1, p):
                    R[i, k] -= a * R[j, k]


@Text
def gram(W, w, made, V, D, T, h):
    """The factors of the last rows of W, whose columns have variances w.

    W w W' is the covariance of all rows.  V and D become the factors of that of the
    last n = len(made) rows, and T what each row before them has of the combinations
    whose variances are D.  Of the first rows W keeps what the last ones do not tell.
    `made` (n,) says what numbers the variances are made of; h is room for a row.
    """
    n, wide = len(made), W.shape[1]
    top = len(W) - n
    for j in range(n - 1, -1, -1):
        v, d, start = V[j], 0, 0
        while start < wide - 1 and W[top + j, start] == 0:
            start += 1
        last = W[top + j, start:]
        for k in range(wide - start):
            h[k] = w[start + k] * last[k]
            d += h[k] * last[k]
        d = clear(d, TINY * made[j])
        D[j], share = d, over(1, d)
        for i in range(n):
            v[i] = 0
        v[j] = 1
        for i in range(top + j):
            row, u = W[i, start:], 0
            for k in range(wide - start):
                u += row[k] * h[k]
            u *= share
            for k in range(wide - start):
                row[k] -= u * last[k]
            if i < top:
                T[i, j] = u
            else:
                v[i - top] = u


@Text
def rows_ahead(B, G, V, D, W, top, made):
    """W = [G, B U] from row `top` on, and what the variances of rows are made of.

    G comes first: it ends in a triangle, so that `gram` meets its zeros there.
    """
    (n, N), g = B.shape, G.shape[1]
    for i in range(n):
        b, row, size = B[i], W[top + i], 0
        for k in range(g):
            row[k] = G[i, k]
            size += G[i, k] * G[i, k]
        for k in range(N):
            v, a, much = V[k], 0, 0
            for m in range(k + 1):
                a += b[m] * v[m]
                much += abs(b[m] * v[m])
            row[g + k] = clear(a, much)
            size += much * much * D[k]
        made[i] = size


@Text
def predict(M, B, G, X, d, drive, z, V, D, E, e, W, w, made, met, T, h):
    """The state ahead of the next row."""
    n, N = B.shape
    g, p = G.shape[1], len(e) if X.shape[1] else 0
    for i in range(n):
        row, a, much = M[i], drive[i], abs(drive[i])
        for k in range(N):
            a += row[k] * z[k]
            much += abs(row[k] * z[k])
        for k in range(n):
            much += 1e-3 * abs(row[k]) * met[k]  # rounding of what was before
        made[i], h[i] = a, much
    for k in range(n):
        z[k], met[k] = made[k], h[k]
    for k in range(n, N):
        z[k], met[k] = 0, 0
    rows_ahead(B, G, V, D, W, 0, made)
    for i in range(n):
        for j in range(p):
            a = X[i, 0] * E[j, n]
            for k in range(1, N - n):
                a += X[i, k] * E[j, n + k]
            W[i, N + g + j] = a
            made[i] += a * a * e[j]
    for k in range(g):
        w[k] = 1
    for k in range(N):
        w[g + k] = D[k]
    for j in range(p):
        w[N + g + j] = e[j]
    gram(W, w, made, V, D, T, h)
    for k in range(n, N):
        V[k], D[k] = 0, d[k - n]
        V[k, k] = 1


@Text
def read(y, V, D, c, r, z, met, K, f):
    """Take in a reading y of c z: the pivot, the innovation, and what that is made of.

    `met` says what the estimate z is made of.
    """
    nu, size = y, abs(y)
    for i in range(len(z)):
        nu -= c[i] * z[i]
        size += abs(c[i] * z[i])
    for i in range(len(met)):
        size += abs(c[i]) * met[i]
    pivot = absorb(V, D, c, r, nu, z, K, f)
    move = over(size, pivot)
    for i in range(len(met)):
        met[i] += abs(K[i]) * move
    return pivot, nu, size


@Text
def spread(V, D, variances):
    """The variances of the plant's states."""
    n = len(variances)
    for i in range(n):
        variances[i] = 0
    for k in range(len(D)):
        row, d = V[k], D[k]
        for i in range(min(k + 1, n)):
            variances[i] += row[i] * row[i] * d


@Text
def push(O, z, E, e, x, variances):  # noqa: E741
    """What accurate outputs add to an estimate, and to its variances."""
    n, pushed, p = O.shape[0], O.shape[1], len(e)
    for i in range(n):
        for k in range(pushed):
            x[i] += O[i, k] * z[n + k]
        for j in range(p):
            a = O[i, 0] * E[j, n]
            for k in range(1, pushed):
                a += O[i, k] * E[j, n + k]
            variances[i] += a * a * e[j]


@Text
def put(x, out):
    """out = x; numba takes seconds to compile what `out[:] = x` says of lengths."""
    for i in range(len(x)):
        out[i] = x[i]


@Text
def forward(y, drive, at, maps, state, xs, variances, tape):
    """Filter the rows of y, NaN where an output did not arrive.

    `at` has the setting of the row before the first one, or -1 where `state` is that
    ahead of the first reading, and then of each row.  Returns the first row and output
    whose reading contradicts what was known exactly, as one number; -1 if none does.
    """
    z, V, D, E, e = state
    (rows, p), N, n = y.shape, len(z), maps.B.shape[1]
    pushed = maps.O.shape[2]
    wide = N + maps.G.shape[2] + (p if pushed else 0)
    W, T = np.zeros((n, wide), z.dtype), np.zeros((0, n), z.dtype)
    w, h = np.zeros(wide, z.dtype), np.zeros(wide, z.dtype)
    made, met, f = np.zeros(n, z.dtype), np.zeros(N, z.dtype), np.zeros(N, z.dtype)
    for i in range(N):
        met[i] = abs(z[i])
    clash, s = -1, -1
    M, B, G, X = maps.M[0], maps.B[0], maps.G[0], maps.X[0]
    C, r, O = maps.C[0], maps.r[0], maps.O[0]  # noqa: E741
    for t in range(rows):
        if at[t] >= 0:
            if at[t] != s:
                s = at[t]
                M, B, G, X = maps.M[s], maps.B[s], maps.G[s], maps.X[s]
            d = maps.d[at[t + 1]]
            predict(M, B, G, X, d, drive[t], z, V, D, E, e, W, w, made, met, T, h)
        if len(tape.ahead):
            put(z[:n], tape.ahead[t])
        if t == 0 or at[t + 1] != at[t]:
            C, r, O = maps.C[at[t + 1]], maps.r[at[t + 1]], maps.O[at[t + 1]]  # noqa: E741
        for j in range(p):
            e[j] = 0
            pivot, nu = r[j] - r[j] - 1, y[t, j]
            if nu == nu:
                pivot, nu, size = read(nu, V, D, C[j], r[j], z, met, E[j], f)
                e[j] = over(1, pivot)
                if pivot == 0 and abs(nu) > CLASH * size and clash < 0:
                    clash = t * p + j
            if len(tape.pivot):
                tape.pivot[t, j], tape.nu[t, j] = pivot, nu
            if len(tape.K):
                put(E[j], tape.K[t, j])
        if len(tape.z):
            put(z, tape.z[t])
            put(D, tape.D[t])
            for k in range(N):
                put(V[k], tape.V[t, k])
        x, v = xs[t], variances[t]
        for i in range(n):
            x[i] = z[i]
        spread(V, D, v)
        if pushed:
            push(O, z, E, e, x, v)
    return clash


@Text
def taken(tape, t, state):
    """The state behind row t of a tape."""
    z, V, D, E, e = state
    for i in range(len(z)):
        z[i], D[i] = tape.z[t, i], tape.D[t, i]
        for k in range(len(z)):
            V[i, k] = tape.V[t, i, k]
    for j in range(len(e)):
        e[j] = over(1, tape.pivot[t, j])
        for i in range(len(z)):
            E[j, i] = tape.K[t, j, i]


@Text
def resumed(y, drive, at, maps, state, xs, variances, tape, first, stop):
    """`forward` over the rows from `first` until `stop`, behind those on the tape."""
    taken(tape, first - 1, state)
    part = Tape(
        tape.ahead, tape.z[first:stop], tape.V[first:stop], tape.D[first:stop],
        tape.K[first:stop], tape.pivot[first:stop], tape.nu[first:stop],
    )  # fmt: skip
    return forward(
        y[first:stop], drive[first:stop], at[first - 1 : stop], maps, state,
        xs[first:stop], variances[first:stop], part,
    )  # fmt: skip


@Text
def replay(y, drive, at, first, known, since, span, maps, state, xs, variances, tape,
           oldest, before):  # fmt: skip
    """Filter rows, and again from the oldest whose readings have just become known.

    y and at[1:] hold versions of rows: those of row t from first[t] on, and version v
    holds from row known[v] on.  since[t] is the oldest row with a version from row t
    on, at most span - 1 rows before t.  What is written of row t is as of row t.
    `before` gets the state behind the row before `oldest`, as of the last row; that
    has less than `span` rows after it.  Returns -1, -1, or the row at which a reading
    contradicts what was known, and which does, as `forward` says it.
    """
    z, V, D, E, e = state
    (_, p), N, n, rows = y.shape, len(z), maps.B.shape[1], len(since)
    size = 2 * span + ROOM
    near = Tape(
        np.zeros((0, n)), np.zeros((size, N)), np.zeros((size, N, N)),
        np.zeros((size, N)), np.zeros((size, p, N)), np.zeros((size, p)),
        np.zeros((size, p)),
    )  # fmt: skip
    x, v, r = np.zeros((size, n)), np.zeros((size, n)), np.zeros((size, p))
    now, m = np.zeros(size, np.int64), np.zeros(size + 1, np.int64)
    start = State(z.copy(), V.copy(), D.copy(), E.copy(), e.copy())
    m[0], base, t = at[0], 0, 0  # row `base` is the first that is near
    while t < rows:
        if t - base == size:  # the last rows become the first that are near
            for i in range(span):
                k = size - span + i
                near.z[i], near.V[i], near.D[i] = near.z[k], near.V[k], near.D[k]
                near.K[i], near.pivot[i] = near.K[k], near.pivot[k]
                now[i], m[i] = now[k], m[k]
            m[span], base = m[size], t - span
        a, last = since[t] - base, t
        while last + 1 < rows and since[last + 1] > last and last + 1 - base < size:
            last += 1  # rows at which nothing late arrives
        for i in range(t - base, last - base + 1):
            now[i] = first[base + i]
        for i in range(a, last - base + 1):
            k = now[i]
            while k + 1 < first[base + i + 1] and known[k + 1] <= t:
                k += 1
            now[i], r[i], m[i + 1] = k, y[k], at[k + 1]
        if base + a == 0:
            z[:], V[:], D[:], E[:], e[:] = start
        elif base + a < t:
            taken(near, a - 1, state)
        b = last - base + 1
        part = Tape(
            near.ahead, near.z[a:b], near.V[a:b], near.D[a:b], near.K[a:b],
            near.pivot[a:b], near.nu[a:b],
        )  # fmt: skip
        clash = forward(
            r[a:b], drive[base + a : base + b], m[a : b + 1], maps, state, x[a:b],
            v[a:b], part,
        )  # fmt: skip
        if clash >= 0:
            return max(t, base + a + clash // p), (base + a) * p + clash
        for k in range(t, last + 1):
            i = k - base
            xs[k], variances[k] = x[i], v[i]
            if len(tape.z):
                tape.z[k], tape.V[k], tape.D[k] = near.z[i], near.V[i], near.D[i]
            if len(tape.K):
                tape.K[k], tape.pivot[k] = near.K[i], near.pivot[i]
                tape.nu[k] = near.nu[i]
        t = last + 1
    if oldest > 0:
        taken(near, oldest - 1 - base, before)
    return -1, -1


@Text
def gained(A, J, K, z, y, drive, x):
    """x = K y + J drive + A z, where J has columns."""
    for i in range(len(z)):  # first what need not wait for the row before
        s = K[i, 0] * y[0]
        for j in range(1, len(y)):
            s += K[i, j] * y[j]
        for k in range(J.shape[1]):
            s += J[i, k] * drive[k]
        for k in range(len(z)):
            s += A[i, k] * z[k]
        x[i] = s


@Text
def one_gain(y, drive, A, J, K, z, sizes, xs, variances):
    """Filter rows with the same gain, z+ = K y + J drive + A z; `sizes` are variances.

    J has no columns where there is no input.
    """
    now = z.copy()
    for t in range(len(y)):
        gained(A, J, K, now, y[t], drive[t], xs[t])
        put(sizes, variances[t])
        put(xs[t], now)
    put(now, z)


@Text
def combine(X, M, out):
    """out = X M', row by row."""
    for t in range(len(X)):
        x, row = X[t], out[t]
        for i in range(len(M)):
            m, s = M[i], x[0] * M[i, 0]
            for k in range(1, len(x)):
                s += m[k] * x[k]
            row[i] = s


@Text
def mixed(y, at, mix):
    """Combine the readings of each row, NaN for none, by its triangle of `mix`."""
    for t in range(len(y)):
        row, L = y[t], mix[at[t + 1]]
        for i in range(len(row) - 1, -1, -1):
            s = row[i] - row[i]
            for k in range(i + 1 if s == 0 else 0):
                if row[k] == row[k]:
                    s += L[i, k] * row[k]
            row[i] = s


@Text
def unread(K, c, share, nu, a, A, h):
    """Put into a and A what a reading says before it is read; `share` is 1 / pivot.

    h becomes A K share, of the A that was given.
    """
    u, d = nu, share * 0 + 1
    for i in range(len(a)):
        row, s = A[i], A[i, 0] * K[0]
        for k in range(1, len(a)):
            s += row[k] * K[k]
        h[i] = s * share
        u -= K[i] * a[i]
        d += K[i] * h[i]
    u, d = u * share, d * share
    for i in range(len(a)):
        a[i] += c[i] * u
        row, s = A[i], d * c[i] - h[i]
        for k in range(len(a)):
            row[k] += s * c[k] - c[i] * h[k]
    return u, d


@Text
def times(X, Y, out):
    """out = X Y of square matrices, or nearly so."""
    if len(Y) > FEW:
        np.dot(X, Y, out)
        return
    for i in range(len(X)):
        for j in range(Y.shape[1]):
            s = X[i, 0] * Y[0, j]
            for k in range(1, len(Y)):
                s += X[i, k] * Y[k, j]
            out[i, j] = s


@Text
def moved_back(B, lam, Lam, a, A, H):
    """a = B' lam and A = B' Lam B; H (n, N) becomes Lam B."""
    for i in range(len(a)):
        a[i] = B[0, i] * lam[0]
    for k in range(1, len(lam)):
        row, s = B[k], lam[k]
        for i in range(len(a)):
            a[i] += row[i] * s
    times(Lam, B, H)
    times(B.T, H, A)
    for i in range(len(a)):  # `unread` lets what is not symmetric grow
        for j in range(i):
            A[j, i] = A[i, j]


@Text
def corrected(S, a, A, z, H, variances):
    """What later rows, by a and A, say of an estimate z of covariance S.

    H becomes S A, and `variances` those that are left.  Returns a size of S A, beside
    which rounding of A is rounding of what is left of S.
    """
    size = S[0, 0] * A[0, 0]
    for i in range(1, len(z)):
        size += S[i, i] * A[i, i]
    for i in range(len(z)):
        row, s = S[i], z[i]
        for k in range(len(z)):
            s += row[k] * a[k]
        z[i] = s
    times(S, A, H)
    for i in range(len(variances)):
        row, gone, s = S[i], H[i], S[i, i]
        for k in range(len(z)):
            s -= gone[k] * row[k]
        variances[i] = s
    return size


@Text
def driven_by(G, l, h, w):
    """What l of the next prediction says of the noise G: w = G G' l; h is room."""
    g = G.shape[1]
    for k in range(g):
        h[k] = G[0, k] * l[0]
    for i in range(1, len(w)):
        row, s = G[i], l[i]
        for k in range(g):
            h[k] += row[k] * s
    for i in range(len(w)):
        row, s = G[i], l[0] - l[0]
        for k in range(g):
            s += row[k] * h[k]
        w[i] = s


@Text
def backward(at, maps, tape, z, variances, P, w, before):
    """What later rows say of each row, by their innovations alone (Bryson, Frazier).

    They change the estimate of a row, of covariance S, by S a, and its covariance by
    -S A S: z (rows, N), `variances` (rows, n) and P (rows, n, n), if it has rows,
    become those of all rows, and w (rows, n) what they say of the noise G that leads
    to the next row.  z and w may be z and D of the tape; if D has no rows, V has S.

    Where readings are accurate beside what was known, or S beside what is left of it,
    rounding of A is not small beside that; such a row t is returned, or -1.  A of the
    next row is in before[(t + 1) % 2, 0], and S if the tape has none in [.., 1].
    Rounding of A at a row is that of what is left at all rows before it, and there it
    is no larger beside S.
    """
    rows, p = tape.pivot.shape
    (n, N), kind = maps.B.shape[1:], tape.z.dtype
    a, x = np.zeros(N, kind), np.zeros(N, kind)
    l, L, now = np.zeros(n, kind), np.zeros((n, n), kind), np.zeros((N, N), kind)
    L = now if N == n else L
    h, H, LB = np.zeros(N, kind), np.zeros((N, N), kind), np.zeros((n, N), kind)
    T = np.zeros((N, N), kind)
    told, noise = np.zeros(maps.G.shape[2], kind), np.zeros(n, kind)
    ahead, worst, k = np.zeros(N, kind), 0, -1
    B, C, G = maps.B[0], maps.C[0], maps.G[0]
    for t in range(rows - 1, -1, -1):
        if at[t + 1] != k:
            k = at[t + 1]
            B, C, G = maps.B[k], maps.C[k], maps.G[k]
        A, v = before[t % 2, 0], variances[t]
        moved_back(B, l, L, a, A, LB)
        if len(tape.D):
            V, D, S = tape.V[t], tape.D[t], before[t % 2, 1]
            for j in range(N):
                row, column, d = T[j], V[j], D[j]
                for i in range(N):
                    row[i] = d * column[i]
            times(V.T, T, S)
        else:
            S = tape.V[t]
        for i in range(N):
            x[i] = tape.z[t, i]
        size = corrected(S, a, A, x, H, v)
        driven_by(G, l, told, noise)
        if len(P):
            times(H, S, T)
            for i in range(n):
                for j in range(i + 1):
                    P[t, i, j] = S[i, j] - T[i, j]
                    P[t, j, i] = P[t, i, j]
        for i in range(N):
            ahead[i] = S[i, i]
            for j in range(N):
                now[i, j] = A[i, j]
        for j in range(p - 1, -1, -1):
            share = over(1, tape.pivot[t, j])
            if share > 0:
                K = tape.K[t, j]
                unread(K, C[j], share, tape.nu[t, j], a, now, h)
                for i in range(N):
                    ahead[i] += K[i] * K[i] * share
        for i in range(N):  # A changes from what it is beside S to what it is ahead
            size += ahead[i] * (A[i, i] + now[i, i])
        worst = max(worst, size)
        for i in range(n):
            if not LOST * worst * S[i, i] <= v[i]:
                return t
        for i in range(N):
            z[t, i] = x[i]
        for i in range(n):
            w[t, i] = noise[i]
            l[i] = a[i]
            for j in range(n if N > n else 0):
                L[i, j] = now[i, j]
    return -1


@Text
def factored(P, V, D):
    """The factors of covariances (rows, n, n), which are used up."""
    rows, n, _ = P.shape
    for t in range(rows):
        for j in range(n - 1, -1, -1):
            d = P[t, j, j]
            D[t, j] = max(d, d - d)
            for i in range(n):
                V[t, j, i] = d - d
            V[t, j, j] += 1
            for i in range(j):
                u = over(P[t, i, j], D[t, j])
                V[t, j, i] = u
                for k in range(i + 1):
                    P[t, k, i] -= u * P[t, k, j]


@Text
def rts(at, maps, tape, gains):
    """Smooth rows from the last one up, without an inverse (Rauch, Tung, Striebel).

    The estimates z of the tape, with their factors V and D, become those of all rows;
    `gains` (rows, n, n) what there is in a row's error of that of the next state, or
    no rows.
    """
    rows, N = tape.z.shape
    n, g = maps.B.shape[1], maps.G.shape[2]
    z, kind = tape.z, tape.z.dtype
    W, w = np.zeros((N + n, N + g), kind), np.zeros(N + g, kind)
    Y, v = np.zeros((N, N + g + N), kind), np.zeros(N + g + N, kind)
    made, U, d = np.zeros(n, kind), np.zeros((n, n), kind), np.zeros(n, kind)
    T, none = np.zeros((N, n), kind), np.zeros((0, N), kind)
    size, h = np.zeros(N, kind), np.zeros(2 * N + g, kind)
    for t in range(rows - 2, -1, -1):
        B, G, V, D = maps.B[at[t + 1]], maps.G[at[t + 1]], tape.V[t], tape.D[t]
        after, spread_after = tape.V[t + 1], tape.D[t + 1]
        for k in range(g):
            w[k] = 1
        for k in range(N):
            w[g + k] = D[k]
        for i in range(N):
            for k in range(g):
                W[i, k] = 0
            for k in range(N):
                W[i, g + k] = V[k, i]
        rows_ahead(B, G, V, D, W, N, made)
        gram(W, w, made, U, d, T, h)
        for i in range(N):  # the gain T U^-1
            for j in range(n):
                for k in range(j):
                    T[i, j] -= T[i, k] * U[j, k]
        for i in range(N):
            size[i] = 0
            for j in range(n):
                z[t, i] += T[i, j] * (z[t + 1, j] - tape.ahead[t + 1, j])
            for k in range(N + g):
                Y[i, k] = W[i, k]
                size[i] += W[i, k] * W[i, k] * w[k]
            for k in range(N):
                a, much = T[i, 0] * after[k, 0], abs(T[i, 0] * after[k, 0])
                for j in range(1, n):
                    a += T[i, j] * after[k, j]
                    much += abs(T[i, j] * after[k, j])
                Y[i, N + g + k] = clear(a, much)
                size[i] += much * much * spread_after[k]
        for k in range(N + g):
            v[k] = w[k]
        for k in range(N):
            v[N + g + k] = spread_after[k]
        gram(Y, v, size, V, D, none, h)
        if len(gains):
            gains[t] = T[:n]


@Text
def score(at, maps, tape, lam, Lam, Q, R, S):
    """What the innovations say of the noises, from the last row up.

    With lam and Lam as of the prediction behind the last row, and then of the first
    one, and u, U the same of the readings of a row: adds lam lam' - Lam to Q (n, n),
    u u' - U to R (k, p, p), and to S (k, n, p) lam of the next row times u' less what
    both have in common; R and S for each map.  S has no rows where it is not wanted.
    """
    rows, p = tape.pivot.shape
    n, N = maps.B.shape[1:]
    a, A = np.zeros(N, lam.dtype), np.zeros((N, N), lam.dtype)
    h, H = np.zeros(N, lam.dtype), np.zeros((n, N), lam.dtype)
    told, s = np.zeros(p, lam.dtype), np.zeros((p, N), lam.dtype)
    for t in range(rows - 1, -1, -1):
        k = at[t + 1]
        C = maps.C[k]
        moved_back(maps.B[k], lam, Lam, a, A, H)
        for j in range(p - 1, -1, -1):
            told[j] = 0
            share = over(1, tape.pivot[t, j])
            if share == 0:
                for i in range(N):
                    s[j, i] = 0
                continue
            K, c = tape.K[t, j], C[j]
            u, d = unread(K, c, share, tape.nu[t, j], a, A, h)
            told[j] = u
            R[k, j, j] += u * u - d
            for m in range(j + 1, p):  # s[m] is what a and the reading m share
                v = s[m, 0] * K[0]
                for i in range(1, N):
                    v += s[m, i] * K[i]
                v *= share
                for i in range(N):
                    s[m, i] -= c[i] * v
                R[k, j, m] += u * told[m] + v
                R[k, m, j] += u * told[m] + v
            for i in range(N):
                s[j, i] = c[i] * d - h[i]
            for i in range(n if len(S) else 0):  # H is what lam and a share
                v = H[i, 0] * K[0]
                for m in range(1, N):
                    v += H[i, m] * K[m]
                v *= share
                for m in range(N):
                    H[i, m] -= v * c[m]
                S[k, i, j] += lam[i] * u + v
        for i in range(n):
            lam[i] = a[i]
            for j in range(n):
                Lam[i, j] = A[i, j]
        if at[t] >= 0:
            for i in range(n):
                for j in range(n):
                    Q[i, j] += lam[i] * lam[j] - Lam[i, j]
