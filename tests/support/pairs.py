"""Pairs (A, C) and poles for the tests of the staircase observer."""

import numpy as np
import scipy.linalg

# SLICOT, example data of AB01OD, as the dual pair (A, C)
AB01OD = (
    [
        [17, 24, 1, 8, 15],
        [23, 5, 7, 14, 16],
        [4, 6, 13, 20, 22],
        [10, 12, 19, 21, 3],
        [11, 18, 25, 2, 9],
    ],
    [[-1, 4, -9, 16, -25], [-4, 9, -16, 25, -36]],
)


def hidden_chains(n, p, seed=0, complex_=False):
    """p chains of delays with small random couplings, turned by a random unitary."""
    rng = np.random.default_rng(seed)

    def normal(*shape):
        real = rng.standard_normal(shape)
        return real + 1j * rng.standard_normal(shape) if complex_ else real

    A = np.eye(n, k=-p) + 0.3 * np.triu(normal(n, n), 1 - p) / n
    Q = scipy.linalg.qr(normal(n, n))[0]
    return Q @ A @ Q.conj().T, np.eye(n)[n - p :] @ Q.conj().T, rng


def with_stairs(sizes, rng, complex_=False):
    """A random pair in the form (7), hidden by a unitary matrix."""

    def normal(*shape):
        real = rng.standard_normal(shape)
        return real + 1j * rng.standard_normal(shape) if complex_ else real

    n, ends = sum(sizes), np.cumsum([0, *sizes])
    A, C = normal(n, n), np.zeros((sizes[-1], n), complex if complex_ else float)
    for j in range(len(sizes) - 1):
        A[ends[j + 2] :, ends[j] : ends[j + 1]] = 0
        block = A[ends[j + 1] : ends[j + 2], ends[j] : ends[j + 1]]
        block += 2 * np.eye(*block.shape)
    C[:, ends[-2] :] = normal(sizes[-1], sizes[-1]) + 2 * np.eye(sizes[-1])
    Q = scipy.linalg.qr(normal(n, n))[0]
    return Q.conj().T @ A @ Q, C @ Q


def conjugates(order, rng, radius=0.4):
    """`order` poles in conjugate pairs, and a real one when the order is odd."""
    half = (
        radius * rng.random(order // 2) * np.exp(1j * rng.uniform(0.3, 2.8, order // 2))
    )
    pairs = np.stack([half, half.conj()], axis=1).ravel()
    return np.concatenate([pairs, [0.1] * (order % 2)])


def characteristic(values):
    return np.poly(np.asarray(values, dtype=complex))
