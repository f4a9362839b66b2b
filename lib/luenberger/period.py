"""A continuous plant over one sampling period, on plain arrays: inputs and noise."""

import numpy as np
import scipy.linalg

from . import kernels
from .numeric import Matrix, Vector
from .numeric.balance import balanced, power_of_two
from .papers.hsia.derivation import noise_block, noise_doubled, noise_of_a_period


def hold(M: Matrix, N: Matrix, step: float | Vector) -> tuple[Matrix, Matrix]:
    """Exact discretisation of s' = M s + N u for u held over `step` seconds.

    Of several steps (N,), stacks with one for each.
    """
    k, m = N.shape
    block = np.block([[M, N], [np.zeros((m, k + m))]])
    E = scipy.linalg.expm(np.asarray(step)[..., None, None] * block)
    return E[..., :k, :k], E[..., :k, k:]


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
    top = 2.0 ** np.ceil(np.log2(T))
    for longest in np.unique(top):
        here = top == longest
        parts = _alike(A, B, np.zeros(A.shape) if Q is None else Q, T[here], longest)
        for whole, part in zip(found, parts):
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
    A_i, B_i = hold(A, B / inputs, T)
    gathered = np.zeros((len(T), *A.shape))
    if Q.any():
        gathered = _noise(A, intensity / noise, T, longest) * noise * both
    return A_i * x / states, B_i * x * inputs, gathered


def _size(X: Matrix, axis: int | None = None) -> np.ndarray | np.floating:
    """The power of two nearest to the largest entry, 1 where all are zero."""
    top = np.abs(X).max(axis=axis, initial=0.0)
    return power_of_two(np.where(top > 0, top, 1.0))


def _noise(A: Matrix, Q: Matrix, T: Vector, longest: float) -> Matrix:
    """Covariance of the noise of periods: Van Loan's exponential, then doubling.

    The exponential holds e^(-A t), which overflows for a stable plant and a long
    period; over a short one it does not, and doubling keeps Q semi-definite.
    """
    n, size = len(A), float(np.linalg.norm(A, 1)) * longest
    doublings = max(0, int(np.ceil(np.log2(max(size, 1.0)))))
    block = kernels.compiled(noise_block)(A=A, Q=Q)["Block"]
    E = scipy.linalg.expm(block * (T / 2**doublings)[:, None, None])
    Phi, have = E[:, n:, n:].mT, dict(X=E[:, :n, n:])
    P = kernels.run(noise_of_a_period, have | dict(Phi=Phi), stacks=True)["P"]
    for _ in range(doublings):
        P = kernels.run(noise_doubled, dict(Phi=Phi, P=P), stacks=True)["P_2"]
        Phi = Phi @ Phi
    return P
