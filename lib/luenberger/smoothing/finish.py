"""What follows from smoothed estimates: both noises, and accurate outputs met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.linalg import solve_right
from ..recursion.alike import alike
from ..recursion.root_step import Move
from ..recursion.settings import Setting, Settings
from .carried import Back, Ways
from .derivation import noises, pushed_step, residual

Rows = Vector | slice
Group = tuple[Rows, Setting, Vector]  # rows, their setting, the outputs that arrived


def ways(settings: Settings, first: int, seen: Matrix) -> Ways:
    """How the rows from the instant `first` on lead on; `seen` tells what arrived."""
    plant = settings.plant
    As = each(settings, "A", first, len(seen))
    if plant.S is not None and plant.S.any():
        As = np.array(np.broadcast_to(As, (len(seen), plant.n, plant.n)))
        for rows, setting, _ in groups(settings, first, seen):
            As[rows] = setting.As

    def move(k: int) -> Move:
        return settings.at(first + k, _pattern(seen[k])).move

    return Ways(As, each(settings, "C", first, len(seen)), move)


def each(settings: Settings, name: str, first: int, rows: int) -> Matrix:
    """A matrix of the plant, or a stack of it if it varies, at the given instants."""
    X, begin = getattr(settings.plant, name), first - settings.origin
    return X if X.ndim == 2 else X[begin : begin + rows]


def groups(settings: Settings, first: int, seen: Matrix) -> Iterator[Group]:
    """Rows that have one setting; of a plant that varies, each row by itself."""
    if settings.steps is not None:
        for k in range(len(seen)):
            yield np.array([k]), settings.at(first + k, _pattern(seen[k])), seen[k]
        return
    if seen.all():
        yield slice(None), settings.at(0), np.ones(seen.shape[1], dtype=bool)
        return
    for rows in alike(seen):
        one = seen[rows[0]]
        yield rows, settings.at(0, _pattern(one)), one


def _pattern(seen: Vector) -> Vector | None:
    return None if seen.all() else seen


def residuals(
    settings: Settings, first: int, seen: Matrix, y: Matrix, u: Matrix, x: Matrix
) -> Matrix:
    """What estimates x (N, n) leave of the measurements (N, p); zero where missing."""
    have = {name: each(settings, name, first, len(y)) for name in ("C", "E")}
    y = y if seen.all() else np.where(seen, y, 0.0)
    if all(X.ndim == 2 for X in have.values()):  # a column for each row
        found = kernels.run(residual, have | dict(x_s=x.T, u=u.T, y=y.T))["rho_s"].T
    else:
        have |= dict(x_s=x[..., None], u=u[..., None], y=y[..., None])
        found = kernels.run(residual, have, stacks=True)["rho_s"][..., 0]
    return found if seen.all() else np.where(seen, found, 0.0)


def both_noises(
    settings: Settings, first: int, seen: Matrix, lamda_next: Matrix, rho: Matrix
) -> tuple[Matrix, Matrix]:
    """E[w | y] (N, n) and E[v | y] (N, p) of the rows."""
    plant = settings.plant
    w, v = np.empty_like(lamda_next), rho.copy()
    for rows, setting, arrived in groups(settings, first, seen):
        here = 0 if isinstance(rows, slice) else first - settings.origin + int(rows[0])
        _, R, S = plant.at(here).covariances()
        R_all, own = R[:, arrived], rho[rows][:, arrived]
        J_v = solve_right(R_all, R_all[arrived])
        have = dict(Q=setting.Qs, J=setting.J, S=S, R_all=R_all, J_v=J_v)
        have |= dict(lamda_next=lamda_next[rows].T, rho_s=own.T)  # a column for a row
        found = kernels.run(noises, have, "w_s", "v_s")
        w[rows] = found["w_s"].T
        if not arrived.all():
            v[rows] = np.where(arrived, v[rows], found["v_s"].T)
    return w, v


def pushed(
    settings: Settings, first: int, seen: Matrix, back: Back, rho: Matrix
) -> Back:
    """Smoothed rows that meet the accurate outputs."""
    found = kernels.run(
        pushed_step,
        dict(
            C=each(settings, "C", first, len(rho)),
            R=each(settings, "R", first, len(rho)),
            Gamma=_pushes(settings, first, seen)[1:],
            x_s=back.x[..., None], rho_s=rho[..., None], Sigma_s=back.Sigma,
        ),
        "x_c", "Sigma_c",
        stacks=True,
    )  # fmt: skip
    return replace(
        back, x=found["x_c"][..., 0], Sigma=found["Sigma_c"], deviations=None
    )


def pushed_neighbours(
    settings: Settings, first: int, seen: Matrix, U: Matrix
) -> Matrix:
    """E[e_k e_{k-1}'] (N, n, n) of rows that meet the accurate outputs.

    What was before the first row has no outputs.
    """
    C, Gamma = (
        each(settings, "C", first, len(U)),
        _pushes(settings, first, seen),
    )
    before = C if C.ndim == 2 else np.concatenate([C[:1], C[:-1]])
    have = dict(C=before, C_next=C, Gamma=Gamma[:-1], Gamma_next=Gamma[1:], U_next=U)
    return kernels.run(pushed_step, have, "U_c", stacks=True)["U_c"]


def _pushes(settings: Settings, first: int, seen: Matrix) -> Matrix:
    """Gamma of each row, in row k + 1 that of row k; columns of zeros where missing."""
    plant = settings.plant
    Gamma = np.zeros((len(seen) + 1, plant.n, plant.p))
    for rows, setting, arrived in groups(settings, first, seen):
        one = np.zeros((plant.n, plant.p))
        one[:, arrived] = setting.Gamma
        Gamma[1:][rows] = one
    return Gamma
