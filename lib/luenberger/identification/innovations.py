"""What a row's innovation says of the likelihood, where its covariance may be singular.

An entry of a row that the entries before it determine has no density.  It is left out,
and what it did to the prediction is what those do.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri

from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import CLEAR, lengths
from ..recursion.state import Step


class Innovation(NamedTuple):
    """One row: `free` are its entries that count, of all that arrived.

    Attributes
    ----------
    free : (k,) ndarray of int
        Where they are.
    log_det : float
        Of their covariance.
    z : (k,) ndarray
        Their innovations, whitened: z z' adds up to the exponent.
    whitening : (k, k) ndarray
        What makes z of the innovations; W = whitening' whitening.
    taken : (p_seen, k) ndarray
        What each entry's innovation is, made of theirs.
    """

    free: np.ndarray
    log_det: float
    z: np.ndarray
    whitening: np.ndarray
    taken: np.ndarray

    def found(self) -> Matrices:
        """W and e of the entries that count, and `taken`."""
        W = self.whitening.T @ self.whitening
        e = self.whitening.T @ self.z[:, None]
        return dict(W=W, e=e, taken=self.taken)


def counted(row: Step) -> Innovation:
    """Of a row that NumPy did, from a factor of M.

    Where covariances were carried as factors it is [L, V], and else every entry counts.
    Where outputs have no noise, `unit` is the rounding of its rows.
    """
    new, now, innovation = row.new, row.state.setting, row.innovation[:, 0]
    assert now is not None
    if "L" not in new:
        return _all_counted(new["M"], innovation)
    Z = np.concatenate([new["L"], now.V], axis=1)
    unit = new.get("unit", np.zeros(len(Z)))
    size = np.where(unit > 0, unit, lengths(Z))
    size = np.where(size > 0, size, 1.0)
    rows = Z / size[:, None]
    free = _independent(rows, CLEAR * (unit > 0))
    Q, upper = np.linalg.qr(rows[free].T)
    sign = np.where(upper.diagonal() < 0, -1.0, 1.0)  # as Cholesky's triangle has it
    Q, upper = Q * sign, upper * sign[:, None]
    inverse = dtrtri(upper)[0] if len(free) else upper
    whitening = np.triu(inverse).T / size[free]
    taken = Z @ Q @ whitening
    diagonal = upper.diagonal() * size[free]
    log_det = 2 * float(np.log(diagonal).sum())
    return Innovation(free, log_det, whitening @ innovation[free], whitening, taken)


def _all_counted(M: Matrix, innovation: Vector) -> Innovation:
    """The same where M is safely definite."""
    all_ = np.arange(len(M))
    if not len(M):
        return Innovation(all_, 0.0, np.zeros(0), M, M)
    half, _ = dpotrf(M, lower=1, clean=1)
    whitening = dtrtri(half, lower=1)[0]
    log_det = 2 * float(np.log(half.diagonal()).sum())
    return Innovation(all_, log_det, whitening @ innovation, whitening, np.eye(len(M)))


def _independent(rows: Matrix, least: Vector) -> np.ndarray:
    """The rows that are farther than `least` from what those before them span."""
    basis = np.zeros((0, rows.shape[1]))
    free = []
    for k, row in enumerate(rows):
        rest = row - (row @ basis.T) @ basis
        rest = rest - (rest @ basis.T) @ basis  # once more, for the digits
        size = np.linalg.norm(rest)
        if size > least[k]:
            free.append(k)
            basis = np.vstack([basis, rest / size])
    return np.array(free, dtype=int)


def pivots(M: Matrix, nu: Matrix) -> tuple[Vector, Vector]:
    """log det(M) and nu' M^-1 nu for each row of (N, p, p) and (N, p).

    One elimination of [M, nu] in all rows at once; a row has few outputs.
    """
    both = np.concatenate([M, nu[:, :, None]], axis=2)
    both = np.ascontiguousarray(both.transpose(1, 2, 0))  # each entry, in all rows
    log_det, square = np.zeros((2, len(M)))
    for j in range(len(both)):
        pivot = both[j, j]
        log_det += np.log(pivot)
        square += both[j, -1] ** 2 / pivot
        share = both[j + 1 :, j] / pivot
        both[j + 1 :, j + 1 :] -= share[:, None] * both[j, j + 1 :]
    return log_det, square
