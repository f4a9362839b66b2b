"""Plants and estimators made for the optimal projection equations.

`stationary` returns sizes and values by name, of a plant for a projection that is
chosen beforehand.
"""

import numpy as np
from scipy.linalg import sqrtm

SIZES = dict(n=5, l=3, n_e=2, q=4)


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
