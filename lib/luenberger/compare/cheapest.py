"""The form of a design that is the least work: as designed, modal, or companion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..analysis.multiply_adds import multiply_adds, without_rounding
from ..analysis.step_cost import StepCost, step_cost
from ..errors import CertificateError, DesignError
from ..observer import Observer

UP_TO = 50  # states; above it only the form of the design is counted
CHAINS_UP_TO = 12  # states; longer chains lose their digits
DESIGNED = "as designed"
FORMS: dict[str, Callable[[Observer], Observer]] = {
    "modal": lambda one: one.modal(),
    "modal, companion blocks": lambda one: one.modal("companion"),
    "companion": lambda one: one.companion(),
}


def cheapest(
    observer: Observer, sound: Callable[[Observer], bool]
) -> tuple[Observer, str, StepCost]:
    """An observer in the form of least work, which form that is, and what it costs.

    Work is counted in the C that `export.to_c` writes.  Another form is taken only if
    it saves work and is `sound`; among equal work the first in `FORMS` is.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5, 1], [0.25, 0.25]], [[], []], [[3], [1]],
    ...                        [[1, 2]], [[0.5]], T=[[1], [1]], L=[[1]], dt=1.0)
    >>> form, name, cost = cheapest(observer, lambda one: True)
    >>> lb.multiply_adds(observer), name, cost.multiply_adds
    (9, 'modal', 7)
    """
    cost = step_cost(without_rounding(observer))
    best = (observer, DESIGNED, cost)
    for name, form in _forms(observer):
        if multiply_adds(form) < best[2].multiply_adds and sound(form):
            cost = step_cost(without_rounding(form))
            if cost.multiply_adds < best[2].multiply_adds:
                best = (form, name, cost)
    return best


def _forms(observer: Observer) -> Iterator[tuple[str, Observer]]:
    """The forms that there are."""
    if not 1 < observer.order <= UP_TO:
        return
    for name, form in FORMS.items():
        if name == "companion" and observer.order > CHAINS_UP_TO:
            continue
        try:
            yield name, form(observer)
        except (DesignError, CertificateError, np.linalg.LinAlgError):
            continue
