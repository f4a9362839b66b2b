"""The form of a design that is the least work: as designed, modal, or companion."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..analysis.step_cost import MATRICES, StepCost, step_cost
from ..errors import CertificateError, DesignError
from ..numeric import Matrix
from ..observer import Observer

UP_TO = 50  # states; above it only the form of the design is counted
CHAINS_UP_TO = 12  # states; longer chains lose their digits
NEGLIGIBLE = (1e-10, 1e-13)  # of a matrix's largest entry: rounding, if that is sound
DESIGNED = "as designed"
FORMS: dict[str, Callable[[Observer], Observer]] = {
    "modal": lambda one: one.modal(),
    "modal, companion blocks": lambda one: one.modal("companion"),
    "companion": lambda one: one.companion(),
}


def cheapest(
    observer: Observer, sound: Callable[[Observer], bool], dtype: str = "double"
) -> tuple[Observer, str, StepCost]:
    """An observer in the form of least work, which form that is, and what it costs.

    Work is counted in the C that `export.to_c` writes for the observer which is
    returned.  Another form is taken only if it saves work and is `sound`, and so is
    the same form without entries that are rounding; among equal work the first in
    `FORMS` is.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5, 1], [0.25, 0.25]], [[], []], [[3], [1]],
    ...                        [[1, 2]], [[0.5]], T=[[1], [1]], L=[[1]], dt=1.0)
    >>> form, name, cost = cheapest(observer, lambda one: True)
    >>> lb.multiply_adds(observer), name, cost.multiply_adds
    (9, 'modal', 7)
    """
    best = (observer, DESIGNED, step_cost(observer, dtype))
    for name, form in _forms(observer):
        for one in (*(without_rounding(form, part) for part in NEGLIGIBLE), form):
            cost = step_cost(one, dtype)
            if cost.multiply_adds < best[2].multiply_adds and sound(one):
                best = (one, name, cost)
    return best


def _forms(observer: Observer) -> Iterator[tuple[str, Observer]]:
    """The forms that there are."""
    yield DESIGNED, observer
    if not 1 < observer.order <= UP_TO:
        return
    for name, form in FORMS.items():
        if name == "companion" and observer.order > CHAINS_UP_TO:
            continue
        try:
            yield name, form(observer)
        except (DesignError, CertificateError, np.linalg.LinAlgError):
            continue


def without_rounding(observer: Observer, part: float) -> Observer:
    """The observer without entries below this part of the largest of their matrix.

    Those as close to 1 or -1 become that.
    """
    exact: Any = {k: _rounded(getattr(observer, k), part) for k in MATRICES}
    return dataclasses.replace(observer, **exact)


def _rounded(X: Matrix, part: float) -> Matrix:
    X = np.where(np.abs(X) <= part * np.abs(X).max(initial=0), 0.0, X)
    for one in (1.0, -1.0):
        X = np.where(np.abs(X - one) <= part, one, X)
    return X
