"""A plan of a comparison, carried out and measured."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.disturbance import disturbed
from ..analysis.error_covariance import error_covariance
from ..analysis.optimality import STATIONARY_TOL, optimality
from ..analysis.step_cost import multiply_adds
from ..certificate import certify
from ..kernels.kept import CacheWarning
from ..numeric import Matrix
from ..numeric.linalg import ROUNDING, UNIT_TOL, lyapunov, radius
from ..observer import Observer
from ..plant import Plant
from .attempts import Attempt, noisy
from .cheapest import DESIGNED, SHOWN, Rounded, cheapest
from .reasons import count

if TYPE_CHECKING:
    from .methods import Plan

DISTURBED = (
    "Best for u = 0: known inputs disturb its estimate, and no error is known without "
    "plant.with_input(U), which says what they are like."
)
FORM_TOL = 1e-12  # of the certificate of another form, beside the design's own


@np.errstate(all="ignore")  # a note is a design's warning, not NumPy's of an overflow
def attempt(
    plan: Plan,
    plant: Plant,
    k: Matrix | None,
    dtype: str = "double",
    orders: Collection[int] | None = None,
) -> Attempt | None:
    """Carry a plan out, and measure what comes of it.

    None if the design has none of the `orders` that were asked for.  States that its
    estimate never shows count there.
    """
    known: Any = dict(accurate=plan.accurate, horizon=plan.horizon, k=k)
    given = (plan.method, plan.label, plan.order)
    try:
        observer, warned = _quietly(plan.design)
        if orders is not None and observer.order not in orders:
            return None
        figures: Any = _figures(observer, plant, plan, dtype)
    except ValueError as error:  # DesignError, CertificateError: listed, not raised
        return Attempt(*given, **known, refusal=str(error))
    form, name = figures["observer"], figures["form"]
    found = Attempt(plan.method, plan.label, form.order, **known | figures)
    formed = []
    if hidden := observer.order - form.order:
        which = count(hidden, "state")
        formed.append(f"Left out: {which} that the estimate never shows.")
    if name not in (DESIGNED, SHOWN):
        formed.append(f"Given in other coordinates: {name}.")
    unknown = found.disturbed and plant.U is None
    notes = [plan.note, *formed, found.note, DISTURBED if unknown else "", *warned]
    return dataclasses.replace(found, note=" ".join(filter(None, notes)))


def _quietly(design: Callable[[], Observer]) -> tuple[Observer, list[str]]:
    """What a design gives, and the texts of its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", CacheWarning)  # no property of the design
        observer = design()
    return observer, [f"{one.message}" for one in caught]


def _figures(
    observer: Observer,
    plant: Plant,
    plan: Plan,
    dtype: str,
) -> dict[str, Any]:
    best, certificate = None, certify(observer, plant)
    asked: Any = dict(weight=plan.weight, feedthrough=plan.feedthrough)
    if plan.feedthrough is not None:
        best = optimality(observer, plant, **asked)

    moved = disturbed(observer, plant, certificate)
    known = noisy(plant) and not (moved and plant.U is None)

    rounded = Rounded(observer, plant, dtype)

    def sound(form: Observer) -> bool:
        if best is not None:
            worst = optimality(form, plant, **asked).worst
            same = worst <= max(STATIONARY_TOL, best.worst)
        else:
            same = certify(form, plant).worst <= max(FORM_TOL, certificate.worst)
        return same and rounded.keeps_digits(form)

    form, name, work, size = observer, DESIGNED, multiply_adds(observer), None
    operations = None
    if not observer.is_complex:
        form, name, (work, operations, size) = cheapest(observer, sound, dtype)
    return dict(
        covariance=steady_covariance(observer, plant) if known else None,
        disturbed=moved,
        noise_gain=noise_gain(observer, plant),
        work=work,
        operations=operations if plant.dt > 0 else None,
        bytes=size if plant.dt > 0 else None,
        certificate=certificate if form is observer else certify(form, plant),
        optimality=best,
        observer=form,
        form=name,
        note=rounded.note,
    )


def steady_covariance(observer: Observer, plant: Plant) -> Matrix:
    """The steady error covariance, 0 where nothing moves what is estimated.

    What decays and has no noise is known without measuring, but the gain that an
    iteration leaves for it is not quite 0.  What that lets in of R, beside what a plain
    inverse of C would, is below rounding.
    """
    Sigma, L = error_covariance(observer, plant), observer.L
    if disturbed(observer, plant, certify(observer, plant)):
        return Sigma
    if plant.multiplicative and plant.Q.any() or radius(plant.A) >= 1 - UNIT_TOL:
        return Sigma
    still = (L @ lyapunov(plant.A, plant.Q) @ L.T).diagonal() == 0
    let_in = np.linalg.pinv(plant.C) ** 2 @ plant.R.diagonal()
    floor = ROUNDING**2 * min(let_in[let_in > 0], default=0.0) * (L * L).sum(axis=1)
    moved = ~still | (Sigma.diagonal() > floor)
    return Sigma * np.outer(moved, moved)


def noise_gain(observer: Observer, plant: Plant) -> float | None:
    """Root of the steady error trace that v alone would leave; None if dt = 0.

    Without R, that of white noise of unit variance in every output.
    """
    if plant.dt == 0 or plant.is_complex or observer.is_complex:
        return None
    quiet = dataclasses.replace(
        plant,
        Q=np.zeros((plant.n, plant.n)),
        R=np.eye(plant.p) if plant.R is None else plant.R,
        S=None,
        U=np.zeros(plant.m),
        multiplicative=(),
    )
    left = error_covariance(observer, quiet)
    return float(np.sqrt(max(np.trace(left), 0.0)))
