"""The polynomial of least radius in an affine family, by descent from many starts."""

from math import comb

import numpy as np
import scipy.optimize

from .half_plane import to_disc

STARTS = 12  # at least


def search(basis, discrete):
    """Roots of the polynomial of least radius that a descent from many starts finds.

    Deterministic.  The radius is neither convex nor smooth, so the least one can be
    missed.
    """
    g = to_disc(basis.astype(float), discrete)
    weight = np.array([comb(len(g) - 1, j) for j in range(len(g))], float)[:, None]
    _, _, right = np.linalg.svd(g[-1:])  # monic: g[-1] y = 1
    y0, free = right[0] / (g[-1] @ right[0]), right[1:].T
    Z, _ = np.linalg.qr(g @ free / weight)
    Z = Z * weight
    g0 = g @ y0
    best = None
    for start in _starts(g0 / weight[:, 0], Z / weight):
        found = scipy.optimize.minimize(
            _radius_and_gradient, start, (g0, Z), jac=True, method="BFGS"
        )
        if best is None or found.fun < best.fun:
            best = found
    for _ in range(2):
        found = scipy.optimize.minimize(
            lambda c: _radius_and_gradient(c, g0, Z)[0],
            best.x,
            method="Nelder-Mead",
            options=dict(maxfev=200 * len(best.x), xatol=1e-10, fatol=1e-12),
        )
        best = min(best, found, key=lambda one: one.fun)
    zeta = np.roots((g0 + Z @ best.x)[::-1])
    return zeta if discrete else (zeta - 1) / (zeta + 1)


def _starts(g0, Z):
    """Projections of polynomials with few different roots, and random ones."""
    r = len(g0) - 1
    weight = np.array([comb(r, j) for j in range(r + 1)], float)
    for k in range(r + 1):
        for rho in (0.3, 0.8):
            wanted = np.poly(np.r_[np.full(r - k, rho), np.full(k, -rho)])[::-1]
            yield Z.T @ (wanted / weight - g0)
    rng = np.random.default_rng(0)
    for _ in range(max(STARTS - 2 * (r + 1), 4)):
        wanted = np.poly(rng.uniform(-0.9, 0.9, r))[::-1]
        yield Z.T @ (wanted / weight - g0)


def _radius_and_gradient(c, g0, Z):
    g = g0 + Z @ c
    zeta = np.roots(g[::-1])
    if len(zeta) == 0:
        return 0.0, np.zeros(len(c))
    top = zeta[np.argmax(np.abs(zeta))]
    slope = np.polyval(np.polyder(g[::-1]), top)
    if top == 0 or slope == 0:
        return float(abs(top)), np.zeros(len(c))
    moved = -(top ** np.arange(len(g)) @ Z) / slope
    return float(abs(top)), (top.conjugate() * moved).real / abs(top)
