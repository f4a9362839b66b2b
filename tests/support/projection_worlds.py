"""Plants and estimators made for the optimal projection equations.

Each world returns sizes and values by name that satisfy the relations of some claims;
`stationary` makes a plant for a projection chosen beforehand.
"""

import numpy as np
from scipy.linalg import sqrtm

SIZES = dict(n=5, l=3, n_e=2, q=4, k=2, s=0.7, c=0.6)


def definite(rng, k, scale=1.0):
    root = scale * rng.normal(size=(k, k))
    return root @ root.T + 0.1 * scale * np.eye(k)


def inverse_pair(rng, n, r):
    """G, Gam, N, M with [G' N] and [Gam; M] inverse to each other."""
    X = np.linalg.qr(rng.normal(size=(n, n)))[0] + 0.2 * rng.normal(size=(n, n))
    Y = np.linalg.inv(X)
    return X[:, :r].T, Y[:r], X[:, r:], Y[r:]


def stable(rng, n, radius=0.4):
    A = rng.normal(size=(n, n))
    return radius * A / np.abs(np.linalg.eigvals(A)).max()


def stein(F, H, N):
    """X = F X H + N."""
    size = N.size
    return np.linalg.solve(np.eye(size) - np.kron(F, H.T), N.ravel()).reshape(N.shape)


def plain(rng):
    return SIZES, {}


def projecting(rng):
    """Gam G' = I, De V2s = L Q C' (of the theorem and of the innovations plant)."""
    n, l, r, q = (SIZES[k] for k in ("n", "l", "n_e", "q"))
    G, Gam, N, M = inverse_pair(rng, n, r)
    Q, V2s = definite(rng, n), definite(rng, l)
    C, L = rng.normal(size=(l, n)), rng.normal(size=(q, n))
    De = L @ Q @ C.T @ np.linalg.inv(V2s)
    G1, Gam1 = inverse_pair(rng, n, r)[:2]
    X, Y = rng.normal(size=(n, r)), rng.normal(size=(r, n))
    return SIZES, {
        "G": G, "Gam": Gam, "N": N, "M": M, "Q": Q, "V2s": V2s, "C": C, "L": L,
        "De": De, "G_1": G1, "Gam_1": Gam1, "X": X, "Y": Y,
        "X+": np.linalg.pinv(X), "Y+": np.linalg.pinv(Y),
    }  # fmt: skip


def eigenprojection(rng):
    """xi^-1 = [Y1; Y2] of xi = [X1 X2]."""
    G, Gam, N, M = inverse_pair(rng, SIZES["n"], SIZES["n_e"])
    return SIZES, {"X_1": G.T, "Y_1": Gam, "X_2": N, "Y_2": M}


def stationary(rng):
    """A plant made for a projection: its estimator satisfies every equation."""
    n, r = 4, 2
    sizes = SIZES | dict(n=n, l=n, q=n)
    G, Gam, N, M = inverse_pair(rng, n, r)
    D, E = np.diag([2.0, 1.5, 0.7, 0.4]), np.diag([1.3, 2.1, 0.5, 0.8])
    xi, back = np.hstack([G.T, N]), np.vstack([Gam, M])
    Qh, Ph = xi @ D @ xi.T, back.T @ E @ back
    Q2, P2 = Gam @ Qh @ Gam.T, G @ Ph @ G.T
    A, R, V2s = stable(rng, n, 0.1), definite(rng, n), definite(rng, n)
    root = lambda X: np.real(sqrtm(X))  # noqa: E731
    Qs = root(Qh - A @ G.T @ Q2 @ G @ A.T) @ root(V2s)
    C, Q = 0.1 * rng.normal(size=(n, n)), definite(rng, n, 0.3)
    K = Qs @ np.linalg.inv(V2s)
    Aq = A - K @ C
    Lq = np.linalg.inv(root(R)) @ root(Ph - Aq.T @ Gam.T @ P2 @ Gam @ Aq)
    De = Lq @ Q @ C.T @ np.linalg.inv(V2s - C @ Q @ C.T)
    return sizes, dict(
        A=A, C=C, R=R, G=G, Gam=Gam, N=N, M=M, tau=G.T @ Gam, Qh=Qh, Ph=Ph, Q=Q, Q2=Q2,
        P2=P2, Qs=Qs, V2s=V2s, Aq=Aq, Lq=Lq, De=De, L=Lq + De @ C,
    )  # fmt: skip


