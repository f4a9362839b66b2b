"""What is known of a known input, and the plant that it drives as one without input.

Where an observer is not exact the input moves the error, and how far depends on what
the input is like.  Its statistics are those of the outputs of a small plant; see
papers/leondes_novak/derivation/known_input.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import factor
from ..numeric.linalg import UNIT_TOL, lyapunov, modes
from ..observer import Observer
from ..papers.leondes_novak.derivation import driven_pair, observer_of_both
from ..papers.leondes_novak.derivation import driven_plant as model_and_plant
from ..plant import Plant

DRIVEN = 1e-9  # of the noise that reaches a mode, relative: below it is rounding
DEFECTIVE = 1e-7  # of unit eigenvectors with their duals; below it the mode grows


class KnownInput(NamedTuple):
    """Statistics of u, the outputs of s+ = A s + w, u = C s + v.

    A tone is a mode on the unit circle that no noise drives, and complex inputs c: u
    has the part Re(c mode^i), each column of c with a phase of its own.
    """

    model: Plant  # all of it, from its x0 and P0 on
    varying: Plant  # what decays, kept alive by noise
    tones: tuple[tuple[complex, Matrix], ...]  # what stays

    @property
    def level(self) -> Vector:
        """The mean of u in the long run."""
        mean = [c[:, 0].real for mode, c in self.tones if abs(mode - 1) <= UNIT_TOL]
        return sum(mean, np.zeros(self.model.p))

    @property
    def still(self) -> bool:
        """Whether u is its level, and nothing more."""
        flat = all(abs(mode - 1) <= UNIT_TOL for mode, _ in self.tones)
        rest = [c[:, 1:].any() for _, c in self.tones]
        noise = self.varying.Q.any() or self.varying.R.any()
        return flat and not any(rest) and not noise


def known_input(plant: Plant) -> KnownInput:
    """The statistics of a plant's known input, of which U says something.

    Raises
    ------
    DesignError
        If the model grows, or noise drives a mode of it that does not decay.
    """
    U = plant.U
    if isinstance(U, Plant):
        Q, R, S = U.at(0).covariances()
        return _split(replace(U, Q=Q, R=R, S=S))
    none = np.zeros((1, 1))
    given: dict[str, Any] = dict(dt=plant.dt, Q=none, P0=none)
    if U.ndim == 2:
        C = np.zeros((plant.m, 1))
        model = Plant(none, None, C, R=U, **given)
        return KnownInput(model, model, ())
    u = U[:, None]
    R = np.zeros((plant.m, plant.m))
    model = Plant([[1]], None, u, R=R, x0=[1], **given)
    still = replace(model, A=none, C=0 * u, x0=None)
    return KnownInput(model, still, ((1.0, u),) if u.any() else ())


def no_tones(given: KnownInput) -> DesignError:
    """What to say where a filter is to be the best one for tones."""
    listed = modes(np.array([mode for mode, _ in given.tones]))
    return DesignError(
        "the best filter of an order is known for an input at a level, or for one "
        f"whose model decays, and this U has the mode {listed} on the unit circle. "
        "Give in its place a tone whose phase drifts slowly, dataclasses.replace(U, "
        "A=0.999 * U.A, Q=X - 0.999**2 * U.A @ X @ U.A.T), where X is the mean of "
        "s s' over a period, s the state of U. error_covariance takes tones."
    )


def _split(model: Plant) -> KnownInput:
    """A model in tones and the rest."""
    values, left, right = scipy.linalg.eig(model.A, left=True, right=True)
    grows = np.abs(values) > 1 + UNIT_TOL
    if grows.any():
        raise DesignError(
            f"the model U of the known input has the mode {modes(values[grows])} "
            "outside the unit circle, so that the input grows without bound"
        )
    start = model.x0[:, None]
    if model.P0 is not None:
        start = np.hstack([start, factor(model.P0)])
    stays, tones = np.zeros(model.A.shape), []
    for mode, group in _tones(values):
        one = _projection(mode, left[:, group].conj().T, right[:, group], model.Q)
        stays = stays + one.real
        tones.append((mode, model.C @ one @ start))
    varying, basis = _decaying(model, stays)
    if model.P0 is None:
        X = basis @ lyapunov(varying.A, varying.Q) @ basis.T
        model = replace(model, P0=X)
    return KnownInput(model, varying, tuple(t for t in tones if t[1].any()))


def _tones(values: Vector) -> Iterator[tuple[complex, list[int]]]:
    """Modes on the unit circle, each with the indices of its eigenvalues."""
    left = [k for k, one in enumerate(values) if abs(abs(one) - 1) <= UNIT_TOL]
    while left:
        mode = values[left[0]]
        group = [k for k in left if abs(values[k] - mode) <= UNIT_TOL]
        left = [k for k in left if k not in group]
        yield complex(mode / abs(mode)), group


def _projection(mode: complex, left: Matrix, right: Matrix, Q: Matrix) -> Matrix:
    """What picks a mode of the model out of its state."""
    overlap, noise = left @ right, factor(Q)
    if np.linalg.svd(overlap, compute_uv=False)[-1] < DEFECTIVE:
        raise DesignError(
            f"the model U of the known input grows: its mode {modes([mode])} is "
            "repeated. Take modes inside the unit circle."
        )
    if (np.abs(left @ noise) > DRIVEN * (np.abs(left) @ np.abs(noise))).any():
        raise DesignError(
            f"the model U of the known input has the mode {modes([mode])} on the unit "
            "circle, and noise drives it, so that the input grows without bound. Take "
            "a mode inside the unit circle, or no noise there."
        )
    return right @ np.linalg.solve(overlap, left)


def _decaying(model: Plant, stays: Matrix) -> tuple[Plant, Matrix]:
    """The model without what stays, and the basis of its states in the model's."""
    n, keep = len(stays), np.eye(len(stays)) - stays
    count = n - int(round(np.trace(stays)))
    if count == n:
        return replace(model, x0=None, P0=None), np.eye(n)
    basis = scipy.linalg.qr(keep, pivoting=True)[0][:, :count]
    if count == 0:  # a plant has a state: one that never moves
        return replace(
            model, A=np.zeros((1, 1)), B=None, C=np.zeros((model.p, 1)),
            Q=np.zeros((1, 1)), S=np.zeros((1, model.p)),
            x0=None, P0=None, state_names=None, estimates=None,
        ), np.zeros((n, 1))  # fmt: skip
    rows = basis.T @ keep
    noise = rows @ factor(model.Q)
    return replace(
        model, A=basis.T @ model.A @ basis, B=None, C=model.C @ basis,
        Q=noise @ noise.T, S=rows @ model.S, x0=None, P0=None, state_names=None,
        estimates=None,
    ), basis  # fmt: skip


