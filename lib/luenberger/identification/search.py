"""The search for the most likely values: a quasi-Newton method, made unit-free."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy  # its parts load when first used

from ..numeric import Matrix, Vector

NUDGE = 1e-4  # of the logarithm of a deviation, for second derivatives
FLAT = 1e-6  # a curvature below this part of the largest is none
SLOPE = 1e-7  # of the objective for each reading, at its end
DONE = 1e-10  # what one more step would gain, in units of the logarithm
ROUNDS = 4  # of search, each from where the last one ended

Objective = Callable[[Vector], tuple[float, Vector]]  # value to be least, and slope


def curvature(objective: Objective, theta: Vector) -> Matrix:
    """Second derivatives by differences of the slope."""
    steps = NUDGE * np.eye(len(theta))
    rows = [
        (objective(theta + d)[1] - objective(theta - d)[1]) / (2 * NUDGE) for d in steps
    ]
    found = np.array(rows).reshape(len(theta), len(theta))
    return 0.5 * (found + found.T)


def upward(H: Matrix) -> Matrix:
    """The inverse of a curvature whose directions are all taken to be upward."""
    unit = 1 / np.sqrt(np.where(H.diagonal() != 0, np.abs(H.diagonal()), 1.0))
    values, vectors = np.linalg.eigh(np.nan_to_num(H * unit * unit[:, None]))
    size = np.maximum(np.abs(values), FLAT * max(np.abs(values).max(initial=0), 1e-300))
    return (vectors / size) @ vectors.T * unit * unit[:, None]


def least(
    objective: Objective, theta: Vector, report: Callable[[int], object],
    inverse: Matrix | None = None,
) -> tuple[Vector, float]:  # fmt: skip
    """Where the objective is least, from a start, and its value there.

    Parameters
    ----------
    objective : callable
        The value, infinite where there is none, and the slope.
    theta : (k,) ndarray
    report : callable
        Is told how many evaluations were made.
    inverse : (k, k) ndarray, optional
        That of the curvature at the start, about; default from differences.
    """
    calls, best = 0, (np.inf, theta)

    def counted(theta: Vector) -> tuple[float, Vector]:
        nonlocal calls, best
        calls += 1
        report(calls)
        found = objective(theta)
        if found[0] < best[0]:
            best = found[0], theta.copy()
        return found

    before = counted(theta)[0]
    for _ in range(ROUNDS if len(theta) else 0):
        if inverse is None:
            inverse = upward(curvature(counted, best[1]))
        found = scipy.optimize.minimize(
            counted, best[1], jac=True, method="BFGS",
            options=dict(hess_inv0=_definite(inverse), gtol=SLOPE, maxiter=200),
        )  # fmt: skip
        gained, before, inverse = before - best[0], best[0], None
        if gained <= DONE or found.success:
            break
    return best[1], best[0]


def _definite(X: Matrix) -> Matrix:
    """A matrix that is as symmetric and definite as SciPy wants it."""
    X = 0.5 * (X + X.T)
    return X + 1e-12 * np.diag(np.abs(X.diagonal()))
