"""X = A X F' + N for many right sides and a small F that changes, A fixed.

With the complex Schur forms A = U a U*, F = V f V*, the columns of U* X V follow one
from the other by triangular solves: n^2 r operations once a is known, and no Kronecker
product.  LAPACK's routine for continuous time needs an inverse that need not exist.
"""

import numpy as np
from scipy.linalg import schur
from scipy.linalg.lapack import ztrtrs

from ...numeric import Matrix
from ...numeric.linalg import eye


class Schur:
    """A real matrix by its complex Schur form."""

    def __init__(self, A: Matrix) -> None:
        self.upper, self.basis = schur(A, output="complex", check_finite=False)

    def forward(self, F: "Schur", N: Matrix) -> Matrix:
        """X with X = A X F' + N; N is (n, r) or a stack (k, n, r)."""
        return self._march(F, N, adjoint=False)

    def backward(self, F: "Schur", N: Matrix) -> Matrix:
        """X with X = A'X F + N, the adjoint of `forward`."""
        return self._march(F, N, adjoint=True)

    def _march(self, F: "Schur", N: Matrix, adjoint: bool) -> Matrix:
        n, r, a = len(self.upper), len(F.upper), self.upper
        poles = F.upper.diagonal().conj()
        step, f = (a.conj().T, F.upper.T) if adjoint else (a, F.upper.conj())
        turned = (self.basis.conj().T @ N @ F.basis).T  # columns first
        Y = np.ascontiguousarray(turned).reshape(r, -1)
        for j in range(r) if adjoint else range(r)[::-1]:
            known = slice(0, j) if adjoint else slice(j + 1, r)
            right = Y[j] + (step @ (f[j, known] @ Y[known]).reshape(n, -1)).ravel()
            solved, _ = ztrtrs(
                eye(n) - poles[j] * a, right.reshape(n, -1), trans=2 * adjoint
            )
            Y[j] = solved.ravel()
        return (self.basis @ Y.reshape(N.T.shape).T @ F.basis.conj().T).real
