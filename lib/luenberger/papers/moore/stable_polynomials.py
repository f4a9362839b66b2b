"""Which polynomial of an affine family is stable, and which decays fastest.

A family is a matrix `basis`, (r + 1, d + 1): its polynomials beta = basis y have their
coefficients in ascending order and a leading one.  Stable means Hurwitz, or Schur in
discrete time.  Both are the same question, seen in the half plane of w or in the disc
of zeta = (1 + w) / (1 - w); how fast a polynomial decays is measured by its radius,
the largest |zeta| of its roots, so that no optimum lies at infinity.

Every coefficient of a stable polynomial, in w, is positive, and the polynomials with
one positive coefficient and zeros are limits of stable ones.  As the stable ones are
connected, a single equation a h = 0 on the coefficients h has a stable solution
exactly when a has entries of both signs.

Source: Fam and Meditch (1978) for the hull; Blondel, Gurbuzbalaban, Megretski and
Overton (2012) for the optimum under one equation.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import comb

import numpy as np
import scipy.linalg

from ...numeric import Matrix, Vector, rationals

ROUNDING = 1e-13  # a coefficient this small beside the largest is zero, in floats


def to_half_plane(basis: Matrix, discrete: bool) -> Matrix:
    """Coefficients in w of polynomials in s = w, or z = (1 + w) / (1 - w); exact."""
    if not discrete:
        return basis
    r = len(basis) - 1
    M = np.array([_product(r - j, j) for j in range(r + 1)], dtype=object).T
    return (M if basis.dtype == object else M.astype(float)) @ basis


def _product(minus: int, plus: int) -> Vector:
    """Coefficients of (1 - w)^minus (1 + w)^plus, as integers."""
    left = [(-1) ** i * comb(minus, i) for i in range(minus + 1)]
    return np.convolve(
        np.array(left, dtype=object),
        np.array([comb(plus, i) for i in range(plus + 1)], dtype=object),
    )


def to_disc(basis: Matrix, discrete: bool) -> Matrix:
    """Coefficients in zeta, up to a common factor."""
    r = len(basis) - 1
    if discrete:
        return basis
    # w = (zeta - 1) / (zeta + 1)
    M = [(-1) ** j * _product(j, r - j) for j in range(r + 1)]
    return np.array(M).astype(float).T @ basis


def radius(roots: Vector, discrete: bool) -> float:
    """Largest |zeta| of roots in s or z; infinite when s = 1 is one of them."""
    if discrete:
        return float(np.abs(roots).max(initial=0))
    with np.errstate(divide="ignore"):
        return float((np.abs(1 + roots) / np.abs(1 - roots)).max(initial=0))


def is_stable(beta: Vector, discrete: bool) -> bool:
    """Routh's test: exact for Fractions; in floats what is rounding is not stable."""
    h = to_half_plane(beta[:, None], discrete)[:, 0][::-1]
    h = h if h[0] > 0 else -h
    least = 0 if h.dtype == object else ROUNDING * np.abs(h).max()
    if not (h > least).all():
        return False
    while len(h) > 1:
        if not h[1] > 0:
            return False
        rest = h[1:].copy()
        rest[1:-1:2] -= h[0] / h[1] * h[3::2]
        h = rest
    return True


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


STABLE_TOL = 1e-9  # a radius this close to 1 is called on the boundary
SIGN_TOL = 1e-11  # an entry of a this small beside the largest is called zero
DENOMINATORS = (1, 2, 4, 5, 8, 10, 16, 50, 100, 1000, 10**4, 10**6, 10**9, 10**12)


@dataclass(frozen=True)
class Answer:
    """A stable polynomial by its roots, in s or z, or why there is none.

    `beta` is exact when the family is; `decided` says what the answer rests on:
    "exact", "sign condition" (a proof that there is none) or "search" (no proof when
    it finds none).
    """

    decided: str
    stable: bool
    roots: np.ndarray | None = None
    beta: np.ndarray | None = None


def decide(basis: Matrix, discrete: bool) -> Answer:
    """The stable polynomial of least radius in the family, as an `Answer`."""
    r, d = basis.shape[0] - 1, basis.shape[1] - 1
    if d == 0:
        return _point(basis[:, 0] / basis[-1, 0], discrete)
    if d == r:
        roots = np.full(r, 0.0 if discrete else -1.0)
        return Answer("exact", True, roots, _powers(roots, basis))
    rows = annihilator(to_half_plane(basis, discrete))
    if len(rows) == 1:
        return _one_equation(rows[0], basis, discrete)
    if one_signed(rows):
        return Answer("sign condition", False)
    return _searched(basis, discrete)


def _searched(basis: Matrix, discrete: bool) -> Answer:
    roots = search(basis, discrete)
    if radius(roots, discrete) < 1 - STABLE_TOL:
        return _rounded("search", roots, basis, discrete)
    return Answer("search", False)


def _point(beta: Vector, discrete: bool) -> Answer:
    roots = np.roots(beta[::-1].astype(float))
    stable = is_stable(beta, discrete)
    if beta.dtype != object:
        stable = stable and radius(roots, discrete) < 1 - STABLE_TOL
    return Answer("exact", stable, roots, beta)