def split(rng):
    """tau Qh tau' = Q1 - Q with any tau; and Gam Qh Gam' = X, G Ph G' = Y."""
    sizes, values = projecting(rng)
    n = sizes["n"]
    tau, Qh, Ph, Q1 = rng.normal(size=(n, n)), *(definite(rng, n) for _ in range(3))
    G, Gam = values["G"], values["Gam"]
    return sizes, dict(
        G=G, Gam=Gam, tau=tau, Qh=Qh, Ph=Ph, Q1=Q1, Q=Q1 - tau @ Qh @ tau.T,
        X=Gam @ Qh @ Gam.T, Y=G @ Ph @ G.T,
    )  # fmt: skip


def turn(angle=0.8):
    """M with M M' = c I."""
    a, b = np.sqrt(SIZES["c"]) * np.array([np.cos(angle), np.sin(angle)])
    return np.array([[a, b], [-b, a]])


def turned(rng, size):
    """X and V (size, 2) with X V = V M, and columns W (size - 2) beside V."""
    T = rng.normal(size=(size, size))
    rest = rng.normal(size=(size - 2, size - 2))
    middle = np.block([[turn(), rng.normal(size=(2, size - 2))],
                       [np.zeros((size - 2, 2)), rest]])  # fmt: skip
    return T @ middle @ np.linalg.inv(T), T[:, :2]


def turning(rng):
    """A'V = V M, X = H H'."""
    X, V = turned(rng, SIZES["n"])
    return SIZES, {"A": X.T, "V": V, "M": turn()}


def seen_mode(rng):
    X, V = turned(rng, 4)
    return SIZES | dict(n_e=4), {"Ae": X, "V": V, "M": turn()}


def driven_mode(rng):
    """Phi'V = V M and Be'V = 0."""
    X, V = turned(rng, 4)
    Be = (np.eye(4) - V @ np.linalg.pinv(V)) @ rng.normal(size=(4, SIZES["l"]))
    return SIZES | dict(n_e=4), {"Phi": X.T, "V": V, "M": turn(), "Be": Be}


def whole_mode(rng):
    """Ae'V = V M and A'X = X M - C'Be'V."""
    n, l = SIZES["n"], SIZES["l"]
    X, V = turned(rng, 4)
    A, C, Be = stable(rng, n), rng.normal(size=(l, n)), rng.normal(size=(4, l))
    M = turn()
    top = stein(A.T, np.linalg.inv(M), C.T @ Be.T @ V @ np.linalg.inv(M))
    values = {"Ae": X.T, "V": V, "M": M, "A": A, "C": C, "Be": Be, "X": top}
    return SIZES | dict(n_e=4), values


def noises(kind):
    """A_1 X A_1' is what remains, for the three relations of the scaling."""

    def world(rng):
        n, s = SIZES["n"], SIZES["s"]
        A, A2, X = stable(rng, n, 0.2), 0.1 * rng.normal(size=(n, n)), definite(rng, n)
        Y = definite(rng, n) + 9 * np.eye(n)
        root = lambda M: np.real(sqrtm(M))  # noqa: E731
        values = {"A": A, "A_2": A2, "X": X, "Y": Y}
        if kind == "limit":
            values["X"] = X = Y
            left = (X - A @ X @ A.T) / s**2 - A2 @ X @ A2.T
        elif kind == "solved":
            left = Y - A @ Y @ A.T - A2 @ X @ A2.T
        else:
            A1, V1, Xk = (
                0.2 * rng.normal(size=(n, n)),
                definite(rng, n),
                definite(rng, n),
            )
            push = lambda Z: A1 @ Z @ A1.T + A2 @ Z @ A2.T + V1  # noqa: E731
            Q1 = np.zeros((n, n))
            for _ in range(300):
                Q1 = A @ Q1 @ A.T + push(Q1)
            return SIZES, {"A": A, "A_1": A1, "A_2": A2, "V1": V1, "Q1": Q1, "X_k": Xk,
                           "X_k+1": stein(A, A.T, push(Xk))}  # fmt: skip
        values["A_1"] = root(left) @ np.linalg.inv(root(X))
        return SIZES, values

    return world


WORLDS = (
    plain, projecting, eigenprojection, stationary, split, turning, seen_mode,
    driven_mode, whole_mode, *map(noises, ("limit", "solved", "steps")),
)  # fmt: skip
