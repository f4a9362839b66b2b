"""The fixed-order filter beside what people do without it.

    python benchmarks/optimal_projection.py            everything, ten minutes
    python benchmarks/optimal_projection.py --quick    10 problems, sizes up to 50

First 100 seeded random problems: n = 3 .. 8, order 1 .. 4, up to two multiplicative
noises, with and without feedthrough.  Contestants:

* luenberger: `fixed_order_filter`, the search from 24 starts and its certificate.
* BFGS: the best of 20 random-start runs of SciPy's BFGS on the raw parameters Ae, Be,
  Ce, De, with a cost and an adjoint gradient coded here by Kronecker products; nothing
  of the library is used.
* truncation: the Kalman filter (of the equivalent plant), then balanced truncation.

Costs are those of the independent code here.  Then time against n, for all 24 starts;
run it with OMP_NUM_THREADS=1.
"""

import math
import sys
import warnings

import numpy as np
import scipy.linalg
import scipy.optimize

import luenberger as lb

SIZES = ((20, 5, 2), (20, 5, 0), (50, 8, 0), (100, 8, 0), (200, 8, 0), (400, 8, 0))


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


def truncated(plant, order, L, feedthrough):
    """Balanced truncation of the Kalman filter, as the parameters of `Raw`."""
    full = lb.fixed_order_filter(plant, plant.n, L=L, feedthrough=feedthrough)
    reach = scipy.linalg.solve_discrete_lyapunov(full.F, full.D @ full.D.T)
    seen = scipy.linalg.solve_discrete_lyapunov(full.F.T, full.P.T @ full.P)
    values, vectors = np.linalg.eigh(reach)
    half = vectors * np.sqrt(values.clip(0))
    left = np.linalg.svd(half.T @ seen @ half)[0][:, :order]
    lift, read = half @ left, left.T @ np.linalg.pinv(half)
    return read @ full.F @ lift, read @ full.D, full.P @ lift, full.V


def parameters(observer):
    return observer.F, observer.D, observer.P, observer.V


def compare(count, seconds):
    """One line a problem, then what they add up to; the seconds of both."""
    excess, lost, times, worst, more = [], [], [], 0.0, []
    print(f"{'':4} {'n p q r noises':>15} {'cost':>13} {'BFGS is above by':>17} "
          f"{'residual':>9} {'seconds':>8} {'BFGS':>7} {'truncation':>11}")  # fmt: skip
    for seed in range(count):
        plant, order, L, feedthrough = random_problem(seed)
        raw = Raw(plant, order, L, feedthrough)
        options = dict(L=L, feedthrough=feedthrough)
        mine, search = seconds(lambda: lb.fixed_order_search(plant, order, **options))  # noqa: B023
        theirs, other = seconds(lambda: baseline(raw))  # noqa: B023
        cost, floor = raw.of(*parameters(search.best.observer)), search.least_cost
        cut = raw.of(*truncated(plant, order, L, feedthrough))
        excess.append(other / cost - 1)
        lost.append((cut - floor) / max(cost - floor, 1e-12 * cost))
        times.append((mine, theirs))
        worst = max(worst, search.best.optimality.worst)
        more.append(len(search.minima))
        sizes = f"{plant.n} {plant.p} {len(L)} {order} {len(plant.multiplicative)}"
        print(f"{seed:4} {sizes:>15} {cost:13.8g} {excess[-1]:17.1e} "
              f"{search.best.optimality.worst:9.0e} {mine:8.2f} {theirs:7.1f} "
              f"{cut / cost:11.4f}", flush=True)  # fmt: skip
    print(
        f"\nabove BFGS by more than 1e-7: {sum(e < -1e-7 for e in excess)} of {count}"
    )
    print(f"below BFGS by more than 1e-7: {sum(e > 1e-7 for e in excess)} of {count}")
    print(f"largest residual of a necessary condition: {worst:.0e}")
    print(f"problems with several local minima: {sum(k > 1 for k in more)}")
    quartiles = np.quantile(lost, [0.25, 0.5, 0.75, 1])
    print("excess over the Kalman filter, truncation / ours: quartiles and largest "
          + " ".join(f"{value:.3g}" for value in quartiles))  # fmt: skip
    return zip(*times)


def growth(largest, seconds):
    """Time against n: sizes in words, seconds."""
    times = {}
    for n, order, noises in SIZES:
        if n > largest:
            break
        rng = np.random.default_rng(n)
        plant = random_plant(rng, dense(rng, n), 3, noises, n)
        times[n], _ = seconds(lambda: lb.fixed_order_search(plant, order))  # noqa: B023
        yield f"n = {n}, order {order}, {noises} noises", times[n]
    sizes = [n for n in times if n >= 50]
    if len(sizes) > 1:
        a, b = sizes[0], sizes[-1]
        exponent = math.log(times[b] / times[a]) / math.log(b / a)
        print(f"time grows as n^{exponent:.2f}, n = {a} to {b}")


def records(quick=False):
    """Seconds beside BFGS, over problems where others have rounds; then against n."""
    from common import record, seconds  # here, as the tests load this file by its path

    warnings.simplefilter("ignore", scipy.linalg.LinAlgWarning)  # where BFGS strays
    count = 10 if quick else 100
    ours, bfgs = compare(count, seconds)
    case = f"{count} problems, n = 3 to 8"
    yield record("fixed-order filter", case, "s", {"NumPy": ours, "SciPy": bfgs})
    for case, taken in growth(50 if quick else 400, seconds):
        yield record("fixed-order filter", case, "s", {"NumPy": [taken]})


if __name__ == "__main__":
    from common import line

    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
