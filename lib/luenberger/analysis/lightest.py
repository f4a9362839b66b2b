"""The form of an observer that is the least work on a device."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arguments import expect
from ..errors import CertificateError, DesignError
from ..numeric import Matrix
from ..observer import Observer
from .step_cost import MATRICES, multiply_adds

UP_TO = 50  # states; above it only the form of the design is counted
NEGLIGIBLE = 1e-13  # of a matrix's largest entry: rounding
LOSS = {"double": 1e4, "float": 10.0}  # of digits that a form may cost, a factor


def lightest(observer: Observer, *, dtype: str = "double") -> Observer:
    """The same observer in the coordinates in which a step is the fewest multiply-adds.

    As designed, or modal with either kind of block, without states that the estimate
    never shows and without entries that are rounding, 1e-13 of the largest of their
    matrix.  A form is left out whose coordinates are so nearly dependent that rounding
    may grow more than 1e4 times, in float 10 times.

    Parameters
    ----------
    observer : Observer
        Constant and real.
    dtype : "double" or "float"
        What the device computes in.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5, 1], [0.25, 0.25]], [[], []], [[3], [1]],
    ...                        [[1, 2]], [[0.5]], T=[[1], [1]], L=[[1]], dt=1.0)
    >>> light = lb.export.lightest(observer)
    >>> lb.export.multiply_adds(observer), lb.export.multiply_adds(light)
    (9, 7)
    """
    expect(observer=observer)
    forms = [without_rounding(one) for one in _forms(observer, LOSS[dtype])]
    return min(forms, key=lambda one: multiply_adds(one, dtype=dtype))


def _forms(observer: Observer, loss: float) -> Iterator[Observer]:
    yield observer
    if not observer.order:
        return
    shown = without_rounding(observer).without_hidden()
    if shown.order < observer.order:
        yield shown
    if not 1 < shown.order <= UP_TO:
        return
    for pairs in ("rotation", "companion"):
        try:
            form = shown.modal(pairs)
        except (DesignError, CertificateError, np.linalg.LinAlgError):
            continue
        if _dependence(shown, form) <= loss:
            yield form


def _dependence(observer: Observer, form: Observer) -> float:
    """The condition of the new coordinates in the old ones, whatever their units.

    Both follow the state, T x and S T x, and are moved by inputs, D y and S D y.  Rows
    and columns of S have length one, as powers of two cost no digits.
    """
    old, new = (
        _even(np.hstack([o.T, o.G, o.D, o.F @ o.G, o.F @ o.D]), 1)
        for o in (observer, form)
    )
    S, _, rank, _ = np.linalg.lstsq(old.T, new.T, rcond=None)
    if rank < len(old):
        return np.inf
    for _ in range(5):
        S = _even(_even(S, 0), 1)
    return float(np.linalg.cond(S))


def _even(X: Matrix, axis: int) -> Matrix:
    length = np.linalg.norm(X, axis=axis, keepdims=True)
    found: Matrix = X / np.where(length > 0, length, 1.0)
    return found


def without_rounding(observer: Observer, part: float = NEGLIGIBLE) -> Observer:
    """The observer without entries that are next to nothing, or next to 1 or -1."""
    exact: Any = {k: _rounded(getattr(observer, k), part) for k in MATRICES}
    return dataclasses.replace(observer, **exact)


def _rounded(X: Matrix, part: float) -> Matrix:
    X = np.where(np.abs(X) <= part * np.abs(X).max(initial=0), 0.0, X)
    for one in (1.0, -1.0):
        X = np.where(np.abs(X - one) <= part, one, X)
    return X
