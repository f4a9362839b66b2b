"""Exponentials of one matrix over many times.

SciPy's `expm` takes a stack one matrix after the other.  Here the matrix is the same
for all times, so its powers are made once, and the series is summed for all times.
"""

from math import factorial

import numpy as np

from . import Matrix, Vector

DEGREE = 20  # 1 / 20! is below rounding, also beside a block that is integrated


def squarings(M: Matrix) -> int:
    """How often M is halved until no column's entries have a sum above one."""
    size = float(np.abs(M).sum(axis=0).max(initial=0.0))
    return max(0, int(np.ceil(np.log2(max(size, 1.0)))))


def series(M: Matrix, times: Vector) -> Matrix:
    """exp(M t) for each of `times` (N,) in (0, 1]: a stack (N, k, k).

    For M with column sums up to one, but for a block above the diagonal blocks, which
    the exponential integrates.  Each entry is summed by itself, so an exponential does
    not hang on which other times there are.

    >>> series(np.array([[0.0, 3.0], [0.0, 0.0]]), np.array([0.5, 1.0]))[:, 0, 1]
    array([1.5, 3. ])
    """
    powers = [np.eye(len(M))]
    for _ in range(DEGREE):
        powers.append(powers[-1] @ M)
    terms = np.array([X.ravel() / factorial(k) for k, X in enumerate(powers)])
    found = np.zeros((len(times), terms.shape[1]))
    for entry in np.flatnonzero(terms.any(axis=0)):
        total = np.full(len(times), terms[DEGREE, entry])
        for term in terms[DEGREE - 1 :: -1, entry]:
            total *= times
            total += term
        found[:, entry] = total
    return found.reshape(len(times), *M.shape)


def squared(E: Matrix, count: int) -> Matrix:
    """Each of a stack to the power 2^count."""
    for _ in range(count):
        E = E @ E
    return E
