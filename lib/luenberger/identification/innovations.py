"""What a row's innovation says of the likelihood, where its covariance may be singular.

An entry of a row that the entries before it determine has no density.  It is left out,
and what it did to the prediction is what those do.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dtrtri

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

    Where covariances were carried as factors it is [L, V].  Where outputs have no
    noise, `unit` is the rounding of its rows, and without it every entry counts.
    """
    new, now, innovation = row.new, row.state.setting, row.innovation[:, 0]
    assert now is not None
    if "L" in new:
        Z = np.concatenate([new["L"], now.V], axis=1)
    else:
        Z = np.linalg.cholesky(new["M"])
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
    M, nu = M.copy(), nu.copy()
    log_det, square = np.zeros(len(M)), np.zeros(len(M))
    for j in range(nu.shape[1]):
        pivot = M[:, j, j]
        log_det += np.log(pivot)
        square += nu[:, j] ** 2 / pivot
        share = M[:, j + 1 :, j] / pivot[:, None]
        M[:, j + 1 :, j + 1 :] -= share[:, :, None] * M[:, None, j, j + 1 :]
        nu[:, j + 1 :] -= share * nu[:, j, None]
    return log_det, square
