"""Whether rows with a settled gain are as close to the full recursion as they say.

    python tests/support/bounds_of_settling.py 1000

takes some minutes: random plants, of which a third are only detectable and a third have
accurate outputs, against a textbook filter in long doubles.  It prints how many settle,
how many are outside their bound, and how much of it is used;
`tests/recursion/test_settled.py` does the same with few plants.  Two more arguments are
the tolerance and a number of gaps.  Rows behind a gap are filtered in full, and round
as a filter does that never stops: with gaps the tolerance has to be large beside that.
"""

import sys

import numpy as np

import luenberger as lb

ROWS = 400


def plant_and_record(seed):
    """A plant, m1, and a record that is as large as its noises say."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    p = int(rng.integers(1, min(n, 3) + 1))
    A, C = rng.standard_normal((n, n)), rng.standard_normal((p, n))
    A *= rng.uniform(0.3, 1.3) / np.abs(np.linalg.eigvals(A)).max()
    if seed % 3 == 0 and n > 2:  # modes that die away and that no output shows
        h, turn = n // 2, np.linalg.qr(rng.standard_normal((n, n)))[0]
        A[h:, :h] = A[:h, h:] = C[:, h:] = 0
        unseen = rng.standard_normal((n - h, n - h))
        A[h:, h:] = unseen * rng.uniform(0.5, 0.98) / radius(unseen)
        A, C = turn @ A @ turn.T, C @ turn.T
    B = rng.standard_normal((n, rng.integers(1, n + 1)))
    Q = B @ B.T * 10 ** rng.uniform(-3, 1)
    R = np.diag(10 ** rng.uniform(-3, 1, p))
    m1 = int(seed % 3 == 1)
    if m1:
        R[0, 0] *= 1e-3
    P0 = np.eye(n) * 10 ** rng.uniform(-1, 3)
    y = rng.standard_normal((ROWS, p)) * np.sqrt((C @ Q @ C.T + R).diagonal() + 1)
    return lb.Plant(A, None, C, dt=1.0, Q=Q, R=R, P0=P0), m1, y


def radius(A):
    return np.abs(np.linalg.eigvals(A)).max()


def divided(B, M):
    """B M^-1 of long doubles, M positive definite."""
    M, B = M.copy(), B.copy()
    for k in range(len(M)):
        B[:, k] /= M[k, k]
        M[:, k] /= M[k, k]  # columns: B M^-1 is kept by column operations
        for j in range(len(M)):
            if j != k:
                B[:, j] -= B[:, k] * M[k, j]
                M[:, j] -= M[:, k] * M[k, j]
    return B


def textbook(plant, m1, y):
    """x and P of every row, in long doubles."""
    A, C, Q, R, P = (
        np.longdouble(X) for X in (plant.A, plant.C, plant.Q, plant.R, plant.P0)
    )
    n, p = C.T.shape
    push = np.zeros((n, p), np.longdouble)
    if m1:
        push[:, :m1] = divided(C[:m1].T, C[:m1] @ C[:m1].T)
    x, xs, Ps = np.zeros(n, np.longdouble), [], []
    for row in np.longdouble(y):
        x, Omega = A @ x, A @ P @ A.T + Q
        seen = ~np.isnan(row)
        H, V, G = C[seen], R[np.ix_(seen, seen)], push[:, seen]
        K = divided(Omega @ H.T, H @ Omega @ H.T + V)
        K = K + G - G @ H @ K
        left = np.eye(n) - K @ H
        x, P = x + K @ (row[seen] - H @ x), left @ Omega @ left.T + K @ V @ K.T
        xs.append(x)
        Ps.append(P)
    return np.array(xs), np.array(Ps)


def of_plant(seed, settle=1e-9, gaps=0):
    """The bound, and how far off estimates and covariances are; None: never settled.

    With `gaps`, so many stretches of the record lack an output, or all.
    """
    plant, m1, y = plant_and_record(seed)
    rng = np.random.default_rng(seed + 1000)
    for k in rng.integers(40, ROWS, gaps):
        lacks = int(rng.integers(plant.p)) if rng.integers(2) else slice(None)
        y[k : k + int(rng.integers(1, 5)), lacks] = np.nan
    given = dict(m1=m1, settle=settle, history=True, backend="numpy")
    found = lb.filter_data(plant, y, **given)
    if not len(found.settled_at):
        return None
    x, P = textbook(plant, m1, y)
    rows = slice(found.settled_at[0], None)
    std = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    off_x = (np.abs(found.x - x) / std)[rows].max()
    off_P = (np.abs(found.P - P) / std[:, :, None] / std[:, None])[rows].max()
    return found.settle_bound, float(off_x), float(off_P)


def main(count, settle=1e-9, gaps=0):
    found = [of_plant(seed, settle, int(gaps)) for seed in range(count)]
    some = [one for one in found if one is not None]
    used = [max(x, P) / bound for bound, x, P in some]
    print(f"{count} plants, settle={settle:g}: {len(some)} settled")
    print(f"outside their bound: {sum(share > 1 for share in used)}")
    print(f"used of it: median {np.median(used):.2g}, most {max(used):.2g}")
    print(f"largest bound {max(bound for bound, _, _ in some):.2g}")
    worst = [max(one[k] for one in some) for k in (1, 2)]
    print("furthest off: estimates {:.1e}, covariances {:.1e}".format(*worst))


if __name__ == "__main__":
    main(int(sys.argv[1]), *map(float, sys.argv[2:]))