def driven(plant: Plant, model: Plant) -> Plant:
    """Model and plant as one plant without input; its outputs are y and then u."""
    of_input = dict(A_u=model.A, C_u=model.C, Q_u=model.Q, R_u=model.R)
    of_input["S_u"] = np.zeros((model.n, model.p)) if model.S is None else model.S

    def at(i: int) -> Matrices:
        now = plant.at(i)
        Q, R, S = now.covariances()
        have = dict(zip("ABCE", now)) | dict(Q=Q, R=R, S=S) | of_input
        return kernels.run(model_and_plant, have)

    found = at(0)
    if plant.steps is not None:
        rows = [at(i) for i in range(plant.steps)]
        found = {name: np.stack([row[name] for row in rows]) for name in found}
    places = dict(Pi_x=_picked(plant.n, model), Pi_y=np.eye(plant.p + plant.m, plant.p))
    pairs = [
        kernels.run(driven_pair, dict(A1=A1, C1=C1) | places)
        for A1, C1 in plant.multiplicative
    ]
    P0 = plant.P0
    if P0 is not None:
        of_model = np.zeros((model.n, model.n)) if model.P0 is None else model.P0
        P0 = scipy.linalg.block_diag(of_model, P0)
    return Plant(
        found["A_in"], None, found["C_in"], dt=plant.dt,
        Q=found["Q_in"], R=found["R_in"], S=found["S_in"],
        x0=np.concatenate([model.x0, plant.x0]), P0=P0, at_first=plant.at_first,
        multiplicative=[(one["A1_in"], one["C1_in"]) for one in pairs],
        output_names=[*plant.output_names, *(f"known {u}" for u in plant.input_names)],
    )  # fmt: skip


def seen(observer: Observer, model: Plant) -> Observer:
    """An observer of a plant as one of `driven`: it takes u as a measurement."""
    o, none = observer, np.zeros((observer.order, 0))
    picked = _picked(o.L.shape[1], model)

    def at(k: int) -> Matrices:
        _, G, D, _, V, W = o.at(k)
        T = o.T if o.steps is None else o.T[k]
        have = dict(D=D, G=G, V_any=V, W_any=W, T=T, L_any=o.L, Pi_x=picked)
        return kernels.run(observer_of_both, have)

    found, start = at(0), {}
    L = found.pop("L_in")
    if o.steps is not None:
        rows = [at(k) for k in range(o.steps)]
        found = {name: np.stack([row[name] for row in rows]) for name in found}
        none = np.zeros((o.steps, o.order, 0))
        start = dict(T0=o.T0 @ picked, G0=none[0])
    D, V, T = (found[name] for name in ("D_in", "V_in", "T_in"))
    return Observer(o.F, none, D, o.P, V, T, L, z0=o.z0, dt=o.dt, **start)


def _picked(n: int, model: Plant) -> Matrix:
    """The rows that pick the states of a plant from those of model and plant."""
    return np.eye(n, model.n + n, model.n)


def start_of_input(observer: Observer, plant: Plant) -> Matrix | None:
    """What the start of an observer takes of y and u at instant 0, if anything."""
    if observer.steps is None or plant.at_first or not observer.G0.any():
        return None
    return np.hstack([np.zeros((observer.order, plant.p)), observer.G0])