def _powers(roots: Vector, basis: Matrix) -> Vector:
    """The polynomial with these integer roots, exact if the family is."""
    beta = np.array(np.poly(roots)[::-1])
    if basis.dtype != object:
        return beta
    return rationals.zeros(len(beta)) + beta.astype(int)


def annihilator(h: Matrix) -> Matrix:
    """Independent rows a with a h = 0."""
    if h.dtype == object:
        return rationals.null_space(h.T).T
    return scipy.linalg.null_space(h.T).T


def one_signed(rows: Matrix) -> bool:
    """Whether a combination a of the rows has one sign: then no h > 0 has a h = 0.

    A proof for exact rows, where the combination that linear programming finds is
    rounded to Fractions and checked.
    """
    if any(_signs(row) < 2 for row in rows):
        return True
    floats = rows.astype(float)
    size = np.linalg.norm(floats, axis=1, keepdims=True)
    m, count = floats.shape
    # the largest t with every entry of the combination >= t
    found = scipy.optimize.linprog(
        np.r_[np.zeros(m), -1.0],
        A_ub=np.hstack([-(floats / size).T, np.ones((count, 1))]),
        b_ub=np.zeros(count),
        bounds=[(-1, 1)] * m + [(None, 1)],
    )
    if not found.success or found.x[-1] <= SIGN_TOL:
        return False
    if rows.dtype != object:  # linear programming takes small entries for zeros
        return bool((found.x[:-1] @ (floats / size)).min() > SIGN_TOL)
    return _signs(_fractions(found.x[:-1] / size[:, 0]) @ rows) < 2


def _fractions(floats: Vector) -> Vector:
    return np.array([Fraction(x) for x in floats], dtype=object)


def _signs(a: Vector) -> int:
    """How many signs the entries of a have."""
    if a.dtype != object:
        weighed = np.abs(a) * [comb(len(a) - 1, j) for j in range(len(a))]
        a = np.where(weighed > SIGN_TOL * weighed.max(), a, 0.0)
    return int((a > 0).any()) + int((a < 0).any())


def _one_equation(a: Vector, basis: Matrix, discrete: bool) -> Answer:
    """One equation a h = 0: decided by signs, solved by two real roots.

    An optimum has the form (zeta - rho)^(r-k) (zeta + rho)^k, so the least rho for
    which some k meets the equation is sought among the roots of r + 1 polynomials.
    """
    if _signs(a) == 1:
        return Answer("exact", False)
    found = [
        (q, k) for k, f in enumerate(_spread(a.astype(float))) for q in _beyond_one(f)
    ]
    if not found:  # a double root that rounding took off the real line
        return _searched(basis, discrete)
    q, k = min(found)
    # zeta = rho is w = -1 / q, zeta = -rho is w = -q
    w = np.r_[np.full(len(a) - 1 - k, -1 / q), np.full(k, -q)]
    roots = (1 + w) / (1 - w) if discrete else w
    return _rounded("exact", roots, basis, discrete)


def _spread(a: Vector) -> Iterator[Vector]:
    """a h of h = (1 + q w)^(r-k) (q + w)^k for k = 0 .. r, as polynomials in q."""
    r = len(a) - 1
    for k in range(r + 1):
        h = np.zeros((r + 1, r + 1))  # by powers of w and of q
        h[0, 0] = 1
        for _ in range(r - k):
            h = h + np.roll(h, 1, (0, 1))
        for _ in range(k):
            h = np.roll(h, 1, 1) + np.roll(h, 1, 0)
        yield a @ h


def _beyond_one(f: Vector) -> list[float]:
    """Real roots q >= 1 of f, which may start at q = 1."""
    size = np.abs(f)
    if abs(f.sum()) <= SIGN_TOL * size.sum():
        return [1.0]
    top = np.flatnonzero(size > SIGN_TOL * size.max())[-1]
    roots = np.roots(f[top::-1])
    return [float(q.real) for q in roots if abs(q.imag) < 1e-9 * abs(q) and q.real > 1]


def _rounded(decided: str, roots: Vector, basis: Matrix, discrete: bool) -> Answer:
    """The answer; in an exact family a simple rational polynomial near the optimum."""
    if basis.dtype != object:
        beta = np.poly(roots).real[::-1]
        return Answer(decided, radius(roots, discrete) < 1 - STABLE_TOL, roots, beta)
    wanted = np.poly(roots).real[::-1]
    least = radius(roots, discrete)
    free, base, Z = _free(basis)
    for denominator in DENOMINATORS:
        c = [Fraction(wanted[j]).limit_denominator(denominator) for j in free]
        beta = base + Z @ np.array(c, dtype=object)
        found = np.roots(beta[::-1].astype(float))
        near = radius(found, discrete) < 0.8 * least + 0.2
        if near and is_stable(beta, discrete):
            return Answer(decided, True, found, beta)
    return Answer(decided, False)


def _free(basis: Matrix) -> tuple[list[int], Vector, Matrix]:
    """Coefficients that may be chosen, and how the others follow: base + Z c."""
    r, d = basis.shape[0] - 1, basis.shape[1] - 1
    echelon, pivots = rationals.reduced(basis[::-1].T)  # the leading one first
    free = [r - j for j in pivots[1:]]
    assert pivots[0] == 0 and len(free) == d
    return free, echelon[0][::-1], echelon[1:, ::-1].T
