"""Run a plant and an observer side by side, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import expect
from ..at_work import start
from ..certificate import require_match, require_real
from ..errors import SAMPLE
from ..filtering.compiling import Text
from ..numeric import Matrix, Vector
from ..numeric.factors import square_root
from ..observer import Observer
from ..period import hold
from ..plant import Plant
from .checked import real, rows, single

Seed = int | np.random.SeedSequence | None
WHOLE = 64 * 64  # entries of a matrix that BLAS multiplies without dividing the work


@dataclass(frozen=True, eq=False)
class Run:
    """One simulation.  Rows are times, as in scipy and MATLAB ``lsim``.

    For a filter designed over steps the rows are its instants 1 .. N; otherwise row
    0 is the first sample.
    """

    t: np.ndarray  # (N,) seconds
    x: np.ndarray  # (N, n) plant state
    z: np.ndarray  # (N, r) observer state
    u: np.ndarray  # (N, m) known input
    y: np.ndarray  # (N, p) measurement
    w: np.ndarray  # (N, q) L x
    w_hat: np.ndarray  # (N, q) the observer's estimate of w

    @property
    def error(self) -> Matrix:
        """w^ - w, (N, q)."""
        return self.w_hat - self.w


def simulate(
    plant: Plant,
    observer: Observer,
    t: ArrayLike,
    *,
    u: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    x0: ArrayLike | None = None,
    z0: ArrayLike | None = None,
    seed: Seed = None,
) -> Run:
    """Simulate plant and observer together, exactly.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0, 0], [0, 0]], R=[[1]], P0=[[1, 0], [0, 1]])
    >>> observer = lb.kalman_filter(plant, steps=5)
    >>> lb.simulate(plant, observer, 5, x0=[2, 1]).x[:, 0]
    array([3., 4., 5., 6., 7.])

    Parameters
    ----------
    plant : Plant
    observer : Observer
    t : int or (N,) array_like
        In discrete time the number of steps; or equally spaced times in seconds,
        spaced by dt when dt > 0.
    u : float or (N, m) array_like, optional
        Known input at each row, held until the next; default zero.
    u0 : (m,) array_like, optional
        The input from instant 0 to 1, for a filter designed over steps.
    x0 : (n,) array_like, optional
        Plant state at the start; default ``plant.x0``, with a seed drawn around it.
    z0 : (r,) array_like, optional
        Observer state at its first row, default as designed.
    seed : int, optional
        Draw the start (from P0) and the noises (from Q, R, S, then the multiplicative
        ones).  None: no noise.

    Returns
    -------
    Run
        A constant observer gives rows 0 .. steps, a filter over N steps its rows
        1 .. steps.

    Raises
    ------
    ValueError
        If sizes, times or sampling periods disagree.
    """
    expect(plant=plant, observer=observer)
    require_match(observer, plant)
    require_real("simulation", plant, observer)
    if plant.dt == 0:
        return _simulate_continuous(plant, observer, t, u, x0, z0, seed, u0)
    steps = _whole_steps(t, plant.dt)
    x, y, u = trajectory(plant, observer, steps, u=u, u0=u0, x0=x0, seeds=(seed,))
    first = 0 if observer.steps is None else 1
    z, w_hat = follow(observer, y, u, start(observer, u0, z0))
    times = plant.dt * np.arange(first, steps + 1)
    x, y, z, w_hat = (signal[..., 0] for signal in (x[first:], y, z, w_hat))
    return Run(times, x, z, u, y, x @ observer.L.T, w_hat)


def trajectory(
    plant: Plant,
    observer: Observer,
    steps: int,
    *,
    u: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    x0: ArrayLike | None = None,
    seeds: Sequence[Seed] = (None,),
    roots: tuple[Matrix, Matrix] | None = None,
) -> tuple[Matrix, Matrix, Matrix]:
    """States (steps + 1, n, runs), measurements (N, p, runs) and inputs (N, m).

    Each seed makes one run from a stream of its own, so a run does not depend on
    which others are made beside it.  Measurements start at the observer's first row.
    `roots` are those of the noise, if they are known already.
    """
    varying = observer.steps is not None
    if varying and steps > observer.steps:
        raise ValueError(
            f"{steps} steps asked of a filter designed for {observer.steps}; design it "
            f"with steps={steps}"
        )
    n, first = plant.n, int(varying)
    u = _input(u, steps + 1 - first, plant.m)
    before = np.zeros(plant.m) if u0 is None else single("u0", u0, plant.m)
    full = np.vstack([before, u]) if varying else u
    roots = noise_roots(plant, steps) if roots is None else roots
    noise, gains, deviation = _noise(plant, steps, seeds, *roots)
    A, B, C, E = (over(X, steps + 1) for X in (plant.A, plant.B, plant.C, plant.E))
    x = np.empty((steps + 1, n, len(seeds)))
    x[0] = (plant.x0 if x0 is None else single("x0", x0, n))[:, None]
    x[0] += deviation if x0 is None else 0.0
    drive = noise[:, :n] + times(B, full[..., None])
    begin = int(varying and plant.at_first and steps > 0)
    x[begin] = x[0]
    F, at_once = each(A), 1 if plant.multiplicative else max(steps - begin, 1)
    for i in range(begin, steps, at_once):
        along(F[i * (A.ndim > 2) :], drive[i : i + at_once], x[i:])
        for (A1, _), g in zip(plant.multiplicative, gains[i]):
            x[i + 1] += g * times(A1, x[i])
    y = times(C, x) + times(E, full[..., None]) + noise[:, n:]
    for j, (_, C1) in enumerate(plant.multiplicative):
        y += gains[:, j, None] * times(C1, x)
    return x, y[first:], u


@Text
def along(F: Matrix, drive: Matrix, z: Matrix) -> None:
    """z[k + 1] = F[k] z[k] + drive[k] of runs side by side: z (N + 1, r, runs).

    F is one matrix (1, r, r), or one for each row; z[0] is given.
    """
    rows, r, runs = drive.shape
    last = len(F) - 1
    for k in range(rows):
        A = F[min(k, last)]
        for i in range(r):
            out, acts = z[k + 1, i], drive[k, i]
            for s in range(runs):
                out[s] = acts[s]
            for j in range(r):
                a, now = A[i, j], z[k, j]
                for s in range(runs):
                    out[s] += a * now[s]


def times(A: Matrix, X: Matrix, out: Matrix | None = None) -> Matrix:
    """A @ X, in an order of summation that does not hang on the number of threads.

    BLAS divides a large product among its threads, and then the last bits depend on
    how many there are.  It leaves a small one whole.
    """
    if A.shape[-2] * A.shape[-1] <= WHOLE:
        return np.matmul(A, X, out=out)
    return np.einsum("...ij,...jr->...ir", A, X, out=out)


def over(X: Matrix, rows: int) -> Matrix:
    """X, or its first `rows` rows if it changes in time, the last one held."""
    return X if X.ndim == 2 else X[np.minimum(np.arange(rows), len(X) - 1)]


def noise_roots(plant: Plant, steps: int) -> tuple[Matrix, Matrix]:
    """H0, H with H0 H0' = P0, H H' = [[Q, S], [S', R]], a stack if those change."""
    rows = 1 if plant.steps is None else steps + 1
    every = (plant.at(i).covariances() for i in range(rows))
    H = np.stack([square_root(np.block([[Q, S], [S.T, R]])) for Q, R, S in every])
    P0 = np.zeros((plant.n, plant.n)) if plant.P0 is None else plant.P0
    return square_root(P0), H[0] if plant.steps is None else H


def _noise(
    plant: Plant, steps: int, seeds: Sequence[Seed], H0: Matrix, H: Matrix
) -> tuple[Matrix, Matrix, Matrix]:
    """[w; v] of every instant and run, the g_j, and the first state's deviation.

    The g_j (instants, number of g_j, runs) are drawn last, so that the rest of a run
    is the same with multiplicative noise as without.
    """
    runs, width = len(seeds), plant.n + plant.p
    noise = np.zeros((runs, steps + 1, width))
    gains = np.zeros((runs, steps + 1, len(plant.multiplicative)))
    deviation = np.zeros((runs, plant.n))
    for run, seed in enumerate(seeds):
        if seed is not None:
            rng = np.random.default_rng(seed)
            for drawn in (deviation[run], noise[run], gains[run]):
                rng.standard_normal(out=drawn)
    noise, gains = (np.ascontiguousarray(g.transpose(1, 2, 0)) for g in (noise, gains))
    return times(H, noise), gains, times(H0, deviation.T)


def follow(
    observer: Observer, y: Matrix, u: Matrix, state: Vector
) -> tuple[Matrix, Matrix]:
    """States (N, r, runs) and estimates (N, q, runs) from measurements (N, p, runs).

    Inputs are (N, m, runs), or (N, m) of all runs.
    """
    N, r, o = len(y), observer.order, observer
    u = u if u.ndim == 3 else u[..., None]
    F, G, D, P, V, W = (over(X, N) for X in (o.F, o.G, o.D, o.P, o.V, o.W))
    drive = times(D, y) + times(G, u)
    z = np.empty((N, r, y.shape[-1]))
    z[0] = state[:, None]
    along(each(F), drive[:-1], z)
    return z, times(P, z) + times(V, y) + times(W, u)


def each(X: Matrix) -> Matrix:
    """The matrices of rows, or one for all, as compiled code takes them."""
    return np.ascontiguousarray(X[None] if X.ndim == 2 else X, dtype=float)


def _input(u: ArrayLike | None, length: int, m: int) -> Matrix:
    u = np.zeros(m) if u is None else real("u", u, "an array of numbers")
    try:
        u = np.broadcast_to(u, (length, m))
    except ValueError:
        raise ValueError(f"u must be ({length}, {m}), got {u.shape}") from None
    return rows("u", u, m)


def _whole_steps(t: ArrayLike, dt: float) -> int:
    if isinstance(t, (int, np.integer)) and not isinstance(t, bool):
        if t < 1:
            raise ValueError(f"steps must be at least 1, got {t}")
        return int(t)
    t = _equally_spaced(t)
    if not np.isclose(t[1] - t[0], dt, rtol=1e-6):
        raise ValueError(
            f"t is spaced by {t[1] - t[0]:g} s but the plant samples every {dt:g} s; "
            "give a number of steps, or sample the continuous plant with that period, "
            f"plant.sampled({t[1] - t[0]:g})"
        )
    return len(t) - 1


def _equally_spaced(t: ArrayLike) -> Vector:
    t = real("t", t, "a number of steps or equally spaced times")
    if t.ndim != 1 or len(t) < 2 or not np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6):
        raise ValueError("t must be a number of steps or equally spaced times")
    return t


def _simulate_continuous(
    plant: Plant,
    observer: Observer,
    t: ArrayLike,
    u: ArrayLike | None,
    x0: ArrayLike | None,
    z0: ArrayLike | None,
    seed: Seed,
    u0: ArrayLike | None,
) -> Run:
    if seed is not None or u0 is not None:
        raise ValueError(
            f"noise (seed) and u0 are for discrete time; the plant has dt=0; {SAMPLE}"
        )
    t = _equally_spaced(t)
    u = _input(u, len(t), plant.m)
    n, r = plant.n, observer.order
    M = np.block([[plant.A, np.zeros((n, r))], [observer.D @ plant.C, observer.F]])
    N = np.vstack([plant.B, observer.G + observer.D @ plant.E])
    M, N = hold(M, N, t[1] - t[0])
    s = np.empty((len(t), n + r))
    s[0] = np.concatenate(
        [plant.x0 if x0 is None else single("x0", x0, n), start(observer, None, z0)]
    )
    for k in range(len(t) - 1):
        s[k + 1] = M @ s[k] + N @ u[k]
    x, z = s[:, :n], s[:, n:]
    y = x @ plant.C.T + u @ plant.E.T
    w_hat = z @ observer.P.T + y @ observer.V.T + u @ observer.W.T
    return Run(t, x, z, u, y, x @ observer.L.T, w_hat)
