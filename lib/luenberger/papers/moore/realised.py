"""An observer of k x with given factors, and what rounding leaves of it.

Source: papers/moore/derivation/observer.py for the chain; what the others are, they
say.
"""

import dataclasses
from collections.abc import Iterator

import numpy as np

from ...numeric import Matrix, Vector
from .companion_chain import Chain, Factors, chain, in_order
from .driven import driven
from .orthonormal import orthonormal
from .recurrences import OverRationals, Polynomials

ACCURATE = 1e-12  # an error of the estimate, relative to k, that needs no better
LOST_TOL = 1e-6  # an error above it is not rounding
RESIDUAL_TOL = 1e-10  # of T A - F T = D C, beside its terms
DEPENDENT = 1e-8  # rows of T so dependent, at length one, say little of each other


def built(
    admissible: Polynomials, factors: Factors, poles: Vector
) -> tuple[Chain, float]:
    """The observer in the user's units, and its error: see `_error`.

    Where the chain has lost digits others are tried, which lose fewer.
    """
    A, C, k = admissible.A, admissible.C, admissible.k
    found = chain(A, C, k, factors)
    if isinstance(admissible, OverRationals):
        return found, _error_of_rounding(admissible, found, poles)
    found = _scaled(admissible, found)
    error = _error(admissible, found, poles)
    for other in _others(A, C, k, in_order(poles)):
        if error <= ACCURATE:
            break
        better = _error(admissible, other, poles)
        if better < error:
            found, error = other, better
    d, outputs = admissible.d, admissible.outputs
    return dataclasses.replace(found, T=found.T / d, D=found.D / outputs), error


def _others(A: Matrix, C: Matrix, k: Vector, poles: Vector) -> Iterator[Chain]:
    found = driven(A, C, k, poles)
    yield found
    if len(C) == 1 or np.linalg.matrix_rank(found.T, DEPENDENT) == len(poles):
        found = orthonormal(A, C, k, found, poles)
        if found is not None:
            yield found


def _error_of_rounding(admissible: OverRationals, found: Chain, poles: Vector) -> float:
    """What an exact chain loses when its matrices become floats."""
    floats = admissible.rounded
    F, D, T, P = (X.astype(float) for X in (found.F, found.D, found.T, found.P))
    rounded = Chain(F, D * floats.outputs, T * floats.d, P)
    return _error(floats, rounded, poles)


def _scaled(admissible: Polynomials, found: Chain) -> Chain:
    """The chain with rows of T at comparable size.

    A row is divided by the size of its terms, not by its own: it can be rounding.
    """
    terms = found.T @ admissible.A, found.D @ admissible.C
    size = np.linalg.norm(terms, axis=2).sum(axis=0)
    size = np.r_[np.linalg.norm(admissible.k), size][: len(size)]
    size = np.exp2(np.round(np.log2(np.where(size > 0, size, 1.0))))  # exact to divide
    return dataclasses.replace(
        found,
        F=found.F / size[:, None] * size,
        D=found.D / size[:, None],
        T=found.T / size[:, None],
        P=found.P * size,
    )


def _error(admissible: Polynomials, found: Chain, poles: Vector) -> float:
    """Error that the state drives into the estimate, relative to k, in scaled units.

    The largest of |P T - k + P (s I - F)^-1 (T A - F T - D C)| over s = 0 (z = 1)
    and the frequencies of the poles.  A residual that the certificate would notice
    counts as lost, whatever comes of it.
    """
    A, C, k, o = admissible.A, admissible.C, admissible.k, found
    dynamics = o.T @ A - o.F @ o.T - o.D @ C
    output = o.P @ o.T - k
    s = np.r_[0, poles.imag] * 1j
    if admissible.discrete:
        s = np.exp(1j * np.r_[0, np.angle(poles)])
    s = s[np.abs(s[:, None] - poles).min(axis=1) > 0]  # not stable: refused elsewhere
    eye = np.eye(len(poles))
    errors = [output + o.P @ np.linalg.solve(x * eye - o.F, dynamics) for x in s]
    norm = np.linalg.norm
    terms = norm(o.T) * (norm(A) + norm(o.F)) + norm(o.D) * norm(C)
    relative = norm(dynamics) / terms if terms > 0 else 0.0
    error = max(map(norm, errors), default=0.0) / (norm(k) if k.any() else 1.0)
    return float(max(error, relative * (LOST_TOL / RESIDUAL_TOL)))
