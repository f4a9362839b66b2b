"""A continuous plant over one sampling period, on plain arrays: inputs and noise."""

import numpy as np
import scipy.linalg

from . import kernels
from .numeric import Matrix
from .numeric.balance import balanced, power_of_two
from .papers.hsia.derivation import noise_block, noise_doubled, noise_of_a_period


def hold(M: Matrix, N: Matrix, step: float) -> tuple[Matrix, Matrix]:
    """Exact discretisation of s' = M s + N u for u held over `step` seconds."""
    k, m = N.shape
    E = scipy.linalg.expm(step * np.block([[M, N], [np.zeros((m, k + m))]]))
    return E[:k, :k], E[:k, k:]


def over_period(
    A: Matrix, B: Matrix, Q: Matrix | None, T: float
) -> tuple[Matrix, Matrix, Matrix | None]:
    """A, B and, if there is noise of intensity Q, its covariance over T seconds.

    In units in which no entry drowns another: the exponential rounds beside a norm.
    """
    n, intensity = len(A), np.zeros(A.shape) if Q is None else Q
    none = np.zeros((0, n)), np.zeros(0)  # no outputs
    states, _ = balanced(A * T, none[0], intensity.diagonal() * T, none[1])
    x, both = states[:, None], np.outer(states, states)
    A, B, intensity = A / x * states, B / x, intensity / both
    inputs, noise = _size(B, axis=0), _size(intensity)
    A_i, B_i = hold(A, B / inputs, T)
    gathered = None if Q is None else _noise(A, intensity / noise, T) * noise * both
    return A_i * x / states, B_i * x * inputs, gathered


def _size(X: Matrix, axis: int | None = None) -> np.ndarray | np.floating:
    """The power of two nearest to the largest entry, 1 where all are zero."""
    top = np.abs(X).max(axis=axis, initial=0.0)
    return power_of_two(np.where(top > 0, top, 1.0))


def _noise(A: Matrix, Q: Matrix, T: float) -> Matrix:
    """Covariance of the noise of one period: Van Loan's exponential, then doubling.

    The exponential holds e^(-A t), which overflows for a stable plant and a long
    period; over a short one it does not, and doubling keeps Q semi-definite.
    """
    n = len(A)
    doublings = max(0, int(np.ceil(np.log2(max(float(np.linalg.norm(A, 1)) * T, 1.0)))))
    block = kernels.compiled(noise_block)(A=A, Q=Q)["Block"]
    E = scipy.linalg.expm(block * (T / 2**doublings))
    Phi = E[n:, n:].T
    Q = kernels.compiled(noise_of_a_period)(Phi=Phi, X=E[:n, n:])["P"]
    for _ in range(doublings):
        Q = kernels.compiled(noise_doubled)(Phi=Phi, P=Q)["P_2"]
        Phi = Phi @ Phi
    return Q
