"""A continuous plant over one sampling period, on plain arrays: inputs and noise.

SciPy's `expm` takes a stack one matrix after the other.  Here the matrix is the same
for all times, so its powers are made once, and the series is summed for all times.
"""

from math import factorial

import numpy as np
import scipy.linalg

from . import kernels
from .numeric import Matrix, Vector
from .numeric.balance import balanced, power_of_two
from .papers.hsia.derivation import noise_block, noise_doubled, noise_of_a_period

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


TOGETHER = 1 << 12  # periods whose exponentials are held at once


def hold(M: Matrix, N: Matrix, step: float) -> tuple[Matrix, Matrix]:
    """Exact discretisation of s' = M s + N u for u held over `step` seconds."""
    k = len(M)
    E = scipy.linalg.expm(step * _held(M, N))
    return E[:k, :k], E[:k, k:]


def _held(M: Matrix, N: Matrix) -> Matrix:
    """The block matrix of a state and an input that is held."""
    k, m = N.shape
    return np.block([[M, N], [np.zeros((m, k + m))]])


def over_periods(
    A: Matrix, B: Matrix, Q: Matrix | None, T: Vector
) -> tuple[Matrix, Matrix, Matrix | None]:
    """A, B and, if there is noise of intensity Q, its covariance over T (N,) seconds.

    They are stacks (N, n, n), (N, n, m), (N, n, n), one for each period.  Periods
    between two powers of two are done at once; what comes out of one does not hang on
    which others there are.
    """
    n, m = B.shape
    found = np.empty((len(T), n, n)), np.empty((len(T), n, m)), np.empty((len(T), n, n))
    noise = np.zeros(A.shape) if Q is None else Q
    top = 2.0 ** np.ceil(np.log2(T))
    for longest in np.unique(top):
        alike = np.flatnonzero(top == longest)
        for k in range(0, len(alike), TOGETHER):
            here = alike[k : k + TOGETHER]
            for whole, part in zip(found, _alike(A, B, noise, T[here], longest)):
                whole[here] = part
    return found[0], found[1], None if Q is None else found[2]


def _alike(
    A: Matrix, B: Matrix, Q: Matrix, T: Vector, longest: float
) -> tuple[Matrix, Matrix, Matrix]:
    """The same of periods of like length, at most the `longest`.

    In units in which no entry drowns another: the exponential rounds beside a norm.
    """
    none = np.zeros((0, len(A))), np.zeros(0)  # no outputs
    states, _ = balanced(A * longest, none[0], Q.diagonal() * longest, none[1])
    x, both = states[:, None], np.outer(states, states)
    A, B, intensity = A / x * states, B / x, Q / both
    inputs, noise = _size(B, axis=0), _size(intensity)
    times, halvings, n = T / longest, squarings(A * longest), len(A)
    block = _held(A, B / inputs) * (longest / 2**halvings)
    E = squared(series(block, times), halvings)
    gathered = np.zeros((len(T), *A.shape))
    if Q.any():
        scale = longest / 2**halvings
        gathered = _noise(A * scale, intensity / noise * scale, times, halvings)
        gathered *= noise * both
    return E[:, :n, :n] * x / states, E[:, :n, n:] * x * inputs, gathered


def _size(X: Matrix, axis: int | None = None) -> np.ndarray | np.floating:
    """The power of two nearest to the largest entry, 1 where all are zero."""
    top = np.abs(X).max(axis=axis, initial=0.0)
    return power_of_two(np.where(top > 0, top, 1.0))


def _noise(A: Matrix, Q: Matrix, times: Vector, doublings: int) -> Matrix:
    """Covariance of the noise of periods: Van Loan's exponential, then doubling.

    The exponential holds e^(-A t), which overflows for a stable plant and a long
    period; over a short one it does not, and doubling keeps Q semi-definite.
    """
    n = len(A)
    E = series(kernels.compiled(noise_block)(A=A, Q=Q)["Block"], times)
    Phi, have = E[:, n:, n:].mT, dict(X=E[:, :n, n:])
    P = kernels.run(noise_of_a_period, have | dict(Phi=Phi), stacks=True)["P"]
    for _ in range(doublings):
        P = kernels.run(noise_doubled, dict(Phi=Phi, P=P), stacks=True)["P_2"]
        Phi = Phi @ Phi
    return P
