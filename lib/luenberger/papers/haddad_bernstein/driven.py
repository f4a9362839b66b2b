"""The best estimator of a plant whose known input has statistics.

Plant and input together are a plant without input, and the input is measured: what the
paper derives holds for both.  Its estimator then takes the input as it takes a
measurement, with gains of their own.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...analysis.error_system import error_system
from ...analysis.known_input import KnownInput, driven, no_tones
from ...certificate import residuals
from ...kernels import run
from ...numeric import Matrix
from ...numeric.linalg import SINGULAR_TOL, lyapunov
from ...observer import Observer
from ...plant import Plant
from .derivation import output_moments
from .search import Search


def driven_search(
    search: Callable[[Plant, Matrix], Search],
    plant: Plant,
    L: Matrix,
    given: KnownInput,
) -> Search:
    """The minima of a search, for an input of these statistics."""
    if given.still:
        return _each(search(plant, L), lambda one: level_met(one, plant))
    require_decaying(given)
    model, both = given.varying, driven(plant, given.varying)
    rows, back = _moving(model)
    pick = np.zeros((plant.p + len(rows), plant.p + plant.m))
    pick[: plant.p, : plant.p], pick[plant.p :, plant.p :] = np.eye(plant.p), rows
    names = both.output_names
    if len(rows) < plant.m:
        known = tuple(f"known u{k + 1}" for k in range(len(rows)))
        names = (*plant.output_names, *known)
    seen = replace(
        both, C=pick @ both.C, E=None, R=pick @ both.R @ pick.T, S=both.S @ pick.T,
        output_names=names,
        multiplicative=tuple((A1, pick @ C1) for A1, C1 in both.multiplicative),
    )  # fmt: skip
    found = search(seen, np.hstack([np.zeros((len(L), model.n)), L]))
    found = _each(found, lambda one: _of_plant(one, plant, model.n, pick, back))
    return replace(found, enough=min(found.enough, plant.n))


def require_decaying(given: KnownInput) -> None:
    """Refuse an input that has a level or a tone beside what varies."""
    if given.tones:
        raise no_tones(given)


def level_met(observer: Observer, plant: Plant) -> Observer:
    """The observer with the W that leaves no error at any constant input.

    At a level the error is that of a plant without input, and a mean beside it.
    """
    system = error_system(observer, replace(plant, multiplicative=()), None)
    return replace(observer, W=observer.W - system.of_tone(1.0, np.eye(plant.m)).real)


def _each(found: Search, change: Callable[[Observer], Observer]) -> Search:
    """A search with every observer changed."""
    changed = (replace(one, observer=change(one.observer)) for one in found.minima)
    return replace(found, minima=tuple(changed))


def _moving(model: Plant) -> tuple[Matrix, Matrix]:
    """Z and N with u = N Z u: all of Z u moves, and u rests in other directions."""
    have = dict(C=model.C, Q1=lyapunov(model.A, model.Q), V2=model.R)
    moments = run(output_moments, have, "Qyy")["Qyy"]
    size = np.sqrt(moments.diagonal())
    size = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(moments / size / size[:, None])
    keep = values > SINGULAR_TOL * len(values)
    if keep.all():
        return np.eye(model.p), np.eye(model.p)
    moving = vectors[:, keep]
    return moving.T / size, size[:, None] * moving


def _of_plant(
    observer: Observer, plant: Plant, j: int, pick: Matrix, back: Matrix
) -> Observer:
    """An observer of model and plant as one of the plant; j states are the model's.

    Where the input is at rest it enters as into any observer that follows T x.
    """
    o, p = observer, plant.p
    D, G = np.split(o.D @ pick, [p], axis=1)
    V, W = np.split(o.V @ pick, [p], axis=1)
    L, T, rows = o.L[:, j:], o.T[:, j:], pick[p:, p:]
    rest = np.eye(plant.m) - back @ rows
    _, G_0, _, W_0 = residuals(
        plant.A, plant.B, plant.C, plant.E, L, o.F, 0, D, o.P, V, 0, T, T
    )
    G, W = G + G_0 @ rest, W - W_0 @ rest
    found = Observer(o.F, G, D, o.P, V, T, L, W, z0=T @ plant.x0, dt=plant.dt)
    return found.named(plant)
