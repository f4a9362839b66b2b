"""Run a plant and an observer side by side, exactly."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from .certificate import require_match, require_real
from .linalg import square_root
from .recorded import rows, single, start


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
    def error(self):
        """w^ - w, (N, q)."""
        return self.w_hat - self.w


def simulate(plant, observer, t, *, u=None, u0=None, x0=None, z0=None, seed=None):
    """Simulate plant and observer together, exactly.

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

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0, 0], [0, 0]], R=[[1]], P0=[[1, 0], [0, 1]])
    >>> observer = lb.kalman_filter(plant, steps=5)
    >>> lb.simulate(plant, observer, 5, x0=[2, 1]).x[:, 0]
    array([3., 4., 5., 6., 7.])
    """
    require_match(observer, plant)
    require_real("simulation", plant, observer)
    if plant.dt == 0:
        return _simulate_continuous(plant, observer, t, u, x0, z0, seed, u0)
    steps = _whole_steps(t, plant.dt)
    x, y, u = trajectory(plant, observer, steps, u=u, u0=u0, x0=x0, seeds=(seed,))
    x, y = x[0], y[0]
    first = 0 if observer.steps is None else 1
    z, w_hat = follow(observer, y[None], u, start(observer, u0, z0))
    times = plant.dt * np.arange(first, steps + 1)
    x = x[first:]
    return Run(times, x, z[0], u, y, x @ observer.L.T, w_hat[0])


def trajectory(plant, observer, steps, *, u=None, u0=None, x0=None, seeds=(None,)):
    """States (runs, steps + 1, n), measurements (runs, N, p) and inputs (N, m).

    Each seed makes one run from a stream of its own, so a run does not depend on
    which others are made beside it.  Measurements start at the observer's first row.
    """
    varying = observer.steps is not None
    if varying and steps > observer.steps:
        raise ValueError(
            f"{steps} steps asked of a filter designed for {observer.steps}"
        )
    n, p, first = plant.n, plant.p, int(varying)
    u = _input(u, steps + 1 - first, plant.m)
    before = np.zeros(plant.m) if u0 is None else single("u0", u0, plant.m)
    full = np.vstack([before, u]) if varying else u
    noise, gains, deviation = _noise(plant, steps, seeds)
    x = np.empty((len(seeds), steps + 1, n))
    x[:, 0] = plant.x0 + deviation if x0 is None else single("x0", x0, n)
    y = np.empty((len(seeds), steps + 1 - first, p))
    for i in range(steps + 1):
        now = plant.at(i)
        if i >= first:
            y[:, i - first] = x[:, i] @ now.C.T + full[i] @ now.E.T + noise[:, i, n:]
            for (_, C1), g in zip(plant.multiplicative, gains[i]):
                y[:, i - first] += g * (x[:, i] @ C1.T)
        if i < steps:
            if varying and i == 0 and plant.P0_is == "prior":
                x[:, 1] = x[:, 0]
                continue
            x[:, i + 1] = x[:, i] @ now.A.T + full[i] @ now.B.T + noise[:, i, :n]
            for (A1, _), g in zip(plant.multiplicative, gains[i]):
                x[:, i + 1] += g * (x[:, i] @ A1.T)
    return x, y, u


def _noise(plant, steps, seeds):
    """[w, v] of every run and instant, the g_j, and the first state's deviation.

    The g_j (instants, number of g_j, runs, 1) are drawn last, so that the rest of a
    run is the same with multiplicative noise as without.
    """
    n, p = plant.n, plant.p
    noise = np.zeros((len(seeds), steps + 1, n + p))
    gains = np.zeros((steps + 1, len(plant.multiplicative), len(seeds), 1))
    deviation = np.zeros((len(seeds), n))
    root0 = np.zeros((n, n)) if plant.P0 is None else square_root(plant.P0)
    for run, seed in enumerate(seeds):
        if seed is None:
            continue
        rng = np.random.default_rng(seed)
        deviation[run] = root0 @ rng.standard_normal(n)
        noise[run] = rng.standard_normal((steps + 1, n + p))
        gains[:, :, run, 0] = rng.standard_normal(gains.shape[:2])
    constant = plant.steps is None
    for i in range(1 if constant else steps + 1):
        here = slice(None) if constant else i
        noise[:, here] = noise[:, here] @ square_root(_joint(plant.at(i))).T
    return noise, gains, deviation


def _joint(now):
    n, p = now.A.shape[0], now.C.shape[0]
    Q = np.zeros((n, n)) if now.Q is None else now.Q
    R = np.zeros((p, p)) if now.R is None else now.R
    S = np.zeros((n, p)) if now.S is None else now.S
    return np.block([[Q, S], [S.T, R]])


def follow(observer, y, u, state):
    """Observer states and estimates for runs of measurements y (runs, N, p)."""
    z = np.empty((*y.shape[:2], observer.order))
    w_hat = np.empty((*y.shape[:2], observer.L.shape[0]))
    now = np.broadcast_to(state, (len(y), observer.order))
    for k in range(y.shape[1]):
        F, G, D, P, V, W = observer.at(k)
        z[:, k] = now
        w_hat[:, k] = now @ P.T + y[:, k] @ V.T + u[k] @ W.T
        now = now @ F.T + u[k] @ G.T + y[:, k] @ D.T
    return z, w_hat


def _input(u, length, m):
    u = np.zeros(m) if u is None else np.asarray(u, dtype=float)
    try:
        u = np.broadcast_to(u, (length, m))
    except ValueError:
        raise ValueError(f"u must be ({length}, {m}), got {u.shape}") from None
    return rows("u", u, m)


def _whole_steps(t, dt):
    if isinstance(t, (int, np.integer)) and not isinstance(t, bool):
        if t < 1:
            raise ValueError(f"steps must be at least 1, got {t}")
        return int(t)
    t = _equally_spaced(t)
    if not np.isclose(t[1] - t[0], dt, rtol=1e-6):
        raise ValueError(
            f"t is spaced by {t[1] - t[0]:g} s but the plant samples every {dt:g} s"
        )
    return len(t) - 1


def _equally_spaced(t):
    t = np.asarray(t, dtype=float)
    if t.ndim != 1 or len(t) < 2 or not np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6):
        raise ValueError("t must be a number of steps or equally spaced times")
    return t


def _simulate_continuous(plant, observer, t, u, x0, z0, seed, u0):
    if seed is not None or u0 is not None:
        raise ValueError(
            "noise (seed) and u0 are for discrete time; the plant has dt=0"
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


def hold(M, N, step):
    """Exact discretisation of s' = M s + N u for u held over `step` seconds."""
    k, m = N.shape
    E = scipy.linalg.expm(step * np.block([[M, N], [np.zeros((m, k + m))]]))
    return E[:k, :k], E[:k, k:]
