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

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import comb

import numpy as np
import scipy.linalg

from . import Matrix, Vector, rationals
from .half_plane import is_stable, radius, to_half_plane
from .polynomial_search import search

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
