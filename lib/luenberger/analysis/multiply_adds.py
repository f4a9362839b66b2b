"""How much work any observer is at each sample."""

import dataclasses
from typing import Any

import numpy as np

from ..arguments import expect
from ..numeric import Matrix
from ..observer import Observer

NEGLIGIBLE = 1e-10  # beside the largest entry of a matrix: rounding, not work


def multiply_adds(observer: Observer) -> int:
    """Multiply-adds of one step of a constant observer: entries that are not 0 or 1.

    A zero costs nothing and a one no multiplication but an addition, which is
    counted; the figure is the number of nonzero entries of F, G, D, P, V, W less one
    for each row of w^ that is a bare copy of one signal.  An entry below 1e-10 of the
    largest of its matrix is rounding and counts as zero.

    Examples
    --------
    >>> import luenberger as lb
    >>> lb.multiply_adds(lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                              T=[[-2, 1]], L=[[1, 0], [0, 1]]))
    5
    """
    expect(observer=observer)
    o = observer
    if o.steps is not None:
        raise ValueError("the count is of a constant observer; take one row's worth")
    F, G, D, P, V, W = (_rounded(X) for X in (o.F, o.G, o.D, o.P, o.V, o.W))
    work = sum(np.count_nonzero(X) for X in (F, G, D))
    for row in np.hstack([P, V, W]):
        entries = row[row != 0]
        copied = len(entries) == 1 and entries[0] == 1
        work += 0 if copied else len(entries)
    return int(work)


def without_rounding(observer: Observer) -> Observer:
    """The observer without what `multiply_adds` takes for rounding."""
    exact: Any = {k: _rounded(getattr(observer, k)) for k in "FGDPVW"}
    return dataclasses.replace(observer, **exact)


def _rounded(X: Matrix) -> Matrix:
    """X with entries that are rounding set to 0, and those a rounding off +-1 to it."""
    X = np.where(np.abs(X) <= NEGLIGIBLE * np.abs(X).max(initial=0), 0.0, X)
    for one in (1.0, -1.0):
        X = np.where(np.abs(X - one) <= NEGLIGIBLE, one, X)
    return X
