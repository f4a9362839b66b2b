"""What an error covariance claims of simulated errors, told from rounding.

Three sizes meet here.  The error's true covariance X is carried as a factor H, which
holds small directions that X itself would lose.  Rounding is carried as if it were
one more noise, of `ROUNDING` times the numbers that meet in each sum; its covariance
is B.  A direction in which H stays below B is null: errors there are rounding.  A
claim that is given as a matrix has the rounding of the variances it was propagated
from.  That decides what it says of null directions; elsewhere X is at hand.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg

from .. import kernels
from ..analysis.error_system import ErrorSystem, error_system
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import factor, lengths
from ..numeric.linalg import SINGULAR_TOL, eye, symmetrise
from ..observer import Observer
from ..papers.leondes_novak.derivation import error_recursion, side_by_side_step
from ..plant import Plant

ROUNDING = 1e-12  # of what meets in a sum: gains are solved for, so more than eps
RULED_OUT = 8  # times as large as that: more than rounding
ENTRIES = 2e-15  # rounding of an entry of a covariance that somebody computed
BLURRED = 0.1  # of a standard deviation: more of this than that covariance says of it


Part = tuple[Matrix, Matrix, int]  # of a claim, at one instant: root, null, rank


class Claim(NamedTuple):
    """An error covariance X at each instant, ready for e' X^+ e = |root e|^2."""

    root: np.ndarray  # (steps + 1, q, q), rows of zeros for directions without variance
    null: np.ndarray | None  # the same with rows N, |N e| <= 1 if e is rounding
    rank: np.ndarray  # (steps + 1,)


@dataclass(frozen=True, eq=False)
class Yardstick:
    """The true error at one instant, in coordinates that make it and rounding plain.

    Attributes
    ----------
    rows : (q, q) ndarray
        J of new coordinates: J e has the covariance diag(spread^2), and rounding in it
        has the size 1.
    spread : (q,) ndarray
        Largest first.
    size : (q,) ndarray
        Standard deviations that the claim's variances were propagated from.
    """

    rows: np.ndarray
    spread: np.ndarray
    size: np.ndarray

    def claim(self) -> Part:
        """root, null and rank if the true covariance is claimed."""
        real = self.spread > 1
        root = self.rows / np.where(real, self.spread, np.inf)[:, None]
        return root, self.rows * ~real[:, None], int(real.sum())

    def judge(self, X: Matrix, before: Matrix) -> Part:
        """root, null and rank of the claim X, which was propagated from `before`.

        Where X is not told from the rounding of its own entries, it claims nothing
        but that the error is no larger than that, or than the true one.
        """
        tol = SINGULAR_TOL * len(X)
        variances = self.size**2 + X.diagonal() + before.diagonal()
        propagated = np.sqrt(np.maximum(self.rows**2 @ variances, 1 / tol))
        unit = np.where(self.spread > 1, self.spread, propagated)
        rows = self.rows / unit[:, None]
        blur = _blur(rows, X)
        sharp = (self.spread <= 1) | (blur < BLURRED)
        values, vectors = np.linalg.eigh(symmetrise(rows[sharp] @ X @ rows[sharp].T))
        keep, axes = values > tol, vectors.T @ rows[sharp]
        none, rounding = axes[~keep], lengths(vectors.T[~keep] / unit[sharp])
        none = none / np.maximum(rounding, _blur(none, X))[:, None]
        blurred = rows[~sharp] / np.maximum(1, blur[~sharp])[:, None]
        root = axes[keep] / np.sqrt(values[keep])[:, None]
        null = np.vstack([none, blurred])
        return (
            np.vstack([root, np.zeros_like(null)]),
            np.vstack([np.zeros_like(root), null]),
            len(root),
        )


def true_claim(observer: Observer, plant: Plant, steps: int) -> Claim:
    """The claim of the observer's true error covariance."""
    return _stacked(yard.claim() for yard in yardsticks(observer, plant, steps))


def given_claim(observer: Observer, plant: Plant, steps: int, X: Matrix) -> Claim:
    """The claim of (steps + 1, q, q) covariances X, right or wrong."""
    yards = yardsticks(observer, plant, steps)
    before = np.concatenate([X[:1], X[:-1]])
    return _stacked(yard.judge(*pair) for yard, *pair in zip(yards, X, before))


def _stacked(parts: Iterable[Part]) -> Claim:
    root, null, rank = map(np.stack, zip(*parts))
    return Claim(root, null if null.any() else None, rank)


