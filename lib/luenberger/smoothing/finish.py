"""What follows from smoothed estimates: both noises, and accurate outputs met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.linalg import solve_right
from ..plant import Plant
from ..recursion.root_step import Move
from ..recursion.settings import Setting, Settings
from .backward import Back, Ways
from .derivation import noises, pushed_step, residual

Group = tuple[Vector, Setting, Vector]  # rows, their setting, the outputs that arrived


def ways(settings: Settings, first: int, seen: Matrix) -> Ways:
    """How the rows from the instant `first` on lead on; `seen` tells what arrived."""
    plant = settings.plant
    As = each(plant, "A", first, len(seen))
    if plant.S is not None and plant.S.any():
        As = np.array(np.broadcast_to(As, (len(seen), plant.n, plant.n)))
        for rows, setting, _ in groups(settings, first, seen):
            As[rows] = setting.As

    def move(k: int) -> Move:
        return settings.at(first + k, _pattern(seen[k])).move

    return Ways(As, each(plant, "C", first, len(seen)), move)


def each(plant: Plant, name: str, first: int, rows: int) -> Matrix:
    """A matrix of the plant, or a stack of it if it varies, at the given instants."""
    X = getattr(plant, name)
    return X if X.ndim == 2 else X[first : first + rows]


def groups(settings: Settings, first: int, seen: Matrix) -> Iterator[Group]:
    """Rows that have one setting; of a plant that varies, each row by itself."""
    if settings.steps is not None:
        for k in range(len(seen)):
            yield np.array([k]), settings.at(first + k, _pattern(seen[k])), seen[k]
        return
    patterns, which = np.unique(seen, axis=0, return_inverse=True)
    for j, pattern in enumerate(patterns):
        rows = np.flatnonzero(which.ravel() == j)
        yield rows, settings.at(0, _pattern(pattern)), pattern


def _pattern(seen: Vector) -> Vector | None:
    return None if seen.all() else seen


def residuals(
    plant: Plant, first: int, seen: Matrix, y: Matrix, u: Matrix, x: Matrix
) -> Matrix:
    """What estimates x (N, n) leave of the measurements (N, p); zero where missing."""
    have = {name: each(plant, name, first, len(y)) for name in ("C", "E")}
    y = np.where(seen, y, 0.0)
    have |= dict(x_s=x[..., None], u=u[..., None], y=y[..., None])
    found = kernels.run(residual, have, stacks=True)["rho_s"][..., 0]
    return np.where(seen, found, 0.0)


def both_noises(
    settings: Settings, first: int, seen: Matrix, lamda_next: Matrix, rho: Matrix
) -> tuple[Matrix, Matrix]:
    """E[w | y] (N, n) and E[v | y] (N, p) of the rows."""
    plant = settings.plant
    w, v = np.empty_like(lamda_next), np.empty_like(rho)
    for rows, setting, arrived in groups(settings, first, seen):
        now = plant.at(first + int(rows[0]) if plant.steps is not None else 0)
        _, R, S = now.covariances()
        R_all = R[:, arrived]
        found = kernels.run(
            noises,
            dict(
                Q=setting.Qs, J=setting.J, S=S, R_all=R_all,
                J_v=solve_right(R_all, R_all[arrived]),
                lamda_next=lamda_next[rows, :, None],
                rho_s=rho[rows][:, arrived, None],
            ),
            "w_s", "v_s",
            stacks=True,
        )  # fmt: skip
        w[rows], v[rows] = found["w_s"][..., 0], found["v_s"][..., 0]
        v[np.ix_(rows, arrived)] = rho[rows][:, arrived]
    return w, v


def pushed(
    settings: Settings, first: int, seen: Matrix, back: Back, rho: Matrix
) -> Back:
    """Smoothed rows that meet the accurate outputs; the first has none before it."""
    plant, N = settings.plant, len(rho)
    Gamma = np.zeros((N + 1, plant.n, plant.p))  # row k + 1 is that of row k
    for rows, setting, arrived in groups(settings, first, seen):
        one = np.zeros((plant.n, plant.p))
        one[:, arrived] = setting.Gamma
        Gamma[rows + 1] = one
    C = each(plant, "C", first, N)
    before = C if C.ndim == 2 else np.concatenate([C[:1], C[:-1]])
    found = kernels.run(
        pushed_step,
        dict(
            C=C, R=each(plant, "R", first, N), Gamma=Gamma[1:],
            x_s=back.x[..., None], rho_s=rho[..., None], Sigma_s=back.Sigma,
        ),
        "x_c", "Sigma_c",
        stacks=True,
    )  # fmt: skip
    U = kernels.run(
        pushed_step,
        dict(C=before, C_next=C, Gamma=Gamma[:-1], Gamma_next=Gamma[1:], U_next=back.U),
        "U_c",
        stacks=True,
    )["U_c"]
    return replace(back, x=found["x_c"][..., 0], Sigma=found["Sigma_c"], U=U)
