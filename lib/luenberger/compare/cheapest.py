"""The form of a design that is the least work: as designed, modal, or companion."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..analysis.step_cost import MATRICES, StepCost, step_cost
from ..errors import CertificateError, DesignError
from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from .rounding import Record, records, rounding

A_DIGIT = 10.0  # times as far as in the design may rounding move estimates in a form
TO_SPARE = 1e-9  # of an estimate's size: rounding below it is no loss to speak of
UP_TO = 50  # states; above it only the form of the design is counted
CHAINS_UP_TO = 12  # states; longer chains lose their digits
NEGLIGIBLE = (1e-10, 1e-13)  # of a matrix's largest entry: rounding, if that is sound
DESIGNED = "as designed"
SHOWN = "without hidden states"
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
    returned.  Another form is taken only if it saves work and is `sound`, which may
    ask for the digits too (`Rounded`).  So is the same form without entries that are
    rounding.  Among equal work the first in `FORMS` is taken.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5, 1], [0.25, 0.25]], [[], []], [[3], [1]],
    ...                        [[1, 2]], [[0.5]], T=[[1], [1]], L=[[1]], dt=1.0)
    >>> form, name, cost = cheapest(observer, lambda one: True)
    >>> lb.export.multiply_adds(observer), name, cost.multiply_adds
    (9, 'modal', 7)
    """
    best = (observer, DESIGNED, step_cost(observer, dtype))
    for name, form in _forms(observer):
        for one in (*(without_rounding(form, part) for part in NEGLIGIBLE), form):
            cost = step_cost(one, dtype)
            if cost.multiply_adds < best[2].multiply_adds and sound(one):
                best = (one, name, cost)
    return best


class Rounded:
    """What forms of a design lose to rounding, beside the design.

    A form keeps the digits of a design where rounding in `dtype` moves no estimate
    more than ten times as far as in the design, or by less than 1e-9 of its size.  In
    continuous time nothing is computed step by step, and every form keeps them.
    """

    def __init__(self, design: Observer, plant: Plant, dtype: str) -> None:
        self.design, self.plant, self.dtype = design, plant, dtype
        self.passed_over = False

    @functools.cached_property
    def known(self) -> list[Record]:
        return records(self.design, self.plant)

    @functools.cached_property
    def most(self) -> Vector:
        """The most that rounding may move each estimate, beside its size."""
        own = rounding(self.design, self.known, self.dtype)
        return np.maximum(A_DIGIT * own, TO_SPARE)

    def keeps_digits(self, form: Observer) -> bool:
        if self.plant.dt == 0:
            return True
        found = rounding(form, self.known, self.dtype)
        good = bool((found <= self.most).all())
        self.passed_over |= not good
        return good

    @property
    def note(self) -> str:
        """Says so where a form of less work was left out."""
        if not self.passed_over:
            return ""
        return (
            "A lighter form is passed over, as rounding would cost it more than a "
            f"digit in {self.dtype}."
        )


def _forms(observer: Observer) -> Iterator[tuple[str, Observer]]:
    """The forms that there are."""
    yield DESIGNED, observer
    bases, shown = [observer], without_rounding(observer, NEGLIGIBLE[-1])
    shown = shown.without_hidden()
    if shown.order < observer.order:
        yield SHOWN, shown
        bases.append(shown)
    for base in bases:
        yield from _of_same_order(base)


def _of_same_order(observer: Observer) -> Iterator[tuple[str, Observer]]:
    """Forms with all states of an observer."""
    for name, form in FORMS.items() if 1 < observer.order <= UP_TO else ():
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
