"""What is found in a block of records, and where it is written."""

from typing import NamedTuple

import numpy as np

from ..numeric import Matrix, Vector
from ..recursion.settings import Settings
from ..recursion.state import History

SOME = 256  # records whose deviations are copied at once


class Block(NamedTuple):
    """What was found in a block of records, the record first.

    Attributes
    ----------
    x : (M, N, n) ndarray
    variances : (M, N, n) ndarray
        Of the error of x, as they came.  Records that share them have them once, with
        the first; `deviations` are those of all.
    P : (M, n, n) ndarray
        At the last row, or at every row (M, N, n, n).
    K : (M, N, n, p) ndarray or None
        Where P is kept at every row.
    back : (M,) ndarray of int
        How many records back the one is that has a record's variances.
    """

    x: np.ndarray
    variances: np.ndarray
    P: np.ndarray
    K: np.ndarray | None
    back: np.ndarray

    @classmethod
    def empty(
        cls,
        settings: Settings,
        shape: tuple[int, ...],
        history: bool,
        complete: bool = False,
    ) -> "Block":
        """Room for what is found in records of the shape (M, N, p).

        If they are `complete`, nothing missing, there is room for the variances of
        one, and all records look at it.
        """
        (M, N, p), n = shape, settings.plant.n
        rows = (N,) if history else ()
        K = np.empty((M, N, n, p)) if history else None
        x = np.empty((M, N, n))
        variances = one_for_all(M, (N, n)) if complete else np.empty((M, N, n))
        P, back = np.empty((M, *rows, n, n)), np.zeros(M, dtype=int)
        return cls(x, variances, P, K, back)

    def put(self, which: Vector, found: History, last: Matrix) -> None:
        """Write what does not hang on measurements, the same for some records."""
        self.share(which, found.variances)
        self.P[which] = last if self.K is None else found.P
        if self.K is not None:
            self.K[which] = found.K

    def share(self, which: Vector, variances: Matrix) -> None:
        """Write variances (N, n) that some records have."""
        self.variances[which[0]] = variances
        self.back[which] = which - which[0]


def one_for_all(M: int, shape: tuple[int, ...]) -> Matrix:
    """(M, ...) in the memory of an array of the shape (...)."""
    one = np.empty(shape)
    return np.lib.stride_tricks.as_strided(one, (M, *shape), (0, *one.strides))


def deviations(variances: Matrix, back: Vector) -> Matrix:
    """One-sigma errors (M, N, n), in the place of the variances of a `Block`.

    Where all records have the same, they are there once, and cannot be written to.
    """
    who = np.arange(len(back))
    own, others = who[back == 0], who[back > 0]
    if len(own) and (not variances.strides[0] or _same(variances, own)):
        only = np.sqrt(np.maximum(variances[own[0]], 0))
        return np.broadcast_to(only, variances.shape)
    for s in own.tolist():
        np.sqrt(np.maximum(variances[s], 0), out=variances[s])
    for k in range(0, len(others), SOME):
        some = others[k : k + SOME]
        variances[some] = variances[some - back[some]]
    return variances


def _same(variances: Matrix, which: Vector) -> bool:
    """Whether these records have the same variances: in all parts of many records."""
    first = variances[which[0]]
    return all(np.array_equal(first, variances[s]) for s in which[1:].tolist())
