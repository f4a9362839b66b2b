"""One step of the covariance where it is singular, or nearly: in factors.

Two things go on from step to step: a factor H of Sigma, and the covariance of what
rounding has done to H so far.  Both obey the recursion of the error itself, so a
rounding that an unstable mode has made large is still known for what it is.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg.lapack import dgelsy, dgesdd

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import CLEAR, EPS, factor, firm, lengths, rounded, shorten
from ..papers.leondes_novak.derivation import root_update

if TYPE_CHECKING:
    from .settings import Setting


class Move(NamedTuple):
    """What leads from an instant to the next: A, Q, and G with G G' = Q.

    ``size`` holds the magnitudes that the entries of A are sums of.
    """

    A: np.ndarray
    Q: np.ndarray
    G: np.ndarray
    size: np.ndarray


class Spread(NamedTuple):
    """The covariance of the error; as a factor too where it is not safely definite.

    States that are known exactly have rows of zeros, and need no factor.
    ``rounding`` is the covariance of the rounding in each column of ``half``.
    """

    Sigma: np.ndarray
    half: np.ndarray | None = None
    rounding: np.ndarray | None = None

    @classmethod
    def of(cls, Sigma: Matrix, size: Vector | None = None) -> "Spread":
        """From a covariance alone; `size` holds the variances that it was made of."""
        size = np.abs(Sigma.diagonal()) if size is None else size  # rounding has a sign
        if firm(Sigma, size):
            return cls(Sigma)
        return cls(Sigma, factor(Sigma, size), np.diag(EPS**2 * size))

    def factored(self) -> tuple[Matrix, Matrix]:
        """A factor, and the covariance of its rounding, in any case."""
        if self.half is not None and self.rounding is not None:
            return self.half, self.rounding
        some = self.Sigma.diagonal() > 0  # the others are known exactly
        half = np.zeros((len(some), np.count_nonzero(some)))
        half[some] = np.linalg.cholesky(self.Sigma[np.ix_(some, some)])
        return half, np.diag(EPS**2 * self.Sigma.diagonal())


def root_step(now: "Setting", move: Move, spread: Spread) -> tuple[Matrices, Spread]:
    """The matrices of `gain_step`, and the next `Spread`."""
    H_minus, rounding = ahead(move, *spread.factored())
    size = lengths(H_minus)
    seen = np.abs(now.C) @ size + now.deviation
    if now.blind.size:
        unit = rounded(now.C @ rounding @ now.C.T, seen).diagonal()
        unit = np.maximum(unit, (EPS * seen) ** 2)  # rounding may have made it less
        found = visible(now, H_minus, np.sqrt(unit))
    else:
        found = definite(now, H_minus, seen)
    found |= kernels.compiled(root_update)(
        C=now.C, V=now.V, Gamma=now.Gamma, Kmv=found["Kmv"], H_minus=H_minus
    )
    half = shorten(np.concatenate([found["kept"], found["drawn"]], axis=1))
    size = size + np.abs(found["K"]) @ seen
    rounding = rounded(found["Y"] @ rounding @ found["Y"].T, size)
    found["Omega"], Sigma = H_minus @ H_minus.T, half @ half.T
    found["Sigma_next"] = Sigma
    with np.errstate(over="ignore"):  # infinite is not safe
        made_of = np.maximum(rounding.diagonal(), 0) / EPS**2  # it is rounded as well
    if not now.blind.size and firm(Sigma, made_of):
        return found, Spread(Sigma)
    return found, Spread(Sigma, half, rounding)


def ahead(move: Move, half: Matrix, rounding: Matrix) -> tuple[Matrix, Matrix]:
    """H_minus = [A H, G], and the covariance of its rounding: (44)."""
    A = move.A
    H_minus = np.concatenate([A @ half, move.G], axis=1)
    size = move.size @ lengths(half) + lengths(move.G)
    return H_minus, rounded(A @ rounding @ A.T, size)


def definite(now: "Setting", H_minus: Matrix, unit: Vector) -> Matrices:
    """M and Kmv of (33) where R is positive definite; `unit` are sizes of the outputs.

    Kmv = [H_minus, 0] Q T^-T with [C H_minus, V]' = Q T: M, which holds half of the
    digits, is not solved with.  With the largest rows first and pivots, a row of Q T
    is as precise as it is small (Cox and Higham, BIT 38 (1998) 34-50).
    """
    L = now.C @ H_minus
    Z = np.concatenate([L, now.V], axis=1)
    rows, (p, k) = (Z / unit[:, None]).T, L.shape
    right = np.zeros((len(rows), len(H_minus)))
    right[:k] = H_minus.T
    order = np.argsort(-np.abs(rows).max(axis=1, initial=0))
    work = (p + 3) * (p + len(H_minus) + 1) + 64
    free = np.zeros(p, dtype=np.int32)
    found = dgelsy(rows[order], right[order], free, 0.0, work)[1] if p else right
    return dict(L=L, M=Z @ Z.T, Kmv=found[:p].T / unit)


def visible(now: "Setting", H_minus: Matrix, unit: Vector) -> Matrices:
    """M and Kmv of (33) where M may be singular.

    Kmv = Hx T D^-1 U' W^-1 with [C H_minus, V] = W U D T' and W = diag(unit), the
    rounding of each row, so that singular values are counted in roundings.
    """
    L = now.C @ H_minus
    Z = np.concatenate([L, now.V], axis=1)
    Kmv = np.zeros((len(H_minus), len(Z)))
    some = unit > 0  # an output of no size at all is known, and mixes with no other
    if some.any():
        U, D, Tt, _ = dgesdd(Z[some] / unit[some, None], full_matrices=0)
        rank = np.count_nonzero(D > CLEAR)
        rows = H_minus @ Tt[:rank, : H_minus.shape[1]].T / D[:rank]  # of Kmv W U
        Kmv[:, some] = rows @ U[:, :rank].T / unit[some]
    return dict(L=L, M=Z @ Z.T, Kmv=Kmv)
