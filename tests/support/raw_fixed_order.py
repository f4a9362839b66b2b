"""Costs of fixed-order filters by plain algebra, without the library's own.

Seeded random problems; a cost with an adjoint gradient in the raw parameters Ae, Be,
Ce, De, by Kronecker products; and the best of random-start runs of SciPy's BFGS on it.
"""

import math

import numpy as np
import scipy.linalg
import scipy.optimize

import luenberger as lb


def random_problem(seed):
    """plant, order, L and feedthrough of problem `seed`; two in five resonate."""
    rng = np.random.default_rng([17, seed])
    n = int(rng.integers(3, 9))
    p, q = int(rng.integers(1, min(n, 3) + 1)), int(rng.integers(1, n + 1))
    order = int(rng.integers(1, min(4, n - 1) + 1))
    kind = resonant if seed % 5 > 2 else dense
    plant = random_plant(rng, kind(rng, n), p, seed % 3, sources=n - seed % 5)
    L = np.eye(n) if seed % 4 < 2 else rng.normal(size=(q, n))
    return plant, order, L, seed % 2 == 0


def dense(rng, n):
    A = rng.normal(size=(n, n))
    return A * rng.uniform(0.5, 0.99) / np.abs(np.linalg.eigvals(A)).max()


def resonant(rng, n):
    """Modes that are lightly damped, which makes many local minima."""
    poles = rng.uniform(0.9, 0.995, n // 2) * np.exp(1j * rng.uniform(0, 3, n // 2))
    blocks = [[[z.real, z.imag], [-z.imag, z.real]] for z in poles]
    rest = [[[rng.uniform(-0.99, 0.99)]]] * (n % 2)
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    return turn.T @ scipy.linalg.block_diag(*blocks, *rest) @ turn


def random_plant(rng, A, p, noises, sources):
    """Noise on x from `sources` independent ones, correlated with that on y."""
    n = len(A)
    H = rng.normal(size=(n + p, max(sources, 1) + p)) / math.sqrt(n + p)
    joint = H @ H.T
    pairs = [
        (0.05 * A @ np.diag(rng.normal(size=n)), 0.1 * rng.normal(size=(p, n)))
        for _ in range(noises)
    ]
    return lb.Plant(
        A, None, rng.normal(size=(p, n)), dt=1.0, multiplicative=pairs,
        Q=joint[:n, :n], R=joint[n:, n:], S=joint[:n, n:],
    )  # fmt: skip


class Raw:
    """Cost and gradient in Ae, Be, Ce, De, by Kronecker products of full size."""

    def __init__(self, plant, order, L, feedthrough):
        self.plant, self.r, self.L, self.feedthrough = plant, order, L, feedthrough
        self.n, self.p, self.q = plant.n, plant.p, len(L)
        S = np.zeros((self.n, self.p)) if plant.S is None else plant.S
        self.noise = np.block([[plant.Q, S], [S.T, plant.R]])
        self.cuts = np.cumsum([order * order, order * self.p, self.q * order])

    def split(self, x):
        parts = np.split(x, self.cuts)
        shapes = (self.r, self.r), (self.r, self.p), (self.q, self.r), (self.q, self.p)
        if not self.feedthrough:
            parts[3] = np.zeros(self.q * self.p)
        return [part.reshape(shape) for part, shape in zip(parts, shapes)]

    def join(self, Ae, Be, Ce, De):
        whole = np.concatenate([X.ravel() for X in (Ae, Be, Ce, De)])
        return whole if self.feedthrough else whole[: self.cuts[2]]

    def __call__(self, x):
        """Cost and gradient; a large cost and no gradient outside of stability."""
        Ae, Be, Ce, De = self.split(x)
        n, r, plant = self.n, self.r, self.plant
        if not np.abs(np.linalg.eigvals(Ae)).max() < 1:
            return 1e10, np.zeros_like(x)
        zero = np.zeros((r, r))
        systems = [(plant.A, plant.C, Ae)]
        systems += [(A1, C1, zero) for A1, C1 in plant.multiplicative]
        whole = [np.block([[A, np.zeros((n, r))], [Be @ C, F]]) for A, C, F in systems]
        H = np.block([[np.eye(n), np.zeros((n, self.p))], [np.zeros((r, n)), Be]])
        miss = [np.hstack([self.L - De @ plant.C, -Ce])]
        miss += [
            np.hstack([-De @ C1, np.zeros((self.q, r))])
            for _, C1 in plant.multiplicative
        ]
        N = n + r
        operator = np.eye(N * N) - sum(np.kron(M, M) for M in whole)
        lu = scipy.linalg.lu_factor(operator, check_finite=False)
        drive = H @ self.noise @ H.T
        pull = sum(E.T @ E for E in miss)
        X = scipy.linalg.lu_solve(lu, drive.ravel()).reshape(N, N)
        Y = scipy.linalg.lu_solve(lu, pull.ravel(), trans=1).reshape(N, N)
        R = plant.R
        cost = float(np.sum(X * pull) + np.sum((De @ R) * De))
        dAe = 2 * (Y @ whole[0] @ X)[n:, n:]
        dBe = 2 * (Y @ H @ self.noise)[n:, n:]
        dCe = -2 * (miss[0] @ X)[:, n:]
        dDe = 2 * De @ R
        for M, E, (_, C, _) in zip(whole, miss, systems):
            dBe += 2 * (Y @ M @ X)[n:, :n] @ C.T
            dDe -= 2 * (E @ X)[:, :n] @ C.T
        return cost, self.join(dAe, dBe, dCe, dDe)

    def of(self, Ae, Be, Ce, De):
        """The cost, in coordinates in which rounding is small."""
        n, zero, C = self.n, np.zeros((self.n, self.r)), self.plant.C
        A = np.block([[self.plant.A, zero], [Be @ C, Ae]])
        H = scipy.linalg.block_diag(np.eye(n), Be)
        X = scipy.linalg.solve_discrete_lyapunov(A, H @ self.noise @ H.T)[n:, n:]
        size = np.sqrt(X.diagonal())
        size = np.where(size > 0, size, 1.0)
        Ae, Be = Ae * size / size[:, None], Be / size[:, None]
        return self(self.join(Ae, Be, Ce * size, De))[0]


def baseline(raw, runs=20, seed=0):
    """The least cost of random-start BFGS runs."""
    best = np.inf
    for k in range(runs):
        rng = np.random.default_rng([seed, k])
        Ae = rng.normal(size=(raw.r, raw.r))
        Ae *= rng.uniform(0, 0.95) / np.abs(np.linalg.eigvals(Ae)).max()
        rest = (rng.normal(size=s) for s in ((raw.r, raw.p), (raw.q, raw.r)))
        start = raw.join(Ae, *rest, np.zeros((raw.q, raw.p)))
        found = scipy.optimize.minimize(
            raw, start, jac=True, method="BFGS", options=dict(gtol=1e-8, maxiter=2000)
        )
        best = min(best, raw.of(*raw.split(found.x)))
    return best


def parameters(observer):
    return observer.F, observer.D, observer.P, observer.V
