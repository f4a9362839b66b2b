"""Sizes in units of a covariance, with what rounding may add to them."""

from __future__ import annotations

from math import sqrt

import numpy as np
from scipy.linalg.lapack import dtrtrs

from ..numeric import Matrix, Vector
from ..numeric.factors import EPS
from ..numeric.linalg import eye
from ..numeric.rounded import Rounded


class Measure:
    """H = root root', in units of which vectors and covariances are measured.

    Whatever the root is, H is its square exactly.  What is found is an upper bound:
    `slack` is what the rounding of the inverse may do to it.
    """

    def __init__(self, root: Matrix) -> None:
        self.root, n = root, len(root)
        self.inverse = dtrtrs(root, eye(n), lower=1)[0] if n else root  # LAPACK prints
        wrong = (n + 2) * EPS * _length(np.abs(self.inverse) @ np.abs(root))
        self.slack = 1 / (1 - wrong) if wrong < 0.5 else np.inf

    def size(self, X: Rounded) -> float:
        """The least t with -t H <= X <= t H, for a symmetric X."""
        n, size = len(self.root), np.abs(self.inverse)
        if not (np.isfinite(X.value).all() and np.isfinite(X.off).all()):
            return np.inf
        inner = self.inverse @ X.value @ self.inverse.T
        largest = np.abs(np.linalg.eigvalsh(inner)).max(initial=0.0)
        off = X.off + (2 * n + 4) * EPS * np.abs(X.value)
        lost = n * EPS * _length(inner) + _length(size @ off @ size.T)
        return float(self.slack**2 * (largest + lost))

    def norm(self, X: Rounded) -> float:
        """The largest singular value of root^-1 X."""
        n = len(self.root)
        if not (X.value.size and np.isfinite(X.off).all()):
            return np.inf if X.value.size else 0.0
        inner = self.inverse @ X.value
        off = X.off + (n + 2) * EPS * np.abs(X.value)
        lost = n * EPS * _length(inner) + _length(np.abs(self.inverse) @ off)
        square = np.linalg.eigvalsh(inner @ inner.T)[-1]  # cheaper than its root
        square += (2 * n + inner.shape[1]) * EPS * _length(inner) ** 2
        return float(self.slack * (np.sqrt(square) + lost))

    def length(self, size: Vector) -> float:
        """That of a vector whose entries have at most these sizes."""
        return float(self.slack * _length(np.abs(self.inverse) @ size))


def _length(X: Matrix) -> float:
    return sqrt(np.vdot(X, X))
