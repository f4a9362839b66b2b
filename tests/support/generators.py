"""Random plants for the tests, and filters written so plainly that they can be read.

The filters here share no code and no formulas with the library: predictor form with
S, one solve a step, rows of missing outputs dropped by hand.
"""

import pickle

import numpy as np
from exact_filter import rational

import luenberger as lb


def noise(rng, n, p, rank, cross=True):
    """Q, R, S of a joint covariance of the given rank; S = None when not `cross`."""
    H = rng.normal(size=(n + p, rank)) / np.sqrt(max(rank, 1))
    if cross:
        joint = H @ H.T
        return joint[:n, :n], joint[n:, n:], joint[:n, n:]
    half = rng.normal(size=(p, min(p, rank)))
    return H[:n] @ H[:n].T, half @ half.T, None


def dynamics(rng, n, radius):
    """A dense random A with the given spectral radius."""
    A = rng.normal(size=(n, n))
    return A * (radius / np.abs(np.linalg.eigvals(A)).max())


def plant(rng, n, p, *, m=1, rank=None, cross=True, radius=0.95, **options):
    """A random constant plant; `rank` is that of the joint noise covariance."""
    rank = n + p if rank is None else rank
    Q, R, S = noise(rng, n, p, rank, cross)
    root = rng.normal(size=(n, n))
    given = dict(Q=Q, R=R, S=S, P0=root @ root.T / n, x0=rng.normal(size=n), dt=1.0)
    return lb.Plant(
        dynamics(rng, n, radius),
        rng.normal(size=(n, m)) if m else None,
        rng.normal(size=(p, n)),
        rng.normal(size=(p, m)) if m else None,
        **(given | options),
    )


def varying(rng, n, p, steps, *, m=1, rank=None, cross=True, radius=0.95, **options):
    """A random plant whose every matrix changes at every instant 0 .. steps."""
    rank = n + p if rank is None else rank
    Q, R, S = zip(*(noise(rng, n, p, rank, cross) for _ in range(steps + 1)))
    root = rng.normal(size=(n, n))
    given = dict(
        Q=np.stack(Q),
        R=np.stack(R),
        S=np.stack(S) if cross else None,
        P0=root @ root.T / n,
        x0=rng.normal(size=n),
        dt=1.0,
    )
    return lb.Plant(
        np.stack([dynamics(rng, n, radius) for _ in range(steps + 1)]),
        rng.normal(size=(steps + 1, n, m)) if m else None,
        rng.normal(size=(steps + 1, p, n)),
        rng.normal(size=(steps + 1, p, m)) if m else None,
        **(given | options),
    )


def record(rng, plant, steps):
    """Measurements of a noisy run of `plant` at 1 .. steps, the inputs, and u0."""
    n, p = plant.n, plant.p
    u = rng.normal(size=(steps + 1, plant.m))
    x = plant.x0 + root(plant.P0) @ rng.normal(size=n)
    y = np.empty((steps, p))
    for i in range(steps + 1):
        now = plant.at(i)
        S = np.zeros((n, p)) if now.S is None else now.S
        wv = root(np.block([[now.Q, S], [S.T, now.R]])) @ rng.normal(size=n + p)
        if i > 0:
            y[i - 1] = now.C @ x + now.E @ u[i] + wv[n:]
        if i > 0 or not plant.at_first:
            x = now.A @ x + now.B @ u[i] + wv[:n]
    return y, u[1:], u[0]


def root(X):
    values, vectors = np.linalg.eigh(X)
    return vectors * np.sqrt(values.clip(0))


def kalman(plant, y, u, u0):
    """Textbook predictor-form Kalman filter with S; a NaN drops that row of y.

    Returns the estimates, error covariances and gains after each update.
    """
    first = plant.at(0)
    x, P = plant.x0, plant.P0
    if not plant.at_first:
        x = first.A @ x + first.B @ u0
        P = first.A @ P @ first.A.T + first.Q
    xs, Ps, Ks = [], [], []
    for k in range(len(y)):
        now, seen = plant.at(k + 1), ~np.isnan(y[k])
        C, R = now.C[seen], now.R[np.ix_(seen, seen)]
        S = np.zeros(C.T.shape) if now.S is None else now.S[:, seen]
        M = C @ P @ C.T + R
        innovation = y[k][seen] - C @ x - (now.E @ u[k])[seen]
        K = np.linalg.solve(M, C @ P).T
        xs.append(x + K @ innovation)
        left = np.eye(plant.n) - K @ C
        updated = left @ P @ left.T + K @ R @ K.T
        Ps.append((updated + updated.T) / 2)
        Ks.append(np.zeros((plant.n, plant.p)))
        Ks[-1][:, seen] = K
        L = np.linalg.solve(M, (now.A @ P @ C.T + S).T).T
        x = now.A @ x + now.B @ u[k] + L @ innovation
        left = now.A - L @ C
        P = left @ P @ left.T + now.Q + L @ R @ L.T - L @ S.T - S @ L.T
        P = (P + P.T) / 2
    return np.array(xs), np.array(Ps), np.array(Ks)


def relative(found, wanted):
    """Largest deviation relative to the largest wanted entry."""
    return np.abs(found - wanted).max() / np.abs(wanted).max()