def yardsticks(observer: Observer, plant: Plant, steps: int) -> Iterator[Yardstick]:
    """Those of the rows 0 .. steps of `error_covariance`.

    Sizes are standard deviations, that of x about zero.  A sum has the size of its
    terms taken at their magnitudes, so that what cancels in it is counted.
    """
    system = error_system(observer, plant, steps)
    x = [np.sqrt(np.maximum(X.diagonal(), 0)) for X in system.of_state(steps)]
    L, back = np.abs(observer.L), np.abs(np.linalg.pinv(observer.L))
    if observer.steps is not None:
        root = factor(plant.P0)
        yield yardstick(observer.L @ root, _noise(L @ x[0]), L @ lengths(root))
    first, spread = x[system.instant(0)], np.sqrt(plant.P0.diagonal())
    if observer.steps is not None and not plant.at_first:  # x of instant 1
        A, w = np.abs(plant.at(0).A), np.sqrt(system.noise(0)["Q"].diagonal())
        first, spread = A @ x[0] + w, A @ spread + w
    z = np.abs(system.first_sample()[0]) @ first + np.abs(observer.z0)
    start = np.concatenate([first, z])
    B = _noise(start[len(start) - len(system.start()) :])
    step = kernels.compiled(error_recursion)
    for k, (root, given) in enumerate(system.factors(steps)):
        F, P, V = given["F"], given["P"], np.abs(given["V"])
        w, v, eps = (lengths(given[name]) for name in ("Nw", "Nv", "H"))
        now, more = _sums(system, k, given, x[system.instant(k)])
        size = L @ spread + np.abs(P) @ eps + V @ v
        none = np.zeros((len(B), len(now)))
        found = step(  # as if rounding were the noise
            F=F, P=P, X=B, D=none, T_next=eye(len(B)), V=eye(len(now)), S=none,
            Q=_noise(more), R=_noise(now),
        )  # fmt: skip
        yield yardstick(root, found["Sigma"], size)
        B = found["X_next"]
        A = np.abs(plant.at(system.instant(k)).A)
        spread = A @ (back @ lengths(root)) + w


def _sums(
    system: ErrorSystem, k: int, given: Matrices, x: Vector
) -> tuple[Vector, Vector]:
    """Sizes of the terms that make e at row k, and of those that make eps after it.

    They are those of plant and observer side by side, where nothing cancels.
    """
    o = system.observer
    now = system.plant.at(system.instant(k))
    T = np.abs(o.T if o.steps is None else o.T[k])
    w, v, eps = (lengths(given[name]) for name in ("Nw", "Nv", "H"))
    own = slice(len(eps) - o.order, None)  # beside them there may be those of x
    have = dict(zip("FGDPVW", o.at(k))) | dict(A=now.A, C=now.C)
    have = {name: np.abs(X) for name, X in have.items()} | dict(L=-np.abs(o.L))
    have |= dict(Hw=w[:, None], Hv=v[:, None], xi=np.ones((1, 1)))
    have |= dict(x=x[:, None], z=(T @ x + eps[own])[:, None])
    found = kernels.run(side_by_side_step, have, "e", "z_next", "x_next")
    more = np.abs(given["T_next"]) @ found["x_next"][:, 0]
    more[own] += found["z_next"][:, 0]
    return found["e"][:, 0], more


def yardstick(H: Matrix, rounding: Matrix, size: Vector) -> Yardstick:
    """From a factor of the true covariance and the covariance of rounding."""
    unit = np.sqrt(rounding.diagonal())
    unit = np.where(unit > 0, unit, 1.0)
    eye = np.eye(len(unit))
    lower = np.linalg.cholesky(rounding / unit / unit[:, None] + SINGULAR_TOL * eye)
    white = scipy.linalg.solve_triangular(lower, H / unit[:, None], lower=True)
    U, spread, _ = np.linalg.svd(white)
    rows = scipy.linalg.solve_triangular(lower, U, lower=True, trans=1).T / unit
    return Yardstick(rows, np.pad(spread, (0, len(H) - len(spread))), size)


def _blur(rows: Matrix, X: Matrix) -> Vector:
    """What the entries of X leave open, as standard deviations along `rows`."""
    rows = np.abs(rows)
    return np.sqrt(ENTRIES * np.einsum("ij,jk,ik->i", rows, np.abs(X), rows))


def _noise(size: Vector) -> Matrix:
    """The covariance of rounding in sums of such sizes."""
    return np.diag((ROUNDING * size) ** 2)
