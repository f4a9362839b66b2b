"""X = A X F' + N for many right sides and a small F that changes, A fixed.

With the complex Schur forms A = U a U*, F = V f V*, the columns of U* X V follow one
from the other by triangular solves: n^2 r operations once a is known, and no Kronecker
product.  LAPACK's routine for continuous time needs an inverse that need not exist.
"""

import numpy as np
from scipy.linalg import schur
from scipy.linalg.lapack import ztrtrs


class Schur:
    """A real matrix by its complex Schur form."""

    def __init__(self, A):
        self.upper, self.basis = schur(A, output="complex", check_finite=False)

    def forward(self, F, N):
        """X with X = A X F' + N; N is (n, r) or a stack (k, n, r)."""
        return self._march(F, N, range(len(F.upper))[::-1], adjoint=False)

    def backward(self, F, N):
        """X with X = A'X F + N, the adjoint of `forward`."""
        return self._march(F, N, range(len(F.upper)), adjoint=True)

    def _march(self, F, N, columns, adjoint):
        a, f = self.upper, F.upper.T if adjoint else F.upper.conj()
        step = a.conj().T if adjoint else a
        Y = np.atleast_3d((self.basis.conj().T @ N @ F.basis).T)  # columns first
        Y = np.ascontiguousarray(Y.reshape(N.shape[-1], N.shape[-2], -1))
        known = []
        for j in columns:
            if known:
                Y[j] += step @ np.tensordot(f[j, known], Y[known], 1)
            shifted = np.eye(len(a)) - F.upper[j, j].conj() * a
            Y[j], _ = ztrtrs(shifted, Y[j], trans=2 if adjoint else 0)
            known.append(j)
        return (self.basis @ Y.reshape(N.T.shape).T @ F.basis.conj().T).real