def exact(plant, y, u=None, u0=None):
    """The best estimates and covariances in rational arithmetic, for any noise.

    The noises are made part of the state, s = [x; w; v], so that every output is
    noise-free; outputs are used one at a time, and one of zero variance is skipped.
    Right for singular R, redundant outputs, S and P0 = 0 alike, with no tolerance.
    It knows time-varying plants; `exact_filter` knows accurate outputs instead.
    What was asked before, as by the same test of another backend, is not filtered anew.
    """
    asked = pickle.dumps((plant, y, u, u0))
    if asked not in FILTERED:
        FILTERED[asked] = _exact(plant, y, u, u0)
    return [X.copy() for X in FILTERED[asked]]


FILTERED = {}  # by the bytes of plant and record


def _exact(plant, y, u, u0):
    n, p = plant.n, plant.p
    N = len(y)
    u = np.zeros((N, plant.m)) if u is None else u
    u0 = np.zeros(plant.m) if u0 is None else u0
    u = rational(np.vstack([u0, u]))
    mean, spread = rational(plant.x0), rational(plant.P0)
    xs, Ps = [], []
    for i in range(N + 1):
        now = plant.at(i)
        A, B, C, E, Q, R = (rational(X) for X in now[:6])
        S = rational(np.zeros((n, p)) if now.S is None else now.S)
        noise = np.block([[Q, S], [S.T, R]])
        zero = rational(np.zeros((n, n + p)))
        s = np.concatenate([mean, rational(np.zeros(n + p))])
        P = np.block([[spread, zero], [zero.T, noise]])
        if i > 0:
            H = np.hstack([C, rational(np.zeros((p, n))), rational(np.eye(p))])
            for j in np.flatnonzero(~np.isnan(y[i - 1])):
                seen = P @ H[j]
                variance = H[j] @ seen
                if variance != 0:
                    gap = rational(y[i - 1][j : j + 1])[0] - H[j] @ s - E[j] @ u[i]
                    s = s + seen * (gap / variance)
                    P = P - np.outer(seen, seen) / variance
            xs.append(s[:n].astype(float))
            Ps.append(P[:n, :n].astype(float))
        mean, spread = s[:n], P[:n, :n]
        if i > 0 or not plant.at_first:
            move = np.hstack([A, rational(np.eye(n)), rational(np.zeros((n, p)))])
            mean, spread = move @ s + B @ u[i], move @ P @ move.T
    return np.array(xs), np.array(Ps)


KNOWN = ("a constant", "what the input was", "an oscillator", "all")


def known(kind, n=4, p=2, seed=3, first=False):
    """A plant of which some states are known exactly, the last ones or the first."""
    rng = np.random.default_rng(seed)
    A, C = dynamics(rng, n, 0.9), rng.normal(size=(p, n))
    B, H, x0 = rng.normal(size=(n, 1)), rng.normal(size=(n, n)), rng.normal(size=n)
    P0, Q = H @ H.T + np.eye(n), H.T @ H + 0.1 * np.eye(n)
    count = {"an oscillator": 2, "all": n}.get(kind, 1)
    some = np.arange(n) >= n - count
    if kind != "all":
        A[some] = 0
    if kind == "a constant":
        A[-1, -1] = 1
    elif kind == "an oscillator":
        A[-2:, -2:] = [[0.8, -0.6], [0.6, 0.8]]
    for X in (Q,) if kind == "what the input was" else (Q, P0):
        X[some], X[:, some] = 0, 0
    order = np.roll(np.arange(n), count if first else 0)
    A, P0, Q = (X[np.ix_(order, order)] for X in (A, P0, Q))
    return lb.Plant(
        A, B[order], C[:, order], dt=1.0, Q=Q, R=np.eye(p), P0=P0, x0=x0[order]
    )


def holes(rng, y, share=0.3):
    """y with a share of its entries missing, and two rows missing altogether."""
    y = y.copy()
    y[rng.random(y.shape) < share] = np.nan
    y[[3, 4]] = np.nan
    return y


def integer_plant(seed):
    """Small integers: every rank, every zero and every coincidence occurs."""
    rng = np.random.default_rng(seed)
    n, p = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    A, B, C, E = (
        rng.integers(-2, 3, size=s).astype(float)
        for s in ((n, n), (n, 1), (p, n), (p, 1))
    )
    H = rng.integers(-2, 3, size=(n + p, int(rng.integers(0, n + p + 1)))).astype(float)
    start = rng.integers(-2, 3, size=(n, int(rng.integers(0, n + 1)))).astype(float)
    joint = H @ H.T
    plant = lb.Plant(
        A, B, C, E, dt=1.0, Q=joint[:n, :n], R=joint[n:, n:], S=joint[:n, n:],
        P0=start @ start.T,
    )  # fmt: skip
    return plant, *integer_record(rng, plant, H, start)


def integer_record(rng, plant, H, start, steps=6):
    x = start @ rng.integers(-2, 3, size=start.shape[1])
    u = rng.integers(-2, 3, size=(steps + 1, 1)).astype(float)
    y = np.empty((steps, plant.p))
    for i in range(steps + 1):
        noise = H @ rng.integers(-2, 3, size=H.shape[1])
        if i:
            y[i - 1] = plant.C @ x + plant.E @ u[i] + noise[plant.n :]
        x = plant.A @ x + plant.B @ u[i] + noise[: plant.n]
    return y, u[1:], u[0]
