"""The polynomial of least radius in an affine family: candidates, then descent."""

from collections.abc import Callable, Iterator
from math import comb

import numpy as np
import scipy.linalg

from . import Matrix, Vector
from .half_plane import to_disc

GRID = np.sin(np.linspace(0.01, np.pi / 2, 120))  # radii, denser towards 1
POWERS = (6, 20, 60)  # of the means that replace the radius, which is not smooth
DESCENTS = 8  # from the best starts, if none of the first finds a stable one
ENOUGH = 3
SIMPLEX = 8  # dimensions in which Nelder-Mead still gains on BFGS
STEPS = 80  # of a descent; fewer above the degree LARGE, where a step costs r^3
LARGE = 30
PLAIN = 20  # how many numbers k of roots at -rho are tried, about


def search(basis: Matrix, discrete: bool) -> Vector:
    """Roots, in s or z, of the polynomial of least radius that was found.

    Deterministic.  The radius is neither convex nor smooth, so the least one can be
    missed.  Where it is least most roots lie on the circle and many coincide; hence
    the candidates with all but m - 1 roots at rho and -rho, m the number of equations.
    """
    g0, Z, weight = _monic(to_disc(basis.astype(float), discrete))

    def value(c: Vector) -> float:
        return _radius(c, g0, Z, weight)

    several = list(_candidates(g0, Z, weight))
    wanted = [np.poly(roots)[::-1].real for roots in [*several, *_plain(len(g0) - 1)]]
    starts = [Z.T @ (g / weight - g0) for g in wanted]
    if Z.shape[1] == 1:
        starts += [np.array([x]) for x in np.tan(np.linspace(-1.55, 1.55, 201))]
    found: list[Vector] = []
    for count, start in enumerate(sorted(starts, key=value)[:DESCENTS]):
        large = len(g0) > LARGE + 1
        if count >= ENOUGH and (large or min(map(value, found)) < 1):
            break
        found += [start, *_descent(start, g0, Z, weight)]
    best = min(found, key=value)
    if len(best) <= SIMPLEX:
        calls = 2 * len(best) * _steps(len(g0) - 1)
        options = dict(maxfev=calls, xatol=1e-10, fatol=1e-12)
        best = scipy.optimize.minimize(
            value, best, method="Nelder-Mead", options=options
        ).x
    several.append(np.roots((weight * (g0 + Z @ best))[::-1]))
    zeta = min(several, key=lambda roots: np.abs(roots).max())
    return zeta if discrete else (zeta - 1) / (zeta + 1)


def _monic(g: Matrix) -> tuple[Vector, Matrix, Vector]:
    """g0, Z, weight: the monic polynomials of the family are weight (g0 + Z c)."""
    weight = np.array([comb(len(g) - 1, j) for j in range(len(g))], float)
    _, _, right = np.linalg.svd(g[-1:])
    one = g @ (right[0] / (g[-1] @ right[0])) / weight
    Z, _ = np.linalg.qr(g @ right[1:].T / weight[:, None])
    Z[-1] = 0  # monic, exactly
    return one, Z, weight


def _candidates(g0: Vector, Z: Matrix, weight: Vector) -> Iterator[Vector]:
    """Roots of (zeta - rho)^a (zeta + rho)^b f(zeta) in the family, deg f = m - 1.

    The m equations are linear in the coefficients of f, so that rho is where their
    determinant vanishes.
    """
    equations = scipy.linalg.null_space(np.column_stack([g0, Z]).T).T / weight
    m, r = len(equations), len(g0) - 1
    degree = r - m + 1
    windows = np.lib.stride_tricks.sliding_window_view(equations, degree + 1, axis=1)
    for b in range(degree + 1):
        at_one = np.poly(np.r_[np.ones(degree - b), -np.ones(b)])[::-1]

        def system(rho: float, at_one: Vector = at_one) -> Matrix:
            return windows @ (at_one * rho ** np.arange(degree, -1, -1))

        def determinant(
            rho: float, system: Callable[[float], Matrix] = system
        ) -> float:
            return np.linalg.det(system(rho))

        values = np.linalg.det(np.array([system(rho) for rho in GRID]))
        for low, high, u, v in zip(GRID, GRID[1:], values, values[1:]):
            if u * v < 0:
                rho = scipy.optimize.brentq(determinant, low, high)
                M = system(rho)
                f = np.linalg.lstsq(M[:, :-1], -M[:, -1], rcond=None)[0]
                circle = np.r_[np.full(degree - b, rho), np.full(b, -rho)]
                yield np.r_[circle, np.roots(np.r_[1.0, f[::-1]])]


def _plain(r: int) -> Iterator[Vector]:
    """Roots of polynomials to be projected on the family."""
    for k in range(0, r + 1, max(1, r // PLAIN)):
        for rho in (0.3, 0.8):
            yield np.r_[np.full(r - k, rho), np.full(k, -rho)]


def _descent(c: Vector, g0: Vector, Z: Matrix, weight: Vector) -> Iterator[Vector]:
    """Where the power means of the |roots| are least, the last near the radius."""
    for power in POWERS:
        c = scipy.optimize.minimize(
            _mean, c, (g0, Z, weight, power), jac=True, method="BFGS",
            options=dict(maxiter=_steps(len(g0) - 1)),
        ).x  # fmt: skip
        yield c


def _steps(r: int) -> int:
    return max(5, int(STEPS * min(1, LARGE / r) ** 3))


def _mean(
    c: Vector, g0: Vector, Z: Matrix, weight: Vector, power: int
) -> tuple[float, Vector]:
    """log of the power mean of the |roots|, and its gradient with respect to c."""
    g = weight * (g0 + Z @ c)
    zeta = np.roots(g[::-1])
    size = np.maximum(np.abs(zeta), np.finfo(float).tiny)
    slope = np.polyval(np.polyder(g[::-1]), zeta)
    slope = np.where(slope == 0, np.finfo(float).tiny, slope)
    share = (size / size.max()) ** power
    value = np.log(size.max()) + np.log(share.sum()) / power
    moved = -(zeta[:, None] ** np.arange(len(g)) @ (weight[:, None] * Z))
    with np.errstate(over="ignore", invalid="ignore"):
        each = (zeta.conj() / size**2 / slope)[:, None] * moved
        gradient = (share / share.sum()) @ each.real
    return value, gradient if np.isfinite(gradient).all() else np.zeros(len(c))


def _radius(c: Vector, g0: Vector, Z: Matrix, weight: Vector) -> float:
    return float(np.abs(np.roots((weight * (g0 + Z @ c))[::-1])).max())
